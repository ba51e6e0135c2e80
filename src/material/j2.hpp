#pragma once

#include "material/flow_law.hpp"

namespace matpoint {

/// Metals: Hencky's elasticity, and flow at constant volume where von Mises' stress of tau reaches sigma_y(a), a the plastic strain.
///   sigma_y = s0 + H a                                             hardening_modulus
///           = s0 + (s_inf - s0) (1 - exp(-delta a)) + H a          saturation_stress, saturation_rate: Voce
///           = s0 (1 + a/eps0)^n                                    swift_strain, swift_exponent: Swift
/// Sources: Simo (1992); Voce (1948); Swift (1952). Yield is of Kirchhoff stress, which is Cauchy's to the change of volume.
struct J2 : FlowLaw<J2> {
  static constexpr auto name = "j2";
  static constexpr auto summary = "Von Mises plasticity for metals, perfect or with linear, Voce's or Swift's hardening (Simo 1992).";

  Real yield_stress = 0;                  ///< s0 [Pa]
  Real hardening_modulus = 0;             ///< H [Pa]
  std::optional<Real> saturation_stress;  ///< s_inf [Pa]
  Real saturation_rate = 0;               ///< delta [1]
  Real swift_strain = 0;                  ///< eps0 [1]; 0: no Swift hardening.
  Real swift_exponent = 0;                ///< n [1]

  static void declare(ParameterTable<J2>& table) {
    declare_elastic(table);
    table.required("yield_stress", "Pa", &J2::yield_stress, positive(), "Von Mises' stress at which it first yields.");
    table.optional("hardening_modulus", "Pa", &J2::hardening_modulus, non_negative(), "Linear hardening; 0 for a perfectly plastic metal.");
    table.optional("saturation_stress", "Pa", &J2::saturation_stress, positive(),
                   "Voce: the yield stress at large plastic strains, but for linear hardening; with saturation_rate.");
    table.optional("saturation_rate", "1", &J2::saturation_rate, non_negative(), "Voce: how soon it is reached.");
    table.optional("swift_strain", "1", &J2::swift_strain, non_negative(),
                   "Swift: yield_stress (1 + a/swift_strain)^swift_exponent at the plastic strain a; 0: not Swift.");
    table.optional("swift_exponent", "1", &J2::swift_exponent, Constraint{"in the interval [0, 1)", [](Real x) { return x >= 0 && x < 1; }},
                   "Swift: the exponent.");
  }
  void check(const Input& input, const ReadContext& context) const {
    if (saturation_stress && *saturation_stress < yield_stress) {
      fail_input(input, context,
                 fmt::format("saturation_stress = {} is below yield_stress = {}: it would soften, which depends on the grid; allowed: >= "
                             "yield_stress",
                             *saturation_stress, yield_stress));
    }
    if (saturation_stress && !(saturation_rate > 0))
      fail_input(input, context, "saturation_stress needs a saturation_rate > 0, or nothing ever hardens");
    if (swift_strain > 0 && (saturation_stress || hardening_modulus > 0))
      fail_input(input, context, "swift_strain is given beside hardening_modulus or saturation_stress; give one kind of hardening");
    if (swift_exponent > 0 && swift_strain == 0) fail_input(input, context, "swift_exponent needs a swift_strain > 0");
  }

  template <class T>
  struct Internal {
    T plastic_strain;
  };
  static constexpr std::array<InternalVariable, 1> internal_variables = {{{"plastic_strain", "1"}}};
  /// The step minimises an energy, so its tangent is symmetric.
  static constexpr bool is_symmetric = true;

  static constexpr bool scales_deviator = true;

  /// q* - 3 G x = sigma_y(a + x) for the plastic strain x of the step: convex and falling, so that Newton's method climbs to it from 0.
  template <class State, class T>
  void flow(State& p, const Internal<T>& old, Internal<T>& updated, Real /*dt*/) const {
    const Real G3 = 3 * mu();
    const T a = old.plastic_strain;
    // Within the yield surface the equation is that of a point on it, and x comes out as 0.
    const T q = T(p.shear() * (std::sqrt(6.0) * mu()));
    T stress, slope;
    harden(a, stress, slope);
    const T q_or_yield = max(q, stress);
    T x = T((q_or_yield - stress) / (slope + T(G3)));
    if (saturation_stress || swift_strain > 0) {
      constexpr int k_iterations = 5;
      for (int i = 1; i < k_iterations; ++i) {
        harden(T(a + x), stress, slope);
        x = x + (q_or_yield - G3 * x - stress) / (slope + T(G3));
      }
    }
    const T q_new = T(q_or_yield - G3 * x);
    const T scale = T(T(1.0) - G3 * x / q_or_yield);
    p.set(p.theta(), scale);
    updated.plastic_strain = a + x;
    p.dissipated = q_new * x;
  }

 private:
  /// sigma_y and its derivative.
  template <class T>
  void harden(const T& a, T& stress, T& slope) const {
    if (swift_strain > 0) {
      const T base = T(T(1.0) + a * (1 / swift_strain));
      stress = T(yield_stress * exp(T(swift_exponent * log(base))));
      slope = T(stress * (swift_exponent / swift_strain) / base);
      return;
    }
    stress = T(T(yield_stress) + hardening_modulus * a);
    slope = T(hardening_modulus);
    if (!saturation_stress) return;
    const Real rise = *saturation_stress - yield_stress;
    const T left = T(rise * exp(T(-saturation_rate * a)));
    stress = stress + (T(rise) - left);
    slope = slope + saturation_rate * left;
  }
};

}  // namespace matpoint
