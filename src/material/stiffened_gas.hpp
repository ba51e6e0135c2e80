#pragma once

#include "material/equation_of_state.hpp"

namespace matpoint {

/// p = (gamma - 1) u/J - gamma p_inf: liquids under shocks; water has gamma = 4.4, p_inf = 6e8 Pa. Source: Harlow & Amsden (1971).
struct StiffenedGas : EquationOfState<StiffenedGas> {
  static constexpr auto name = "stiffened_gas";
  static constexpr auto summary = "Stiffened gas: water and other liquids under shocks (Harlow & Amsden 1971).";

  Real gamma = 0;           ///< [1]
  Real stiff_pressure = 0;  ///< p_inf [Pa]
  Real pressure = 0;        ///< p0 [Pa]

  static void declare(ParameterTable<StiffenedGas>& table) {
    declare_shocks(table);
    declare_spall(table);
    table.required("gamma", "1", &StiffenedGas::gamma, Constraint{"in the interval (1, 10]", [](Real x) { return x > 1 && x <= 10; }},
                   "4.4 for water.");
    table.required("stiff_pressure", "Pa", &StiffenedGas::stiff_pressure, non_negative(), "p_inf; 6e8 for water.");
    table.optional("pressure", "Pa", &StiffenedGas::pressure, non_negative(), "At the start.");
  }
  void check(const Input& input, const ReadContext& context) const {
    if (stiff_pressure == 0 && pressure == 0) fail_input(input, context, "stiff_pressure and pressure are both 0: nothing would resist");
  }
  Real start_energy() const { return (pressure + gamma * stiff_pressure) / (gamma - 1); }
  template <class T>
  PressureLine<T> line(const T& J) const {
    const T B = T(T(gamma - 1) / J);
    return {T(-gamma * stiff_pressure), B, T(0.0), T(-B / J)};
  }
};

}  // namespace matpoint
