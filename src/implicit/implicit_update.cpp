// The implicit solver's end of a step: what the converged displacements do to the bodies, and to the books; and what it tells about itself.
#include <algorithm>
#include <cmath>

#include "body/particle_fields.hpp"
#include "case/linear_solver_names.hpp"
#include "implicit/implicit_solver.hpp"

namespace matpoint {

template <int Dim>
void NodalWork<Dim>::advance(const StepSpace<Dim>& space, const std::vector<Real>& force, const std::vector<Real>& u) {
  const auto size = static_cast<std::size_t>(space.slot_count() * Dim);
  last_.resize(size, 0);
  std::vector<Real> now(size, 0);
  start_ = end_ = 0;
  for (std::size_t n = 0; n < space.nodes().size(); ++n) {
    for (std::size_t d = 0; d < Dim; ++d) {
      const std::size_t place = static_cast<std::size_t>(space.slots()[n]) * Dim + d;
      now[place] = force[n * Dim + d];
      start_ += 0.5 * last_[place] * u[n * Dim + d];
      end_ += 0.5 * now[place] * u[n * Dim + d];
    }
  }
  last_ = std::move(now);
}

template <int Dim>
void NodalWork<Dim>::start_with(const StepSpace<Dim>& space, const std::vector<Real>& force) {
  last_.assign(static_cast<std::size_t>(space.slot_count() * Dim), 0);
  for (std::size_t k = 0; k < force.size(); ++k) last_[static_cast<std::size_t>(space.slots()[k / Dim]) * Dim + k % Dim] = force[k];
}

template <int Dim>
void ImplicitSolver<Dim>::commit(Real t, Real dt, const StepLoad<Dim>& load, const std::vector<Real>& u) {
  std::vector<Real> residual;
  assembly_.residual(u, load, residual);
  newton_.report_residual(newton_.unknown_norm(residual));
  std::vector<Real> A;
  std::vector<Vec<Dim>> du;
  assembly_.deform(u, A, du);
  const Vec3 reaction = hold(load, u, residual, contacts_.slip(space_, u, conditions_.displacements(t, dt)), dt);
  hold_pairs(u, dt);
  book(t, dt, load, u, du, reaction);
  book_forces_at_start(dt, load, u, du);
  has_pressed_ = particles_.empty() && (contact_.has_pressed() || sides_.has_pressed(u));
  ledger_.contact_dissipation += contact_.commit(spec_.mode == ImplicitMode::dynamic);
  sides_.commit(u, spec_.mode == ImplicitMode::dynamic);
  ledger_.contact_energy = contact_.energy() + sides_.energy();
  commit_law(dt, A);
  const bool is_dynamic = spec_.mode == ImplicitMode::dynamic;
  space_.for_each_point([&](std::size_t source, std::size_t p, std::size_t k) {
    PointBody<Dim>& body = *sources_[source].points;
    Real F[Dim * Dim];
    std::copy_n(body.F.data() + p * Dim * Dim, Dim * Dim, F);
    for (std::size_t i = 0; i < Dim; ++i) {
      for (std::size_t j = 0; j < Dim; ++j) {
        Real sum = 0;
        for (std::size_t e = 0; e < Dim; ++e) sum += A[(k * Dim + i) * Dim + e] * F[e * Dim + j];
        body.F[(p * Dim + i) * Dim + j] = sum;
      }
    }
    for (std::size_t d = 0; d < Dim; ++d) {
      if (is_dynamic) {
        Real& v = body.velocity[p][d];
        Real& a = body.acceleration[p][d];
        const Real a_new = load.inertia.u * du[k][d] - load.inertia.v * v - load.inertia.a * a;
        const Real v_new = v + dt * ((1 - spec_.gamma) * a + spec_.gamma * a_new);
        ledger_.integrator_loss += 0.5 * body.mass[p] * ((a + a_new) * du[k][d] - (v_new + v) * (v_new - v));
        v = v_new;
        a = a_new;
      }
      body.position[p][d] += du[k][d];
    }
  });
  commit_nodes(dt, load, u);
  time_ = t + dt;
  change_gravity(case_.gravity_at(t + dt), du);
}

/// The law once more where it leaves something behind: its history, and a stress that does not follow from F.
template <int Dim>
void ImplicitSolver<Dim>::commit_law(Real dt, const std::vector<Real>& A) {
  Real S[Dim * Dim];
  space_.for_each_point([&](std::size_t source, std::size_t p, std::size_t k) {
    PointBody<Dim>& body = *sources_[source].points;
    if (body.history.empty() && body.tau.empty()) return;
    const auto history_size = static_cast<std::size_t>(body.material().history_size(Dim));
    std::vector<Real> new_history(history_size);
    Real dissipation = 0;
    TangentPoints point;
    point.count = 1;
    point.dt = dt;
    point.A = A.data() + k * Dim * Dim;
    point.F = body.F.data() + p * Dim * Dim;
    point.history = body.history.data() + p * history_size;
    point.S = S;
    point.new_history = new_history.data();
    point.tau = body.tau.empty() ? nullptr : body.tau.data() + 6 * p;
    point.dissipated = &dissipation;
    assembly_.law(source)(body.material().law_data(), point);
    std::copy(new_history.begin(), new_history.end(), body.history.begin() + static_cast<std::ptrdiff_t>(p * history_size));
    (body.material().is_plastic() ? ledger_.plastic_dissipation : ledger_.viscous_dissipation) += dissipation * body.volume0[p];
  });
}

/// Bodies of elements keep their motion at the nodes; their Gauss points follow.
template <int Dim>
void ImplicitSolver<Dim>::commit_nodes(Real dt, const StepLoad<Dim>& load, const std::vector<Real>& u) {
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    if (sources_[s].fem == nullptr) continue;
    FemBody<Dim>& fem = *sources_[s].fem;
    for (std::size_t n = 0; n < space_.nodes().size(); ++n) {
      if (!space_.is_of(s, n) || !fem.has_node(space_.nodes()[n])) continue;
      const auto node = static_cast<std::size_t>(space_.nodes()[n]);
      for (std::size_t d = 0; d < Dim; ++d) {
        const Real du = u[n * Dim + d];
        if (spec_.mode == ImplicitMode::dynamic) {
          Real& v = fem.velocity[node][d];
          Real& a = fem.acceleration[node][d];
          const Real a_new = load.inertia.u * du - load.inertia.v * v - load.inertia.a * a;
          v += dt * ((1 - spec_.gamma) * a + spec_.gamma * a_new);
          a = a_new;
        }
        fem.displacement[node][d] += du;
      }
    }
    fem.interpolate_motion();
  }
}

