// No particle of a fluid gets into a region that holds it, and the books know what kept it out.
#include <array>

#include "case/case_file.hpp"
#include "run/simulation.hpp"
#include "support/solver_case.hpp"

namespace matpoint::test {
namespace {

struct Wall {
  const char* name;
  int dim;
  const char* shape;
  const char* transfer;
};

/// Water falls against a wall of less than a cell, and of two cells, that stands on the floor.
std::string text_of(const Wall& wall, Real thickness, const char* kind) {
  const bool is_3d = wall.dim == 3;
  std::string text =
      fmt::format(R"(
dim = {}
gravity = [0, {}]
[grid]
upper = [1, {}]
cell_size = 0.1
[time]
end = 1
[solver]
shape = "{}"
transfer = "{}"
[[body]]
name = "water"
region = {{ type = "box", lower = [0, 0{}], upper = [0.4, {}] }}
layout = {{ type = "per_cell", count = {} }}
material = {{ type = "newtonian_fluid", density = 1000, pressure_scale = 57142.857, tension = 0 }}
[[boundary]]
region = {{ type = "box", lower = [0.43, 0{}], upper = [{}, {}] }}
{}
)",
                  wall.dim, is_3d ? "0, -9.81" : "-9.81", is_3d ? "0.3, 1" : "1", wall.shape, wall.transfer, is_3d ? ", 0" : "",
                  is_3d ? "0.3, 0.6" : "0.6", is_3d ? 8 : 4, is_3d ? ", 0" : "", 0.43 + thickness, is_3d ? "0.3, 1" : "1", kind);
  for (const char* side : {"left", "right", "bottom", "top", "front", "back"}) {
    if (is_3d || (std::string(side) != "front" && std::string(side) != "back")) text += fmt::format("[[boundary]]\nside = \"{}\"\n", side);
  }
  return text;
}

class Obstacles : public testing::TestWithParam<Wall> {};

TEST_P(Obstacles, let_no_fluid_in_whatever_their_thickness) {
  for (const Real thickness : {0.08, 0.2}) {
    for (const char* kind : {"kind = \"fixed\"", "kind = \"slip\"\ncontact = \"no_tension\""}) {
      Simulation sim(Case::from_input(parse_toml(text_of(GetParam(), thickness, kind), "wall"), "wall"));
      Real farthest = 0;
      sim.add_callback([&](const Simulation& now) {
        farthest = std::max(farthest, now.solver().totals(0).upper[0]);
        return true;
      });
      sim.run();
      EXPECT_LE(farthest, 0.43 + 1e-6) << thickness << kind;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, Obstacles,
                         testing::Values(Wall{"bspline2", 2, "bspline2", "flip"}, Wall{"gimp", 2, "gimp", "flip"},
                                         Wall{"linear", 2, "linear", "flip"}, Wall{"apic", 2, "bspline2", "apic"},
                                         Wall{"bspline2_3d", 3, "bspline2", "flip"}),
                         [](const auto& info) { return info.param.name; });

// One particle flies into a wall of glass: what it loses is what the books say.
TEST(ObstacleBooks, have_the_impulse_and_the_energy) {
  Simulation sim(Case::from_input(parse_toml(R"(
[grid]
upper = [1, 1]
cell_size = 0.1
[time]
end = 0.3
dt = 1e-3
[solver]
shape = "bspline2"
fluid_correction = false
[[body]]
name = "drop"
layout = { type = "points", positions = [[0.3, 0.5]], volumes = 1e-4 }
velocity = { type = "uniform", value = [1, 0.25] }
material = { type = "newtonian_fluid", density = 1000, pressure_scale = 57142.857, tension = 0 }
[[boundary]]
region = { type = "disk", center = [0.57, 0.57], radius = 0.1 }
kind = "slip"
contact = "no_tension"
)",
                                             "drop"),
                                  "drop"));
  const BodyTotals start = sim.solver().totals(0);
  sim.run();
  const BodyTotals end = sim.solver().totals(0);
  const Ledger& ledger = sim.solver().ledger();
  for (std::size_t d = 0; d < 2; ++d) EXPECT_NEAR(end.momentum[d] - start.momentum[d], ledger.boundary_impulse[d], 1e-13);
  EXPECT_GT(std::abs(ledger.boundary_impulse[0]), 0.01 * start.momentum[0]);
  const std::vector<Real> x = sim.solver().field(0, "position").values;
  EXPECT_GE(std::hypot(x[0] - 0.57, x[1] - 0.57), 0.1 - 1e-9);
}

// What is in a region from the start is held there, as a clamp does.
TEST(ObstacleBooks, leave_alone_what_was_inside) {
  Simulation sim(Case::from_input(parse_toml(R"(
[grid]
upper = [1, 1]
cell_size = 0.1
[time]
end = 0.1
[[body]]
name = "drop"
region = { type = "box", lower = [0.3, 0.3], upper = [0.7, 0.7] }
layout = { type = "per_cell", count = 4 }
material = { type = "newtonian_fluid", density = 1000, pressure_scale = 57142.857 }
[[boundary]]
region = { type = "box", lower = [0.4, 0.4], upper = [0.6, 0.6] }
kind = "fixed"
)",
                                             "drop"),
                                  "drop"));
  sim.run();
  EXPECT_EQ(sim.solver().ledger().contact_dissipation, 0);
}

}  // namespace
}  // namespace matpoint::test
