// Rigid tools: they move as told, or as forces and moments say; they and the particles push each other with equal forces; nothing passes;
// runs go on from states, and what cannot be is refused.
#include <gmock/gmock.h>

#include <numbers>

#include "core/parallel.hpp"
#include "explicit/rigid_motion.hpp"
#include "support/block_in_air.hpp"
#include "support/from_toml.hpp"
#include "support/solver_case.hpp"

namespace matpoint::test {
namespace {

constexpr Real pi = std::numbers::pi;

ToolSpec tool(const std::string& shape, int dim) {
  ToolSpec spec;
  spec.name = "tool";
  spec.shape = region(shape, dim);
  return spec;
}

TEST(RigidMotion, goes_as_it_is_told) {
  ToolSpec spec = tool("{ type = 'box', lower = [0, 0], upper = [2, 1] }", 2);
  spec.velocity = {2, -1};
  spec.angular_velocity = {0, 0, pi};
  spec.times = {0, 1, 2};
  spec.factors = {0, 1, 1};
  RigidMotion motion(spec, 2);
  for (int k = 0; k < 200; ++k) motion.advance(0.01 * k, 0.01, {}, {}, {0, -10, 0});
  // The integral of the factors is 1.5.
  EXPECT_NEAR(motion.pivot()[0], 1 + 3, 1e-12);
  EXPECT_NEAR(motion.pivot()[1], 0.5 - 1.5, 1e-12);
  EXPECT_NEAR(motion.turn()[2], 1.5 * pi, 1e-12);
  // The corner (2, 1) is at (1, 0.5) from the middle, and three quarters of a turn later at (0.5, -1).
  const Vec3 start = motion.at_start({4.5, -2, 0});
  EXPECT_NEAR(start[0], 2, 1e-12);
  EXPECT_NEAR(start[1], 1, 1e-12);
  const Vec3 v = motion.velocity_of({4.5, -2, 0});
  EXPECT_NEAR(v[0], 2 + pi, 1e-12);
  EXPECT_NEAR(v[1], -1 + 0.5 * pi, 1e-12);
}

TEST(RigidMotion, turns_about_a_pivot_and_an_axis) {
  ToolSpec spec = tool("{ type = 'box', lower = [0, 0, 0], upper = [1, 1, 1] }", 3);
  spec.angular_velocity = {0, 2, 0};
  spec.pivot = Vec3{0, 0, 0};
  RigidMotion motion(spec, 3);
  for (int k = 0; k < 100; ++k) motion.advance(0, pi / 400, {}, {}, {});
  const Vec3 now = motion.turned({1, 0, 0});  // a quarter of a turn about y
  EXPECT_NEAR(now[0], 0, 1e-12);
  EXPECT_NEAR(now[2], -1, 1e-12);
  EXPECT_NEAR(motion.turn()[1], pi / 2, 1e-12);
}

TEST(RigidMotion, falls_and_is_held) {
  ToolSpec spec = tool("{ type = 'sphere', center = [0, 0, 0], radius = 0.5 }", 3);
  spec.density = 10;
  spec.velocity = {1, 0, 0};
  spec.held = {"z"};
  RigidMotion motion(spec, 3);
  EXPECT_NEAR(motion.mass(), 10 * pi / 6, 1e-12);
  for (int k = 0; k < 1000; ++k) motion.advance(0, 1e-3, {0, 0, 5}, {}, {0, -2, -10});
  EXPECT_NEAR(motion.pivot()[0], 1, 1e-9);
  EXPECT_NEAR(motion.pivot()[1], -1, 2e-3);
  EXPECT_EQ(motion.pivot()[2], 0);
  EXPECT_NEAR(motion.velocity()[1], -2, 1e-9);
}

TEST(RigidMotion, swings_on_a_hinge_with_the_period_of_a_pendulum) {
  // A rod of 1 m, from which gravity and a spring take turns: T = 2 pi sqrt(I / (m g l / 2 + k)).
  ToolSpec spec = tool("{ type = 'box', lower = [-0.01, -1], upper = [0.01, 0] }", 2);
  spec.mass = 3;
  spec.hinge = Vec3{0, 0, 0};
  spec.spring = 7;
  spec.angular_velocity = {0, 0, 0.05};
  RigidMotion motion(spec, 2);
  const Real inertia = 3.0 / 3 + 3 * 0.0004 / 12;
  const Real period = 2 * pi * std::sqrt(inertia / (3 * 9.81 / 2 + 7));
  Real last = 0, crossed = -1, measured = 0;
  for (int k = 0; k < 100000 && measured == 0; ++k) {
    motion.advance(0, 1e-4, {}, {}, {0, -9.81, 0});
    const Real angle = motion.turn()[2];
    if (last < 0 && angle >= 0) crossed < 0 ? (void)(crossed = k * 1e-4) : (void)(measured = k * 1e-4 - crossed);
    last = angle;
  }
  EXPECT_NEAR(measured, period, 1e-3 * period);
}

TEST(RigidMotion, turns_freely_as_eulers_equations_say) {
  ToolSpec spec = tool("{ type = 'box', lower = [0, 0, 0], upper = [0.1, 0.2, 0.4] }", 3);
  spec.mass = 12;
  spec.angular_velocity = {3, 5, 2};
  RigidMotion motion(spec, 3);
  const Vec3 I{0.04 + 0.16, 0.01 + 0.16, 0.01 + 0.04};
  // In the frame of the body, by the rule of Runge and Kutta: I w' = I w x w.
  const auto rate = [&](const Vec3& w) {
    const Vec3 moment = cross({I[0] * w[0], I[1] * w[1], I[2] * w[2]}, w);
    return Vec3{moment[0] / I[0], moment[1] / I[1], moment[2] / I[2]};
  };
  const auto plus = [](const Vec3& a, const Vec3& b, Real f) { return Vec3{a[0] + f * b[0], a[1] + f * b[1], a[2] + f * b[2]}; };
  Vec3 w = spec.angular_velocity;
  constexpr Real dt = 1e-4;
  for (int k = 0; k < 20000; ++k) {
    motion.advance(0, dt, {}, {}, {});
    const Vec3 a = rate(w), b = rate(plus(w, a, dt / 2)), c = rate(plus(w, b, dt / 2)), d = rate(plus(w, c, dt));
    for (std::size_t e = 0; e < 3; ++e) w[e] += dt / 6 * (a[e] + 2 * b[e] + 2 * c[e] + d[e]);
  }
  for (std::size_t e = 0; e < 3; ++e) {
    Vec3 axis{};
    axis[e] = 1;
    EXPECT_NEAR(dot(motion.turned(axis), motion.angular_velocity()), w[e], 1e-5) << e;
  }
}

std::string block(int dim, const std::string& tools, const std::string& solver = "") {
  return block_in_air(dim, dim == 3 ? "[0, -10, 0]" : "[0, -10]", "0.2", solver, "", tools);
}

const std::string k_plate = "[[tool]]\nname = \"plate\"\nshape = { type = \"box\", lower = [0.2, 0.6], upper = [1.8, 0.8] }\n";

class ToolNumerics : public testing::TestWithParam<std::string> {};

TEST_P(ToolNumerics, momentum_of_bodies_and_tools_stays) {
  for (const int dim : {2, 3}) {
    const std::string free = fmt::format(
        "[[tool]]\nname = \"ball\"\nshape = {{ type = \"{}\", center = {}, radius = 0.15 }}\ndensity = 2000\nvelocity = "
        "{}\nangular_velocity = {}\n"
        "friction = 0.4\n",
        dim == 3 ? "sphere" : "disk", dim == 3 ? "[1, 0.6, 0.5]" : "[1.05, 0.6]", dim == 3 ? "[0.5, 3, 0.1]" : "[0.5, 3]",
        dim == 3 ? "[1, 2, 3]" : "4");
    Simulation sim(read(block(dim, free, GetParam())));
    const Real mass = 2000 * (dim == 3 ? 4 * pi / 3 * 0.003375 : pi * 0.0225);
    sim.run();
    EXPECT_LT(momentum_remainder(sim), 1e-12 * momentum_scale(sim.solver())) << dim;
    const BoundaryTotals ball = sim.solver().boundaries()[0];
    EXPECT_GT(ball.impulse[1], 0.1 * mass) << dim;
    const Vec3 start{0.5, 3, 0.1};
    for (std::size_t d = 0; d < static_cast<std::size_t>(dim); ++d) {
      const Real v = number_of(sim.solver(), fmt::format("ball.velocity_{}", "xyz"[d]));
      const Real pulled = d == 1 ? -10 * sim.time() : 0;
      EXPECT_NEAR(mass * (v - start[d] - pulled) + ball.impulse[d], 0, 1e-11 * mass) << dim << d;
    }
    // What the ball has lost the block has gained or rubbed away.
    const Real lost = sim.solver().ledger().boundary_work;
    EXPECT_NEAR(ball.work, lost, 1e-9 * std::abs(lost));
    // Orders and transfers that smooth take much of the waves of a blow.
    if (GetParam().find("usl") != std::string::npos || GetParam().find("apic") != std::string::npos) continue;
    EXPECT_LT(std::abs(transfer_loss(sim)), 0.2 * std::abs(lost)) << dim;
  }
}

INSTANTIATE_TEST_SUITE_P(all, ToolNumerics,
                         testing::Values("", "stress_order = \"usl\"", "stress_order = \"usf\"", "transfer = \"apic\"",
                                         "shape = \"linear\"", "shape = \"bspline2\"", "shape = \"cpdi\"\ntransfer = \"flip\""));

TEST(Tools, on_which_a_body_is_laid_carry_its_weight) {
  for (const Real top : {0.8, 0.81}) {  // also where the lattice has its particles nearer than half a spacing, which is 0.025
    Simulation sim(read(block(2, k_plate, "damping = 40\n"),
                        {fmt::format("body.block.region.lower=[0.7, {}]", top), "body.block.region.upper=[1.1, 1.1]", "time.end=1",
                         fmt::format("tool.plate.shape={{ type = \"box\", lower = [0.2, 0.6], upper = [1.8, {}] }}", top)}));
    sim.step();
    EXPECT_LT(greatest_magnitude(sim.solver().field(0, "velocity").values), 10.1 * sim.last_dt());
    sim.step();
    EXPECT_LT(greatest_magnitude(sim.solver().field(0, "velocity").values), 20.2 * sim.last_dt());
    sim.run();
    const Real weight = sim.solver().totals(0).mass * 10, arm = sim.solver().totals(0).center_of_mass[0] - 1;
    EXPECT_NEAR(arm, -0.1, 0.001);
    EXPECT_NEAR(sim.solver().boundaries()[0].force[1], weight, 0.01 * weight);
    EXPECT_NEAR(number_of(sim.solver(), "plate.torque"), -weight * arm, 0.01 * weight * 0.1);
    EXPECT_LT(number_of(sim.solver(), "plate.overlap"), 0.2);
  }
}

TEST(Tools, on_which_a_body_rests_do_not_make_it_ring) {
  const std::string press = "[[load]]\nbody = \"block\"\nkind = \"pressure\"\npressure = 500\nside = \"top\"\n";
  Simulation sim(read(block(2, k_plate + "friction = 0.3\n" + press),
                      {"time.end=3", "grid.cell_size=0.05", "body.block.region.upper=[1, 1.1]", "body.block.material.youngs_modulus=1e6"}));
  sim.run();
  // Weight and load come at once, and what swings at first has about 0.5 J. Without dashpots 4.6 J are made in 3 s.
  EXPECT_LT(sim.solver().totals(0).kinetic_energy, 0.1);
  EXPECT_GT(transfer_loss(sim), -0.1);
}

TEST(Tools, book_what_friction_takes_where_a_body_sticks) {
  // A block that a plate has brought to its speed, 0.5 m/s, after which nothing slips: m v^2 / 2 went into the motion, as much was rubbed
  // away.
  const std::string plate =
      "[[tool]]\nname = \"plate\"\nshape = { type = \"box\", lower = [-2, 0.6], upper = [4, 0.8] }\nvelocity = [0.5, 0]\n"
      "friction = 0.3\n";
  Simulation sim(read(block(2, plate), {"time.end=0.6", "body.block.material.youngs_modulus=1e6"}));
  sim.run();
  const BodyTotals totals = sim.solver().totals(0);
  const Real kinetic = 0.5 * totals.mass * 0.25;
  EXPECT_NEAR(totals.momentum[0] / totals.mass, 0.5, 0.01);
  EXPECT_NEAR(sim.solver().boundaries()[0].work, 2 * kinetic, 0.05 * kinetic);
  EXPECT_NEAR(sim.solver().ledger().contact_dissipation, kinetic, 0.1 * kinetic);
  EXPECT_LT(std::abs(transfer_loss(sim)), 0.05 * kinetic);
}

TEST(Tools, lift_and_turn_what_lies_on_them) {
  Simulation sim(read(block(2, k_plate + "velocity = [0, 0.5]\nfriction = 0.5\n"), {"time.end=0.6"}));
  sim.run();
  // A piston that starts at once throws the block; after a while it lies on it again.
  EXPECT_NEAR(number_of(sim.solver(), "plate.position_y"), 0.7 + 0.3, 1e-9);
  EXPECT_GT(sim.solver().totals(0).lower[1], 0.8 + 0.3 - 0.01);
  EXPECT_GT(sim.solver().boundaries()[0].work, 0);
}

TEST(Tools, let_nothing_pass) {
  // Sand thrown at a blade of two cells, and a blade that is driven through it.
  const std::string sand =
      "{ type = \"drucker_prager\", density = 1600, youngs_modulus = 1e6, poissons_ratio = 0.3, cohesion = 0, friction_angle = 35 }";
  const std::string blade =
      "[[tool]]\nname = \"blade\"\nshape = { type = \"box\", lower = [1.4, 0.2], upper = [1.6, 1.8] }\nfriction = 0.2\n";
  for (const std::string moved : {"", "velocity = [-5, 0]\n"}) {
    Simulation sim(read(
        block(2, blade + moved),
        {"body.block.material=" + sand, std::string("body.block.velocity=") + (moved.empty() ? "[5, 0]" : "[0, 0]"), "gravity=[0, 0]"}));
    sim.run();
    const Real front = number_of(sim.solver(), "blade.position_x") - 0.1;
    const std::vector<Real> x = sim.solver().field(0, "position").values;
    Real pressed = 0;
    for (std::size_t p = 0; 2 * p < x.size(); ++p) {
      EXPECT_FALSE(x[2 * p] > front && x[2 * p + 1] > 0.25 && x[2 * p + 1] < 1.75) << p;
      pressed += x[2 * p] > front - 0.1 ? 1 : 0;
    }
    EXPECT_GT(pressed, 4);
    EXPECT_GT(std::abs(sim.solver().boundaries()[0].impulse[0]), 100);
  }
}

TEST(Tools, that_fall_out_of_the_grid_end_the_run_with_a_sentence) {
  Simulation sim(
      read(block(2, "[[tool]]\nname = \"stone\"\nshape = { type = \"disk\", center = [0.3, 0.3], radius = 0.1 }\ndensity = 2000\n"),
           {"time.end=1"}));
  std::string said;
  try {
    sim.run();
  } catch (const SolverError& error) {
    said = error.what();
  }
  // 0.4 m down.
  EXPECT_NEAR(sim.time(), std::sqrt(2 * 0.4 / 10), 0.01);
  EXPECT_NE(said.find("tool \"stone\", which moves freely, has left the grid"), std::string::npos) << said;
}

TEST(Tools, press_rings_around_an_axis) {
  Simulation sim(read(R"(
gravity = [0, 0]
[grid]
axisymmetric = true
upper = [1, 1]
cell_size = 0.05
[time]
end = 0.5
[solver]
damping = 100
[[body]]
name = "block"
region = { type = "box", lower = [0, 0], upper = [0.5, 0.6] }
layout = { type = "per_cell", count = 4 }
material = { type = "neo_hookean", density = 1000, youngs_modulus = 1e6, poissons_ratio = 0 }
[[boundary]]
side = "bottom"
kind = "slip"
[[tool]]
name = "piston"
shape = { type = "box", lower = [0, 0.6], upper = [0.9, 0.8] }
velocity = [0, -0.02]
times = [0, 0.3, 0.301]
factors = [1, 1, 0]
)"));
  sim.run();
  const Real moved = 0.7 - number_of(sim.solver(), "piston.position_y");
  // Without Poisson's effect: E times the strain, less what the surface gives.
  const Real stress = 1e6 * moved / 0.6;
  EXPECT_NEAR(-sim.solver().boundaries().back().force[1], stress * pi * 0.25, 0.03 * stress * pi * 0.25);
}

TEST(Tools, are_the_same_for_any_number_of_threads) {
  const auto end = [](int threads) {
    set_thread_count(threads);
    Simulation sim(read(block(3,
                              "[[tool]]\nname = \"ball\"\nshape = { type = \"sphere\", center = [1, 0.64, 0.5], radius = 0.15 }\ndensity = "
                              "2000\nvelocity = [0, 2, 0]\nfriction = 0.4\n"),
                        {"grid.cell_size=0.05"}));
    sim.run();
    set_thread_count(0);
    return sim.save_state();
  };
  EXPECT_EQ(difference_of(end(1), end(3)), "");
}

TEST(Tools, that_cannot_be_are_refused) {
  const auto said = [](const std::string& more, const std::vector<std::string>& sets = {}) {
    return complaint_of([&] { Simulation(read(block(2, k_plate + more), sets)); });
  };
  EXPECT_EQ(
      said("", {"body.block.region.lower=[0.7, 0.7]"}),
      "case.toml:17: tool \"plate\": particle 0 of body \"block\" at (0.725, 0.725) is in it; move it, or cut it out of the body's region");
  EXPECT_EQ(said("hinge = [0, 0]\n"), "case.toml:20: tool \"plate\": hinge is for what moves freely; give the tool a density or a mass");
  EXPECT_EQ(said("density = 1\nmass = 1\n"), "case.toml:21: tool \"plate\": density and mass are both given; give one of them");
  EXPECT_EQ(said("density = 1\nfactors = [1]\n"),
            "case.toml:21: tool \"plate\": factors is for a prescribed motion, and with density or mass the tool moves freely");
  EXPECT_EQ(said("velocity = [1, 0, 0]\n"),
            "case.toml:20: tool \"plate\": velocity has 3 numbers; the case has dim = 2, so it must have 2");
  EXPECT_EQ(said("density = 1\nheld = [\"z\"]\n"),
            "case.toml:21: tool \"plate\": held: \"z\" is unknown, allowed: \"x\", \"y\" or \"rotation\"; did you mean \"x\"?");
  EXPECT_EQ(said("density = 1\nspring = 1\n"), "case.toml:21: tool \"plate\": a spring needs a hinge, in 3D with an axis");
  EXPECT_EQ(said("times = [0, 1]\n"),
            "case.toml:20: tool \"plate\": times goes with factors, of velocity and angular_velocity, or with velocities instead "
            "of velocity");
  EXPECT_EQ(said("fricton = 1\n").substr(0, 58), "case.toml:20: tool \"plate\": unknown key \"fricton\"; did you");
  EXPECT_EQ(said("", {"tool.plate.name=block"}),
            "case.toml:17: tool block: a tool, boundary or body has the name \"block\" already; give each its own");
  EXPECT_EQ(
      said("", {"tool.plate.shape={ type = \"difference\", of = [{ type = \"box\", lower = [0.2, 0.6], upper = [1.8, 0.8] }, { type = "
                "\"disk\", center = [1, 0.7], radius = 0.05 }] }"}),
      "--set tool.plate.shape: tool \"plate\": the surface of this shape is not known; use box, disk, sphere, cylinder, polygon or "
      "half_space, "
      "or a "
      "union of these");
  EXPECT_EQ(said("", {"solver.type=implicit", "time.dt=0.01"}),
            "case.toml:17: tool plate: tools are for solver.type = \"explicit\" only; the implicit one has stiff bodies with contact = "
            "\"pairs\", and "
            "sides that move");
  EXPECT_EQ(said("", {"grid.periodic=[\"x\"]"}), "case.toml:17: tool plate: tools cannot be used with periodic sides");
  EXPECT_EQ(said("velocity = [1, 0]\n", {"grid.axisymmetric=true"}),
            "case.toml:17: tool plate: with grid.axisymmetric = true a tool can only be moved along the axis, by a velocity whose first "
            "number is 0");
}

}  // namespace
}  // namespace matpoint::test
