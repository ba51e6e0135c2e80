#include "case/time_spec.hpp"

#include <cmath>

#include "case/case_reading.hpp"

namespace matpoint {

void check_time(TimeSpec& time, const Input& input, const ReadContext& context) {
  if (time.rule && time.dt) fail_input(at_key(input, "rule"), context, "dt and rule are both given; give one of them");
  if (time.dt) {
    for (const char* key : {"cfl", "dt_max", "dt_min"}) {
      if (is_given(input, key)) {
        fail_input(at_key(input, key), context,
                   fmt::format("{} is for automatic time steps, but dt = {} fixes them; leave one out", key, *time.dt));
      }
    }
    if (time.end / *time.dt < 0.5) {
      fail_input(at_key(input, "dt"), context,
                 fmt::format("dt = {} is longer than the whole run (end = {}): no step would be done", *time.dt, time.end));
    }
  }
  constexpr Real k_steps_max = 1e15;  // near 2^53 a sum of steps would stand still
  const Real longest = time.dt.value_or(time.dt_max.value_or(time.end));
  if (time.end / longest > k_steps_max) {
    const char* key = time.dt ? "dt" : "dt_max";
    fail_input(at_key(input, key), context,
               fmt::format("{} = {} makes {:.3g} steps to end = {}, at most {:.0g} are possible", key, longest, time.end / longest,
                           time.end, k_steps_max));
  }
  if (time.dt_max && *time.dt_max < time.dt_min) {
    fail_input(at_key(input, "dt_max"), context, fmt::format("dt_max = {} is below dt_min = {}", *time.dt_max, time.dt_min));
  }
}

void TimeSpec::declare(ParameterTable<TimeSpec>& table) {
  table.required("end", "s", &TimeSpec::end, positive(), "The run ends at this time.");
  table.optional("dt", "s", &TimeSpec::dt, positive(), "Fixed time step; without it steps are automatic.");
  const auto automatic = [&table](const std::string& name, const std::string& unit, auto member, Constraint constraint,
                                  const std::string& default_text, const std::string& help) {
    table.custom(
        {name, unit, "number", default_text, constraint.text, help, false},
        [=](TimeSpec& time, const Input& input, const ReadContext& context) { read_value(input, context, name, constraint, time.*member); },
        [=](const TimeSpec& time, int) -> std::optional<Input> {
          if (time.dt || time.rule) return std::nullopt;
          if constexpr (std::is_same_v<decltype(member), Real TimeSpec::*>)
            return Input::real(time.*member);
          else
            return time.*member ? std::optional(Input::real(*(time.*member))) : std::nullopt;
        });
  };
  automatic("cfl", "1", &TimeSpec::cfl, Constraint{"in the interval (0, 1]", [](Real x) { return x > 0 && x <= 1; }}, "0.4",
            "Share of the stable time step that an automatic step takes.");
  automatic("dt_max", "s", &TimeSpec::dt_max, positive(), "", "Longest automatic step.");
  automatic("dt_min", "s", &TimeSpec::dt_min, non_negative(), "0", "The run fails when an automatic step would be shorter.");
  table.optional(
      "step_cuts_max", "1", &TimeSpec::step_cuts_max, between_closed(0, 30),
      "Explicit solver with automatic steps: a step that fails is taken again half as long, and so often at most; 0: no state is "
      "kept to go back to.");
  typed(table, "rule", &TimeSpec::rule, step_rule_registry, "Implicit solver without dt: how long the next step is.", false);
}

}  // namespace matpoint
