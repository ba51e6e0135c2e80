#pragma once

#include "material/equation_of_state.hpp"

namespace matpoint {

/// The products of an explosive: p = A (1 - w/(R1 J)) e^(-R1 J) + B (1 - w/(R2 J)) e^(-R2 J) + w u/J, with the energy u0 of the detonation
/// set free at the start, everywhere at once. Source: Lee, Hornig & Kury (1968).
struct Jwl : EquationOfState<Jwl> {
  static constexpr auto name = "jwl";
  static constexpr auto summary = "Jones-Wilkins-Lee equation of state: the products of an explosive (Lee, Hornig & Kury 1968).";

  Real A = 0, B = 0;    ///< [Pa]
  Real R1 = 0, R2 = 0;  ///< [1]
  Real omega = 0;       ///< w [1]
  Real energy = 0;      ///< u0 [J/m^3]

  static void declare(ParameterTable<Jwl>& table) {
    declare_shocks(table);
    table.required("A", "Pa", &Jwl::A, non_negative(), "Of the first term.");
    table.required("B", "Pa", &Jwl::B, non_negative(), "Of the second term.");
    table.required("R1", "1", &Jwl::R1, positive(), "Of the first term.");
    table.required("R2", "1", &Jwl::R2, positive(), "Of the second term.");
    table.required("omega", "1", &Jwl::omega, positive(), "Of the third term, which is left when the products have expanded.");
    table.required("energy", "J/m^3", &Jwl::energy, positive(), "Energy of the detonation per reference volume.");
  }
  Real start_energy() const { return energy; }
  template <class T>
  PressureLine<T> line(const T& J) const {
    const T inverse = T(T(1.0) / J);
    T p = T(0.0), p_slope = T(0.0);
    for (const auto& [factor, R] : {std::pair(A, R1), std::pair(B, R2)}) {
      const T fall = T(factor * exp(T(-R * J)));
      const T share = T(T(1.0) - (omega / R) * inverse);
      p = T(p + fall * share);
      p_slope = T(p_slope + fall * T((omega / R) * inverse * inverse - R * share));
    }
    const T third = T(omega * inverse);
    return {p, third, p_slope, T(-third * inverse)};
  }
};

}  // namespace matpoint
