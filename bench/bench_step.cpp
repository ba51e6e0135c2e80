// Particle-updates per CPU second and core of the explicit solver, beside a plain array-of-structs loop in the same run.
// Fails (exit code 1) when the two programs' energies differ: a fast answer to another question is worth nothing.
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <cstdio>
#include <fstream>
#include <map>

#include "core/version.hpp"
#include "measure.hpp"

namespace matpoint::bench {
namespace {

struct Options {
  std::vector<std::size_t> particles{1000, 10000, 100000, 1000000};
  std::vector<int> dims{2, 3};
  std::vector<Arrangement> layouts{Arrangement::lattice, Arrangement::jitter};
  std::vector<StressOrder> orders{StressOrder::usl};
  int repetitions = 5;
  std::string csv;
};

const std::map<std::string, StressOrder> k_orders{{"usl", StressOrder::usl}, {"usf", StressOrder::usf}, {"musl", StressOrder::musl}};
const std::map<std::string, Arrangement> k_layouts{{"lattice", Arrangement::lattice}, {"jitter", Arrangement::jitter}};

template <class T>
std::string name_of(const std::map<std::string, T>& names, T value) {
  for (const auto& [name, candidate] : names) {
    if (candidate == value) return name;
  }
  return "";
}

std::string processor() {
  std::ifstream file("/proc/cpuinfo");
  std::string line;
  while (std::getline(file, line)) {
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  }
  return "unknown processor";
}

std::string conditions() {
  return fmt::format("{}; {}, {}; plain loop {}; matpoint {} at {}; 1 thread, double", processor(), MATPOINT_COMPILER, MATPOINT_BUILD_TYPE,
                     MATPOINT_PLAIN_OPTIONS, version(), commit());
}

class Table {
 public:
  explicit Table(const std::string& csv) {
    fmt::print("{}\n", conditions());
    fmt::print("{:<20}{:>10}{:>12}{:>12}{:>8}{:>8}{:>14}  {}\n", "scenario", "particles", "plain M/s", "ours M/s", "ratio", "spread",
               "B/particle", "ours by stage, ns per particle");
    if (csv.empty()) return;
    file_.open(csv);
    if (!file_) throw std::runtime_error(fmt::format("cannot write {}", csv));
    file_ << "# " << conditions() << "\n"
          << "dim,layout,stress_order,particles,plain_updates_per_s,our_updates_per_s,ratio,our_spread,plain_bytes_per_particle,"
             "our_bytes_per_particle,kinetic_difference,strain_difference,our_stages_ns_per_particle\n";
  }

  void add(const Scenario& scenario, const Measurement& m) {
    std::string stages;
    for (const StageTime& stage : m.stages) {
      const std::string label = stage.label == "g2p, stress" ? "g2p+stress" : stage.label;
      stages += fmt::format("{}{} {:.1f}", stages.empty() ? "" : "; ", label, stage.nanoseconds);
    }
    const std::string layout = name_of(k_layouts, scenario.arrangement);
    const std::string order = name_of(k_orders, scenario.order);
    fmt::print("{:<20}{:>10}{:>12.2f}{:>12.2f}{:>8.2f}{:>7.0f}%{:>8.0f}/{:<5.0f}  {}\n",
               fmt::format("{}D {} {}", scenario.dim, layout, order), m.particles, 1e-6 * m.plain_rate, 1e-6 * m.our_rate,
               m.our_rate / m.plain_rate, 100 * m.our_spread, m.plain_bytes, m.our_bytes, stages);
    std::fflush(stdout);
    if (file_.is_open()) {
      file_ << fmt::format("{},{},{},{},{:.4g},{:.4g},{:.3f},{:.3f},{:.1f},{:.1f},{:.1e},{:.1e},{}\n", scenario.dim, layout, order,
                           m.particles, m.plain_rate, m.our_rate, m.our_rate / m.plain_rate, m.our_spread, m.plain_bytes, m.our_bytes,
                           m.kinetic_difference, m.strain_difference, stages);
    }
  }

 private:
  std::ofstream file_;
};

void run(const Options& options) {
  Table table(options.csv);
  for (const StressOrder order : options.orders) {
    for (const int dim : options.dims) {
      for (const Arrangement layout : options.layouts) {
        for (const std::size_t particles : options.particles) {
          const Scenario scenario{dim, layout, particles, order, options.repetitions};
          table.add(scenario, measure(scenario));
        }
      }
    }
  }
}

}  // namespace
}  // namespace matpoint::bench

int main(int argc, char** argv) {
  using namespace matpoint::bench;
  Options options;
  CLI::App app{"Times one step of the explicit solver beside a plain array-of-structs loop; both run the same two colliding bodies."};
  app.add_option("--particles", options.particles, "about so many particles [1]")->delimiter(',')->check(CLI::Range(500, 20000000));
  app.add_option("--dims", options.dims, "2, 3 or both")->delimiter(',')->check(CLI::Range(2, 3));
  app.add_option("--layouts", options.layouts, "lattice, jitter or both")->delimiter(',')->transform(CLI::CheckedTransformer(k_layouts));
  app.add_option("--orders", options.orders, "usl, usf, musl")->delimiter(',')->transform(CLI::CheckedTransformer(k_orders));
  app.add_option("--repetitions", options.repetitions, "of each scenario; the medians count")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--csv", options.csv, "also write the table to this file");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    run(options);
  } catch (const std::exception& error) {
    fmt::print(stderr, "bench_step: {}\n", error.what());
    return 1;
  }
  return 0;
}
