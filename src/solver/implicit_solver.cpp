#include "solver/implicit_solver.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <chrono>
#include <cmath>

#include "body/particle_fields.hpp"

namespace matpoint {
namespace {

template <int Dim>
std::unique_ptr<Basis<Dim>> make_basis(const Case& problem) {
  if (problem.implicit.basis == BasisKind::element) return make_element_basis<Dim>(problem.grid, problem.implicit.element_order);
  return make_spline_basis<Dim>(problem.grid);
}

template <int Dim>
SeedingGrid seeding_grid(const GridSpec& grid) {
  SeedingGrid box{Dim, grid.lower, grid.upper, {}};
  for (std::size_t d = 0; d < Dim; ++d) box.cell_size[d] = grid.cell_size[d] * std::ldexp(1, -grid.refinements);
  return box;
}

}  // namespace

template <int Dim>
ImplicitSolver<Dim>::ImplicitSolver(const Case& problem)
    : case_(problem),
      spec_(problem.implicit),
      basis_(make_basis<Dim>(problem)),
      body_(problem.bodies.front(), seeding_grid<Dim>(problem.grid)),
      conditions_(problem.boundaries, *basis_),
      space_(*basis_, conditions_, spec_.soft_stiffness),
      assembly_(body_, space_),
      newton_(spec_, space_, assembly_, profile_),
      gravity_(problem.gravity_at(0)) {
  geometry_.lower = problem.grid.lower;
  for (std::size_t d = 0; d < Dim; ++d) {
    geometry_.cell_size[d] = problem.grid.cell_size[d] * std::ldexp(1, -problem.grid.refinements);
    geometry_.nodes[d] = problem.grid.cells[d] * (1 << problem.grid.refinements) + 1;
  }
  space_.update(body_, 0);
  if (spec_.mode == ImplicitMode::quasi_static) check_support();
}

/// A static problem needs supports against every rigid motion of the body: each motion must move some prescribed component. Counted by the
/// rank of what the prescribed components see of the motions.
template <int Dim>
void ImplicitSolver<Dim>::check_support() const {
  constexpr int k_motions = Dim == 2 ? 3 : 6;
  Eigen::Matrix<Real, k_motions, k_motions> seen = Eigen::Matrix<Real, k_motions, k_motions>::Zero();
  Vec3 center{};
  Vec3 size{};
  for (std::size_t d = 0; d < Dim; ++d) {
    center[d] = 0.5 * (case_.grid.lower[d] + case_.grid.upper[d]);
    size[d] = 0.5 * (case_.grid.upper[d] - case_.grid.lower[d]);
  }
  const Real length = *std::max_element(size.begin(), size.end());
  for (std::size_t n = 0; n < space_.nodes().size(); ++n) {
    const Vec<Dim> position = basis_->node_position(space_.nodes()[n]);
    Vec3 x{};
    for (std::size_t d = 0; d < Dim; ++d) x[d] = (position[d] - center[d]) / length;
    for (int component = 0; component < Dim; ++component) {
      if (space_.unknown(static_cast<Index>(n), component) >= 0) continue;
      Eigen::Matrix<Real, k_motions, 1> row = Eigen::Matrix<Real, k_motions, 1>::Zero();
      row[component] = 1;
      // Rotation about the axis r moves the point by e_r x (x - center).
      for (int r = 0; r < k_motions - Dim; ++r) {
        const int axis = Dim == 2 ? 2 : r;
        const int next = (axis + 1) % 3;
        const int after = (axis + 2) % 3;
        if (component == next) row[Dim + r] = -x[static_cast<std::size_t>(after)];
        if (component == after) row[Dim + r] = x[static_cast<std::size_t>(next)];
      }
      seen += row * row.transpose();
    }
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<Real, k_motions, k_motions>> modes(seen);
  if (modes.eigenvalues()[0] > 1e-10 * std::max(Real{1}, modes.eigenvalues()[k_motions - 1])) return;
  const Eigen::Matrix<Real, k_motions, 1> free = modes.eigenvectors().col(0);
  int largest = 0;
  free.cwiseAbs().maxCoeff(&largest);
  const std::string motion = largest < Dim ? fmt::format("move along {}", "xyz"[largest]) : std::string("turn");
  throw InputError(
      "{}: nothing holds the body, it is free to {}, so mode = \"static\" has no solution; add a [[boundary]] on a side that the "
      "body touches, or use mode = \"dynamic\"",
      place_of(case_.bodies.front()), motion);
}

template <int Dim>
void ImplicitSolver<Dim>::step(Real t, Real dt) {
  const auto start = std::chrono::steady_clock::now();
  iterations_ = 0;
  cuts_ = 0;
  if (!has_acceleration_ && spec_.mode == ImplicitMode::dynamic) {
    if (spec_.initial_acceleration == InitialAcceleration::consistent) set_initial_acceleration(t, dt);
    has_acceleration_ = true;
  }
  advance(t, dt, 0);
  {
    Stage stage(profile_, "check");
    find_escapes();
  }
  step_seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

template <int Dim>
void ImplicitSolver<Dim>::advance(Real t, Real dt, int cuts) {
  cuts_ = std::max(cuts_, cuts);
  const std::optional<std::string> failure = try_step(t, dt);
  if (!failure) return;
  if (cuts == spec_.step_cuts_max) {
    throw SolverError("t = {:.8g} s: Newton's method failed also with the step cut to {:.4g} s ({} times in half): {}", t, dt, cuts,
                      *failure);
  }
  advance(t, dt / 2, cuts + 1);
  find_escapes();
  if (!escapes_.empty()) return;  // the rest of the step is lost with them; the policy is the simulation's
  advance(t + dt / 2, dt / 2, cuts + 1);
}

template <int Dim>
std::optional<std::string> ImplicitSolver<Dim>::try_step(Real t, Real dt) {
  {
    Stage stage(profile_, "locate");
    space_.update(body_, t);
    assembly_.start();
    if (assembly_.is_new_pattern()) newton_.forget_pattern();
  }
  const StepLoad<Dim> load = make_load(t + dt, dt);
  std::vector<Real> u;
  std::vector<Real> prescribed(space_.nodes().size() * Dim, 0);
  const std::vector<Vec<Dim>> displacements = conditions_.displacements(t, dt);
  for (std::size_t n = 0; n < space_.nodes().size(); ++n) {
    for (int d = 0; d < Dim; ++d) {
      const auto s = static_cast<std::size_t>(d);
      const int condition = conditions_.condition(space_.nodes()[n], d);
      if (condition >= 0) prescribed[n * Dim + s] = displacements[static_cast<std::size_t>(condition)][s];
    }
  }
  const bool is_symmetric = space_.receding_count() == 0 && !body_.material().is_rate_dependent();
  const auto failure = newton_.solve(load, std::move(prescribed), is_symmetric ? Symmetry::symmetric : Symmetry::general, u);
  iterations_ += newton_.report().iterations;
  if (failure) return failure;
  Stage stage(profile_, "update");
  commit(t, dt, load, u);
  return std::nullopt;
}

template <int Dim>
StepInertia ImplicitSolver<Dim>::newmark(Real dt) const {
  if (spec_.mode == ImplicitMode::quasi_static) return {};
  return {1 / (spec_.beta * dt * dt), 1 / (spec_.beta * dt), (1 - 2 * spec_.beta) / (2 * spec_.beta)};
}

template <int Dim>
StepLoad<Dim> ImplicitSolver<Dim>::make_load(Real t_end, Real dt) {
  StepLoad<Dim> load;
  load.dt = dt;
  load.inertia = newmark(dt);
  const Vec3 gravity = case_.gravity_at(t_end);
  std::copy_n(gravity.begin(), Dim, load.gravity.begin());
  if (case_.body_force) {
    std::vector<Real> positions;
    for (const Vec<Dim>& x : body_.position) positions.insert(positions.end(), x.begin(), x.end());
    body_force_values_.resize(positions.size());
    case_.body_force->at(t_end, positions, body_force_values_);
    load.body_force = body_force_values_.data();
  }
  return load;
}

/// Accelerations at the start from the forces there: M a = f. The mass matrix of particles as quadrature points may be singular, where a
/// node sees few of them; a step that is short beside the first one adds just enough stiffness.
template <int Dim>
void ImplicitSolver<Dim>::set_initial_acceleration(Real t, Real dt) {
  constexpr Real k_short = 1e-3;
  Stage stage(profile_, "start");
  space_.update(body_, t);
  assembly_.start();
  StepLoad<Dim> load = make_load(t, dt);
  const Real factor = newmark(k_short * dt).u;
  load.inertia = {factor, 0, 0};
  const std::vector<Real> zero(space_.nodes().size() * Dim, 0);
  std::vector<Real> residual;
  Lift lift;
  assembly_.residual_and_matrix(zero, load, residual, lift);
  if (assembly_.is_new_pattern()) newton_.forget_pattern();
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
  Vec3 gravity_force{};
  for (std::size_t k = 0; k < a.size(); ++k) {
    const auto p = static_cast<std::size_t>(space_.particles()[k]);
    body_.acceleration[p] = a[k];
    for (std::size_t d = 0; d < Dim; ++d) {
      total[d] += body_.mass[p] * a[k][d];
      gravity_force[d] += body_.mass[p] * load.gravity[d];
      if (load.body_force != nullptr) body_force_force_[d] += body_.mass[p] * load.body_force[p * Dim + d];
    }
  }
  gravity_force_ = gravity_force;
  std::copy_n(load.gravity.begin(), Dim, acceleration_gravity_.begin());
  for (std::size_t d = 0; d < Dim; ++d) reaction_[d] = total[d] - gravity_force[d] - body_force_force_[d];
}

template <int Dim>
void ImplicitSolver<Dim>::commit(Real t, Real dt, const StepLoad<Dim>& load, const std::vector<Real>& u) {
  std::vector<Real> residual;
  assembly_.residual(u, load, residual);
  newton_.report_residual(newton_.unknown_norm(residual));
  std::vector<Real> A;
  std::vector<Vec<Dim>> du;
  assembly_.deform(u, A, du);
  const auto n = du.size();
  // The law once more where it leaves something behind: its history, and a stress that does not follow from F.
  if (!body_.history.empty() || !body_.tau.empty()) {
    const auto history_size = static_cast<std::size_t>(body_.material().history_size());
    Real S[Dim * Dim];
    std::vector<Real> new_history(history_size);
    for (std::size_t k = 0; k < n; ++k) {
      const auto p = static_cast<std::size_t>(space_.particles()[k]);
      Real dissipation = 0;
      TangentPoints point;
      point.count = 1;
      point.dt = dt;
      point.A = A.data() + k * Dim * Dim;
      point.F = body_.F.data() + p * Dim * Dim;
      point.history = body_.history.data() + p * history_size;
      point.S = S;
      point.new_history = new_history.data();
      point.tau = body_.tau.empty() ? nullptr : body_.tau.data() + 6 * p;
      point.dissipation_rate = &dissipation;
      assembly_.law()(body_.material().law_data(), point);
      std::copy(new_history.begin(), new_history.end(), body_.history.begin() + static_cast<std::ptrdiff_t>(p * history_size));
      ledger_.viscous_dissipation += dt * dissipation * body_.volume0[p];
    }
  }
  const bool is_dynamic = spec_.mode == ImplicitMode::dynamic;
  for (std::size_t k = 0; k < n; ++k) {
    const auto p = static_cast<std::size_t>(space_.particles()[k]);
    Real F[Dim * Dim];
    std::copy_n(body_.F.data() + p * Dim * Dim, Dim * Dim, F);
    for (std::size_t i = 0; i < Dim; ++i) {
      for (std::size_t j = 0; j < Dim; ++j) {
        Real sum = 0;
        for (std::size_t e = 0; e < Dim; ++e) sum += A[(k * Dim + i) * Dim + e] * F[e * Dim + j];
        body_.F[(p * Dim + i) * Dim + j] = sum;
      }
    }
    for (std::size_t d = 0; d < Dim; ++d) {
      if (is_dynamic) {
        Real& v = body_.velocity[p][d];
        Real& a = body_.acceleration[p][d];
        const Real a_new = load.inertia.u * du[k][d] - load.inertia.v * v - load.inertia.a * a;
        v += dt * ((1 - spec_.gamma) * a + spec_.gamma * a_new);
        a = a_new;
      }
      body_.position[p][d] += du[k][d];
    }
  }
  book(t + dt, dt, load, u, residual);
}

/// The ledger, with the same weights in time as the particles' velocities: momentum closes to rounding. The residual at prescribed
/// components is the force with which they act on the body.
template <int Dim>
void ImplicitSolver<Dim>::book(Real t_end, Real dt, const StepLoad<Dim>& load, const std::vector<Real>& u,
                               const std::vector<Real>& residual) {
  Vec3 reaction{};
  for (std::size_t n = 0; n < space_.nodes().size(); ++n) {
    for (int d = 0; d < Dim; ++d) {
      if (space_.unknown(static_cast<Index>(n), d) >= 0) continue;
      const auto s = static_cast<std::size_t>(d);
      reaction[s] += residual[n * Dim + s];
      ledger_.boundary_work += residual[n * Dim + s] * u[n * Dim + s];
    }
  }
  Vec3 gravity_force{};
  Vec3 body_force{};
  for (std::size_t p = 0; p < static_cast<std::size_t>(body_.count()); ++p) {
    for (std::size_t d = 0; d < Dim; ++d) {
      gravity_force[d] += body_.mass[p] * load.gravity[d];
      if (load.body_force != nullptr) body_force[d] += body_.mass[p] * load.body_force[p * Dim + d];
    }
  }
  if (load.body_force != nullptr) {
    std::vector<Real> A;
    std::vector<Vec<Dim>> du;
    assembly_.deform(u, A, du);
    for (std::size_t k = 0; k < du.size(); ++k) {
      const auto p = static_cast<std::size_t>(space_.particles()[k]);
      for (std::size_t d = 0; d < Dim; ++d) ledger_.body_force_work += body_.mass[p] * load.body_force[p * Dim + d] * du[k][d];
    }
  }
  if (spec_.mode == ImplicitMode::dynamic) {
    const auto impulse = [&](Vec3& sum, Vec3& old, const Vec3& now) {
      for (std::size_t d = 0; d < Dim; ++d) sum[d] += dt * ((1 - spec_.gamma) * old[d] + spec_.gamma * now[d]);
      old = now;
    };
    std::copy_n(load.gravity.begin(), Dim, acceleration_gravity_.begin());
    impulse(ledger_.gravity_impulse, gravity_force_, gravity_force);
    impulse(ledger_.body_force_impulse, body_force_force_, body_force);
    impulse(ledger_.boundary_impulse, reaction_, reaction);
  }
  change_gravity(case_.gravity_at(t_end), u);
}

/// Where gravity changes, so does the gravitational energy: work of the load, at the middle of the step's way as the trapezoidal rule has
/// it.
template <int Dim>
void ImplicitSolver<Dim>::change_gravity(const Vec3& gravity, const std::vector<Real>& u) {
  if (gravity == gravity_) return;
  std::vector<Real> A;
  std::vector<Vec<Dim>> du;
  assembly_.deform(u, A, du);
  for (std::size_t k = 0; k < du.size(); ++k) {
    const auto p = static_cast<std::size_t>(space_.particles()[k]);
    for (std::size_t d = 0; d < Dim; ++d)
      ledger_.body_force_work -= body_.mass[p] * (gravity[d] - gravity_[d]) * (body_.position[p][d] - 0.5 * du[k][d]);
  }
  gravity_ = gravity;
}

template <int Dim>
void ImplicitSolver<Dim>::find_escapes() {
  escapes_.clear();
  escaped_rows_.clear();
  for (std::size_t p = 0; p < static_cast<std::size_t>(body_.count()); ++p) {
    if (basis_->locate(body_.position[p])) continue;
    Escape escape{0, body_.id[p], {}, {}};
    std::copy_n(body_.position[p].begin(), Dim, escape.position.begin());
    std::copy_n(body_.velocity[p].begin(), Dim, escape.velocity.begin());
    escapes_.push_back(escape);
    escaped_rows_.push_back(static_cast<Index>(p));
  }
}

template <int Dim>
void ImplicitSolver<Dim>::remove_escaped() {
  // The sums behind the next impulses are those of the particles that stay. What held the others is booked with the conditions.
  for (const Index row : escaped_rows_) {
    const auto p = static_cast<std::size_t>(row);
    for (std::size_t d = 0; d < Dim; ++d) {
      const Real weight = body_.mass[p] * acceleration_gravity_[d];
      gravity_force_[d] -= weight;
      reaction_[d] -= body_.mass[p] * body_.acceleration[p][d] - weight;
    }
  }
  body_.remove(escaped_rows_, gravity_, ledger_);
  escapes_.clear();
  escaped_rows_.clear();
}

template <int Dim>
std::vector<std::string> ImplicitSolver<Dim>::field_names(std::size_t) const {
  return particle_field_names();
}

template <int Dim>
void ImplicitSolver<Dim>::set_field(std::size_t, const std::string& name, const std::vector<Real>& values) {
  if (name == "position" && values.size() == body_.position.size() * Dim) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      const std::size_t d = i % Dim;
      if (values[i] >= case_.grid.lower[d] && values[i] <= case_.grid.upper[d]) continue;
      throw InputError("body \"{}\": position of particle row {} is outside of the grid: {} = {}, allowed: {} to {}", body_.name(), i / Dim,
                       "xyz"[d], values[i], case_.grid.lower[d], case_.grid.upper[d]);
    }
  }
  body_.set_field(name, values);
}

template <int Dim>
Index ImplicitSolver<Dim>::memory() const {
  const Index functions = space_.functions();
  const Index per_particle = functions * (1 + Dim) * static_cast<Index>(sizeof(Real));
  return body_.memory() + body_.count() * per_particle + assembly_.matrix().nonZeros() * static_cast<Index>(sizeof(Real) + sizeof(int));
}

template <int Dim>
Occupancy ImplicitSolver<Dim>::occupancy() const {
  return {body_.count(), 0, body_.memory()};
}

template <int Dim>
std::vector<StepNumber> ImplicitSolver<Dim>::step_numbers() const {
  return {{"newton_iterations", "1", static_cast<Real>(iterations_)},
          {"step_cuts", "1", static_cast<Real>(cuts_)},
          {"residual", "N", newton_.report().residuals.empty() ? 0 : newton_.report().residuals.back()},
          {"active_unknowns", "1", static_cast<Real>(space_.unknown_count())},
          {"receding_particles", "1", static_cast<Real>(space_.receding_count())},
          {"step_seconds", "s", step_seconds_}};
}

template <int Dim>
std::vector<std::string> ImplicitSolver<Dim>::warnings() const {
  // Elements integrate products of quadratic gradients with what particles they have; splines are smoother and content with fewer.
  const Index enough = spec_.basis == BasisKind::element ? (spec_.element_order == 2 ? 25 : 9) * (Dim == 3 ? 3 : 1) : whole_power(2, Dim);
  Index few = 0;
  Index least = body_.count();
  for (std::size_t c = 0; c < space_.cells().size(); ++c) {
    if (space_.soft_factor(c) > 0 && (spec_.soft_stiffness[0] > 0 || spec_.soft_stiffness[1] > 0)) continue;  // at the body's surface
    const Index count = space_.cell_end(c) - space_.cell_begin(c);
    if (count >= enough) continue;
    ++few;
    least = std::min(least, count);
  }
  if (few == 0) return {};
  return {fmt::format(
      "{} of {} cells inside the body have fewer than {} particles (the poorest {}): too few to integrate the functions of a cell; "
      "take a finer layout or larger cells",
      few, space_.cells().size(), enough, least)};
}

std::unique_ptr<Solver> make_implicit_solver(const Case& problem) {
  if (problem.dim == 3) return std::make_unique<ImplicitSolver<3>>(problem);
  return std::make_unique<ImplicitSolver<2>>(problem);
}

template class ImplicitSolver<2>;
template class ImplicitSolver<3>;

}  // namespace matpoint
