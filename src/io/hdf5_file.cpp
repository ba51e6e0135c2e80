#include "io/hdf5_file.hpp"

#include <hdf5.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <limits>
#include <mutex>
#include <new>
#include <system_error>
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
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
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

/// The memory in which files are made, kept from one to the next: asking the system for it again costs a third of writing it.
class ImageMemory {
 public:
  static void* grow(void* old, std::size_t size) {
    const std::lock_guard lock(s_mutex);
    const bool is_kept = old == nullptr ? !s_is_used : old == s_data;
    if (!is_kept) return std::realloc(old, size);
    if (size > s_size) {
      void* const grown = std::realloc(s_data, size);
      if (grown == nullptr) return nullptr;
      s_data = grown;
      s_size = size;
    }
    s_is_used = true;
    return s_data;
  }
  static void give_back(void* image) {
    const std::lock_guard lock(s_mutex);
    if (image == s_data)
      s_is_used = false;
    else
      std::free(image);
  }

 private:
  static inline std::mutex s_mutex;
  static inline void* s_data = nullptr;
  static inline std::size_t s_size = 0;
  static inline bool s_is_used = false;
};

void use_kept_memory(hid_t access, const std::filesystem::path& path) {
  H5FD_file_image_callbacks_t callbacks{};
  callbacks.image_malloc = [](size_t size, H5FD_file_image_op_t, void*) { return ImageMemory::grow(nullptr, size); };
  callbacks.image_memcpy = [](void* to, const void* from, size_t size, H5FD_file_image_op_t, void*) { return std::memcpy(to, from, size); };
  callbacks.image_realloc = [](void* old, size_t size, H5FD_file_image_op_t, void*) { return ImageMemory::grow(old, size); };
  callbacks.image_free = [](void* image, H5FD_file_image_op_t, void*) -> herr_t {
    ImageMemory::give_back(image);
    return 0;
  };
  check(H5Pset_file_image_callbacks(access, &callbacks), path);
}

constexpr std::size_t k_seal_size = 512;  // HDF5 looks for its signature at 0, 512, 1024, ...

/// To find what has been cut short or changed by accident: FNV-1a by words of 8 bytes. All pieces but the last are whole words.
class Checksum {
 public:
  void add(const char* data, std::size_t size) {
    while (size > 0) {
      std::uint64_t word = 0;
      const std::size_t step = std::min(size, sizeof word);
      std::memcpy(&word, data, step);
      sum_ = std::rotl((sum_ ^ word) * 0x100000001b3u, 29);
      data += step;
      size -= step;
    }
  }
  std::uint64_t value() const { return sum_; }

 private:
  std::uint64_t sum_ = 0xcbf29ce484222325u;
};

/// The block in front of `size` bytes.
std::string seal_of(const std::string& title, std::size_t size, const Checksum& sum) {
  std::string seal = fmt::format("{}\n{} bytes follow this block of {}\nchecksum {:016x}\n", title, size, k_seal_size, sum.value());
  seal.resize(k_seal_size, '\0');
  return seal;
}

std::ifstream open_to_read(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError("cannot read \"{}\": {}", path.string(), std::generic_category().message(errno));
  return file;
}

std::string read_seal(std::ifstream& file) {
  std::string seal(k_seal_size, '\0');
  file.read(seal.data(), static_cast<std::streamsize>(seal.size()));
  seal.resize(static_cast<std::size_t>(file.gcount()));
  return seal;
}

std::string title_in(const std::string& seal) {
  const std::size_t end = seal.find('\n');
  const std::string title = seal.substr(0, end == std::string::npos ? 0 : end);
  const bool is_text = std::all_of(title.begin(), title.end(), [](char c) { return c >= ' ' && c <= '~'; });
  return is_text ? title : std::string();
}

