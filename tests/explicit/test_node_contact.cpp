// Contact between bodies with velocity fields of their own.
#include "support/solver_case.hpp"

namespace matpoint::test {
namespace {

/// A box of 2 x 1 (x 0.5) m with cells of 1/12 m.
Case contact_case(int dim, Real friction) {
  Case problem = make_case(dim, {0, 0, 0}, {2, 1, dim == 3 ? 0.5 : 0.0}, {24, 12, 6});
  problem.grid.cells.resize(static_cast<std::size_t>(dim));
  problem.solver.contact = ContactMethod::multi_field;
  problem.solver.friction = friction;
  problem.time.dt = 1e-3;
  return problem;
}

BodySpec block(int dim, const std::string& name, const Vec3& lower, const Vec3& upper, const Vec3& velocity) {
  const std::array<int, 3> count{static_cast<int>(std::lround((upper[0] - lower[0]) * 24)),
                                 static_cast<int>(std::lround((upper[1] - lower[1]) * 24)), 6};
  return make_body(name, lattice(dim, lower, upper, count), neo_hookean(1e5, 0.3, 1000), [=](const Vec3&) { return velocity; });
}

TEST(Contact, three_bodies_at_a_node_keep_momentum_and_never_gain_energy) {
  for (const int dim : {2, 3}) {
    for (const Real friction : {0.0, 0.4}) {
      Case problem = contact_case(dim, friction);
      problem.bodies.push_back(block(dim, "left", {0.3, 0.3, 0.1}, {0.8, 0.8, 0.35}, {0.5, 0.1, 0}));
      problem.bodies.push_back(block(dim, "right low", {0.85, 0.3, 0.1}, {1.35, 0.55, 0.35}, {-0.5, 0, 0}));
      problem.bodies.push_back(block(dim, "right high", {0.85, 0.55, 0.1}, {1.35, 0.8, 0.35}, {-0.5, -0.1, 0}));
      problem.time.end = 0.3;
      Simulation sim(problem);
      const Real scale = momentum_scale(sim.solver());
      const Vec3 start = sums_of(sim.solver()).momentum;
      Real greatest = 0;
      sim.add_callback([&](const Simulation& now) {
        greatest = std::max(greatest, sums_of(now.solver()).energy);
        return true;
      });
      sim.run();
      const Vec3 end = sums_of(sim.solver()).momentum;
      const Vec3 lost = sim.solver().ledger().cutoff_impulse;
      // Round-off of a few eps of the momentum per step.
      for (std::size_t d = 0; d < 3; ++d)
        EXPECT_NEAR(end[d] - start[d] - lost[d], 0, 300 * 10 * k_epsilon * scale) << dim << " " << friction;
      EXPECT_LT(greatest, sim.initial_energy() * (1 + 1e-9)) << dim << " " << friction;
      EXPECT_GT(sim.solver().ledger().contact_dissipation, 0.01 * sim.initial_energy()) << "the bodies should have collided";
    }
  }
}

TEST(Contact, bodies_that_share_nodes_but_do_not_touch_move_freely) {
  // A gap of a cell, closing by a hundredth of it; and bodies that touch, but part.
  for (const auto& [gap, speed] : {std::pair<Real, Real>{1.0 / 12, 0.01}, {0.001, -0.5}}) {
    Case problem = contact_case(2, 0.5);
    problem.bodies.push_back(block(2, "left", {0.3, 0.3, 0}, {0.8, 0.8, 0}, {speed, 0, 0}));
    problem.bodies.push_back(block(2, "right", {0.8 + gap, 0.3, 0}, {1.3 + gap, 0.8, 0}, {0, 0, 0}));
    problem.solver.mass_cutoff = 0;
    problem.time.end = 0.05;
    Simulation sim(problem);
    sim.run();
    EXPECT_EQ(sim.solver().ledger().contact_dissipation, 0);
    EXPECT_NEAR(sim.solver().totals(1).momentum[0], 0, 1e-12);
    EXPECT_NEAR(sim.solver().totals(0).momentum[0], 250 * speed, 1e-10);
  }
}

TEST(Contact, friction_acts_between_bodies_by_coulombs_law) {
  // A wide block falls on another as wide, both free, and slides along x over a flat side that reaches beyond it: the impulses along are
  // mu times those across.
  Real along[2], across[2];
  for (const int k : {0, 1}) {
    Case problem = contact_case(2, 0.2 * k);
    problem.bodies.push_back(block(2, "low", {0.1, 0.1, 0}, {1.9, 0.5, 0}, {0, 0, 0}));
    problem.bodies.push_back(block(2, "high", {0.5, 0.51, 0}, {1.5, 0.9, 0}, {0.3, -0.1, 0}));
    problem.time.end = 0.25;
    Simulation sim(problem);
    sim.run();
    along[k] = sim.solver().totals(0).momentum[0];
    across[k] = -sim.solver().totals(0).momentum[1];
  }
  EXPECT_GT(across[0], 20) << "the block should have fallen on the other";
  // The edges of the upper block press a little along x, too, also without friction.
  EXPECT_NEAR((along[1] - along[0]) / across[1], 0.2, 0.02);
}

TEST(Contact, a_wall_behind_a_body_takes_its_part) {
  Case problem = contact_case(2, 0.3);
  problem.gravity = {0, -5, 0};
  problem.boundaries.push_back(make_side("bottom", BoundaryKind::fixed));
  problem.boundaries.push_back(make_side("left", BoundaryKind::slip));
  problem.bodies.push_back(block(2, "low", {0, 0, 0}, {1, 0.25, 0}, {0, 0, 0}));
  problem.bodies.push_back(block(2, "high", {0, 0.25, 0}, {0.5, 0.75, 0}, {0.2, -0.2, 0}));
  problem.time.end = 0.3;
  Simulation sim(problem);
  const Vec3 start = sums_of(sim.solver()).momentum;
  sim.run();
  const Ledger& ledger = sim.solver().ledger();
  const Vec3 end = sums_of(sim.solver()).momentum;
  for (std::size_t d = 0; d < 2; ++d) {
    const Real booked = ledger.gravity_impulse[d] + ledger.boundary_impulse[d] + ledger.cutoff_impulse[d];
    EXPECT_NEAR(end[d] - start[d] - booked, 0, 1e-10) << d;
  }
  EXPECT_GT(ledger.contact_dissipation, 0);
}

/// A block thrown along a body that the floor holds, over several of its cells: how far it slides, and how far it rises.
std::pair<Real, Real> slide(int dim, StressOrder order) {
  Case problem = contact_case(dim, 0.3);
  problem.time.dt.reset();
  problem.time.end = 0.5;
  problem.gravity = {0, -9.81, 0};
  problem.solver.stress_order = order;
  const Real far = dim == 3 ? 0.35 : 0;
  problem.bodies.push_back(block(dim, "block", {0.25, 0.25, 0.1}, {0.75, 0.75, far}, {1, 0, 0}));
  problem.bodies.push_back(block(dim, "below", {0, 0, 0.1}, {1.5, 0.25, far}, {0, 0, 0}));
  for (BodySpec& body : problem.bodies) body.material = neo_hookean(1e8, 0.3, 1000);
  problem.boundaries.push_back(make_side("bottom", BoundaryKind::fixed));
  Simulation sim(problem);
  const Vec3 start = sim.solver().totals(0).center_of_mass;
  sim.run();
  const Vec3 end = sim.solver().totals(0).center_of_mass;
  return {end[0] - start[0], end[1] - start[1]};
}

// What pressed has one second velocity across the contact; without that a resting block shakes itself loose, and slides 20 % too far. And
// along the direction in which the particles of both are farthest apart: the mean of both bodies' normals leans at the block's edges, so
// that it climbs and is braked.
TEST(Contact, a_block_slides_as_far_as_coulomb_has_it) {
  for (const int dim : {2, 3}) {
    for (const StressOrder order : {StressOrder::musl, StressOrder::usf}) {
      const auto [way, rise] = slide(dim, order);
      EXPECT_NEAR(way, 1 / (2 * 0.3 * 9.81), 0.01 * 0.17) << dim;
      EXPECT_NEAR(rise, 0, 0.01 / 12) << dim;
    }
  }
}

}  // namespace
}  // namespace matpoint::test
