#pragma once

#include "material/law.hpp"

namespace matpoint {

/// Compressible Neo-Hookean solid: tau = mu (b - I) + lambda ln J I with b = F F^T;
/// W = mu/2 (tr b - 3 - 2 ln J) + lambda/2 (ln J)^2.
/// Source: Bonet & Wood (2008), sec. 6.4.3; Kamuth (thesis on explicit MPM), eq. 47. For J > 0, any size of strain.
struct NeoHookean : ElasticParameters {
  static constexpr auto name = "neo_hookean";
  static constexpr auto summary = "Compressible Neo-Hookean solid, for large strains (Bonet & Wood 2008, sec. 6.4.3).";

  static void declare(ParameterTable<NeoHookean>& table) { declare_elastic(table); }

  template <class M>
  M kirchhoff_stress(const M& F) const {
    using T = typename M::Scalar;
    const M b = F * transpose(F);
    return mu() * b + M::diagonal(T(lambda() * log(determinant(F)) - mu()));
  }

  template <class M>
  typename M::Scalar energy_density(const M& F) const {
    using T = typename M::Scalar;
    const T log_J = log(determinant(F));
    return T(0.5 * mu() * (contract(F, F) - 3.0 - 2.0 * log_J) + 0.5 * lambda() * log_J * log_J);
  }

  /// Of plane waves along a uniaxial stretch J: c^2 = J^2 dP/dJ / rho0 with P = mu (J - 1/J) + lambda ln J / J.
  Real wave_speed(Real J) const {
    const Real stiffness = mu() * (J * J + 1) + lambda() * (1 - std::log(J));
    return std::sqrt(std::max(mu(), stiffness) / density);
  }
};

}  // namespace matpoint