/// Throws InputError unless the file is as it was written.
void check_seal(const std::filesystem::path& path) {
  std::ifstream file = open_to_read(path);
  const std::string seal = read_seal(file);
  Checksum sum;
  std::size_t size = 0;
  for (std::vector<char> piece(1 << 20); file; size += static_cast<std::size_t>(file.gcount())) {
    file.read(piece.data(), static_cast<std::streamsize>(piece.size()));
    sum.add(piece.data(), static_cast<std::size_t>(file.gcount()));
  }
  if (seal == seal_of(title_in(seal), size, sum)) return;
  throw InputError("\"{}\" is damaged: its {} bytes are not those that were written", path.string(), size + seal.size());
}

/// Makes the data set, with the groups on the way to it. None of them keeps the time at which it was made: the same numbers make the same
/// file.
Handle make_dataset(hid_t file, const std::string& name, hid_t type, hid_t space, hid_t creation, const std::filesystem::path& path) {
  for (std::size_t end = name.find('/'); end != std::string::npos; end = name.find('/', end + 1)) {
    const std::string group = name.substr(0, end);
    if (H5Lexists(file, group.c_str(), H5P_DEFAULT) > 0) continue;
    const Handle of_group(H5Pcreate(H5P_GROUP_CREATE), H5Pclose, path);
    check(H5Pset_obj_track_times(of_group, false), path);
    const Handle made(H5Gcreate2(file, group.c_str(), H5P_DEFAULT, of_group, H5P_DEFAULT), H5Gclose, path);
  }
  check(H5Pset_obj_track_times(creation, false), path);
  return {H5Dcreate2(file, name.c_str(), type, space, H5P_DEFAULT, creation, H5P_DEFAULT), H5Dclose, path};
}

Index value_count(const Hdf5Array& array) {
  return std::visit([](const auto& values) { return static_cast<Index>(values.size()); }, array.values);
}

void write_array(hid_t file, const Hdf5Array& array, const std::filesystem::path& path) {
  Index row_size = 1;
  for (const Index n : array.row_shape) row_size *= n;
  const std::vector<hsize_t> shape = dimensions(row_size > 0 ? value_count(array) / row_size : 0, array.row_shape);
  const int rank = static_cast<int>(shape.size());
  const Handle space(H5Screate_simple(rank, shape.data(), nullptr), H5Sclose, path);
  const Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, path);
  if (array.compression > 0 && shape[0] > 0) {
    // Chunks of at most some MB: that is what a reader of a few rows must unpack.
    constexpr hsize_t k_chunk_values = 1 << 18;
    std::vector<hsize_t> chunk = shape;
    hsize_t values = 1;
    for (std::size_t d = chunk.size(); d-- > 0;) {
      chunk[d] = std::clamp<hsize_t>(k_chunk_values / values, 1, chunk[d]);
      values *= chunk[d];
    }
    check(H5Pset_chunk(creation, rank, chunk.data()), path);
    // Bytes of equal rank side by side: numbers of one size have their first bytes in common.
    check(H5Pset_shuffle(creation), path);
    check(H5Pset_deflate(creation, static_cast<unsigned>(array.compression)), path);
  }
  if (const auto* text = std::get_if<std::string_view>(&array.values)) {
    const Handle type(H5Tcopy(H5T_C_S1), H5Tclose, path);
    check(H5Tset_size(type, std::max<std::size_t>(1, text->size())), path);
    check(H5Tset_cset(type, H5T_CSET_UTF8), path);
    const Handle scalar(H5Screate(H5S_SCALAR), H5Sclose, path);
    Handle made = make_dataset(file, array.name, type, scalar, creation, path);
    const char nothing = '\0';
    check(H5Dwrite(made, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, text->empty() ? &nothing : text->data()), path);
    made.close(path);
    return;
  }
  Handle made = make_dataset(file, array.name, file_type(array.number), space, creation, path);
  const auto write = [&](hid_t type, const auto& values) {
    if (!values.empty()) check(H5Dwrite(made, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), path);
  };
  if (const auto* integers = std::get_if<std::span<const Index>>(&array.values))
    write(H5T_NATIVE_INT64, *integers);
  else if (const auto* singles = std::get_if<std::span<const float>>(&array.values))
    write(H5T_NATIVE_FLOAT, *singles);
  else
    write(H5T_NATIVE_DOUBLE, std::get<std::span<const Real>>(array.values));
  made.close(path);
}

