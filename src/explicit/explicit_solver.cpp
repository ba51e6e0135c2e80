#include "explicit/explicit_solver.hpp"

#include <algorithm>
#include <cmath>

#include "body/fill_body.hpp"
#include "body/particle_body.hpp"

namespace matpoint {

namespace {

template <int Dim, class R>
std::vector<std::unique_ptr<Grid<Dim, R>>> make_grids(const Case& problem) {
  std::vector<std::unique_ptr<Grid<Dim, R>>> grids;
  const std::size_t count = problem.solver.contact != ContactMethod::single_field ? problem.bodies.size() : 1;
  for (std::size_t g = 0; g < count; ++g) grids.push_back(std::make_unique<Grid<Dim, R>>(problem.grid, problem.solver.shape));
  return grids;
}

/// The boxes around surfaces that hold more than the component across them for good.
template <int Dim>
std::vector<Extent<Dim>> boxes_that_hold(const Case& problem) {
  std::vector<Extent<Dim>> boxes;
  for (const BoundarySpec& spec : problem.boundaries) {
    if (spec.kind == BoundaryKind::slip || spec.kind == BoundaryKind::traction || spec.contact != FaceContact::stick) continue;
    Extent<Dim> box;
    const Vec3 lower = spec.region ? spec.region->lower() : problem.grid.lower,
               upper = spec.region ? spec.region->upper() : problem.grid.upper;
    std::copy_n(lower.begin(), Dim, box.lower.begin());
    std::copy_n(upper.begin(), Dim, box.upper.begin());
    if (!spec.region) {
      const BoundarySide side = side_of(spec.side);
      if (spec.components.size() == 1 && spec.components[0] == std::string(1, "xyz"[side.axis])) continue;
      const auto axis = static_cast<std::size_t>(side.axis);
      (side.is_upper ? box.lower : box.upper)[axis] = side.is_upper ? box.upper[axis] : box.lower[axis];
    }
    boxes.push_back(box);
  }
  return boxes;
}

/// Whether two boxes are nearer to each other than `margin` in each direction.
template <int Dim>
bool is_near(const Extent<Dim>& a, const Extent<Dim>& b, const Vec3& margin) {
  for (std::size_t d = 0; d < Dim; ++d) {
    if (a.lower[d] > b.upper[d] + margin[d] || b.lower[d] > a.upper[d] + margin[d]) return false;
  }
  return true;
}

}  // namespace

template <int Dim, class R>
ExplicitSolver<Dim, R>::ExplicitSolver(const Case& problem)
    : gravity_(problem.gravity_at(0)),
      body_force_(problem.body_force),
      stress_order_(problem.solver.stress_order),
      fmpm_order_(problem.solver.transfer == Transfer::fmpm ? problem.solver.fmpm_order : 1),
      kernels_(kernel_table<Dim, R>()),
      grids_(make_grids<Dim, R>(problem)),
      geometry_(grids_[0]->geometry()),
      boundary_conditions_(problem.boundaries, *grids_[0]) {
  if (!problem.gravity_times.empty() || !problem.base_acceleration_times.empty())
    gravity_at_ = [problem](Real t) { return problem.gravity_at(t); };
  for (const std::string& name : boundary_names(problem.boundaries)) boundaries_.push_back({name, {}, {}, 0});
  for (auto& grid : grids_) {
    grid->set_boundary_conditions(&boundary_conditions_);
    grid->set_refined(fmpm_order_ > 1);
  }
  Real smallest_mass = std::numeric_limits<Real>::infinity();
  const bool has_particle_force = body_force_ && body_force_->is_of_particles;
  for (const BodySpec& spec : problem.bodies) {
    const bool is_rigid_turn =
        problem.solver.co_rotating.value_or(false) && !spec.material->is_fluid() && spec.formulation == Formulation::updated;
    const ParticleScheme scheme{problem.solver.shape,         problem.solver.transfer,
                                has_particle_force,           problem.solver.fluid_correction.value_or(false),
                                problem.grid.is_axisymmetric, is_rigid_turn};
    Grid<Dim, R>& grid = *grids_[std::min(bodies_.size(), grids_.size() - 1)];
    bodies_.push_back(std::make_unique<ParticleBody<Dim, R>>(spec, scheme, grid));
    smallest_mass = std::min(smallest_mass, bodies_.back()->smallest_particle_mass());
  }
  std::copy_n(gravity_.begin(), Dim, dynamics_.gravity.begin());
  dynamics_.damping = problem.solver.damping;
  dynamics_.flip = problem.solver.transfer == Transfer::flip ? problem.solver.flip : 0;
  // Of less than this share of a particle a node's f / m overflows sooner or later, and its own share of a motion is far below rounding.
  constexpr Real k_lightest = sizeof(R) == 8 ? 1e-200 : 1e-24;
  dynamics_.mass_cutoff =
      std::max(problem.solver.mass_cutoff.value_or(problem.solver.mass_cutoff_relative * smallest_mass), k_lightest * smallest_mass);
  check_cutoff(problem.solver, smallest_mass);
  std::vector<const Body<Dim>*> bodies;
  for (const auto& body : bodies_) bodies.push_back(body.get());
  if (!problem.tools.empty()) {
    tools_ = std::make_unique<Tools<Dim>>(problem, bodies);
    renew_tools();
  }
  if (problem.solver.contact == ContactMethod::pairs) {
    pairs_ = std::make_unique<PairContact<Dim>>(problem, std::move(bodies));
    update_pairs(0);
  } else if (problem.solver.contact == ContactMethod::multi_field) {
    std::vector<Grid<Dim, R>*> grids;
    for (const auto& grid : grids_) grids.push_back(grid.get());
    contact_ = std::make_unique<Contact<Dim, R>>(std::move(grids), std::move(bodies), boundary_conditions_, problem.solver.friction);
  }
  const std::vector<Obstacle> obstacles = boundary_conditions_.obstacles(0);
  for (auto& body : bodies_) {
    body->note_inside(obstacles);
    has_obstacles_ = has_obstacles_ || (body->is_fluid() && !obstacles.empty());
  }
  holds_ = boxes_that_hold<Dim>(problem);
  if (!problem.loads.empty()) {
    std::vector<Body<Dim>*> loaded;
    for (const auto& body : bodies_) loaded.push_back(body.get());
    loads_ = std::make_unique<AppliedLoads<Dim>>(problem, seeding_grid(*grids_[0], problem.grid.is_axisymmetric), std::move(loaded));
  }
  if (problem.solver.fluid_correction.value_or(false)) {
    const bool has_filter = problem.solver.transfer == Transfer::flip && problem.solver.flip == 1;
    correction_ = std::make_unique<FluidCorrection<Dim, R>>(has_filter, *grids_[0], boundary_conditions_, bodies_);
    if (tools_) correction_->set_rigid([this](const Vec3& x) { return tools_->distance(x); });
  }
  if (body_force_ && !has_particle_force) {
    constexpr Index k_nodes_max = 50'000'000;
    if (node_count() > k_nodes_max) {
      throw InputError("body_force: it is kept for all nodes of the grid, {} of them; at most {} are possible, so take larger cells",
                       node_count(), k_nodes_max);
    }
    for (auto& grid : grids_) grid->set_body_force(&body_force_values_);
    update_body_force(0);
  }
}

template <int Dim, class R>
void ExplicitSolver<Dim, R>::find_held() {
  const bool shares_grid = grids_.size() == 1;
  if (std::none_of(bodies_.begin(), bodies_.end(), [](const auto& body) { return body->is_co_rotating(); })) return;
  std::vector<Extent<Dim>> boxes;
  for (const auto& body : bodies_) boxes.push_back(body->extent());
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (!bodies_[b]->is_co_rotating()) continue;
    bool is_held = std::any_of(holds_.begin(), holds_.end(), [&](const auto& box) { return is_near(boxes[b], box, geometry_.cell_size); });
    for (std::size_t other = 0; other < bodies_.size() && shares_grid; ++other)
      is_held = is_held || (other != b && is_near(boxes[b], boxes[other], geometry_.cell_size));
    bodies_[b]->set_held(is_held);
  }
}

