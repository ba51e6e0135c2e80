#pragma once

#include "material/law.hpp"
#include "material/spectral.hpp"

namespace matpoint {

/// The fixed corotated solid: with the principal stretches l_i, tau_i = 2 mu (l_i - 1) l_i + lambda (J - 1) J and
/// W = mu sum (l_i - 1)^2 + lambda/2 (J - 1)^2. Its energy stays finite at J = 0, so that a great force may turn it inside out.
/// Source: Stomakhin, Howes, Schroeder & Teran (2012).
struct FixedCorotated : ElasticParameters {
  static constexpr auto name = "fixed_corotated";
  static constexpr auto summary = "Fixed corotated solid of computer graphics (Stomakhin et al. 2012): the elastic part of snow.";

  static void declare(ParameterTable<FixedCorotated>& table) { declare_elastic(table); }

  template <class M>
  M kirchhoff_stress(const M& F) const {
    return isotropic(left_cauchy_green_minus_identity(F), [this](const auto* e) { return principal_stress(e, lambda(), mu()); });
  }
  template <class M>
  typename M::Scalar energy_density(const M& F) const {
    using T = typename M::Scalar;
    const T J_minus_1 = T(determinant(F) - 1.0);
    // The trace of the tensor whose principal values are (l_i - 1)^2.
    const M squares = isotropic(left_cauchy_green_minus_identity(F), [](const auto* e) {
      using U = std::remove_cvref_t<decltype(*e)>;
      std::array<U, 3> result;
      for (std::size_t i = 0; i < 3; ++i) result[i] = U(expm1(e[i]) * expm1(e[i]));
      return result;
    });
    return T(mu() * trace(squares) + 0.5 * lambda() * J_minus_1 * J_minus_1);
  }
  /// Of plane waves along a uniaxial stretch J: rho0 c^2 = (2 mu + lambda) J^2.
  Real wave_speed(Real J) const { return std::sqrt((lambda() + 2 * mu()) / density) * J; }
  /// Along the greatest stretch l: 2 mu l^2 + lambda J^2, with Gershgorin's bound of l^2.
  template <class M, class H>
  typename M::Scalar wave_modulus(const M& F, const H& /*history*/) const {
    using T = typename M::Scalar;
    const M b = F * transpose(F);
    const T xy = abs(b(0, 1));
    T x = T(b(0, 0) + xy), y = T(b(1, 1) + xy), z = b(2, 2);
    if constexpr (M::k_size == 9) {
      x = T(x + abs(b(0, 2)));
      y = T(y + abs(b(1, 2)));
      z = T(z + abs(b(0, 2)) + abs(b(1, 2)));
    }
    const T J = determinant(F);
    return T(2 * mu() * max(x, max(y, z)) + lambda() * T(J * J));
  }

  /// Of the half logarithms e_i of b; Lame's numbers may be those of a state.
  template <class T, class Modulus>
  static std::array<T, 3> principal_stress(const T* e, const Modulus& lambda, const Modulus& mu) {
    const T theta = T(e[0] + e[1] + e[2]);
    const T J_minus_1 = T(expm1(theta));
    const T shared = T(lambda * T(J_minus_1 * T(J_minus_1 + T(1.0))));
    std::array<T, 3> tau;
    for (std::size_t i = 0; i < 3; ++i) {
      const T l_minus_1 = T(expm1(e[i]));
      tau[i] = T(shared + 2.0 * mu * T(l_minus_1 * T(l_minus_1 + T(1.0))));
    }
    return tau;
  }
  template <class T, class Modulus>
  static T principal_energy(const T* e, const Modulus& lambda, const Modulus& mu) {
    const T J_minus_1 = T(expm1(T(e[0] + e[1] + e[2])));
    T squares = T(0.0);
    for (int i = 0; i < 3; ++i) squares = T(squares + expm1(e[i]) * expm1(e[i]));
    return T(mu * squares + 0.5 * lambda * T(J_minus_1 * J_minus_1));
  }
};

}  // namespace matpoint
