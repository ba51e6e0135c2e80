// Rigid surfaces that let go and rub: sides of the grid and regions with `contact`, explicit solver.
#include <numbers>

#include "support/solver_case.hpp"

namespace matpoint::test {
namespace {

constexpr Real k_gravity = 9.81;
constexpr Real k_cell = 1.0 / 16;

BoundarySpec surface(const std::string& side, FaceContact contact, Real friction = 0) {
  BoundarySpec boundary = make_side(side, BoundaryKind::fixed);
  boundary.contact = contact;
  boundary.friction = friction;
  return boundary;
}

/// A block of .5 x .25 (x .25) m on the side y = 0 of a wide box; gravity is turned as if that side were inclined by `angle` along x, and
/// grows within .2 s, so that the block is pressed on gently.
Case block_on_incline(int dim, Real angle, const BoundarySpec& bottom) {
  Case problem = make_case(dim, {0, 0, 0}, {4, 0.5, dim == 3 ? 0.5 : 0.0}, {64, 8, 8});
  problem.grid.cells.resize(static_cast<std::size_t>(dim));
  const std::array<int, 3> count{16, 8, 8};
  problem.bodies.push_back(make_body("block", lattice(dim, {0.5, 0, 0.125}, {1, 0.25, 0.375}, count), neo_hookean(2e5, 0.3, 1000)));
  problem.gravity = {k_gravity * std::sin(angle), -k_gravity * std::cos(angle), 0};
  problem.gravity_times = {0, 0.2};
  problem.gravity_factors = {0, 1};
  problem.boundaries.push_back(bottom);
  problem.time.dt = 1e-3;
  problem.time.end = 0.6;
  return problem;
}

Real speed_along(const Simulation& sim) { return sim.solver().totals(0).momentum[0] / sim.solver().totals(0).mass; }

void expect_momentum_balance(const Simulation& sim, const Vec3& start, Real tolerance) {
  const Ledger& ledger = sim.solver().ledger();
  const Vec3 end = sums_of(sim.solver()).momentum;
  for (std::size_t d = 0; d < 3; ++d) {
    const Real booked = ledger.gravity_impulse[d] + ledger.boundary_impulse[d] + ledger.cutoff_impulse[d] + ledger.damping_impulse[d];
    EXPECT_NEAR(end[d] - start[d], booked, tolerance) << d;
  }
}

TEST(SurfaceContact, block_on_an_incline_sticks_or_slips_by_coulombs_law) {
  const Real angle = std::atan(0.5);
  for (const int dim : {2, 3}) {
    for (const auto& [order, shape] : {std::pair{StressOrder::usl, ShapeKind::bspline2},
                                       {StressOrder::usf, ShapeKind::linear},
                                       {StressOrder::musl, ShapeKind::linear},
                                       {StressOrder::musl, ShapeKind::gimp},
                                       {StressOrder::usl, ShapeKind::cpdi}}) {
      for (const Real mu : {0.0, 0.2, 0.4, 0.7}) {
        Case problem = block_on_incline(dim, angle, surface("bottom", FaceContact::friction, mu));
        problem.solver.stress_order = order;
        problem.solver.shape = shape;
        problem.solver.mass_cutoff = 0;
        if (dim == 3 && mu != 0.2) continue;
        Simulation sim(problem);
        sim.run();
        // Gravity acts for .1 s less than the time that has passed, and each step takes that of its start. What the block still swings
        // across has pressed less or more.
        const Real time = sim.time() - 0.1 - 0.5 * problem.time.dt.value();
        const Real across = sim.solver().totals(0).momentum[1] / sim.solver().totals(0).mass;
        const Real exact = k_gravity * std::sin(angle) * time - mu * (k_gravity * std::cos(angle) * time + across);
        const Real scale = k_gravity * std::sin(angle) * time;
        // Single nodes stick for a moment while the block swings.
        EXPECT_NEAR(speed_along(sim), mu < 0.5 ? exact : 0, (mu == 0 ? 1e-3 : 4e-3) * scale)
            << dim << " " << order_name(order) << " " << mu;
        expect_momentum_balance(sim, {}, 1e-10);
      }
    }
  }
}

TEST(SurfaceContact, friction_books_its_force_times_the_way_and_rest_nothing) {
  const Real angle = 35 * std::numbers::pi / 180;
  for (const ShapeKind shape : {ShapeKind::linear, ShapeKind::bspline2}) {
    for (const Real cfl : {0.4, 0.1}) {
      Case problem = make_case(2, {0, 0, 0}, {3, 1, 0}, {30, 10});
      problem.bodies.push_back(make_body("block", lattice(2, {0.3, 0, 0}, {0.7, 0.4, 0}, {8, 8, 1}), neo_hookean(1e6, 0.3, 1000)));
      problem.gravity = {k_gravity * std::sin(angle), -k_gravity * std::cos(angle), 0};
      problem.boundaries.push_back(surface("bottom", FaceContact::friction, 0.25));
      problem.solver.mass_cutoff_relative = 0;
      problem.solver.shape = shape;
      problem.time.cfl = cfl;
      problem.time.end = 0.8;
      Simulation slides(problem);
      const Real start = slides.solver().totals(0).center_of_mass[0];
      slides.run();
      const Real way = slides.solver().totals(0).center_of_mass[0] - start;
      const Real taken = 0.25 * 160 * k_gravity * std::cos(angle) * way;
      EXPECT_GT(way, 1.1);
      EXPECT_NEAR(slides.solver().ledger().contact_dissipation, taken, 0.02 * taken) << cfl;
      // A block at rest, that only swings under its sudden weight: next to nothing of its potential energy over the floor.
      problem.gravity = {0, -k_gravity, 0};
      Simulation rests(problem);
      rests.run();
      EXPECT_NEAR(rests.solver().ledger().contact_dissipation, 0, 2e-3 * 160 * k_gravity * 0.2) << cfl;
    }
  }
}

TEST(SurfaceContact, ball_leaves_a_side_that_lets_go) {
  for (const BoundaryKind kind : {BoundaryKind::fixed, BoundaryKind::slip}) {
    for (const StressOrder order : {StressOrder::usf, StressOrder::musl}) {
      Case problem = make_case(2, {0, 0, 0}, {2, 1, 0}, {32, 16});
      problem.bodies.push_back(
          make_body("block", lattice(2, {0.5, 0.25, 0}, {1, 0.75, 0}, {16, 16, 1}), neo_hookean(1e5, 0.3, 1000), [](const Vec3&) {
            return Vec3{0.5, -1, 0};
          }));
      BoundarySpec bottom = make_side("bottom", kind);
      bottom.contact = FaceContact::no_tension;
      problem.boundaries.push_back(bottom);
      problem.solver.stress_order = order;
      problem.solver.mass_cutoff = 0;
      problem.time.dt = 5e-4;
      problem.time.end = 0.7;
      Simulation sim(problem);
      const Vec3 start = sums_of(sim.solver()).momentum;
      Real greatest = 0;
      Real touched = -1;
      sim.add_callback([&](const Simulation& now) {
        greatest = std::max(greatest, sums_of(now.solver()).energy);
        if (touched < 0 && now.solver().ledger().boundary_impulse[1] > 0) touched = now.time();
        return true;
      });
      sim.run();
      EXPECT_NEAR(touched, 0.25, 1e-3) << "when it is there, and not a cell before";
      EXPECT_GT(sim.solver().totals(0).momentum[1] / sim.solver().totals(0).mass, 0.7);
      expect_momentum_balance(sim, start, 1e-10);
      // Free flight makes 1e-5 of noise.
      EXPECT_LE(greatest, sim.initial_energy() * (1 + 1e-4));
      EXPECT_GT(sim.solver().ledger().contact_dissipation, 0);
      if (kind == BoundaryKind::slip) {
        EXPECT_NEAR(sums_of(sim.solver()).momentum[0], start[0], 1e-10);
      }
    }
  }
}

TEST(SurfaceContact, belt_carries_a_block_along_with_mu_n_until_both_are_as_fast) {
  BoundarySpec belt = surface("bottom", FaceContact::friction, 0.3);
  belt.kind = BoundaryKind::velocity;
  belt.velocity = {0.8, 0};
  Case problem = block_on_incline(2, 0, belt);
  problem.solver.mass_cutoff_relative = 1e-3;  // the shear that the belt has put into the block swings on for ever without
  problem.time.end = 0.8;
  Simulation sim(problem);
  bool is_seen = false;
  sim.add_callback([&](const Simulation& now) {
    if (is_seen || now.time() < 0.3 - 1e-9) return true;
    is_seen = true;
    const Ledger& ledger = now.solver().ledger();
    EXPECT_NEAR(speed_along(now), 0.3 * k_gravity * (now.time() - 0.1), 0.01);
    // The belt has worked more than the block has got: the difference went into friction.
    EXPECT_NEAR(ledger.boundary_work, ledger.boundary_impulse[0] * 0.8, 1e-9);
    EXPECT_GT(ledger.contact_dissipation, 0.4 * ledger.boundary_work);
    return true;
  });
  sim.run();
  EXPECT_TRUE(is_seen);
  EXPECT_NEAR(speed_along(sim), 0.8, 0.01);
}

TEST(SurfaceContact, mirror_image_of_a_case_has_the_mirror_image_of_its_motion) {
  Real speed[2];
  for (const int k : {0, 1}) {
    Case problem = block_on_incline(2, k == 0 ? 0.6 : -0.6, surface("bottom", FaceContact::friction, 0.3));
    problem.bodies.clear();
    const Real left = k == 0 ? 1.5 : 2;
    problem.bodies.push_back(make_body("block", lattice(2, {left, 0, 0}, {left + 0.5, 0.25, 0}, {16, 8, 1}), neo_hookean(2e5, 0.3, 1000)));
    Simulation sim(problem);
    sim.run();
    speed[k] = speed_along(sim);
  }
  EXPECT_GT(speed[0], 0.5);
  EXPECT_NEAR(speed[0], -speed[1], 1e-10 * speed[0]);
}

TEST(SurfaceContact, corner_of_a_side_that_holds_and_one_that_rubs) {
  Case problem = block_on_incline(2, 0.3, surface("bottom", FaceContact::friction, 0.1));
  problem.bodies.clear();
  problem.bodies.push_back(make_body("block", lattice(2, {3.5, 0, 0}, {4, 0.25, 0}, {16, 8, 1}), neo_hookean(2e5, 0.3, 1000)));
  problem.boundaries.push_back(make_side("right", BoundaryKind::slip));
  problem.solver.damping = 20;
  problem.time.end = 1;
  Simulation sim(problem);
  sim.run();
  EXPECT_NEAR(speed_along(sim), 0, 1e-3);
  expect_momentum_balance(sim, {}, 1e-9);
}

TEST(SurfaceContact, region_as_an_obstacle_lets_go_and_rubs) {
  // A plane along an axis, but as a region: as the side of the grid, but for its gaps, which are not measured.
  Real speed[2];
  for (const int k : {0, 1}) {
    BoundarySpec bottom = surface("bottom", FaceContact::friction, 0.2);
    if (k == 1) {
      bottom.side.clear();
      bottom.region = read(
                          "[grid]\nupper = [4, 1]\ncell_size = 0.0625\n[time]\nend = 1\n[[body]]\nname = \"b\"\nregion = { type = \"box\", "
                          "lower = [0, 0], upper = [1, 1] }\nlayout = { type = \"per_cell\", count = 4 }\nmaterial = { type = "
                          "\"neo_hookean\", density = 1, youngs_modulus = 1, poissons_ratio = 0.3 }\n[[boundary]]\nkind = \"slip\"\n"
                          "region = { type = \"half_space\", point = [0, 0], normal = [0, 1] }\n")
                          .boundaries[0]
                          .region;
    }
    Simulation sim(block_on_incline(2, 0.5, bottom));
    sim.run();
    speed[k] = speed_along(sim);
  }
  EXPECT_GT(speed[0], 0.5);
  EXPECT_NEAR(speed[1], speed[0], 1e-4 * speed[0]);
}

}  // namespace
}  // namespace matpoint::test
