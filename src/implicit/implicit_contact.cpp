// The steps of the implicit solver with sides that let go: what they start from, and when their sets agree (docs/implicit.md).
#include <algorithm>
#include <cmath>

#include "implicit/implicit_solver.hpp"

namespace matpoint {

template <int Dim>
std::optional<std::string> ImplicitSolver<Dim>::settle(Real t, Real dt, StepLoad<Dim>& load, const std::vector<Vec<Dim>>& displacements,
                                                       bool is_balanced, std::vector<Real>& u) {
  bool is_settled = false;
  while (!is_settled) {
    if (!contacts_.is_empty()) take_contacts(load, displacements);
    if (is_balanced) balance(t, dt, displacements);
    if (auto failure = solve(t, load, displacements, u)) return failure;
    is_settled = true;
    if (contacts_.is_empty()) break;
    std::vector<Real> residual;
    assembly_.residual(u, load, residual);
    is_settled = !contacts_.update(space_, u, residual, displacements);
  }
  return std::nullopt;
}

template <int Dim>
bool ImplicitSolver<Dim>::loses_particles(const std::vector<Real>& u) const {
  std::vector<Real> A;
  std::vector<Vec<Dim>> du;
  assembly_.deform(u, A, du);
  bool loses = false;
  space_.for_each_point([&](std::size_t source, std::size_t p, std::size_t k) {
    for (std::size_t d = 0; d < Dim; ++d) {
      const Real x = sources_[source].points->position[p][d] + du[k][d];
      loses = loses || x < case_.grid.lower[d] || x > case_.grid.upper[d];
    }
  });
  return loses;
}

template <int Dim>
typename ImplicitSolver<Dim>::StepStart ImplicitSolver<Dim>::start_of_step() const {
  StepStart start{contacts_, boundaries_, pairs_, loads_, soft_work_, traction_work_, gravity_force_, body_force_force_, reaction_, {}, {}};
  for (const PointSource<Dim>& source : sources_) {
    start.accelerations.push_back(source.points->acceleration);
    start.nodal_accelerations.push_back(source.fem != nullptr ? source.fem->acceleration : std::vector<Vec<Dim>>{});
  }
  return start;
}

template <int Dim>
void ImplicitSolver<Dim>::restore(const StepStart& start) {
  contacts_ = start.contacts;
  contact_.balance({});
  sides_.balance({});
  boundaries_ = start.boundaries;
  pairs_ = start.pairs;
  loads_ = start.loads;
  soft_work_ = start.soft_work;
  traction_work_ = start.traction_work;
  gravity_force_ = start.gravity_force;
  body_force_force_ = start.body_force_force;
  reaction_ = start.reaction;
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    sources_[s].points->acceleration = start.accelerations[s];
    if (sources_[s].fem != nullptr) sources_[s].fem->acceleration = start.nodal_accelerations[s];
  }
}

