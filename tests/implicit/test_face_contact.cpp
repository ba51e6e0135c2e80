// Sides of the grid that let go at nodes, without and with Coulomb friction, against a point mass on an incline and the ledger.
#include <gmock/gmock.h>

#include "core/parallel.hpp"
#include "implicit/falling_disk.hpp"
#include "implicit/implicit_solver.hpp"
#include "support/solver_case.hpp"

namespace matpoint::test {
namespace {

/// A block on an incline of 30 degrees, pressed on by gravity that grows over five of its periods, so that it hardly bounces.
constexpr const char* k_block = R"(
gravity = [5, -8.660254037844386]
gravity_times = [0, 0.2]
gravity_factors = [0, 1]
[grid]
lower = [0, 0]
upper = [6, 1.5]
cells = [24, 6]
[time]
end = 0.5
dt = 0.01
[solver]
type = "implicit"
[[body]]
name = "block"
region = { type = "box", lower = [0.5, 0], upper = [1.5, 1] }
layout = { type = "per_cell", count = 9 }
material = { type = "neo_hookean", density = 1000, youngs_modulus = 1e7, poissons_ratio = 0.3 }
[[boundary]]
side = "bottom"
kind = "fixed"
contact = "friction"
friction = 0.3
)";

/// The same on a horizontal face in 3D; gravity is given by the test.
constexpr const char* k_solid = R"(
dim = 3
gravity = [0, -8, 0]
gravity_times = [0, 0.1]
gravity_factors = [0, 1]
[grid]
lower = [0, 0, 0]
upper = [4, 2, 4]
cells = [4, 2, 4]
[time]
end = 0.3
dt = 0.01
[solver]
type = "implicit"
[[body]]
name = "block"
region = { type = "box", lower = [0.5, 0, 0.5], upper = [1.5, 1, 1.5] }
layout = { type = "per_cell", count = 27 }
material = { type = "neo_hookean", density = 1000, youngs_modulus = 1e7, poissons_ratio = 0.3 }
[[boundary]]
side = "bottom"
kind = "fixed"
contact = "friction"
friction = 0.3
)";

/// A disk that falls on the bottom of its box, turning, so that it rubs; it bounces.
constexpr const char* k_disk = R"(
gravity = [0, -9.81]
[grid]
lower = [0, 0]
upper = [2, 2]
cells = [10, 10]
[time]
end = 0.3
dt = 0.005
[solver]
type = "implicit"
[[body]]
name = "disk"
region = { type = "disk", center = [1, 0.75], radius = 0.5 }
layout = { type = "per_cell", count = 16 }
velocity = { type = "rotating", center = [1, 0.75], angular_velocity = 8, value = [0.4, -2] }
material = { type = "neo_hookean", density = 1000, youngs_modulus = 1e6, poissons_ratio = 0.3 }
[[boundary]]
side = "bottom"
kind = "fixed"
contact = "friction"
friction = 0.3
)";

void run_to(Simulation& sim, Real t) {
  while (sim.time() < t - 1e-9) sim.step();
}

Vec3 velocity_of(const Simulation& sim) {
  const BodyTotals totals = sim.solver().totals(0);
  return {totals.momentum[0] / totals.mass, totals.momentum[1] / totals.mass, totals.momentum[2] / totals.mass};
}

TEST(FaceFriction, a_block_slides_down_an_incline_by_coulombs_law) {
  Simulation sim(read(k_block));
  run_to(sim, 0.2);
  const Real before = velocity_of(sim)[0];
  run_to(sim, 0.5);
  // What the block still bounces changes the pressure's impulse: measured 2e-4.
  const Real acceleration = (velocity_of(sim)[0] - before) / 0.3;
  EXPECT_NEAR(acceleration / (5 - 0.3 * 8.660254037844386), 1, 1e-3);
  EXPECT_EQ(number_of(sim.solver(), "contact_slipping"), number_of(sim.solver(), "contact_nodes"));
  EXPECT_GT(number_of(sim.solver(), "contact_nodes"), 2);
}

TEST(FaceFriction, where_it_slips_friction_is_mu_times_the_pressure) {
  Simulation sim(read(k_block));
  for (int k = 0; k < 50; ++k) {
    const Vec3 before = sim.solver().ledger().boundary_impulse;
    sim.step();
    const Vec3 after = sim.solver().ledger().boundary_impulse;
    EXPECT_GT(after[1] - before[1], 0);
    if (k < 4) continue;  // until all nodes slip; the impulse of a step has half of the force at its start
    EXPECT_NEAR((before[0] - after[0]) / (after[1] - before[1]), 0.3, 1e-9) << "step " << k;
  }
}

