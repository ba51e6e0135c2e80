// What runs of the implicit solver start from: accelerations, and ground that is at rest.
#include <algorithm>
#include <cmath>

#include "implicit/implicit_solver.hpp"

namespace matpoint {

/// Accelerations at the start from the forces there: M a = f. The mass matrix of particles as quadrature points may be singular, where a
/// node sees few of them; a step that is short beside the first one adds just enough stiffness.
/// Those of bodies of elements, by active node and component [m/s^2].
template <int Dim>
void ImplicitSolver<Dim>::take_nodal_accelerations(const std::vector<Real>& nodal) {
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    if (sources_[s].fem == nullptr) continue;
    for (std::size_t n = 0; n < space_.nodes().size(); ++n) {
      if (!space_.is_of(s, n) || !sources_[s].fem->has_node(space_.nodes()[n])) continue;
      Vec<Dim>& a = sources_[s].fem->acceleration[static_cast<std::size_t>(space_.nodes()[n])];
      std::copy_n(nodal.begin() + static_cast<std::ptrdiff_t>(n * Dim), Dim, a.begin());
    }
  }
}

/// What loads on particles and on faces do at the start of a step.
template <int Dim>
void ImplicitSolver<Dim>::start_loads(const StepLoad<Dim>& load) {
  const std::vector<Real> zero(space_.nodes().size() * Dim, 0);
  for (std::size_t l = 0; l < loads_.size(); ++l) {
    loads_[l].force = {};
    const std::vector<Real> forces = point_loads_.nodal_forces(l, zero, load.factors);
    for (std::size_t k = 0; k < forces.size(); ++k) loads_[l].force[k % Dim] += forces[k];
    for (std::size_t d = 0; d < Dim; ++d) body_force_force_[d] += loads_[l].force[d];
  }
  if (load.nodal_force.empty()) return;
  for (std::size_t k = 0; k < load.nodal_force.size(); ++k) body_force_force_[k % Dim] += load.nodal_force[k];
  traction_work_.start_with(space_, load.nodal_force);
}

template <int Dim>
void ImplicitSolver<Dim>::set_initial_acceleration(Real t, Real dt) {
  constexpr Real k_short = 1e-3;
  update_space(t);
  StepLoad<Dim> load = make_load(t, dt);
  const Real factor = newmark(k_short * dt).u;
  load.inertia = {factor, 0, 0};
  if (!contacts_.is_empty()) {
    contacts_.start(space_);
    take_contacts(load, conditions_.displacements(t, 0));
  }
  const std::vector<Real> zero(space_.nodes().size() * Dim, 0);
  std::vector<Real> residual;
  Lift lift;
  assembly_.residual_and_matrix(zero, load, residual, lift);
  std::vector<Real> nodal;
  if (!newton_.solve_linear(residual, Symmetry::general, nodal)) {
    throw SolverError("t = {:.8g} s: no accelerations follow from the forces at the start; initial_acceleration = \"zero\" does without",
                      t);
  }
  for (Real& value : nodal) value *= -factor;
  std::vector<Real> A;
  std::vector<Vec<Dim>> a;
  assembly_.deform(nodal, A, a);
  Vec3 total{};
  space_.for_each_point([&](std::size_t source, std::size_t p, std::size_t k) {
    const Vec<Dim>& acceleration = a[k];
    PointBody<Dim>& body = *sources_[source].points;
    body.acceleration[p] = acceleration;
    const Real ratio = sources_[source].fem != nullptr ? sources_[source].fem->weight_ratio() : 1;
    for (std::size_t d = 0; d < Dim; ++d) {
      total[d] += body.mass[p] * acceleration[d];
      gravity_force_[d] += body.mass[p] * ratio * load.gravity[d];
      body_force_force_[d] += body.mass[p] * (load.b(source, ratio, p, d) - ratio * load.gravity[d]);
    }
  });
  take_nodal_accelerations(nodal);
  start_loads(load);
  for (Real& value : nodal) value /= factor;
  assembly_.residual(nodal, load, residual);
  hold(load, zero, residual, zero, 0);
  std::copy_n(load.gravity.begin(), Dim, acceleration_gravity_.begin());
  for (std::size_t d = 0; d < Dim; ++d) reaction_[d] = total[d] - gravity_force_[d] - body_force_force_[d];
}

