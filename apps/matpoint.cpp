// The program `matpoint`: reads the command line, calls one command, and turns every way to fail into its exit code.
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <system_error>

#include "commands.hpp"
#include "core/error.hpp"
#include "core/parallel.hpp"
#include "core/version.hpp"
#include "material/point_test.hpp"
#include "run/make_solver.hpp"
#include "verify/verify.hpp"

namespace matpoint {
namespace {

/// What the command line says, for all commands.
struct Arguments {
  RunOptions run;
  PlotOptions plot;
  TestMaterialOptions test;
  VerifyOptions verify;
  std::string name;  ///< CASE or NAME of check, list and explain.
  std::vector<std::string> sets;
  std::string threads = "0";
  bool is_verify_list = false;
};

/// The whole text as a number of threads.
int read_threads(const std::string& text) {
  constexpr int k_threads_max = 1024;
  int count = -1;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), count);
  if (error != std::errc{} || end != text.data() + text.size() || count < 0 || count > k_threads_max) {
    throw InputError("--threads = {} is not allowed: give 1 to {}, or 0 for all processors", text, k_threads_max);
  }
  return count;
}

void add_threads(CLI::App& command, Arguments& arguments) {
  command.add_option("--threads", arguments.threads, "Threads; 0 (the default) takes all processors")->type_name("N");
}

void add_case(CLI::App& command, std::string& name, std::vector<std::string>& sets, bool is_required = true) {
  command.add_option("CASE", name, "A case file, or the name of a shipped case (`matpoint list cases`)")
      ->required(is_required)
      ->type_name("");
  // One value per --set: otherwise `--set a=1 CASE` would swallow the case.
  command.add_option("--set", sets, "Change a value of the case, e.g. --set solver.flip=0.99; may be repeated")
      ->allow_extra_args(false)
      ->type_name("KEY=VALUE");
}

void add_run(CLI::App& app, Arguments& arguments) {
  CLI::App& command = *app.add_subcommand("run", "Run a case and write its results into a folder");
  add_case(command, arguments.run.case_name, arguments.run.sets, false);
  add_threads(command, arguments);
  command.add_option("--out", arguments.run.out, "Results folder; default: results/<case name>")->type_name("DIR");
  command.add_flag("--overwrite", arguments.run.is_overwrite, "Replace the results of an earlier run in that folder");
  command.add_option("--continue", arguments.run.continued, "Go on with the run of a results folder, from its last checkpoint")
      ->type_name("DIR");
  command.add_option("--from", arguments.run.from, "Start a new run from the last checkpoint of a results folder, or from a state")
      ->type_name("DIR");
  for (const auto& [option, help] :
       {std::pair("steps", "Checkpoint after every so many steps"), std::pair("time", "Checkpoint after so much simulated time [s]"),
        std::pair("wall", "Checkpoint after so many seconds of computing")}) {
    const std::string key = std::string("output.checkpoint_") + option + "=";
    command
        .add_option_function<std::string>(
            std::string("--checkpoint-") + option,
            [&arguments, key](const std::string& value) { arguments.run.checkpoint_sets.push_back(key + value); }, help)
        ->type_name(std::string(option) == "steps" ? "N" : "T");
  }
  command.add_option("--time-limit", arguments.run.time_limit, "End after so many seconds with a checkpoint, and exit with 75")
      ->type_name("T");
}

void add_status(CLI::App& app, Arguments& arguments) {
  CLI::App& command = *app.add_subcommand("status", "Say how the run of a results folder stands: running, finished, dead");
  command.add_option("DIR", arguments.name, "The results folder")->required()->type_name("");
}

void add_check(CLI::App& app, Arguments& arguments) {
  CLI::App& command = *app.add_subcommand("check", "Say what a run would be: resolved values, sizes, time step, time needed");
  add_case(command, arguments.name, arguments.sets);
  add_threads(command, arguments);
}

void add_list_and_explain(CLI::App& app, Arguments& arguments) {
  CLI::App& list = *app.add_subcommand("list", "List shipped cases, materials, regions, layouts, velocities, sections, fields");
  list.add_option("WHAT", arguments.name, "One of these; default: all")->type_name("");
  CLI::App& explain = *app.add_subcommand("explain", "Explain a material, region, layout, velocity, section, parameter or shipped case");
  explain.add_option("NAME", arguments.name, "What to explain")->required()->type_name("");
}

void add_plot(CLI::App& app, Arguments& arguments) {
  CLI::App& command = *app.add_subcommand("plot", "Draw pictures of a results folder into it, or the curves of a test of a material");
  command.add_option("DIR", arguments.plot.folder, "The results folder, or a table of test-material")->required()->type_name("");
  command.add_option("--field", arguments.plot.fields, "Field that colours the particles; may be repeated")
      ->allow_extra_args(false)
      ->type_name("NAME");
  command.add_option("--times", arguments.plot.times, "Times [s] of the pictures, e.g. 0,0.5,1; default: six")
      ->allow_extra_args(false)
      ->type_name("T,T,...");
}

