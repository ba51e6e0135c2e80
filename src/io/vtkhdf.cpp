// Layout (n_t particles at time t):
//
//   vtkhdf/<name>_<t>.h5   Points, PointData/<field>     (n_t, components)
//                          Connectivity, Offsets, Types  where the topology is another one than that of the time before: vertices
//                                                        0..n-1, or the cells of a body of elements
//   <name>.vtkhdf          VTKHDF/{Points, PointData/<field>, Connectivity, Offsets, Types}     all of these, one after the other
//                          VTKHDF/{NumberOfPoints, NumberOfCells, NumberOfConnectivityIds}      one entry per topology
//                          VTKHDF/Steps/{Values, PartOffsets, PointOffsets, ...}                one entry per time: where what begins
//                          VTKHDF/Steps/PointDataOffsets/<field>
//
// A topology is written only when the number of particles changes: its 17 bytes per particle are more than a position in single precision.
#include "io/vtkhdf.hpp"

#include <algorithm>
#include <array>
#include <deque>

#include "core/error.hpp"

namespace matpoint {
namespace {

const std::string k_point_data = "PointData/";

/// Small arrays of a file, kept until it is written.
class Lists {
 public:
  explicit Lists(Hdf5Content& content) : content_(content) {}
  void add(const std::string& name, std::vector<Index> values, Number number = Number::int64, std::vector<Index> row_shape = {}) {
    integers_.push_back(std::move(values));
    content_.arrays.push_back({name, number, std::move(row_shape), std::span<const Index>(integers_.back())});
  }
  void add(const std::string& name, std::vector<Real> values) {
    reals_.push_back(std::move(values));
    content_.arrays.push_back({name, Number::float64, {}, std::span<const Real>(reals_.back())});
  }

