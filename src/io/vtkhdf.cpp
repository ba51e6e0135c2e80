// Layout of the particles' file (n_t particles at time t, all times one after the other):
//
//   VTKHDF/Points, VTKHDF/PointData/<field>            (sum of n_t, components)
//   VTKHDF/{Connectivity, Offsets, Types}              one topology per part: vertices 0..n-1, or the cells of a body of elements
//   VTKHDF/{NumberOfPoints, NumberOfCells, NumberOfConnectivityIds}    one entry per part
//   VTKHDF/Steps/{Values, PartOffsets, PointOffsets, ...}              one entry per time: where its part and its points begin
//   VTKHDF/Steps/PointDataOffsets/<field>
//
// A part is added only when the number of particles changes: its 17 bytes per particle are more than a position in single precision.
// Readers believe the attribute Steps/NSteps, which is written last.
#include "io/vtkhdf.hpp"

#include <algorithm>
#include <array>
#include <numeric>

#include "core/error.hpp"

namespace matpoint {
namespace {

constexpr Index k_step_chunk = 256;  ///< Times per chunk of the small arrays with one entry per time.

const std::string k_point_data = "VTKHDF/PointData/";
const std::string k_field_offsets = "VTKHDF/Steps/PointDataOffsets/";
constexpr std::array k_part_counts = {"VTKHDF/NumberOfPoints", "VTKHDF/NumberOfCells", "VTKHDF/NumberOfConnectivityIds"};

Hdf5Dataset list(std::string name, Number number, Index chunk) { return {std::move(name), number, {}, {chunk}}; }

/// Rows per chunk: one time of a middling body; small bodies share chunks, large ones stay below a few MB.
Index particle_chunk(Index particles) { return std::clamp<Index>(particles, 512, 65536); }

const Hdf5Dataset& find(const std::vector<Hdf5Dataset>& datasets, const std::string& name) {
  const auto found = std::find_if(datasets.begin(), datasets.end(), [&](const Hdf5Dataset& dataset) { return dataset.name == name; });
  if (found == datasets.end()) throw SolverError("the fields of the results changed during the run: {} is new", name);
  return *found;
}

Hdf5Attribute step_count(Index count) { return {"VTKHDF/Steps", "NSteps", count}; }

/// Rows collected for one append; keeps the small arrays alive.
class Append {
 public:
  explicit Append(const std::vector<Hdf5Dataset>& datasets) : datasets_(datasets) {}

  void add(const std::string& name, const std::vector<Real>& values) {
    rows_.push_back({&find(datasets_, name), std::span<const Real>(values)});
  }
  void add(const std::string& name, const std::vector<Index>& values) {
    rows_.push_back({&find(datasets_, name), std::span<const Index>(values)});
  }
  void add(const std::string& name, std::vector<Index>&&) = delete;
  const std::vector<Hdf5Rows>& rows() const { return rows_; }

