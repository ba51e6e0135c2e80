// Loads on particles in the implicit solver: matrices are exact, momentum and energy close, a uniform pressure gives a uniform stress on
// every basis, and what cannot be is refused.
#include <gmock/gmock.h>

#include <random>

#include "implicit/tangent_error.hpp"
#include "support/from_toml.hpp"
#include "support/solver_case.hpp"

namespace matpoint::test {
namespace {

/// A block of 0.65 x 0.4 (x 0.35), which ends within cells.
std::string block(int dim, const std::string& solver, const std::string& more, const std::string& mode = "static") {
  const bool is_3d = dim == 3;
  return fmt::format(R"(
dim = {}
gravity = {}
[grid]
upper = {}
cell_size = 0.1
[time]
end = 0.1
dt = 0.01
[solver]
type = "implicit"
mode = "{}"
{}
[[body]]
name = "block"
region = {{ type = "box", lower = {}, upper = {} }}
layout = {{ type = "per_cell", count = {} }}
material = {{ type = "neo_hookean", density = 1000, youngs_modulus = 1e5, poissons_ratio = 0.25 }}
{}
)",
                     dim, is_3d ? "[0, 0, 0]" : "[0, 0]", is_3d ? "[1, 1, 0.6]" : "[1, 1]", mode, solver, is_3d ? "[0, 0, 0]" : "[0, 0]",
                     is_3d ? "[0.65, 0.4, 0.35]" : "[0.65, 0.4]", is_3d ? 8 : 4, more);
}
std::string sides(std::initializer_list<const char*> names) {
  std::string text;
  for (const char* name : names) text += fmt::format("[[boundary]]\nside = \"{}\"\nkind = \"slip\"\n", name);
  return text;
}
const std::string k_pressure = "[[load]]\nbody = \"block\"\nkind = \"pressure\"\npressure = 5\n";

template <int Dim>
Real error_of(const std::string& solver_keys, const std::string& more) {
  ImplicitSolver<Dim> solver(read(block(Dim, solver_keys, more)));
  StepLoad<Dim> load;
  load.dt = 0.01;
  load.factors = {1};
  solver.space().update(0);
  solver.assembly().start();
  std::mt19937 random(3);
  std::vector<Real> u(solver.space().nodes().size() * Dim);
  for (Real& x : u) x = 5e-3 * (static_cast<Real>(random()) / 4294967296.0 - 0.5);
  return tangent_error(solver, load, u);
}

TEST(PointLoads, have_exact_tangents) {
  // A pressure of half the modulus, so that it matters.
  const std::string load = "[[load]]\nbody = \"block\"\nkind = \"pressure\"\npressure = 5e4\n";
  for (const std::string solver : {"", "basis = \"element\"\nelement_order = 1\n"})
    EXPECT_LT(error_of<2>(solver, load + sides({"left", "bottom"})), 1e-7) << solver;
  EXPECT_LT(error_of<3>("basis = \"element\"\nelement_order = 1\n", load + sides({"left", "bottom", "front"})), 1e-7);
}

TEST(PointLoads, of_one_pressure_all_around_make_one_stress) {
  for (const int dim : {2, 3}) {
    for (const std::string solver : {"", "basis = \"element\"\nelement_order = 1\n"}) {
      Simulation sim(read(block(dim, solver, k_pressure + (dim == 2 ? sides({"left", "bottom"}) : sides({"left", "bottom", "front"}))),
                          {"time.dt=0.05"}));
      sim.run();
      const std::vector<Real> stress = sim.solver().field(0, "stress").values;
      Real worst = 0;
      for (std::size_t k = 0; k < stress.size(); ++k) {
        if (k % 6 == 2 && dim == 2) continue;
        worst = std::max(worst, std::abs(stress[k] / 5 + (k % 6 < 3 ? 1 : 0)));
      }
      EXPECT_LT(worst, 1e-3) << dim << solver;
    }
  }
}

TEST(PointLoads, close_the_books_of_a_body_that_flies) {
  const std::string loads =
      "[[load]]\nbody = \"block\"\nkind = \"pressure\"\npressure = 200\nside = \"bottom\"\nregion = { type = \"box\", lower = [0, 0], "
      "upper = [1, "
      "1] }\ntimes = [0, 0.05]\nfactors = [0, 1]\n"
      "[[load]]\nbody = \"block\"\nkind = \"force\"\nforce = [5, 3]\nside = \"right\"\n";
  for (const std::string solver :
       {"", "basis = \"element\"\nelement_order = 1\n", "initial_acceleration = \"zero\"\n", "beta = 0.3\ngamma = 0.6\n"}) {
    Simulation sim(read(block(2, solver, loads, "dynamic"), {"grid.upper=[2, 2]", "body.block.region.lower=[0.7, 0.7]",
                                                             "body.block.region.upper=[1.35, 1.1]", "time.dt=0.001"}));
    sim.run();
    EXPECT_LT(momentum_remainder(sim), 1e-8 * momentum_scale(sim.solver())) << solver;
    EXPECT_LT(std::abs(transfer_loss(sim)), 1e-4 * sim.solver().ledger().body_force_work) << solver;
    const std::vector<BoundaryTotals> totals = sim.solver().boundaries();
    EXPECT_NEAR(totals[1].force[0], 5, 1e-9);
    EXPECT_NEAR(totals[0].work + totals[1].work, sim.solver().ledger().body_force_work, 1e-9);
  }
}

TEST(PointLoads, grow_with_the_steps_of_statics_and_are_carried_by_the_sides) {
  const std::string load = "[[load]]\nname = \"pull\"\nbody = \"block\"\nkind = \"traction\"\ntraction = [300, 100]\nside = \"right\"\n";
  Simulation sim(read(block(2, "", load + "[[boundary]]\nside = \"left\"\nkind = \"fixed\"\n")));
  sim.step();
  EXPECT_NEAR(sim.solver().boundaries()[1].force[0], 0.1 * 300 * 0.4, 1e-9);
  sim.run();
  const std::vector<BoundaryTotals> totals = sim.solver().boundaries();
  EXPECT_EQ(totals[1].name, "pull");
  for (std::size_t d = 0; d < 2; ++d) EXPECT_NEAR(totals[0].force[d] + totals[1].force[d], 0, 1e-6 * 120);
  EXPECT_NEAR(totals[1].force[1], 100 * 0.4, 1e-9);
  EXPECT_NEAR(totals[1].work, sim.solver().totals(0).strain_energy, 0.02 * totals[1].work);
}

TEST(PointLoads, that_cannot_be_are_refused) {
  const auto said = [](const std::string& solver, const std::string& more, const std::vector<std::string>& sets = {}) {
    return complaint_of([&] { Simulation(read(block(2, solver, more), sets)); });
  };
  EXPECT_EQ(said("linear_solver = \"ldlt\"\n", k_pressure + sides({"left", "bottom"})),
            "case.toml:20: load on body block: a pressure, which follows the surface, makes the matrix unsymmetric, and linear_solver = "
            "\"ldlt\" is for symmetric ones; use \"auto\"");
  EXPECT_EQ(
      said("basis = \"element\"\nelement_order = 2\n", k_pressure + sides({"left", "bottom"})),
      "case.toml:21: load on body block: a load on the surface of particles is for basis = \"bspline\" or element_order = 1: at a free "
      "surface particles do not hold elements with 9 (27) nodes, which are negative in places");
  EXPECT_EQ(
      said("basis = \"element\"\n",
           "[[body]]\nname = \"plate\"\nmethod = \"elements\"\nregion = { type = \"box\", lower = [0, 0.5], upper = [1, 0.8] }\nmaterial = "
           "{ "
           "type = \"neo_hookean\", density = 1, youngs_modulus = 1, poissons_ratio = 0 }\n"
           "[[load]]\nbody = \"plate\"\nkind = \"force\"\nforce = [1, 0]\n"),
      "case.toml:25: load load_1: body \"plate\" consists of elements; loads on their faces are boundaries with kind = \"traction\", and "
      "this is for bodies of particles");
}

}  // namespace
}  // namespace matpoint::test