template <int Dim>
int ImplicitSolver<Dim>::acting_condition(std::size_t n, std::size_t d, const StepLoad<Dim>& load) const {
  const Index node = space_.nodes()[n];
  if (space_.unknown(static_cast<Index>(n), static_cast<int>(d)) < 0) return conditions_.condition(node, static_cast<int>(d));
  if (load.friction.empty() || load.friction[n].axis < 0) return -1;
  return conditions_.condition(node, load.friction[n].axis);
}

/// The residual at prescribed components is the force with which they act on the bodies; where a node slips, Coulomb's law has it. In slip
/// along a face this force dissipates, and in the motion of the face it works.
template <int Dim>
Vec3 ImplicitSolver<Dim>::hold(const StepLoad<Dim>& load, const std::vector<Real>& u, const std::vector<Real>& residual,
                               const std::vector<Real>& slip, Real dt) {
  std::vector<std::vector<Real>> forces(boundaries_.size());
  std::vector<Vec3> sums(boundaries_.size());
  for (std::size_t k = 0; k < residual.size(); ++k) {
    const std::size_t n = k / Dim;
    const std::size_t d = k % Dim;
    const int condition = acting_condition(n, d, load);
    if (condition < 0) continue;
    const auto b = static_cast<std::size_t>(condition);
    forces[b].resize(residual.size(), 0);
    if (space_.unknown(static_cast<Index>(n), static_cast<int>(d)) < 0) {
      forces[b][k] = residual[k];
    } else {
      const FaceFriction<Dim>& friction = load.friction[n];
      forces[b][k] = -friction.at(u.data() + n * Dim)[d] * residual[n * Dim + static_cast<std::size_t>(friction.axis)];
    }
    sums[b][d] += forces[b][k];
  }
  Vec3 reaction{};
  work_at_start_ = 0;
  for (std::size_t b = 0; b < boundaries_.size(); ++b) {
    HeldBoundary& boundary = boundaries_[b];
    forces[b].resize(residual.size(), 0);
    boundary.work.advance(space_, forces[b], u);
    boundary.in_slip.advance(space_, forces[b], slip);
    const Real in_slip = boundary.in_slip.start() + boundary.in_slip.end();
    const Real work = boundary.work.start() + boundary.work.end() - in_slip;
    boundary.totals.work += work;
    ledger_.boundary_work += work;
    ledger_.contact_dissipation -= in_slip;
    work_at_start_ += boundary.work.start();
    for (std::size_t d = 0; d < Dim; ++d) {
      reaction[d] += sums[b][d];
      if (spec_.mode == ImplicitMode::dynamic)
        boundary.totals.impulse[d] += dt * ((1 - spec_.gamma) * boundary.totals.force[d] + spec_.gamma * sums[b][d]);
    }
    boundary.totals.force = sums[b];
  }
  for (const auto& action : sides_.actions(u, spec_.mode == ImplicitMode::dynamic)) {
    HeldBoundary& boundary = boundaries_[static_cast<std::size_t>(action.condition)];
    boundary.totals.work += action.work;
    ledger_.boundary_work += action.work;
    ledger_.contact_dissipation += action.slip_work;
    for (std::size_t d = 0; d < Dim; ++d) {
      reaction[d] += action.end[d];
      boundary.totals.force[d] = action.end[d];
      if (spec_.mode == ImplicitMode::dynamic) boundary.totals.impulse[d] += dt * spec_.gamma * action.end[d];
    }
  }
  return reaction;
}

