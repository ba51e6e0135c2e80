// What particles keep for transfers and formulations beside velocity: saved and assigned, booked, and warned of.
#include "support/solver_case.hpp"

namespace matpoint::test {
namespace {

Case turning_block(Transfer transfer, ShapeKind shape, Formulation formulation = Formulation::updated) {
  Case problem = make_case(2, {0, 0, 0}, {2, 1, 0}, {24, 12});
  problem.solver.shape = shape;
  problem.solver.transfer = transfer;
  const Seeds seeds = jittered(lattice(2, {0.6, 0.3, 0}, {1.1, 0.7, 0}, {12, 10, 1}), 2, 0.005);
  problem.bodies.push_back(make_body("block", seeds, neo_hookean(1e5, 0.3, 1000), [](const Vec3& x) {
    return Vec3{0.3 - 2 * (x[1] - 0.5), 2 * (x[0] - 0.8), 0};
  }));
  problem.bodies[0].formulation = formulation;
  problem.time.dt = 1e-3;
  problem.time.end = 0.1;
  return problem;
}

TEST(Transfers, state_that_is_read_and_assigned_goes_on_as_it_would_have) {
  for (const Transfer transfer : {Transfer::flip, Transfer::apic, Transfer::tpic}) {
    for (const Formulation formulation : {Formulation::updated, Formulation::total}) {
      const Case problem = turning_block(transfer, ShapeKind::bspline2, formulation);
      Simulation first(problem);
      for (int n = 0; n < 40; ++n) first.step();
      Simulation second(problem);
      std::vector<std::string> names = {"position", "velocity", "deformation_gradient"};
      if (transfer != Transfer::flip) names.push_back("affine_velocity");  // after the velocity, which sets it to zero
      for (const std::string& name : names) second.set_field(0, name, first.solver().field(0, name).values);
      for (int n = 0; n < 40; ++n) {
        first.step();
        second.step();
      }
      // Places are added up in another way: round-off, which 40 steps pass on.
      for (const char* name : {"position", "velocity"})
        EXPECT_LT(greatest_difference(first.solver().field(0, name).values, second.solver().field(0, name).values), 1e-11) << name;
    }
  }
}

TEST(Transfers, affine_velocity_starts_as_the_gradient_of_the_field) {
  const Simulation sim(turning_block(Transfer::apic, ShapeKind::linear));
  const std::vector<Real> C = sim.solver().field(0, "affine_velocity").values;
  for (std::size_t p = 0; p < C.size(); p += 9) {
    EXPECT_NEAR(C[p + 1], -2, 1e-12);
    EXPECT_NEAR(C[p + 3], 2, 1e-12);
    EXPECT_NEAR(C[p], 0, 1e-12);
  }
}

TEST(Transfers, body_force_of_particles_is_gravity_when_it_is_constant) {
  for (const StressOrder order : {StressOrder::usl, StressOrder::usf, StressOrder::musl}) {
    for (const ShapeKind shape : {ShapeKind::linear, ShapeKind::bspline2}) {
      Case with_gravity = turning_block(Transfer::flip, shape);
      with_gravity.solver.stress_order = order;
      with_gravity.solver.mass_cutoff = 0.02;
      Case with_force = with_gravity;
      with_gravity.gravity = {0.5, -2, 0};
      with_force.body_force = std::make_shared<BodyForce>();
      with_force.body_force->is_of_particles = true;
      with_force.body_force->at = [](Real, const std::vector<Real>&, std::vector<Real>& values) {
        for (std::size_t k = 0; k < values.size(); ++k) values[k] = k % 2 == 0 ? 0.5 : -2;
      };
      Simulation a(with_gravity);
      Simulation b(with_force);
      a.run();
      b.run();
      EXPECT_LT(greatest_difference(a.solver().field(0, "velocity").values, b.solver().field(0, "velocity").values), 1e-11);
      EXPECT_NEAR(b.solver().ledger().body_force_impulse[1], -2 * 200 * 0.1, 1e-10);
      // Work takes the mean of the velocities before and after a step, while positions, and so gravity's energy, follow those after it.
      const Real fallen = a.solver().totals(0).gravitational_energy - Simulation(with_gravity).solver().totals(0).gravitational_energy;
      const Real of_the_step = 0.5 * 200 * (0.5 * 0.5 + 2 * 2) * 1e-3 * 0.1;
      // Nodes under the mass cutoff keep some of the velocity back, but none of the motion (exact to 1e-14 without the cutoff).
      EXPECT_NEAR(b.solver().ledger().body_force_work, -fallen - of_the_step, 1e-4 * std::abs(fallen));
    }
  }
}

TEST(Transfers, short_steps_with_what_damps_in_each_of_them_are_warned_of) {
  const auto warnings = [](Transfer transfer, Real dt) {
    Case problem = turning_block(transfer, ShapeKind::bspline2);
    problem.time.dt = dt;
    return Simulation(problem).warnings();
  };
  EXPECT_TRUE(warnings(Transfer::flip, 1e-6).empty());
  EXPECT_TRUE(warnings(Transfer::apic, 2e-3).empty());
  ASSERT_EQ(warnings(Transfer::apic, 1e-4).size(), 1u);
  EXPECT_NE(warnings(Transfer::apic, 1e-4)[0].find("takes some of the motion in each step"), std::string::npos);
}

}  // namespace
}  // namespace matpoint::test
