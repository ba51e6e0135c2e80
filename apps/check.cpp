// `matpoint check`. The whole output is a case file again: the resolved values, with everything else in comments.
#include <chrono>
#include <cstdio>

#include "case/case_file.hpp"
#include "case/simulation.hpp"
#include "commands.hpp"
#include "core/parallel.hpp"

namespace matpoint {
namespace {

struct Calibration {
  double seconds_per_step = 0;
  std::string failure;  ///< Why a step failed, or empty.
};

/// Times a few steps. The outputs are not part of it.
Calibration calibrate(Simulation& simulation) {
  using Clock = std::chrono::steady_clock;
  constexpr int k_steps_max = 200;
  constexpr double k_seconds_max = 0.5;
  Calibration calibration;
  try {
    simulation.step();  // the first one pays for fresh memory
    int steps = 0;
    double seconds = 0;
    const Clock::time_point start = Clock::now();
    while (steps < k_steps_max && seconds < k_seconds_max) {
      simulation.step();
      ++steps;
      seconds = std::chrono::duration<double>(Clock::now() - start).count();
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
  fmt::print("# memory            {}\n", memory_text(solver.memory()));
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
  fmt::print("# stable time step  {:.6g} s (CFL number 1, at the start)\n", stable);
  fmt::print("# time step         {:.6g} s ({}, {:.3g} of the stable one)\n", dt, is_fixed ? "fixed" : "automatic, at the start",
             dt / stable);
  fmt::print("# steps             {}{:.0f} to t = {:.6g} s\n", is_fixed ? "" : "about ", steps, problem.time.end);
  std::fflush(stdout);
  const Calibration calibration = calibrate(simulation);
  if (calibration.failure.empty()) {
    fmt::print("# estimated time    {} on {} thread{}, without output\n", duration_text(steps * calibration.seconds_per_step),
               thread_count(), thread_count() == 1 ? "" : "s");
  } else {
    fmt::print("# estimated time    unknown: the run fails soon after the start\n");
    print_warning(calibration.failure);
  }
  return k_exit_done;
}

}  // namespace matpoint
