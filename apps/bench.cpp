// `matpoint bench`: hands over to the program matpoint-bench beside this one. That is compiled for the building host alone.
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "commands.hpp"
#include "core/error.hpp"

namespace matpoint {

int bench_command(std::vector<std::string> words) {
  std::error_code error;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", error);
  if (error) throw InputError("cannot find the benchmark: /proc/self/exe: {}; start the program matpoint-bench yourself", error.message());
  const std::filesystem::path program = self.parent_path() / "matpoint-bench";
  words.insert(words.begin(), program.string());
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  execv(arguments[0], arguments.data());
  throw InputError("cannot start the benchmark {}: {}; `cmake --build --preset release --target matpoint_bench` makes it", program.string(),
                   std::strerror(errno));
}

}  // namespace matpoint
