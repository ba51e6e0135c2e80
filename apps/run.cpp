// `matpoint run`.
#include <sys/resource.h>

#include <charconv>
#include <csignal>
#include <cstdio>

#include "case/case_file.hpp"
#include "commands.hpp"
#include "core/parallel.hpp"
#include "core/version.hpp"
#include "io/results_folder.hpp"
#include "io/state_file.hpp"
#include "progress.hpp"
#include "run/restart.hpp"
#include "run/simulation.hpp"

namespace matpoint {
namespace {

std::atomic<int> g_signal{0};
std::atomic<int> g_checkpoint{0};
static_assert(std::atomic<int>::is_always_lock_free, "a signal handler may only touch lock-free atomics");

/// The first signal asks the run to end at a step boundary; the second finds the default action and kills at once.
extern "C" void handle_signal(int number) {
  g_signal = number;
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
}

/// Asks for a checkpoint; the run goes on.
extern "C" void handle_checkpoint_signal(int) { g_checkpoint = 1; }

void catch_signals() {
  std::signal(SIGUSR1, handle_checkpoint_signal);
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
  say("matpoint {} ({}): {}{}{}\n", version(), commit(), problem.name, problem.title.empty() ? "" : ", ", problem.title);
  say("{}D, {} {}, {} particles, {} nodes, {} thread{}, to t = {:.6g} s, into {}\n", solver.dim(), solver.body_count(),
      solver.body_count() == 1 ? "body" : "bodies", particles, solver.node_count(), thread_count(), thread_count() == 1 ? "" : "s",
      problem.time.end, out);
  std::fflush(stdout);
}

/// Wall time per stage, and what is left: the clock, the checks and the outputs.
void print_profile(const Simulation& simulation, double seconds, double updates) {
  const auto print_line = [&](const std::string& label, double stage) {
    say("  {:16s} {:10.3f} {:8.1f} {:24.1f}\n", label, stage, seconds > 0 ? 100 * stage / seconds : 0,
        updates > 0 ? 1e9 * stage / updates : 0);
  };
  say("\n  {:16s} {:>10s} {:>8s} {:>24s}\n", "stage", "seconds", "%", "ns per particle-update");
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
    case RunEnd::time_limit: return "interrupted (time limit)";
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
  say("particle {} of body \"{}\" left the grid at ({:.6g}), t = {:.8g} s; particles_outside = \"stop\" ends the run here\n", first.id,
      simulation.solver().body_name(first.body), fmt::join(first.position.begin(), first.position.begin() + dim, ", "), simulation.time());
}

void print_removed(const Simulation& simulation) {
  const Ledger& ledger = simulation.solver().ledger();
  if (ledger.removed_count == 0) return;
  print_warning(fmt::format("{} particle{} left the grid and {} removed, with a mass of {:.6g} kg", ledger.removed_count,
                            ledger.removed_count == 1 ? "" : "s", ledger.removed_count == 1 ? "was" : "were", ledger.removed_mass));
}

/// What the run says about itself; what is not good is a warning, too.
void print_health(const Simulation& simulation) {
  say("\n");
  for (const HealthLine& line : simulation.health())
    say("{:<16} {} ({})\n", line.name, line.text, line.is_good ? "good" : "see the warning");
  std::fflush(stdout);
  for (const HealthLine& line : simulation.health()) {
    if (!line.is_good) print_warning(fmt::format("{}: {}; {}", line.name, line.text, line.remedy));
  }
}

/// Runs into the folder; whatever goes wrong is in the manifest before it is thrown on.
RunEnd run_into(Simulation& simulation, ResultsFolder& results, Progress& progress, std::optional<double> time_limit) {
  try {
    const RunEnd ending = simulation.run(&results, {}, {&g_signal, &g_checkpoint, time_limit});
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

namespace {

/// What a run starts with.
struct Start {
  Case problem;
  std::string out;
  ExistingFolder existing = ExistingFolder::refuse;
  std::optional<FoundState> state;
  bool is_continued = false;  ///< In the folder of the state.
};

std::string status_of(const std::string& folder) {
  const Input manifest = read_manifest(std::filesystem::path(folder) / "manifest.toml");
  const Input* const status = manifest.find("status");
  return status == nullptr ? "" : status->as_string();
}

/// A run that has no checkpoint yet begins again.
Start start_again(const RunOptions& options) {
  const std::string path = options.continued + "/manifest.toml";
  Input manifest = read_manifest(path);
  Input* const input = manifest.find("case");
  const Input* const name = manifest.find("case_name");
  if (input == nullptr || name == nullptr) throw InputError("\"{}\" was not written by matpoint", path);
  for (const std::string& set : options.checkpoint_sets) apply_set(*input, set);
  say("no checkpoint in {} yet: the run begins again\n", options.continued);
  return {Case::from_input(*input, name->as_string()), options.continued, ExistingFolder::overwrite, {}, false};
}

Start start_of(const RunOptions& options) {
  std::vector<std::string> sets = options.sets;
  sets.insert(sets.end(), options.checkpoint_sets.begin(), options.checkpoint_sets.end());
  const std::string& folder = options.continued.empty() ? options.from : options.continued;
  if (folder.empty()) {
    Case problem = load_case(options.case_name, sets);
    const std::string out = options.out.empty() ? "results/" + problem.name : options.out;
    return {std::move(problem), out, options.is_overwrite ? ExistingFolder::overwrite : ExistingFolder::refuse, {}, false};
  }
  std::optional<FoundState> found;
  std::vector<std::string> complaints;
  if (std::filesystem::is_directory(folder))
    found = newest_state(folder, complaints);
  else
    found = FoundState{folder, read_state(folder)};
  for (const std::string& complaint : complaints) print_warning(complaint + "; the one before it is taken");
  if (!found && !options.continued.empty()) return start_again(options);
  if (!found)
    throw InputError("\"{}\" has no checkpoint to start from; run it with --checkpoint-steps, --checkpoint-time or --checkpoint-wall",
                     folder);
  Case problem = case_of(*found, sets, options.continued.empty());
  say("from {}\n", found->path.string());
  if (!options.continued.empty()) return {std::move(problem), folder, ExistingFolder::overwrite, std::move(found), true};
  const std::string out = options.out.empty() ? "results/" + problem.name : options.out;
  return {std::move(problem), out, options.is_overwrite ? ExistingFolder::overwrite : ExistingFolder::refuse, std::move(found), false};
}

std::optional<double> read_time_limit(const std::string& text) {
  if (text.empty()) return {};
  double seconds = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seconds);
  if (error != std::errc{} || end != text.data() + text.size() || !(seconds > 0))
    throw InputError("--time-limit = {} is not allowed: give a number of seconds > 0", text);
  return seconds;
}

}  // namespace

int run_command(const RunOptions& options) {
  // A reader of what is printed that goes away (`| head`) does not end the run.
  std::signal(SIGPIPE, SIG_IGN);
  const std::optional<double> time_limit = read_time_limit(options.time_limit);
  if (!options.continued.empty()) {
    if (!std::filesystem::exists(options.continued + "/manifest.toml"))
      throw InputError("\"{}\" is no results folder: it has no manifest.toml", options.continued);
    if (status_of(options.continued) == "finished") {
      say("{} has finished already\n", options.continued);
      settle_standard_output();
      return k_exit_done;
    }
  }
  Start start = start_of(options);
  const std::string& out = start.out;
  // Before particles are made: a folder that may not be used is said at once, also for a large case.
  ResultsFolder results(out, start.existing);
  Simulation simulation(std::move(start.problem));
  for (const std::string& warning : simulation.warnings()) print_warning(warning);
  if (start.state) simulation.load_state(start.state->table, !start.is_continued);

  catch_signals();
  if (start.is_continued)
    results.begin_again(simulation, start.state->table, thread_count(), options.command);
  else
    results.begin(simulation, thread_count(), options.command);
  start.state.reset();
  print_start(simulation, out);
  Progress progress(simulation.problem());
  simulation.add_callback([&progress](const Simulation& now) {
    progress.update(now);
    return true;
  });
  const RunEnd ending = run_into(simulation, results, progress, time_limit);
  const double seconds = progress.seconds();

  if (ending == RunEnd::particle_left) print_particle_left(simulation);
  print_removed(simulation);
  print_profile(simulation, seconds, progress.particle_updates());
  print_health(simulation);
  say("\n{}: {} steps to t = {:.8g} s in {}, {} particle-updates/s on {} thread{}\n", ending_text(ending), simulation.step_count(),
      simulation.time(), duration_text(seconds), count_text(seconds > 0 ? progress.particle_updates() / seconds : 0), thread_count(),
      thread_count() == 1 ? "" : "s");
  say("results: {}\n", out);
  if (ending == RunEnd::interrupted || ending == RunEnd::time_limit)
    say("next:    {} run --continue {}\n", shell_word(options.program), shell_word(out));
  else
    say("next:    {} plot {}\n", shell_word(options.program), shell_word(out));
  settle_standard_output();
  return ending == RunEnd::interrupted ? 128 + g_signal : ending == RunEnd::time_limit ? k_exit_time_limit : k_exit_done;
}

}  // namespace matpoint
