#pragma once

#include "material/rubber.hpp"

namespace matpoint {

/// Gent: W_iso = -mu/2 Jm ln(1 - (I1 - 3)/Jm): chains that can be stretched so far and no further. Beyond 0.999 of that it goes on with a
/// straight line, so that one bad step is not the end. Source: Gent (1996).
struct Gent : InvariantRubber<Gent> {
  static constexpr auto name = "gent";
  static constexpr auto summary = "Compressible Gent solid, for rubber and tissue with a limit of stretch (Gent 1996).";

  Real shear_modulus = 0;  ///< mu [Pa]
  Real Jm = 0;             ///< [1]

  static void declare(ParameterTable<Gent>& table) {
    declare_volume(table);
    table.required("shear_modulus", "Pa", &Gent::shear_modulus, positive(), "At small strains.");
    table.required("Jm", "1", &Gent::Jm, positive(), "The limit of I1 - 3; some 30 to 100 for rubber.");
  }
  template <class T>
  Slopes<T> slopes(const T& I1) const {
    const T left = T(T(1.0) / T(T(1.0) - clipped(I1)));
    return {T(0.5 * shear_modulus * left), 0, T((0.5 * shear_modulus / Jm) * left * left)};
  }
  template <class T>
  T shear_energy(const T& I1, const T& /*I2*/) const {
    const T x = clipped(I1);
    const T beyond = T(T(T(I1 - 3.0) * (1 / Jm)) - x);
    return T(-0.5 * shear_modulus * Jm * T(log(T(T(1.0) - x)) - beyond / T(T(1.0) - x)));
  }

 private:
  template <class T>
  T clipped(const T& I1) const {
    return T(min(T(T(I1 - 3.0) * (1 / Jm)), T(0.999)));
  }
};

}  // namespace matpoint
