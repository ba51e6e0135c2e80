// The clock: fixed steps are never cut and never summed, automatic steps end on events and keep below the limit.
#include "support/solver_case.hpp"

namespace matpoint::test {
namespace {

Case vibrating_block() {
  Case problem = make_case(2, {0, 0, 0}, {1, 1, 0}, {8, 8});
  problem.bodies.push_back(
      make_body("block", lattice(2, {0.25, 0.25, 0}, {0.75, 0.75, 0}, {8, 8, 1}), neo_hookean(1e4, 0.3, 1000), [](const Vec3& x) {
        return Vec3{0.5 * (x[0] - 0.5), 0, 0};
      }));
  problem.time.end = 0.1;
  return problem;
}

TEST(Clock, fixed_time_is_step_times_dt) {
  Case problem = vibrating_block();
  problem.time.dt = 1e-4;  // 0.1 / 1e-4 = 1000; adding 1e-4 1000 times ends beside 0.1
  Simulation sim(problem);
  bool is_product = true;
  sim.add_callback([&](const Simulation& s) {
    is_product = is_product && s.time() == static_cast<Real>(s.step_count()) * 1e-4;
    return true;
  });
  EXPECT_EQ(sim.run(), RunEnd::finished);
  EXPECT_TRUE(is_product);
  EXPECT_EQ(sim.step_count(), 1000);
  EXPECT_EQ(sim.time(), 1000 * 1e-4);
}

TEST(Clock, fixed_step_is_never_cut_to_an_event) {
  Case problem = vibrating_block();
  problem.time.dt = 3e-3;               // 0.1 / 3e-3 = 33.3: ends after 33 whole steps
  problem.output.history_every = 7e-3;  // no multiple of the step
  problem.output.fields_at = {0.05};
  Simulation sim(problem);
  std::vector<Real> dts;
  sim.add_callback([&](const Simulation& s) {
    if (s.step_count() > 0) dts.push_back(s.last_dt());
    return true;
  });
  sim.run();
  EXPECT_EQ(dts, std::vector<Real>(33, 3e-3));
  EXPECT_EQ(sim.time(), 33 * 3e-3);
}

TEST(Clock, automatic_step_keeps_below_the_limit_and_is_cut_at_the_end_only) {
  Case problem = vibrating_block();
  problem.time.cfl = 0.3;
  problem.output.history_every = 0.017;
  problem.output.fields_at = {0.0123, 0.05};
  Simulation sim(problem);
  std::vector<Real> times;
  Real limit = std::numeric_limits<Real>::infinity();
  sim.add_callback([&](const Simulation& s) {
    if (s.step_count() > 0) {
      EXPECT_LE(s.last_dt(), limit * (1 + 1e-12));
      EXPECT_GT(s.last_dt(), 0);
    }
    limit = 0.3 * s.solver().stable_dt();
    times.push_back(s.time());
    return true;
  });
  sim.run();
  EXPECT_EQ(sim.time(), 0.1);
  // At rest the limit is 0.3 h / c with c = sqrt((lambda + 2 mu) / rho); the run needs that many steps.
  const Real wave_speed = std::sqrt(1e4 * 0.7 / (1.3 * 0.4) / 1000);
  const Real steps = 0.1 / (0.3 * 0.125 / wave_speed);
  EXPECT_GE(sim.step_count(), static_cast<Index>(steps));
  EXPECT_LE(sim.step_count(), static_cast<Index>(1.2 * steps) + 1);
}

TEST(Clock, how_often_a_run_is_looked_at_does_not_change_it) {
  const auto run = [](std::optional<Real> history_every, std::optional<Real> fields_every, std::vector<Real> fields_at) {
    Case problem = vibrating_block();
    problem.output.history_every = history_every;
    problem.output.fields_every = fields_every;
    problem.output.fields_at = std::move(fields_at);
    Simulation sim(problem);
    Real shortest = 1, longest = 0;
    sim.add_callback([&](const Simulation& s) {
      if (s.step_count() > 0 && s.time() < 0.1) {
        shortest = std::min(shortest, s.last_dt());
        longest = std::max(longest, s.last_dt());
      }
      return true;
    });
    sim.run();
    EXPECT_GT(shortest, 0.5 * longest);
    return std::pair(sim.step_count(), sim.solver().field(0, "position").values);
  };
  const auto rarely = run(0.1, 0.1, {});
  EXPECT_EQ(run(0.001, 0.0007, {}), rarely);
  // Multiples of .01 and .05 that differ in the last digit.
  EXPECT_EQ(run(0.01, 0.05, {0.03, 0.030000000000000002, 0.09}), rarely);
}

TEST(Clock, rows_of_the_history_are_at_their_times_and_between_those_of_the_steps_around) {
  Case problem = vibrating_block();
  problem.output.history_every = 0.0031;
  Simulation sim(problem);
  std::vector<std::vector<Real>> rows;
  std::vector<std::vector<Real>> steps = {history_row(sim)};
  sim.add_history_callback([&](const std::vector<Real>& row) { rows.push_back(row); });
  sim.add_callback([&](const Simulation& s) {
    if (s.step_count() > 0) steps.push_back(history_row(s));
    return true;
  });
  sim.run();
  ASSERT_EQ(rows.size(), 34u);  // the start, 32 multiples, the end
  const std::vector<HistoryColumn> columns = history_columns(sim.solver());
  const auto column = [&](const std::string& name) {
    return static_cast<std::size_t>(
        std::find_if(columns.begin(), columns.end(), [&](const HistoryColumn& one) { return one.name == name; }) - columns.begin());
  };
  for (std::size_t k = 0; k < rows.size(); ++k) {
    EXPECT_EQ(rows[k][0], k == 33 ? 0.1 : static_cast<Real>(k) * 0.0031);
    std::size_t after = 0;
    while (steps[after][0] < rows[k][0]) ++after;
    const std::size_t before = steps[after][0] == rows[k][0] ? after : after - 1;
    const Real share = before == after ? 0 : (rows[k][0] - steps[before][0]) / (steps[after][0] - steps[before][0]);
    for (const char* name : {"kinetic_energy", "strain_energy", "center_of_mass_x", "block.momentum_x", "transfer_loss"}) {
      const std::size_t c = column(name);
      EXPECT_NEAR(rows[k][c], (1 - share) * steps[before][c] + share * steps[after][c], 1e-12 * (1 + std::abs(steps[after][c]))) << name;
    }
    EXPECT_EQ(rows[k][1], steps[after][1]) << "counts are not interpolated";
    EXPECT_EQ(rows[k][column("particle_count")], steps[after][column("particle_count")]);
  }
}

TEST(Clock, dt_max_holds_and_dt_min_stops_the_run) {
  Case problem = vibrating_block();
  problem.time.dt_max = 1e-3;
  Simulation sim(problem);
  EXPECT_EQ(sim.next_dt(), 1e-3);
  problem.time.dt_max.reset();
  problem.time.dt_min = 1;
  Simulation blocked(problem);
  try {
    blocked.run();
    FAIL() << "should have thrown";
  } catch (const SolverError& error) {
    EXPECT_NE(std::string(error.what()).find("is below dt_min = 1 s"), std::string::npos) << error.what();
  }
}

TEST(Clock, stable_limit_is_cell_size_over_wave_and_particle_speed) {
  Case problem = make_case(2, {0, 0, 0}, {2, 1, 0}, {20, 5});  // cells of 0.1 x 0.2
  problem.bodies.push_back(
      make_body("block", lattice(2, {0.2, 0.2, 0}, {0.8, 0.8, 0}, {6, 6, 1}), neo_hookean(1e4, 0.3, 1000), [](const Vec3&) {
        return Vec3{-1.5, 4, 0};
      }));
  const Real wave_speed = std::sqrt(1e4 * 0.7 / (1.3 * 0.4) / 1000);
  const Real expected = std::min(0.1 / (wave_speed + 1.5), 0.2 / (wave_speed + 4));
  EXPECT_NEAR(Simulation(problem).solver().stable_dt(), expected, 1e-12 * expected);
  // A fluid: c0 = sqrt(gamma kappa / rho), and diffusion when it is viscous enough.
  problem.bodies[0] = make_body("water", lattice(2, {0.2, 0.2, 0}, {0.8, 0.8, 0}, {6, 6, 1}), newtonian_fluid(2e6, 0, 1000));
  EXPECT_NEAR(Simulation(problem).solver().stable_dt(), 0.1 / std::sqrt(7 * 2e6 / 1000), 1e-12);
  problem.bodies[0] = make_body("honey", lattice(2, {0.2, 0.2, 0}, {0.8, 0.8, 0}, {6, 6, 1}), newtonian_fluid(2, 1e5, 1000));
  EXPECT_NEAR(Simulation(problem).solver().stable_dt(), 0.1 * 0.1 / (2 * 2 * 1e5 / 1000), 1e-12);
}

TEST(Clock, callback_ends_a_run_normally_and_the_run_goes_on_later) {
  Case problem = vibrating_block();
  problem.time.dt = 1e-3;
  Simulation sim(problem);
  sim.add_callback([](const Simulation& s) { return s.step_count() != 10; });
  EXPECT_EQ(sim.run(), RunEnd::stopped_by_callback);
  EXPECT_EQ(sim.step_count(), 10);
  EXPECT_EQ(sim.run(), RunEnd::finished);
  EXPECT_EQ(sim.step_count(), 100);
}

}  // namespace
}  // namespace matpoint::test
