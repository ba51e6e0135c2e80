#pragma once

#include "material/flow_law.hpp"

namespace matpoint {

/// Dry grains that flow: sqrt(J2) = mu(I) p, mu = mu_s + (mu_2 - mu_s)/(1 + I0/I), I = g d sqrt(rho_s/p) with the shear rate g, at constant
/// volume; elastic below mu_s p; without pressure it has no stress and parts. The step is implicit and closed: no viscous limit of dt.
/// Sources: Jop, Forterre & Pouliquen (2006); Dunatunga & Kamrin (2015).
struct MuI : PartingLaw<MuI> {
  static constexpr auto name = "mu_i";
  static constexpr auto summary = "Dry granular flow with the mu(I) rheology (Jop, Forterre & Pouliquen 2006; Dunatunga & Kamrin 2015).";

  Real mu_s = 0;            ///< [1]
  Real mu_2 = 0;            ///< [1]
  Real I0 = 0;              ///< [1]
  Real grain_diameter = 0;  ///< d [m]
  Real grain_density = 0;   ///< rho_s [kg/m^3]

  static void declare(ParameterTable<MuI>& table) {
    declare_elastic(table);
    table.required("mu_s", "1", &MuI::mu_s, between(0, 2), "Coefficient of friction at rest.");
    table.required("mu_2", "1", &MuI::mu_2, between(0, 2), "The same of fast flow, above mu_s.");
    table.required("I0", "1", &MuI::I0, positive(), "Inertial number half way between.");
    table.required("grain_diameter", "m", &MuI::grain_diameter, positive(), "Diameter of the grains.");
    table.required("grain_density", "kg/m^3", &MuI::grain_density, positive(), "Density of the grains' own material.");
  }
  void check(const Input& input, const ReadContext& context) const {
    if (mu_2 <= mu_s) fail_input(input, context, fmt::format("mu_2 = {} is not above mu_s = {}", mu_2, mu_s));
    if (grain_density < density)
      fail_input(input, context,
                 fmt::format("grain_density = {} is below density = {}, which counts the voids, too", grain_density, density));
  }

  static constexpr bool scales_deviator = true;

  template <class State, class T>
  void flow(State& p, const Internal<T>& old, Internal<T>& updated, Real dt) const {
    const Real K = bulk_modulus(), G = mu();
    const T gap = p.close(old.gap);
    const T theta = p.theta();
    const T none = T(0.0);
    const T pressure = T(max(none, T(-K * theta)));
    const T r = T(p.shear() * (std::sqrt(2.0) * G));
    const T slow = T(mu_s * pressure), fast = T(mu_2 * pressure);
    const T al = T(sqrt(T(pressure + T(1e-30 * G))) * (I0 * G * dt / (grain_diameter * std::sqrt(grain_density))));
    const T B = T(fast + r + al);
    const T H = T(fast * r + slow * al);
    const T flowing = T(2.0 * H / (B + T(sqrt(T(max(T(1e-30 * G * G), T(B * B - 4.0 * H)))))));
    const T new_r = select(r > slow, T(min(flowing, r)), r);
    const T new_theta = T(min(theta, none));
    p.set(new_theta, T(new_r / r));
    updated.plastic_strain = old.plastic_strain + (r - new_r) * (1 / (std::sqrt(3.0) * G));
    updated.gap = gap + (theta - new_theta);
    p.dissipated = T(new_r * (r - new_r) * (1 / G));
  }
};

}  // namespace matpoint