template <int Dim>
void ImplicitSolver<Dim>::hold_pairs(const std::vector<Real>& u, Real dt) {
  if (pairs_.empty()) return;
  const bool is_dynamic = spec_.mode == ImplicitMode::dynamic;
  const std::vector<std::vector<Real>> forces = contact_.pair_forces(is_dynamic);
  for (std::size_t p = 0; p < pairs_.size(); ++p) {
    BoundaryTotals& totals = pairs_[p].totals;
    Vec3 sum{};
    for (std::size_t k = 0; k < forces[p].size(); ++k) sum[k % Dim] += forces[p][k];
    pairs_[p].work.advance(space_, forces[p], u);
    totals.work += pairs_[p].work.start() + pairs_[p].work.end();
    for (std::size_t d = 0; d < Dim && is_dynamic; ++d)
      totals.impulse[d] += dt * ((1 - spec_.gamma) * totals.force[d] + spec_.gamma * sum[d]);
    totals.force = sum;
  }
}

template <int Dim>
std::vector<Real> ImplicitSolver<Dim>::load_factors(Real t) const {
  std::vector<Real> factors;
  for (const LoadSpec& spec : case_.loads) factors.push_back(case_.load_factor(spec, t));
  return factors;
}

/// By the trapezoidal rule, on the step's background at both ends.
template <int Dim>
Vec3 ImplicitSolver<Dim>::book_loads(Real t, Real dt, const StepLoad<Dim>& load, const std::vector<Real>& u) {
  Vec3 sum{};
  load_work_at_start_ = 0;
  const std::vector<Real> zero(u.size(), 0);
  const std::vector<Real> before = load_factors(t);
  for (std::size_t l = 0; l < loads_.size(); ++l) {
    const std::vector<Real> start = point_loads_.nodal_forces(l, zero, before), end = point_loads_.nodal_forces(l, u, load.factors);
    Vec3 force{};
    Real work = 0;
    for (std::size_t k = 0; k < u.size(); ++k) {
      force[k % Dim] += end[k];
      load_work_at_start_ += 0.5 * start[k] * u[k];
      work += 0.5 * (start[k] + end[k]) * u[k];
    }
    BoundaryTotals& totals = loads_[l];
    totals.work += work;
    ledger_.body_force_work += work;
    for (std::size_t d = 0; d < Dim; ++d) {
      if (spec_.mode == ImplicitMode::dynamic) totals.impulse[d] += dt * ((1 - spec_.gamma) * totals.force[d] + spec_.gamma * force[d]);
      sum[d] += force[d];
    }
    totals.force = force;
  }
  return sum;
}

