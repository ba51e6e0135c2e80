// What solids for rubber share: an energy of what keeps the volume, and a bulk modulus.
#pragma once

#include "core/dual.hpp"
#include "material/law.hpp"

namespace matpoint {

/// W = W_iso(J^(-2/3) b) + K/4 (J^2 - 1 - 2 ln J): the second part has no end at J = 0, so that nothing turns inside out.
/// Source: Simo & Taylor (1982).
template <class Law>
struct RubberLaw {
  Real density = 0;       ///< [kg/m^3]
  Real bulk_modulus = 0;  ///< K [Pa]

  static void declare_volume(ParameterTable<Law>& table) {
    table.required("density", "kg/m^3", static_cast<Real Law::*>(&Law::density), positive(), "Mass per reference volume.");
    table.required("bulk_modulus", "Pa", static_cast<Real Law::*>(&Law::bulk_modulus), positive(),
                   "Resistance to changes of volume; some 100 times the shear modulus stands for an incompressible rubber.");
  }
  template <class T>
  T volume_stress(const T& J) const {
    return T(0.5 * bulk_modulus * T(J * J - 1.0));
  }
  template <class T>
  T volume_energy(const T& J) const {
    return T(0.25 * bulk_modulus * T(J * J - 1.0 - 2.0 * log(J)));
  }

  /// Of plane waves along a uniaxial stretch J: rho0 c^2 = J^2 dP/dJ, P the first Piola-Kirchhoff stress.
  Real wave_speed(Real J) const {
    using D = Dual<1>;
    auto F = Mat3<D, true>::identity();
    F(0, 0) = D::variable(J, 0);
    const D P = static_cast<const Law&>(*this).kirchhoff_stress(F)(0, 0) / F(0, 0);
    return J * std::sqrt(std::max(P.d[0], Real{0}) / density);
  }
  /// A bound of the greatest principal value of J^(-2/3) b by its trace I1: the two others add at least 2/sqrt(l).
  template <class T>
  static T greatest_square(const T& I1) {
    T l = I1;
    for (int i = 0; i < 4; ++i) l = T(I1 - 2.0 / T(sqrt(l)));
    return l;
  }
  /// What the volume adds to rho0 c^2 [Pa].
  template <class T>
  T volume_modulus(const T& J) const {
    return T(0.5 * bulk_modulus * T(J * J + 1.0));
  }
};

/// Those that know of J^(-2/3) b its invariants I1 and I2: with slopes(I1) = {W1, W2, W11} of W(I1) + W2 I2,
/// tau = 2 (W1 + I1 W2) dev b - 2 W2 dev b^2 + K/2 (J^2 - 1) I. Source: Holzapfel (2000), sec. 6.4 and 6.5.
template <class Law>
struct InvariantRubber : RubberLaw<Law> {
  template <class T>
  struct Slopes {
    T W1;        ///< [Pa]
    Real W2;     ///< [Pa]
    T W11{0.0};  ///< [Pa]
  };

  template <class M>
  M kirchhoff_stress(const M& F) const {
    using T = typename M::Scalar;
    const T J = determinant(F);
    const M b = scaled(T(power(J, -2.0 / 3)), M(F * transpose(F)));
    const T I1 = trace(b);
    const Slopes<T> at = law().slopes(I1);
    M tau = scaled(T(2.0 * at.W1), deviator(b)) + M::diagonal(this->volume_stress(J));
    if (at.W2 != 0) tau = tau + scaled(T(2 * at.W2), deviator(scaled(I1, b) - b * b));
    return tau;
  }
  template <class M>
  typename M::Scalar energy_density(const M& F) const {
    using T = typename M::Scalar;
    const T J = determinant(F);
    const M b = scaled(T(power(J, -2.0 / 3)), M(F * transpose(F)));
    const T I1 = trace(b);
    return T(law().shear_energy(I1, T(0.5 * T(I1 * I1 - contract(b, b)))) + this->volume_energy(J));
  }
  template <class M, class H>
  typename M::Scalar wave_modulus(const M& F, const H& /*history*/) const {
    using T = typename M::Scalar;
    const T J = determinant(F);
    const T I1 = T(power(J, -2.0 / 3) * trace(M(F * transpose(F))));
    const Slopes<T> at = law().slopes(I1);
    const T l = this->greatest_square(I1);
    return T(this->volume_modulus(J) + (8.0 / 3) * l * T(at.W1 + at.W2 * I1) + 4.0 * at.W11 * l * l);
  }

 private:
  const Law& law() const { return static_cast<const Law&>(*this); }
};

}  // namespace matpoint
