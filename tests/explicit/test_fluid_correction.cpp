// Fluids keep their volume and lose what the grid does not see, and the books say so.
#include "case/case_file.hpp"
#include "run/simulation.hpp"
#include "support/solver_case.hpp"

namespace matpoint::test {
namespace {

Case dam(int dim, const std::string& solver, Real end, Real pressure_scale = 57142.857, Real cell_size = 0) {
  const bool is_3d = dim == 3;
  std::string text = fmt::format(R"(
dim = {}
gravity = [0, {}]
[grid]
upper = [1, {}]
cell_size = {}
[time]
end = {}
[solver]
{}
[[body]]
name = "water"
region = {{ type = "box", lower = [0, 0{}], upper = [0.4, {}] }}
layout = {{ type = "per_cell", count = {} }}
material = {{ type = "newtonian_fluid", density = 1000, pressure_scale = {} }}
)",
                                 dim, is_3d ? "0, -9.81" : "-9.81", is_3d ? "0.2, 1" : "1",
                                 cell_size > 0 ? cell_size
                                 : is_3d       ? 0.1
                                               : 0.05,
                                 end, solver, is_3d ? ", 0" : "", is_3d ? "0.2, 0.6" : "0.6", is_3d ? 8 : 4, pressure_scale);
  for (const char* side : {"left", "right", "bottom", "top", "front", "back"}) {
    if (is_3d || (std::string(side) != "front" && std::string(side) != "back")) text += fmt::format("[[boundary]]\nside = \"{}\"\n", side);
  }
  return Case::from_input(parse_toml(text, "dam"), "dam");
}

Real energy_of(const Simulation& sim) {
  const BodyTotals totals = sim.solver().totals(0);
  return totals.kinetic_energy + totals.strain_energy + totals.gravitational_energy;
}

/// Mean height of the center over the last third.
Real height(Simulation& sim, int up) {
  Real sum = 0, time = 0;
  sim.add_callback([&](const Simulation& now) {
    if (now.time() > now.problem().time.end * 2 / 3) {
      sum += now.last_dt() * now.solver().totals(0).center_of_mass[static_cast<std::size_t>(up)];
      time += now.last_dt();
    }
    return true;
  });
  sim.run();
  return sum / time;
}

// At rest 0.12 m; what still sloshes lifts it by some per cent.
TEST(FluidCorrection, keeps_the_volume_and_makes_no_energy) {
  for (const int dim : {2, 3}) {
    for (const char* precision : {"double", "single"}) {
      Simulation sim(dam(dim, fmt::format("precision = \"{}\"", precision), 9));
      const Real start = energy_of(sim);
      Real greatest = 0;
      sim.add_callback([&](const Simulation& now) {
        greatest = std::max(greatest, energy_of(now));
        return true;
      });
      EXPECT_NEAR(height(sim, dim - 1), 0.122, 0.007) << dim << precision;
      EXPECT_LE(greatest, 1.001 * start) << dim << precision;
      EXPECT_GT(sim.solver().ledger().filter_dissipation, 0);
      EXPECT_GT(sim.solver().ledger().shift_work, 0);
    }
  }
}

TEST(FluidCorrection, books_what_it_takes_and_keeps_momentum) {
  // In free fall nothing but the correction and the scheme itself acts on what turns inside.
  Simulation sim(Case::from_input(parse_toml(R"(
gravity = [0, -2]
[grid]
upper = [2, 2]
cell_size = 0.1
[time]
end = 0.5
[[body]]
name = "drop"
region = { type = "disk", center = [1, 1.4], radius = 0.4 }
layout = { type = "per_cell", count = 4 }
velocity = { type = "rotating", center = [1, 1.4], angular_velocity = 1 }
material = { type = "newtonian_fluid", density = 1000, pressure_scale = 57142.857 }
)",
                                             "drop"),
                                  "drop"));
  const Real m = sim.solver().totals(0).mass;
  sim.run();
  const BodyTotals end = sim.solver().totals(0);
  EXPECT_NEAR(end.momentum[0], 0, 1e-10 * m);
  EXPECT_NEAR(end.momentum[1], -m, 1e-10 * m);
  const Ledger& ledger = sim.solver().ledger();
  EXPECT_GT(ledger.filter_dissipation, 0);
  EXPECT_LT(ledger.filter_dissipation, 0.05 * end.kinetic_energy);
}

// A stiffer fluid takes ten times the steps for the same flow and is not damped more.
TEST(FluidCorrection, belongs_to_the_flow_and_not_to_the_steps) {
  Real front[2], taken[2];
  for (const int k : {0, 1}) {
    Simulation sim(dam(2, "", 0.25, k == 0 ? 4e5 / 7 : 4e7 / 7, 0.025));
    sim.run();
    front[k] = sim.solver().totals(0).upper[0];
    taken[k] = sim.solver().ledger().filter_dissipation;
  }
  EXPECT_NEAR(front[1] / front[0], 1, 0.01);
  EXPECT_LT(taken[1], 2 * taken[0]);  // ten times as much, if it were by the step
}

TEST(FluidCorrection, leaves_alone_what_flies) {
  Simulation sim(Case::from_input(parse_toml(R"(
[grid]
upper = [2, 1]
cell_size = 0.05
[time]
end = 0.1
[[body]]
name = "drop"
region = { type = "disk", center = [0.5, 0.5], radius = 0.2 }
layout = { type = "per_cell", count = 4 }
velocity = { type = "uniform", value = [8, 1] }
material = { type = "newtonian_fluid", density = 1000, pressure_scale = 57142.857 }
)",
                                             "drop"),
                                  "drop"));
  const Real start = energy_of(sim);
  sim.run();
  EXPECT_NEAR(energy_of(sim) / start, 1, 1e-12);
  EXPECT_NEAR(sim.solver().ledger().filter_dissipation / start, 0, 1e-12);
}

TEST(FluidCorrection, is_chosen_for_smooth_shapes_and_refused_for_others) {
  EXPECT_TRUE(*dam(2, "", 1).solver.fluid_correction);
  EXPECT_EQ(dam(2, "", 1).solver.shape, ShapeKind::bspline2);
  EXPECT_FALSE(*dam(2, "shape = \"linear\"", 1).solver.fluid_correction);
  EXPECT_THROW(dam(2, "shape = \"linear\"\nfluid_correction = true", 1), InputError);
}

}  // namespace
}  // namespace matpoint::test
