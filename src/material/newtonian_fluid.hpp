#pragma once

#include "material/law.hpp"

namespace matpoint {

/// Weakly compressible Newtonian fluid: sigma = 2 mu d' - p I, p = kappa (J^-gamma - 1), d' the deviator of sym(L) in 3D.
/// Source: Kamuth (thesis on explicit MPM), eq. 48-50; Monaghan (1994) for the equation of state. kappa is the pressure scale: the bulk
/// modulus at rest is gamma kappa and the speed of sound sqrt(gamma kappa / density). Under tension p falls to -kappa, as it stands;
/// `tension` scales p and its energy for J > 1, and with 0 a fluid has none: it comes apart without a force, and no energy is made or lost
/// by that.
struct NewtonianFluid {
  static constexpr auto name = "newtonian_fluid";
  static constexpr auto summary =
      "Weakly compressible Newtonian fluid with the equation of state p = kappa (J^-gamma - 1) (Monaghan 1994).";

  static constexpr bool is_fluid = true;

  Real density = 0;         ///< [kg/m^3]
  Real pressure_scale = 0;  ///< kappa [Pa]
  Real gamma = 7;           ///< [1]
  Real viscosity = 0;       ///< Dynamic viscosity mu [Pa s].
  Real tension = 1;         ///< Share of p that is kept for J > 1 [1].

  static void declare(ParameterTable<NewtonianFluid>& table) {
    table.required("density", "kg/m^3", &NewtonianFluid::density, positive(), "Mass per reference volume.");
    table.required("pressure_scale", "Pa", &NewtonianFluid::pressure_scale, positive(),
                   "kappa of p = kappa (J^-gamma - 1); the bulk modulus at rest is gamma kappa.");
    table.optional("gamma", "1", &NewtonianFluid::gamma, between_closed(1, 50), "Exponent of the equation of state; 7 for water.");
    table.optional("viscosity", "Pa s", &NewtonianFluid::viscosity, non_negative(), "Dynamic viscosity; 0 for an inviscid fluid.");
    table.optional("tension", "1", &NewtonianFluid::tension, between_closed(0, 1),
                   "Share of the tension that the equation of state gives a stretched fluid; 0 for none.");
  }

  template <class T>
  using History = NoHistory<T>;

  template <class M, class T = typename M::Scalar>
  M kirchhoff_stress(const Kinematics<M>& k, const History<T>&, History<T>&) const {
    const T J = determinant(k.F);
    const T minus_J_pressure = T(kept(J) * (pressure_scale * (J - power(J, 1 - gamma))));
    const T viscous = T(2 * viscosity * J);
    return scaled(viscous, deviator(k.d())) + M::diagonal(minus_J_pressure);
  }

  /// kappa [(J^(1 - gamma) - 1)/(gamma - 1) + J - 1], or its limit for gamma = 1: kappa (J - 1 - ln J).
  template <class M>
  typename M::Scalar energy_density(const M& F) const {
    using T = typename M::Scalar;
    const T J = determinant(F);
    if (gamma == 1) return T(kept(J) * (pressure_scale * (J - 1.0 - log(J))));
    return T(kept(J) * (pressure_scale * ((power(J, 1 - gamma) - 1.0) * (1 / (gamma - 1)) + J - 1.0)));
  }

  /// 2 mu d':d' J.
  template <class M, class T = typename M::Scalar>
  T dissipation_rate(const Kinematics<M>& k) const {
    const M d = deviator(k.d());
    return T(2 * viscosity * determinant(k.F) * contract(d, d));
  }

  /// c^2 = dp/drho = gamma kappa / rho0 J^(1 - gamma).
  Real wave_speed(Real J) const { return std::sqrt(kept(J) * gamma * pressure_scale / density * std::pow(J, 1 - gamma)); }
  Real kinematic_viscosity(Real J) const { return viscosity * J / density; }

 private:
  template <class T>
  T kept(const T& J) const {
    return select(J > T(1.0), T(tension), T(1.0));
  }
};

}  // namespace matpoint
