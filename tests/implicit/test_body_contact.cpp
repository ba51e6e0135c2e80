// Contact between bodies of particles in fields of their own: exact tangents, forces that make no energy, Coulomb's law.
#include "implicit/implicit_solver.hpp"
#include "io/history.hpp"
#include "support/solver_case.hpp"

namespace matpoint::test {
namespace {

/// Two blocks on each other along y, of which the upper one overlaps the lower by 0.02; both end at a slip side on the left.
Case two_blocks(int dim, const std::string& mode, Real friction) {
  const bool is_3d = dim == 3;
  const auto body = [&](const char* name, const char* lower, const char* upper, Real modulus) {
    return fmt::format(R"(
[[body]]
name = "{}"
region = {{ type = "box", lower = [0, {}{}], upper = [{}{}] }}
layout = {{ type = "per_cell", count = {} }}
material = {{ type = "neo_hookean", density = 1000, youngs_modulus = {}, poissons_ratio = 0.3 }}
)",
                       name, lower, is_3d ? ", 0" : "", upper, is_3d ? ", 0.6" : "", is_3d ? 8 : 4, modulus);
  };
  return read(fmt::format(R"(
dim = {}
gravity = {}
[grid]
upper = {}
cells = {}
[time]
end = 0.1
dt = 0.01
[solver]
type = "implicit"
mode = "{}"
contact = "pairs"
friction = {}
[[boundary]]
side = "left"
[[boundary]]
side = "bottom"
kind = "fixed"
[[boundary]]
side = "top"
kind = "velocity"
velocity = {}
)",
                          dim, is_3d ? "[0, 0, 0]" : "[0, 0]", is_3d ? "[1, 0.8, 1]" : "[1, 0.8]", is_3d ? "[5, 4, 5]" : "[10, 8]", mode,
                          friction, is_3d ? "[0, -0.1, 0]" : "[0, -0.1]") +
              body("low", "0", "0.8, 0.4", 1e6) + body("high", "0.38", "0.6, 0.8", 2e6));
}

/// The largest entry of the matrix's error against central differences, over the largest entry.
template <int Dim>
Real error_of_matrix(ImplicitSolver<Dim>& solver, const StepLoad<Dim>& load, const std::vector<Real>& u) {
  Assembly<Dim>& assembly = solver.assembly();
  const StepSpace<Dim>& space = solver.space();
  std::vector<Real> residual, up, down;
  Lift lift;
  assembly.residual_and_matrix(u, load, residual, lift);
  const Eigen::MatrixXd matrix = assembly.matrix();
  const Real step = 1e-7;
  Real worst = 0;
  for (std::size_t k = 0; k < u.size(); ++k) {
    const int column = space.unknown(static_cast<Index>(k / Dim), static_cast<int>(k % Dim));
    if (column < 0) continue;
    std::vector<Real> moved = u;
    moved[k] = u[k] + step;
    assembly.residual(moved, load, up);
    moved[k] = u[k] - step;
    assembly.residual(moved, load, down);
    for (std::size_t i = 0; i < u.size(); ++i) {
      const int row = space.unknown(static_cast<Index>(i / Dim), static_cast<int>(i % Dim));
      if (row >= 0) worst = std::max(worst, std::abs(matrix(row, column) - (up[i] - down[i]) / (2 * step)));
    }
  }
  return worst / matrix.cwiseAbs().maxCoeff();
}

template <int Dim>
void check_tangent(bool is_dynamic, Real friction, Real slip) {
  Simulation sim(two_blocks(Dim, is_dynamic ? "dynamic" : "static", friction));
  auto& solver = dynamic_cast<ImplicitSolver<Dim>&>(sim.solver());
  // No rows and no symmetry.
  for (std::size_t b : {0, 1}) {
    std::vector<Real> x = solver.field(b, "position").values;
    for (std::size_t k = 0; k < x.size(); ++k) {
      if (k % static_cast<std::size_t>(Dim) == 1) x[k] += 0.004 * std::sin(12.9898 * static_cast<Real>(k));
    }
    solver.set_field(b, "position", x);
  }
  solver.assembly().start();
  StepLoad<Dim> load;
  load.dt = 0.01;
  if (is_dynamic) load.inertia = {4e4, 400, 1};
  // The upper block moves down and along, everything shakes a little.
  std::vector<Real> u(solver.space().nodes().size() * Dim);
  for (std::size_t k = 0; k < u.size(); ++k) {
    const bool is_upper = solver.space().slots()[k / Dim] >= solver.basis().node_count();
    const Vec<Dim> x = solver.basis().node_position(solver.space().nodes()[k / Dim]);
    u[k] = 1e-3 * std::sin(7.0 * x[0] + 11.0 * x[1] + static_cast<Real>(k % Dim));
    if (is_upper && k % Dim == 0) u[k] += slip;
    if (is_upper && k % Dim == 1) u[k] -= 2e-3;
    if (solver.space().unknown(static_cast<Index>(k / Dim), static_cast<int>(k % Dim)) < 0) u[k] = 0;
  }
  EXPECT_LT(error_of_matrix<Dim>(solver, load, u), 1e-7) << Dim << (is_dynamic ? " dynamic " : " static ") << friction;
  std::vector<Real> residual;
  solver.assembly().residual(u, load, residual);
  EXPECT_GT(greatest_magnitude(residual), 1) << "there should be contact";
}

TEST(BodyContact, tangents_are_exact) {
  for (const bool is_dynamic : {false, true}) {
    check_tangent<2>(is_dynamic, 0, 0);
    check_tangent<2>(is_dynamic, 0.3, 1e-4);
    check_tangent<2>(is_dynamic, 0.3, 0.02);
    check_tangent<3>(is_dynamic, 0.3, 0.02);
  }
}

}  // namespace
}  // namespace matpoint::test