/// Ground that starts with the stress that carries it is out of balance in its first and last rows all the same: a few particles do not
/// integrate a stress exactly that is linear in the height, times functions that are cut. The displacements that would bring it to rest
/// are found, and what they do to the stresses is kept without them, as geotechnical programs begin. Where that would be more than the
/// weight of half a cell, the ground is not at rest, and falls or slides as it should.
template <int Dim>
void ImplicitSolver<Dim>::balance_initial_stress() {
  constexpr int k_rounds = 3;  // what is left of the first is of second order
  const bool is_ground = std::any_of(case_.bodies.begin(), case_.bodies.end(), [](const BodySpec& body) { return !!body.initial_stress; });
  const bool is_at_rest = std::all_of(case_.bodies.begin(), case_.bodies.end(), [](const BodySpec& body) {
    return !body.velocity && body.method == BodyMethod::particles && !body.material->is_rate_dependent();
  });
  if (!is_ground || !is_at_rest || !contacts_.is_empty() || contact_.has_pairs() || !sides_.is_empty()) return;
  for (int round = 0; round < k_rounds; ++round) {
    update_space(0);
    StepLoad<Dim> load = make_load(0, 1);
    load.inertia = {};
    const bool is_symmetric = !point_loads_.follows() && std::all_of(sources_.begin(), sources_.end(), [](const auto& source) {
      return source.points->material().is_symmetric();
    });
    std::vector<Real> u;
    const std::vector<Real> held(space_.nodes().size() * Dim, 0);
    if (newton_.solve(load, held, is_symmetric ? Symmetry::symmetric : Symmetry::general, u)) return;
    std::vector<Real> A;
    std::vector<Vec<Dim>> du;
    assembly_.deform(u, A, du);
    if (!is_small_correction(A, load)) return;
    take_stress(A);
  }
}

/// Whether no stress changes by more than the weight of half a cell.
template <int Dim>
bool ImplicitSolver<Dim>::is_small_correction(const std::vector<Real>& A, const StepLoad<Dim>& load) const {
  constexpr Real k_share = 0.5;
  const Real limit = k_share * std::sqrt(dot(load.gravity, load.gravity)) * basis_->shortest_side();
  bool is_small = true;
  space_.for_each_point([&](std::size_t source, std::size_t, std::size_t k) {
    const Real c = sources_[source].points->material().wave_speed(1);
    Real strain = 0;
    for (std::size_t e = 0; e < Dim * Dim; ++e) {
      const Real change = A[k * Dim * Dim + e] - (e % (Dim + 1) == 0 ? 1 : 0);
      strain += change * change;
    }
    is_small = is_small && c * c * std::sqrt(strain) <= limit;
  });
  return is_small;
}

/// Strains all particles by A where they are.
template <int Dim>
void ImplicitSolver<Dim>::take_stress(const std::vector<Real>& A) {
  commit_law(1, A);
  ledger_ = {};
  space_.for_each_point([&](std::size_t source, std::size_t p, std::size_t k) {
    PointBody<Dim>& body = *sources_[source].points;
    // A law that remembers its strain has it; its F counts from here.
    if (body.material().remembers_strain()) return;
    Real* const F = body.F.data() + p * Dim * Dim;
    Real strained[Dim * Dim];
    for (std::size_t i = 0; i < Dim; ++i) {
      for (std::size_t j = 0; j < Dim; ++j) {
        strained[i * Dim + j] = 0;
        for (std::size_t e = 0; e < Dim; ++e) strained[i * Dim + j] += A[(k * Dim + i) * Dim + e] * F[e * Dim + j];
      }
    }
    std::copy_n(strained, Dim * Dim, F);
  });
}

template void ImplicitSolver<2>::set_initial_acceleration(Real, Real);
template void ImplicitSolver<3>::set_initial_acceleration(Real, Real);
template void ImplicitSolver<2>::take_nodal_accelerations(const std::vector<Real>&);
template void ImplicitSolver<3>::take_nodal_accelerations(const std::vector<Real>&);
template void ImplicitSolver<2>::start_loads(const StepLoad<2>&);
template void ImplicitSolver<3>::start_loads(const StepLoad<3>&);
template void ImplicitSolver<2>::balance_initial_stress();
template void ImplicitSolver<3>::balance_initial_stress();
template bool ImplicitSolver<2>::is_small_correction(const std::vector<Real>&, const StepLoad<2>&) const;
template bool ImplicitSolver<3>::is_small_correction(const std::vector<Real>&, const StepLoad<3>&) const;
template void ImplicitSolver<2>::take_stress(const std::vector<Real>&);
template void ImplicitSolver<3>::take_stress(const std::vector<Real>&);

}  // namespace matpoint
