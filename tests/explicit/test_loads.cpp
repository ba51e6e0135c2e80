// Loads on particles: momentum and moments are those of the load whatever the numerics, work is what the motion gains, a uniform pressure
// is in balance with a uniform stress, runs go on from states, and what cannot be is refused.
#include <gmock/gmock.h>

#include <numbers>

#include "core/parallel.hpp"
#include "support/block_in_air.hpp"
#include "support/from_toml.hpp"
#include "support/solver_case.hpp"

namespace matpoint::test {
namespace {

constexpr Real pi = std::numbers::pi;

std::string block(int dim, const std::string& solver, const std::string& loads, const std::string& more = "") {
  return block_in_air(dim, dim == 3 ? "[0.4, -1, 2]" : "[0.4, -1]", "0.02", solver, more, loads);
}

const std::string k_loads_2d =
    "[[load]]\nname = \"gas\"\nbody = \"block\"\nkind = \"pressure\"\npressure = 3000\nside = \"bottom\"\nregion = { type = \"box\", lower "
    "= "
    "[0, 0], upper = [1, 2] }\n"
    "[[load]]\nname = \"wind\"\nbody = \"block\"\nkind = \"traction\"\ntraction = [500, 200]\nside = \"left\"\ntimes = [0, 0.01, 0.02]\n"
    "factors = [0, 1, 0.5]\n"
    "[[load]]\nbody = \"block\"\nkind = \"force\"\nforce = [30, -70]\nregion = { type = \"disk\", center = [1.2, 1], radius = 0.1 }\n";
const std::string k_loads_3d =
    "[[load]]\nbody = \"block\"\nkind = \"pressure\"\npressure = 3000\nside = \"front\"\n"
    "[[load]]\nbody = \"block\"\nkind = \"force\"\nforce = [30, -70, 10]\nside = \"right\"\n"
    "[[load]]\nbody = \"block\"\nkind = \"traction\"\ntraction = [30, -70, 10]\n";

class LoadNumerics : public testing::TestWithParam<std::string> {};

TEST_P(LoadNumerics, momentum_is_the_impulse_of_the_loads) {
  for (const int dim : {2, 3}) {
    Simulation sim(read(block(dim, GetParam(), dim == 2 ? k_loads_2d : k_loads_3d), {"time.dt=1e-4", "time.end=0.05"}));
    sim.run();
    EXPECT_LT(momentum_remainder(sim), 1e-12 * momentum_scale(sim.solver())) << dim;
    Vec3 sum{};
    for (const BoundaryTotals& load : sim.solver().boundaries()) {
      for (std::size_t d = 0; d < 3; ++d) sum[d] += load.impulse[d];
    }
    EXPECT_LT(std::abs(sum[0] - sim.solver().ledger().body_force_impulse[0]), 1e-12 * std::abs(sum[0]));
    EXPECT_GT(std::abs(sum[0]), 0.1);
    // Transfers that smooth take much of the waves in so many steps.
    if (GetParam().find("transfer") != std::string::npos && GetParam().find("flip") == std::string::npos) continue;
    EXPECT_LT(std::abs(transfer_loss(sim)), 0.02 * sim.solver().totals(0).kinetic_energy) << dim;
  }
}

INSTANTIATE_TEST_SUITE_P(all, LoadNumerics,
                         testing::Values("", "stress_order = \"usl\"", "stress_order = \"usf\"", "transfer = \"apic\"",
                                         "transfer = \"tpic\"", "transfer = \"fmpm\"", "shape = \"linear\"", "shape = \"bspline2\"",
                                         "shape = \"bspline3\"", "shape = \"cpdi\"\ntransfer = \"flip\"", "co_rotating = false"));

TEST(Loads, have_the_size_that_was_asked_for) {
  Simulation sim(read(block(2, "", k_loads_2d)));
  sim.step();
  std::vector<BoundaryTotals> loads = sim.solver().boundaries();
  ASSERT_EQ(loads.size(), 3u);
  EXPECT_EQ(loads[0].name, "gas");
  EXPECT_NEAR(loads[0].force[1], 3000 * 0.3, 1e-3 * 900);  // of the length that is under it now
  EXPECT_EQ(loads[2].name, "load_3");
  EXPECT_NEAR(loads[2].force[0], 30, 1e-12);
  EXPECT_NEAR(loads[2].force[1], -70, 1e-12);
  while (sim.time() < 0.01) sim.step();
  loads = sim.solver().boundaries();
  const Real factor = 1 - 0.5 * (sim.time() - 0.01) / 0.01;
  EXPECT_NEAR(loads[1].force[0], factor * 500 * 0.3, 1e-9);
  EXPECT_NEAR(loads[1].force[1], factor * 200 * 0.3, 1e-9);
}

/// The angular momentum about the middle of a block, over the moment's. `share`: of the affine velocities, in cell sides squared.
Real turn(const std::string& shape, Real share, const std::string& load, Real moment) {
  Simulation sim(read(block(2, "transfer = \"apic\"\nshape = \"" + shape + "\"", load), {"gravity=[0, 0]", "time.end=0.002"}));
  sim.run();
  const std::vector<Real> x = sim.solver().field(0, "position").values, v = sim.solver().field(0, "velocity").values,
                          C = sim.solver().field(0, "affine_velocity").values, mass = sim.solver().field(0, "mass").values;
  const std::size_t n = C.size() / mass.size(), row = n == 4 ? 2 : 3;
  Real momentum = 0;
  for (std::size_t p = 0; p < mass.size(); ++p) {
    momentum += mass[p] * ((x[2 * p] - 1) * v[2 * p + 1] - (x[2 * p + 1] - 0.95) * v[2 * p]);
    momentum += mass[p] * share * 0.01 * (C[n * p + row] - C[n * p + 1]);
  }
  return momentum / (moment * sim.time());
}

TEST(Loads, have_the_moment_of_the_surface_and_not_of_the_particles_behind_it) {
  // Shear along the upper side: its arm is 0.15, that of the particles 0.125. Affine transfers keep the angular momentum: that of a
  // particle is in its slopes, too.
  const std::string along = "[[load]]\nbody = \"block\"\nkind = \"traction\"\ntraction = [-1000, 0]\nside = \"top\"\n";
  const std::string below =
      "[[load]]\nbody = \"block\"\nkind = \"pressure\"\npressure = 1000\nside = \"bottom\"\nregion = { type = \"box\", lower = [1, 0], "
      "upper = "
      "[2, 2] }\n";
  for (const auto& [shape, share] : {std::pair("bspline2", 1.0 / 4), std::pair("bspline3", 1.0 / 3)}) {
    EXPECT_NEAR(turn(shape, share, along, 1000 * 0.6 * 0.15), 1, 3e-3) << shape;
    EXPECT_NEAR(turn(shape, share, below, 1000 * 0.3 * 0.15), 1, 3e-3) << shape;
  }
}

TEST(Loads, of_one_pressure_all_around_leave_a_body_under_that_stress_at_rest) {
  for (const std::string shape : {"linear", "gimp", "bspline2", "bspline3"}) {
    for (const Real shift : {0.0, 0.05}) {
      const std::string load = "[[load]]\nbody = \"block\"\nkind = \"pressure\"\npressure = 1\n";
      Simulation sim(read(block(2, "shape = \"" + shape + "\"", load),
                          {"gravity=[0, 0]", fmt::format("body.block.region.lower=[{}, 0.8]", 0.7 + shift)}));
      // Of so small a strain that places need not follow.
      const Real K = 1e5 / (3 * (1 - 0.6)), G = 1e5 / 2.6, strain = -1 / (2 * (K + G / 3));
      std::vector<Real> F;
      for (Index p = 0; p < sim.solver().particle_count(0); ++p) F.insert(F.end(), {1 + strain, 0, 0, 0, 1 + strain, 0, 0, 0, 1});
      sim.solver().set_field(0, "deformation_gradient", F);
      sim.step();
      const Real free = 1 / (1000 * 0.1) * sim.last_dt();  // what the pressure would do to a cell at the surface
      // One particle's middle does not integrate the slope of a cubic function exactly.
      EXPECT_LT(greatest_magnitude(sim.solver().field(0, "velocity").values), (shape == "bspline3" ? 1e-2 : 1e-3) * free) << shape << shift;
    }
  }
}

TEST(Loads, do_not_act_where_the_body_lies_on_a_side_that_holds_it) {
  const std::string load = "[[load]]\nbody = \"block\"\nkind = \"pressure\"\npressure = 100\n";
  const std::vector<std::string> sets = {"grid.lower=[0.7, 0]"};
  Simulation free(read(block(2, "", load), sets));
  Simulation held(read(block(2, "", load, "[[boundary]]\nside = \"left\"\nkind = \"slip\"\n"), sets));
  free.step();
  held.step();
  EXPECT_NEAR(free.solver().boundaries().back().force[0], 0, 0.1);
  EXPECT_NEAR(held.solver().boundaries().back().force[0], -100 * 0.3, 0.1);
  const std::string side = "[[load]]\nbody = \"block\"\nkind = \"pressure\"\npressure = 100\nside = \"left\"\n";
  EXPECT_EQ(
      complaint_of([&] { Simulation(read(block(2, "", side, "[[boundary]]\nside = \"left\"\nkind = \"slip\"\n"), sets)); }),
      "case.toml:20: load load_1: no face of the free surface to the left side of body \"block\"; what lies on a side of the grid with a "
      "boundary is not free");
}

TEST(Loads, of_a_ring_are_those_of_the_full_circle) {
  const std::string text = R"(
gravity = [0, 0]
[grid]
axisymmetric = true
upper = [1, 1]
cell_size = 0.1
[time]
end = 0.01
[[body]]
name = "block"
region = { type = "box", lower = [0, 0], upper = [0.5, 0.4] }
layout = { type = "per_cell", count = 4 }
material = { type = "neo_hookean", density = 1000, youngs_modulus = 1e5, poissons_ratio = 0.3 }
)";
  Simulation above(read(text + "[[load]]\nbody = \"block\"\nkind = \"pressure\"\npressure = 10\nside = \"top\"\n"));
  above.step();
  EXPECT_NEAR(above.solver().boundaries()[1].force[1], -10 * pi * 0.25, 1e-2);
  // Rings that have been widened have a larger end.
  std::vector<Real> F;
  for (Index q = 0; q < above.solver().particle_count(0); ++q) F.insert(F.end(), {1, 0, 0, 0, 1, 0, 0, 0, 1.2});
  above.solver().set_field(0, "deformation_gradient", F);
  above.step();
  EXPECT_NEAR(above.solver().boundaries()[1].force[1], -1.2 * 10 * pi * 0.25, 0.1);
  Simulation around(read(text + "[[load]]\nbody = \"block\"\nkind = \"traction\"\ntraction = [10, 0]\nside = \"right\"\n"));
  around.step();
  EXPECT_NEAR(around.solver().boundaries()[1].force[0], 10 * 2 * pi * 0.5 * 0.4, 1e-9);
  // What lies on the axis is no surface.
  EXPECT_THAT(complaint_of([&] {
                Simulation(read(text + "[[load]]\nbody = \"block\"\nkind = \"traction\"\ntraction = [10, 0]\nside = \"left\"\n"));
              }),
              testing::HasSubstr("no face of the free surface to the left side"));
}

TEST(Loads, of_total_lagrangian_bodies_are_the_same) {
  Simulation updated(read(block(2, "shape = \"linear\"", k_loads_2d), {"time.end=0.01"}));
  Simulation total(read(block(2, "shape = \"linear\"", k_loads_2d), {"time.end=0.01", "body.block.formulation=total"}));
  updated.run();
  total.run();
  EXPECT_LT(momentum_remainder(total), 1e-12 * momentum_scale(total.solver()));
  const BodyTotals a = updated.solver().totals(0), b = total.solver().totals(0);
  for (std::size_t d = 0; d < 2; ++d) EXPECT_NEAR(a.momentum[d], b.momentum[d], 0.01 * std::abs(a.momentum[d]));
  EXPECT_NEAR(a.kinetic_energy, b.kinetic_energy, 0.02 * a.kinetic_energy);
}

TEST(Loads, cross_periodic_sides) {
  // A layer that a shear stress on top drags along, around the grid.
  Simulation sim(read(R"(
gravity = [0, 0]
[grid]
upper = [0.4, 1]
cell_size = 0.1
periodic = ["x"]
[time]
end = 0.3
[[body]]
name = "block"
region = { type = "box", lower = [0, 0.2], upper = [0.4, 0.6] }
layout = { type = "per_cell", count = 4 }
velocity = [2, 0]
material = { type = "neo_hookean", density = 1000, youngs_modulus = 1e5, poissons_ratio = 0.3 }
[[load]]
body = "block"
kind = "traction"
traction = [100, 0]
side = "top"
[[load]]
body = "block"
kind = "traction"
traction = [100, 0]
side = "bottom"
)"));
  sim.run();
  const BoundaryTotals top = sim.solver().boundaries()[0];
  EXPECT_NEAR(top.force[0], 40, 1e-10);
  EXPECT_NEAR(sim.solver().totals(0).momentum[0], 160 * 2 + 2 * 40 * 0.3, 1e-9);
  EXPECT_NEAR(top.work, 40 * (2 * 0.3 + 0.5 * 0.5 * 0.3 * 0.3), 0.05);
  EXPECT_NEAR(transfer_loss(sim), 0, 0.05);
  EXPECT_THAT(complaint_of([&] {
                Simulation(read(block(2, "", "[[load]]\nbody = \"block\"\nkind = \"pressure\"\npressure = 1\nside = \"right\"\n"),
                                {"grid.periodic=[\"x\"]", "body.block.region.lower=[0, 0.8]", "body.block.region.upper=[2, 1.1]"}));
              }),
              testing::HasSubstr("no face of the free surface"));
}

TEST(Loads, of_a_body_with_an_initial_stress_are_on_its_surface_as_it_is) {
  const std::string load = "[[load]]\nbody = \"block\"\nkind = \"pressure\"\npressure = 100\nside = \"top\"\n";
  Simulation sim(
      read(block(2, "", load, "initial_stress = { type = \"uniform\", value = [-2e4, -3e4, -1e4, 5e3] }\n"), {"gravity=[0, 0]"}));
  sim.step();
  EXPECT_NEAR(sim.solver().boundaries()[0].force[1], -60, 0.5);
}

TEST(Loads, are_the_same_for_any_number_of_threads) {
  const auto end = [](int threads) {
    set_thread_count(threads);
    Simulation sim(read(block(3, "", k_loads_3d)));
    sim.run();
    set_thread_count(0);
    return sim.save_state();
  };
  EXPECT_EQ(difference_of(end(1), end(3)), "");
}

TEST(Loads, end_with_particles_that_leave) {
  Simulation sim(read(block(2, "", "[[load]]\nbody = \"block\"\nkind = \"force\"\nforce = [2.5e5, 0]\n"),
                      {"grid.particles_outside=remove", "gravity=[0, 0]", "grid.upper=[1.4, 2]"}));
  sim.run();
  EXPECT_LT(sim.solver().particle_count(0), 60);
  EXPECT_GT(sim.solver().particle_count(0), 0);
  EXPECT_LT(momentum_remainder(sim), 1e-10 * 2.5e5 * 0.02);
  EXPECT_LT(sim.solver().boundaries()[0].force[0], 2.5e5);
}

TEST(Loads, that_cannot_be_are_refused) {
  const auto said = [](const std::string& load, const std::vector<std::string>& sets = {}) {
    return complaint_of([&] { Simulation(read(block(2, "", "[[load]]\n" + load), sets)); });
  };
  const std::string push = "body = \"block\"\nkind = \"pressure\"\npressure = 1\n";
  EXPECT_EQ(said("kind = \"force\"\nforce = [1, 0]\n"),
            "case.toml:17: load 1: body is missing (string): The body of particles that it acts on.");
  EXPECT_EQ(said("body = \"blok\"\nkind = \"force\"\nforce = [1, 0]\n"),
            "case.toml:17: load load_1: body = \"blok\" is unknown, allowed: \"block\"; did you mean \"block\"?");
  EXPECT_EQ(said("body = \"block\"\nkind = \"force\"\n"), "case.toml:17: load 1: kind = \"force\" needs force");
  EXPECT_EQ(said("body = \"block\"\nkind = \"force\"\nforce = [1, 0, 0]\n"),
            "case.toml:20: load 1: force has 3 numbers; the case has dim = 2, so it must have 2");
  EXPECT_EQ(said(push + "traction = [1, 0]\n"), "case.toml:21: load 1: traction is for kind = \"traction\" only");
  EXPECT_EQ(
      said(push + "side = \"botom\"\n"),
      "case.toml:21: load 1: side: \"botom\" is unknown, allowed: \"left\", \"right\", \"bottom\" or \"top\"; did you mean \"bottom\"?");
  EXPECT_EQ(said(push + "times = [0, 1]\n"), "case.toml:21: load 1: times has 2 entries and factors 0; they must match");
  EXPECT_EQ(said(push + "times = [0, 0]\nfactors = [0, 1]\n"), "case.toml:21: load 1: times[1] = 0 must be greater than times[0] = 0");
  EXPECT_EQ(said(push + "name = \"block\"\n"),
            "case.toml:17: load block: a load, tool, boundary or body has the name \"block\" already; give each its own");
  EXPECT_EQ(
      said(push + "region = { type = \"disk\", center = [0, 0], radius = 0.1 }\n"),
      "case.toml:17: load load_1: no face of the free surface of body \"block\" has its middle in the region; what lies on a side of the "
      "grid with a boundary is not free");
  EXPECT_EQ(said("body = \"block\"\nkind = \"force\"\nforce = [1, 0]\nregion = { type = \"disk\", center = [0, 0], radius = 0.1 }\n"),
            "case.toml:17: load load_1: no particle of body \"block\" has its middle in the region; enlarge the region");
  EXPECT_THAT(said(push, {"body.block.material={ type = \"newtonian_fluid\", density = 1000, pressure_scale = 1e5 }"}),
              testing::HasSubstr("body \"block\" is a fluid, whose particles do not stay at its surface"));
  EXPECT_THAT(said(push, {"body.block.layout={ type = \"polar\", rings = 4 }",
                          "body.block.region={ type = \"disk\", center = [1, 1], radius = 0.2 }"}),
              testing::HasSubstr("case.toml:17: load load_1: body \"block\": its particles do not lie on a lattice"));
  EXPECT_EQ(said("body = \"block\"\nkind = \"force\"\nforce = [1, 0]\n", {"base_acceleration=[[1, 0]]"}),
            "--set base_acceleration: base_acceleration_times has 0 entries and base_acceleration 1; they must match");
}

TEST(BaseAcceleration, acts_on_all_as_a_weight_that_changes) {
  for (const std::string solver : {"", "stress_order = \"usl\"", "stress_order = \"usf\""}) {
    Simulation sim(read(block(2, solver, ""), {"gravity=[0, -1]", "base_acceleration=[[0, 0], [100, 50], [0, 0]]",
                                               "base_acceleration_times=[0, 0.004, 0.01]", "time.dt=1e-4"}));
    sim.run();
    const BodyTotals totals = sim.solver().totals(0);
    // The integral of the record is 0.5 and 0.25 m/s.
    EXPECT_NEAR(totals.momentum[0] / totals.mass, -0.5, 2e-3);
    EXPECT_NEAR(totals.momentum[1] / totals.mass, -0.25 - 0.02, 2e-3);
    EXPECT_LT(momentum_remainder(sim), 1e-12 * momentum_scale(sim.solver()));
    EXPECT_LT(std::abs(transfer_loss(sim)), 0.02 * totals.kinetic_energy);  // of first order in the step
  }
}

}  // namespace
}  // namespace matpoint::test
