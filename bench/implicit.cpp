#include "implicit.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <fstream>
#include <stdexcept>

#include "case/case_file.hpp"
#include "case/simulation.hpp"
#include "core/parallel.hpp"
#include "solver/linear_solver_names.hpp"

namespace matpoint::bench {
namespace {

struct Run {
  std::string row;  ///< Of Table 1 of the paper: E1 (symmetric) or E2 (with receding particles).
  int J;
  std::string linear_solver;
  int threads;
  int steps;
};

struct Seconds {
  double all = 0;
  double assembly = 0;
  double linear = 0;
};

std::vector<std::string> sets_of(const Run& run) {
  const double gap = (run.row == "E1" ? 0.2 : 0.3) / (1 << (run.J - 1));
  std::vector<std::string> sets = {fmt::format("grid.refinements={}", run.J), fmt::format("body.disk.region.center=[0,{}]", gap),
                                   "solver.linear_solver=" + run.linear_solver};
  if (run.row == "E1") {
    sets.insert(sets.end(),
                {"body.disk.material.youngs_modulus=4.2e6", "solver.soft_stiffness=[1e-3,1e-7]", "boundary.1.receding_correction=0"});
  }
  return sets;
}

class Table {
 public:
  explicit Table(const std::string& csv) {
    fmt::print("{:<18}{:>3}{:>12}{:>9}{:>7}{:>10}{:>12}{:>11}{:>11}{:>11}\n", "rolling disk, row", "J", "solver", "threads", "steps",
               "unknowns", "iterations", "seconds", "assembly", "linear");
    if (csv.empty()) return;
    file_.open(csv);
    if (!file_) throw std::runtime_error(fmt::format("cannot write {}", csv));
    file_ << "row,J,linear_solver,threads,steps,unknowns,newton_iterations,seconds,assembly_seconds,linear_seconds\n";
  }
  void run(const Run& one) {
    set_thread_count(one.threads);
    Simulation sim(load_case("rolling_disk", sets_of(one)));
    double iterations = 0;
    double unknowns = 0;
    Seconds seconds;
    std::string failure;
    try {
      for (int k = 0; k < one.steps; ++k) {
        sim.step();
        for (const StepNumber& number : sim.solver().step_numbers()) {
          if (number.name == "newton_iterations") iterations += number.value;
          if (number.name == "active_unknowns") unknowns += number.value / one.steps;
          if (number.name == "step_seconds") seconds.all += number.value;
        }
      }
    } catch (const SolverError& error) {
      failure = error.what();
    }
    for (const Profile::Entry& stage : sim.solver().profile().entries()) {
      if (stage.label == std::string("assembly")) seconds.assembly = stage.seconds;
      if (stage.label == std::string("linear solve")) seconds.linear = stage.seconds;
    }
    if (!failure.empty()) {
      fmt::print("{:<18}{:>3}{:>12}{:>9}  failed: {}\n", one.row, one.J, one.linear_solver, one.threads, failure);
      return;
    }
    fmt::print("{:<18}{:>3}{:>12}{:>9}{:>7}{:>10.0f}{:>12.0f}{:>11.2f}{:>11.2f}{:>11.2f}\n", one.row, one.J, one.linear_solver, one.threads,
               one.steps, unknowns, iterations, seconds.all, seconds.assembly, seconds.linear);
    std::fflush(stdout);
    if (!file_.is_open()) return;
    file_ << fmt::format("{},{},{},{},{},{:.0f},{:.0f},{:.3f},{:.3f},{:.3f}\n", one.row, one.J, one.linear_solver, one.threads, one.steps,
                         unknowns, iterations, seconds.all, seconds.assembly, seconds.linear)
          << std::flush;
  }

 private:
  std::ofstream file_;
};

}  // namespace

void run_implicit(const std::string& csv, int threads) {
  Table table(csv);
  const int one = threads > 0 ? threads : 1;
  // The first steps with every method: E1 is symmetric and definite, E2 is not.
  for (const int J : {2, 3, 4}) {
    for (const char* row : {"E1", "E2"}) {
      for (const std::string& name : linear_solver_names()) {
        const bool is_symmetric_method = name == "ldlt" || name == "cholmod" || name == "cg";
        if (row == std::string("E2") && is_symmetric_method) continue;
        table.run({row, J, name, one, 12});
      }
    }
  }
  // Whole runs of Table 1.
  for (const int count : threads > 0 ? std::vector<int>{threads} : std::vector<int>{1, 2}) {
    table.run({"E2", 2, "auto", count, 250});
    table.run({"E2", 4, "auto", count, 250});
  }
}

}  // namespace matpoint::bench
