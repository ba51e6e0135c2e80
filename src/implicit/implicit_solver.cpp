#include "implicit/implicit_solver.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <numeric>

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
  SeedingGrid box{Dim, grid.lower, grid.upper, {}, false};
  for (std::size_t d = 0; d < Dim; ++d) box.cell_size[d] = grid.cell_size[d] * std::ldexp(1, -grid.refinements);
  return box;
}

/// Of a grid that is no box: whether all particles are in it.
template <int Dim>
void check_inside(const PointBody<Dim>& body, const Basis<Dim>& basis, const BodySpec& spec, const GridSpec& grid) {
  for (std::size_t p = 0; p < static_cast<std::size_t>(body.count()); ++p) {
    if (basis.locate(body.position[p])) continue;
    throw InputError("{}: particle {} at ({:.6g}) is outside of the {}; move the body or change the grid", place_of(spec), body.id[p],
                     fmt::join(body.position[p], ", "), grid.map_name());
  }
}

/// Whether a face of a body of elements carries the load of a condition.
template <int Dim>
bool is_loaded(const BoundarySpec& spec, const ElementFace& face, const Basis<Dim>& basis) {
  if (!spec.region) {
    const std::vector<ElementFace>& side = basis.side_faces(spec.side);
    return std::any_of(side.begin(), side.end(), [&](const ElementFace& one) {
      return one.element == face.element && one.axis == face.axis && one.is_upper == face.is_upper;
    });
  }
  const Real cell_size = basis.shortest_side(face.element);
  for (int corner = 0; corner < 1 << (Dim - 1); ++corner) {
    ElementPoint<Dim> point{face.element, {}};
    for (int d = 0, bit = 0; d < Dim; ++d)
      point.xi[static_cast<std::size_t>(d)] = d == face.axis ? (face.is_upper ? 1 : -1) : (corner >> bit++ & 1) != 0 ? 1 : -1;
    Vec3 x{};
    const Vec<Dim> position = basis.position(point);
    std::copy(position.begin(), position.end(), x.begin());
    if (!spec.region->reaches(x, node_tolerance(x, cell_size))) return false;
  }
  return true;
}

template <int Dim>
Vec<Dim> face_middle(const ElementFace& face, const Basis<Dim>& basis) {
  ElementPoint<Dim> point{face.element, {}};
  point.xi[static_cast<std::size_t>(face.axis)] = face.is_upper ? 1 : -1;
  return basis.position(point);
}

/// Adds int N t dA over a face, by node, by Gauss's rule with three points per direction.
template <int Dim>
void add_traction(const std::vector<Real>& traction, const ElementFace& face, const Basis<Dim>& basis, Vec<Dim>* forces) {
  const Real places[3] = {-std::sqrt(0.6), 0, std::sqrt(0.6)};
  const Real weights[3] = {5.0 / 9, 8.0 / 9, 5.0 / 9};
  std::vector<Real> N(static_cast<std::size_t>(basis.functions_per_cell()));
  std::vector<Real> gradients(N.size() * Dim);
  for (int k = 0; k < whole_power(3, Dim - 1); ++k) {
    ElementPoint<Dim> point{face.element, {}};
    Real weight = 1;
    Vec3 tangents[2] = {{0, 0, 1}, {0, 0, 1}};
    int tangent = 0;
    for (int d = 0, rest = k; d < Dim; ++d) {
      const auto s = static_cast<std::size_t>(d);
      if (d == face.axis) {
        point.xi[s] = face.is_upper ? 1 : -1;
        continue;
      }
      point.xi[s] = places[rest % 3];
      weight *= weights[rest % 3];
      rest /= 3;
    }
    // dx/dxi by central differences, which are exact for quadratic functions.
    for (int d = 0; d < Dim; ++d) {
      if (d == face.axis) continue;
      ElementPoint<Dim> before = point, after = point;
      before.xi[static_cast<std::size_t>(d)] -= 0.5;
      after.xi[static_cast<std::size_t>(d)] += 0.5;
      const Vec<Dim> a = basis.position(before), b = basis.position(after);
      Vec3 t{};
      for (std::size_t e = 0; e < Dim; ++e) t[e] = b[e] - a[e];
      tangents[tangent++] = t;
    }
    const Vec3& s = tangents[0];
    const Vec3& t = tangents[1];
    const Vec3 normal = {s[1] * t[2] - s[2] * t[1], s[2] * t[0] - s[0] * t[2], s[0] * t[1] - s[1] * t[0]};
    weight *= std::sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
    basis.evaluate(point, N.data(), gradients.data());
    for (std::size_t i = 0; i < N.size(); ++i) {
      Vec<Dim>& force = forces[basis.cell_nodes(face.element)[i]];
      for (std::size_t d = 0; d < Dim; ++d) force[d] += weight * N[i] * traction[d];
    }
  }
}

}  // namespace

