// What each boundary carries in the implicit solver: forces, impulses and work by name, against weights, momentum and the ledger.
#include "support/solver_case.hpp"

namespace matpoint::test {
namespace {

BoundaryTotals of(const Simulation& sim, const std::string& name) {
  for (const BoundaryTotals& one : sim.solver().boundaries()) {
    if (one.name == name) return one;
  }
  ADD_FAILURE() << "no boundary is called " << name;
  return {};
}

std::string block(int dim, const std::string& boundaries, const std::string& solver) {
  const bool is_3d = dim == 3;
  return fmt::format(R"(
dim = {}
gravity = {}
[grid]
upper = {}
cells = {}
[time]
end = 1
dt = 0.5
[solver]
type = "implicit"
{}
[[body]]
name = "block"
region = {{ type = "box", lower = {}, upper = {} }}
layout = {{ type = "per_cell", count = {} }}
material = {{ type = "neo_hookean", density = 1000, youngs_modulus = 1e6, poissons_ratio = 0.3 }}
{})",
                     dim, is_3d ? "[0, -9.81, 0]" : "[0, -9.81]", is_3d ? "[1, 1, 1]" : "[1, 1]", is_3d ? "[4, 4, 4]" : "[8, 8]", solver,
                     is_3d ? "[0.25, 0, 0.25]" : "[0.25, 0]", is_3d ? "[0.75, 0.5, 0.75]" : "[0.75, 0.5]", is_3d ? 27 : 9, boundaries);
}

TEST(Reactions, a_floor_carries_the_weight_in_statics) {
  for (const int dim : {2, 3}) {
    Simulation sim(read(block(dim, "[[boundary]]\nside = \"bottom\"\nkind = \"fixed\"\nname = \"floor\"\n", "mode = \"static\"")));
    sim.run();
    const BoundaryTotals floor = of(sim, "floor");
    const Real weight = sim.solver().totals(0).mass * 9.81;
    EXPECT_NEAR(floor.force[1], weight, 1e-8 * weight) << dim;
    EXPECT_NEAR(floor.force[0], 0, 1e-8 * weight);
    EXPECT_EQ(floor.impulse[1], 0);
    EXPECT_EQ(floor.work, 0);
  }
}

TEST(Reactions, sides_that_share_a_weight_sum_up_to_it) {
  const std::string sides = "[[boundary]]\nside = \"left\"\nkind = \"fixed\"\n[[boundary]]\nside = \"right\"\nkind = \"fixed\"\n";
  Simulation sim(read(block(2, sides, "mode = \"static\""), {"body.block.region.lower=[0, 0.25]", "body.block.region.upper=[1, 0.75]"}));
  sim.run();
  const Real weight = sim.solver().totals(0).mass * 9.81;
  const BoundaryTotals left = of(sim, "left"), right = of(sim, "right");
  EXPECT_NEAR(left.force[1] + right.force[1], weight, 1e-8 * weight);
  EXPECT_NEAR(left.force[1], right.force[1], 1e-8 * weight);
  EXPECT_NEAR(left.force[0], -right.force[0], 1e-8 * weight);
  EXPECT_GT(std::abs(left.force[0]), 1) << "clamped ends push or pull";
}

TEST(Reactions, impulses_of_all_boundaries_are_the_momentum_and_their_work_is_the_ledgers) {
  // A block that rubs on a floor, is pushed by a moving side, and lets go of the floor on its way.
  const std::string boundaries = R"(
[[boundary]]
side = "bottom"
kind = "fixed"
contact = "friction"
friction = 0.3
[[boundary]]
side = "left"
kind = "velocity"
times = [0, 0.2]
velocities = [[0, 0], [1, 0]]
name = "ram"
)";
  for (const char* start : {"consistent", "zero"}) {
    Simulation sim(read(block(2, boundaries, ""), {"body.block.region.lower=[0, 0]", "body.block.region.upper=[0.5, 0.5]", "time.end=0.15",
                                                   "time.dt=0.005", "solver.initial_acceleration=" + std::string(start)}));
    sim.run();
    const Ledger& ledger = sim.solver().ledger();
    const BoundaryTotals floor = of(sim, "bottom"), ram = of(sim, "ram");
    const BodyTotals block = sim.solver().totals(0);
    const Real scale = std::abs(ledger.gravity_impulse[1]);
    for (std::size_t d = 0; d < 2; ++d) {
      EXPECT_NEAR(floor.impulse[d] + ram.impulse[d] + ledger.gravity_impulse[d], block.momentum[d], 1e-8 * scale) << start << d;
    }
    EXPECT_GT(ram.work, 1);
    EXPECT_GT(ram.impulse[0], 0);
    EXPECT_LT(floor.impulse[0], 0) << "friction holds back";
    EXPECT_NEAR(floor.work + ram.work, ledger.boundary_work, 1e-10 * std::abs(ledger.boundary_work));
    // A floor at rest does no work, and its friction dissipates. Nodes that it lets go of in a step move under half the force that it had
    // on them before.
    EXPECT_NEAR(floor.work, 0, 1e-3 * ram.work);
  }
}

