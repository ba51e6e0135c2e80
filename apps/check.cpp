// `matpoint check`. The whole output is a case file again: the resolved values, with everything else in comments.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "case/case_file.hpp"
#include "commands.hpp"
#include "core/parallel.hpp"
#include "run/simulation.hpp"

namespace matpoint {
namespace {

// As measured: the program itself with its libraries, and what making a body's particles needs for each of them for a moment.
constexpr Index k_program_bytes = 20'000'000;
constexpr Index k_seeding_bytes = 130;
// As measured: one append to a field file, however small.
constexpr double k_seconds_per_append = 0.004;

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// What was measured on this machine, for the whole case.
struct Calibration {
  double seconds_per_step = 0;
  double seconds_per_history = 0;  ///< One row.
  double seconds_per_fields = 0;   ///< Taking the fields of one time; they are written beside the run.
  Index field_bytes = 0;           ///< Memory of the fields of one time.
  std::string failure;             ///< Why a step failed, or empty.
};

/// Whether the outputs of a case have this field.
bool is_written(const OutputSpec& output, const std::string& name) {
  return output.fields.empty() || std::find(output.fields.begin(), output.fields.end(), name) != output.fields.end();
}

void calibrate_outputs(const Simulation& simulation, Calibration& calibration) {
  const Solver& solver = simulation.solver();
  Clock::time_point start = Clock::now();
  for (std::size_t b = 0; b < solver.body_count(); ++b) solver.totals(b);
  calibration.seconds_per_history = seconds_since(start);
  if (simulation.problem().output.formats.empty()) return;
  const bool has_grid = simulation.problem().output.grid;
  std::vector<std::vector<Field>> fields(solver.body_count());
  const auto take_all = [&] {
    for (std::size_t b = 0; b < solver.body_count(); ++b) {
      std::vector<std::string> names = {"position"};
      for (const std::string& name : solver.field_names(b)) {
        if (name != "position" && is_written(simulation.problem().output, name)) names.push_back(name);
      }
      solver.take_fields(b, names, 3, fields[b]);
    }
    return has_grid ? solver.grid_fields() : std::vector<Field>{};
  };
  // Fresh memory is paid for once.
  for (const Field& field : take_all()) calibration.field_bytes += 2 * static_cast<Index>(field.values.size() * sizeof(Real));
  start = Clock::now();
  take_all();
  calibration.seconds_per_fields = seconds_since(start);
  for (std::size_t b = 0; b < solver.body_count(); ++b) {
    // Three index lists of the file.
    calibration.field_bytes += solver.particle_count(b) * 3 * static_cast<Index>(sizeof(Index));
    for (const Field& field : fields[b]) calibration.field_bytes += static_cast<Index>(field.values.size() * sizeof(Real));
  }
}

/// Times some steps, and the outputs.
Calibration calibrate(Simulation& simulation) {
  constexpr double k_seconds_max = 1;
  Calibration calibration;
  const Real end = simulation.problem().time.end;
  const Real almost_end = end * (1 - 1e-9);
  try {
    calibrate_outputs(simulation, calibration);
    // The first step pays for fresh memory, so it counts only when there is no other.
    Clock::time_point start = Clock::now();
    simulation.step(end);
    double seconds = seconds_since(start);
    int steps = 1;
    if (simulation.time() < almost_end) {
      steps = 0;
      start = Clock::now();
    }
    while (simulation.time() < almost_end && (steps == 0 || seconds < k_seconds_max)) {
      simulation.step(end);
      ++steps;
      seconds = seconds_since(start);
    }
    calibration.seconds_per_step = seconds / steps;
  } catch (const SolverError& error) {
    calibration.failure = error.what();
  }
  return calibration;
}

std::string memory_text(Index bytes) {
  const auto size = static_cast<double>(bytes);
  if (size < 1e6) return fmt::format("{:.0f} kB", size / 1e3);
  return size < 1e9 ? fmt::format("{:.1f} MB", size / 1e6) : fmt::format("{:.2f} GB", size / 1e9);
}

void print_sizes(const Simulation& simulation) {
  const Solver& solver = simulation.solver();
  Index particles = 0;
  std::string bodies;
  for (std::size_t b = 0; b < solver.body_count(); ++b) {
    particles += solver.particle_count(b);
    bodies += fmt::format("{}{} {}", b == 0 ? "" : ", ", solver.body_name(b), solver.particle_count(b));
  }
  const GridGeometry& grid = solver.grid();
  const int dim = solver.dim();
  fmt::print("# particles         {} ({})\n", particles, bodies);
  fmt::print("# nodes             {} ({}), cell size {:.6g} m\n", solver.node_count(),
             fmt::join(grid.nodes.begin(), grid.nodes.begin() + dim, " x "),
             fmt::join(grid.cell_size.begin(), grid.cell_size.begin() + dim, " x "));
}

}  // namespace

int check_command(const std::string& case_name, const std::vector<std::string>& sets) {
  Simulation simulation(load_case(case_name, sets));
  const Case& problem = simulation.problem();
  for (const std::string& warning : simulation.warnings()) print_warning(warning);

  fmt::print("# {}, resolved: what a run takes, with all defaults\n{}\n", problem.name, write_toml(problem.to_input()));
  print_sizes(simulation);
  const Real stable = simulation.solver().stable_dt();
  const Real dt = simulation.next_dt();
  const bool is_fixed = problem.time.dt.has_value();
  const double steps = std::ceil(problem.time.end / dt * (1 - 1e-12));
  const std::string kind = is_fixed ? "fixed" : problem.time.rule ? "by the rule, at the start" : "automatic, at the start";
  if (problem.is_implicit()) {
    fmt::print("# time step         {:.6g} s ({}; implicit steps are stable, accuracy limits them)\n", dt, kind);
  } else {
    fmt::print("# stable time step  {:.6g} s (CFL number 1, at the start)\n", stable);
    fmt::print("# time step         {:.6g} s ({}, {:.3g} of the stable one)\n", dt, kind, dt / stable);
  }
  fmt::print("# steps             {}{:.0f} to t = {:.6g} s\n", is_fixed ? "" : "about ", steps, problem.time.end);
  std::fflush(stdout);
  const Solver& solver = simulation.solver();
  const Index memory = solver.memory();
  Index largest_body = 0;
  for (std::size_t b = 0; b < solver.body_count(); ++b) largest_body = std::max(largest_body, solver.particle_count(b));
  const Calibration calibration = calibrate(simulation);
  const Index kept = problem.time.step_cuts_max > 0 ? solver.occupancy().state_bytes : 0;  // to go back to
  const Index passing = kept + std::max(calibration.field_bytes, k_seeding_bytes * largest_body);
  fmt::print("# memory            {} for particles and grid, {} at the most (start, output)\n", memory_text(memory),
             memory_text(memory + passing + k_program_bytes));
  if (calibration.failure.empty()) {
    const OutputSpec& output = problem.output;
    const double end = problem.time.end;
    const double rows = output.history_every ? end / *output.history_every : 200;
    const double times = static_cast<double>(output.fields_at.size()) + (output.fields_every        ? end / *output.fields_every
                                                                         : output.fields_at.empty() ? 50
                                                                                                    : 0);
    // No more outputs than steps, and one at the start and at the end.
    const double output_seconds =
        (std::min(rows, steps) + 1) * calibration.seconds_per_history + (std::min(times, steps) + 2) * calibration.seconds_per_fields;
    // Files are written beside the run, which waits for them when they are slower.
    const auto files = static_cast<double>(output.formats.size() * (simulation.solver().body_count() + (output.grid ? 1 : 0)));
    const double writing_seconds = (std::min(times, steps) + 2) * files * k_seconds_per_append;
    fmt::print("# estimated time    {} on {} thread{}, of which {} for output\n",
               duration_text(std::max(steps * calibration.seconds_per_step + output_seconds, writing_seconds)), thread_count(),
               thread_count() == 1 ? "" : "s", duration_text(output_seconds));
  } else {
    fmt::print("# estimated time    unknown: the run fails soon after the start\n");
    print_warning(calibration.failure);
  }
  return k_exit_done;
}

}  // namespace matpoint
