#include "measure.hpp"

#include <time.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>

#include "case/case_file.hpp"
#include "core/parallel.hpp"
#include "run/make_solver.hpp"
#include "run/simulation.hpp"

namespace matpoint::bench {
namespace {

// Work per repetition and program: long against the clock and short against the patience of a developer.
constexpr double k_updates = 1.5e6;
// A run is started afresh after so many steps, so that the bodies stay where they are and rounding does not grow.
constexpr int k_steps_max = 100;
constexpr int k_steps_min = 3;
// Before them: particles that change their cells spread over new memory in the first steps, and the system takes its time to hand that out.
constexpr int k_warm_up_steps = 10;
// The programs add in different orders: differences of about eps * sqrt(steps) * condition, observed below 1e-11 (1e-3 in single).
constexpr double k_energy_tolerance = 1e-8;
constexpr double k_energy_tolerance_single = 1e-2;

/// CPU time of this thread, or wall time.
double seconds(bool is_wall_time) {
  if (is_wall_time) return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : (values[middle - 1] + values[middle]) / 2;
}

/// What a repetition of one program comes to.
struct Outcome {
  double seconds = 0;
  double kinetic_energy = 0;
  double strain_energy = 0;
  double bytes = 0;
  Occupancy occupancy;
};

struct Plan {
  const Scenario& scenario;
  Scene scene;
  int steps = 0;  ///< Timed steps of a run, after those that warm it up.
  int runs = 0;   ///< Per repetition.
};

void set_length(Plan& plan, double particles) {
  plan.steps = std::clamp(static_cast<int>(k_updates / particles), k_steps_min, k_steps_max);
  plan.runs = std::max(1, static_cast<int>(std::lround(k_updates / (particles * plan.steps))));
}

PlainOrder plain_order(StressOrder order) {
  return order == StressOrder::usl ? PlainOrder::usl : order == StressOrder::usf ? PlainOrder::usf : PlainOrder::musl;
}

PlainShape plain_shape(const SolverSpec& solver) { return solver.shape == ShapeKind::linear ? PlainShape::linear : PlainShape::bspline2; }

Outcome repeat_plain(const Plan& plan, PlainStyle style) {
  Outcome outcome;
  for (int run = 0; run < plan.runs; ++run) {
    const std::unique_ptr<PlainLoop> loop =
        make_plain_loop(plan.scene, plain_order(plan.scenario.solver.stress_order), plain_shape(plan.scenario.solver), style);
    for (int step = 0; step < k_warm_up_steps; ++step) loop->step();
    const double start = seconds(false);
    for (int step = 0; step < plan.steps; ++step) loop->step();
    outcome.seconds += seconds(false) - start;
    outcome.kinetic_energy = loop->kinetic_energy();
    outcome.strain_energy = loop->strain_energy();
    outcome.bytes = static_cast<double>(loop->memory());
  }
  return outcome;
}

using StageSeconds = std::map<std::string, double>;

void add_stages(const Profile& profile, double sign, StageSeconds& stages) {
  for (const Profile::Entry& entry : profile.entries()) stages[entry.label] += sign * entry.seconds;
}

void take_state(const Solver& solver, Outcome& outcome) {
  outcome.kinetic_energy = outcome.strain_energy = 0;
  for (std::size_t body = 0; body < solver.body_count(); ++body) {
    const BodyTotals totals = solver.totals(body);
    outcome.kinetic_energy += totals.kinetic_energy;
    outcome.strain_energy += totals.strain_energy;
  }
  outcome.bytes = static_cast<double>(solver.memory());
  outcome.occupancy = solver.occupancy();
}

Outcome repeat_solver(const Plan& plan, const Case& problem, StageSeconds& stages) {
  Outcome outcome;
  const bool is_wall_time = plan.scenario.is_wall_time || plan.scenario.threads > 1;
  const double dt = plan.scene.dt;
  for (int run = 0; run < plan.runs; ++run) {
    const std::unique_ptr<Solver> solver = make_solver(problem);
    int step = 0;
    for (; step < k_warm_up_steps; ++step) solver->step(step * dt, dt);
    add_stages(solver->profile(), -1, stages);
    const double start = seconds(is_wall_time);
    for (; step < k_warm_up_steps + plan.steps; ++step) solver->step(step * dt, dt);
    outcome.seconds += seconds(is_wall_time) - start;
    add_stages(solver->profile(), 1, stages);
    if (!solver->escapes().empty()) throw std::runtime_error("the benchmark's scene is wrong: a particle left the grid");
    take_state(*solver, outcome);
  }
  return outcome;
}

/// The steps of a case that goes on from repetition to repetition.
Outcome repeat_case(const Plan& plan, Simulation& simulation, StageSeconds& stages) {
  Outcome outcome;
  const int steps = plan.steps * plan.runs;
  const bool is_wall_time = plan.scenario.is_wall_time || plan.scenario.threads > 1;
  add_stages(simulation.solver().profile(), -1, stages);
  const double start = seconds(is_wall_time);
  for (int step = 0; step < steps; ++step) simulation.step();
  outcome.seconds = seconds(is_wall_time) - start;
  add_stages(simulation.solver().profile(), 1, stages);
  take_state(simulation.solver(), outcome);
  return outcome;
}

double difference(const Outcome& ours, const Outcome& plain, const Scenario& scenario) {
  const double kinetic = std::abs(ours.kinetic_energy - plain.kinetic_energy) / plain.kinetic_energy;
  const double strain = std::abs(ours.strain_energy - plain.strain_energy) / plain.strain_energy;
  const double worst = scenario.scene.is_at_rest ? 0 : std::max(kinetic, strain);
  if (!(worst <= (scenario.solver.precision == "single" ? k_energy_tolerance_single : k_energy_tolerance))) {
    throw std::runtime_error(
        fmt::format("the physics differ: kinetic and strain energy {:.15g} J and {:.15g} J with the solver, {:.15g} J and "
                    "{:.15g} J with a plain loop",
                    ours.kinetic_energy, ours.strain_energy, plain.kinetic_energy, plain.strain_energy));
  }
  return worst;
}

/// What all repetitions of a scenario have in common.
struct Rates {
  std::vector<double> ours, textbook, tuned;
  StageSeconds stages;
  Outcome last;
};

Measurement summarize(const Plan& plan, double particles, const Rates& rates, const Machine& machine) {
  const double updates = particles * plan.steps * plan.runs;
  const auto rate = [&](const std::vector<double>& times) { return times.empty() ? 0 : updates / median(times); };
  Measurement result;
  result.particles = static_cast<std::size_t>(particles);
  result.rate = rate(rates.ours) / plan.scenario.threads;
  result.textbook_rate = rate(rates.textbook);
  result.tuned_rate = rate(rates.tuned);
  const auto [least, greatest] = std::minmax_element(rates.ours.begin(), rates.ours.end());
  result.spread = (*greatest - *least) / median(rates.ours);
  result.bytes = rates.last.bytes / particles;
  result.lane_fill = particles / static_cast<double>(rates.last.occupancy.lanes);
  result.moved = static_cast<double>(rates.last.occupancy.moved) / particles;
  const double state_bytes = static_cast<double>(rates.last.occupancy.state_bytes) / particles;
  result.roofline = result.rate * 2 * state_bytes / machine.update_bandwidth;
  for (const auto& [label, time] : rates.stages) {
    result.stages.push_back({label, 1e9 * time * plan.scenario.threads / (updates * static_cast<double>(rates.ours.size()))});
  }
  return result;
}

Measurement measure_case(const Scenario& scenario, const Machine& machine) {
  Simulation simulation(Case::from_input(parse_toml(scenario.case_text, scenario.name), scenario.name));
  double particles = 0;
  for (std::size_t b = 0; b < simulation.solver().body_count(); ++b)
    particles += static_cast<double>(simulation.solver().particle_count(b));
  while (simulation.time() < scenario.warm_up) simulation.step();
  for (int step = 0; step < k_warm_up_steps; ++step) simulation.step();
  Plan plan{scenario, {}, 0, 0};
  set_length(plan, particles);
  Rates rates;
  for (int repetition = 0; repetition < scenario.repetitions; ++repetition) {
    rates.last = repeat_case(plan, simulation, rates.stages);
    rates.ours.push_back(rates.last.seconds);
  }
  return summarize(plan, particles, rates, machine);
}

}  // namespace

Measurement measure(const Scenario& scenario, const Machine& machine) {
  set_thread_count(scenario.threads);
  if (!scenario.case_text.empty()) return measure_case(scenario, machine);
  Plan plan{scenario, make_scene(scenario.scene), 0, 0};
  const auto particles = static_cast<double>(plan.scene.particle_count());
  set_length(plan, particles);
  std::optional<Input> law;
  if (!scenario.law.empty()) law = *parse_toml("law = " + scenario.law, scenario.name).find("law");
  const Case problem = make_case(plan.scene, scenario.solver, law);

  Rates rates;
  Outcome textbook, tuned;
  for (int repetition = 0; repetition < scenario.repetitions; ++repetition) {
    // In turn, each first every third time: what disturbs the machine meets all.
    for (int turn = 0; turn < 3; ++turn) {
      const int program = (repetition + turn) % 3;
      if (program > 0 && !scenario.has_plain) continue;
      if (program == 0) {
        rates.last = repeat_solver(plan, problem, rates.stages);
        rates.ours.push_back(rates.last.seconds);
      } else if (program == 1) {
        textbook = repeat_plain(plan, PlainStyle::textbook);
        rates.textbook.push_back(textbook.seconds);
      } else {
        tuned = repeat_plain(plan, PlainStyle::tuned);
        rates.tuned.push_back(tuned.seconds);
      }
    }
  }
  Measurement result = summarize(plan, particles, rates, machine);
  if (scenario.has_plain) {
    result.plain_bytes = textbook.bytes / particles;
    result.energy_difference = std::max(difference(rates.last, textbook, scenario), difference(rates.last, tuned, scenario));
  }
  return result;
}

}  // namespace matpoint::bench
