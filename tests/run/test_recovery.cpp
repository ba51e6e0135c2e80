// A step that fails is not the end: the run goes back and takes smaller ones, and its results are those of a run that always did.
#include <fstream>
#include <regex>

#include "core/parallel.hpp"
#include "io/results_folder.hpp"
#include "run/restart.hpp"
#include "support/from_toml.hpp"
#include "support/solver_case.hpp"
#include "support/temporary_folder.hpp"

namespace matpoint::test {
namespace {

namespace fs = std::filesystem;

/// A ball that is thrown into the corner of a closed box: with APIC and the longest steps it is turned inside out at the wall.
constexpr const char* k_ball = R"(
gravity = [0, -9.81]
[grid]
upper = [1, 1]
cells = [20, 20]
[solver]
transfer = "apic"
[[body]]
name = "ball"
region = { type = "disk", center = [0.3, 0.3], radius = 0.15 }
layout = { type = "per_cell", count = 4 }
velocity = { type = "uniform", value = [6, -8] }
material = { type = "neo_hookean", density = 1000, youngs_modulus = 2e4, poissons_ratio = 0.3 }
[[boundary]]
side = "left"
kind = "slip"
[[boundary]]
side = "right"
kind = "slip"
[[boundary]]
side = "bottom"
kind = "slip"
[[boundary]]
side = "top"
kind = "slip"
)";

Case ball(const std::vector<std::string>& sets) {
  Input input = parse_toml(k_ball, "case.toml");
  for (const std::string& set : sets) apply_set(input, set);
  return Case::from_input(input, "case");
}

std::vector<Real> positions(const Simulation& simulation) { return simulation.solver().field(0, "position").values; }

Snapshot now_of(const Simulation& simulation) { return simulation; }

std::string read_file(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// What run() throws.
std::string failure_of(Simulation& simulation, ResultsFolder* results = nullptr) {
  try {
    simulation.run(results);
  } catch (const SolverError& error) {
    return error.what();
  }
  return "";
}

TEST(Recovery, a_step_that_fails_is_taken_again_smaller) {
  const std::vector<std::string> long_steps = {"time.end=60", "time.cfl=1"};
  Simulation sim(ball(long_steps));
  EXPECT_EQ(sim.run(), RunEnd::finished);
  const Snapshot now = now_of(sim);
  EXPECT_GE(now.failed_steps, 1);
  EXPECT_GT(now.redone_steps, 0);
  EXPECT_LT(static_cast<Real>(now.redone_steps), 0.01 * static_cast<Real>(now.step));
  EXPECT_TRUE(std::any_of(sim.health().begin(), sim.health().end(), [](const HealthLine& line) { return line.name == "steps"; }));
  // At the end it lies on the floor, as it does after a run with ordinary steps.
  Simulation ordinary(ball({"time.end=60"}));
  ordinary.run();
  EXPECT_EQ(now_of(ordinary).failed_steps, 0);
  const auto energy = [](const Simulation& of) {
    const BodyTotals totals = of.solver().totals(0);
    return totals.kinetic_energy + totals.strain_energy + totals.gravitational_energy;
  };
  EXPECT_NEAR(energy(sim), energy(ordinary), 0.02 * sim.initial_energy());

  std::vector<std::string> no_cuts = long_steps;
  no_cuts.push_back("time.step_cuts_max=0");
  Simulation without(ball(no_cuts));
  EXPECT_NE(failure_of(without).find("is not positive"), std::string::npos);
}

TEST(Recovery, results_are_those_of_a_run_that_took_smaller_steps_from_the_start) {
  // The failure comes before a second state is kept: all of the run is taken again, half as long.
  const TemporaryFolder folder;
  const auto run = [&](const std::string& name, const std::string& cfl) {
    Simulation sim(ball({"time.end=0.4", "time.cfl=" + cfl, "output.history_every=0.004", "output.fields_every=0.01",
                         "output.formats=[\"vtkhdf\", \"vtu\"]", "output.checkpoint_steps=25"}));
    ResultsFolder results(folder.path() / name);
    results.begin(sim, 1);
    EXPECT_EQ(sim.run(&results), RunEnd::finished);
    results.finish(sim, "finished");
    return now_of(sim).failed_steps;
  };
  EXPECT_EQ(run("long", "1"), 1);
  EXPECT_EQ(run("short", "0.5"), 0);
  for (const char* file : {"history.csv", "ball.vtkhdf", "ball.pvd", "vtkhdf/ball_000020.h5"})
    EXPECT_EQ(read_file(folder.path() / "long" / file), read_file(folder.path() / "short" / file)) << file;
  const std::vector<fs::path> all = checkpoints_of(folder.path() / "long");
  ASSERT_EQ(all.size(), 2u);
  for (std::size_t k = 0; k < 2; ++k) EXPECT_EQ(all[k].filename(), checkpoints_of(folder.path() / "short")[k].filename());
}

TEST(Recovery, no_checkpoint_of_what_was_thrown_away_is_left) {
  const TemporaryFolder folder;
  Simulation sim(ball({"time.end=0.4", "time.cfl=1", "output.checkpoint_steps=25"}));
  ResultsFolder results(folder.path() / "results");
  results.begin(sim, 1);
  bool has_gone_back = false;
  Index last = 0;
  sim.add_callback([&](const Simulation& now) {
    has_gone_back = has_gone_back || now.step_count() < last;
    last = now.step_count();
    return !(has_gone_back && last == 5);
  });
  EXPECT_EQ(sim.run(&results), RunEnd::stopped_by_callback);
  results.wait();
  const std::vector<fs::path> all = checkpoints_of(folder.path() / "results");
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].filename(), "step_000000000000.h5");
  Simulation again(ball({"time.end=0.4", "time.cfl=1"}));
  again.load_state(find_state(folder.path() / "results").table);
  again.run();
  EXPECT_EQ(again.time(), 0.4);
}