 private:
  Hdf5Content& content_;
  std::deque<std::vector<Index>> integers_;  // whose elements stay where they are
  std::deque<std::vector<Real>> reals_;
};

}  // namespace

std::string VtkHdfSeries::file_of(std::size_t time) const { return fmt::format("vtkhdf/{}_{:06}.h5", name_, time); }

/// z slowest; readers want no dimension of extent 1 here: a 2D image has rank 2.
std::vector<Index> VtkHdfSeries::image_shape() const {
  std::vector<Index> shape;
  for (int d = dim_ - 1; d >= 0; --d) shape.push_back(grid_->nodes[static_cast<std::size_t>(d)]);
  return shape;
}

void VtkHdfSeries::write(const FieldSet& set, ReaderWatch* watch) {
  std::vector<Column> columns;
  if (!grid_) columns.push_back({"Points", real_, {3}});
  for (const Field& field : set.fields) {
    columns.push_back({k_point_data + field.name, stored_number(field.name, real_), grid_ ? image_shape() : std::vector<Index>{}});
    if (field.components > 1) columns.back().row_shape.push_back(field.components);
  }
  const auto is_same = [](const Column& a, const Column& b) { return a.name == b.name && a.row_shape == b.row_shape; };
  if (!columns_.empty() && !std::equal(columns.begin(), columns.end(), columns_.begin(), columns_.end(), is_same))
    throw SolverError("the fields of the results changed during the run");
  columns_ = std::move(columns);

  Time time;
  time.time = set.time;
  time.points = grid_ ? 1 : static_cast<Index>(set.position.size() / 3);
  write_piece(set, time);
  times_.push_back(time);
  constexpr std::chrono::milliseconds k_patience{20};
  is_behind_ = watch != nullptr && times_.size() > 1 && !watch->is_quiet(name_ + ".vtkhdf", k_patience);
  if (is_behind_) return;
  try {
    write_index();
  } catch (...) {
    times_.pop_back();  // the next attempt writes this time again
    throw;
  }
}

void VtkHdfSeries::write_piece(const FieldSet& set, Time& time) const {
  Hdf5Content piece;
  Lists lists(piece);
  BodyCells cells;
  if (!grid_ && (times_.empty() || times_.back().points != time.points)) {
    cells = cells_or_vertices(set.cells, time.points);
    time.entries = static_cast<Index>(cells.nodes.size());
    time.cells = time.entries / cells.nodes_per_cell;
    std::vector<Index> offsets;
    for (Index cell = 0; cell <= time.cells; ++cell) offsets.push_back(cell * cells.nodes_per_cell);
    lists.add("Connectivity", std::move(cells.nodes));
    lists.add("Offsets", std::move(offsets));
    lists.add("Types", std::vector<Index>(static_cast<std::size_t>(time.cells), cells.vtk_type), Number::uint8);
  }
  auto column = columns_.begin();
  const auto add = [&](const std::vector<Real>& values) {
    piece.arrays.push_back({column->name, column->number, column->row_shape, std::span<const Real>(values), compression_});
    ++column;
  };
  if (!grid_) add(set.position);
  for (const Field& field : set.fields) add(field.values);
  piece.attributes = {{"/", "Time", std::vector<Real>{set.time}}};
  write_hdf5(folder_ / file_of(times_.size()), piece);
}

/// What all times have, one after the other.
void VtkHdfSeries::add_columns(Hdf5Content& content) const {
  for (const Column& column : columns_) {
    Hdf5Joined joined{"VTKHDF/" + column.name, column.number, column.row_shape, {}};
    for (std::size_t t = 0; t < times_.size(); ++t) joined.sources.push_back({file_of(t), column.name, times_[t].points});
    joined.is_row = grid_ && times_.size() == 1;  // VTK takes an image of one time for one without times
    content.joined.push_back(std::move(joined));
  }
}

void VtkHdfSeries::write_index() const {
  Hdf5Content index;
  Lists lists(index);
  const auto count = static_cast<Index>(times_.size());
  add_columns(index);
  std::vector<Real> values;
  std::vector<Index> points;  // before each time
  Index sum = 0;
  for (const Time& time : times_) {
    values.push_back(time.time);
    points.push_back(sum);
    sum += time.points;
  }
  lists.add("VTKHDF/Steps/Values", std::move(values));
  for (const Column& column : columns_) {
    if (column.name.starts_with(k_point_data))
      lists.add("VTKHDF/Steps/PointDataOffsets/" + column.name.substr(k_point_data.size()), points);
  }
  index.attributes = {{"VTKHDF", "Version", std::vector<Index>{2, 0}},
                      {"VTKHDF", "Type", std::string(grid_ ? "ImageData" : "UnstructuredGrid")},
                      {"VTKHDF/Steps", "NSteps", count}};
  if (grid_) {
    std::vector<Index> extent;
    for (const int nodes : grid_->nodes) extent.insert(extent.end(), {0, nodes - 1});
    const auto triple = [](const Vec3& x) { return std::vector<Real>(x.begin(), x.end()); };
    Vec3 spacing = grid_->cell_size;
    if (dim_ == 2) spacing[2] = 1;  // VTK refuses a spacing of 0
    index.attributes.push_back({"VTKHDF", "WholeExtent", extent});
    index.attributes.push_back({"VTKHDF", "Origin", triple(grid_->lower)});
    index.attributes.push_back({"VTKHDF", "Spacing", triple(spacing)});
    index.attributes.push_back({"VTKHDF", "Direction", std::vector<Real>{1, 0, 0, 0, 1, 0, 0, 0, 1}});
    write_hdf5(folder_ / (name_ + ".vtkhdf"), index, OnDisk::content);
    return;
  }
  Hdf5Joined connectivity{"VTKHDF/Connectivity", Number::int64, {}, {}}, offsets{"VTKHDF/Offsets", Number::int64, {}, {}},
      types{"VTKHDF/Types", Number::uint8, {}, {}};
  std::vector<Index> part_points, part_cells, part_entries;      // by topology
  std::vector<Index> part_offsets, cell_offsets, entry_offsets;  // by time
  Index cells = 0, entries = 0, cells_before = 0, entries_before = 0;
  for (std::size_t t = 0; t < times_.size(); ++t) {
    const Time& time = times_[t];
    const bool has_topology = t == 0 || time.points != times_[t - 1].points;
    if (has_topology) {
      connectivity.sources.push_back({file_of(t), "Connectivity", time.entries});
      offsets.sources.push_back({file_of(t), "Offsets", time.cells + 1});
      types.sources.push_back({file_of(t), "Types", time.cells});
      part_points.push_back(time.points);
      part_cells.push_back(time.cells);
      part_entries.push_back(time.entries);
      cells_before = cells;
      entries_before = entries;
      cells += time.cells;
      entries += time.entries;
    }
    part_offsets.push_back(static_cast<Index>(part_points.size()) - 1);
    cell_offsets.push_back(cells_before);
    entry_offsets.push_back(entries_before);
  }
  index.joined.insert(index.joined.end(), {connectivity, offsets, types});
  lists.add("VTKHDF/NumberOfPoints", std::move(part_points));
  lists.add("VTKHDF/NumberOfCells", std::move(part_cells));
  lists.add("VTKHDF/NumberOfConnectivityIds", std::move(part_entries));
  lists.add("VTKHDF/Steps/NumberOfParts", std::vector<Index>(times_.size(), 1));
  lists.add("VTKHDF/Steps/PartOffsets", std::move(part_offsets));
  lists.add("VTKHDF/Steps/PointOffsets", points);
  lists.add("VTKHDF/Steps/CellOffsets", std::move(cell_offsets), Number::int64, {1});
  lists.add("VTKHDF/Steps/ConnectivityIdOffsets", std::move(entry_offsets), Number::int64, {1});
  write_hdf5(folder_ / (name_ + ".vtkhdf"), index, OnDisk::content);
}

void VtkHdfSeries::declare_state(State& state) {
  state.rows("times", times_);
  Index count = static_cast<Index>(columns_.size());
  state.add("column_count", count);
  if (state.is_loading()) columns_.assign(static_cast<std::size_t>(std::clamp<Index>(count, 0, 1000)), {});
  for (std::size_t k = 0; k < columns_.size(); ++k) {
    state.in("column_" + std::to_string(k), [&] {
      state.add("name", columns_[k].name);
      state.add("number", columns_[k].number);
      state.add("row_shape", columns_[k].row_shape);
    });
  }
}

void VtkHdfSeries::settle(ReaderWatch& watch) {
  if (!is_behind_) return;
  // Whoever looks without a pause has had his time.
  watch.is_quiet(name_ + ".vtkhdf", std::chrono::milliseconds(3000));
  write_index();
  is_behind_ = false;
}

void VtkHdfSeries::take_back() const {
  if (!times_.empty()) write_index();
}

}  // namespace matpoint