/// The ledger, with the same weights in time as the particles' velocities: momentum closes to rounding.
template <int Dim>
void ImplicitSolver<Dim>::book(Real t, Real dt, const StepLoad<Dim>& load, const std::vector<Real>& u, const std::vector<Vec<Dim>>& du,
                               const Vec3& reaction) {
  Vec3 gravity_force{};
  Vec3 body_force = book_loads(t, dt, load, u);
  for (std::size_t k = 0; k < load.nodal_force.size(); ++k) body_force[k % Dim] += load.nodal_force[k];
  if (!load.nodal_force.empty()) {
    traction_work_.advance(space_, load.nodal_force, u);
    ledger_.body_force_work += traction_work_.start() + traction_work_.end();
  }
  if (spec_.soft_stiffness[0] > 0 || spec_.soft_stiffness[1] > 0 || spec_.surface_penalty > 0) {
    std::vector<Real> soft;
    assembly_.soft_force(u, soft);
    soft_work_.advance(space_, soft, u);
    ledger_.soft_dissipation += soft_work_.start() + soft_work_.end();
  }
  space_.for_each_point([&](std::size_t source, std::size_t p, std::size_t k) {
    const Real ratio = sources_[source].fem != nullptr ? sources_[source].fem->weight_ratio() : 1;
    const Real mass = sources_[source].points->mass[p];
    for (std::size_t d = 0; d < Dim; ++d) {
      gravity_force[d] += mass * ratio * load.gravity[d];
      if (load.body_force.empty()) continue;
      const Real force = mass * (load.b(source, ratio, p, d) - ratio * load.gravity[d]);
      body_force[d] += force;
      ledger_.body_force_work += force * du[k][d];
    }
  });
  if (spec_.mode != ImplicitMode::dynamic) return;
  const auto impulse = [&](Vec3& sum, Vec3& old, const Vec3& now) {
    for (std::size_t d = 0; d < Dim; ++d) sum[d] += dt * ((1 - spec_.gamma) * old[d] + spec_.gamma * now[d]);
    old = now;
  };
  std::copy_n(load.gravity.begin(), Dim, acceleration_gravity_.begin());
  impulse(ledger_.gravity_impulse, gravity_force_, gravity_force);
  impulse(ledger_.body_force_impulse, body_force_force_, body_force);
  impulse(ledger_.boundary_impulse, reaction_, reaction);
}

/// What the forces at the start of the step do on this step's background. They balanced on that of the last step, and where they do not on
/// this one, energy is lost or made.
template <int Dim>
void ImplicitSolver<Dim>::book_forces_at_start(Real dt, const StepLoad<Dim>& load, const std::vector<Real>& u,
                                               const std::vector<Vec<Dim>>& du) {
  const auto work = assembly_.stress_work(u, dt);
  ledger_.receding_work += 0.5 * (work.correction_start + work.correction_end);
  if (spec_.mode != ImplicitMode::dynamic) return;
  Real unbalanced = 0.5 * work.start + contact_.work_at_start() + sides_.work_at_start(u) + soft_work_.start() - work_at_start_ -
                    traction_work_.start() - load_work_at_start_;
  space_.for_each_point([&](std::size_t source, std::size_t p, std::size_t k) {
    const PointBody<Dim>& body = *sources_[source].points;
    const Real ratio = sources_[source].fem != nullptr ? sources_[source].fem->weight_ratio() : 1;
    for (std::size_t d = 0; d < Dim; ++d) {
      const Real b = load.b(source, ratio, p, d) + ratio * (gravity_[d] - load.gravity[d]);
      unbalanced += 0.5 * body.mass[p] * (body.acceleration[p][d] - b) * du[k][d];
    }
  });
  ledger_.reset_loss -= unbalanced;
}

/// Where gravity changes, so does the gravitational energy: work of the load, at the middle of the step's way as the trapezoidal rule has
/// it.
template <int Dim>
void ImplicitSolver<Dim>::change_gravity(const Vec3& gravity, const std::vector<Vec<Dim>>& du) {
  if (gravity == gravity_) return;
  space_.for_each_point([&](std::size_t source, std::size_t p, std::size_t k) {
    const Real ratio = sources_[source].fem != nullptr ? sources_[source].fem->weight_ratio() : 1;
    const PointBody<Dim>& body = *sources_[source].points;
    for (std::size_t d = 0; d < Dim; ++d)
      ledger_.body_force_work -= body.mass[p] * ratio * (gravity[d] - gravity_[d]) * (body.position[p][d] - 0.5 * du[k][d]);
  });
  gravity_ = gravity;
}

