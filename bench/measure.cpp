#include "measure.hpp"

#include <time.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/parallel.hpp"
#include "solver/solver.hpp"

namespace matpoint::bench {
namespace {

// Work per repetition and program: long against the clock and short against the patience of a developer.
constexpr double k_updates = 1.5e6;
// A run is started afresh after so many steps, so that the bodies stay where they are and rounding does not grow.
constexpr int k_steps_max = 100;
constexpr int k_steps_min = 3;
// The programs add in different orders: differences of about eps * sqrt(steps) * condition, observed below 1e-11.
constexpr double k_energy_tolerance = 1e-8;

double cpu_seconds() {
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
};

struct Plan {
  Scene scene;
  StressOrder order;
  int steps = 0;  ///< Timed steps of a run; one more before them brings memory and caches into their lasting state.
  int runs = 0;   ///< Per repetition.

  double updates() const { return static_cast<double>(scene.particle_count()) * steps * runs; }
};

PlainOrder plain_order(StressOrder order) {
  return order == StressOrder::usl ? PlainOrder::usl : order == StressOrder::usf ? PlainOrder::usf : PlainOrder::musl;
}

Outcome repeat_plain(const Plan& plan) {
  Outcome outcome;
  for (int run = 0; run < plan.runs; ++run) {
    const std::unique_ptr<PlainLoop> loop = make_plain_loop(plan.scene, plain_order(plan.order));
    loop->step();
    const double start = cpu_seconds();
    for (int step = 0; step < plan.steps; ++step) loop->step();
    outcome.seconds += cpu_seconds() - start;
    outcome.kinetic_energy = loop->kinetic_energy();
    outcome.strain_energy = loop->strain_energy();
    outcome.bytes = static_cast<double>(loop->memory());
  }
  return outcome;
}

Outcome repeat_ours(const Plan& plan, const Case& problem, std::map<std::string, double>& stage_seconds) {
  Outcome outcome;
  const double dt = plan.scene.dt;
  for (int run = 0; run < plan.runs; ++run) {
    const std::unique_ptr<Solver> solver = make_solver(problem);
    solver->step(0, dt);
    for (const Profile::Entry& entry : solver->profile().entries()) stage_seconds[entry.label] -= entry.seconds;
    const double start = cpu_seconds();
    for (int step = 0; step < plan.steps; ++step) solver->step((step + 1) * dt, dt);
    outcome.seconds += cpu_seconds() - start;
    for (const Profile::Entry& entry : solver->profile().entries()) stage_seconds[entry.label] += entry.seconds;
    if (!solver->escapes().empty()) throw std::runtime_error("the benchmark's scene is wrong: a particle left the grid");
    outcome.kinetic_energy = outcome.strain_energy = 0;
    for (std::size_t body = 0; body < solver->body_count(); ++body) {
      const BodyTotals totals = solver->totals(body);
      outcome.kinetic_energy += totals.kinetic_energy;
      outcome.strain_energy += totals.strain_energy;
    }
    outcome.bytes = static_cast<double>(solver->memory());
  }
  return outcome;
}

double relative_difference(double ours, double plain, const char* what) {
  const double difference = std::abs(ours - plain) / plain;
  if (!(difference <= k_energy_tolerance)) {
    throw std::runtime_error(
        fmt::format("the physics differ: {} energy {:.15g} J with the solver, {:.15g} J with the plain loop", what, ours, plain));
  }
  return difference;
}

}  // namespace

Measurement measure(const Scenario& scenario) {
  set_thread_count(1);
  Plan plan{make_scene(scenario.dim, scenario.arrangement, scenario.particles), scenario.order, 0, 0};
  const auto particles = static_cast<double>(plan.scene.particle_count());
  plan.steps = std::clamp(static_cast<int>(k_updates / particles), k_steps_min, k_steps_max);
  plan.runs = std::max(1, static_cast<int>(std::lround(k_updates / (particles * plan.steps))));
  const Case problem = make_case(plan.scene, scenario.order);

  std::vector<double> plain_rates;
  std::vector<double> our_rates;
  std::map<std::string, double> stage_seconds;
  Outcome plain;
  Outcome ours;
  for (int repetition = 0; repetition < scenario.repetitions; ++repetition) {
    // In turn, and each first every other time: what disturbs the machine meets both.
    for (const bool is_plain : {repetition % 2 == 0, repetition % 2 != 0}) {
      if (is_plain) {
        plain = repeat_plain(plan);
        plain_rates.push_back(plan.updates() / plain.seconds);
      } else {
        ours = repeat_ours(plan, problem, stage_seconds);
        our_rates.push_back(plan.updates() / ours.seconds);
      }
    }
  }

  Measurement result;
  result.particles = plan.scene.particle_count();
  result.plain_rate = median(plain_rates);
  result.our_rate = median(our_rates);
  const auto [least, greatest] = std::minmax_element(our_rates.begin(), our_rates.end());
  result.our_spread = (*greatest - *least) / result.our_rate;
  result.plain_bytes = plain.bytes / particles;
  result.our_bytes = ours.bytes / particles;
  for (const auto& [label, seconds] : stage_seconds) {
    result.stages.push_back({label, 1e9 * seconds / (plan.updates() * scenario.repetitions)});
  }
  result.kinetic_difference = relative_difference(ours.kinetic_energy, plain.kinetic_energy, "kinetic");
  result.strain_difference = relative_difference(ours.strain_energy, plain.strain_energy, "strain");
  return result;
}

}  // namespace matpoint::bench