template <int Dim, class R>
void ExplicitSolver<Dim, R>::update_pairs(Real dt) {
  if (!pairs_) return;
  Stage stage(profile_, "contact");
  pairs_->update(dt);
  ledger_.contact_dissipation += pairs_->dissipated();
  take_contact_energy();
}

template <int Dim, class R>
void ExplicitSolver<Dim, R>::take_contact_energy() {
  ledger_.contact_energy = (pairs_ ? pairs_->energy() : 0) + (tools_ ? tools_->energy() : 0);
}

/// After particles were moved or taken away other than by steps.
template <int Dim, class R>
void ExplicitSolver<Dim, R>::renew_tools() {
  if (!tools_) return;
  tools_->update(0, 0, ledger_);
  take_contact_energy();
}

template <int Dim, class R>
void ExplicitSolver<Dim, R>::move_tools(Real t, Real dt) {
  if (!tools_) return;
  Stage stage(profile_, "tools");
  tools_->advance(t, dt, gravity_);
  tools_->update(dt, dt, ledger_);
  take_contact_energy();
}

// To what the sweep has mapped, and not as a body force of the particles, which the fused sweeps would take to the nodes from one step
// before: a lag makes the energy of stiff contact grow.
template <int Dim, class R>
void ExplicitSolver<Dim, R>::add_contact_forces() {
  if (!pairs_ && !tools_) return;
  Stage stage(profile_, "contact");
  const auto add = [&](std::size_t b, const ParticleForces<Dim>& forces) {
    if (!forces.ids.empty()) bodies_[b]->add_forces(forces.values, forces.ids, forces.box);
  };
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (pairs_) add(b, pairs_->forces(b));
    if (tools_) add(b, tools_->forces(b));
  }
}

