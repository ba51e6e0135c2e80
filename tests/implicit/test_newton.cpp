// Newton's method of the implicit solver: it follows prescribed motion at once, finds what softens, cuts steps, and says why it failed.
#include <gmock/gmock.h>

#include <cmath>

#include "implicit/falling_disk.hpp"
#include "implicit/implicit_solver.hpp"
#include "support/solver_case.hpp"
#include "support/temporary_folder.hpp"

namespace matpoint::test {
namespace {

TEST(Newton, prescribed_motion_stretches_a_block_uniformly) {
  // One load step in which the right side moves by 0.1 m; the law's stress at the stretch 1.1 is known.
  Simulation sim(read(R"(
[grid]
upper = [1, 1]
cells = [4, 4]
[time]
end = 1
dt = 1
[solver]
type = "implicit"
mode = "static"
basis = "element"
soft_stiffness = [0, 0]
[[body]]
name = "block"
region = { type = "box", lower = [0, 0], upper = [1, 1] }
layout = { type = "per_cell", count = 16 }
material = { type = "neo_hookean", density = 1000, youngs_modulus = 1e5, poissons_ratio = 0.3 }
[[boundary]]
side = "left"
[[boundary]]
side = "bottom"
[[boundary]]
side = "top"
[[boundary]]
side = "right"
kind = "velocity"
components = ["x"]
times = [0, 1]
velocities = [[0, 0], [-0.2, 0]]
)"));
  sim.run();
  // The body follows in the first increment: without K_fp u_p the first row of cells would be turned inside out before it moves.
  EXPECT_EQ(number_of(sim.solver(), "step_cuts"), 0);
  EXPECT_LE(number_of(sim.solver(), "newton_iterations"), 5);
  EXPECT_EQ(dynamic_cast<const ImplicitSolver<2>&>(sim.solver()).newton_report().halvings, 0);
  const Real stretch = 0.9;
  for (std::size_t p = 0; p < 256; ++p) EXPECT_NEAR(sim.solver().field(0, "J").values[p], stretch, 1e-12);
  const Real mu = 1e5 / 2.6, lambda = 1e5 * 0.3 / (1.3 * 0.4);
  const Real sigma = (mu * (stretch * stretch - 1) + lambda * std::log(stretch)) / stretch;
  EXPECT_NEAR(sim.solver().field(0, "stress").values[0], sigma, 1e-8 * std::abs(sigma));
  // The work of one step is that of the mean of the forces at its start, 0, and at its end.
  const Real force = mu * (stretch - 1 / stretch) + lambda * std::log(stretch) / stretch;
  EXPECT_NEAR(sim.solver().ledger().boundary_work, -0.05 * force, 1e-8 * std::abs(force));
}

TEST(Newton, a_step_that_fails_is_cut_and_the_run_goes_on) {
  // A step in which the disk would fall through the bottom: Newton's method needs shorter ones.
  Simulation sim(read(k_falling_disk, {"solver.iterations_max=5", "time.dt=0.02", "body.disk.velocity.value=[0,-8]"}));
  Real cuts = 0;
  for (int k = 0; k < 10; ++k) {
    sim.step();
    cuts = std::max(cuts, number_of(sim.solver(), "step_cuts"));
  }
  EXPECT_GT(cuts, 0);
  EXPECT_NEAR(sim.time(), 0.2, 1e-12);
  EXPECT_LT(momentum_remainder(sim), 1e-8 * momentum_scale(sim.solver()));
}

TEST(Newton, a_step_that_fails_to_the_end_says_where_and_why) {
  Simulation sim(read(k_falling_disk, {"solver.iterations_max=1", "solver.step_cuts_max=2"}));
  const std::string message = message_of<SolverError>([&] { sim.step(); });
  EXPECT_THAT(
      message,
      testing::HasSubstr(
          "step 1, t = 0 s: Newton's method failed also with the step cut to 0.00125 s (2 times in half): no convergence in 1 iterations"));
  EXPECT_THAT(message_of<SolverError>([&] { sim.step(); }), testing::HasSubstr("broke off"));
}

TEST(Newton, a_motion_that_would_turn_particles_inside_out_is_refused_and_named) {
  Simulation sim(read(k_falling_disk, {"solver.basis=element", "gravity=[0,0]", "solver.step_cuts_max=0", "body.disk.region.center=[1,0.5]",
                                       "body.disk.velocity.value=[0,0]", "body.disk.velocity.angular_velocity=0",
                                       "boundary.1.kind=velocity", "boundary.1.velocity=[0,1e7]"}));
  EXPECT_THAT(message_of<SolverError>([&] { sim.step(); }),
              testing::AllOf(testing::HasSubstr("Newton's method failed"), testing::HasSubstr("of particle")));
}

TEST(Newton, a_bar_that_necks_is_found_without_shorter_steps) {
  // Where the load falls full increments do not converge, in however short a step; halved ones do.
  const std::string text = R"(
[grid]
upper = [6.413e-3, 26.667e-3]
cells = [4, 12]
corners = [[0, 0], [6.297566e-3, 0], [6.413e-3, 26.667e-3], [0, 26.667e-3]]
[time]
end = 1
dt = 0.04
[solver]
type = "implicit"
mode = "static"
basis = "element"
element_order = 1
[[body]]
name = "bar"
method = "elements"
fbar = true
region = { type = "box", lower = [-1, -1], upper = [1, 1] }
material = { type = "j2", density = 7850, youngs_modulus = 206.9e9, poissons_ratio = 0.29, yield_stress = 0.45e9, saturation_stress = 0.715e9, saturation_rate = 16.93, hardening_modulus = 0.12924e9 }
[[boundary]]
side = "top"
kind = "velocity"
velocity = [0, 5e-3]
[[boundary]]
side = "left"
kind = "slip"
[[boundary]]
side = "bottom"
kind = "slip"
)";
  // The load at the end and the greatest, by the search that asks every increment to reduce the residual.
  std::vector<Real> last, greatest;
  for (const std::vector<std::string>& sets : {std::vector<std::string>{}, {"solver.halving=residual"}}) {
    Simulation sim(read(text, sets));
    Real most = 0, cuts = 0, iterations = 0;
    sim.add_callback([&](const Simulation& now) {
      if (now.step_count() == 0) return true;
      most = std::max(most, now.solver().boundaries()[0].force[1]);
      cuts += number_of(now.solver(), "step_cuts");
      iterations += number_of(now.solver(), "newton_iterations");
      return true;
    });
    sim.run();
    EXPECT_EQ(cuts, 0);
    EXPECT_LT(iterations, 600);
    last.push_back(sim.solver().boundaries()[0].force[1]);
    greatest.push_back(most);
  }
  EXPECT_GT(greatest[0], 1.15 * last[0]) << "it should have necked";
  EXPECT_NEAR(last[0], last[1], 1e-6 * last[1]);
  EXPECT_NEAR(greatest[0], greatest[1], 1e-6 * greatest[1]);
}

}  // namespace
}  // namespace matpoint::test
