#pragma once

#include "material/law.hpp"

namespace matpoint {

/// St. Venant-Kirchhoff solid: S = lambda tr(E) I + 2 mu E with Green's strain E = (F^T F - I)/2, tau = F S F^T.
/// Source: Bonet & Wood (2008), sec. 6.4.1; Kamuth (thesis on explicit MPM), eq. 45. Large rotations, small strains: it softens in
/// compression and lets material pass J = 0 at finite force.
struct StVenantKirchhoff : ElasticParameters {
  static constexpr auto name = "st_venant_kirchhoff";
  static constexpr auto summary =
      "St. Venant-Kirchhoff solid: linear between Green's strain and the second Piola-Kirchhoff stress (Bonet & Wood 2008, sec. 6.4.1).";

  static void declare(ParameterTable<StVenantKirchhoff>& table) { declare_elastic(table); }

  template <class M>
  M kirchhoff_stress(const M& F) const {
    using T = typename M::Scalar;
    const M E = green_strain(F);
    const M S = M::diagonal(T(lambda() * trace(E))) + (2 * mu()) * E;
    return F * S * transpose(F);
  }

  template <class M>
  typename M::Scalar energy_density(const M& F) const {
    using T = typename M::Scalar;
    const M E = green_strain(F);
    const T trace_E = trace(E);
    return T(0.5 * lambda() * trace_E * trace_E + mu() * contract(E, E));
  }

  /// Of plane waves along a uniaxial stretch J: c^2 = J^2 dP/dJ / rho0 with P = (lambda + 2 mu) J (J^2 - 1)/2, 0 where P softens.
  Real wave_speed(Real J) const {
    const Real stiffness = (lambda() + 2 * mu()) * (3 * J * J - 1) / 2;
    return J * std::sqrt(std::max(Real{0}, stiffness) / density);
  }

 private:
  template <class M>
  static M green_strain(const M& F) {
    return 0.5 * (transpose(F) * F - M::identity());
  }
};

}  // namespace matpoint