TEST(FaceFriction, below_the_angle_of_friction_a_block_stays) {
  Simulation sim(read(k_block, {"boundary.1.friction=0.7"}));
  run_to(sim, 0.3);
  const BodyTotals before = sim.solver().totals(0);
  const Vec3 impulse = sim.solver().ledger().boundary_impulse;
  run_to(sim, 0.5);
  const BodyTotals after = sim.solver().totals(0);
  // It swings in shear with w = pi/2 (G / rho)^(1/2) / L = 97/s: gravity that grows over T leaves up to 2 g / (w^3 T) of it.
  EXPECT_NEAR(after.center_of_mass[0], before.center_of_mass[0], 1e-4);
  EXPECT_NEAR(impulse[0] - sim.solver().ledger().boundary_impulse[0], 0.2 * 5 * before.mass, 1e-2 * before.mass);
}

TEST(FaceFriction, without_friction_a_face_only_pushes) {
  for (const char* mu : {"0", "0.3"}) {
    Simulation sim(read(k_disk, {fmt::format("boundary.1.friction={}", mu)}));
    Real last = 0, least = 0, greatest = 0;
    for (int k = 0; k < 60; ++k) {
      sim.step();
      const Real now = sim.solver().ledger().boundary_impulse[1];
      least = std::min(least, now - last);
      greatest = std::max(greatest, now - last);
      last = now;
    }
    EXPECT_GE(least, -1e-9 * greatest);
    EXPECT_GT(velocity_of(sim)[1], 0.5);  // it came back
    if (mu[0] != '0' || mu[1] != 0) continue;
    EXPECT_NEAR(sim.solver().ledger().boundary_impulse[0], 0, 1e-9 * last);
    EXPECT_NEAR(sim.solver().ledger().contact_dissipation, 0, 1e-9 * sim.initial_energy());
  }
}

TEST(FaceFriction, momentum_balances_to_rounding_and_friction_takes_energy) {
  for (const char* face : {"[0, 0]", "[-1, 0]"}) {
    Simulation sim(read(k_disk, {"boundary.1.kind=velocity", fmt::format("boundary.1.velocity={}", face)}));
    const Real scale = momentum_scale(sim.solver());
    Real slipping = 0, unsettled = 0;
    for (int k = 0; k < 60; ++k) {
      const Real before = sim.solver().ledger().contact_dissipation;
      sim.step();
      EXPECT_LT(momentum_remainder(sim), 1e-9 * scale) << "step " << k;
      // Half of the force at the start of a step acts in it, and where the slip turns back that half works: in 1 of 120 steps, measured.
      EXPECT_GE(sim.solver().ledger().contact_dissipation, before - 1e-6 * sim.initial_energy()) << "step " << k;
      unsettled += number_of(sim.solver(), "contact_unsettled");
      slipping = std::max(slipping, number_of(sim.solver(), "contact_slipping"));
    }
    EXPECT_GT(slipping, 1);
    EXPECT_LE(unsettled, 1);  // of some 300 nodes
    EXPECT_GT(sim.solver().ledger().contact_dissipation, 0.01 * sim.initial_energy());
    EXPECT_LT(std::abs(transfer_loss(sim)), 1e-3 * sim.initial_energy());
  }
}

