// What walls are for: nothing passes them, wherever their faces lie on the grid, and the books say what they did.
#include "case/case_file.hpp"
#include "support/solver_case.hpp"

namespace matpoint::test {
namespace {

Case read(const std::string& text, const std::vector<std::string>& sets = {}) {
  Input input = parse_toml(text, "case.toml");
  for (const std::string& set : sets) apply_set(input, set);
  return Case::from_input(input, "case");
}

/// How far a block slides on a floor whose face is at y [m].
Real way_on(const std::string& shape, const std::string& region, Real y, int n, Vec3 corner) {
  Case problem =
      read(fmt::format(
               R"(
gravity = [0, -9.81]
[grid]
lower = [{0}, {1}]
upper = [{2}, {3}]
cells = [{4}, {5}]
[time]
end = 0.5
[[body]]
name = "block"
region = {{ type = "box", lower = [{6}, {7}], upper = [{8}, {9}] }}
layout = {{ type = "per_cell", count = 4 }}
velocity = {{ type = "uniform", value = [1, 0] }}
material = {{ type = "neo_hookean", density = 1000, youngs_modulus = 1e6, poissons_ratio = 0.3 }}
[[boundary]]
region = {10}
kind = "fixed"
contact = "friction"
friction = 0.3
)",
               corner[0], corner[1], corner[0] + 2, corner[1] + 1, 2 * n, n, corner[0] + 0.4, y, corner[0] + 0.8, y + 0.4, region),
           {"solver.shape=" + shape});
  Simulation sim(problem);
  const Real start = sim.solver().totals(0).center_of_mass[0];
  sim.run();
  return sim.solver().totals(0).center_of_mass[0] - start;
}

TEST(RegionOnALine, is_the_same_floor_for_every_line_of_a_grid) {
  for (const auto& [shape, corner] : {std::pair("linear", Vec3{0, 0, 0}), std::pair("linear", Vec3{-0.3, 0.45, 0}),
                                      std::pair("bspline2", Vec3{0, 0, 0}), std::pair("bspline2", Vec3{-0.3, 0.45, 0})}) {
    Real first = 0;
    for (int k = 1; k <= 5; ++k) {
      const Real h = 0.1;
      for (const Real y : {corner[1] + k / 10.0, corner[1] + k * h}) {  // as written, and as a multiple of the cells
        for (const std::string& region :
             {fmt::format("{{ type = \"box\", lower = [{}, {}], upper = [{}, {}] }}", corner[0] - 0.1, corner[1] - 0.1, corner[0] + 2.1, y),
              fmt::format("{{ type = \"half_space\", point = [0, {}], normal = [0, 1] }}", y)}) {
          const Real way = way_on(shape, region, y, 10, corner);
          if (first == 0) first = way;
          // v^2 / (2 mu g) of Coulomb's law, and all lines alike. Control points of B-splines stand in the middles of cells: the floor is
          // half a cell lower, and the block falls on it.
          EXPECT_NEAR(way, 1 / (2 * 0.3 * 9.81), (shape == std::string("linear") ? 0.01 : 0.03) * 0.1699) << y << " " << region;
          EXPECT_NEAR(way, first, 1e-6) << y << " " << region;
        }
      }
    }
  }
}

const char* const k_thrown = R"(
[grid]
upper = [1, 1]
cells = [32, 32]
[time]
end = 0.5
[[body]]
name = "water"
region = { type = "box", lower = [0.3, 0.3], upper = [0.7, 0.7] }
layout = { type = "per_cell", count = 4 }
velocity = { type = "uniform", value = [-10, -10] }
material = { type = "newtonian_fluid", density = 1000, pressure_scale = 57000 }
[[boundary]]
side = "left"
[[boundary]]
side = "right"
[[boundary]]
side = "bottom"
[[boundary]]
side = "top"
)";

