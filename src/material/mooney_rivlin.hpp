#pragma once

#include "material/rubber.hpp"

namespace matpoint {

/// Mooney-Rivlin: W_iso = c1 (I1 - 3) + c2 (I2 - 3); the shear modulus at small strains is 2 (c1 + c2).
/// Sources: Mooney (1940); Rivlin (1948).
struct MooneyRivlin : InvariantRubber<MooneyRivlin> {
  static constexpr auto name = "mooney_rivlin";
  static constexpr auto summary = "Compressible Mooney-Rivlin solid, for rubber to stretches of about 2 (Mooney 1940; Rivlin 1948).";

  Real c1 = 0;  ///< [Pa]
  Real c2 = 0;  ///< [Pa]

  static void declare(ParameterTable<MooneyRivlin>& table) {
    declare_volume(table);
    table.required("c1", "Pa", &MooneyRivlin::c1, positive(), "Factor of the first invariant.");
    table.optional("c2", "Pa", &MooneyRivlin::c2, non_negative(), "Factor of the second invariant; 0 for a neo-Hookean solid.");
  }
  template <class T>
  Slopes<T> slopes(const T& /*I1*/) const {
    return {T(c1), c2};
  }
  template <class T>
  T shear_energy(const T& I1, const T& I2) const {
    return T(c1 * T(I1 - 3.0) + c2 * T(I2 - 3.0));
  }
};

}  // namespace matpoint
