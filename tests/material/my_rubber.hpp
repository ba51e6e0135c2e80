#pragma once

#include "material/law.hpp"

namespace matpoint {

/// Compressible Mooney-Rivlin solid: W = c1 (I1 - 3) + c2 (I2 - 3) + K/4 (J^2 - 1 - 2 ln J) with the invariants of J^(-2/3) b, b = F F^T,
/// I1 = J^(-2/3) tr b, I2 = J^(-4/3) ((tr b)^2 - b : b)/2;
/// tau = 2 c1 J^(-2/3) dev b + 2 c2 J^(-4/3) dev(tr(b) b - b b) + K/2 (J^2 - 1) I.
/// Source: Holzapfel (2000), sec. 6.4 and 6.5. Rubber; the shear modulus at small strains is 2 (c1 + c2).
struct MyRubber {
  static constexpr auto name = "my_rubber";
  static constexpr auto summary = "Compressible Mooney-Rivlin solid, the example of a law.";

  Real density = 0;       ///< [kg/m^3]
  Real c1 = 0;            ///< [Pa]
  Real c2 = 0;            ///< [Pa]
  Real bulk_modulus = 0;  ///< K [Pa]

  static void declare(ParameterTable<MyRubber>& table) {
    table.required("density", "kg/m^3", &MyRubber::density, positive(), "Mass per reference volume.");
    table.required("c1", "Pa", &MyRubber::c1, positive(), "Factor of the first invariant.");
    table.optional("c2", "Pa", &MyRubber::c2, non_negative(), "Factor of the second invariant; 0 for a Neo-Hookean solid.");
    table.required("bulk_modulus", "Pa", &MyRubber::bulk_modulus, positive(), "Bulk modulus at small strains.");
  }

  template <class M>
  M kirchhoff_stress(const M& F) const {
    using T = typename M::Scalar;
    const M b = F * transpose(F);
    const T J = determinant(F);
    const T factor1 = T(2 * c1 * power(J, -2.0 / 3));
    const T factor2 = T(2 * c2 * power(J, -4.0 / 3));
    const T volumetric = T(0.5 * bulk_modulus * (J * J - 1.0));
    return scaled(factor1, deviator(b)) + scaled(factor2, deviator(scaled(trace(b), b) - b * b)) + M::diagonal(volumetric);
  }

  template <class M>
  typename M::Scalar energy_density(const M& F) const {
    using T = typename M::Scalar;
    const M b = F * transpose(F);
    const T J = determinant(F);
    const T I1 = T(power(J, -2.0 / 3) * trace(b));
    const T I2 = T(power(J, -4.0 / 3) * 0.5 * (trace(b) * trace(b) - contract(b, b)));
    return T(c1 * (I1 - 3.0) + c2 * (I2 - 3.0) + 0.25 * bulk_modulus * (J * J - 1.0 - 2.0 * log(J)));
  }

  /// Of plane waves along a uniaxial stretch J: c^2 = J^2 dP/dJ / rho0 with
  /// P = 4/3 [c1 (J^(1/3) - J^(-5/3)) + c2 (J^(-1/3) - J^(-7/3))] + K/2 (J - 1/J).
  Real wave_speed(Real J) const {
    const Real slope1 = c1 * (std::pow(J, -2.0 / 3) + 5 * std::pow(J, -8.0 / 3));
    const Real slope2 = c2 * (7 * std::pow(J, -10.0 / 3) - std::pow(J, -4.0 / 3));
    return J * std::sqrt((4.0 / 9 * (slope1 + slope2) + 0.5 * bulk_modulus * (1 + 1 / (J * J))) / density);
  }
};

}  // namespace matpoint
