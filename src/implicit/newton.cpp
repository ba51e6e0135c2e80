#include "implicit/newton.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace matpoint {
namespace {

constexpr int k_halvings_max = 12;
// In a second search: more of them are not worth their time, a shorter step is.
constexpr int k_second_halvings_max = 6;
// Residuals that small, in shares of the forces, go up and down by rounding.
constexpr Real k_rounding = 1e-12;
// Where a node sees hardly any mass, rounding of the residual moves it for ever; a residual below this that no longer falls has converged.
constexpr Real k_stagnation = 1e-10;

Real norm_of(const std::vector<Real>& values) {
  Real sum = 0;
  for (const Real value : values) sum += value * value;
  return std::sqrt(sum);
}

}  // namespace

template <int Dim>
Newton<Dim>::Newton(const ImplicitSpec& spec, const StepSpace<Dim>& space, Assembly<Dim>& assembly, Profile& profile)
    : spec_(spec),
      space_(space),
      assembly_(assembly),
      profile_(profile),
      linear_solver_(make_linear_solver(spec.linear_solver, spec.linear_tolerance, spec.petsc)) {}

template <int Dim>
Real Newton<Dim>::unknown_norm(const std::vector<Real>& nodal) const {
  Real sum = 0;
  for (std::size_t k = 0; k < nodal.size(); ++k) {
    if (space_.unknown(static_cast<Index>(k / Dim), static_cast<int>(k % Dim)) >= 0) sum += nodal[k] * nodal[k];
  }
  return std::sqrt(sum);
}

template <int Dim>
UnknownPlaces Newton<Dim>::places() const {
  UnknownPlaces places;
  places.dim = Dim;
  for (std::size_t n = 0; n < space_.nodes().size(); ++n) {
    const Vec<Dim> x = space_.place(n);
    places.positions.insert(places.positions.end(), x.begin(), x.end());
    for (int d = 0; d < Dim; ++d) places.unknowns.push_back(space_.unknown(static_cast<Index>(n), d));
  }
  return places;
}

template <int Dim>
bool Newton<Dim>::solve_linear(const std::vector<Real>& right, Symmetry symmetry, std::vector<Real>& result) {
  result.assign(right.size(), 0);
  if (space_.unknown_count() == 0) return true;
  Stage stage(profile_, "linear solve");
  Vector b(space_.unknown_count());
  Vector x = Vector::Zero(space_.unknown_count());
  for (std::size_t k = 0; k < right.size(); ++k) {
    const int unknown = space_.unknown(static_cast<Index>(k / Dim), static_cast<int>(k % Dim));
    if (unknown >= 0) b[unknown] = right[k];
  }
  if (analyzed_ != assembly_.pattern()) {
    if (linear_solver_->needs_places()) linear_solver_->place(places());
    linear_solver_->analyze(assembly_.matrix());
  }
  analyzed_ = assembly_.pattern();
  if (!linear_solver_->factorize(assembly_.matrix(), symmetry) || !linear_solver_->solve(b, x)) return false;
  report_.pivot_ratio = linear_solver_->pivot_ratio();
  report_.linear_iterations += linear_solver_->iterations();
  for (std::size_t k = 0; k < right.size(); ++k) {
    const int unknown = space_.unknown(static_cast<Index>(k / Dim), static_cast<int>(k % Dim));
    if (unknown >= 0) result[k] = x[unknown];
  }
  return true;
}

template <int Dim>
std::optional<std::string> Newton<Dim>::solve(const StepLoad<Dim>& load, std::vector<Real> prescribed, Symmetry symmetry,
                                              std::vector<Real>& u) {
  const Real pivot_ratio = report_.pivot_ratio;  // where this step needs no matrix
  report_ = {};
  report_.pivot_ratio = pivot_ratio;
  u.resize(prescribed.size(), 0);
  for (std::size_t k = 0; k < u.size(); ++k) {
    if (space_.unknown(static_cast<Index>(k / Dim), static_cast<int>(k % Dim)) < 0) prescribed[k] -= u[k];
  }
  const bool is_free = spec_.halving == StepHalving::inversion && !assembly_.may_touch();
  const Search start{load, std::move(prescribed), u, u, u, {}, {}, 0, 0, is_free ? 0 : k_halvings_max, 0};
  std::optional<std::string> failure = search_from(start, symmetry, u);
  if (!failure || !is_free) return failure;
  // Where loads fall, or much begins to flow at once, full increments wander about what halved ones find.
  const NewtonReport first = std::exchange(report_, {});
  Search again = start;
  again.halvings_to_fall = k_second_halvings_max;
  const std::optional<std::string> second = search_from(std::move(again), symmetry, u);
  report_.iterations += first.iterations;
  report_.halvings += first.halvings;
  report_.linear_iterations += first.linear_iterations;
  return second ? failure : std::nullopt;
}

