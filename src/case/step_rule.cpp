#include "case/step_rule.hpp"

#include <algorithm>

#include "core/interpolate.hpp"

namespace matpoint {
namespace {

void check_table(const std::vector<Real>& places, const char* places_name, const std::vector<Real>& steps, const Input& input,
                 const ReadContext& context) {
  if (places.empty() || places.size() != steps.size()) {
    fail_input(*input.find("steps"), context,
               fmt::format("{} has {} numbers and steps {}; they must match", places_name, places.size(), steps.size()));
  }
  for (std::size_t k = 1; k < places.size(); ++k) {
    if (places[k] > places[k - 1]) continue;
    fail_input(*input.find(places_name), context,
               fmt::format("{0}[{1}] = {2} must be greater than {0}[{3}] = {4}", places_name, k, places[k], k - 1, places[k - 1]));
  }
}

struct TableRule final : StepRule {
  static constexpr auto name = "table";
  static constexpr auto summary = "The time step as a function of time: linear between the entries, constant before and after.";

  std::vector<Real> times;
  std::vector<Real> steps;

  static void declare(ParameterTable<TableRule>& table) {
    table.required("times", "s", &TableRule::times, non_negative(), "Ascending.");
    table.required("steps", "s", &TableRule::steps, positive(), "The step at each time.");
  }
  Real dt(const StepState& state) const override { return interpolated(times, steps, state.time); }
  Input write(int dim) const override { return write_typed(*this, dim); }
  void check(const Input& input, const ReadContext& context) const override { check_table(times, "times", steps, input, context); }
};

struct DistanceRule final : StepRule {
  static constexpr auto name = "distance";
  static constexpr auto summary =
      "The time step from how far the foremost particle has come: short near a wall, long far from it. Constant beyond the positions.";

  std::string toward = "bottom";
  std::vector<Real> positions;
  std::vector<Real> steps;
  std::string interpolation = "linear";

  static void declare(ParameterTable<DistanceRule>& table) {
    table.optional("toward", "1", &DistanceRule::toward, any_number(),
                   "The side that the particle nearest to it is taken of: left, right, bottom, top, front or back.");
    table.required("positions", "m", &DistanceRule::positions, any_number(), "Ascending coordinates of that particle, across the side.");
    table.required("steps", "s", &DistanceRule::steps, positive(), "The step at each position.");
    table.optional("interpolation", "1", &DistanceRule::interpolation, any_number(),
                   "\"linear\" between the positions, or \"quadratic\": the parabola through three of them.");
  }
  Real dt(const StepState& state) const override {
    const std::size_t side = side_number();
    const Real x = side % 2 == 0 ? state.lower[side / 2] : state.upper[side / 2];
    if (interpolation == "linear" || x <= positions.front() || x >= positions.back()) return interpolated(positions, steps, x);
    Real sum = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      Real weight = 1;
      for (std::size_t j = 0; j < 3; ++j) {
        if (j != i) weight *= (x - positions[j]) / (positions[i] - positions[j]);
      }
      sum += weight * steps[i];
    }
    return sum;
  }
  Input write(int dim) const override { return write_typed(*this, dim); }
  void check(const Input& input, const ReadContext& context) const override {
    const std::vector<std::string>& names = sides();
    const std::size_t allowed = context.dim == 2 ? 4 : 6;
    if (side_number() >= allowed) {
      const std::vector<std::string> known(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(allowed));
      fail_input(*input.find("toward"), context,
                 fmt::format("toward = \"{}\" is unknown, allowed: {}{}", toward, list_names(known), did_you_mean(toward, known)));
    }
    check_table(positions, "positions", steps, input, context);
    if (interpolation != "linear" && interpolation != "quadratic") {
      fail_input(*input.find("interpolation"), context,
                 fmt::format("interpolation = \"{}\" is unknown, allowed: \"linear\" or \"quadratic\"", interpolation));
    }
    if (interpolation == "quadratic" && positions.size() != 3) {
      fail_input(*input.find("positions"), context,
                 fmt::format("interpolation = \"quadratic\" needs 3 positions, positions has {}", positions.size()));
    }
    if (interpolation == "quadratic") {
      // A parabola through three positive numbers may dip below zero between them.
      StepState state;
      for (int k = 0; k <= 200; ++k) {
        const Real x = positions[0] + (positions[2] - positions[0]) * k / 200;
        state.lower = state.upper = {x, x, x};
        if (dt(state) > 0) continue;
        fail_input(*input.find("steps"), context,
                   fmt::format("the parabola through steps is {:.4g} s at {:.4g} m; it must be > 0", dt(state), x));
      }
    }
  }

 private:
  static const std::vector<std::string>& sides() {
    static const std::vector<std::string> names = {"left", "right", "bottom", "top", "front", "back"};
    return names;
  }
  std::size_t side_number() const { return static_cast<std::size_t>(std::find(sides().begin(), sides().end(), toward) - sides().begin()); }
};

struct NewtonCountRule final : StepRule {
  static constexpr auto name = "newton_count";
  static constexpr auto summary = "The time step grows while Newton's method converges fast and shrinks when it needs many iterations.";

  Real first = 0;
  Real smallest = 0;
  Real largest = 0;
  int few = 4;
  int many = 8;
  Real growth = 1.5;

  static void declare(ParameterTable<NewtonCountRule>& table) {
    table.required("first", "s", &NewtonCountRule::first, positive(), "The first step.");
    table.required("smallest", "s", &NewtonCountRule::smallest, positive(), "No step is shorter.");
    table.required("largest", "s", &NewtonCountRule::largest, positive(), "No step is longer.");
    table.optional("few", "1", &NewtonCountRule::few, at_least(1), "Up to so many iterations, the next step is `growth` times as long.");
    table.optional("many", "1", &NewtonCountRule::many, at_least(2), "From so many iterations on, the next step is shorter by `growth`.");
    table.optional("growth", "1", &NewtonCountRule::growth, Constraint{"> 1 and <= 10", [](Real x) { return x > 1 && x <= 10; }},
                   "Factor from one step to the next.");
  }
  Real dt(const StepState& state) const override {
    if (state.last_dt == 0) return first;
    Real next = state.last_dt;
    if (state.step_cuts > 0 || state.newton_iterations >= many)
      next /= growth;
    else if (state.newton_iterations <= few)
      next *= growth;
    return std::clamp(next, smallest, largest);
  }
  Input write(int dim) const override { return write_typed(*this, dim); }
  void check(const Input& input, const ReadContext& context) const override {
    if (!(smallest <= first && first <= largest)) {
      fail_input(*input.find("first"), context,
                 fmt::format("first = {} must lie between smallest = {} and largest = {}", first, smallest, largest));
    }
    if (few >= many) fail_input(input, context, fmt::format("few = {} must be below many = {}", few, many));
  }
};

}  // namespace

const TypeRegistry<StepRule>& step_rule_registry() {
  static const TypeRegistry<StepRule> registry = [] {
    TypeRegistry<StepRule> all;
    all.add<TableRule>();
    all.add<DistanceRule>();
    all.add<NewtonCountRule>();
    return all;
  }();
  return registry;
}

}  // namespace matpoint