template <int Dim>
ImplicitSolver<Dim>::ImplicitSolver(const Case& problem)
    : case_(problem),
      spec_(problem.implicit),
      basis_(make_basis<Dim>(problem)),
      conditions_(problem.boundaries, *basis_),
      space_(*basis_, conditions_, (make_bodies(), sources_), spec_.soft_stiffness, spec_.contact == ImplicitContact::pairs),
      contacts_(problem.boundaries, space_),
      contact_(problem, space_),
      sides_(problem, space_),
      point_loads_(problem, seeding_grid<Dim>(problem.grid), space_),
      assembly_(space_, contact_, sides_, point_loads_, spec_.basis == BasisKind::bspline ? 2 : 1,
                spec_.basis == BasisKind::bspline || spec_.element_order == 2, spec_.surface_penalty),
      newton_(spec_, space_, assembly_, profile_),
      gravity_(problem.gravity_at(0)) {
  geometry_.lower = problem.grid.lower;
  for (std::size_t d = 0; d < Dim; ++d) {
    geometry_.cell_size[d] = problem.grid.cell_size[d] * std::ldexp(1, -problem.grid.refinements);
    geometry_.nodes[d] = problem.grid.cells[d] * (1 << problem.grid.refinements) + 1;
  }
  make_tractions();
  for (const auto& [first, second] : contact_.pairs()) pairs_.push_back({{body_name(first) + "|" + body_name(second), {}, {}, 0}, {}, {}});
  for (const std::string& name : boundary_names(problem.boundaries)) boundaries_.push_back({{name, {}, {}, 0}, {}, {}});
  for (std::size_t k = 0; k < point_loads_.count(); ++k) loads_.push_back({point_loads_.name(k), {}, {}, 0});
  if (space_.moves_basis()) reset_ = std::make_unique<BackgroundReset<Dim>>(*basis_, conditions_, space_);
  escaped_rows_.resize(sources_.size());
  space_.update(0);
  measure_contact();
  if (spec_.mode == ImplicitMode::quasi_static) check_support();
  if (spec_.mode == ImplicitMode::dynamic) balance_initial_stress();
}

template <int Dim>
void ImplicitSolver<Dim>::make_bodies() {
  for (const BodySpec& spec : case_.bodies) {
    if (spec.method == BodyMethod::elements) {
      fem_bodies_.emplace_back(spec, *basis_);
      sources_.push_back({&fem_bodies_.back().points(), &fem_bodies_.back(), spec.has_fbar()});
    } else {
      particles_.emplace_back(spec, seeding_grid<Dim>(case_.grid));
      sources_.push_back({&particles_.back(), nullptr, spec.has_fbar()});
      if (case_.grid.is_mapped()) check_inside(particles_.back(), *basis_, spec, case_.grid);
    }
  }
}

/// Dead loads: int N t dA over the undeformed faces of bodies of elements, on a side of the grid or with all their nodes in a region.
template <int Dim>
void ImplicitSolver<Dim>::make_tractions() {
  std::map<std::pair<Index, int>, std::size_t> loaded;  // face by its cell and number, and by which condition
  for (std::size_t b = 0; b < case_.boundaries.size(); ++b) {
    const BoundarySpec& spec = case_.boundaries[b];
    if (spec.kind != BoundaryKind::traction) continue;
    if (tractions_.empty()) tractions_.assign(static_cast<std::size_t>(space_.slot_count()), Vec<Dim>{});
    int faces = 0;
    for (std::size_t s = 0; s < sources_.size(); ++s) {
      if (sources_[s].fem == nullptr) continue;
      const FemBody<Dim>& body = *sources_[s].fem;
      for (const ElementFace& face : body.outer_faces(*basis_, space_.is_fem_cell())) {
        if (!is_loaded(spec, face, *basis_)) continue;
        ++faces;
        const auto [first, is_new] = loaded.try_emplace({face.element, 2 * face.axis + (face.is_upper ? 1 : 0)}, b);
        if (!is_new) {
          throw InputError(
              "{}boundary {}: the face of body \"{}\" at ({:.6g}) is loaded already by boundary {}; let each face have one traction",
              spec.place.empty() ? "" : spec.place + ": ", b + 1, body.points().name(), fmt::join(face_middle(face, *basis_), ", "),
              first->second + 1);
        }
        add_traction<Dim>(spec.traction, face, *basis_, tractions_.data() + space_.slot(space_.field_of(s), 0));
      }
    }
    if (faces > 0) continue;
    throw InputError("{}boundary {}: kind = \"traction\" loads faces of bodies of elements, and there is none {}",
                     spec.place.empty() ? "" : spec.place + ": ", b + 1, spec.region ? "with all its nodes in the region" : "on this side");
  }
}