TEST(FaceFriction, a_stiff_disk_that_lies_on_its_face_stays_in_the_grid) {
  // Waves cross tens of cells in a step, and no set agrees with accelerations of its own: in the third step nodes would enter the face, and
  // particles leave.
  Simulation sim(read(R"(
gravity = [6.936717523440032, -6.936717523440032]
[grid]
lower = [-2, -1.6]
upper = [2.5, 1.8375]
cells = [15, 11]
[time]
end = 0.03
dt = 0.01
[solver]
type = "implicit"
beta = 0.3
initial_acceleration = "zero"
soft_stiffness = [1e-5, 1e-9]
[[body]]
name = "disk"
region = { type = "disk", center = [0, 0], radius = 1.6 }
layout = { type = "layered_disk", core_radius = 1.4, points = 300, layers = 22, normalized = false }
material = { type = "neo_hookean", density = 1000, youngs_modulus = 4.2e8, poissons_ratio = 0.4 }
[[boundary]]
side = "bottom"
kind = "fixed"
contact = "friction"
friction = 0.2
)"));
  EXPECT_NO_THROW(sim.run());
  // It slips by Coulomb's law, but for half a step at most: its first acceleration is 0.
  EXPECT_NEAR(velocity_of(sim)[0], 0.8 * 6.9367 * 0.03, 0.8 * 6.9367 * 0.005);
}

TEST(FaceFriction, dissipation_is_friction_times_slip) {
  Simulation sim(read(k_block));
  run_to(sim, 0.2);
  const Ledger start = sim.solver().ledger();
  const Real x_start = sim.solver().totals(0).center_of_mass[0];
  run_to(sim, 0.5);
  const Ledger end = sim.solver().ledger();
  const Real x_end = sim.solver().totals(0).center_of_mass[0];
  // The force is constant, but for the bounce.
  const Real expected = 0.3 * 8.660254037844386 * 1000 * (x_end - x_start);
  EXPECT_NEAR((end.contact_dissipation - start.contact_dissipation) / expected, 1, 2e-3);
  EXPECT_NEAR(end.boundary_work - start.boundary_work, 0, 1e-4 * expected);
}

TEST(FaceFriction, a_moving_face_drags_a_block_until_it_follows) {
  // 0.5 x 10 m/s^2 up to 1 m/s: 0.1 s of gravity that grows to 5 m/s^2, then 0.15 s.
  Simulation sim(read(k_block, {"gravity=[0,-10]", "gravity_times=[0,0.1]", "boundary.1.kind=velocity", "boundary.1.velocity=[1,0]",
                                "boundary.1.friction=0.5"}));
  run_to(sim, 0.2);
  EXPECT_NEAR(velocity_of(sim)[0], 0.75, 2e-3);
  EXPECT_NEAR(sim.solver().ledger().boundary_impulse[0], 0.5 * sim.solver().ledger().boundary_impulse[1], 1e-6 * 1000);
  run_to(sim, 0.35);
  const Real x = sim.solver().totals(0).center_of_mass[0];
  run_to(sim, 0.5);
  // Caught at once, it swings in shear by a / w^2 = 5e-4 m (w as above) about the face's motion.
  EXPECT_NEAR((sim.solver().totals(0).center_of_mass[0] - x) / 0.15, 1, 1e-2);
  // The face works F V t, half of which is left as kinetic energy.
  const Ledger& ledger = sim.solver().ledger();
  EXPECT_NEAR(ledger.boundary_work, ledger.boundary_impulse[0], 1e-3 * ledger.boundary_work);
  EXPECT_NEAR(ledger.contact_dissipation, 500, 10);
}

TEST(FaceFriction, turned_and_mirrored_it_is_the_same) {
  const auto totals = [](const std::vector<std::string>& sets) {
    Simulation sim(read(k_disk, sets));
    for (int k = 0; k < 40; ++k) sim.step();
    EXPECT_GT(sim.solver().ledger().contact_dissipation, 0);
    return sim.solver().totals(0);
  };
  const BodyTotals one = totals({});
  const BodyTotals mirrored = totals({"body.disk.velocity.angular_velocity=-8", "body.disk.velocity.value=[-0.4,-2]"});
  EXPECT_NEAR(mirrored.center_of_mass[0], 2 - one.center_of_mass[0], 1e-9);
  EXPECT_NEAR(mirrored.center_of_mass[1], one.center_of_mass[1], 1e-9);
  EXPECT_NEAR(mirrored.momentum[0], -one.momentum[0], 1e-6 * std::abs(one.momentum[0]));
  // x' = 2 - y, y' = x: the bottom becomes the right side, with the other sense of its normal.
  const BodyTotals turned = totals({"gravity=[9.81,0]", "body.disk.region.center=[1.25,1]", "body.disk.velocity.center=[1.25,1]",
                                    "body.disk.velocity.value=[2,0.4]", "boundary.1.side=right"});
  EXPECT_NEAR(turned.center_of_mass[0], 2 - one.center_of_mass[1], 1e-9);
  EXPECT_NEAR(turned.center_of_mass[1], one.center_of_mass[0], 1e-9);
}

TEST(FaceFriction, in_3d_it_acts_against_the_slip) {
  Simulation sim(read(k_solid, {"gravity=[3,-8,4]"}));
  run_to(sim, 0.1);
  const Vec3 before = sim.solver().ledger().boundary_impulse;
  run_to(sim, 0.3);
  const Vec3 after = sim.solver().ledger().boundary_impulse;
  // The nodes slip in directions of their own, as the block bounces and shears: the sum is a little less than mu of the pressure.
  const Real limit = 0.3 * (after[1] - before[1]);
  EXPECT_NEAR((before[0] - after[0]) / limit, 0.6, 0.01);
  EXPECT_NEAR((before[2] - after[2]) / limit, 0.8, 0.01);
  EXPECT_LT(std::hypot(before[0] - after[0], before[2] - after[2]), limit * (1 + 1e-6));
  EXPECT_LT(momentum_remainder(sim), 1e-9 * momentum_scale(sim.solver()));
}

TEST(FaceFriction, in_3d_the_direction_follows_a_motion_that_turns) {
  // Thrown across the slope: dv/dt = g_t - mu N v / |v|, beside the midpoint rule for a point mass under the same N and g_t.
  Simulation sim(read(k_solid, {"gravity=[6,-8,0]", "body.block.velocity={ type = \"uniform\", value = [0, 0, 1] }"}));
  const Real mass = sim.solver().totals(0).mass;
  constexpr int k_parts = 100;
  Real v[2] = {0, 1};
  while (sim.time() < 0.3 - 1e-9) {
    const Ledger before = sim.solver().ledger();
    sim.step();
    const Ledger& after = sim.solver().ledger();
    const Real friction = 0.3 * (after.boundary_impulse[1] - before.boundary_impulse[1]) / mass / k_parts;
    const Real load = (after.gravity_impulse[0] - before.gravity_impulse[0]) / mass / k_parts;
    for (int part = 0; part < k_parts; ++part) {
      const Real speed = std::hypot(v[0], v[1]);
      const Real middle[2] = {v[0] + 0.5 * (load - friction * v[0] / speed), v[1] - 0.5 * friction * v[1] / speed};
      const Real speed_middle = std::hypot(middle[0], middle[1]);
      v[0] += load - friction * middle[0] / speed_middle;
      v[1] -= friction * middle[1] / speed_middle;
    }
    EXPECT_EQ(number_of(sim.solver(), "contact_unsettled"), 0);
  }
  EXPECT_NEAR(velocity_of(sim)[0], v[0], 0.02);
  EXPECT_NEAR(velocity_of(sim)[2], v[1], 0.02);
  EXPECT_GT(v[0], 1);
  EXPECT_LT(v[1], 0.7);  // by far not where it was thrown
}

TEST(FaceFriction, any_number_of_threads_gives_the_same_bits) {
  std::vector<Real> first;
  const int before = thread_count();
  for (const int threads : {1, 3}) {
    set_thread_count(threads);
    Simulation sim(read(k_disk));
    for (int k = 0; k < 30; ++k) sim.step();
    if (first.empty()) first = sim.solver().field(0, "velocity").values;
    EXPECT_EQ(first, sim.solver().field(0, "velocity").values);
  }
  set_thread_count(before);
}

TEST(FaceContact, a_face_without_tension_pushes_and_never_pulls) {
  const auto bounce = [](const char* contact, Real& least, Real& greatest) {
    Simulation sim(read(k_falling_disk, {"time.end=0.5", "body.disk.velocity.value=[0,-2]", "body.disk.velocity.angular_velocity=0",
                                         fmt::format("boundary.1.contact={}", contact)}));
    const Real scale = momentum_scale(sim.solver());
    Real last = 0, speed = 0;
    sim.add_callback([&](const Simulation& s) {
      const Real now = s.solver().ledger().boundary_impulse[1];
      least = std::min(least, now - last);
      greatest = std::max(greatest, now - last);
      last = now;
      speed = std::max(speed, s.solver().totals(0).momentum[1] / s.solver().totals(0).mass);
      EXPECT_LT(momentum_remainder(s), 1e-9 * scale);
      return true;
    });
    sim.run();
    return speed;
  };
  Real least = 0, greatest = 0, least_stick = 0, greatest_stick = 0;
  // The explicit solver has 2.78 m/s on 80 cells.
  EXPECT_NEAR(bounce("no_tension", least, greatest), 2.78, 0.05);
  EXPECT_GE(least, -1e-9 * greatest);
  bounce("stick", least_stick, greatest_stick);
  EXPECT_LT(least_stick, -1e-3 * greatest_stick);  // a face that holds does pull
}

// With the accelerations that particles carry from the background of the step before these gained up to 14 % of their kinetic energy.
TEST(FaceContact, a_bounce_makes_no_energy) {
  for (const char* shape :
       {"{ type = \"box\", lower = [0.3, 0.3], upper = [0.7, 0.7] }", "{ type = \"disk\", center = [0.5, 0.5], radius = 0.2 }",
        "{ type = \"box\", lower = [0.3, 0.3, 0.3], upper = [0.7, 0.7, 0.7] }"}) {
    const bool is_3d = std::string(shape).find("0.3, 0.3, 0.3") != std::string::npos;
    for (const char* contact : {"contact = \"no_tension\"", "contact = \"friction\"\nfriction = 0.3"}) {
      for (const char* E : {"1e5", "1e7"}) {
        Simulation sim(read(fmt::format(R"(
dim = {0}
gravity = [0, -9.81{1}]
[grid]
upper = [1, 1{2}]
cell_size = {7}
[time]
end = 0.12
dt = 2e-3
[solver]
type = "implicit"
[[body]]
name = "body"
region = {3}
layout = {{ type = "per_cell", count = {4} }}
velocity = {{ type = "uniform", value = [0.5, -3{1}] }}
material = {{ type = "neo_hookean", density = 1000, youngs_modulus = {5}, poissons_ratio = 0.3 }}
[[boundary]]
side = "bottom"
kind = "fixed"
{6}
)",
                                        is_3d ? 3 : 2, is_3d ? ", 0" : "", is_3d ? ", 1" : "", shape, is_3d ? 27 : 16, E, contact,
                                        is_3d ? 0.2 : 0.1)));
        const BodyTotals start = sim.solver().totals(0);
        const Real before = sim.initial_energy();
        Real greatest = 0;
        sim.add_callback([&](const Simulation& now) {
          const BodyTotals totals = now.solver().totals(0);
          greatest = std::max(greatest, totals.kinetic_energy + totals.strain_energy + totals.gravitational_energy - before);
          return true;
        });
        sim.run();
        EXPECT_LT(greatest, 1e-4 * start.kinetic_energy) << shape << contact << E;
        EXPECT_GT(sim.solver().ledger().boundary_impulse[1], start.mass) << "it should have hit the bottom";
        EXPECT_LT(momentum_remainder(sim), 1e-9 * momentum_scale(sim.solver()));
      }
    }
  }
}

