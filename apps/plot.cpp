// `matpoint plot`: hands over to python/matpoint/plot_command.py.
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "commands.hpp"
#include "core/error.hpp"

namespace matpoint {
namespace {

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

}  // namespace

int plot_command(const PlotOptions& options) {
  const std::string asked = environment("MATPOINT_PYTHON");
  const std::string recorded = MATPOINT_PYTHON;
  const std::string python = !asked.empty() ? asked : !recorded.empty() ? recorded : "python3";

  const std::string package = MATPOINT_PYTHON_PATH;
  const std::string path = environment("PYTHONPATH");
  if (!package.empty()) setenv("PYTHONPATH", (path.empty() ? package : package + ":" + path).c_str(), 1);

  std::vector<std::string> words = {python, "-m", "matpoint.plot_command"};
  for (const std::string& field : options.fields) words.push_back("--field=" + field);
  for (const std::string& times : options.times) words.push_back("--times=" + times);
  words.insert(words.end(), {"--", options.folder});  // also a folder whose name begins with a dash
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);

  std::fflush(nullptr);  // what is still in a buffer would be lost with this program
  execvp(arguments[0], arguments.data());
  const std::string reason = std::strerror(errno);
  const char* origin = !asked.empty()      ? "from the environment variable MATPOINT_PYTHON"
                       : !recorded.empty() ? "recorded by the build"
                                           : "the default";
  throw InputError("cannot start the Python interpreter \"{}\" ({}): {}; set MATPOINT_PYTHON to a Python with matplotlib and h5py", python,
                   origin, reason);
}

}  // namespace matpoint