template <int Dim>
Vec3 ImplicitSolver<Dim>::gravity_on(std::size_t body) const {
  const Real ratio = sources_[body].fem != nullptr ? sources_[body].fem->weight_ratio() : 1;
  return {ratio * gravity_[0], ratio * gravity_[1], ratio * gravity_[2]};
}

template <int Dim>
void ImplicitSolver<Dim>::update_space(Real t) {
  Stage stage(profile_, "locate");
  if (reset_) basis_->set_nodes(reset_->positions(sources_));
  space_.update(t);
  contact_.start();
  sides_.start();
  assembly_.start();
}

/// Which part of the active nodes each belongs to: parts share no cell.
template <int Dim>
std::vector<int> parts_of_nodes(const StepSpace<Dim>& space) {
  std::vector<int> leader(space.nodes().size());
  std::iota(leader.begin(), leader.end(), 0);
  const auto find = [&](int n) {
    while (leader[static_cast<std::size_t>(n)] != n)
      n = leader[static_cast<std::size_t>(n)] = leader[static_cast<std::size_t>(leader[static_cast<std::size_t>(n)])];
    return n;
  };
  for (std::size_t c = 0; c < space.cells().size(); ++c) {
    const int first = find(space.cell_nodes(c)[0]);
    for (int i = 1; i < space.functions(); ++i) leader[static_cast<std::size_t>(find(space.cell_nodes(c)[i]))] = first;
  }
  for (std::size_t n = 0; n < leader.size(); ++n) leader[n] = find(static_cast<int>(n));
  return leader;
}

/// A static problem needs supports against every rigid motion of each part that hangs together: each motion must move some prescribed
/// component. Counted by the rank of what the prescribed components see of the motions.
template <int Dim>
void ImplicitSolver<Dim>::check_support() const {
  constexpr int k_motions = Dim == 2 ? 3 : 6;
  using Motions = Eigen::Matrix<Real, k_motions, k_motions>;
  std::map<int, Motions> seen_by_part;
  Vec3 center{};
  Vec3 size{};
  for (std::size_t d = 0; d < Dim; ++d) {
    center[d] = 0.5 * (case_.grid.lower[d] + case_.grid.upper[d]);
    size[d] = 0.5 * (case_.grid.upper[d] - case_.grid.lower[d]);
  }
  const Real length = *std::max_element(size.begin(), size.end());
  const std::vector<int> parts = parts_of_nodes(space_);
  // A component of a point that is held.
  const auto hold = [&](int part, const Vec<Dim>& position, int component) {
    Vec3 x{};
    for (std::size_t d = 0; d < Dim; ++d) x[d] = (position[d] - center[d]) / length;
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
    seen_by_part.at(part) += row * row.transpose();
  };
  for (std::size_t n = 0; n < space_.nodes().size(); ++n) {
    seen_by_part.try_emplace(parts[n], Motions::Zero());
    for (int component = 0; component < Dim; ++component) {
      if (space_.unknown(static_cast<Index>(n), component) < 0) hold(parts[n], basis_->node_position(space_.nodes()[n]), component);
    }
  }
  // What a side holds that lets go may hold, or not: then Newton's method says so.
  for (const auto& support : sides_.supports()) {
    for (int component = 0; component < Dim; ++component) {
      if (component == static_cast<int>(support.axis) || support.holds_along)
        hold(parts[static_cast<std::size_t>(space_.cell_nodes(support.cell)[0])], support.x, component);
    }
  }
  for (const auto& [part, seen] : seen_by_part) {
    const Eigen::SelfAdjointEigenSolver<Motions> modes(seen);
    if (modes.eigenvalues()[0] > 1e-10 * std::max(Real{1}, modes.eigenvalues()[k_motions - 1])) continue;
    const Eigen::Matrix<Real, k_motions, 1> free = modes.eigenvectors().col(0);
    int largest = 0;
    free.cwiseAbs().maxCoeff(&largest);
    const std::string motion = largest < Dim ? fmt::format("move along {}", "xyz"[largest]) : std::string("turn");
    std::size_t body = 0;
    for (std::size_t c = 0; c < space_.cells().size(); ++c) {
      if (parts[static_cast<std::size_t>(space_.cell_nodes(c)[0])] == part) body = space_.source_of(c);
    }
    throw InputError(
        "{}: nothing holds the body, it is free to {}{}, so mode = \"static\" has no solution; add a [[boundary]] on a side that the "
        "body touches, or use mode = \"dynamic\"",
        place_of(case_.bodies[body]), motion,
        contact_.has_pairs() ? " (contact, which may end, does not hold)"
        : sides_.is_empty()  ? ""
                             : " (a side that lets go holds what lies on it, half a particle's spacing away)");
  }
}

