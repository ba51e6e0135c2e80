// What each boundary does to the bodies: the parts of one whole, and a wall's force is what leans on it.
#include "case/case_file.hpp"
#include "support/solver_case.hpp"

namespace matpoint::test {
namespace {

Case read(const std::string& text, const std::vector<std::string>& sets = {}) {
  Input input = parse_toml(text, "case.toml");
  for (const std::string& set : sets) apply_set(input, set);
  return Case::from_input(input, "case");
}

const char* const k_thrown = R"(
gravity = [2, -10]
[grid]
upper = [1, 1]
cells = [20, 20]
[time]
end = 0.4
[[body]]
name = "lower"
region = { type = "box", lower = [0.4, 0.05], upper = [0.6, 0.2] }
layout = { type = "per_cell", count = 4 }
velocity = { type = "uniform", value = [2, -1] }
material = { type = "neo_hookean", density = 1000, youngs_modulus = 1e5, poissons_ratio = 0.3 }
[[body]]
name = "upper"
region = { type = "box", lower = [0.4, 0.3], upper = [0.6, 0.5] }
layout = { type = "per_cell", count = 4 }
velocity = { type = "uniform", value = [2, -2] }
material = { type = "neo_hookean", density = 1000, youngs_modulus = 1e5, poissons_ratio = 0.3 }
[[boundary]]
side = "bottom"
kind = "fixed"
[[boundary]]
side = "right"
kind = "slip"
[[boundary]]
name = "slide"
region = { type = "half_space", point = [0.5, 0.07], normal = [-0.6, 0.8] }
kind = "slip"
)";

TEST(BoundaryTotals, are_the_parts_of_the_whole) {
  const std::string water = "body.lower.material={ type = \"newtonian_fluid\", density = 1000, pressure_scale = 1e4, viscosity = 1 }";
  for (const std::vector<std::string>& sets :
       std::vector<std::vector<std::string>>{{},
                                             {"boundary.1.contact=friction", "boundary.1.friction=0.3"},
                                             {"boundary.1.contact=no_tension", "boundary.2.kind=velocity", "boundary.2.velocity=[-0.5, 0]"},
                                             {"solver.transfer=fmpm", "solver.stress_order=musl"},
                                             {"solver.contact=multi_field"},
                                             {"solver.contact=pairs", "solver.stress_order=usf"},
                                             {"solver.damping=2"},
                                             {water}}) {
    SCOPED_TRACE(fmt::format("{}", fmt::join(sets, " ")));
    Simulation sim(read(k_thrown, sets));
    sim.run();
    const Ledger& ledger = sim.solver().ledger();
    Vec3 impulse{};
    Real work = 0, size = 0;
    ASSERT_EQ(sim.solver().boundaries().size(), 3u);
    for (const BoundaryTotals& one : sim.solver().boundaries()) {
      for (std::size_t d = 0; d < 3; ++d) {
        impulse[d] += one.impulse[d];
        size += std::abs(one.impulse[d]);
      }
      work += one.work;
    }
    EXPECT_GT(size, 10) << "of a momentum of 140 N s";
    for (std::size_t d = 0; d < 3; ++d) EXPECT_NEAR(impulse[d], ledger.boundary_impulse[d], 1e-10 * size);
    EXPECT_NEAR(work, ledger.boundary_work, 1e-10 * (std::abs(ledger.boundary_work) + size));
  }
}

TEST(BoundaryTotals, a_floor_carries_the_weight_and_a_wall_the_thrust) {
  // Ground at rest, K0 = 0.5: the floor has its weight, a wall half of what a fluid of that weight would press with.
  for (const int dim : {2, 3}) {
    const std::string depth = dim == 3 ? ", 0.5" : "", zero = dim == 3 ? ", 0" : "", cells = dim == 3 ? ", 4" : "";
    std::string text = fmt::format(
        "dim = {0}\ngravity = [0, -10{2}]\n[grid]\nupper = [1, 3{1}]\ncells = [8, 24{3}]\n[time]\nend = 0.01\n[[body]]\nname = "
        "\"ground\"\nregion = {{ "
        "type = \"box\", lower = [0, 0{2}], upper = [1, 2{1}] }}\nlayout = {{ type = \"per_cell\", count = {4} }}\ninitial_stress = {{ "
        "type = "
        "\"geostatic\", K0 = 0.5 }}\nmaterial = {{ type = \"drucker_prager\", density = 2000, youngs_modulus = 1e7, poissons_ratio = 0.3, "
        "cohesion = "
        "1e3, friction_angle = 30 }}\n",
        dim, depth, zero, cells, dim == 3 ? 8 : 4);
    for (const char* side : {"left", "right", "bottom"}) text += fmt::format("[[boundary]]\nside = \"{}\"\nkind = \"slip\"\n", side);
    if (dim == 3) {
      for (const char* side : {"front", "back"}) text += fmt::format("[[boundary]]\nside = \"{}\"\nkind = \"slip\"\n", side);
    }
    Simulation sim(read(text));
    sim.run();
    const std::vector<BoundaryTotals> all = sim.solver().boundaries();
    const Real width = dim == 3 ? 0.5 : 1, weight = 2000 * 10 * 2 * width, thrust = 0.5 * 2000 * 10 * 2 * 2 / 2 * width;
    EXPECT_EQ(all[0].name, "left");
    EXPECT_NEAR(all[0].force[0], thrust, 1e-9 * thrust);
    EXPECT_NEAR(all[1].force[0], -thrust, 1e-9 * thrust);
    EXPECT_NEAR(all[2].force[1], weight, 1e-9 * weight);
    EXPECT_NEAR(all[2].impulse[1], weight * sim.time(), 1e-9 * weight);
    EXPECT_EQ(all[2].work, 0);
  }
}

}  // namespace
}  // namespace matpoint::test
