// `matpoint list` and `matpoint explain`: everything they say comes from the declarations that also read the case files.
#include <algorithm>
#include <array>
#include <functional>

#include "body/particle_fields.hpp"
#include "case/case_file.hpp"
#include "commands.hpp"
#include "io/results_folder.hpp"
#include "material/parameter_sets.hpp"

namespace matpoint {
namespace {

/// Something that case files name, with its parameters.
struct Topic {
  std::string kind;
  std::string name;
  std::string summary;
  std::vector<ParameterDescription> parameters;
};

template <class Base>
void append(std::vector<Topic>& topics, const std::string& kind, const TypeRegistry<Base>& registry) {
  for (const auto& entry : registry.entries()) topics.push_back({kind, entry.name, entry.summary, entry.parameters});
}

std::vector<Topic> all_topics() {
  std::vector<Topic> topics;
  for (const CaseSection& section : case_sections()) topics.push_back({"section", section.name, section.summary, section.parameters});
  append(topics, "material", material_registry());
  for (const ParameterSet& set : parameter_sets()) topics.push_back({"parameter set", set.name, set.summary, {}});
  append(topics, "region", region_registry());
  append(topics, "layout", layout_registry());
  append(topics, "velocity", velocity_registry());
  append(topics, "initial_stress", initial_stress_registry());
  append(topics, "rule", step_rule_registry());
  return topics;
}

std::string allowed_text(const ParameterDescription& parameter) { return parameter.allowed.empty() ? "any" : parameter.allowed; }

std::string default_text(const ParameterDescription& parameter) {
  if (parameter.is_required) return "required";
  return parameter.default_text.empty() ? "none" : parameter.default_text;
}

/// Columns as wide as their longest entry; the help on a line of its own, because it is prose.
void print_parameters(const std::vector<ParameterDescription>& parameters) {
  std::vector<std::array<std::string, 5>> rows = {{"parameter", "type", "unit", "default", "allowed"}};
  for (const ParameterDescription& p : parameters) rows.push_back({p.name, p.type, p.unit, default_text(p), allowed_text(p)});
  std::array<std::size_t, 4> widths{};
  for (const auto& row : rows) {
    for (std::size_t c = 0; c < widths.size(); ++c) widths[c] = std::max(widths[c], row[c].size());
  }
  for (std::size_t r = 0; r < rows.size(); ++r) {
    fmt::print("  ");
    for (std::size_t c = 0; c < widths.size(); ++c) fmt::print("{:{}s}  ", rows[r][c], widths[c]);
    fmt::print("{}\n", rows[r][4]);
    if (r > 0) fmt::print("      {}\n", parameters[r - 1].help);
  }
}

void print_topic(const Topic& topic) {
  fmt::print("{} \"{}\": {}\n", topic.kind, topic.name, topic.summary);
  for (const ParameterSet& set : parameter_sets()) {
    if (topic.kind != "parameter set" || set.name != topic.name) continue;
    for (const auto& [key, value] : set.table.entries()) fmt::print("  {} = {}\n", key, value.text());
    return;
  }
  if (topic.parameters.empty()) {
    fmt::print("  no parameters\n");
  } else {
    print_parameters(topic.parameters);
  }
}

void print_case(const std::string& name, const std::string& text) {
  const Case problem = load_case(name);
  fmt::print("case \"{}\": {}\n", name, problem.title);
  if (!problem.source.empty()) fmt::print("  source: {}\n", problem.source);
  fmt::print("  run it with `matpoint run {0}`, look at its sizes with `matpoint check {0}`; its text:\n\n{1}", name, text);
  if (!text.empty() && text.back() != '\n') fmt::print("\n");
}

/// Every parameter called `name`, or `<topic>.<parameter>`, with the topic that it belongs to.
bool print_single_parameters(const std::vector<Topic>& topics, const std::string& name) {
  const std::size_t dot = name.rfind('.');
  const std::string owner = dot == std::string::npos ? "" : name.substr(0, dot);
  const std::string key = dot == std::string::npos ? name : name.substr(dot + 1);
  bool is_found = false;
  for (const Topic& topic : topics) {
    if (!owner.empty() && owner != topic.name) continue;
    for (const ParameterDescription& parameter : topic.parameters) {
      if (parameter.name != key) continue;
      if (is_found) fmt::print("\n");
      fmt::print("parameter of {} \"{}\":\n", topic.kind, topic.name);
      print_parameters({parameter});
      is_found = true;
    }
  }
  return is_found;
}

void list_topics(const std::string& title, const std::string& kind) {
  fmt::print("{}:\n", title);
  const std::vector<Topic> topics = all_topics();
  std::size_t width = 0;
  for (const Topic& topic : topics) width = std::max(width, topic.kind == kind ? topic.name.size() : 0);
  for (const Topic& topic : topics) {
    if (topic.kind == kind) fmt::print("  {:{}s}  {}\n", topic.name, width, topic.summary);
  }
}

void list_cases() {
  fmt::print("cases:\n");
  std::size_t width = 0;
  for (const auto& [name, text] : shipped_cases()) width = std::max(width, name.size());
  for (const auto& [name, text] : shipped_cases()) {
    // The title alone, without reading the rest: a list must not fail because of one case.
    const Input input = parse_toml(text, name + ".toml");
    const Input* title = input.find("title");
    fmt::print("  {:{}s}  {}\n", name, width, title != nullptr && title->kind() == Input::Kind::string ? title->as_string() : "");
  }
}

void list_fields() {
  std::vector<std::string> always, on_request = {"displacement"};
  for (const std::string& name : particle_field_names()) (is_written_on_request(name) ? on_request : always).push_back(name);
  fmt::print("fields:\n  {}\n", fmt::join(always, "\n  "));
  fmt::print("fields on request, where output.fields names them:\n  {}\n", fmt::join(on_request, "\n  "));
  fmt::print("fields of single materials:\n");
  std::size_t width = 0;
  for (const auto& [name, laws] : material_variables()) width = std::max(width, name.size());
  for (const auto& [name, laws] : material_variables()) fmt::print("  {:{}s}  {}\n", name, width, fmt::join(laws, ", "));
}

}  // namespace

int list_command(const std::string& what) {
  struct List {
    std::string name;
    std::function<void()> print;
  };
  const std::vector<List> lists = {{"cases", list_cases},
                                   {"materials", [] { list_topics("materials", "material"); }},
                                   {"parameter_sets", [] { list_topics("parameter sets of materials", "parameter set"); }},
                                   {"regions", [] { list_topics("regions", "region"); }},
                                   {"layouts", [] { list_topics("layouts", "layout"); }},
                                   {"velocities", [] { list_topics("velocities", "velocity"); }},
                                   {"initial_stresses", [] { list_topics("initial stresses", "initial_stress"); }},
                                   {"rules", [] { list_topics("rules for the time step of the implicit solver", "rule"); }},
                                   {"sections", [] { list_topics("sections of a case file", "section"); }},
                                   {"fields", list_fields}};
  std::vector<std::string> names;
  for (const List& list : lists) names.push_back(list.name);
  if (!what.empty() && std::find(names.begin(), names.end(), what) == names.end()) {
    throw InputError("there is no list of \"{}\", allowed: {}{}", what, list_names(names), did_you_mean(what, names));
  }
  for (const List& list : lists) {
    if (what.empty() || what == list.name) {
      list.print();
      if (what.empty()) fmt::print("\n");
    }
  }
  if (what.empty()) fmt::print("`matpoint explain NAME` says more about each.\n");
  return k_exit_done;
}

int explain_command(const std::string& name) {
  const std::vector<Topic> topics = all_topics();
  bool is_found = false;
  for (const Topic& topic : topics) {
    if (topic.name != name) continue;
    if (is_found) fmt::print("\n");
    print_topic(topic);
    is_found = true;
  }
  if (!is_found) is_found = print_single_parameters(topics, name);
  if (const auto shipped = shipped_cases().find(name); shipped != shipped_cases().end()) {
    if (is_found) fmt::print("\n");
    print_case(shipped->first, shipped->second);
    is_found = true;
  }
  if (is_found) return k_exit_done;

  std::vector<std::string> names;
  for (const Topic& topic : topics) names.push_back(topic.name);
  for (const auto& [shipped, text] : shipped_cases()) names.push_back(shipped);
  for (const Topic& topic : topics) {
    for (const ParameterDescription& parameter : topic.parameters) {
      names.push_back(parameter.name);
      names.push_back(topic.name + "." + parameter.name);
    }
  }
  throw InputError("nothing is called \"{}\"{} (`matpoint list` names materials, regions, layouts, cases, ...)", name,
                   did_you_mean(name, names));
}

}  // namespace matpoint
