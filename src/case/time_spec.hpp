// The section [time] of a case.
#pragma once

#include <memory>
#include <optional>

#include "case/step_rule.hpp"
#include "core/parameters.hpp"

namespace matpoint {

struct TimeSpec {
  Real end = 0;
  std::optional<Real> dt;
  Real cfl = 0.4;
  std::optional<Real> dt_max;
  Real dt_min = 0;
  int step_cuts_max = 8;
  std::shared_ptr<StepRule> rule;  ///< Of an implicit run without dt.
  static void declare(ParameterTable<TimeSpec>& table);
};

/// What goes beyond single values. Throws InputError.
void check_time(TimeSpec& time, const Input& input, const ReadContext& context);

}  // namespace matpoint