/// (M + (s dt)^2 K) a = f, with f of the places, stresses and loads at the start: M alone is nearly singular where cuts are thin, and what
/// swings faster than the step sees must not be thrown on. Friction and reactions follow from the same solution.
template <int Dim>
void ImplicitSolver<Dim>::balance(Real t, Real dt, const std::vector<Vec<Dim>>& displacements) {
  // Of the step. Measured on bounces of blocks and disks, E = 1e5 to 1e8, steps of 2 and 0.5 ms, cells of 5 to 20 cm: 0.05 gains up to 14 %
  // of the energy, from 0.1 on nothing is gained, and 0.25 loses half as much again.
  constexpr Real k_share = 0.1;
  contact_.balance({});
  sides_.balance({});
  sides_.start_step(std::vector<Vec<Dim>>(displacements.size(), Vec<Dim>{}));  // the step has not begun to move them
  StepLoad<Dim> load = make_load(t, dt);
  const Real factor = 1 / (k_share * k_share * dt * dt);
  load.inertia = {factor, 0, 0};
  load.friction = contacts_.friction(space_, displacements);
  const std::vector<Real> zero(space_.nodes().size() * Dim, 0);
  std::vector<Real> residual;
  Lift lift;
  assembly_.residual_and_matrix(zero, load, residual, lift);
  std::vector<Real> way;
  if (!newton_.solve_linear(residual, Symmetry::general, way)) {  // the accelerations of the particles do
    sides_.start_step(displacements);
    return;
  }
  Real greatest = 0;
  for (Real& x : way) {
    x = -x;
    greatest = std::max(greatest, std::abs(x));
  }
  std::vector<Real> A;
  std::vector<Vec<Dim>> du;
  assembly_.deform(way, A, du);
  Vec3 total{};
  gravity_force_ = body_force_force_ = reaction_ = {};
  space_.for_each_point([&](std::size_t source, std::size_t p, std::size_t k) {
    PointBody<Dim>& body = *sources_[source].points;
    const Real ratio = sources_[source].fem != nullptr ? sources_[source].fem->weight_ratio() : 1;
    for (std::size_t d = 0; d < Dim; ++d) {
      body.acceleration[p][d] = factor * du[k][d];
      total[d] += body.mass[p] * body.acceleration[p][d];
      gravity_force_[d] += body.mass[p] * ratio * load.gravity[d];
      body_force_force_[d] += body.mass[p] * (load.b(source, ratio, p, d) - ratio * load.gravity[d]);
    }
  });
  std::vector<Real> nodal = way;
  for (Real& value : nodal) value *= factor;
  take_nodal_accelerations(nodal);
  start_loads(load);
  // The reactions that go with them, to first order as the accelerations themselves: by a difference, exact to ten digits.
  const Real small = greatest > 0 ? 1e-5 * geometry_.cell_size[0] / greatest : 0;
  std::vector<Real> up = way, down = way, change_up, change_down;
  for (std::size_t k = 0; k < way.size(); ++k) {
    up[k] *= small;
    down[k] *= -small;
  }
  assembly_.residual(up, load, change_up);
  assembly_.residual(down, load, change_down);
  for (std::size_t k = 0; k < residual.size() && small > 0; ++k) residual[k] += (change_up[k] - change_down[k]) / (2 * small);
  std::vector<std::vector<Real>> held(boundaries_.size());
  for (std::size_t k = 0; k < residual.size(); ++k) {
    const std::size_t n = k / Dim;
    const int condition = acting_condition(n, k % Dim, load);
    if (condition < 0) continue;
    std::vector<Real>& force = held[static_cast<std::size_t>(condition)];
    force.resize(residual.size(), 0);
    force[k] = residual[k];
    if (space_.unknown(static_cast<Index>(n), static_cast<int>(k % Dim)) < 0) continue;
    const FaceFriction<Dim>& friction = load.friction[n];
    force[k] = -friction.at(zero.data())[k % Dim] * residual[n * Dim + static_cast<std::size_t>(friction.axis)];
  }
  for (std::size_t b = 0; b < boundaries_.size(); ++b) {
    held[b].resize(residual.size(), 0);
    boundaries_[b].work.start_with(space_, held[b]);
    boundaries_[b].in_slip.start_with(space_, held[b]);
    boundaries_[b].totals.force = {};
    for (std::size_t k = 0; k < held[b].size(); ++k) boundaries_[b].totals.force[k % Dim] += held[b][k];
  }
  balance_pairs(up, down, small);
  contact_.balance(way);
  sides_.balance(way);
  for (const auto& action : sides_.actions(zero, true))
    std::copy(action.start.begin(), action.start.end(), boundaries_[static_cast<std::size_t>(action.condition)].totals.force.begin());
  sides_.start_step(displacements);
  soft_work_.start_with(space_, zero);  // it acts on the displacements of a step, and at its start there are none
  for (std::size_t d = 0; d < Dim; ++d) reaction_[d] = total[d] - gravity_force_[d] - body_force_force_[d];
}

/// What bodies in contact do to each other at the start of the step, to first order, too.
template <int Dim>
void ImplicitSolver<Dim>::balance_pairs(const std::vector<Real>& up, const std::vector<Real>& down, Real small) {
  if (pairs_.empty()) return;
  const auto forces_after = [&](const std::vector<Real>& u) {
    contact_.move(u);
    return contact_.pair_forces(true);
  };
  std::vector<std::vector<Real>> forces = forces_after(std::vector<Real>(up.size(), 0));
  const std::vector<std::vector<Real>> change_up = forces_after(up), change_down = forces_after(down);
  for (std::size_t p = 0; p < pairs_.size(); ++p) {
    for (std::size_t k = 0; k < forces[p].size() && small > 0; ++k) forces[p][k] += (change_up[p][k] - change_down[p][k]) / (2 * small);
    pairs_[p].work.start_with(space_, forces[p]);
    pairs_[p].totals.force = {};
    for (std::size_t k = 0; k < forces[p].size(); ++k) pairs_[p].totals.force[k % Dim] += forces[p][k];
  }
}

// Used by implicit_solver.cpp.
template std::optional<std::string> ImplicitSolver<2>::settle(Real, Real, StepLoad<2>&, const std::vector<Vec<2>>&, bool,
                                                              std::vector<Real>&);
template bool ImplicitSolver<2>::loses_particles(const std::vector<Real>&) const;
template ImplicitSolver<2>::StepStart ImplicitSolver<2>::start_of_step() const;
template void ImplicitSolver<2>::restore(const StepStart&);
template std::optional<std::string> ImplicitSolver<3>::settle(Real, Real, StepLoad<3>&, const std::vector<Vec<3>>&, bool,
                                                              std::vector<Real>&);
template bool ImplicitSolver<3>::loses_particles(const std::vector<Real>&) const;
template ImplicitSolver<3>::StepStart ImplicitSolver<3>::start_of_step() const;
template void ImplicitSolver<3>::restore(const StepStart&);

}  // namespace matpoint