/// Two layers whose interface is on a line of cells; `matpoint verify implicit_contact` has their closed form on elements.
TEST(ManyBodies, layers_in_one_field_of_splines_weigh_what_they_weigh) {
  Simulation sim(read(R"(
gravity = [0, -0.01]
[grid]
upper = [0.5, 1]
cell_size = 0.25
[time]
end = 1
dt = 1
[solver]
type = "implicit"
mode = "static"
[[body]]
name = "low"
region = { type = "box", lower = [0, 0], upper = [0.5, 0.5] }
layout = { type = "per_cell", count = 100 }
material = { type = "neo_hookean", density = 2000, youngs_modulus = 1e6, poissons_ratio = 0.3 }
[[body]]
name = "top"
region = { type = "box", lower = [0, 0.5], upper = [0.5, 1] }
layout = { type = "per_cell", count = 100 }
material = { type = "neo_hookean", density = 1500, youngs_modulus = 4e6, poissons_ratio = 0.2 }
[[boundary]]
side = "left"
[[boundary]]
side = "right"
[[boundary]]
side = "bottom"
kind = "fixed"
)"));
  sim.run();
  const Real weight = 0.01 * (sim.solver().totals(0).mass + sim.solver().totals(1).mass);
  EXPECT_NEAR(of(sim, "bottom").force[1], weight, 1e-8 * weight);
}

TEST(ManyBodies, nothing_holds_one_of_two_that_are_apart) {
  const std::string second = R"([[body]]
name = "flying"
region = { type = "box", lower = [0.25, 0.875], upper = [0.75, 1] }
layout = { type = "per_cell", count = 9 }
material = { type = "neo_hookean", density = 1000, youngs_modulus = 1e6, poissons_ratio = 0.3 }
)";
  const std::string text = block(2, second + "[[boundary]]\nside = \"bottom\"\nkind = \"fixed\"\n", "mode = \"static\"");
  try {
    Simulation sim(read(text));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("body \"flying\": nothing holds the body"), std::string::npos) << error.what();
  }
  EXPECT_EQ(Simulation(read(text, {"solver.mode=dynamic"})).warnings().size(), 1u) << "where they meet they stick";
}

TEST(Reactions, names_are_those_given_or_of_sides_and_never_twice_the_same) {
  const std::string two = "[[boundary]]\nside = \"bottom\"\nkind = \"fixed\"\ncomponents = [\"x\"]\n[[boundary]]\nside = \"bottom\"\n";
  const std::vector<BoundaryTotals> all = Simulation(read(block(2, two, ""))).solver().boundaries();
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0].name, "bottom");
  EXPECT_EQ(all[1].name, "boundary_2");
  EXPECT_THROW(read(block(2, two, ""), {"boundary.1.name=a", "boundary.2.name=a"}), InputError);
  EXPECT_THROW(read(block(2, two, ""), {"boundary.1.name=a.b"}), InputError);
  const std::string region =
      "[[boundary]]\nside = \"bottom\"\n[[boundary]]\nkind = \"fixed\"\nregion = { type = \"box\", lower = [0, 0], upper = [1, 0.125] }\n";
  const std::string on_elements = block(2, region, "basis = \"element\"");
  EXPECT_EQ(Simulation(read(on_elements)).solver().boundaries()[1].name, "boundary_2");
  EXPECT_THROW(read(on_elements, {"boundary.1.name=boundary_2"}), InputError);
}

}  // namespace
}  // namespace matpoint::test
