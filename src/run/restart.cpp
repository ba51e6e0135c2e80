#include "run/restart.hpp"

#include <algorithm>
#include <regex>

#include "case/case_file.hpp"
#include "io/results_folder.hpp"
#include "io/state_file.hpp"

namespace matpoint {
namespace {

/// All single values of a resolved case, by their paths; bodies and probes by name.
void flatten(const Input& input, const std::string& path, std::map<std::string, std::string>& values) {
  const std::string below = path.empty() ? "" : path + ".";
  if (input.kind() == Input::Kind::table) {
    for (const auto& [key, value] : input.entries()) flatten(value, below + key, values);
  } else if (input.kind() == Input::Kind::array && !input.items().empty() && input.items().front().kind() == Input::Kind::table) {
    std::size_t number = 0;
    for (const Input& item : input.items()) {
      const Input* const name = item.find("name");
      ++number;
      flatten(item, below + (name != nullptr ? name->as_string() : std::to_string(number)), values);
    }
  } else {
    values[path] =
        input.kind() == Input::Kind::real || input.kind() == Input::Kind::integer ? fmt::format("{}", input.as_real()) : input.text();
  }
}

std::map<std::string, std::string> flat(const Case& problem) {
  std::map<std::string, std::string> values;
  flatten(problem.to_input(), "", values);
  return values;
}

std::string value_in(const std::map<std::string, std::string>& values, const std::string& key) {
  const auto found = values.find(key);
  return found == values.end() ? "not given" : found->second;
}

std::string text_of(const FoundState& state, const char* key) {
  const auto found = state.table.find(key);
  const std::string* const text = found == state.table.end() ? nullptr : std::get_if<std::string>(&found->second);
  if (text == nullptr) throw InputError("\"{}\" is damaged: it has no \"{}\"", state.path.string(), key);
  return *text;
}

/// Whether a run of its own may have another value of a key than the state that it starts from.
bool may_change(const std::string& key) {
  static const std::regex allowed(
      R"((title|source|gravity|gravity_times|gravity_factors|(time|output|probe|boundary)(\..*)?|)"
      R"(solver\.(damping|flip|friction|contact_stiffness|fmpm_order|mass_cutoff|mass_cutoff_relative|beta|gamma|soft_stiffness|)"
      R"(surface_penalty|increment_tolerance|increment_absolute|residual_tolerance|residual_absolute|iterations_max|step_cuts_max|halving|)"
      R"(linear_solver|linear_tolerance)|body\.[^.]*\.material\..*))");
  static const std::regex refused(R"(body\.[^.]*\.material\.(type|density))");
  return std::regex_match(key, allowed) && !std::regex_match(key, refused);
}

}  // namespace

std::optional<FoundState> newest_state(const std::filesystem::path& folder, std::vector<std::string>& complaints) {
  std::vector<std::filesystem::path> all = checkpoints_of(folder);
  for (auto path = all.rbegin(); path != all.rend(); ++path) {
    try {
      return FoundState{*path, read_state(*path)};
    } catch (const InputError& error) {
      complaints.push_back(error.what());
    }
  }
  return std::nullopt;
}

FoundState find_state(const std::filesystem::path& path) {
  if (!std::filesystem::is_directory(path)) return {path, read_state(path)};
  std::vector<std::string> complaints;
  if (std::optional<FoundState> found = newest_state(path, complaints)) return std::move(*found);
  if (!complaints.empty()) throw InputError("{}", complaints.front());
  throw InputError("\"{}\" has no checkpoint; output.checkpoint_steps, checkpoint_time or checkpoint_wall of a case make some",
                   path.string());
}

SavedCase saved_case(const FoundState& state) {
  const std::string functions = text_of(state, "case_functions");
  if (!functions.empty()) {
    throw InputError(
        "\"{}\": its case has functions that no file can hold ({}); go on in Python with the case given again: mp.load(path, case)",
        state.path.string(), functions);
  }
  return {parse_toml(text_of(state, "case"), state.path.string() + ": case"), text_of(state, "case_name")};
}

void check_same_case(const FoundState& state, const Case& problem) {
  std::map<std::string, std::string> before, after = flat(problem);
  flatten(parse_toml(text_of(state, "case"), state.path.string() + ": case"), "", before);
  const auto check = [&](const std::string& key) {
    if (key == "title" || key == "source" || key.starts_with("output.") || key.starts_with("probe.") ||
        value_in(before, key) == value_in(after, key))
      return;
    throw InputError("\"{}\" is the state of another case: {} is {} there and {} here", state.path.string(), key, value_in(before, key),
                     value_in(after, key));
  };
  for (const auto& [key, value] : before) check(key);
  for (const auto& [key, value] : after) check(key);
}

Case case_of(const FoundState& state, const std::vector<std::string>& sets, bool is_new_run) {
  auto [input, name] = saved_case(state);
  const Case saved = Case::from_input(input, name);
  for (const std::string& set : sets) apply_set(input, set);
  Case problem = Case::from_input(input, name);
  const auto before = flat(saved), after = flat(problem);
  const auto check = [&](const std::string& key) {
    if (value_in(before, key) == value_in(after, key)) return;
    if (is_new_run ? may_change(key) : key.starts_with("output.checkpoint_")) return;
    if (is_new_run) {
      throw InputError(
          "{} cannot be changed from {} to {} in a run that starts from a state: what may change is gravity, time, output, probes, "
          "boundaries, parameters of the same law but density, damping, friction, tolerances",
          key, value_in(before, key), value_in(after, key));
    }
    throw InputError("{} cannot be changed from {} to {} in a run that is continued; --from starts a new run from the state", key,
                     value_in(before, key), value_in(after, key));
  };
  for (const auto& [key, value] : before) check(key);
  for (const auto& [key, value] : after) check(key);
  const auto keeps = [](const BodySpec& body) { return body.keeps_displacement; };
  if (std::any_of(problem.bodies.begin(), problem.bodies.end(), keeps) && std::none_of(saved.bodies.begin(), saved.bodies.end(), keeps)) {
    throw InputError(
        "output.fields cannot ask for \"displacement\" from \"{}\": the run that wrote it did not remember where particles started",
        state.path.string());
  }
  return problem;
}

}  // namespace matpoint