void write_joined(hid_t file, const Hdf5Joined& joined, const std::filesystem::path& path) {
  Index rows = 0;
  for (const Hdf5Source& source : joined.sources) rows += source.rows;
  std::vector<hsize_t> shape = dimensions(rows, joined.row_shape);
  if (joined.is_row) shape.erase(shape.begin());
  const int rank = static_cast<int>(shape.size());
  const Handle space(H5Screate_simple(rank, shape.data(), nullptr), H5Sclose, path);
  const Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, path);
  // What a reader sees of a file that somebody has taken away: nothing that could be taken for a result.
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Index none = joined.number == Number::uint8 ? 0 : -1;
  if (joined.number == Number::float32 || joined.number == Number::float64)
    check(H5Pset_fill_value(creation, H5T_NATIVE_DOUBLE, &nan), path);
  else
    check(H5Pset_fill_value(creation, H5T_NATIVE_INT64, &none), path);
  hsize_t first = 0;
  for (const Hdf5Source& source : joined.sources) {
    if (source.rows == 0) continue;
    const std::vector<hsize_t> block = dimensions(source.rows, joined.row_shape);
    std::vector<hsize_t> start(block.size(), 0);
    start[0] = first;
    first += block[0];
    if (!joined.is_row) check(H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, block.data(), nullptr), path);
    const Handle there(H5Screate_simple(static_cast<int>(block.size()), block.data(), nullptr), H5Sclose, path);
    check(H5Pset_virtual(creation, space, source.file.c_str(), source.dataset.c_str(), there), path);
  }
  check(H5Sselect_all(space), path);
  Handle made = make_dataset(file, joined.name, file_type(joined.number), space, creation, path);
  made.close(path);
}