/// Nodes of a side hold the bodies whose nodes they are. A body of elements that comes from elsewhere has none there, and would pass.
template <int Dim>
void ImplicitSolver<Dim>::check_sides(std::size_t source) const {
  if (space_.moves_basis() || case_.grid.is_mapped()) return;
  const PointBody<Dim>& body = *sources_[source].points;
  for (const BoundarySpec& boundary : case_.boundaries) {
    if (boundary.region || boundary.kind == BoundaryKind::traction || boundary.touches_by_particles()) continue;
    const BoundarySide side = side_of(boundary.side);
    const auto axis = static_cast<std::size_t>(side.axis);
    const Real place = side.is_upper ? case_.grid.upper[axis] : case_.grid.lower[axis];
    for (std::size_t p = 0; p < static_cast<std::size_t>(body.count()); ++p) {
      const Real beyond = (side.is_upper ? 1 : -1) * (body.position[p][axis] - place);
      if (beyond <= sources_[source].depth(p)) continue;
      const std::vector<Index> held = basis_->side_nodes(boundary.side);
      const FemBody<Dim>& fem = *sources_[source].fem;
      if (std::any_of(held.begin(), held.end(), [&](Index node) { return fem.has_node(node); })) break;  // it may swing past its clamp
      throw SolverError(
          "t = {:.8g} s: body \"{}\" of elements has passed the {} side at ({:.6g}), which holds only nodes that lie on it at the start; "
          "give this boundary contact = \"no_tension\"",
          time_, body.name(), boundary.side, fmt::join(body.position[p], ", "));
    }
  }
}

template <int Dim>
void ImplicitSolver<Dim>::find_escapes() {
  escapes_.clear();
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    escaped_rows_[s].clear();
    if (sources_[s].fem != nullptr) {
      check_sides(s);
      continue;
    }
    const PointBody<Dim>& body = *sources_[s].points;
    for (std::size_t p = 0; p < static_cast<std::size_t>(body.count()); ++p) {
      // On a background that moves the search is dear; a particle that jumped over a cell is found by the next step.
      if (reset_ && !space_.is_at_border(s, p)) continue;
      if (space_.find(s, p)) continue;
      Escape escape{s, body.id[p], {}, {}};
      std::copy_n(body.position[p].begin(), Dim, escape.position.begin());
      std::copy_n(body.velocity[p].begin(), Dim, escape.velocity.begin());
      escapes_.push_back(escape);
      escaped_rows_[s].push_back(static_cast<Index>(p));
    }
  }
}

template <int Dim>
void ImplicitSolver<Dim>::remove_escaped() {
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    if (escaped_rows_[s].empty()) continue;
    PointBody<Dim>& body = *sources_[s].points;
    // The sums behind the next impulses are those of the particles that stay. What held the others is booked with the conditions.
    for (const Index row : escaped_rows_[s]) {
      const auto p = static_cast<std::size_t>(row);
      for (std::size_t d = 0; d < Dim; ++d) {
        const Real weight = body.mass[p] * acceleration_gravity_[d];
        gravity_force_[d] -= weight;
        reaction_[d] -= body.mass[p] * body.acceleration[p][d] - weight;
      }
    }
    body.remove(escaped_rows_[s], gravity_, ledger_);
    space_.forget(s, escaped_rows_[s]);
    escaped_rows_[s].clear();
  }
  const std::vector<Real> factors = load_factors(time_);
  for (std::size_t l = 0; l < loads_.size(); ++l) {
    const Vec3 left = point_loads_.resultant(l, factors[l]);
    for (std::size_t d = 0; d < Dim; ++d) {
      body_force_force_[d] += left[d] - loads_[l].force[d];
      reaction_[d] -= left[d] - loads_[l].force[d];
    }
    loads_[l].force = left;
  }
  escapes_.clear();
  const Real before = ledger_.contact_energy;
  measure_contact();
  ledger_.removed_energy += before - ledger_.contact_energy;
}

template <int Dim>
void ImplicitSolver<Dim>::measure_contact() {
  if (!contact_.has_pairs() && sides_.is_empty()) return;
  space_.update(time_);
  contact_.start();
  contact_.measure_energy();
  sides_.start_step(std::vector<Vec<Dim>>(case_.boundaries.size(), Vec<Dim>{}));
  sides_.start();
  sides_.measure_energy(std::vector<Real>(space_.nodes().size() * Dim, 0));
  ledger_.contact_energy = contact_.energy() + sides_.energy();
}