template <int Dim>
std::optional<std::string> Newton<Dim>::search_from(Search search, Symmetry symmetry, std::vector<Real>& u) {
  // Prescribed displacements come with the first increment, so that the body follows them at once: alone they might turn cells inside out.
  if (norm_of(search.prescribed) > 0) search.lift.displacement = &search.prescribed;
  {
    Stage stage(profile_, "assembly");
    assembly_.residual_and_matrix(search.u, search.load, search.residual, search.lift);
  }
  while (report_.iterations < spec_.iterations_max) {
    search.norm = unknown_norm(search.residual);
    search.force_scale = std::max({search.force_scale, norm_of(search.residual), search.norm});
    report_.residuals.push_back(search.norm);
    if (!std::isfinite(search.norm)) return "the residual is not finite";
    if (is_balanced(search)) {
      u = search.u;
      return std::nullopt;
    }
    search.last_norm = search.norm;
    ++report_.iterations;
    if (!make_increment(search, symmetry)) {
      return fmt::format("the linear system of iteration {} is singular, or {} found no solution: {} unknowns in {} cells",
                         report_.iterations, linear_solver_->name(), space_.unknown_count(), space_.cells().size());
    }
    std::string failure;
    const Outcome outcome = take_increment(search, failure);
    if (outcome == Outcome::failed) return failure;
    if (outcome == Outcome::converged) {
      u = search.u;
      return std::nullopt;
    }
  }
  return fmt::format("no convergence in {} iterations (residual {:.3g} N of {:.3g} N, last increment {:.3g} of the displacement)",
                     spec_.iterations_max, unknown_norm(search.residual), search.force_scale,
                     report_.increments.empty() ? 0 : report_.increments.back());
}

/// By the residual.
template <int Dim>
bool Newton<Dim>::is_balanced(const Search& search) const {
  if (!search.has_all()) return false;
  if (search.norm <= spec_.residual_absolute) return true;
  if (report_.iterations > 0 && search.norm <= spec_.residual_tolerance * search.force_scale) return true;
  return report_.iterations > 1 && search.norm <= k_stagnation * search.force_scale && search.norm > 0.5 * search.last_norm;
}

/// By the increment, component by component: the greatest ratio of the increment's norm to the step displacement's.
template <int Dim>
bool Newton<Dim>::has_converged(const Search& search, Real share) {
  Real worst = 0;
  for (std::size_t d = 0; d < Dim; ++d) {
    Real u_squared = 0;
    Real d_squared = 0;
    for (std::size_t k = d; k < search.trial.size(); k += Dim) {
      u_squared += search.trial[k] * search.trial[k];
      d_squared += search.increment[k] * search.increment[k];
    }
    if (u_squared < spec_.increment_absolute * spec_.increment_absolute) continue;
    worst = std::max(worst, share * std::sqrt(d_squared / u_squared));
  }
  report_.increments.push_back(worst);
  return search.has_all() && worst < spec_.increment_tolerance;
}

/// K d = r + K_fp u_p at the unknowns, -u_p where prescribed; the step is u - d.
template <int Dim>
bool Newton<Dim>::make_increment(Search& search, Symmetry symmetry) {
  std::vector<Real> right = search.residual;
  for (std::size_t k = 0; k < right.size(); ++k) {
    const int unknown = space_.unknown(static_cast<Index>(k / Dim), static_cast<int>(k % Dim));
    if (unknown >= 0) right[k] += search.lift.force[unknown];
  }
  if (!solve_linear(right, symmetry, search.increment)) return false;
  for (std::size_t k = 0; k < right.size(); ++k) search.increment[k] -= search.prescribed[k];
  return true;
}

/// Takes the increment, or the half of it, or the half of that: until nothing is turned inside out and, if asked for, the residual falls.
template <int Dim>
typename Newton<Dim>::Outcome Newton<Dim>::take_increment(Search& search, std::string& failure) {
  Real share = 1;
  for (int halving = 0;; ++halving) {
    const bool is_last = halving == k_halvings_max;
    for (std::size_t k = 0; k < search.u.size(); ++k) search.trial[k] = search.u[k] - share * search.increment[k];
    std::string fault;
    {
      Stage stage(profile_, "inversion");
      fault = assembly_.find_fault(search.trial);
    }
    if (!fault.empty() && is_last) {
      failure = fault + ", however short the increment";
      return Outcome::failed;
    }
    if (fault.empty()) {
      if (has_converged(search, share)) {
        search.u = search.trial;
        return Outcome::converged;
      }
      Stage stage(profile_, "assembly");
      assembly_.residual_and_matrix(search.trial, search.load, search.residual, search.lift);
      const Real after = unknown_norm(search.residual);
      const bool may_rise = halving >= search.halvings_to_fall || !search.has_all() || after <= k_rounding * search.force_scale;
      if (may_rise || is_last || after < search.norm) break;
      report_.increments.pop_back();
    }
    share /= 2;
    ++report_.halvings;
  }
  search.u = search.trial;
  if (!search.has_all()) {
    // The matrix that was just made has been asked for the whole rest; what was taken of it is gone.
    for (Real& left : search.prescribed) left *= 1 - share;
    search.lift.force *= 1 - share;
    if (share == 1) search.lift.displacement = nullptr;
  }
  return Outcome::goes_on;
}

template class Newton<2>;
template class Newton<3>;

}  // namespace matpoint
