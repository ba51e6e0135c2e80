// Boundary conditions, obstacles, the mass cutoff, and particles that leave the grid.
#include "support/solver_case.hpp"

namespace matpoint::test {
namespace {

const StressOrder k_orders[] = {StressOrder::usl, StressOrder::usf, StressOrder::musl};

/// Velocity component d of the node (i, j) after the last step.
Real node_velocity(const Simulation& sim, int i, int j, std::size_t d) {
  const Field velocity = sim.solver().grid_fields()[1];
  const auto node = static_cast<std::size_t>(j * sim.solver().grid().nodes[0] + i);
  return velocity.values[node * static_cast<std::size_t>(velocity.components) + d];
}

TEST(Boundaries, tabulated_velocity_is_linear_between_and_constant_outside_its_times) {
  const auto table = [](Real t) { return t <= 0.1 ? 1 : t >= 0.3 ? -2 : 1 - 3 * (t - 0.1) / 0.2; };
  for (const StressOrder order : k_orders) {
    Case problem = make_case(2, {0, 0, 0}, {1, 1, 0}, {4, 4});
    problem.bodies.push_back(make_body("block", lattice(2, {0, 0.25, 0}, {1, 0.75, 0}, {8, 4, 1}), neo_hookean(10, 0.3, 1000)));
    BoundarySpec wall = make_side("left", BoundaryKind::velocity, {"y"});
    wall.times = {0.1, 0.3};
    wall.velocities = {{9, 1, 0}, {9, -2, 0}};
    problem.boundaries = {wall};
    problem.solver.stress_order = order;
    problem.time.dt = 0.02;
    problem.time.end = 0.4;
    Simulation sim(problem);
    sim.add_callback([&](const Simulation& s) {
      if (s.step_count() == 0) return true;
      // In USF, as in the others, the velocity that moves the particles is that of the step's end.
      EXPECT_NEAR(node_velocity(s, 0, 2, 1), table(s.time()), 1e-12) << order_name(order) << " t = " << s.time();
      EXPECT_NE(node_velocity(s, 0, 2, 0), 9) << "the x component is not in the list of components";
      return true;
    });
    sim.run();
  }
}

TEST(Boundaries, fixed_slip_and_component_lists_hold_what_they_name) {
  Case problem = make_case(2, {0, 0, 0}, {1, 1, 0}, {4, 4});
  problem.bodies.push_back(make_body("block", lattice(2, {0, 0, 0}, {1, 1, 0}, {8, 8, 1}), neo_hookean(10, 0.3, 1000), [](const Vec3&) {
    return Vec3{1, 0.5, 0};
  }));
  problem.grid.particles_outside = OutsidePolicy::remove;
  problem.boundaries = {make_side("left", BoundaryKind::slip), make_side("bottom", BoundaryKind::fixed, {"x"}),
                        make_side("right", BoundaryKind::fixed)};
  problem.time.dt = 1e-3;
  Simulation sim(problem);
  sim.step();
  EXPECT_EQ(node_velocity(sim, 0, 2, 0), 0);
  EXPECT_NEAR(node_velocity(sim, 0, 2, 1), 0.5, 1e-12);
  EXPECT_EQ(node_velocity(sim, 2, 0, 0), 0);
  EXPECT_NEAR(node_velocity(sim, 2, 0, 1), 0.5, 1e-12);
  EXPECT_EQ(node_velocity(sim, 4, 2, 0), 0);
  EXPECT_EQ(node_velocity(sim, 4, 2, 1), 0);
  EXPECT_NEAR(node_velocity(sim, 2, 4, 0), 1, 1e-12) << "the top is free";
  EXPECT_EQ(node_velocity(sim, 0, 0, 0), 0) << "a corner gets both";
}

TEST(Boundaries, where_two_conditions_meet_the_later_one_holds) {
  for (const bool is_fixed_last : {true, false}) {
    Case problem = make_case(2, {0, 0, 0}, {1, 1, 0}, {4, 4});
    problem.bodies.push_back(make_body("block", lattice(2, {0, 0, 0}, {1, 1, 0}, {8, 8, 1}), neo_hookean(10, 0.3, 1000)));
    BoundarySpec moving = make_side("bottom", BoundaryKind::velocity);
    moving.velocity = {0.25, 0};
    problem.boundaries = {moving, make_side("left", BoundaryKind::fixed)};
    if (!is_fixed_last) std::swap(problem.boundaries[0], problem.boundaries[1]);
    problem.time.dt = 1e-3;
    Simulation sim(problem);
    sim.step();
    EXPECT_EQ(node_velocity(sim, 0, 0, 0), is_fixed_last ? 0 : 0.25);
  }
}

TEST(Boundaries, obstacle_inside_the_grid_stops_a_body) {
  for (const StressOrder order : k_orders) {
    Case problem = make_case(2, {0, 0, 0}, {2, 1, 0}, {20, 10});
    problem.solver.stress_order = order;
    problem.bodies.push_back(
        make_body("ball", lattice(2, {0.3, 0.3, 0}, {0.7, 0.7, 0}, {8, 8, 1}), neo_hookean(2e3, 0.3, 1000), [](const Vec3&) {
          return Vec3{0.5, 0, 0};
        }));
    BoundarySpec barrier;
    barrier.region = std::make_shared<TestBox>(Vec3{0.999, -1, -1}, Vec3{1.301, 2, 1});
    barrier.kind = BoundaryKind::fixed;
    problem.boundaries = {barrier};
    problem.time.dt = 2e-3;
    problem.time.end = 2;
    Simulation sim(problem);
    Real farthest = 0;
    sim.add_callback([&](const Simulation& s) {
      farthest = std::max(farthest, s.solver().totals(0).upper[0]);
      return true;
    });
    sim.run();
    EXPECT_GT(farthest, 0.9) << "it should have come to the barrier's first cell";
    EXPECT_LT(farthest, 1.0) << "nodes at rest from x = 1 on cannot be passed";
    EXPECT_LT(sim.solver().totals(0).momentum[0], 0) << "it should have rebounded, " << order_name(order);
    EXPECT_LT(momentum_remainder(sim), 1000 * 10 * k_epsilon * sim.solver().totals(0).mass * 0.5);
  }
}

TEST(Boundaries, region_without_a_node_is_refused) {
  Case problem = make_case(2, {0, 0, 0}, {1, 1, 0}, {4, 4});
  problem.bodies.push_back(make_body("block", lattice(2, {0, 0, 0}, {1, 1, 0}, {8, 8, 1}), neo_hookean(10, 0.3, 1000)));
  BoundarySpec needle;
  needle.region = std::make_shared<TestBox>(Vec3{0.3, 0.3, -1}, Vec3{0.4, 0.4, 1});
  problem.boundaries = {needle};
  try {
    Simulation sim(problem);
    FAIL() << "should have thrown";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("boundary 1: its region contains no node of the grid"), std::string::npos) << error.what();
  }
}

TEST(MassCutoff, nodes_under_it_rest_and_relative_means_smallest_particle_mass) {
  // One particle of 2 kg at (0.1, 0.1) of a unit cell: its nodes get 1.62, 0.18, 0.18 and 0.02 kg.
  const auto run = [](std::optional<Real> absolute, Real relative) {
    Case problem = make_case(2, {0, 0, 0}, {2, 2, 0}, {2, 2});
    Seeds seeds;
    seeds.position = {{0.1, 0.1, 0}};
    seeds.volume = {0.002};
    problem.bodies.push_back(make_body("one", seeds, neo_hookean(1, 0, 1000), [](const Vec3&) { return Vec3{1, 0, 0}; }));
    problem.solver.mass_cutoff = absolute;
    problem.solver.mass_cutoff_relative = relative;
    problem.solver.stress_order = StressOrder::usl;
    problem.time.dt = 1e-3;
    Simulation sim(problem);
    sim.step();
    std::array<bool, 3> is_moving{};
    for (std::size_t n = 0; n < 3; ++n) is_moving[n] = node_velocity(sim, n == 0 ? 0 : 1, n == 2 ? 1 : 0, 0) > 0.5;
    return is_moving;
  };
  using Moving = std::array<bool, 3>;  // nodes with 1.62, 0.18 and 0.02 kg
  EXPECT_EQ(run({}, 0.009), (Moving{true, true, true}));
  EXPECT_EQ(run({}, 0.011), (Moving{true, true, false}));
  EXPECT_EQ(run({}, 0.091), (Moving{true, false, false}));
  EXPECT_EQ(run(0.019, 0.5), (Moving{true, true, true})) << "an absolute cutoff replaces the relative one";
  EXPECT_EQ(run(0.021, 1e-3), (Moving{true, true, false}));
  EXPECT_EQ(run(0.19, 1e-3), (Moving{true, false, false}));
}

/// Two particles, 1 kg each, far apart; the right one leaves the grid to the right in step 6. The last 0.01 m take 0.01 s.
Case leaving(OutsidePolicy policy) {
  Case problem = make_case(2, {0, 0, 0}, {8, 1, 0}, {8, 1});
  problem.gravity = {0.5, 0, 0};
  problem.grid.particles_outside = policy;
  Seeds seeds;
  seeds.position = {{1.5, 0.5, 0}, {7.989, 0.5, 0}};
  seeds.volume = {0.001, 0.001};
  problem.bodies.push_back(make_body("pair", seeds, neo_hookean(1, 0, 1000), [](const Vec3& x) {
    return Vec3{x[0] > 4 ? 2.0 : 0.0, 0, 0};
  }));
  problem.time.dt = 1e-3;
  problem.time.end = 0.02;
  problem.solver.mass_cutoff = 0;
  return problem;
}

TEST(ParticlesOutside, error_names_particle_body_time_and_position) {
  Simulation sim(leaving(OutsidePolicy::error));
  try {
    sim.run();
    FAIL() << "should have thrown";
  } catch (const SolverError& error) {
    const std::string text = error.what();
    for (const char* part : {"step 6", "t = 0.006", "particle 1 of body \"pair\"", "left the grid at (8.001", "particles_outside"}) {
      EXPECT_NE(text.find(part), std::string::npos) << part << " is missing in: " << text;
    }
  }
}

TEST(ParticlesOutside, stop_ends_normally_and_keeps_everything) {
  Simulation sim(leaving(OutsidePolicy::stop));
  EXPECT_EQ(sim.run(), RunEnd::particle_left);
  EXPECT_EQ(sim.step_count(), 6);
  EXPECT_EQ(sim.solver().particle_count(0), 2);
  EXPECT_EQ(sim.solver().escapes().size(), 1u);
}

TEST(ParticlesOutside, removed_particle_is_booked_with_mass_momentum_and_energy) {
  for (const StressOrder order : k_orders) {
    Case problem = leaving(OutsidePolicy::remove);
    problem.solver.stress_order = order;
    Simulation sim(problem);
    EXPECT_EQ(sim.run(), RunEnd::finished);
    EXPECT_EQ(sim.solver().particle_count(0), 1);
    EXPECT_EQ(sim.solver().field(0, "id").values, std::vector<Real>{0});
    const Ledger& ledger = sim.solver().ledger();
    EXPECT_EQ(ledger.removed_count, 1);
    EXPECT_DOUBLE_EQ(ledger.removed_mass, 1);
    const Real v = 2 + 6 * 1e-3 * 0.5;  // six steps under gravity
    EXPECT_NEAR(ledger.removed_momentum[0], v, 1e-12);
    const Real x = 7.989 + 1e-3 * (6 * 2 + 0.5e-3 * 21);  // x += dt v with v after the step: 1 + 2 + ... + 6 = 21
    EXPECT_NEAR(ledger.removed_energy, v * v / 2 - 0.5 * x, 1e-9);
    EXPECT_DOUBLE_EQ(sums_of(sim.solver()).mass, 1);
    EXPECT_LT(momentum_remainder(sim), 1e-12);
    // Symplectic Euler under gravity: E changes by dt g (v_n+1 - v_n) / 2 per step and particle, 26 particle-steps of 1.25e-7 J.
    EXPECT_LT(std::abs(transfer_loss(sim)), 26 * 1.3e-7);
  }
}

TEST(FailedRun, inverted_material_stops_with_step_time_body_and_particle) {
  Case problem = make_case(2, {0, 0, 0}, {1, 1, 0}, {4, 4});
  problem.bodies.push_back(
      make_body("soft", lattice(2, {0.25, 0.25, 0}, {0.75, 0.75, 0}, {4, 4, 1}), st_venant_kirchhoff(1, 0.3, 1000), [](const Vec3& x) {
        return Vec3{-200 * (x[0] - 0.5), 0, 0};
      }));
  problem.time.dt = 0.01;
  Simulation sim(problem);
  try {
    sim.run();
    FAIL() << "should have thrown";
  } catch (const SolverError& error) {
    const std::string text = error.what();
    for (const char* part : {"step ", "t = ", "det F = ", "of body \"soft\" at ("}) {
      EXPECT_NE(text.find(part), std::string::npos) << part << " is missing in: " << text;
    }
  }
}

}  // namespace
}  // namespace matpoint::test