template <int Dim, class R>
void ExplicitSolver<Dim, R>::update_body_force(Real t) {
  if (!body_force_ || body_force_->is_of_particles || (body_force_->is_constant && !body_force_values_.empty())) return;
  body_force_values_.resize(static_cast<std::size_t>(node_count()) * Dim);
  if (node_positions_.empty()) node_positions_ = grids_[0]->node_positions();
  body_force_->at(t, node_positions_, body_force_values_);
  grids_[0]->copy_periodic(body_force_values_);
}

template <int Dim, class R>
void ExplicitSolver<Dim, R>::update_particle_forces(Real t) {
  if (!body_force_ || !body_force_->is_of_particles) return;
  particle_forces_.resize(bodies_.size());
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const std::vector<Real> positions = bodies_[b]->field("position", b).values;
    particle_forces_[b].assign(positions.size(), 0);
    body_force_->at(t, positions, particle_forces_[b]);
    bodies_[b]->set_body_force(particle_forces_[b]);
  }
}

template <int Dim, class R>
void ExplicitSolver<Dim, R>::book_particle_forces(const std::vector<std::vector<Real>>& forces, Real dt) {
  for (std::size_t b = 0; b < forces.size(); ++b) {
    Vec3 force;
    ledger_.body_force_work += 0.5 * dt * bodies_[b]->body_force_power(forces[b], force);
    for (std::size_t d = 0; d < 3; ++d) ledger_.body_force_impulse[d] += 0.5 * dt * force[d];
  }
}

/// Where gravity changes, so does the gravitational energy of a body that stands still: work of the load.
template <int Dim, class R>
void ExplicitSolver<Dim, R>::update_gravity(Real t) {
  if (!gravity_at_) return;
  const Vec3 gravity = gravity_at_(t);
  if (gravity == gravity_) return;
  for (const auto& body : bodies_)
    ledger_.body_force_work += body->totals(gravity).gravitational_energy - body->totals(gravity_).gravitational_energy;
  gravity_ = gravity;
  std::copy_n(gravity.begin(), Dim, dynamics_.gravity.begin());
}

template <int Dim, class R>
void ExplicitSolver<Dim, R>::set_field(std::size_t body, const std::string& name, const std::vector<Real>& values) {
  bodies_[body]->set_field(name, values);
  is_mapped_ = false;  // the grid holds what the particles were
  if (loads_) loads_->forget();
  renew_tools();
  if (!pairs_) return;
  pairs_->forget_places();
  update_pairs(0);
}

