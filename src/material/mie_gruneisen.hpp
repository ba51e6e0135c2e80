#pragma once

#include "material/equation_of_state.hpp"

namespace matpoint {

/// Solids under shocks, without strength: with eta = 1 - J, p = p_H (1 - G0 eta/2) + G0 u, p_H = rho0 c0^2 eta/(1 - s eta)^2 the pressure
/// behind a shock of the speed Us = c0 + s up; stretched, p = rho0 c0^2 eta + G0 u. The line ends where s eta = 0.9.
/// Source: Zel'dovich & Raizer (1966), ch. XI.
struct MieGruneisen : EquationOfState<MieGruneisen> {
  static constexpr auto name = "mie_gruneisen";
  static constexpr auto summary =
      "Mie-Grueneisen equation of state with a linear shock speed: solids under shocks (Zel'dovich & Raizer 1966).";

  Real sound_speed = 0;  ///< c0 [m/s]
  Real slope = 0;        ///< s [1]
  Real gruneisen = 0;    ///< G0 [1]

  static void declare(ParameterTable<MieGruneisen>& table) {
    declare_shocks(table);
    declare_spall(table);
    table.required("sound_speed", "m/s", &MieGruneisen::sound_speed, positive(), "c0 of the shock's speed Us = c0 + s up.");
    table.required("slope", "1", &MieGruneisen::slope, non_negative(), "s of the shock's speed.");
    table.required("gruneisen", "1", &MieGruneisen::gruneisen, non_negative(), "Grueneisen's number at rest.");
  }
  Real start_energy() const { return 0; }
  template <class T>
  PressureLine<T> line(const T& J) const {
    const Real stiffness = density * sound_speed * sound_speed;
    const T eta = T(T(1.0) - J);
    const auto is_pressed = eta > T(0.0);
    const T pressed = slope > 0 ? T(min(T(max(T(0.0), eta)), T(0.9 / slope))) : T(max(T(0.0), eta));
    const T left = T(T(1.0) / T(T(1.0) - slope * pressed));
    const T p_H = T(stiffness * pressed * left * left);
    const T p_H_slope = T(stiffness * T(T(1.0) + slope * pressed) * left * left * left);
    const T factor = T(T(1.0) - (0.5 * gruneisen) * pressed);
    return {select(is_pressed, T(p_H * factor), T(stiffness * eta)), T(gruneisen),
            select(is_pressed, T((0.5 * gruneisen) * p_H - p_H_slope * factor), T(-stiffness)), T(0.0)};
  }
};

}  // namespace matpoint
