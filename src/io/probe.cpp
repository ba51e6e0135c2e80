#include "io/probe.hpp"

#include <algorithm>
#include <limits>

namespace matpoint {
namespace {

/// The row of the particle in the body's fields, or -1. Ids are ascending but have gaps when particles were removed.
Index row_of(const Solver& solver, const ProbeTarget& target) {
  const std::vector<Real> ids = solver.field(target.body, "id").values;
  const auto id = static_cast<Real>(target.particle);
  const auto found = std::lower_bound(ids.begin(), ids.end(), id);
  return found != ids.end() && *found == id ? found - ids.begin() : -1;
}

}  // namespace

ProbeTarget find_probe(const ProbeSpec& spec, const Solver& solver) {
  const std::string where = (spec.place.empty() ? "" : spec.place + ": ") + fmt::format("probe \"{}\": ", spec.name);
  std::vector<std::string> bodies;
  for (std::size_t b = 0; b < solver.body_count(); ++b) bodies.push_back(solver.body_name(b));
  const auto named = std::find(bodies.begin(), bodies.end(), spec.body);
  if (named == bodies.end()) {
    throw InputError("{}body = \"{}\" is unknown, allowed: {}{}", where, spec.body, list_names(bodies), did_you_mean(spec.body, bodies));
  }
  ProbeTarget target{static_cast<std::size_t>(named - bodies.begin()), spec.particle.value_or(0)};
  if (!spec.nearest) {
    if (row_of(solver, target) < 0) {
      throw InputError("{}particle = {} does not exist, body \"{}\" has particles 0 to {}", where, target.particle, spec.body,
                       solver.particle_count(target.body) - 1);
    }
    return target;
  }
  const Field position = solver.field(target.body, "position");
  const std::vector<Real> ids = solver.field(target.body, "id").values;
  Real nearest = std::numeric_limits<Real>::infinity();
  for (std::size_t p = 0; p < ids.size(); ++p) {
    Real squared = 0;
    for (std::size_t d = 0; d < static_cast<std::size_t>(position.components); ++d) {
      const Real distance = position.values[p * static_cast<std::size_t>(position.components) + d] - (*spec.nearest)[d];
      squared += distance * distance;
    }
    if (squared < nearest) {
      nearest = squared;
      target.particle = static_cast<Index>(ids[p]);
    }
  }
  return target;
}

std::vector<HistoryColumn> probe_columns(int dim) {
  std::vector<HistoryColumn> columns = {{"time", "s"}};
  for (int d = 0; d < dim; ++d) columns.push_back({std::string("position_") + "xyz"[d], "m"});
  for (int d = 0; d < dim; ++d) columns.push_back({std::string("velocity_") + "xyz"[d], "m/s"});
  for (const char* component : {"xx", "yy", "zz", "xy", "yz", "xz"}) {
    if (dim == 2 && columns.back().name == "stress_xy") break;  // plane strain has no others
    columns.push_back({std::string("stress_") + component, "Pa"});
  }
  return columns;
}

Probe::Probe(const std::filesystem::path& path, const ProbeTarget& target, int dim)
    : target_(target), file_(path, header_line(probe_columns(dim))) {}

std::vector<Real> Probe::row(const Snapshot& snapshot) const {
  const Solver& solver = snapshot.solver;
  const std::size_t width = probe_columns(solver.dim()).size();
  std::vector<Real> row = {snapshot.time};
  const Index found = row_of(solver, target_);
  for (const char* name : {"position", "velocity", "stress"}) {
    if (found < 0) break;
    const Field field = solver.field(target_.body, name);
    const auto begin = field.values.begin() + found * field.components;
    row.insert(row.end(), begin, begin + field.components);
  }
  row.resize(width, std::numeric_limits<Real>::quiet_NaN());  // cuts yz and xz in 2D, fills the row of a removed particle
  return row;
}

void Probe::write(const std::vector<Real>& row) { file_.append(csv_row(row)); }

}  // namespace matpoint