template <int Dim, class R>
void ExplicitSolver<Dim, R>::declare_state(State& state) {
  if (state.is_loading()) {
    for (auto& body : bodies_) body->clear();
    for (auto& grid : grids_) grid->remove_tiles();
    ledger_.boundaries.clear();  // of a step that failed
  }
  state.in("body", [&] {
    for (auto& body : bodies_) state.part(body->name(), *body);
  });
  for (std::size_t g = 0; g < grids_.size() && !state.is_changed(); ++g)
    state.part(grids_.size() == 1 ? "grid" : "grid_of_" + bodies_[g]->name(), *grids_[g]);
  if (contact_ && !state.is_changed()) state.part("contact", *contact_);
  if (pairs_) state.part("pairs", *pairs_);
  if (tools_) state.part("tools", *tools_);
  if (correction_) state.part("fluid_correction", *correction_);
  state.add("time", time_);
  if (!state.is_changed()) {
    state.part("ledger", ledger_);
    state.parts("boundary", boundaries_);
    if (loads_) state.part("loads", *loads_);
    state.add("gravity", gravity_);
  }
  state.add("is_mapped", is_mapped_);
  state.in("body_force", [&] {
    particle_forces_.resize(body_force_ && body_force_->is_of_particles ? bodies_.size() : 0);
    for (std::size_t b = 0; b < particle_forces_.size(); ++b) state.add(bodies_[b]->name(), particle_forces_[b]);
  });
  if (!state.is_loading()) return;
  if (state.is_changed()) {
    is_mapped_ = false;
    if (gravity_at_) gravity_ = gravity_at_(time_);
    update_pairs(0);
  }
  std::copy_n(gravity_.begin(), Dim, dynamics_.gravity.begin());
  escapes_.clear();
  for (std::size_t b = 0; b < bodies_.size(); ++b) bodies_[b]->append_escapes(b, escapes_);
}

template <int Dim, class R>
void ExplicitSolver<Dim, R>::check_cutoff(const SolverSpec& spec, Real smallest_mass) const {
  Real total_mass = 0;
  for (const auto& body : bodies_) total_mass += body->mass();
  if (dynamics_.mass_cutoff <= total_mass) return;
  const std::string key = spec.mass_cutoff
                              ? fmt::format("mass_cutoff = {} kg", *spec.mass_cutoff)
                              : fmt::format("mass_cutoff_relative = {} ({:.6g} kg)", spec.mass_cutoff_relative, dynamics_.mass_cutoff);
  throw InputError(
      "{}{}solver: {} is more than all bodies weigh, {:.6g} kg: no node would ever move; the smallest particle has {:.6g} kg, "
      "and the cutoff should be far below that",
      spec.mass_cutoff_place, spec.mass_cutoff_place.empty() ? "" : ": ", key, total_mass, smallest_mass);
}