TEST(ClosedSides, let_nothing_out_and_their_books_balance) {
  Index returned = 0;
  for (const char* shape : {"linear", "bspline2"}) {
    for (const char* precision : {"double", "single"}) {
      Simulation sim(read(k_thrown, {std::string("solver.shape=") + shape, std::string("solver.precision=") + precision}));
      const Vec3 start = sim.solver().totals(0).momentum;
      const Index count = sim.solver().particle_count(0);
      EXPECT_EQ(sim.run(), RunEnd::finished);
      const BodyTotals end = sim.solver().totals(0);
      EXPECT_EQ(sim.solver().particle_count(0), count);
      EXPECT_GE(std::min(end.lower[0], end.lower[1]), 0);
      EXPECT_LE(std::max(end.upper[0], end.upper[1]), 1);
      const Ledger& ledger = sim.solver().ledger();
      const Real scale = std::abs(start[0]) + std::abs(start[1]);
      for (std::size_t d = 0; d < 2; ++d) {
        EXPECT_NEAR(end.momentum[d] - start[d], ledger.boundary_impulse[d], (std::string(precision) == "single" ? 1e-4 : 1e-9) * scale);
      }
      returned += ledger.returned_count;
    }
  }
  EXPECT_GT(returned, 0) << "no particle was put back, so the test shows little";
}

TEST(ClosedSides, put_a_particle_back_at_rest_across_and_book_what_it_brings) {
  // One particle, alone in its cells: nodes slow it so little that it would pass.
  for (const auto& [kind, wall] : {std::pair("slip", 0.0), std::pair("velocity", 0.25)}) {
    const std::string boundary = std::string(kind) == "slip" ? "" : "kind = \"velocity\"\ncomponents = [\"y\"]\nvelocity = [0, 0.25]\n";
    Case problem = read(fmt::format(
        R"(
[grid]
upper = [1, 1]
cells = [10, 10]
[time]
end = 1
dt = 0.1
[[body]]
name = "one"
layout = {{ type = "points", positions = [[0.55, 0.19]], volumes = [0.01] }}
velocity = {{ type = "uniform", value = [0.1, -3] }}
material = {{ type = "neo_hookean", density = 100, youngs_modulus = 1e-3, poissons_ratio = 0 }}
[[boundary]]
side = "bottom"
{}
)",
        boundary));
    Simulation sim(problem);
    sim.step();
    const BodyTotals totals = sim.solver().totals(0);
    const Ledger& ledger = sim.solver().ledger();
    ASSERT_EQ(ledger.returned_count, 1) << kind;
    EXPECT_TRUE(sim.solver().escapes().empty());
    EXPECT_NEAR(totals.center_of_mass[1], 1e-7, 1e-12) << "a millionth of a cell inside";
    EXPECT_NEAR(totals.momentum[1], wall, 1e-12);  // of 1 kg
    EXPECT_NEAR(totals.momentum[0], 0.1, 1e-12);
    EXPECT_NEAR(ledger.boundary_impulse[1], wall + 3, 1e-9);
    // Energy: what it had, and the wall's work, is what it has and what was taken.
    const Real before = 0.5 * (0.01 + 9), after = 0.5 * (0.01 + wall * wall);
    EXPECT_NEAR(ledger.boundary_work - ledger.contact_dissipation, after - before, 1e-9);
    sim.step();
    EXPECT_EQ(sim.solver().ledger().returned_count, 1) << "it stays inside";
  }
}

TEST(ClosedSides, an_open_side_and_one_that_goes_away_let_out) {
  for (const char* boundary : {"side = \"bottom\"\nkind = \"fixed\"\ncomponents = [\"x\"]",
                               "side = \"bottom\"\nkind = \"velocity\"\nvelocity = [0, -1]", "side = \"top\""}) {
    Case problem =
        read(fmt::format("[grid]\nupper = [1, 1]\ncells = [10, 10]\nparticles_outside = \"stop\"\n[time]\nend = 1\ndt = "
                         "0.1\n[[body]]\nname = \"one\"\nlayout = "
                         "{{ type = \"points\", positions = [[0.55, 0.19]], volumes = [0.01] }}\nvelocity = {{ type = \"uniform\", value = "
                         "[0, -3] }}\nmaterial "
                         "= {{ type = \"neo_hookean\", density = 100, youngs_modulus = 1e-3, poissons_ratio = 0 }}\n[[boundary]]\n{}\n",
                         boundary));
    Simulation sim(problem);
    EXPECT_EQ(sim.run(), RunEnd::particle_left) << boundary;
    EXPECT_EQ(sim.solver().ledger().returned_count, 0);
  }
}

}  // namespace
}  // namespace matpoint::test
