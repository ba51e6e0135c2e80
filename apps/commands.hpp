// The commands of the program `matpoint`, each in its own file: what they need from the command line, and their exit codes.
#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <string>
#include <vector>

namespace matpoint {

/// Exit codes; a signal's is 128 + its number (docs/case_file.md lists them).
enum ExitCode { k_exit_done = 0, k_exit_bug = 1, k_exit_input = 2, k_exit_failed = 3, k_exit_time_limit = 75 };

struct RunOptions {
  std::string program;  ///< argv[0]: the next command is offered with the same words.
  std::string command;  ///< The whole command line, for the manifest.
  std::string case_name;
  std::vector<std::string> sets;
  std::string out;  ///< Empty: results/<case name>.
  bool is_overwrite = false;
  std::string continued;                     ///< A results folder to go on in; empty: none.
  std::string from;                          ///< A results folder or a state to start from; empty: none.
  std::vector<std::string> checkpoint_sets;  ///< What --checkpoint-... says, as --set.
  std::string time_limit;                    ///< [s]; empty: none.
};

struct PlotOptions {
  std::string folder;
  std::vector<std::string> fields;
  std::vector<std::string> times;
};

struct TestMaterialOptions {
  std::string program;            ///< argv[0], as of `run`.
  std::string what;               ///< A law, or a case.
  std::string body;               ///< Of the case; empty: the first.
  std::vector<std::string> sets;  ///< Parameters of the law, or changes of the case.
  std::vector<std::string> test;  ///< KEY=VALUE of the test.
  std::string out;                ///< A CSV file; empty: standard output.
};

/// Runs a case into a results folder.
int run_command(const RunOptions& options);

/// Says how the run of a results folder stands.
int status_command(const std::string& folder);

/// Says what a run of the case would be: resolved values, sizes, time step, time needed. Writes nothing.
int check_command(const std::string& case_name, const std::vector<std::string>& sets);

/// What there is: shipped cases, materials, regions, layouts, velocities, sections, fields; or one of these.
int list_command(const std::string& what);

/// Parameters of whatever is called `name`.
int explain_command(const std::string& name);

/// Becomes the Python program that draws the pictures: returns only by InputError.
int plot_command(const PlotOptions& options);

/// A table of one point of a material on a path.
int test_material_command(const TestMaterialOptions& options);

/// Becomes the benchmark, with the words after `bench`: returns only by InputError.
int bench_command(std::vector<std::string> words);

/// On standard output; a run does not end because nobody can read what it says.
template <class... T>
void say(fmt::format_string<T...> text, T&&... values) {
  std::fputs(fmt::format(text, std::forward<T>(values)...).c_str(), stdout);
}

/// If standard output could not be written, says so on standard error, and no more of it.
void settle_standard_output();

/// Prints `warning: ...` on standard error.
void print_warning(const std::string& text);

/// A word as a shell takes it, quoted when needed.
std::string shell_word(const std::string& word);

/// 12.3 s, 4 min 05 s, 2 h 03 min.
std::string duration_text(double seconds);

/// 123, 12.3 k, 4.5 M: a count with three digits.
std::string count_text(double count);

}  // namespace matpoint