template <int Dim>
void ImplicitSolver<Dim>::declare_state(State& state) {
  state.in("body", [&] {
    for (const PointSource<Dim>& source : sources_) {
      if (source.fem != nullptr)
        state.part(source.points->name(), *source.fem);
      else
        state.part(source.points->name(), *source.points);
    }
  });
  state.part("space", space_);
  if (!state.is_changed()) {
    state.part("faces", contacts_);
    state.part("sides", sides_);
    state.parts("boundary", boundaries_);
  }
  state.part("contact", contact_);
  state.parts("pair", pairs_);
  state.parts("load", loads_);
  state.part("traction_work", traction_work_);
  state.part("soft_work", soft_work_);
  state.add("time", time_);
  if (!state.is_changed()) {
    state.part("ledger", ledger_);
    state.add("gravity", gravity_);
  }
  state.add("has_acceleration", has_acceleration_);
  state.add("has_pressed", has_pressed_);
  state.add("acceleration_gravity", acceleration_gravity_);
  state.add("gravity_force", gravity_force_);
  state.add("body_force_force", body_force_force_);
  state.add("reaction", reaction_);
  // What the rule of the next step goes by.
  state.add("newton_iterations", iterations_);
  state.add("step_cuts", cuts_);
  if (reset_) {
    std::vector<Vec<Dim>> nodes;
    for (Index n = 0; n < basis_->node_count(); ++n) nodes.push_back(basis_->node_position(n));
    state.add("background_nodes", nodes);
    if (static_cast<Index>(nodes.size()) != basis_->node_count()) state.fail("background_nodes", "has not one row for each node");
    if (state.is_loading()) basis_->set_nodes(std::move(nodes));
  }
  if (!state.is_loading()) return;
  find_escapes();
  if (!state.is_changed()) return;
  gravity_ = case_.gravity_at(time_);
  measure_contact();
}

template <int Dim>
std::vector<std::string> ImplicitSolver<Dim>::field_names(std::size_t body) const {
  return sources_[body].points->field_names();
}

template <int Dim>
std::vector<std::string> ImplicitSolver<Dim>::node_field_names(std::size_t body) const {
  return sources_[body].fem != nullptr ? sources_[body].fem->node_field_names() : std::vector<std::string>{};
}

template <int Dim>
Field ImplicitSolver<Dim>::node_field(std::size_t body, const std::string& name) const {
  return sources_[body].fem != nullptr ? sources_[body].fem->node_field(name, body) : Solver::node_field(body, name);
}

template <int Dim>
void ImplicitSolver<Dim>::set_field(std::size_t s, const std::string& name, const std::vector<Real>& values) {
  PointBody<Dim>& body = *sources_[s].points;
  if (sources_[s].fem != nullptr) {
    throw InputError("body \"{}\": {} cannot be assigned: it is a body of elements, whose state is at its nodes", body.name(), name);
  }
  if (name == "position" && values.size() == body.position.size() * Dim) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      const std::size_t d = i % Dim;
      if (values[i] >= case_.grid.lower[d] && values[i] <= case_.grid.upper[d]) continue;
      throw InputError("body \"{}\": position of particle row {} is outside of the grid: {} = {}, allowed: {} to {}", body.name(), i / Dim,
                       "xyz"[d], values[i], case_.grid.lower[d], case_.grid.upper[d]);
    }
  }
  if (name == "position" && values.size() == body.position.size() * Dim && case_.grid.is_mapped()) {
    for (std::size_t p = 0; p < body.position.size(); ++p) {
      Vec<Dim> x;
      std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(p * Dim), Dim, x.begin());
      if (basis_->locate(x)) continue;
      throw InputError("body \"{}\": position of particle row {} is outside of the {}: ({:.6g})", body.name(), p, case_.grid.map_name(),
                       fmt::join(x, ", "));
    }
  }
  body.set_field(name, values);
  measure_contact();
}

template <int Dim>
Index ImplicitSolver<Dim>::memory() const {
  const Index functions = space_.functions();
  const Index per_particle = functions * (1 + Dim) * static_cast<Index>(sizeof(Real));
  Index bytes = assembly_.matrix().nonZeros() * static_cast<Index>(sizeof(Real) + sizeof(int));
  for (const PointSource<Dim>& source : sources_) bytes += source.points->memory() + source.points->count() * per_particle;
  return bytes;
}

template <int Dim>
Occupancy ImplicitSolver<Dim>::occupancy() const {
  Occupancy sum;
  for (const PointSource<Dim>& source : sources_) {
    sum.lanes += source.points->count();
    sum.state_bytes += source.points->memory();
  }
  return sum;
}

