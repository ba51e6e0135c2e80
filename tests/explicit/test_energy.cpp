// The books of energy and impulse against values that are worked out here on their own, and the FLIP/PIC blend.
// Damping and viscosity are also recomputed by the plain loops of support/reference_mpm.hpp (test_solver_reference.cpp).
#include "support/solver_case.hpp"

namespace matpoint::test {
namespace {

const StressOrder k_orders[] = {StressOrder::usl, StressOrder::usf, StressOrder::musl};

TEST(SolverEnergy, flip_pic_blend_is_the_formula) {
  // Two particles in one cell, at different speeds: all nodal values can be written down. Cell [0, 1]^2, gravity in y.
  const Vec3 x[2] = {{0.2, 0.3, 0}, {0.7, 0.6, 0}};
  const Vec3 v[2] = {{1, 0.5, 0}, {-2, 0.25, 0}};
  const Real g = -10;
  const Real dt = 0.01;
  Real node_v[4][2];
  const auto N = [&](int node, const Vec3& at) { return (node % 2 ? at[0] : 1 - at[0]) * (node / 2 ? at[1] : 1 - at[1]); };
  for (int node = 0; node < 4; ++node) {
    const Real weight[2] = {N(node, x[0]), N(node, x[1])};
    for (std::size_t d = 0; d < 2; ++d) {
      node_v[node][d] = (weight[0] * v[0][d] + weight[1] * v[1][d]) / (weight[0] + weight[1]) + (d == 1 ? g * dt : 0);
    }
  }
  for (const StressOrder order : k_orders) {
    for (const Real flip : {1.0, 0.6, 0.0}) {
      Case problem = make_case(2, {0, 0, 0}, {1, 1, 0}, {1, 1});
      problem.gravity = {0, g, 0};
      problem.solver.stress_order = order;
      problem.solver.flip = flip;
      problem.solver.mass_cutoff = 0;
      problem.time.dt = dt;
      Seeds seeds;
      seeds.position = {x[0], x[1]};
      seeds.volume = {0.5, 0.5};
      // Next to no stiffness: USF has stress in its first step already.
      problem.bodies.push_back(
          make_body("pair", seeds, neo_hookean(1e-14, 0, 1), [&](const Vec3& at) { return at[0] < 0.5 ? v[0] : v[1]; }));
      Simulation sim(problem);
      sim.step();
      const std::vector<Real> new_v = sim.solver().field(0, "velocity").values;
      const std::vector<Real> new_x = sim.solver().field(0, "position").values;
      for (std::size_t p = 0; p < 2; ++p) {
        for (std::size_t d = 0; d < 2; ++d) {
          Real pic = 0;
          for (int node = 0; node < 4; ++node) pic += N(node, x[p]) * node_v[node][d];
          const Real flipped = v[p][d] + (d == 1 ? g * dt : 0);
          EXPECT_NEAR(new_v[2 * p + d], flip * flipped + (1 - flip) * pic, 1e-14) << order_name(order) << " " << flip;
          EXPECT_NEAR(new_x[2 * p + d], x[p][d] + dt * pic, 1e-14) << order_name(order) << " " << flip;
        }
      }
    }
  }
}

/// An elastic bar [0.25, 1.25] x [0, 0.25], nu = 0, between slip walls; the left side of the grid is a piston at its end.
Case piston(StressOrder order, Real speed, Real dt) {
  Case problem = make_case(2, {0.25, 0, 0}, {1.75, 0.25, 0}, {48, 8});
  problem.solver.stress_order = order;
  problem.solver.mass_cutoff = 0;
  problem.bodies.push_back(make_body("bar", lattice(2, {0.25, 0, 0}, {1.25, 0.25, 0}, {64, 16, 1}), neo_hookean(1e4, 0, 1)));
  BoundarySpec wall = make_side("left", BoundaryKind::velocity, {"x"});
  wall.velocity = {speed, 0};
  problem.boundaries.push_back(wall);
  problem.boundaries.push_back(make_side("bottom", BoundaryKind::slip));
  problem.boundaries.push_back(make_side("top", BoundaryKind::slip));
  problem.time.dt = dt;
  problem.time.end = 0.008;  // the wave, c = 100 m/s, has run 0.8 m of the bar's 1 m
  return problem;
}

TEST(SolverEnergy, piston_does_the_work_of_the_one_dimensional_wave) {
  const Real speed = 0.05;
  for (const StressOrder order : k_orders) {
    Simulation sim(piston(order, speed, 2e-5));
    sim.run();
    // Behind the wave: stress rho c v, so impulse rho c v t and work rho c v^2 t per area. The wave's front is smeared over a few
    // cells, and the end particles lie half a particle behind the wall: 3 % of the 0.8 m that the wave has run.
    const Real impulse = 1 * 100 * speed * 0.008 * 0.25;
    const Ledger& ledger = sim.solver().ledger();
    EXPECT_NEAR(ledger.boundary_impulse[0], impulse, 0.03 * impulse) << order_name(order);
    EXPECT_NEAR(ledger.boundary_work, impulse * speed, 0.03 * impulse * speed) << order_name(order);
    const Sums sums = sums_of(sim.solver());
    EXPECT_NEAR(sums.energy, ledger.boundary_work, 0.03 * ledger.boundary_work) << order_name(order);
    // Half of it is kinetic, half is stored: equipartition in a travelling wave.
    EXPECT_NEAR(sums.kinetic_energy, sums.energy / 2, 0.03 * sums.energy) << order_name(order);
  }
}

TEST(SolverEnergy, boundary_work_is_wall_velocity_times_the_momentum_that_the_bodies_gain) {
  // Nothing else acts in x, so in each step the wall's impulse is the change of momentum, whatever happens on the nodes.
  for (const StressOrder order : k_orders) {
    for (const Real flip : {1.0, 0.9}) {
      Case problem = piston(order, 0, 2e-5);
      problem.solver.flip = flip;
      problem.boundaries[0].velocity.clear();
      problem.boundaries[0].times = {0, 0.004, 0.008};
      problem.boundaries[0].velocities = {{0.02, 0, 0}, {0.3, 0, 0}, {-0.1, 0, 0}};
      const auto wall = [](Real t) { return t < 0.004 ? 0.02 + t / 0.004 * 0.28 : 0.3 - (t - 0.004) / 0.004 * 0.4; };
      Simulation sim(problem);
      Real momentum = 0;
      Real work = 0;
      Real turnover = 0;
      sim.add_callback([&](const Simulation& s) {
        const Real P = s.solver().totals(0).momentum[0];
        work += (P - momentum) * wall(s.time());
        turnover += std::abs((P - momentum) * wall(s.time()));
        momentum = P;
        return true;
      });
      sim.run();
      EXPECT_GT(turnover, 1e-3);
      // Momentum of 1024 particles is known to 1024 eps of its size, 400 times.
      const Real round_off = 400 * 1024 * k_epsilon * momentum_scale(sim.solver()) * 0.3;
      EXPECT_NEAR(sim.solver().ledger().boundary_work, work, round_off) << order_name(order) << " " << flip;
      EXPECT_NEAR(sim.solver().ledger().boundary_impulse[0], momentum, round_off);
    }
  }
}

/// A block that falls into a corner with everything that takes or gives energy: gravity, damping, viscosity and a moving floor.
Case busy_case(StressOrder order, Real dt) {
  Case problem = make_case(2, {0, 0, 0}, {2, 1.5, 0}, {16, 12});
  problem.gravity = {1, -3, 0};
  problem.solver.stress_order = order;
  problem.solver.damping = 0.5;
  problem.solver.mass_cutoff = 1e-10;
  problem.bodies.push_back(make_body("solid", lattice(2, {0.3, 0.6, 0}, {0.9, 1.1, 0}, {20, 16, 1}), neo_hookean(2e4, 0.3, 1000)));
  problem.bodies.push_back(make_body("pool", lattice(2, {0, 0, 0}, {2, 0.4, 0}, {64, 13, 1}), newtonian_fluid(1e4, 20, 1000)));
  BoundarySpec floor = make_side("bottom", BoundaryKind::velocity, {"y"});
  floor.velocity = {0, 0.05};
  problem.boundaries = {make_side("left", BoundaryKind::slip), make_side("right", BoundaryKind::slip), floor};
  problem.time.dt = dt;
  problem.time.end = 0.3;
  return problem;
}

TEST(SolverEnergy, ledger_closes_up_to_the_transfer_loss) {
  // Energy that changes hands here: about 800 J of fall. The remainder is what the transfers lose (docs/theory.md).
  for (const StressOrder order : k_orders) {
    Simulation sim(busy_case(order, 1e-4));
    sim.run();
    const Ledger& ledger = sim.solver().ledger();
    EXPECT_GT(ledger.damping_dissipation, 10);
    EXPECT_GT(ledger.viscous_dissipation, 1);
    EXPECT_GT(ledger.boundary_work, 10);
    const Real turnover =
        sums_of(sim.solver()).kinetic_energy + ledger.damping_dissipation + ledger.viscous_dissipation + ledger.boundary_work;
    EXPECT_LT(std::abs(transfer_loss(sim)), 0.02 * turnover) << order_name(order);
    EXPECT_LT(momentum_remainder(sim), 1e-10 * momentum_scale(sim.solver())) << order_name(order);
  }
}

TEST(SolverEnergy, damping_decelerates_a_free_block_as_the_exponential) {
  // dP/dt = -alpha P and dE/dt = -2 alpha E: P_n = P_0 (1 - alpha dt)^n exactly, as all nodes lose the same share.
  for (const StressOrder order : k_orders) {
    Case problem = make_case(2, {0, 0, 0}, {2, 1, 0}, {16, 8});
    problem.solver.stress_order = order;
    problem.solver.damping = 3;
    problem.solver.mass_cutoff = 0;
    problem.bodies.push_back(make_body("block", jittered(lattice(2, {0.2, 0.3, 0}, {0.7, 0.7, 0}, {8, 7, 1}), 2, 0.005),
                                       neo_hookean(1e4, 0.3, 1000), [](const Vec3&) {
                                         return Vec3{1, 0, 0};
                                       }));
    problem.time.dt = 1e-3;
    problem.time.end = 0.3;
    Simulation sim(problem);
    const Real P0 = sim.initial_momentum()[0];
    const Real E0 = sim.initial_energy();
    sim.run();
    const Real factor = std::pow(1 - 3e-3, 300);
    const Sums sums = sums_of(sim.solver());
    EXPECT_NEAR(sums.momentum[0], P0 * factor, 1e-12 * P0) << order_name(order);
    EXPECT_NEAR(sums.kinetic_energy, E0 * factor * factor, 1e-12 * E0) << order_name(order);
    // alpha p v dt with v at the end of the step, against the exact loss alpha dt (p_n + p_n+1) / 2 per step: a relative alpha dt / 2.
    const Real lost = E0 * (1 - factor * factor);
    EXPECT_NEAR(sim.solver().ledger().damping_dissipation, lost, 1.01 * 1.5e-3 * lost) << order_name(order);
    EXPECT_NEAR(sim.solver().ledger().damping_impulse[0], P0 * (factor - 1), 1e-12 * P0) << order_name(order);
  }
}

}  // namespace
}  // namespace matpoint::test
