#include "solver/explicit_solver.hpp"

#include <algorithm>
#include <cmath>
#include <new>

#include "body/particle_body.hpp"

namespace matpoint {

template <int Dim>
ExplicitSolver<Dim>::ExplicitSolver(const Case& problem)
    : gravity_(problem.gravity),
      stress_order_(problem.solver.stress_order),
      grid_(problem.grid),
      geometry_(grid_.geometry()),
      boundary_conditions_(problem.boundaries, grid_) {
  const TransferTable<Dim>& transfer = transfer_table_linear<Dim>();
  Real smallest_mass = std::numeric_limits<Real>::infinity();
  for (const BodySpec& spec : problem.bodies) {
    bodies_.push_back(std::make_unique<ParticleBody<Dim>>(spec, grid_, transfer));
    smallest_mass = std::min(smallest_mass, bodies_.back()->smallest_particle_mass());
  }
  std::copy_n(problem.gravity.begin(), Dim, dynamics_.gravity.begin());
  dynamics_.damping = problem.solver.damping;
  dynamics_.flip = problem.solver.flip;
  dynamics_.mass_cutoff = problem.solver.mass_cutoff.value_or(problem.solver.mass_cutoff_relative * smallest_mass);
  is_band_occupied_.resize(static_cast<std::size_t>(grid_.band_count()));
}

// USL: stress last, from the velocities that moved the particles (Sulsky, Chen & Schreyer 1994, as in the thesis by Kamuth).
// USF: stress first, from the velocities at the start of the step (Bardenhagen 2002).
// MUSL: stress last, from the particles' new velocities mapped to the grid once more (Sulsky, Zhou & Schreyer 1995).
template <int Dim>
void ExplicitSolver<Dim>::step(Real t, Real dt) {
  const bool is_usf = stress_order_ == StressOrder::usf;
  const bool is_musl = stress_order_ == StressOrder::musl;
  {
    Stage stage(profile_, "locate");
    std::fill(is_band_occupied_.begin(), is_band_occupied_.end(), char{0});
    for (auto& body : bodies_) body->locate(grid_, is_band_occupied_);
  }
  if (is_usf) {
    map(Map::momentum);
    {
      Stage stage(profile_, "grid");
      grid_.compute_velocity(dynamics_);
      boundary_conditions_.constrain_velocity(grid_, t);
    }
    gather(Gather::gradient, dt);
  }
  map(Map::momentum_and_force);
  {
    Stage stage(profile_, "grid");
    grid_.advance_velocity(dynamics_, dt, ledger_);
    boundary_conditions_.constrain(grid_, dynamics_, t + dt, dt, ledger_);
  }
  if (is_musl) {
    gather(Gather::velocity_displacement, dt);
    map(Map::momentum);
    {
      Stage stage(profile_, "grid");
      grid_.compute_velocity(dynamics_);
      boundary_conditions_.constrain_velocity(grid_, t + dt);
    }
    gather(Gather::gradient_move, dt);
  } else {
    gather(is_usf ? Gather::velocity_move : Gather::all, dt);
  }
  {
    Stage stage(profile_, "check");
    for (std::size_t d = 0; d < Dim; ++d) {
      for (auto& body : bodies_) ledger_.gravity_impulse[d] += body->mass() * dynamics_.gravity[d] * dt;
    }
    for (auto& body : bodies_) ledger_.viscous_dissipation += body->viscous_dissipation();
    check_state(t + dt);
  }
}

template <int Dim>
void ExplicitSolver<Dim>::map(Map what) {
  Stage stage(profile_, "p2g");
  grid_.clear(is_band_occupied_);
  for (auto& body : bodies_) body->p2g(grid_, what);
  grid_.fold_periodic();
}

template <int Dim>
void ExplicitSolver<Dim>::gather(Gather what, Real dt) {
  Stage stage(profile_, "g2p, stress");
  for (auto& body : bodies_) body->g2p(grid_, what, dt, dynamics_.flip);
}

template <int Dim>
void ExplicitSolver<Dim>::check_state(Real t) {
  escapes_.clear();
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    bodies_[b]->append_escapes(grid_, b, escapes_);
  }
  const auto coordinates = [](const Vec3& x) { return fmt::format("({})", fmt::join(x.begin(), x.begin() + Dim, ", ")); };
  for (const Escape& escape : escapes_) {
    if (!std::all_of(escape.position.begin(), escape.position.end(), [](Real x) { return std::isfinite(x); })) {
      throw SolverError("t = {:.8g} s: the state is no longer finite: particle {} of body \"{}\" is at {}; the time step is probably too large",
                        t, escape.id, bodies_[escape.body]->name(), coordinates(escape.position));
    }
  }
  for (auto& body : bodies_) {
    const BadPoint bad = body->bad_point();
    if (bad.id < 0) continue;
    throw SolverError("t = {:.8g} s: det F = {:.6g} of particle {} of body \"{}\" at {} is not positive: the material is turned inside out; "
                      "a smaller time step, stress_order = \"musl\" or a stiffer law may help",
                      t, bad.J, bad.id, body->name(), coordinates(bad.position));
  }
}

template <int Dim>
Real ExplicitSolver<Dim>::stable_dt() const {
  Real dt = std::numeric_limits<Real>::infinity();
  for (const auto& body : bodies_) dt = std::min(dt, body->stable_dt(grid_));
  const Real wall_speed = boundary_conditions_.greatest_speed();
  for (int d = 0; d < Dim && wall_speed > 0; ++d) dt = std::min(dt, grid_.view().cell_size[d] / wall_speed);
  return dt;
}

template <int Dim>
void ExplicitSolver<Dim>::remove_escaped() {
  for (auto& body : bodies_) body->remove_escaped(grid_, gravity_, ledger_);
  escapes_.clear();
}

template <int Dim>
std::vector<Field> ExplicitSolver<Dim>::grid_fields() const {
  Field mass{"mass", "kg", 1, {}};
  Field velocity{"velocity", "m/s", Dim, {}};
  for (Index node = 0; node < grid_.node_count(); ++node) {
    const bool is_active = grid_.is_row_active(node);
    mass.values.push_back(is_active ? grid_.mapped(node)[0] : 0);
    for (int d = 0; d < Dim; ++d) velocity.values.push_back(is_active ? grid_.motion(node)[d] : 0);
  }
  return {mass, velocity};
}

template <int Dim>
Index ExplicitSolver<Dim>::memory() const {
  Index bytes = grid_.memory();
  for (const auto& body : bodies_) bytes += body->memory();
  return bytes;
}

std::unique_ptr<Solver> make_solver(const Case& problem) {
  try {
    if (problem.dim == 3) return std::make_unique<ExplicitSolver<3>>(problem);
    return std::make_unique<ExplicitSolver<2>>(problem);
  } catch (const std::bad_alloc&) {
    throw InputError("the case does not fit into this machine's memory; `matpoint check` says how many particles and nodes it has");
  }
}

template class ExplicitSolver<2>;
template class ExplicitSolver<3>;

}  // namespace matpoint
