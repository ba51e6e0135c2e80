// Nearly incompressible bodies in the implicit solver: chosen by Poisson's ratio, no locking in motion, books that close.
#include "io/history.hpp"
#include "support/solver_case.hpp"

namespace matpoint::test {
namespace {

const char* const k_beam = R"(
gravity = [0, -9.81]
[grid]
lower = [0, -0.5]
upper = [0.75, 0.5]
cells = [12, 16]
[time]
end = 0.2
dt = 0.004
[solver]
type = "implicit"
[[body]]
name = "beam"
region = { type = "box", lower = [0, -0.125], upper = [0.625, 0.125] }
layout = { type = "per_cell", count = 9 }
material = { type = "neo_hookean", density = 1e4, youngs_modulus = 1.74e6, poissons_ratio = 0.499 }
[[boundary]]
side = "left"
kind = "fixed"
attached = true
)";

TEST(VolumePatches, are_chosen_by_poissons_ratio_unless_said_otherwise) {
  const auto chosen = [](const std::vector<std::string>& sets) { return read(k_beam, sets).bodies[0].has_fbar(); };
  EXPECT_TRUE(chosen({}));
  EXPECT_TRUE(chosen({"body.beam.material.poissons_ratio=0.45"}));
  EXPECT_FALSE(chosen({"body.beam.material.poissons_ratio=0.44"}));
  EXPECT_FALSE(chosen({"body.beam.fbar=false"}));
  EXPECT_TRUE(chosen({"body.beam.material.poissons_ratio=0.3", "body.beam.fbar=true"}));
  EXPECT_TRUE(chosen({"body.beam.material.type=st_venant_kirchhoff"}));
}

TEST(VolumePatches, change_nothing_where_the_volume_changes_evenly) {
  // Between slip sides a column shortens evenly under a moving top, and linear functions of place are in every patch.
  const std::string text = R"(
[grid]
upper = [0.5, 0.5]
cells = [4, 4]
[time]
end = 0.1
dt = 0.02
[solver]
type = "implicit"
mode = "static"
[[body]]
name = "block"
region = { type = "box", lower = [0, 0], upper = [0.5, 0.5] }
layout = { type = "per_cell", count = 9 }
material = { type = "neo_hookean", density = 1000, youngs_modulus = 1e6, poissons_ratio = 0.3 }
[[boundary]]
side = "left"
[[boundary]]
side = "right"
[[boundary]]
side = "bottom"
[[boundary]]
side = "top"
kind = "velocity"
velocity = [0, -0.1]
)";
  std::vector<Real> stress[2];
  for (const bool is_on : {false, true}) {
    Simulation sim(read(text, {is_on ? "body.block.fbar=true" : "body.block.fbar=false", "time.end=0.02"}));
    sim.run();
    stress[is_on ? 1 : 0] = sim.solver().field(0, "stress").values;
  }
  for (std::size_t k = 0; k < stress[0].size(); ++k) EXPECT_NEAR(stress[0][k], stress[1][k], 1e-6 * 1e6 * 0.01);
}

TEST(VolumePatches, a_beam_that_swings_is_not_locked_and_keeps_its_books) {
  const auto run = [](const std::string& fbar, Real& sag) {
    auto sim = std::make_unique<Simulation>(read(k_beam, {"body.beam.fbar=" + fbar}));
    sim->run();
    sag = -sim->solver().totals(0).center_of_mass[1];
    return sim;
  };
  Real locked = 0, free = 0;
  run("false", locked);
  const auto sim = run("true", free);
  EXPECT_GT(free, 1.02 * locked) << "nearly incompressible splines lock without patches";
  const Ledger& ledger = sim->solver().ledger();
  const SystemTotals totals = system_totals(*sim);
  const Real moved = totals.sum.mass * 9.81 * free;
  EXPECT_LT(std::abs(totals.transfer_loss), 2e-3 * moved);
  EXPECT_LT(std::abs(ledger.reset_loss), 0.05 * moved);
  const BodyTotals beam = sim->solver().totals(0);
  for (std::size_t d = 0; d < 2; ++d) {
    EXPECT_NEAR(sim->solver().boundaries()[0].impulse[d] + ledger.gravity_impulse[d], beam.momentum[d],
                1e-8 * std::abs(ledger.gravity_impulse[1]));
  }
  EXPECT_GT(beam.J_min, 0.995);
  EXPECT_LT(beam.J_max, 1.005);
}

}  // namespace
}  // namespace matpoint::test
