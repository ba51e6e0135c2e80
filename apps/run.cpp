// `matpoint run`.
#include <sys/resource.h>

#include <csignal>
#include <cstdio>

#include "case/case_file.hpp"
#include "commands.hpp"
#include "core/parallel.hpp"
#include "core/version.hpp"
#include "io/results_folder.hpp"
#include "progress.hpp"
#include "run/simulation.hpp"

namespace matpoint {
namespace {

std::atomic<int> g_signal{0};
static_assert(std::atomic<int>::is_always_lock_free, "a signal handler may only touch lock-free atomics");

/// The first signal asks the run to end at a step boundary; the second finds the default action and kills at once.
extern "C" void handle_signal(int number) {
  g_signal = number;
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
}

void catch_signals() {
  std::signal(SIGINT, handle_signal);
  std::signal(SIGTERM, handle_signal);
  // A file size limit shall be an error of a write, with a message, and not a silent death.
  std::signal(SIGXFSZ, SIG_IGN);
}

void print_start(const Simulation& simulation, const std::string& out) {
  const Solver& solver = simulation.solver();
  Index particles = 0;
  for (std::size_t b = 0; b < solver.body_count(); ++b) particles += solver.particle_count(b);
  const Case& problem = simulation.problem();
  fmt::print("matpoint {} ({}): {}{}{}\n", version(), commit(), problem.name, problem.title.empty() ? "" : ", ", problem.title);
  fmt::print("{}D, {} {}, {} particles, {} nodes, {} thread{}, to t = {:.6g} s, into {}\n", solver.dim(), solver.body_count(),
             solver.body_count() == 1 ? "body" : "bodies", particles, solver.node_count(), thread_count(), thread_count() == 1 ? "" : "s",
             problem.time.end, out);
  std::fflush(stdout);
}

/// Wall time per stage, and what is left: the clock, the checks and the outputs.
void print_profile(const Simulation& simulation, double seconds, double updates) {
  const auto print_line = [&](const std::string& label, double stage) {
    fmt::print("  {:16s} {:10.3f} {:8.1f} {:24.1f}\n", label, stage, seconds > 0 ? 100 * stage / seconds : 0,
               updates > 0 ? 1e9 * stage / updates : 0);
  };
  fmt::print("\n  {:16s} {:>10s} {:>8s} {:>24s}\n", "stage", "seconds", "%", "ns per particle-update");
  double staged = 0;
  for (const Profile::Entry& entry : simulation.solver().profile().entries()) {
    print_line(entry.label, entry.seconds);
    staged += entry.seconds;
  }
  print_line("output, rest", std::max(0.0, seconds - staged));
  print_line("all", seconds);
}

std::string ending_text(RunEnd ending) {
  switch (ending) {
    case RunEnd::particle_left: return "stopped (a particle left the grid)";
    case RunEnd::interrupted: return "interrupted";
    case RunEnd::stopped_by_callback: return "stopped";
    case RunEnd::finished: break;
  }
  return "finished";
}

void print_particle_left(const Simulation& simulation) {
  const std::vector<Escape>& escapes = simulation.solver().escapes();
  if (escapes.empty()) return;
  const Escape& first = escapes.front();
  const int dim = simulation.solver().dim();
  fmt::print("particle {} of body \"{}\" left the grid at ({:.6g}), t = {:.8g} s; particles_outside = \"stop\" ends the run here\n",
             first.id, simulation.solver().body_name(first.body), fmt::join(first.position.begin(), first.position.begin() + dim, ", "),
             simulation.time());
}

void print_removed(const Simulation& simulation) {
  const Ledger& ledger = simulation.solver().ledger();
  if (ledger.removed_count == 0) return;
  print_warning(fmt::format("{} particle{} left the grid and {} removed, with a mass of {:.6g} kg", ledger.removed_count,
                            ledger.removed_count == 1 ? "" : "s", ledger.removed_count == 1 ? "was" : "were", ledger.removed_mass));
}

/// What the run says about itself; what is not good is a warning, too.
void print_health(const Simulation& simulation) {
  fmt::print("\n");
  for (const HealthLine& line : simulation.health())
    fmt::print("{:<16} {} ({})\n", line.name, line.text, line.is_good ? "good" : "see the warning");
  std::fflush(stdout);
  for (const HealthLine& line : simulation.health()) {
    if (!line.is_good) print_warning(fmt::format("{}: {}; {}", line.name, line.text, line.remedy));
  }
}

/// Runs into the folder; whatever goes wrong is in the manifest before it is thrown on.
RunEnd run_into(Simulation& simulation, ResultsFolder& results, Progress& progress) {
  try {
    const RunEnd ending = simulation.run(&results, {}, &g_signal);
    progress.clear();
    results.finish(simulation, ending_text(ending));
    return ending;
  } catch (const SolverError& error) {
    progress.clear();
    results.fail(simulation, error.what());
    throw SolverError("{}; written: {}", error.what(), results.last_written());
  } catch (const std::exception& error) {
    progress.clear();
    results.fail(simulation, error.what());
    throw;
  }
}

}  // namespace

int run_command(const RunOptions& options) {
  Case problem = load_case(options.case_name, options.sets);
  const std::string out = options.out.empty() ? "results/" + problem.name : options.out;
  // Before particles are made: a folder that may not be used is said at once, also for a large case.
  ResultsFolder results(out, options.is_overwrite ? ExistingFolder::overwrite : ExistingFolder::refuse);
  Simulation simulation(std::move(problem));
  for (const std::string& warning : simulation.warnings()) print_warning(warning);

  catch_signals();
  results.begin(simulation, thread_count(), options.command);
  print_start(simulation, out);
  Progress progress(simulation.problem());
  simulation.add_callback([&progress](const Simulation& now) {
    progress.update(now);
    return true;
  });
  const RunEnd ending = run_into(simulation, results, progress);
  const double seconds = progress.seconds();

  if (ending == RunEnd::particle_left) print_particle_left(simulation);
  print_removed(simulation);
  print_profile(simulation, seconds, progress.particle_updates());
  print_health(simulation);
  fmt::print("\n{}: {} steps to t = {:.8g} s in {}, {} particle-updates/s on {} thread{}\n", ending_text(ending), simulation.step_count(),
             simulation.time(), duration_text(seconds), count_text(seconds > 0 ? progress.particle_updates() / seconds : 0), thread_count(),
             thread_count() == 1 ? "" : "s");
  fmt::print("results: {}\n", out);
  fmt::print("next:    {} plot {}\n", shell_word(options.program), shell_word(out));
  return ending == RunEnd::interrupted ? 128 + g_signal : k_exit_done;
}

}  // namespace matpoint