void write_attribute(hid_t file, const Hdf5Attribute& attribute, hid_t type, hid_t space, const void* value,
                     const std::filesystem::path& path) {
  const Handle group(H5Gopen2(file, attribute.group.c_str(), H5P_DEFAULT), H5Gclose, path);
  Handle made(H5Acreate2(group, attribute.name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose, path);
  check(H5Awrite(made, type, value), path);
  made.close(path);
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

/// The numbers of a data set, in the precision that they have.
template <class Value>
std::vector<Value> read_values(hid_t dataset, hid_t type, std::size_t count, const std::string& name) {
  std::vector<Value> values(count);
  if (count > 0 && H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0)
    throw InputError("its data set \"{}\" cannot be read: {}", name, hdf5_reason());
  return values;
}

class ReadHandle {
 public:
  ReadHandle(hid_t id, herr_t (*closer)(hid_t)) : id_(id), close_(closer) {
    if (id < 0) throw InputError("{}", hdf5_reason());
  }
  ~ReadHandle() { close_(id_); }
  ReadHandle(const ReadHandle&) = delete;
  ReadHandle& operator=(const ReadHandle&) = delete;
  operator hid_t() const { return id_; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

StateArray read_array(hid_t file, const std::string& name) {
  const ReadHandle dataset(H5Dopen2(file, name.c_str(), H5P_DEFAULT), H5Dclose);
  const ReadHandle space(H5Dget_space(dataset), H5Sclose);
  const ReadHandle type(H5Dget_type(dataset), H5Tclose);
  const hssize_t points = H5Sget_simple_extent_npoints(space);
  const std::size_t size = H5Tget_size(type);
  if (points < 0 || size == 0) throw InputError("its data set \"{}\" cannot be read: {}", name, hdf5_reason());
  const auto count = static_cast<std::size_t>(points);
  switch (H5Tget_class(type)) {
    case H5T_STRING: {
      if (H5Tis_variable_str(type) > 0 || count != 1) break;
      const std::vector<char> text = read_values<char>(dataset, type, size, name);
      return std::string(text.begin(), std::find(text.begin(), text.end(), '\0'));
    }
    case H5T_FLOAT:
      if (size == sizeof(float)) return read_values<float>(dataset, H5T_NATIVE_FLOAT, count, name);
      return read_values<double>(dataset, H5T_NATIVE_DOUBLE, count, name);
    case H5T_INTEGER: return read_values<Index>(dataset, H5T_NATIVE_INT64, count, name);
    default: break;
  }
  throw InputError("its data set \"{}\" is of a kind that no state has", name);
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

void write_hdf5(const std::filesystem::path& path, const Hdf5Content& content, OnDisk what) {
  make_hdf5_quiet();
  // Made in memory and written in one piece: HDF5 itself never meets a disk that is full or fails, and the file is complete or not there.
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, path);
  Index needed = 1 << 16;
  for (const Hdf5Array& array : content.arrays) needed += value_count(array) * byte_size(array.number);
  constexpr Index k_least = 1 << 16, k_most = 1 << 28;
  check(H5Pset_fapl_core(access, static_cast<std::size_t>(std::clamp(needed, k_least, k_most)), false), path);
  use_kept_memory(access, path);
  check(H5Pset_libver_bounds(access, H5F_LIBVER_V18, H5F_LIBVER_LATEST), path);
  const Handle root(H5Pcreate(H5P_FILE_CREATE), H5Pclose, path);
  check(H5Pset_obj_track_times(root, false), path);
  const std::size_t seal_size = content.title.empty() ? 0 : k_seal_size;
  check(H5Pset_userblock(root, seal_size), path);
  Handle file(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, root, access), H5Fclose, path);
  for (const Hdf5Array& array : content.arrays) write_array(file, array, path);
  for (const Hdf5Joined& joined : content.joined) write_joined(file, joined, path);
  for (const Hdf5Attribute& attribute : content.attributes) write_attribute(file, attribute, path);
  check(H5Fflush(file, H5F_SCOPE_LOCAL), path);
  void* image = nullptr;
  check(H5Fget_vfd_handle(file, H5P_DEFAULT, &image), path);
  const ssize_t size = H5Fget_file_image(file, nullptr, 0);  // without what is allocated beyond the end
  if (size < 0) fail_write(path, hdf5_reason());
  char* const bytes = *static_cast<char* const*>(image);
  const auto count = static_cast<std::size_t>(size);
  if (seal_size > 0) {
    Checksum sum;
    sum.add(bytes + seal_size, count);
    const std::string seal = seal_of(content.title, count, sum);
    std::copy(seal.begin(), seal.end(), bytes);
  }
  write_file(path, {bytes, seal_size + count}, what);
  file.close(path);
}

std::string title_of(const std::filesystem::path& path) {
  std::ifstream file = open_to_read(path);
  return title_in(read_seal(file));
}

StateTable read_sealed_hdf5(const std::filesystem::path& path) {
  make_hdf5_quiet();
  check_seal(path);
  try {
    const ReadHandle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    H5Pset_file_locking(access, false, true);
    const ReadHandle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, access), H5Fclose);
    std::vector<std::string> names;
    const auto collect = [](hid_t, const char* name, const H5O_info_t* info, void* all) -> herr_t {
      if (info->type == H5O_TYPE_DATASET) static_cast<std::vector<std::string>*>(all)->push_back(name);
      return 0;
    };
    if (H5Ovisit2(file, H5_INDEX_NAME, H5_ITER_INC, collect, &names, H5O_INFO_BASIC) < 0) throw InputError("{}", hdf5_reason());
    StateTable table;
    for (const std::string& name : names) table.emplace(name, read_array(file, name));
    return table;
  } catch (const InputError& error) {
    throw InputError("cannot read \"{}\": {}", path.string(), error.what());
  } catch (const std::bad_alloc&) {
    throw InputError("cannot read \"{}\": it does not fit into the memory", path.string());
  }
}

}  // namespace matpoint