TEST(FaceContact, in_a_corner_a_node_is_let_go_by_its_face_only) {
  // Lifted off the bottom and pressed against a slip wall at the left: the wall holds on, also in the corner. Both orders of the
  // conditions.
  for (const bool wall_first : {true, false}) {
    const std::string wall = "[[boundary]]\nside = \"left\"\nkind = \"slip\"\n";
    std::string text = k_falling_disk;
    text = text.substr(0, text.find("[[boundary]]")) + (wall_first ? wall : "") +
           "[[boundary]]\nside = \"bottom\"\nkind = \"fixed\"\ncontact = \"no_tension\"\n" + (wall_first ? "" : wall);
    Simulation sim(read(text, {"gravity=[-20,5]", "body.disk.velocity.value=[0,0]", "body.disk.velocity.angular_velocity=0",
                               "body.disk.region={ type = \"box\", lower = [0, 0], upper = [0.6, 0.6] }"}));
    auto& solver = dynamic_cast<ImplicitSolver<2>&>(sim.solver());
    int let_go = 0;
    for (int k = 0; k < 40; ++k) {
      sim.step();
      EXPECT_GE(solver.totals(0).lower[0], 0);
      const std::vector<Index>& nodes = solver.space().nodes();
      if (nodes.front() != 0) continue;  // the corner's node, while particles are near
      EXPECT_EQ(solver.space().unknown(0, 0), -1) << "step " << k << ", wall first: " << wall_first;
      let_go += solver.space().unknown(0, 1) >= 0 ? 1 : 0;
    }
    EXPECT_GT(let_go, 0) << "wall first: " << wall_first;
    const BodyTotals totals = sim.solver().totals(0);
    EXPECT_NEAR(totals.momentum[1] / totals.mass, 5 * 0.2, 0.1);
    EXPECT_GT(sim.solver().ledger().boundary_impulse[0] / totals.mass, 0.5 * 20 * 0.2);
  }
}

}  // namespace
}  // namespace matpoint::test
