#include "io/hdf5_file.hpp"

#include <hdf5.h>

#include <algorithm>
#include <utility>

#include "core/error.hpp"
#include "io/output_file.hpp"

namespace matpoint {
namespace {

/// The innermost message of HDF5's error stack: the reason, not the way to it.
std::string hdf5_reason() {
  std::string reason;
  H5Ewalk2(
      H5E_DEFAULT, H5E_WALK_UPWARD,
      [](unsigned, const H5E_error2_t* error, void* text) -> herr_t {
        auto& innermost = *static_cast<std::string*>(text);
        if (innermost.empty() && error->desc != nullptr) innermost = error->desc;
        return 0;
      },
      &reason);
  return reason.empty() ? "HDF5 failed" : reason;
}

class Handle {
 public:
  using Close = herr_t (*)(hid_t);
  Handle(hid_t id, Close closer, const std::filesystem::path& path) : id_(id), close_(closer) {
    if (id < 0) fail_write(path, hdf5_reason());
  }
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  operator hid_t() const { return id_; }
  /// Closing a file is a write: its failure must not be lost in the destructor.
  void close(const std::filesystem::path& path) {
    if (close_(std::exchange(id_, -1)) < 0) fail_write(path, hdf5_reason());
  }

 private:
  hid_t id_;
  Close close_;
};

void check(herr_t status, const std::filesystem::path& path) {
  if (status < 0) fail_write(path, hdf5_reason());
}

void make_hdf5_quiet() {
  // After a failed write HDF5 tries again at exit, and complains on stderr. Our files are closed by then.
  static const herr_t once = H5dont_atexit();
  (void)once;
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

hid_t file_type(Number number) {
  switch (number) {
    case Number::float32: return H5T_IEEE_F32LE;
    case Number::float64: return H5T_IEEE_F64LE;
    case Number::int64: return H5T_STD_I64LE;
    case Number::uint8: break;
  }
  return H5T_STD_U8LE;
}

std::vector<hsize_t> dimensions(Index rows, const std::vector<Index>& row_shape) {
  std::vector<hsize_t> all{static_cast<hsize_t>(rows)};
  for (const Index n : row_shape) all.push_back(static_cast<hsize_t>(n));
  return all;
}

void make_dataset(hid_t file, const Hdf5Dataset& dataset, const std::filesystem::path& path) {
  const std::vector<hsize_t> start = dimensions(0, dataset.row_shape);
  std::vector<hsize_t> greatest = start;
  greatest[0] = H5S_UNLIMITED;
  const std::vector<hsize_t> chunk(dataset.chunk_shape.begin(), dataset.chunk_shape.end());
  const int rank = static_cast<int>(start.size());
  const Handle space(H5Screate_simple(rank, start.data(), greatest.data()), H5Sclose, path);
  const Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, path);
  const Handle link(H5Pcreate(H5P_LINK_CREATE), H5Pclose, path);
  check(H5Pset_chunk(creation, rank, chunk.data()), path);
  if (dataset.compression > 0) {
    // Bytes of equal rank side by side: numbers of one size have their first bytes in common.
    check(H5Pset_shuffle(creation), path);
    check(H5Pset_deflate(creation, static_cast<unsigned>(dataset.compression)), path);
  }
  check(H5Pset_create_intermediate_group(link, 1), path);
  const Handle made(H5Dcreate2(file, dataset.name.c_str(), file_type(dataset.number), space, link, creation, H5P_DEFAULT), H5Dclose, path);
}

void write_attribute(hid_t file, const Hdf5Attribute& attribute, hid_t type, hid_t space, const void* value,
                     const std::filesystem::path& path) {
  const Handle group(H5Gopen2(file, attribute.group.c_str(), H5P_DEFAULT), H5Gclose, path);
  if (H5Aexists(group, attribute.name.c_str()) > 0) {
    const Handle existing(H5Aopen(group, attribute.name.c_str(), H5P_DEFAULT), H5Aclose, path);
    check(H5Awrite(existing, type, value), path);
  } else {
    const Handle made(H5Acreate2(group, attribute.name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose, path);
    check(H5Awrite(made, type, value), path);
  }
}

void write_attribute(hid_t file, const Hdf5Attribute& attribute, const std::filesystem::path& path) {
  const Handle scalar(H5Screate(H5S_SCALAR), H5Sclose, path);
  const auto list = [&](const auto& values, hid_t type) {
    const hsize_t size = values.size();
    const Handle space(H5Screate_simple(1, &size, nullptr), H5Sclose, path);
    write_attribute(file, attribute, type, space, values.data(), path);
  };
  if (const auto* number = std::get_if<Index>(&attribute.value)) {
    write_attribute(file, attribute, H5T_NATIVE_INT64, scalar, number, path);
  } else if (const auto* integers = std::get_if<std::vector<Index>>(&attribute.value)) {
    list(*integers, H5T_NATIVE_INT64);
  } else if (const auto* reals = std::get_if<std::vector<Real>>(&attribute.value)) {
    list(*reals, H5T_NATIVE_DOUBLE);
  } else {
    // VTK wants fixed-length ASCII.
    const std::string& text = std::get<std::string>(attribute.value);
    const Handle type(H5Tcopy(H5T_C_S1), H5Tclose, path);
    check(H5Tset_size(type, text.size()), path);
    check(H5Tset_strpad(type, H5T_STR_NULLPAD), path);
    write_attribute(file, attribute, type, scalar, text.data(), path);
  }
}

Index row_size(const Hdf5Dataset& dataset) {
  Index size = 1;
  for (const Index n : dataset.row_shape) size *= n;
  return size;
}

Index value_count(const Hdf5Rows& rows) {
  return std::visit([](const auto& values) { return static_cast<Index>(values.size()); }, rows.values);
}

/// More than HDF5 can need for the rows: the values, one more chunk, and for each new chunk its entry in the index of chunks.
Index space_needed(const Hdf5Rows& rows) {
  constexpr Index k_index_nodes = 32768;  // splitting the index to its root: three nodes of at most 5 KiB, and the headers
  constexpr Index k_index_entry = 256;
  Index chunk = byte_size(rows.dataset->number);
  for (const Index n : rows.dataset->chunk_shape) chunk *= n;
  // A row can be cut into several chunks, each of which may stand out beyond the row.
  Index chunks_per_row = 1;
  for (std::size_t d = 0; d < rows.dataset->row_shape.size(); ++d) {
    const Index edge = rows.dataset->chunk_shape[d + 1];
    chunks_per_row *= (rows.dataset->row_shape[d] + edge - 1) / edge;
  }
  const Index row_count = value_count(rows) / std::max<Index>(1, row_size(*rows.dataset));
  const Index chunks = (row_count / rows.dataset->chunk_shape[0] + 2) * chunks_per_row;
  return chunks * (chunk + k_index_entry) + k_index_nodes;
}

void append_rows(hid_t file, const Hdf5Rows& rows, const std::filesystem::path& path) {
  const Index count = value_count(rows) / row_size(*rows.dataset);
  if (count == 0) return;
  const Handle dataset(H5Dopen2(file, rows.dataset->name.c_str(), H5P_DEFAULT), H5Dclose, path);
  std::vector<hsize_t> extent = dimensions(count, rows.dataset->row_shape);
  const std::vector<hsize_t> block = extent;
  std::vector<hsize_t> start(extent.size(), 0);
  {
    const Handle old(H5Dget_space(dataset), H5Sclose, path);
    std::vector<hsize_t> present(extent.size());
    check(H5Sget_simple_extent_dims(old, present.data(), nullptr), path);
    start[0] = present[0];
    extent[0] += present[0];
  }
  check(H5Dset_extent(dataset, extent.data()), path);
  const Handle space(H5Dget_space(dataset), H5Sclose, path);
  check(H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, block.data(), nullptr), path);
  const Handle memory(H5Screate_simple(static_cast<int>(block.size()), block.data(), nullptr), H5Sclose, path);
  const auto write = [&](hid_t type, const void* values) { check(H5Dwrite(dataset, type, memory, space, H5P_DEFAULT, values), path); };
  if (const auto* integers = std::get_if<std::span<const Index>>(&rows.values))
    write(H5T_NATIVE_INT64, integers->data());
  else
    write(H5T_NATIVE_DOUBLE, std::get<std::span<const Real>>(rows.values).data());
}

}  // namespace

Index byte_size(Number number) {
  switch (number) {
    case Number::float32: return 4;
    case Number::float64: return 8;
    case Number::int64: return 8;
    case Number::uint8: break;
  }
  return 1;
}

void create_hdf5(const std::filesystem::path& path, const std::vector<Hdf5Dataset>& datasets,
                 const std::vector<Hdf5Attribute>& attributes) {
  make_hdf5_quiet();
  // Made in memory and written in one piece: the file is complete or not there.
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, path);
  check(H5Pset_fapl_core(access, 1 << 16, false), path);
  const Handle file(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access), H5Fclose, path);
  for (const Hdf5Dataset& dataset : datasets) make_dataset(file, dataset, path);
  for (const Hdf5Attribute& attribute : attributes) write_attribute(file, attribute, path);
  check(H5Fflush(file, H5F_SCOPE_LOCAL), path);
  const ssize_t size = H5Fget_file_image(file, nullptr, 0);
  if (size < 0) fail_write(path, hdf5_reason());
  std::string image(static_cast<std::size_t>(size), '\0');
  if (H5Fget_file_image(file, image.data(), image.size()) < 0) fail_write(path, hdf5_reason());
  write_file(path, image);
}

void append_hdf5(const std::filesystem::path& path, const std::vector<Hdf5Rows>& rows, const Hdf5Attribute& announcement) {
  make_hdf5_quiet();
  Index needed = 0;
  for (const Hdf5Rows& some : rows) needed += space_needed(some);
  reserve_space(path, needed);
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, path);
  // Someone who has the file open in ParaView must not end the run.
  check(H5Pset_file_locking(access, false, true), path);
  Handle file(H5Fopen(path.c_str(), H5F_ACC_RDWR, access), H5Fclose, path);
  for (const Hdf5Rows& some : rows) append_rows(file, some, path);
  check(H5Fflush(file, H5F_SCOPE_LOCAL), path);
  write_attribute(file, announcement, path);
  file.close(path);
}

}  // namespace matpoint