void add_test_material(CLI::App& app, Arguments& arguments) {
  CLI::App& command = *app.add_subcommand("test-material", "Strain one point of a material, as in a laboratory: a table");
  command.add_option("WHAT", arguments.test.what, "A law (with --set density=...), or a case")->required()->type_name("");
  command.add_option("--set", arguments.test.sets, "A parameter of the law, or a change of the case")->type_name("KEY=VALUE");
  command.add_option("--body", arguments.test.body, "The body of the case; default: the first")->type_name("NAME");
  for (const ParameterDescription& parameter : parameters_of<PointTestSpec>().describe()) {
    const std::string key = parameter.name + "=";
    const bool is_text = parameter.type == "string";
    auto* const option = command.add_option_function<std::string>(
        "--" + parameter.name,
        [&arguments, key, is_text](const std::string& value) {
          arguments.test.test.push_back(is_text ? key + '"' + value + '"' : key + value);
        },
        parameter.help + (parameter.default_text.empty() ? "" : fmt::format(" Default: {}.", parameter.default_text)));
    option->type_name(is_text ? "NAME" : "X");
    if (parameter.is_required) option->required();
  }
  command.add_option("--out", arguments.test.out, "A CSV file; default: standard output")->type_name("FILE");
}

void add_verify(CLI::App& app, Arguments& arguments) {
  CLI::App& command = *app.add_subcommand("verify", "Compare with published and exact numbers; exit code 3 when a bound is missed");
  command.add_option("NAME", arguments.verify.names, "Cases, groups or jobs of --list; default: all of the preset")->type_name("");
  command.add_option("--preset", arguments.verify.preset, "quick (minutes) or full (hours; name some)")
      ->capture_default_str()
      ->type_name("PRESET");
  command
      .add_option("--set", arguments.verify.sets,
                  "Numerics for the everyday problems, e.g. solver.shape=linear, in place of the defaults and each quality")
      ->type_name("KEY=VALUE");
  command.add_option("--out", arguments.verify.csv, "The table as a CSV file")->capture_default_str()->type_name("FILE");
  command.add_flag("--list", arguments.is_verify_list, "Only list what the preset has");
  add_threads(command, arguments);
}

void add_bench(CLI::App& app) {
  // Its options are its own: `matpoint bench --help` is the benchmark's.
  CLI::App& command = *app.add_subcommand("bench", "Measure the speed on this machine, beside plain loops (--list, --help)");
  command.prefix_command();
  command.set_help_flag();
}

/// The command line's errors as one line, with the nearest option.
std::string parse_error_text(const CLI::App& app, const CLI::ParseError& error) {
  const std::vector<CLI::App*> chosen = app.get_subcommands();
  const CLI::App& command = chosen.empty() ? app : *chosen.front();
  const std::string see = fmt::format("(see `matpoint{}{} --help`)", chosen.empty() ? "" : " ", command.get_name());
  if (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr) {
    std::vector<std::string> options;
    for (const CLI::Option* option : command.get_options()) {
      for (const std::string& name : option->get_lnames()) options.push_back("--" + name);
    }
    std::vector<std::string> commands;
    for (const CLI::App* sub : app.get_subcommands(nullptr)) commands.push_back(sub->get_name());
    for (const std::string& word : app.remaining(true)) {
      if (word.starts_with("-"))
        return fmt::format("unknown option \"{}\"{} {}", word, did_you_mean(word.substr(0, word.find('=')), options), see);
    }
    const std::string word = app.remaining(true).empty() ? "" : app.remaining(true).front();
    if (chosen.empty())
      return fmt::format("unknown command \"{}\", allowed: {}{}", word, list_names(commands), did_you_mean(word, commands));
    return fmt::format("unexpected argument \"{}\" {}", word, see);
  }
  return fmt::format("{} {}", error.what(), see);
}

/// What a run starts from is said in one way.
void check_run(const RunOptions& run) {
  const int given = (run.case_name.empty() ? 0 : 1) + (run.continued.empty() ? 0 : 1) + (run.from.empty() ? 0 : 1);
  if (given == 0) throw InputError("CASE is required (see `matpoint run --help`)");
  if (given > 1)
    throw InputError("CASE, --continue and --from exclude each other: a state has its own case; change it with --from DIR --set ...");
  if (run.continued.empty()) return;
  if (!run.sets.empty())
    throw InputError("--set is not for --continue, which goes on with the same case; --from DIR --set ... starts a new run");
  if (!run.out.empty() || run.is_overwrite)
    throw InputError("--out and --overwrite are not for --continue, which writes on in the same folder");
}

