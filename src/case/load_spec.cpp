#include "case/load_spec.hpp"

#include <cmath>

#include "case/case_reading.hpp"

namespace matpoint {
namespace {

std::optional<Input> unless_empty(const std::vector<Real>& values, int dim) {
  if (values.empty()) return std::nullopt;
  return write_value(values, dim);
}

/// A vector that one kind of load needs.
void declare_vector(ParameterTable<LoadSpec>& table, const std::string& name, const std::string& unit, std::vector<Real> LoadSpec::*member,
                    const std::string& help) {
  table.custom(
      {name, unit, "dim numbers", "", "", help, false},
      [=](LoadSpec& load, const Input& input, const ReadContext& context) { read_value(input, context, name, any_number(), load.*member); },
      [=](const LoadSpec& load, int dim) { return unless_empty(load.*member, dim); });
}

}  // namespace

void LoadSpec::declare(ParameterTable<LoadSpec>& table) {
  table.custom(
      {"name", "1", "string", "load_1, load_2, ...", "no dot, comma or quote", "Names the load in results.", false},
      [](LoadSpec& load, const Input& input, const ReadContext& context) {
        read_value(input, context, "name", any_number(), load.name);
        if (load.name.empty() || load.name.find_first_of(".,\n\"") != std::string::npos)
          fail_input(input, context,
                     fmt::format("name = \"{}\" names columns of the history, so it needs letters, and no dot, comma or quote", load.name));
      },
      [](const LoadSpec& load, int) -> std::optional<Input> {
        if (load.name.empty()) return std::nullopt;
        return Input::string(load.name);
      });
  table.required("body", "1", &LoadSpec::body, any_number(), "The body of particles that it acts on.");
  table.choice(
      "kind", &LoadSpec::kind, {{"pressure", LoadKind::pressure}, {"traction", LoadKind::traction}, {"force", LoadKind::force}},
      "pressure: across the surface as it is now, towards the body; traction: per undeformed area of the surface, in one direction; "
      "force: so much in all, spread over particles by their mass, or over a side by its area.",
      true);
  table.custom(
      {"pressure", "Pa", "number", "", "", "For kind = \"pressure\"; positive pushes.", false},
      [](LoadSpec& load, const Input& input, const ReadContext& context) {
        read_value(input, context, "pressure", any_number(), load.pressure);
      },
      [](const LoadSpec& load, int) -> std::optional<Input> {
        if (load.kind != LoadKind::pressure) return std::nullopt;
        return Input::real(load.pressure);
      });
  declare_vector(table, "traction", "Pa", &LoadSpec::traction, "For kind = \"traction\".");
  declare_vector(table, "force", "N", &LoadSpec::force,
                 "For kind = \"force\"; per metre of thickness in 2D, of the full ring around an axis.");
  table.custom(
      {"side", "1", "string", "all of the surface", "\"left\", \"right\" (x), \"bottom\", \"top\" (y), \"front\", \"back\" (z, 3D)",
       "Where the body's surface looks that way at the start.", false},
      [](LoadSpec& load, const Input& input, const ReadContext& context) { read_value(input, context, "side", any_number(), load.side); },
      [](const LoadSpec& load, int) -> std::optional<Input> {
        if (load.side.empty()) return std::nullopt;
        return Input::string(load.side);
      });
  typed(
      table, "region", &LoadSpec::region, region_registry,
      "Where it acts: faces of the surface, or particles of kind = \"force\", whose middles are in it at the start; without it everywhere.",
      false);
  table.custom(
      {"times", "s", "array of numbers", "", "ascending", "Times of a table of factors: linear between, constant before and after.", false},
      [](LoadSpec& load, const Input& input, const ReadContext& context) { read_value(input, context, "times", any_number(), load.times); },
      [](const LoadSpec& load, int dim) { return unless_empty(load.times, dim); });
  table.custom(
      {"factors", "1", "array of numbers", "", "as many as times", "Factors of the load in the course of time.", false},
      [](LoadSpec& load, const Input& input, const ReadContext& context) {
        read_value(input, context, "factors", any_number(), load.factors);
      },
      [](const LoadSpec& load, int dim) { return unless_empty(load.factors, dim); });
}

void check_load(LoadSpec& load, const Input& input, const ReadContext& context) {
  const std::vector<std::pair<LoadKind, std::string>> kinds = {
      {LoadKind::pressure, "pressure"}, {LoadKind::traction, "traction"}, {LoadKind::force, "force"}};
  for (const auto& [kind, key] : kinds) {
    if (load.kind != kind) {
      if (is_given(input, key)) fail_input(at_key(input, key), context, fmt::format("{0} is for kind = \"{0}\" only", key));
      continue;
    }
    if (!is_given(input, key)) fail_input(input, context, fmt::format("kind = \"{0}\" needs {0}", key));
    const std::size_t count = kind == LoadKind::traction ? load.traction.size() : load.force.size();
    if (kind != LoadKind::pressure && count != static_cast<std::size_t>(context.dim)) {
      fail_input(at_key(input, key), context,
                 fmt::format("{} has {} numbers; the case has dim = {}, so it must have {}", key, count, context.dim, context.dim));
    }
  }
  if (is_given(input, "side")) check_words({load.side}, "side", side_names(context.dim), input, context);
  if (load.times.size() != load.factors.size()) {
    fail_input(at_key(input, load.times.empty() ? "factors" : "times"), context,
               fmt::format("times has {} entries and factors {}; they must match", load.times.size(), load.factors.size()));
  }
  for (std::size_t k = 1; k < load.times.size(); ++k) {
    if (load.times[k] > load.times[k - 1]) continue;
    fail_input(at_key(input, "times"), context,
               fmt::format("times[{}] = {} must be greater than times[{}] = {}", k, load.times[k], k - 1, load.times[k - 1]));
  }
}

std::vector<std::string> load_names(const std::vector<LoadSpec>& loads) {
  std::vector<std::string> names;
  for (std::size_t k = 0; k < loads.size(); ++k) names.push_back(loads[k].name.empty() ? fmt::format("load_{}", k + 1) : loads[k].name);
  return names;
}

}  // namespace matpoint
