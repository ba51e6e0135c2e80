#pragma once

#include "material/flow_law.hpp"

namespace matpoint {

/// Muds, pastes, fresh concrete: sqrt(J2) = tau_y + k g^n where it flows, g the shear rate; elastic below, so that it comes to rest. n = 1
/// is Bingham's fluid. Implicit in the law: no viscous limit of dt. In steady shear tau_12 = (tau_y + k g^n)/cosh((tau_y + k g^n)/G).
/// Sources: Herschel & Bulkley (1926); Bingham (1922); Saramito (2007) for the elastic part.
struct HerschelBulkley : PartingLaw<HerschelBulkley> {
  static constexpr auto name = "herschel_bulkley";
  static constexpr auto summary = "Yield-stress fluid, elastic below its yield stress (Herschel & Bulkley 1926); exponent 1 is Bingham's.";

  Real yield_stress = 0;               ///< tau_y [Pa]
  Real consistency = 0;                ///< k [Pa s^n]
  Real exponent = 1;                   ///< n [1]
  std::optional<Real> tension_cutoff;  ///< Greatest mean stress [Pa].

  static void declare(ParameterTable<HerschelBulkley>& table) {
    declare_elastic(table);
    table.required("yield_stress", "Pa", &HerschelBulkley::yield_stress, non_negative(), "Shear stress below which it does not flow.");
    table.required("consistency", "Pa s^n", &HerschelBulkley::consistency, non_negative(),
                   "Viscosity of what is above; of Bingham's fluid [Pa s].");
    table.optional("exponent", "1", &HerschelBulkley::exponent,
                   Constraint{"in the interval (0, 2]", [](Real x) { return x > 0 && x <= 2; }},
                   "1: Bingham's fluid; below it thins in shear.");
    table.optional("tension_cutoff", "Pa", &HerschelBulkley::tension_cutoff, non_negative(),
                   "Greatest tension, as a mean stress, at which it parts; default: it never does.");
  }

  static constexpr bool scales_deviator = true;

  template <class State, class T>
  void flow(State& p, const Internal<T>& old, Internal<T>& updated, Real dt) const {
    const Real K = bulk_modulus(), G = mu();
    T gap = p.close(old.gap);
    const T theta = p.theta();
    T new_theta = theta;
    if (tension_cutoff) new_theta = min(theta, T(*tension_cutoff / K));
    gap = gap + (theta - new_theta);
    const T r = T(p.shear() * (std::sqrt(2.0) * G));
    const T excess = T(max(T(0.0), T(r - T(yield_stress))));
    // G dt g + k g^n = excess, for the strain x = dt g of the step.
    T x = T(0.0);
    if (dt > 0) x = exponent == 1 ? T(excess * (dt / (G * dt + consistency))) : T(shear_rate(excess, dt) * dt);
    const T new_r = T(r - G * x);
    p.set(new_theta, T(new_r / r));
    updated.plastic_strain = old.plastic_strain + x * (1 / std::sqrt(3.0));
    updated.gap = gap;
    p.dissipated = T(new_r * x + (theta - new_theta) * (K * new_theta));
  }

 private:
  /// Newton's method from the upper bound: in g^n for n < 1, in g for n > 1, where the equation is concave or convex.
  template <class T>
  T shear_rate(const T& excess, Real dt) const {
    const Real stiff = mu() * dt;
    constexpr int k_iterations = 6;
    const T tiny = T(1e-30 * mu());
    const T positive_excess = T(max(excess, tiny));
    if (exponent < 1) {
      // k y + G dt y^(1/n) = excess.
      const Real m = 1 / exponent;
      const T linear = T(positive_excess * (1 / stiff));
      T y = T(exp(T(exponent * log(linear))));
      if (consistency > 0) y = min(y, T(positive_excess * (1 / consistency)));
      for (int i = 0; i < k_iterations; ++i) {
        const T rate = T(exp(T(m * log(y))));
        y = T(y - (consistency * y + stiff * rate - positive_excess) / (T(consistency) + (stiff * m) * rate / y));
        y = max(y, tiny);
      }
      return select(excess > T(0.0), T(exp(T(m * log(y)))), T(0.0));
    }
    T g = T(positive_excess * (1 / stiff));
    for (int i = 0; i < k_iterations; ++i) {
      const T stress = T(consistency * exp(T(exponent * log(g))));
      g = T(g - (stress + stiff * g - positive_excess) / (T(stiff) + exponent * stress / g));
      g = max(g, tiny);
    }
    return select(excess > T(0.0), g, T(0.0));
  }
};

}  // namespace matpoint
