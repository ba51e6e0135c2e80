// What each boundary carries in the implicit solver: forces, impulses and work by name, against weights, momentum and the ledger.
#include "support/solver_case.hpp"

namespace matpoint::test {
namespace {

Case read(const std::string& text, const std::vector<std::string>& sets = {}) {
  Input input = parse_toml(text, "case.toml");
  for (const std::string& set : sets) apply_set(input, set);
  return Case::from_input(input, "case");
}

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

/// A column of two layers under its weight, small strains, between slip sides.
TEST(ManyBodies, layers_carry_what_lies_above_and_settle_as_in_closed_form) {
  const Real g = 0.01, a = 0.5;
  const auto text = [&](int dim, const std::string& basis, int count) {
    const std::string z = dim == 3 ? ", 0" : "", w = dim == 3 ? ", 0.5" : "";
    std::string all = fmt::format(R"(
dim = {}
gravity = [0, {}{}]
[grid]
upper = [0.5, 1{}]
cell_size = 0.25
[time]
end = 1
dt = 1
[solver]
type = "implicit"
mode = "static"
basis = "{}"
)",
                                  dim, -g, z, w, basis);
    const auto layer = [&](const char* name, Real from, Real to, Real density, Real E, Real nu) {
      all += fmt::format(R"([[body]]
name = "{}"
region = {{ type = "box", lower = [0, {}{}], upper = [0.5, {}{}] }}
layout = {{ type = "per_cell", count = {} }}
material = {{ type = "neo_hookean", density = {}, youngs_modulus = {}, poissons_ratio = {} }}
)",
                         name, from, z, to, w, count, density, E, nu);
    };
    layer("low", 0, a, 2000, 1e6, 0.3);
    layer("top", a, 1, 1500, 4e6, 0.2);
    for (const char* side : {"left", "right", "front", "back"}) {
      if (dim == 3 || side[0] == 'l' || side[0] == 'r') all += fmt::format("[[boundary]]\nside = \"{}\"\n", side);
    }
    return all + "[[boundary]]\nside = \"bottom\"\nkind = \"fixed\"\n";
  };
  const auto modulus = [](Real E, Real nu) { return E * (1 - nu) / ((1 + nu) * (1 - 2 * nu)); };
  const Real low = modulus(1e6, 0.3), top = modulus(4e6, 0.2);
  const Real way_low = g * (2000 * a * a / 2 + 1500 * (1 - a) * a) / low;
  const Real way = way_low + g * 1500 * (1 - a) * (1 - a) / 2 / top;
  for (const auto& [dim, count] : {std::pair(2, 100), std::pair(3, 216)}) {
    Simulation sim(read(text(dim, "element", count)));
    const std::vector<Real> X = sim.solver().field(1, "position").values;
    sim.run();
    const std::vector<Real> x = sim.solver().field(1, "position").values;
    const auto n = static_cast<std::size_t>(dim);
    for (std::size_t p = 0; p < X.size() / n; ++p) {
      const Real y = X[p * n + 1];
      const Real right = way_low + g * 1500 * ((1 - a) * (y - a) - (y - a) * (y - a) / 2) / top;
      EXPECT_NEAR((X[p * n + 1] - x[p * n + 1]) / way, right / way, 1e-3);
    }
    // The mean over each layer: stresses at single particles scatter by 2e-3.
    const Real mean_low = g * (2000 * a / 2 + 1500 * (1 - a)), mean_top = g * 1500 * (1 - a) / 2;
    for (std::size_t body = 0; body < 2; ++body) {
      const Field field = sim.solver().field(body, "stress");
      const std::size_t width = field.values.size() / static_cast<std::size_t>(sim.solver().particle_count(body));
      Real sum = 0;
      for (std::size_t p = 0; p < field.values.size() / width; ++p) sum += field.values[p * width + 1];
      EXPECT_NEAR(-sum / static_cast<Real>(field.values.size() / width), body == 0 ? mean_low : mean_top, 1e-3 * mean_low) << dim << body;
    }
    const Real weight = g * (sim.solver().totals(0).mass + sim.solver().totals(1).mass);
    EXPECT_NEAR(of(sim, "bottom").force[1], weight, 1e-8 * weight);
  }
  // An interface within cells of splines: no jump of strain there, so it is of first order only.
  Simulation spline(read(text(2, "bspline", 100)));
  spline.run();
  const Real weight = g * (spline.solver().totals(0).mass + spline.solver().totals(1).mass);
  EXPECT_NEAR(of(spline, "bottom").force[1], weight, 1e-8 * weight);
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
