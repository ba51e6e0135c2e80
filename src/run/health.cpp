#include "run/health.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "core/error.hpp"
#include "io/history.hpp"

namespace matpoint {
namespace {

// As shares of the greatest energy that moved in the run: other codes of explicit dynamics warn at gains of 1 to 2 % (LS-DYNA, Radioss,
// Abaqus); a scheme of first order may lose ten times as much, and says so.
constexpr Real k_gain = 0.01;
constexpr Real k_loss = 0.1;
/// Of the impulse of gravity or of the momentum at the start.
constexpr Real k_cutoff = 1e-4;
/// A weakly compressible fluid is meant to keep its volume to 1 % (c0 = 10 times its speed, Monaghan 1994).
constexpr Real k_fluid_volume = 0.02;
/// Beyond these a law means little, and one more step may turn the material inside out.
constexpr Real k_J_low = 0.1;
constexpr Real k_J_high = 10;
/// Share of the energy that moved. A ball that bounces has 5 % at its end, a beam that bends by its own length on coarse cells 6 %; where
/// particles were seen to be shaken loose it is 17 to 21 %.
constexpr Real k_noise = 0.1;
/// Of all steps.
constexpr Real k_redone = 0.01;
/// Share of the particles, per thousand steps.
constexpr Real k_returned = 0.01;

Real volume_of(const Solver& solver, std::size_t body) {
  const std::vector<Real> volumes = solver.field(body, "volume").values;
  return std::accumulate(volumes.begin(), volumes.end(), Real{0});
}

/// Of a group of particles: the sum of m |v - fit|^2 / 2, where the fit is linear in place, divided by the share of it that is left free.
Real scatter(const std::vector<std::size_t>& group, const std::vector<Real>& x, const std::vector<Real>& v, const std::vector<Real>& m,
             std::size_t dim) {
  const std::size_t n = group.size();
  // Columns 1, x, y, z made orthogonal one after the other (Gram-Schmidt), and the velocity made orthogonal to each.
  std::vector<std::vector<Real>> basis;
  const auto take_out = [&](std::vector<Real>& column) {
    for (const std::vector<Real>& one : basis) {
      const Real part = std::inner_product(one.begin(), one.end(), column.begin(), Real{0});
      for (std::size_t k = 0; k < n; ++k) column[k] -= part * one[k];
    }
  };
  for (std::size_t c = 0; c <= dim; ++c) {
    std::vector<Real> column(n, 1);
    for (std::size_t k = 0; k < n && c > 0; ++k) column[k] = x[dim * group[k] + c - 1];
    const Real before = std::inner_product(column.begin(), column.end(), column.begin(), Real{0});
    take_out(column);
    const Real left = std::inner_product(column.begin(), column.end(), column.begin(), Real{0});
    if (left <= 1e-12 * before) continue;  // all in one line
    for (Real& value : column) value /= std::sqrt(left);
    basis.push_back(std::move(column));
  }
  if (n <= basis.size()) return 0;
  Real sum = 0;
  for (std::size_t d = 0; d < dim; ++d) {
    std::vector<Real> rest(n);
    for (std::size_t k = 0; k < n; ++k) rest[k] = v[dim * group[k] + d];
    take_out(rest);
    for (std::size_t k = 0; k < n; ++k) sum += m[group[k]] * rest[k] * rest[k] / 2;
  }
  return sum * static_cast<Real>(n) / static_cast<Real>(n - basis.size());
}

Real percent(Real share) { return 100 * share; }

}  // namespace

Real unresolved_energy(const std::vector<Real>& positions, const std::vector<Real>& velocities, const std::vector<Real>& masses, int dim,
                       const Vec3& cell_size) {
  const auto size = static_cast<std::size_t>(dim);
  using Cell = std::array<std::int64_t, 3>;
  std::vector<std::pair<Cell, std::size_t>> order(masses.size());
  for (std::size_t p = 0; p < masses.size(); ++p) {
    Cell cell{};
    for (std::size_t d = 0; d < size; ++d) cell[d] = static_cast<std::int64_t>(std::floor(positions[size * p + d] / cell_size[d]));
    order[p] = {cell, p};
  }
  std::sort(order.begin(), order.end());
  Real sum = 0;
  std::vector<std::size_t> group;
  for (std::size_t k = 0; k < order.size(); ++k) {
    group.push_back(order[k].second);
    if (k + 1 < order.size() && order[k + 1].first == order[k].first) continue;
    sum += scatter(group, positions, velocities, masses, size);
    group.clear();
  }
  return sum;
}

Health::Health(const Snapshot& start) : is_explicit_(!start.problem.is_implicit()) {
  const std::vector<HistoryColumn> columns = history_columns(start.solver);
  const auto range = [&](const std::string& name) {
    const auto found = std::find_if(columns.begin(), columns.end(), [&](const HistoryColumn& column) { return column.name == name; });
    Range one;
    one.column = static_cast<std::size_t>(found - columns.begin());
    return one;
  };
  kinetic_ = range("kinetic_energy");
  strain_ = range("strain_energy");
  gravitational_ = range("gravitational_energy");
  transfer_loss_ = range("transfer_loss");
  filter_dissipation_ = range("filter_dissipation");
  for (std::size_t b = 0; b < start.solver.body_count(); ++b) {
    J_min_.push_back(range(start.solver.body_name(b) + ".J_min"));
    J_max_.push_back(range(start.solver.body_name(b) + ".J_max"));
    volume_.push_back(volume_of(start.solver, b));
    particles_ += start.solver.particle_count(b);
    const BodyTotals totals = start.solver.totals(b);
    momentum_scale_.push_back(std::sqrt(2 * totals.kinetic_energy * totals.mass));
  }
}

void Health::look(const std::vector<Real>& row) {
  const auto take = [&](Range& range) {
    range.lowest = std::min(range.lowest, row[range.column]);
    range.highest = std::max(range.highest, row[range.column]);
  };
  for (Range* range : {&kinetic_, &strain_, &gravitational_, &transfer_loss_, &filter_dissipation_}) take(*range);
  scheme_loss_.lowest = std::min(scheme_loss_.lowest, row[transfer_loss_.column] + row[filter_dissipation_.column]);
  for (Range& range : J_min_) take(range);
  for (Range& range : J_max_) take(range);
}

void Health::declare_state(State& state) {
  state.part("kinetic_energy", kinetic_);
  state.part("strain_energy", strain_);
  state.part("gravitational_energy", gravitational_);
  state.part("transfer_loss", transfer_loss_);
  state.part("filter_dissipation", filter_dissipation_);
  state.part("scheme_loss", scheme_loss_);
  state.parts("J_min", J_min_);
  state.parts("J_max", J_max_);
  state.add("volume", volume_);
  state.add("particles", particles_);
  state.add("momentum_scale", momentum_scale_);
  if (volume_.size() != J_min_.size() || momentum_scale_.size() != J_min_.size()) state.fail("volume", "has not one number for each body");
}

std::vector<HealthLine> Health::lines(const Snapshot& now) const {
  std::vector<HealthLine> lines;
  if (is_explicit_) {
    add_energy(now, lines);
    add_noise(now, lines);
    add_momentum(now, lines);
  }
  add_bodies(now, lines);
  add_particles(now, lines);
  add_steps(now, lines);
  return lines;
}

void Health::add_energy(const Snapshot& now, std::vector<HealthLine>& lines) const {
  const SystemTotals totals = system_totals(now);
  const Real moved = moved_energy();
  if (!(moved > 0)) return;
  const Real loss = totals.transfer_loss / moved;
  const Real gain = std::max(-scheme_loss_.lowest, Real{0}) / moved;
  HealthLine line{"energy", "", true, ""};
  const bool has_energy = std::all_of(now.problem.bodies.begin(), now.problem.bodies.end(),
                                      [](const BodySpec& body) { return body.material->law_index() >= 0; });
  if (!has_energy) {
    line.text = "not balanced: the law given as a function does not say what it stores";
    lines.push_back(line);
    return;
  }
  if (!now.problem.grid.periodic.empty()) {
    line.text = "not balanced: what goes round periodic sides has no potential of gravity";
    lines.push_back(line);
    return;
  }
  line.text = fmt::format("the transfers {} {:.3g} J, {:.3g} % of the {:.3g} J that moved", loss >= 0 ? "took" : "gave",
                          std::abs(totals.transfer_loss), percent(std::abs(loss)), moved);
  const Real filtered = now.solver.ledger().filter_dissipation;
  if (filtered > 0) line.text += fmt::format("; the correction of fluids took {:.3g} J", filtered);
  // Water that splashes loses much of its energy by nature, in eddies below any grid.
  const bool has_fluid =
      std::any_of(now.problem.bodies.begin(), now.problem.bodies.end(), [](const BodySpec& body) { return body.material->is_fluid(); });
  if (gain > k_gain) {
    line.is_good = false;
    line.text += fmt::format("; at its worst the run had {:.2g} % more than its books", percent(gain));
    line.remedy = now.problem.solver.shape == ShapeKind::linear
                      ? "energy was made: take solver.shape = \"bspline2\", or more particles in a cell"
                      : "energy was made: take solver.flip = 0.99, a smaller time.cfl, or more particles in a cell";
  } else if (loss > k_loss && !has_fluid) {
    line.is_good = false;
    const bool is_loose = std::any_of(now.problem.bodies.begin(), now.problem.bodies.end(),
                                      [](const BodySpec& body) { return body.material->flows_freely(); });
    if (is_loose && now.problem.solver.transfer != Transfer::flip)
      line.remedy =
          "the transfer damps the motion a little in each step: take smaller cells, or a lower youngs_modulus, which makes longer "
          "steps (100 times the greatest stress is enough)";
    else
      line.remedy = now.problem.solver.transfer == Transfer::flip
                        ? "the motion is damped by what the grid cannot resolve: take smaller cells"
                        : "the transfer damps the motion: take solver.transfer = \"flip\", or smaller cells";
  }
  lines.push_back(line);
}

void Health::add_noise(const Snapshot& now, std::vector<HealthLine>& lines) const {
  const Real moved = moved_energy();
  if (!(moved > 0)) return;
  Real noise = 0;
  for (std::size_t b = 0; b < now.solver.body_count(); ++b) {
    const BodySpec& spec = now.problem.bodies[b];
    // Eddies of water below the size of a cell are no fault; elements have one velocity between their nodes.
    if (spec.method != BodyMethod::particles || spec.material->is_fluid() || now.solver.particle_count(b) == 0) continue;
    const auto of = [&](const char* field) { return now.solver.field(b, field).values; };
    noise += unresolved_energy(of("position"), of("velocity"), of("mass"), now.solver.dim(), now.solver.grid().cell_size);
  }
  const Real share = noise / moved;
  HealthLine line{"noise", fmt::format("{:.2g} % of the energy that moved is in motion inside single cells of solids", percent(share)),
                  share <= k_noise, ""};
  if (!line.is_good) {
    line.remedy = now.problem.solver.transfer == Transfer::flip
                      ? "velocities of single particles are noise, and stresses may be: take solver.transfer = \"apic\", which damps it"
                      : "velocities of single particles are noise, and stresses may be: take more particles in a cell";
  }
  lines.push_back(line);
}

void Health::add_momentum(const Snapshot& now, std::vector<HealthLine>& lines) const {
  const Ledger& ledger = now.solver.ledger();
  const auto size = [](const Vec3& v) { return std::sqrt(dot(v, v)); };
  const Real scale = std::max(std::accumulate(momentum_scale_.begin(), momentum_scale_.end(), Real{0}), size(ledger.gravity_impulse));
  if (!(scale > 0)) return;
  const Real lost = size(ledger.cutoff_impulse) / scale;
  HealthLine line{"momentum", fmt::format("nodes under the mass cutoff kept {:.2g} % of it", percent(lost)), lost <= k_cutoff, ""};
  if (!line.is_good) line.remedy = "leave out solver.mass_cutoff and mass_cutoff_relative";
  lines.push_back(line);
}

void Health::add_bodies(const Snapshot& now, std::vector<HealthLine>& lines) const {
  for (std::size_t b = 0; b < volume_.size(); ++b) {
    const std::string& name = now.solver.body_name(b);
    if (now.solver.particle_count(b) == 0) continue;
    const Real change = volume_of(now.solver, b) / volume_[b] - 1;
    const BodySpec& spec = now.problem.bodies[b];
    HealthLine line{"body " + name,
                    fmt::format("J from {:.3g} to {:.3g}, volume {:+.2g} %", J_min_[b].lowest, J_max_[b].highest, percent(change)), true,
                    ""};
    if (spec.material->is_gas()) {
      // Its volume is its own.
    } else if (spec.material->is_fluid() && std::abs(change) > k_fluid_volume && now.solver.ledger().removed_count == 0) {
      line.is_good = false;
      line.remedy =
          "a fluid keeps its volume: take a pressure_scale with c0 = sqrt(gamma pressure_scale / density) ten times its speed, or smaller "
          "cells";
    } else if (J_min_[b].lowest < k_J_low || (J_max_[b].highest > k_J_high && !spec.material->flows_freely() && !spec.material->breaks())) {
      // (That grains fly and what is brittle breaks is no harm.)
      line.is_good = false;
      line.remedy = "the material was all but turned inside out or torn: take a stiffer law, smaller cells, or more particles in a cell";
    }
    lines.push_back(line);
  }
}

void Health::add_particles(const Snapshot& now, std::vector<HealthLine>& lines) const {
  const Ledger& ledger = now.solver.ledger();
  HealthLine line{"particles",
                  fmt::format("{} of {} removed, {} put back at closed sides", ledger.removed_count, particles_, ledger.returned_count),
                  true, ""};
  const Real thousands = std::max(Real{1}, static_cast<Real>(now.step) / 1000);
  if (static_cast<Real>(ledger.returned_count) > k_returned * static_cast<Real>(particles_) * thousands) {
    line.is_good = false;
    line.remedy =
        "particles are pressed through the walls: take more of them in a cell, solver.shape = \"bspline2\", or a smaller time.cfl";
  }
  if (ledger.removed_count > 0) {
    line.is_good = false;
    line.remedy = "particles left the grid: enlarge it or close its sides";
  }
  lines.push_back(line);
}

void Health::add_steps(const Snapshot& now, std::vector<HealthLine>& lines) const {
  if (now.failed_steps == 0) return;
  const Real share = static_cast<Real>(now.redone_steps) / static_cast<Real>(std::max(now.step, Index{1}));
  HealthLine line{"steps",
                  fmt::format("{} failed and {} taken again half as long: {} steps thrown away, {:.2g} % of {}", now.failed_steps,
                              now.failed_steps == 1 ? "was" : "were", now.redone_steps, percent(share), now.step),
                  share <= k_redone, ""};
  if (!line.is_good) line.remedy = "the bodies move faster than the stable step foresees: take a smaller time.cfl";
  lines.push_back(line);
}

}  // namespace matpoint