int dispatch(const CLI::App& app, Arguments& arguments) {
  const std::string command = app.get_subcommands().front()->get_name();
  const int threads = read_threads(arguments.threads);
  set_thread_count(threads);
  if (command == "run") {
    check_run(arguments.run);
    return run_command(arguments.run);
  }
  if (command == "status") return status_command(arguments.name);
  if (command == "check") return check_command(arguments.name, arguments.sets);
  if (command == "list") return list_command(arguments.name);
  if (command == "explain") return explain_command(arguments.name);
  if (command == "plot") return plot_command(arguments.plot);
  if (command == "test-material") return test_material_command(arguments.test);
  if (command == "bench") return bench_command(app.get_subcommands().front()->remaining());
  const std::string& preset = arguments.verify.preset;
  if (preset != "quick" && preset != "full") {
    throw InputError("--preset = {} is unknown, allowed: \"quick\" or \"full\"{}", preset, did_you_mean(preset, {"quick", "full"}));
  }
  arguments.verify.threads = threads;
  if (!arguments.is_verify_list) return run_verify(arguments.verify);
  for (const std::string& line : list_verify_jobs(preset)) fmt::print("{}\n", line);
  return k_exit_done;
}

int run_program(int argc, char** argv) {
  // Before anything is said: errors, too, come from the first rank alone.
  if (argc > 1 && std::string(argv[1]) == "run" && has_worked_for_first_rank()) return k_exit_done;
  Arguments arguments;
  CLI::App app("matpoint: the explicit material point method, 2D (plane strain) and 3D", "matpoint");
  app.set_version_flag("--version", fmt::format("matpoint {} ({})", version(), commit()));
  app.require_subcommand(1);
  app.footer("First steps: `matpoint list cases`, `matpoint run disks`, `matpoint plot results/disks`.");
  add_run(app, arguments);
  add_status(app, arguments);
  add_check(app, arguments);
  add_list_and_explain(app, arguments);
  add_plot(app, arguments);
  add_test_material(app, arguments);
  add_verify(app, arguments);
  add_bench(app);

  arguments.run.program = argv[0];
  arguments.test.program = argv[0];
  for (int i = 0; i < argc; ++i) arguments.run.command += (i > 0 ? " " : "") + shell_word(argv[i]);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& help) {
    return app.exit(help);
  } catch (const CLI::ParseError& error) {
    // An unknown word is worth more than the complaint about what is missing because of it.
    if (app.get_subcommands().empty() && argc > 1) throw InputError(parse_error_text(app, CLI::ExtrasError({argv[1]})));
    throw InputError(parse_error_text(app, error));
  }
  return dispatch(app, arguments);
}

/// Threads of GNU OpenMP that wait for each other spin for milliseconds; when other programs want the processors, too, a run becomes
/// tens of times slower. The library reads how long to spin before main() begins, so the program starts itself once more.
void limit_spinning(char** argv) {
  const bool has_spin = std::getenv("GOMP_SPINCOUNT") != nullptr || std::getenv("OMP_WAIT_POLICY") != nullptr;
  if (has_spin && std::getenv("OPENBLAS_NUM_THREADS") != nullptr) return;
  // One thread of BLAS (linear_solver.cpp says why); otherwise it makes all it may when it is loaded, and hangs where there is no room.
  setenv("OPENBLAS_NUM_THREADS", "1", 0);
  if (!has_spin) setenv("GOMP_SPINCOUNT", "20000", 1);  // about 50 microseconds, more than the pause between two sweeps
  execv("/proc/self/exe", argv);                        // comes back only if there is no such file: then threads spin
}

int fail(int code, const std::string& text) {
  std::fflush(stdout);
  std::fputs(fmt::format("error: {}\n", text).c_str(), stderr);  // where nobody can read it, the exit code says it
  return code;
}

}  // namespace
}  // namespace matpoint

int main(int argc, char** argv) {
  using namespace matpoint;
  limit_spinning(argv);
  try {
    const int code = run_program(argc, argv);
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
      return fail(k_exit_failed, fmt::format("cannot write to standard output: {}", std::generic_category().message(errno)));
    }
    return code;
  } catch (const InputError& error) {
    return fail(k_exit_input, error.what());
  } catch (const SolverError& error) {
    return fail(k_exit_failed, error.what());
  } catch (const std::bad_alloc&) {
    return fail(k_exit_failed, "out of memory; `matpoint check` says how much a case needs");
  } catch (const std::system_error& error) {
    return fail(k_exit_failed, fmt::format("the system refused: {}", error.what()));
  } catch (const std::exception& error) {
    return fail(k_exit_bug,
                fmt::format("{}\nthis is a bug in matpoint, please report it with the command line and the case", error.what()));
  }
}