// USL: stress last, from the velocities that moved the particles (Sulsky, Chen & Schreyer 1994, as in the thesis by Kamuth).
// USF: stress first, from the velocities at the start of the step (Bardenhagen 2002).
// MUSL: stress last, from the particles' new velocities mapped to the grid once more (Sulsky, Zhou & Schreyer 1995).
//
// The particles are mapped to the grid by the sweep that moved them, in the step before; start() does it for the first step. The nodes
// are worked by the sweep, too, tile by tile, before it needs them: start_pass() says how.
template <int Dim, class R>
void ExplicitSolver<Dim, R>::step(Real t, Real dt) {
  update_body_force(t);
  update_gravity(t);
  find_held();
  if (!is_mapped_) start();
  if (loads_) {
    if (!loads_->is_current()) loads_->evaluate(t);
    loads_->start_work();
    if (stress_order_ != StressOrder::usf) loads_->book_impulse(dt, ledger_);
    load_time_ = stress_order_ == StressOrder::usf ? t : t + dt;
  }
  // The stress order decides when forces are mapped: at the start of a step, or at the end of the one before.
  if (stress_order_ == StressOrder::usf) update_particle_forces(t);
  const std::vector<std::vector<Real>> particle_forces = particle_forces_;
  book_particle_forces(particle_forces, dt);
  if (stress_order_ != StressOrder::usf) update_particle_forces(t + dt);
  // What leaves the grid in this step has been pulled for the whole of it.
  for (auto& body : bodies_) {
    for (std::size_t d = 0; d < Dim; ++d) ledger_.gravity_impulse[d] += body->mass() * dynamics_.gravity[d] * dt;
  }
  using Pass = typename Grid<Dim, R>::NodePass;
  if (stress_order_ == StressOrder::usf) {
    start_pass(Pass::velocity_keep, t, dt);
    sweep("stress, p2g", Sweep::usf_stress, dt);
    if (loads_) loads_->book_impulse(dt, ledger_);
    add_contact_forces();
    start_pass(Pass::advance, t + dt, dt);
    refine(t + dt, dt);
    sweep("g2p, p2g", Sweep::usf_velocity, dt);
  } else if (stress_order_ == StressOrder::musl) {
    start_pass(Pass::advance_keep, t + dt, dt);
    refine(t + dt, dt);
    sweep("g2p, p2g", Sweep::musl_velocity, dt);
    start_pass(Pass::velocity, t + dt, dt);
    sweep("gradient, stress, p2g", Sweep::musl_gradient, dt);
  } else {
    start_pass(Pass::advance, t + dt, dt);
    refine(t + dt, dt);
    sweep("g2p, stress, p2g", Sweep::usl, dt);
  }
  update_pairs(dt);
  move_tools(t, dt);
  if (stress_order_ != StressOrder::usf) add_contact_forces();
  book_particle_forces(particle_forces, dt);
  if (loads_) {
    Stage stage(profile_, "loads");
    if (stress_order_ == StressOrder::usf) loads_->evaluate(t + dt);  // the others have done so for the next step
    loads_->book_work(ledger_);
  }
  {
    Stage stage(profile_, "check");
    for (auto& body : bodies_) {
      ledger_.viscous_dissipation += body->viscous_dissipation();
      ledger_.plastic_dissipation += body->plastic_dissipation();
    }
    check_state(t + dt);
  }
  if (correction_ && correction_->is_due(dt)) {
    Stage stage(profile_, "correction");
    correction_->apply(gravity_, ledger_);
    is_mapped_ = false;
  }
  take_boundaries(dt);
  time_ = t + dt;
}

/// What the books have of single boundaries is of this step.
template <int Dim, class R>
void ExplicitSolver<Dim, R>::take_boundaries(Real dt) {
  ledger_.boundaries.resize(boundaries_.size());
  for (std::size_t c = 0; c < boundaries_.size(); ++c) {
    const BoundaryShare& share = ledger_.boundaries[c];
    for (std::size_t d = 0; d < 3; ++d) {
      boundaries_[c].force[d] = share.impulse[d] / dt;
      boundaries_[c].impulse[d] += share.impulse[d];
    }
    boundaries_[c].work += share.work;
  }
  std::fill(ledger_.boundaries.begin(), ledger_.boundaries.end(), BoundaryShare{});
}

template <int Dim, class R>
void ExplicitSolver<Dim, R>::measure_gaps() {
  Stage stage(profile_, "contact");
  for (std::size_t g = 0; g < grids_.size(); ++g) {
    std::vector<const Body<Dim>*> bodies;
    for (std::size_t b = 0; b < bodies_.size(); ++b) {
      if (grids_.size() == 1 || b == g) bodies.push_back(bodies_[b].get());
    }
    boundary_conditions_.measure_gaps(*grids_[g], [&](const TileNodes<Dim>& nodes, int axis, bool is_upper, std::vector<Real>& gaps) {
      for (const Body<Dim>* body : bodies) body->measure_gaps(nodes, axis, is_upper, gaps);
    });
  }
}

template <int Dim, class R>
void ExplicitSolver<Dim, R>::refine(Real t, Real dt) {
  for (int term = 1; term < fmpm_order_; ++term) {
    sweep("refine", Sweep::refine, dt);
    start_pass(Grid<Dim, R>::NodePass::refine, t, dt);
  }
}

template <int Dim, class R>
void ExplicitSolver<Dim, R>::start() {
  for (auto& grid : grids_) grid->clear();
  update_particle_forces(time_);
  load_time_ = time_;
  start_pass(Grid<Dim, R>::NodePass::velocity_keep, time_, 0);
  sweep("start", stress_order_ == StressOrder::usf ? Sweep::start_momentum : Sweep::start, 0);
  if (stress_order_ != StressOrder::usf) add_contact_forces();
  is_mapped_ = true;
}

