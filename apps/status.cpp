// `matpoint status`.
#include <fmt/format.h>

#include "commands.hpp"
#include "core/error.hpp"
#include "io/results_folder.hpp"

namespace matpoint {
namespace {

std::string text_of(const Input& manifest, const char* key) {
  const Input* const value = manifest.find(key);
  return value == nullptr ? "" : value->kind() == Input::Kind::string ? value->as_string() : value->text();
}

/// When a file of the folder was written last.
std::string last_written(const std::filesystem::path& folder) {
  std::filesystem::file_time_type newest = std::filesystem::file_time_type::min();
  std::error_code error;
  for (const auto& file : std::filesystem::recursive_directory_iterator(folder, error)) {
    if (file.is_regular_file(error)) newest = std::max(newest, file.last_write_time(error));
  }
  const auto time = std::chrono::time_point_cast<std::chrono::seconds>(std::chrono::file_clock::to_sys(newest));
  return time_stamp(std::chrono::system_clock::to_time_t(time));
}

}  // namespace

int status_command(const std::string& name) {
  const std::filesystem::path folder = name;
  if (!std::filesystem::exists(folder / "manifest.toml")) throw InputError("\"{}\" is no results folder: it has no manifest.toml", name);
  const Input manifest = read_manifest(folder / "manifest.toml");
  const FolderUse use = folder_use(folder);
  std::string status = text_of(manifest, "status");
  const bool is_open = status == "running";
  if (is_open && use.is_locked)
    status = fmt::format("running: process {} on {} since {}", use.process, use.host, use.started);
  else if (is_open && !use.host.empty() && !use.is_here())
    status = fmt::format("unknown: process {} on {} wrote last at {}; ask there", use.process, use.host, last_written(folder));
  else if (is_open)
    status = fmt::format("dead: process {} ended without a word, and wrote last at {}", use.process, last_written(folder));
  fmt::print("{}: {}\n", name, status);
  if (!is_open) fmt::print("t = {} s, {} steps\n", text_of(manifest, "time"), text_of(manifest, "steps"));
  if (!text_of(manifest, "message").empty()) fmt::print("{}\n", text_of(manifest, "message"));
  const std::vector<std::filesystem::path> checkpoints = checkpoints_of(folder);
  for (const std::filesystem::path& path : checkpoints) fmt::print("checkpoint: {}\n", path.string());
  if (!use.is_locked && status != "finished")
    fmt::print("next: matpoint run --continue {}{}\n", shell_word(name),
               checkpoints.empty() ? " (from the start: there is no checkpoint)" : "");
  return k_exit_done;
}

}  // namespace matpoint
