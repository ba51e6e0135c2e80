// How long the next step of an implicit run is: rules that a case can name.
#pragma once

#include <memory>

#include "core/parameters.hpp"

namespace matpoint {

/// What a rule may look at.
struct StepState {
  Real time = 0;     ///< At the start of the step [s].
  Real last_dt = 0;  ///< 0 before the first step [s].
  Vec3 lower{};      ///< Extent of the particles [m].
  Vec3 upper{};
  int newton_iterations = 0;  ///< Of the last step.
  int step_cuts = 0;          ///< How often the last step was halved because Newton's method failed.
};

class StepRule {
 public:
  virtual ~StepRule() = default;
  /// The step from this state [s].
  virtual Real dt(const StepState& state) const = 0;
  virtual Input write(int dim) const = 0;
  virtual void check(const Input&, const ReadContext&) const {}
};

/// table, distance, newton_count.
const TypeRegistry<StepRule>& step_rule_registry();

}  // namespace matpoint
