#pragma once

#include "material/equation_of_state.hpp"

namespace matpoint {

/// p = (gamma - 1) u/J: an ideal gas, at the pressure p0 where it starts. Into a vacuum it expands for ever.
struct IdealGas : EquationOfState<IdealGas> {
  static constexpr auto name = "ideal_gas";
  static constexpr auto summary = "Ideal gas that heats by compression and by shocks (Von Neumann & Richtmyer 1950).";

  Real gamma = 1.4;   ///< [1]
  Real pressure = 0;  ///< p0 [Pa]

  static void declare(ParameterTable<IdealGas>& table) {
    declare_shocks(table);
    table.required("pressure", "Pa", &IdealGas::pressure, positive(), "At the start.");
    table.optional("gamma", "1", &IdealGas::gamma, Constraint{"in the interval (1, 10]", [](Real x) { return x > 1 && x <= 10; }},
                   "Ratio of the heat capacities; 1.4 for air.");
  }
  Real start_energy() const { return pressure / (gamma - 1); }
  template <class T>
  PressureLine<T> line(const T& J) const {
    const T B = T(T(gamma - 1) / J);
    return {T(0.0), B, T(0.0), T(-B / J)};
  }
};

}  // namespace matpoint