template <int Dim, class R>
void ExplicitSolver<Dim, R>::start_pass(typename Grid<Dim, R>::NodePass pass, Real t, Real dt) {
  using Pass = typename Grid<Dim, R>::NodePass;
  if (pass == Pass::advance || pass == Pass::advance_keep) measure_gaps();
  for (auto& grid : grids_) grid->start_pass(pass, kernels_, dynamics_, t, dt);
  if (!contact_) return;
  Stage stage(profile_, "contact");
  if (pass == Pass::advance || pass == Pass::advance_keep)
    contact_->apply(dynamics_.mass_cutoff, dt, ledger_);
  else if (pass == Pass::velocity || pass == Pass::velocity_keep)
    contact_->apply_second();
}

template <int Dim, class R>
std::vector<BoundaryTotals> ExplicitSolver<Dim, R>::boundaries() const {
  std::vector<BoundaryTotals> all = boundaries_;
  if (tools_) all.insert(all.end(), tools_->totals().begin(), tools_->totals().end());
  if (loads_) all.insert(all.end(), loads_->totals().begin(), loads_->totals().end());
  return all;
}

template <int Dim, class R>
std::vector<Field> ExplicitSolver<Dim, R>::grid_fields() const {
  std::vector<Field> sum = grids_[0]->fields();
  if (grids_.size() == 1) return sum;
  // Of all velocity fields: the mass, and the velocity of the centre of mass.
  std::vector<Real>& mass = sum[0].values;
  std::vector<Real>& momentum = sum[1].values;
  for (std::size_t k = 0; k < momentum.size(); ++k) momentum[k] *= mass[k / Dim];
  for (std::size_t g = 1; g < grids_.size(); ++g) {
    const std::vector<Field> one = grids_[g]->fields();
    for (std::size_t k = 0; k < momentum.size(); ++k) momentum[k] += one[0].values[k / Dim] * one[1].values[k];
    for (std::size_t n = 0; n < mass.size(); ++n) mass[n] += one[0].values[n];
  }
  for (std::size_t k = 0; k < momentum.size(); ++k) momentum[k] = mass[k / Dim] > 0 ? momentum[k] / mass[k / Dim] : 0;
  return sum;
}

template <int Dim, class R>
void ExplicitSolver<Dim, R>::sweep(const char* label, Sweep what, Real dt) {
  {
    Stage stage(profile_, label);
    for (auto& body : bodies_) body->sweep(what, dt, dynamics_.flip);
  }
  if (loads_ && what != Sweep::musl_velocity && what != Sweep::usf_velocity && what != Sweep::refine && what != Sweep::start_momentum) {
    Stage stage(profile_, "loads");
    loads_->evaluate(load_time_);
    loads_->add();
  }
  Stage stage(profile_, "grid");
  using Fold = typename Grid<Dim, R>::Fold;
  for (auto& grid : grids_) {
    grid->finish_pass(ledger_);
    // What earlier sweeps of the step have mapped is folded already.
    grid->fold_periodic(what == Sweep::usf_stress                               ? Fold::force
                        : what == Sweep::musl_velocity || what == Sweep::refine ? Fold::momentum
                                                                                : Fold::all);
  }
}

template <int Dim, class R>
void ExplicitSolver<Dim, R>::check_state(Real t) {
  escapes_.clear();
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    bodies_[b]->append_escapes(b, escapes_);
  }
  const auto coordinates = [](const Vec3& x) { return fmt::format("({:.6g})", fmt::join(x.begin(), x.begin() + Dim, ", ")); };
  for (const Escape& escape : escapes_) {
    if (!std::all_of(escape.position.begin(), escape.position.end(), [](Real x) { return std::isfinite(x); })) {
      throw ParticleError(
          fmt::format(
              "t = {:.8g} s: the state is no longer finite: particle {} of body \"{}\" is at {}; the time step is probably too large", t,
              escape.id, bodies_[escape.body]->name(), coordinates(escape.position)),
          escape.body, escape.id);
    }
  }
  if (!escapes_.empty()) return_escaped(t);
  if (has_obstacles_) keep_out(t);
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const BadPoint bad = bodies_[b]->bad_point();
    if (bad.id < 0) continue;
    throw ParticleError(
        fmt::format("t = {:.8g} s: det F = {:.6g} of particle {} of body \"{}\" at {} is not positive: the material is turned inside out; "
                    "a smaller time step, stress_order = \"musl\" or a stiffer law may help",
                    t, bad.J, bad.id, bodies_[b]->name(), coordinates(bad.position)),
        b, bad.id);
  }
}

