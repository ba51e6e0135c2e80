#include "io/manifest.hpp"

#include <ctime>
#include <fstream>
#include <sstream>

#include "case/case_file.hpp"
#include "core/version.hpp"
#include "kernel/kernel.hpp"

namespace matpoint {
namespace {

/// The first line, by which a folder is recognised as ours before anything in it is deleted.
constexpr const char* k_signature = "# matpoint results";

Input string_list(const std::vector<std::string>& texts) {
  std::vector<Input> items;
  for (const std::string& text : texts) items.push_back(Input::string(text));
  return Input::array(std::move(items));
}

Input profile_table(const Profile& profile) {
  Input table = Input::table();
  for (const Profile::Entry& entry : profile.entries()) table.set(entry.label, Input::real(entry.seconds));
  return table;
}

Input health_table(const std::vector<HealthLine>& health) {
  Input table = Input::table();
  for (const HealthLine& line : health) {
    Input& entry = table.set(line.name, Input::table());
    entry.set("text", Input::string(line.text));
    entry.set("good", Input::boolean(line.is_good));
    if (!line.remedy.empty()) entry.set("remedy", Input::string(line.remedy));
  }
  return table;
}

}  // namespace

std::string time_stamp(std::time_t time) {
  std::tm utc{};
  gmtime_r(&time, &utc);
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}Z", utc.tm_year + 1900, utc.tm_mon + 1, utc.tm_mday, utc.tm_hour, utc.tm_min,
                     utc.tm_sec);
}

std::string manifest_text(const Manifest& manifest, const Snapshot& snapshot) {
  Input run = Input::table();
  run.set("status", Input::string(manifest.status));
  if (!manifest.message.empty()) run.set("message", Input::string(manifest.message));
  run.set("case_name", Input::string(snapshot.problem.name));
  run.set("command", Input::string(manifest.command));
  run.set("version", Input::string(version()));
  run.set("commit", Input::string(commit()));
  run.set("instruction_set", Input::string(instruction_set()));
  run.set("threads", Input::integer(manifest.threads));
  run.set("started", Input::string(manifest.started));
  if (!manifest.ended.empty()) run.set("ended", Input::string(manifest.ended));
  run.set("time", Input::real(snapshot.time));
  run.set("steps", Input::integer(snapshot.step));
  run.set("files", string_list(manifest.files));
  if (!manifest.probes.empty()) run.set("probes", string_list(manifest.probes));
  Input& units = run.set("units", Input::table());
  units.set("history", manifest.history_units);
  units.set("fields", manifest.field_units);
  if (snapshot.health != nullptr && !snapshot.health->empty()) run.set("health", health_table(*snapshot.health));
  run.set("seconds", profile_table(snapshot.solver.profile()));
  run.set("case", manifest.case_input);
  return fmt::format("{}\n{}", k_signature, write_toml(run));
}

Input read_manifest(const std::filesystem::path& path) {
  std::ifstream stream(path);
  std::stringstream text;
  text << stream.rdbuf();
  const InputError foreign("\"{}\" was not written by matpoint", path.string());
  if (!stream || !text.str().starts_with(k_signature)) throw foreign;
  return parse_toml(text.str(), path.string());
}

std::vector<std::string> manifest_files(const std::filesystem::path& path) {
  const InputError foreign("\"{}\" was not written by matpoint", path.string());
  const Input run = read_manifest(path);
  const Input* files = run.find("files");
  if (files == nullptr || files->kind() != Input::Kind::array) throw foreign;
  std::vector<std::string> names;
  for (const Input& item : files->items()) {
    if (item.kind() != Input::Kind::string) throw foreign;
    names.push_back(item.as_string());
  }
  return names;
}

}  // namespace matpoint
