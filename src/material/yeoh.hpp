#pragma once

#include "material/rubber.hpp"

namespace matpoint {

/// Yeoh: W_iso = c1 (I1 - 3) + c2 (I1 - 3)^2 + c3 (I1 - 3)^3; the shear modulus at small strains is 2 c1. Source: Yeoh (1993).
struct Yeoh : InvariantRubber<Yeoh> {
  static constexpr auto name = "yeoh";
  static constexpr auto summary = "Compressible Yeoh solid, for filled rubber that stiffens (Yeoh 1993).";

  Real c1 = 0;  ///< [Pa]
  Real c2 = 0;  ///< [Pa]
  Real c3 = 0;  ///< [Pa]

  static void declare(ParameterTable<Yeoh>& table) {
    declare_volume(table);
    table.required("c1", "Pa", &Yeoh::c1, positive(), "Factor of I1 - 3; half the shear modulus.");
    table.optional("c2", "Pa", &Yeoh::c2, Constraint{"above -sqrt(3 c1 c3)", [](Real x) { return std::isfinite(x); }},
                   "Factor of (I1 - 3)^2; mostly negative: it softens first.");
    table.optional("c3", "Pa", &Yeoh::c3, non_negative(), "Factor of (I1 - 3)^3: it stiffens at great stretches.");
  }
  void check(const Input& input, const ReadContext& context) const {
    // W1 = c1 + 2 c2 y + 3 c3 y^2 > 0 for y >= 0
    if (c2 < 0 && !(c2 * c2 < 3 * c1 * c3)) {
      fail_input(input, context,
                 fmt::format("c2 = {}: beyond some stretch this rubber would pull itself apart; allowed: c2 > -sqrt(3 c1 c3) = {}", c2,
                             -std::sqrt(3 * c1 * c3)));
    }
  }
  template <class T>
  Slopes<T> slopes(const T& I1) const {
    const T y = T(I1 - 3.0);
    return {T(T(c1) + y * T(T(2 * c2) + (3 * c3) * y)), 0, T(abs(T(T(2 * c2) + (6 * c3) * y)))};
  }
  template <class T>
  T shear_energy(const T& I1, const T& /*I2*/) const {
    const T y = T(I1 - 3.0);
    return T(y * T(T(c1) + y * T(T(c2) + c3 * y)));
  }
};

}  // namespace matpoint
