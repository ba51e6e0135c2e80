// One XML file per time (.vtu, .vti; raw appended values) and a .pvd that lists them, for ParaView before 5.12.
// Source: VTK File Formats, "XML File Formats" (Kitware).
#pragma once

#include <optional>

#include "io/field_file.hpp"

namespace matpoint {

/// A growing series of files `vtu/<name>_000000.vtu` (particles) or `.vti` (grid) beside `<name>.pvd`.
class VtuSeries {
 public:
  /// `folder`: the results folder. `grid`: given for nodes of the grid, absent for particles.
  VtuSeries(std::filesystem::path folder, std::string name, Number real, std::optional<GridGeometry> grid = {})
      : folder_(std::move(folder)), name_(std::move(name)), real_(real), grid_(std::move(grid)) {}

  /// Writes one time: first its file, then the list, each of them complete or not at all. Throws SolverError.
  void write(const FieldSet& set);
  void declare_state(State& state) { state.add("times", times_); }
  /// Forgets the times after `time` [s]; take_back() takes them out of the list.
  void drop_after(Real time) {
    while (!times_.empty() && times_.back() > time) times_.pop_back();
  }
  /// The list of all times as it was when this state was saved: later times are no longer in it. Throws SolverError.
  void take_back() const { write_list(times_); }

 private:
  std::string file_of(std::size_t time) const;
  void write_list(const std::vector<Real>& times) const;

  std::filesystem::path folder_;
  std::string name_;
  Number real_;
  std::optional<GridGeometry> grid_;
  std::vector<Real> times_;  ///< That have been written [s].
};

/// The whole text of a .vtu file. Views nothing.
std::string vtu_text(const FieldSet& particles, Number real);

/// The whole text of a .vti file of the grid's nodes.
std::string vti_text(const FieldSet& nodes, const GridGeometry& grid, Number real);

}  // namespace matpoint
