#include "io/history.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

namespace matpoint {
namespace {

constexpr Real k_nan = std::numeric_limits<Real>::quiet_NaN();

/// A column of numbers that come from a T.
template <class T>
struct Column {
  std::string name;
  std::string unit;
  std::function<Real(const T&)> value;
};

template <class T>
class Columns {
 public:
  explicit Columns(int dim) : dim_(dim) {}

  template <class F>
  void scalar(const std::string& name, const std::string& unit, F value) {
    all_.push_back({name, unit, [value](const T& object) { return static_cast<Real>(value(object)); }});
  }
  template <class F>
  void vector(const std::string& name, const std::string& unit, F value) {
    for (int d = 0; d < dim_; ++d) {
      all_.push_back({name + "_" + "xyz"[d], unit, [value, d](const T& object) { return value(object)[static_cast<std::size_t>(d)]; }});
    }
  }
  std::vector<Column<T>> take() { return std::move(all_); }

 private:
  int dim_;
  std::vector<Column<T>> all_;
};

std::vector<Column<BodyTotals>> body_columns(int dim) {
  Columns<BodyTotals> columns(dim);
  columns.scalar("particle_count", "1", [](const BodyTotals& t) { return t.particle_count; });
  columns.scalar("mass", "kg", [](const BodyTotals& t) { return t.mass; });
  columns.vector("momentum", "N s", [](const BodyTotals& t) { return t.momentum; });
  columns.vector("center_of_mass", "m", [](const BodyTotals& t) { return t.center_of_mass; });
  columns.scalar("kinetic_energy", "J", [](const BodyTotals& t) { return t.kinetic_energy; });
  columns.scalar("strain_energy", "J", [](const BodyTotals& t) { return t.strain_energy; });
  columns.scalar("gravitational_energy", "J", [](const BodyTotals& t) { return t.gravitational_energy; });
  columns.scalar("von_mises_max", "Pa", [](const BodyTotals& t) { return t.von_mises_max; });
  columns.vector("lower", "m", [](const BodyTotals& t) { return t.lower; });
  columns.vector("upper", "m", [](const BodyTotals& t) { return t.upper; });
  columns.scalar("J_min", "1", [](const BodyTotals& t) { return t.J_min; });
  columns.scalar("J_max", "1", [](const BodyTotals& t) { return t.J_max; });
  return columns.take();
}

std::vector<Column<SystemTotals>> balance_columns(int dim) {
  Columns<SystemTotals> columns(dim);
  columns.scalar("damping_dissipation", "J", [](const SystemTotals& t) { return t.ledger.damping_dissipation; });
  columns.scalar("viscous_dissipation", "J", [](const SystemTotals& t) { return t.ledger.viscous_dissipation; });
  columns.scalar("plastic_dissipation", "J", [](const SystemTotals& t) { return t.ledger.plastic_dissipation; });
  columns.scalar("contact_dissipation", "J", [](const SystemTotals& t) { return t.ledger.contact_dissipation; });
  columns.scalar("contact_energy", "J", [](const SystemTotals& t) { return t.ledger.contact_energy; });
  columns.scalar("boundary_work", "J", [](const SystemTotals& t) { return t.ledger.boundary_work; });
  columns.scalar("body_force_work", "J", [](const SystemTotals& t) { return t.ledger.body_force_work; });
  columns.scalar("filter_dissipation", "J", [](const SystemTotals& t) { return t.ledger.filter_dissipation; });
  columns.scalar("shift_work", "J", [](const SystemTotals& t) { return t.ledger.shift_work; });
  columns.scalar("transfer_loss", "J", [](const SystemTotals& t) { return t.transfer_loss; });
  columns.vector("boundary_impulse", "N s", [](const SystemTotals& t) { return t.ledger.boundary_impulse; });
  columns.vector("damping_impulse", "N s", [](const SystemTotals& t) { return t.ledger.damping_impulse; });
  columns.vector("gravity_impulse", "N s", [](const SystemTotals& t) { return t.ledger.gravity_impulse; });
  columns.vector("body_force_impulse", "N s", [](const SystemTotals& t) { return t.ledger.body_force_impulse; });
  columns.vector("cutoff_impulse", "N s", [](const SystemTotals& t) { return t.ledger.cutoff_impulse; });
  columns.scalar("returned_count", "1", [](const SystemTotals& t) { return t.ledger.returned_count; });
  columns.scalar("removed_count", "1", [](const SystemTotals& t) { return t.ledger.removed_count; });
  columns.scalar("removed_mass", "kg", [](const SystemTotals& t) { return t.ledger.removed_mass; });
  columns.vector("removed_momentum", "N s", [](const SystemTotals& t) { return t.ledger.removed_momentum; });
  columns.scalar("removed_energy", "J", [](const SystemTotals& t) { return t.ledger.removed_energy; });
  return columns.take();
}

std::vector<Column<BoundaryTotals>> boundary_columns(int dim) {
  Columns<BoundaryTotals> columns(dim);
  columns.vector("force", "N", [](const BoundaryTotals& t) { return t.force; });
  columns.vector("impulse", "N s", [](const BoundaryTotals& t) { return t.impulse; });
  columns.scalar("work", "J", [](const BoundaryTotals& t) { return t.work; });
  return columns.take();
}

/// Where no particle is left there is no centre, no extent and no J: 0 or 1 would read as a result.
BodyTotals without_meaningless(BodyTotals totals) {
  if (totals.particle_count > 0) return totals;
  totals.center_of_mass = totals.lower = totals.upper = {k_nan, k_nan, k_nan};
  totals.J_min = totals.J_max = k_nan;
  return totals;
}

void add(BodyTotals& sum, const BodyTotals& body) {
  if (body.particle_count == 0) return;
  const bool is_first = sum.particle_count == 0;
  sum.particle_count += body.particle_count;
  const Real mass = sum.mass + body.mass;
  for (std::size_t d = 0; d < 3; ++d) {
    sum.center_of_mass[d] =
        is_first ? body.center_of_mass[d] : (sum.mass * sum.center_of_mass[d] + body.mass * body.center_of_mass[d]) / mass;
    sum.momentum[d] += body.momentum[d];
    sum.lower[d] = is_first ? body.lower[d] : std::min(sum.lower[d], body.lower[d]);
    sum.upper[d] = is_first ? body.upper[d] : std::max(sum.upper[d], body.upper[d]);
  }
  sum.mass = mass;
  sum.kinetic_energy += body.kinetic_energy;
  sum.strain_energy += body.strain_energy;
  sum.gravitational_energy += body.gravitational_energy;
  sum.von_mises_max = std::max(sum.von_mises_max, body.von_mises_max);
  sum.J_min = is_first ? body.J_min : std::min(sum.J_min, body.J_min);
  sum.J_max = is_first ? body.J_max : std::max(sum.J_max, body.J_max);
}

}  // namespace

namespace {

/// A pass over all particles: once per row.
std::vector<BodyTotals> body_totals(const Solver& solver) {
  std::vector<BodyTotals> totals;
  for (std::size_t b = 0; b < solver.body_count(); ++b) totals.push_back(solver.totals(b));
  return totals;
}

SystemTotals system_totals(const Snapshot& snapshot, const std::vector<BodyTotals>& bodies) {
  SystemTotals totals;
  for (const BodyTotals& body : bodies) add(totals.sum, body);
  totals.sum = without_meaningless(totals.sum);
  totals.ledger = snapshot.solver.ledger();
  const Real present = totals.sum.kinetic_energy + totals.sum.strain_energy + totals.sum.gravitational_energy;
  totals.transfer_loss = snapshot.initial_energy - present - totals.ledger.energy_spent();
  return totals;
}

}  // namespace

SystemTotals system_totals(const Snapshot& snapshot) { return system_totals(snapshot, body_totals(snapshot.solver)); }

std::vector<HistoryColumn> history_columns(const Solver& solver) {
  std::vector<HistoryColumn> names = {{"time", "s"}, {"step", "1"}, {"dt", "s"}};
  const auto add_all = [&](const auto& columns, const std::string& prefix) {
    for (const auto& column : columns) names.push_back({prefix + column.name, column.unit});
  };
  add_all(body_columns(solver.dim()), "");
  add_all(balance_columns(solver.dim()), "");
  for (const StepNumber& number : solver.step_numbers()) names.push_back({number.name, number.unit});
  for (std::size_t b = 0; b < solver.body_count(); ++b) add_all(body_columns(solver.dim()), solver.body_name(b) + ".");
  for (const BoundaryTotals& boundary : solver.boundaries()) add_all(boundary_columns(solver.dim()), boundary.name + ".");
  return names;
}

std::vector<Real> history_row(const Snapshot& snapshot) {
  const int dim = snapshot.solver.dim();
  std::vector<Real> row = {snapshot.time, static_cast<Real>(snapshot.step), snapshot.dt};
  const auto add_all = [&](const auto& columns, const auto& totals) {
    for (const auto& column : columns) row.push_back(column.value(totals));
  };
  const std::vector<BodyTotals> bodies = body_totals(snapshot.solver);
  const SystemTotals system = system_totals(snapshot, bodies);
  add_all(body_columns(dim), system.sum);
  add_all(balance_columns(dim), system);
  for (const StepNumber& number : snapshot.solver.step_numbers()) row.push_back(number.value);
  for (const BodyTotals& body : bodies) add_all(body_columns(dim), without_meaningless(body));
  for (const BoundaryTotals& boundary : snapshot.solver.boundaries()) add_all(boundary_columns(dim), boundary);
  return row;
}

std::string csv_row(const std::vector<Real>& values) { return fmt::format("{}\n", fmt::join(values, ",")); }

std::string header_line(const std::vector<HistoryColumn>& columns) {
  std::string line;
  for (const HistoryColumn& column : columns) line += (line.empty() ? "" : ",") + column.name;
  return line + "\n";
}

History::History(const std::filesystem::path& path, const Solver& solver) : file_(path, header_line(history_columns(solver))) {}

void History::write(const std::vector<Real>& row) { file_.append(csv_row(row)); }

HistoryRecord interpolated(const HistoryRecord& before, const HistoryRecord& after, Real time, const Solver& solver) {
  const Real share = (time - before.time()) / (after.time() - before.time());
  HistoryRecord record = after;
  const auto mix = [&](Real a, Real b) { return a + share * (b - a); };
  const std::vector<HistoryColumn> columns = history_columns(solver);
  const std::vector<StepNumber> numbers = solver.step_numbers();
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const std::string& name = columns[c].name;
    const bool is_of_step = name == "step" || name == "dt" || name.ends_with("_count") ||
                            std::any_of(numbers.begin(), numbers.end(), [&](const StepNumber& number) { return number.name == name; });
    if (!is_of_step) record.history[c] = mix(before.history[c], after.history[c]);
  }
  for (std::size_t p = 0; p < record.probes.size(); ++p) {
    for (std::size_t c = 0; c < record.probes[p].size(); ++c) record.probes[p][c] = mix(before.probes[p][c], after.probes[p][c]);
    record.probes[p].front() = time;
  }
  record.history.front() = time;
  return record;
}

}  // namespace matpoint
