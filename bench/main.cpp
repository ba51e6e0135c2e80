// Particle-updates per second and core of the explicit solver, beside two plain array-of-structs loops in the same run.
// Fails (exit code 1) when the programs' energies differ: a fast answer to another question is worth nothing.
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <cstdio>
#include <fstream>

#include "core/version.hpp"
#include "implicit.hpp"
#include "kernel/kernel.hpp"
#include "scenarios.hpp"

namespace matpoint::bench {
namespace {

struct Options {
  std::vector<std::string> sets{"schemes"};
  std::size_t particles = 1000000;
  int threads = 0;
  int repetitions = 5;
  std::string csv;
};

std::string processor() {
  std::ifstream file("/proc/cpuinfo");
  std::string line;
  while (std::getline(file, line)) {
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  }
  return "unknown processor";
}

std::string conditions(const Machine& machine) {
  return fmt::format(
      "{}, kernels {}; {}, {}; plain loops {}; matpoint {} at {}\nroofline of one core: {:.1f} GB/s read and written in place, {:.0f} "
      "(double) and "
      "{:.0f} (single) GFLOP/s",
      processor(), instruction_set(), MATPOINT_COMPILER, MATPOINT_BUILD_TYPE, MATPOINT_PLAIN_OPTIONS, version(), commit(),
      1e-9 * machine.update_bandwidth, 1e-9 * machine.double_flops, 1e-9 * machine.single_flops);
}

std::string or_dash(const std::string& text, bool has_value) { return has_value ? text : "-"; }

class Table {
 public:
  Table(const std::string& csv, const Machine& machine) {
    std::string heading = conditions(machine);
    fmt::print("{}\n{:<24}{:>10}{:>9}{:>8}{:>10}{:>7}{:>8}{:>7}{:>9}{:>6}{:>8}{:>10}  {}\n", heading, "rates in M/s and core", "particles",
               "ours", "spread", "textbook", "ratio", "tuned", "ratio", "B/part.", "fill", "moved", "roofline",
               "ns per particle, by stage");
    if (csv.empty()) return;
    file_.open(csv);
    if (!file_) throw std::runtime_error(fmt::format("cannot write {}", csv));
    for (std::size_t at = 0; (at = heading.find('\n', at)) != std::string::npos; at += 3) heading.insert(at + 1, "# ");
    file_ << "# " << heading << "\n"
          << "scenario,threads,precision,particles,updates_per_s_and_core,spread,textbook_updates_per_s,ratio_to_textbook,tuned_updates_"
             "per_s,"
             "ratio_to_tuned,bytes_per_particle,plain_bytes_per_particle,lane_fill,moved_share,roofline_share,energy_difference,"
             "ns_per_particle_by_stage\n";
  }

  void add(const Scenario& scenario, const Measurement& m) {
    std::string stages;
    for (const StageTime& stage : m.stages) {
      if (stage.nanoseconds < 0.05) continue;
      std::string label = stage.label;
      std::replace(label.begin(), label.end(), ',', '+');
      label.erase(std::remove(label.begin(), label.end(), ' '), label.end());
      stages += fmt::format("{}{} {:.1f}", stages.empty() ? "" : "; ", label, stage.nanoseconds);
    }
    const bool has_plain = m.tuned_rate > 0;
    const double to_textbook = has_plain ? m.rate / m.textbook_rate : 0;
    const double to_tuned = has_plain ? m.rate / m.tuned_rate : 0;
    const auto number = [&](double value) { return or_dash(fmt::format("{:.2f}", value), has_plain); };
    fmt::print("{:<24}{:>10}{:>9.2f}{:>7.0f}%{:>10}{:>7}{:>8}{:>7}{:>9.0f}{:>6.2f}{:>7.2f}%{:>9.0f}%  {}\n", scenario.name, m.particles,
               1e-6 * m.rate, 100 * m.spread, number(1e-6 * m.textbook_rate), number(to_textbook), number(1e-6 * m.tuned_rate),
               number(to_tuned), m.bytes, m.lane_fill, 100 * m.moved, 100 * m.roofline, stages);
    std::fflush(stdout);
    if (!file_.is_open()) return;
    file_ << fmt::format("{},{},{},{},{:.4g},{:.3f},{:.4g},{:.3f},{:.4g},{:.3f},{:.1f},{:.1f},{:.3f},{:.5f},{:.3f},{:.1e},{}\n",
                         scenario.name, scenario.threads, scenario.solver.precision, m.particles, m.rate, m.spread, m.textbook_rate,
                         to_textbook, m.tuned_rate, to_tuned, m.bytes, m.plain_bytes, m.lane_fill, m.moved, m.roofline, m.energy_difference,
                         stages)
          << std::flush;
  }

 private:
  std::ofstream file_;
};

void run(const Options& options) {
  if (options.sets == std::vector<std::string>{"implicit"}) {
    run_implicit(options.csv, options.threads);
    return;
  }
  if (options.sets == std::vector<std::string>{"coupled"}) {
    run_coupled(options.csv, options.threads);
    return;
  }
  const std::vector<ScenarioSet> sets = scenario_sets(options.particles);
  const bool is_all = options.sets == std::vector<std::string>{"all"};
  Table table(options.csv, measure_machine());
  const Machine machine = measure_machine();
  for (const ScenarioSet& set : sets) {
    if (!is_all && std::find(options.sets.begin(), options.sets.end(), set.name) == options.sets.end()) continue;
    for (Scenario scenario : set.scenarios) {
      scenario.repetitions = options.repetitions;
      if (options.threads > 0) scenario.threads = options.threads;
      table.add(scenario, measure(scenario, machine));
    }
  }
}

void list() {
  for (const ScenarioSet& set : scenario_sets(1000000)) fmt::print("{:<12}{}\n", set.name, set.about);
  fmt::print("{:<12}{}\n", "all", "all of these");
  fmt::print("{:<12}{}\n", "implicit", "alone: the implicit solver's time by stage and linear solver (15 minutes)");
  fmt::print("{:<12}{}\n", "coupled", "alone: particles and finite elements, time by stage (6 minutes)");
}

std::vector<std::string> set_names() {
  std::vector<std::string> names{"all", "implicit", "coupled"};
  for (const ScenarioSet& set : scenario_sets(1000000)) names.push_back(set.name);
  return names;
}

}  // namespace
}  // namespace matpoint::bench

int main(int argc, char** argv) {
  using namespace matpoint::bench;
  Options options;
  bool is_list = false;
  CLI::App app{"Times the explicit solver beside two plain array-of-structs loops on the same problems.", "matpoint bench"};
  app.add_option("SCENARIO", options.sets, "Sets of scenarios (--list); default: schemes")->check(CLI::IsMember(set_names()));
  app.add_flag("--list", is_list, "List the sets");
  app.add_option("--particles", options.particles, "Size of the scenarios that do not name their own")
      ->check(CLI::Range(500, 20000000))
      ->capture_default_str();
  app.add_option("--threads", options.threads, "Threads; default: one, unless the scenario says otherwise")->check(CLI::Range(1, 1024));
  app.add_option("--repetitions", options.repetitions, "Of each scenario; the medians count")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--csv", options.csv, "Also write the table to this file");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    if (is_list)
      list();
    else
      run(options);
  } catch (const std::exception& error) {
    fmt::print(stderr, "matpoint bench: {}\n", error.what());
    return 1;
  }
  return 0;
}
