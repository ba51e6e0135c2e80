#include "implicit.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <fstream>
#include <stdexcept>

#include "case/case_file.hpp"
#include "case/linear_solver_names.hpp"
#include "core/parallel.hpp"
#include "run/simulation.hpp"

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

constexpr const char* k_stages[] = {"locate", "assembly", "linear solve", "inversion", "update"};

}  // namespace

void run_coupled(const std::string& csv, int threads) {
  set_thread_count(threads > 0 ? threads : 1);
  std::ofstream file;
  if (!csv.empty()) {
    file.open(csv);
    if (!file) throw std::runtime_error(fmt::format("cannot write {}", csv));
    file << "J,threads,steps,unknowns,newton_iterations,seconds,locate,assembly,linear_solve,inversion,update\n";
  }
  fmt::print("{:<14}{:>3}{:>9}{:>7}{:>10}{:>12}{:>10}", "disk on plate", "J", "threads", "steps", "unknowns", "iterations", "seconds");
  for (const char* stage : k_stages) fmt::print("{:>14}", stage);
  fmt::print("\n");
  for (const int J : {2, 3}) {
    Simulation sim(load_case("disk_on_plate",
                             {fmt::format("grid.refinements={}", J), fmt::format("body.disk.region.center=[0,{}]", 0.2 / (1 << (J - 1)))}));
    constexpr int k_steps = 250;
    double iterations = 0, unknowns = 0, seconds = 0;
    for (int k = 0; k < k_steps; ++k) {
      sim.step();
      for (const StepNumber& number : sim.solver().step_numbers()) {
        if (number.name == "newton_iterations") iterations += number.value;
        if (number.name == "active_unknowns") unknowns += number.value / k_steps;
        if (number.name == "step_seconds") seconds += number.value;
      }
    }
    std::string text =
        fmt::format("{:<14}{:>3}{:>9}{:>7}{:>10.0f}{:>12.0f}{:>10.1f}", "row 2", J, thread_count(), k_steps, unknowns, iterations, seconds);
    std::string row = fmt::format("{},{},{},{:.0f},{:.0f},{:.2f}", J, thread_count(), k_steps, unknowns, iterations, seconds);
    for (const char* stage : k_stages) {
      double spent = 0;
      for (const Profile::Entry& entry : sim.solver().profile().entries()) {
        if (entry.label == std::string(stage)) spent = entry.seconds;
      }
      text += fmt::format("{:>14.1f}", spent);
      row += fmt::format(",{:.2f}", spent);
    }
    fmt::print("{}\n", text);
    std::fflush(stdout);
    if (file.is_open()) file << row << "\n" << std::flush;
  }
}

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