/// No particle passes a side that holds it (put_back in particle_body.cpp says why one tries).
template <int Dim, class R>
void ExplicitSolver<Dim, R>::return_escaped(Real t) {
  const std::vector<ClosedSide> sides = boundary_conditions_.closed_sides(t);
  if (sides.empty()) return;
  const Index before = ledger_.returned_count;
  for (auto& body : bodies_) body->return_escaped(sides, gravity_, ledger_);
  if (ledger_.returned_count == before) return;
  is_mapped_ = false;  // the sweep that moved them has mapped the others
  escapes_.clear();
  for (std::size_t b = 0; b < bodies_.size(); ++b) bodies_[b]->append_escapes(b, escapes_);
}

template <int Dim, class R>
void ExplicitSolver<Dim, R>::keep_out(Real t) {
  const std::vector<Obstacle> obstacles = boundary_conditions_.obstacles(t);
  Index count = 0;
  for (auto& body : bodies_) count += body->keep_out(obstacles, gravity_, ledger_);
  if (count > 0) is_mapped_ = false;
}

template <int Dim, class R>
Real ExplicitSolver<Dim, R>::stable_dt() const {
  Real dt = std::numeric_limits<Real>::infinity();
  for (const auto& body : bodies_) dt = std::min(dt, body->stable_dt());
  const Real wall_speed = boundary_conditions_.greatest_speed(time_);
  for (int d = 0; d < Dim && wall_speed > 0; ++d) dt = std::min(dt, grids_[0]->cell_size(d) / wall_speed);
  if (pairs_) dt = std::min(dt, pairs_->stable_dt());
  if (tools_) dt = std::min(dt, tools_->stable_dt());
  return dt;
}

template <int Dim, class R>
void ExplicitSolver<Dim, R>::remove_escaped() {
  for (auto& body : bodies_) body->remove_escaped(gravity_, ledger_);
  escapes_.clear();
  if (loads_) loads_->forget();
  if (tools_) {
    is_mapped_ = false;
    const Real before = ledger_.contact_energy;
    renew_tools();
    ledger_.removed_energy += before - ledger_.contact_energy;
  }
  update_particle_forces(time_);
  if (!pairs_) return;
  // What is left must be mapped again, without the forces of those that were removed.
  is_mapped_ = false;
  pairs_->forget_places();
  const Real before = ledger_.contact_energy;
  update_pairs(0);
  ledger_.removed_energy += before - ledger_.contact_energy;
}

template <int Dim, class R>
Index ExplicitSolver<Dim, R>::memory() const {
  Index bytes = 0;
  for (const auto& grid : grids_) bytes += grid->memory();
  for (const auto& body : bodies_) bytes += body->memory();
  return bytes;
}

template <int Dim, class R>
Occupancy ExplicitSolver<Dim, R>::occupancy() const {
  Occupancy sum;
  for (const auto& body : bodies_) {
    const Occupancy one = body->occupancy();
    sum.lanes += one.lanes;
    sum.moved += one.moved;
    sum.state_bytes += one.state_bytes;
  }
  return sum;
}

std::unique_ptr<Solver> make_explicit_solver(const Case& problem) {
  const bool is_single = problem.solver.precision == "single";
  if (problem.dim == 3) {
    if (is_single) return std::make_unique<ExplicitSolver<3, float>>(problem);
    return std::make_unique<ExplicitSolver<3, double>>(problem);
  }
  if (is_single) return std::make_unique<ExplicitSolver<2, float>>(problem);
  return std::make_unique<ExplicitSolver<2, double>>(problem);
}

template class ExplicitSolver<2, double>;
template class ExplicitSolver<3, double>;
template class ExplicitSolver<2, float>;
template class ExplicitSolver<3, float>;

}  // namespace matpoint