template <int Dim>
std::vector<StepNumber> ImplicitSolver<Dim>::step_numbers() const {
  return {{"newton_iterations", "1", static_cast<Real>(iterations_)},
          {"linear_iterations", "1", static_cast<Real>(linear_iterations_)},
          {"step_cuts", "1", static_cast<Real>(cuts_)},
          {"residual", "N", newton_.report().residuals.empty() ? 0 : newton_.report().residuals.back()},
          {"pivot_ratio", "1", newton_.report().pivot_ratio},
          {"active_unknowns", "1", static_cast<Real>(space_.unknown_count())},
          {"receding_particles", "1", static_cast<Real>(space_.receding_count())},
          {"penetrated_particles", "1", static_cast<Real>(space_.penetrated_count())},
          {"contact_sets", "1", static_cast<Real>(contacts_.sets())},
          {"contact_nodes", "1", static_cast<Real>(contacts_.held())},
          {"contact_slipping", "1", static_cast<Real>(contacts_.slipping())},
          {"contact_unsettled", "1", static_cast<Real>(contacts_.unsettled())},
          {"soft_dissipation", "J", ledger_.soft_dissipation},
          {"receding_work", "J", ledger_.receding_work},
          {"integrator_loss", "J", ledger_.integrator_loss},
          {"reset_loss", "J", ledger_.reset_loss},
          {"step_seconds", "s", step_seconds_}};
}

template <int Dim>
std::vector<std::string> ImplicitSolver<Dim>::warnings() const {
  // Elements integrate products of quadratic gradients with what particles they have; splines are smoother and content with fewer.
  const Index enough = spec_.basis == BasisKind::element ? (spec_.element_order == 2 ? 25 : 9) * (Dim == 3 ? 3 : 1) : whole_power(2, Dim);
  Index few = 0, all = 0;
  Index least = std::numeric_limits<Index>::max();
  for (std::size_t c = 0, next = 0; c < space_.cells().size(); c = next) {
    ++all;
    for (next = c + 1; next < space_.cells().size() && space_.is_again(next);) ++next;
    if (space_.is_fem(c)) continue;
    if (space_.soft_factor(c) > 0 && (spec_.soft_stiffness[0] > 0 || spec_.soft_stiffness[1] > 0)) continue;  // at the body's surface
    const Index count = space_.cell_end(next - 1) - space_.cell_begin(c);
    if (count >= enough) continue;
    ++few;
    least = std::min(least, count);
  }
  std::vector<std::string> found;
  if (spec_.mode == ImplicitMode::dynamic && particles_.size() > 1 && !contact_.has_pairs()) {
    found.push_back(
        "bodies of particles share one field of displacements in the implicit solver: where they meet, they stick to each other; for "
        "contact between them take solver.contact = \"pairs\"");
  }
  const bool may_recede =
      std::any_of(fem_bodies_.begin(), fem_bodies_.end(), [](const FemBody<Dim>& fem) { return fem.receding_correction() > 0; });
  if (spec_.mode == ImplicitMode::dynamic && space_.moves_basis() && !may_recede) {
    found.push_back(
        "particles share the nodes of the bodies of elements: where they meet, they stick to each other; for contact between them take "
        "solver.contact = \"pairs\" with element_order = 1");
  }
  // By what CHOLMOD took for 74,052 unknowns of B-splines (docs/large_problems.md).
  constexpr int k_many = 50'000;
  if (Dim == 3 && space_.unknown_count() >= k_many && factorizes_large(spec_.linear_solver)) {
    const Real times = space_.unknown_count() / 74052.0;
    found.push_back(fmt::format(
        "{} unknowns in 3D: a factorisation takes some {:.2g} GB, and {:.2g} minutes for each of Newton's iterations; "
        "linear_solver = \"cg\" takes less of both, and multigrid, which a program with PETSc has (-DMATPOINT_MPI=ON), far less",
        space_.unknown_count(), 3.1 * std::pow(times, 4.0 / 3), 1.4 * times * times));
  }
  if (few == 0) return found;
  found.push_back(fmt::format(
      "{} of {} cells inside the body have fewer than {} particles (the poorest {}): too few to integrate the functions of a cell; "
      "take a finer layout or larger cells",
      few, all, enough, least));
  return found;
}

template class NodalWork<2>;
template class NodalWork<3>;
template class ImplicitSolver<2>;
template class ImplicitSolver<3>;

}  // namespace matpoint