template <int Dim>
void ImplicitSolver<Dim>::step(Real t, Real dt) {
  const auto start = std::chrono::steady_clock::now();
  iterations_ = 0;
  linear_iterations_ = 0;
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
  update_space(t);
  StepLoad<Dim> load = make_load(t + dt, dt);
  const std::vector<Vec<Dim>> displacements = conditions_.displacements(t, dt);
  sides_.start_step(displacements);
  contacts_.start(space_);
  // Nodes of elements keep accelerations of their own from step to step, which what does not touch must not lose.
  const bool is_balanced = (!contacts_.is_empty() || ((contact_.is_near() || sides_.is_near()) && (!particles_.empty() || has_pressed_))) &&
                           spec_.mode == ImplicitMode::dynamic;
  const std::optional<StepStart> before = is_balanced ? std::optional<StepStart>(start_of_step()) : std::nullopt;
  std::vector<Real> u;
  std::optional<std::string> failure = settle(t, dt, load, displacements, is_balanced, u);
  // Each set has accelerations of its own, and now and then there is none in which no node pulls and none enters its face. One that pulls
  // for a step makes no energy, but no particle may leave for that.
  if (is_balanced && (failure || loses_particles(u))) {
    restore(*before);
    u.clear();
    failure = settle(t, dt, load, displacements, false, u);
  }
  if (failure) return failure;
  Stage stage(profile_, "update");
  commit(t, dt, load, u);
  return std::nullopt;
}

template <int Dim>
void ImplicitSolver<Dim>::take_contacts(StepLoad<Dim>& load, const std::vector<Vec<Dim>>& displacements) {
  space_.release(contacts_.released());
  assembly_.start();
  load.friction = contacts_.friction(space_, displacements);
}

template <int Dim>
std::optional<std::string> ImplicitSolver<Dim>::solve(Real t, const StepLoad<Dim>& load, const std::vector<Vec<Dim>>& displacements,
                                                      std::vector<Real>& u) {
  std::vector<Real> prescribed(space_.nodes().size() * Dim, 0);
  for (std::size_t n = 0; n < space_.nodes().size(); ++n) {
    for (int d = 0; d < Dim; ++d) {
      const auto s = static_cast<std::size_t>(d);
      const int condition = conditions_.condition(space_.nodes()[n], d);
      if (condition >= 0 && space_.unknown(static_cast<Index>(n), d) < 0) {
        const Vec<Dim> displacement = conditions_.is_by_place(condition)
                                          ? conditions_.displacement_by_place(condition, space_.place(n), t, load.dt)
                                          : displacements[static_cast<std::size_t>(condition)];
        prescribed[n * Dim + s] = displacement[s];
      }
    }
  }
  const bool is_symmetric =
      load.friction.empty() && space_.receding_count() == 0 && !point_loads_.follows() && !(sides_.is_near() && sides_.has_friction()) &&
      !(contact_.is_near() && (spec_.mode == ImplicitMode::dynamic || spec_.friction > 0)) &&
      std::all_of(sources_.begin(), sources_.end(), [](const auto& source) { return source.points->material().is_symmetric(); });
  const auto failure = newton_.solve(load, std::move(prescribed), is_symmetric ? Symmetry::symmetric : Symmetry::general, u);
  iterations_ += newton_.report().iterations;
  linear_iterations_ += newton_.report().linear_iterations;
  return failure;
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
  for (std::size_t s = 0; s < sources_.size() && case_.body_force; ++s) {
    std::vector<Real> positions;
    for (const Vec<Dim>& x : sources_[s].points->position) positions.insert(positions.end(), x.begin(), x.end());
    load.body_force.emplace_back(positions.size());
    case_.body_force->at(t_end, positions, load.body_force.back());
  }
  load.factors = load_factors(t_end);
  if (!tractions_.empty()) {
    const Real factor = case_.load_factor(t_end);
    for (const Index slot : space_.slots()) {
      for (const Real force : tractions_[static_cast<std::size_t>(slot)]) load.nodal_force.push_back(factor * force);
    }
  }
  return load;
}

template <int Dim>
std::vector<BoundaryTotals> ImplicitSolver<Dim>::boundaries() const {
  std::vector<BoundaryTotals> all;
  for (std::size_t b = 0; b < boundaries_.size(); ++b) {
    if (case_.boundaries[b].kind != BoundaryKind::traction) all.push_back(boundaries_[b].totals);
  }
  for (const HeldBoundary& pair : pairs_) all.push_back(pair.totals);
  all.insert(all.end(), loads_.begin(), loads_.end());
  return all;
}

std::unique_ptr<Solver> make_implicit_solver(const Case& problem) {
  if (problem.dim == 3) return std::make_unique<ImplicitSolver<3>>(problem);
  return std::make_unique<ImplicitSolver<2>>(problem);
}

template class ImplicitSolver<2>;
template class ImplicitSolver<3>;

}  // namespace matpoint