 private:
  const std::vector<Hdf5Dataset>& datasets_;
  std::vector<Hdf5Rows> rows_;
};

}  // namespace

void VtkHdfBody::create(const FieldSet& first) {
  const Index chunk = particle_chunk(static_cast<Index>(first.position.size() / 3));
  datasets_ = {{"VTKHDF/Points", real_, {3}, {chunk, 3}},
               list("VTKHDF/Connectivity", Number::int64, chunk),
               list("VTKHDF/Offsets", Number::int64, chunk),
               list("VTKHDF/Types", Number::uint8, chunk),
               list("VTKHDF/Steps/Values", Number::float64, k_step_chunk)};
  for (const char* name : k_part_counts) datasets_.push_back(list(name, Number::int64, k_step_chunk));
  for (const char* name : {"NumberOfParts", "PartOffsets", "PointOffsets"}) {
    datasets_.push_back(list(std::string("VTKHDF/Steps/") + name, Number::int64, k_step_chunk));
  }
  for (const char* name : {"CellOffsets", "ConnectivityIdOffsets"}) {
    datasets_.push_back({std::string("VTKHDF/Steps/") + name, Number::int64, {1}, {k_step_chunk, 1}});
  }
  for (const Field& field : first.fields) {
    datasets_.push_back({k_point_data + field.name, stored_number(field.name, real_), {}, {chunk}});
    if (field.components > 1) {
      datasets_.back().row_shape = {field.components};
      datasets_.back().chunk_shape.push_back(field.components);
    }
    datasets_.back().compression = compression_;
    datasets_.push_back(list(k_field_offsets + field.name, Number::int64, k_step_chunk));
  }
  datasets_.front().compression = compression_;
  create_hdf5(path_, datasets_,
              {{"VTKHDF", "Version", std::vector<Index>{2, 0}}, {"VTKHDF", "Type", std::string("UnstructuredGrid")}, step_count(0)});
}

void VtkHdfBody::write(const FieldSet& particles) {
  if (datasets_.empty()) create(particles);
  const auto n = static_cast<Index>(particles.position.size() / 3);
  const bool has_new_part = n != part_size_;
  const Index part = has_new_part ? part_count_ : part_count_ - 1;

  Append append(datasets_);
  const BodyCells cells = has_new_part ? cells_or_vertices(particles.cells, n) : BodyCells{};
  const auto entries = static_cast<Index>(cells.nodes.size());
  const Index cell_count = entries / cells.nodes_per_cell;
  std::vector<Index> offsets;
  for (Index cell = 0; cell <= cell_count; ++cell) offsets.push_back(cell * cells.nodes_per_cell);
  const std::vector<Index> types(static_cast<std::size_t>(cell_count), cells.vtk_type);
  const std::array<std::vector<Index>, 3> sizes = {std::vector<Index>{n}, {cell_count}, {entries}};
  if (has_new_part) {
    for (std::size_t i = 0; i < k_part_counts.size(); ++i) append.add(k_part_counts[i], sizes[i]);
    append.add("VTKHDF/Connectivity", cells.nodes);
    append.add("VTKHDF/Offsets", offsets);
    append.add("VTKHDF/Types", types);
  }
  const std::vector<Real> time{particles.time};
  const std::vector<Index> one{1};
  const std::vector<Index> part_offset{part};
  const std::vector<Index> cell_offset{has_new_part ? cells_ : cell_begin_};
  const std::vector<Index> connectivity_offset{has_new_part ? connectivity_ : connectivity_begin_};
  const std::vector<Index> point_offset{point_count_};
  append.add("VTKHDF/Steps/Values", time);
  append.add("VTKHDF/Steps/NumberOfParts", one);
  append.add("VTKHDF/Steps/PartOffsets", part_offset);
  append.add("VTKHDF/Steps/PointOffsets", point_offset);
  append.add("VTKHDF/Steps/CellOffsets", cell_offset);
  append.add("VTKHDF/Steps/ConnectivityIdOffsets", connectivity_offset);
  append.add("VTKHDF/Points", particles.position);
  for (const Field& field : particles.fields) {
    append.add(k_point_data + field.name, field.values);
    append.add(k_field_offsets + field.name, point_offset);
  }
  append_hdf5(path_, append.rows(), step_count(step_count_ + 1));

  ++step_count_;
  point_count_ += n;
  part_count_ = part + 1;
  part_size_ = n;
  if (!has_new_part) return;
  cell_begin_ = cells_;
  connectivity_begin_ = connectivity_;
  cells_ += cell_count;
  connectivity_ += entries;
}

void VtkHdfImage::create(const FieldSet& first) {
  // z slowest; readers want no dimension of extent 1 here: a 2D image has rank 2.
  std::vector<Index> shape;
  for (int d = dim_ - 1; d >= 0; --d) shape.push_back(grid_.nodes[static_cast<std::size_t>(d)]);
  datasets_ = {list("VTKHDF/Steps/Values", Number::float64, k_step_chunk)};
  for (const Field& field : first.fields) {
    Hdf5Dataset dataset{k_point_data + field.name, real_, shape, {1}};
    dataset.chunk_shape.insert(dataset.chunk_shape.end(), shape.begin(), shape.end());
    dataset.chunk_shape[1] = std::min<Index>(shape[0], 64);  // slabs: a chunk must stay below 4 GB
    if (field.components > 1) {
      dataset.row_shape.push_back(field.components);
      dataset.chunk_shape.push_back(field.components);
    }
    dataset.compression = compression_;
    datasets_.push_back(dataset);
    datasets_.push_back(list(k_field_offsets + field.name, Number::int64, k_step_chunk));
  }
  std::vector<Index> extent;
  for (const int nodes : grid_.nodes) extent.insert(extent.end(), {0, nodes - 1});
  const auto triple = [](const Vec3& x) { return std::vector<Real>(x.begin(), x.end()); };
  Vec3 spacing = grid_.cell_size;
  if (dim_ == 2) spacing[2] = 1;  // VTK refuses a spacing of 0
  create_hdf5(path_, datasets_,
              {{"VTKHDF", "Version", std::vector<Index>{2, 0}},
               {"VTKHDF", "Type", std::string("ImageData")},
               {"VTKHDF", "WholeExtent", extent},
               {"VTKHDF", "Origin", triple(grid_.lower)},
               {"VTKHDF", "Spacing", triple(spacing)},
               {"VTKHDF", "Direction", std::vector<Real>{1, 0, 0, 0, 1, 0, 0, 0, 1}},
               step_count(0)});
}

void VtkHdfImage::write(const FieldSet& nodes) {
  if (datasets_.empty()) create(nodes);
  Append append(datasets_);
  const std::vector<Real> time{nodes.time};
  const std::vector<Index> offset{step_count_};
  append.add("VTKHDF/Steps/Values", time);
  for (const Field& field : nodes.fields) {
    append.add(k_point_data + field.name, field.values);
    append.add(k_field_offsets + field.name, offset);
  }
  append_hdf5(path_, append.rows(), step_count(step_count_ + 1));
  ++step_count_;
}

}  // namespace matpoint