TEST(Recovery, a_state_saved_after_it_goes_on_with_the_same_bits) {
  const std::vector<std::string> sets = {"time.end=0.4", "time.cfl=1"};
  Simulation whole(ball(sets));
  StateTable saved;
  whole.add_callback([&](const Simulation& now) {
    if (now_of(now).failed_steps == 1 && saved.empty() && now.time() > 0.25) saved = whole.save_state();
    return true;
  });
  whole.run();
  ASSERT_FALSE(saved.empty());
  Simulation other(ball(sets));
  other.load_state(saved);
  set_thread_count(2);
  other.run();
  set_thread_count(1);
  EXPECT_EQ(other.step_count(), whole.step_count());
  EXPECT_EQ(positions(other), positions(whole));
  EXPECT_EQ(now_of(other).redone_steps, now_of(whole).redone_steps);
}

TEST(Recovery, a_sudden_load_takes_as_many_halvings_as_it_needs) {
  // Gravity 1e6 times as strong for a millisecond: the stable step of the moment before knows nothing of it.
  Simulation sim(ball({"time.end=0.12", "gravity_times=[0, 0.1, 0.1001, 0.101, 0.1011]", "gravity_factors=[1, 1, 1e6, 1e6, 1]",
                       "body.ball.velocity.value=[0, 0]", "body.ball.region.center=[0.3, 0.155]", "solver.transfer=flip"}));
  EXPECT_EQ(sim.run(), RunEnd::finished);
  const Snapshot now = now_of(sim);
  EXPECT_GE(now.failed_steps, 4);
  EXPECT_LT(now.redone_steps, 500) << "the smallest steps begin shortly before the failure, not a hundred steps before it";
}

TEST(Recovery, a_fixed_step_that_fails_names_one_that_works_and_leaves_the_state_before_it) {
  for (const char* dt : {"0.004", "0.008", "0.02"}) {
    const TemporaryFolder folder;
    const auto problem = [&](const std::string& step) { return ball({"time.end=0.4", "time.dt=" + step, "solver.transfer=flip"}); };
    Simulation sim(problem(dt));
    ResultsFolder results(folder.path() / "results");
    results.begin(sim, 1);
    const std::string text = failure_of(sim, &results);
    std::smatch said;
    ASSERT_TRUE(
        std::regex_search(text, said,
                          std::regex(R"(^step (\d+), .* is not positive.*; in the step before it was at \([^)]*\) with J = )"
                                     R"([-+.e0-9]+, next to it were \d+ of "ball" \(J = .*; a fixed step of ([-.e0-9]+) s gets past)")))
        << text;
    Simulation smaller(problem(said[2]));
    EXPECT_EQ(smaller.run(), RunEnd::finished) << said[2];
    results.fail(sim, text);
    const FoundState last = find_state(folder.path() / "results");
    Simulation again(problem(dt));
    again.load_state(last.table);
    EXPECT_EQ(again.step_count(), std::stol(said[1]) - 1);
    EXPECT_THROW(again.step(), SolverError) << "the next step is the one that failed";
  }
}

TEST(Recovery, failures_that_smaller_steps_do_not_mend_end_the_run) {
  // The ball is thrown out of the open top.
  Input input = parse_toml(k_ball, "case.toml");
  input.find("boundary")->items().pop_back();
  apply_set(input, "time.end=2");
  apply_set(input, "body.ball.velocity.value=[0, 8]");
  Simulation sim(Case::from_input(input, "case"));
  const std::string text = failure_of(sim);
  EXPECT_NE(text.find("left the grid"), std::string::npos) << text;
  EXPECT_LT(now_of(sim).redone_steps, 5000);
  EXPECT_THROW(sim.step(), SolverError);
}

}  // namespace
}  // namespace matpoint::test
