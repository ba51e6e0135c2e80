// The equations of an implicit step by themselves: is the matrix the derivative of the residual, and does Newton's method converge as it
// should?
#include <cmath>
#include <random>

#include "core/error.hpp"
#include "implicit/implicit_solver.hpp"
#include "verify/analytic.hpp"

namespace matpoint {
namespace {

constexpr const char* k_disk = R"(
gravity = [0, -9.81]
[grid]
lower = [-2, -2]
upper = [2, 2]
cells = [8, 8]
[time]
end = 1
dt = 0.01
[solver]
type = "implicit"
[[body]]
name = "disk"
region = { type = "disk", center = [0, 1], radius = 0.6 }
layout = { type = "per_cell", count = 25 }
material = { type = "neo_hookean", density = 1000, youngs_modulus = 1e6, poissons_ratio = 0.3 }
)";

constexpr const char* k_block = R"(
dim = 3
gravity = [1, -9.81, 2]
[grid]
upper = [1, 1, 1]
cells = [2, 3, 2]
[time]
end = 1
dt = 0.01
[solver]
type = "implicit"
[[body]]
name = "block"
region = { type = "box", lower = [0, 0, 0], upper = [0.7, 0.8, 0.6] }
layout = { type = "per_cell", count = 27 }
material = { type = "neo_hookean", density = 1000, youngs_modulus = 1e5, poissons_ratio = 0.3 }
[[boundary]]
side = "bottom"
kind = "fixed"
[[boundary]]
side = "left"
)";

// --- tangent of the assembled system ---------------------------------------------------------------------------------
/// Relative difference between the matrix and central differences of the residual, in a direction at random, after some steps of a case.
template <int Dim>
Real tangent_difference(const Case& problem, int steps) {
  ImplicitSolver<Dim> solver(problem);
  const Real dt = *problem.time.dt;
  for (int k = 0; k < steps; ++k) solver.step(k * dt, dt);
  StepSpace<Dim>& space = solver.space();
  Assembly<Dim>& assembly = solver.assembly();
  space.update(steps * dt);
  assembly.start();
  StepLoad<Dim> load;
  load.dt = dt;
  load.inertia = {1 / (0.3 * dt * dt), 1 / (0.3 * dt), 2.0 / 3};
  std::mt19937 random(7);
  std::uniform_real_distribution<Real> uniform(-1, 1);
  const Real scale = 1e-3 * problem.grid.cell_size[0];
  std::vector<Real> u(space.nodes().size() * Dim), direction(u.size());
  Vector unknowns(space.unknown_count());
  for (std::size_t k = 0; k < u.size(); ++k) {
    u[k] = scale * uniform(random);
    const int unknown = space.unknown(static_cast<Index>(k / Dim), static_cast<int>(k % Dim));
    direction[k] = unknown >= 0 ? uniform(random) : 0;
    if (unknown >= 0) unknowns[unknown] = direction[k];
  }
  std::vector<Real> residual, plus, minus, u_plus = u, u_minus = u;
  Lift lift;
  assembly.residual_and_matrix(u, load, residual, lift);
  const Vector product = assembly.matrix() * unknowns;
  const Real step = 1e-6 * problem.grid.cell_size[0];
  for (std::size_t k = 0; k < u.size(); ++k) {
    u_plus[k] += step * direction[k];
    u_minus[k] -= step * direction[k];
  }
  assembly.residual(u_plus, load, plus);
  assembly.residual(u_minus, load, minus);
  Real difference = 0;
  for (std::size_t k = 0; k < u.size(); ++k) {
    const int unknown = space.unknown(static_cast<Index>(k / Dim), static_cast<int>(k % Dim));
    if (unknown >= 0) difference += std::pow((plus[k] - minus[k]) / (2 * step) - product[unknown], 2);
  }
  return std::sqrt(difference) / product.norm();
}

/// Order by the last three relative increments: 2 for quadratic convergence.
Measured newton_convergence() {
  Case problem = load_case("cantilever", {"grid.refinements=3"});
  ImplicitSolver<2> solver(problem);
  for (int k = 0; k < 30; ++k) solver.step(k * 0.008, 0.008);
  const std::vector<Real>& d = solver.newton_report().increments;
  if (d.size() < 4) throw SolverError("Newton's method took {} iterations only", d.size());
  Measured m;
  for (std::size_t k = 1; k < 4; ++k) m[fmt::format("increment_{}", k + 1)] = d[k];
  m["order_of_increments"] = std::log(d[3] / d[2]) / std::log(d[2] / d[1]);
  const std::vector<Real>& r = solver.newton_report().residuals;
  for (std::size_t k = 0; k < r.size(); ++k) m[fmt::format("residual_{}", k + 1)] = r[k];
  return m;
}

}  // namespace

void add_implicit_newton(VerifySuite& suite) {
  add_problem(
      suite,
      {"implicit_tangent",
       "assembled tangent against central differences",
       "implicit_tangent",
       true,
       true,
       2e7,
       {},
       [] {
         return Measured{
             {"element_receding",
              tangent_difference<2>(
                  load_case("rolling_disk", {"grid.refinements=1", "body.disk.layout.points=60", "body.disk.region.center=[0,0.3]"}), 25)},
             {"bspline", tangent_difference<2>(case_from_text("disk", k_disk), 3)},
             {"bspline_3d", tangent_difference<3>(case_from_text("block", k_block), 2)},
             {"element_3d", tangent_difference<3>(case_from_text("block", k_block, {"solver.basis=element"}), 2)},
             {"patches", tangent_difference<2>(case_from_text("disk", k_disk, {"body.disk.fbar=true"}), 3)},
             {"patches_3d", tangent_difference<3>(case_from_text("block", k_block, {"body.block.fbar=true"}), 2)},
             {"patches_element", tangent_difference<2>(case_from_text("disk", k_disk, {"body.disk.fbar=true", "solver.basis=element"}), 3)},
             {"patches_stiff", tangent_difference<2>(case_from_text("disk", k_disk, {"body.disk.material.poissons_ratio=0.4999"}), 3)}};
       }},
      {at_most("element_receding", 1e-8, "central differences"), at_most("bspline", 1e-8, "central differences"),
       at_most("bspline_3d", 1e-8, "central differences"), at_most("element_3d", 1e-8, "central differences"),
       at_most("patches", 1e-7, "central differences"), at_most("patches_3d", 1e-7, "central differences"),
       at_most("patches_element", 1e-7, "central differences"), at_most("patches_stiff", 1e-7, "central differences")});
  add_problem(suite, {"implicit_newton", "convergence of Newton's method", "implicit_newton", true, true, 3e7, {}, &newton_convergence},
              {at_least("order_of_increments", 1.8, "2 for quadratic convergence; cantilever J = 3, step 30"),
               at_most("increment_3", 1e-4, "quadratic: 1, 4.0e-3, 4.4e-6 in the reference"),
               at_most("increment_4", 1e-9, "9.8e-13 in the reference")});
}

}  // namespace matpoint
