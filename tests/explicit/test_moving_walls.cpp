// A wall that accelerates takes what sticks to it along, with its full velocity.
#include "io/history.hpp"
#include "support/solver_case.hpp"

namespace matpoint::test {
namespace {

/// A slab, two cells high, on a wall that comes to 1 m/s in half a second and goes on.
std::string slab(int dim) {
  const bool is_3d = dim == 3;
  return fmt::format(R"(
dim = {}
[grid]
upper = {}
cell_size = 0.1
[time]
end = 0.7
[[body]]
name = "slab"
region = {{ type = "box", lower = {}, upper = {} }}
layout = {{ type = "per_cell", count = {} }}
material = {{ type = "neo_hookean", density = 1000, youngs_modulus = 1e6, poissons_ratio = 0.3 }}
[[boundary]]
side = "bottom"
kind = "velocity"
times = [0, 0.5]
velocities = {}
)",
                     dim, is_3d ? "[2, 0.5, 0.5]" : "[2, 1]", is_3d ? "[0.5, 0, 0.1]" : "[0.5, 0]", is_3d ? "[1, 0.2, 0.4]" : "[1.5, 0.2]",
                     is_3d ? 8 : 4, is_3d ? "[[0, 0, 0], [1, 0, 0]]" : "[[0, 0], [1, 0]]");
}

TEST(MovingWalls, what_sticks_to_one_that_accelerates_has_its_velocity_and_momentum_balances) {
  for (const char* scheme : {"linear musl", "gimp musl", "gimp usl", "gimp usf", "bspline2 musl"}) {
    for (const int dim : {2, 3}) {
      const std::string words = scheme;
      Input input = parse_toml(slab(dim), "case.toml");
      apply_set(input, "solver.shape=" + words.substr(0, words.find(' ')));
      apply_set(input, "solver.stress_order=" + words.substr(words.find(' ') + 1));
      if (words == "linear musl") apply_set(input, "time.cfl=0.2");
      Simulation sim(Case::from_input(input, "case"));
      for (const Real t : {0.25, 0.7}) {
        sim.run(nullptr, t);
        const BodyTotals totals = sim.solver().totals(0);
        const Real wall = std::min(1.0, sim.time() / 0.5);
        EXPECT_NEAR(totals.momentum[0] / totals.mass, wall, 0.02) << scheme << " " << dim << "D, t = " << t;
        EXPECT_NEAR(sim.solver().ledger().boundary_impulse[0], totals.momentum[0], 1e-9 * totals.mass);
      }
      const std::vector<Real> v = sim.solver().field(0, "velocity").values;
      for (std::size_t k = 0; k < v.size(); k += static_cast<std::size_t>(dim)) EXPECT_NEAR(v[k], 1, 0.1) << scheme << " " << dim;
      // The work of the wall is the kinetic energy that it gave, but for what the start shook.
      const Real energy = sim.solver().totals(0).kinetic_energy;
      EXPECT_NEAR(sim.solver().ledger().boundary_work, energy, 0.03 * energy) << scheme << " " << dim;
    }
  }
}

}  // namespace
}  // namespace matpoint::test
