// Temporal VTKHDF files, read by ParaView >= 5.12, VTK >= 9.3 and PyVista: one file for all times, and beside it one with the numbers of
// each time. Source: VTK File Formats, "VTKHDF File Format", version 2.0 (Kitware).
//
// The first joins the others by views (io/hdf5_file.hpp), as VTK's own writer does, and is replaced when a time is complete. So whatever
// happens to a run, a reader finds all times that were complete and nothing else, also while it goes on.
#pragma once

#include <optional>

#include "io/field_file.hpp"
#include "io/reader_watch.hpp"

namespace matpoint {

/// A growing series of files `vtkhdf/<name>_000000.h5` beside `<name>.vtkhdf`.
class VtkHdfSeries {
 public:
  /// `folder`: the results folder. `real`: how real numbers are stored; `compression`: gzip level of the fields, 0 for none. `grid`: given
  /// for the nodes of the grid, an image; absent for particles, an unstructured grid of vertices, and for bodies of finite elements.
  VtkHdfSeries(std::filesystem::path folder, std::string name, Number real, int compression = 0, std::optional<GridGeometry> grid = {},
               int dim = 3)
      : folder_(std::move(folder)), name_(std::move(name)), real_(real), compression_(compression), grid_(std::move(grid)), dim_(dim) {}

  /// Appends one time. The number of particles may change from call to call, the fields may not. While somebody is looking at the file of
  /// all times, as `watch` tells, that is left as it is until a later time, or settle(). Throws SolverError, and what was written before
  /// stays readable.
  void write(const FieldSet& set, ReaderWatch* watch = nullptr);
  /// All times are in the file of all times then. Throws SolverError.
  void settle(ReaderWatch& watch);
  /// Loading: the next write() goes on after these times.
  void declare_state(State& state);
  /// Forgets the times after `time` [s]; take_back() takes them out of the file.
  void drop_after(Real time) {
    while (!times_.empty() && times_.back().time > time) times_.pop_back();
  }
  /// The file of all times as it was when this state was saved: later times are no longer in it. Throws SolverError.
  void take_back() const;

 private:
  /// One that has been written.
  struct Time {
    Real time = 0;  ///< [s]
    Index points = 0;
    Index cells = 0;    ///< Of a topology that is in this time's file; 0: it is that of the time before.
    Index entries = 0;  ///< Of its Connectivity.
    void declare_state(State& state) {
      state.add("time", time);
      state.add("points", points);
      state.add("cells", cells);
      state.add("entries", entries);
    }
  };
  /// A field as the files have it.
  struct Column {
    std::string name;
    Number number;
    std::vector<Index> row_shape;
  };
  std::string file_of(std::size_t time) const;
  std::vector<Index> image_shape() const;
  void write_piece(const FieldSet& set, Time& time) const;
  void write_index() const;
  void add_columns(Hdf5Content& content) const;

  std::filesystem::path folder_;
  std::string name_;
  Number real_;
  int compression_;
  std::optional<GridGeometry> grid_;
  int dim_;
  std::vector<Column> columns_;  ///< Points, and the fields.
  std::vector<Time> times_;
  bool is_behind_ = false;  ///< The file of all times.
};

}  // namespace matpoint
