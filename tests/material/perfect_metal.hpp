#pragma once

#include "material/flow_law.hpp"

namespace matpoint {

/// A metal that flows where von Mises' stress of tau reaches the yield stress, and never hardens. Source: Simo (1992).
struct PerfectMetal : FlowLaw<PerfectMetal> {
  static constexpr auto name = "perfect_metal";
  static constexpr auto summary = "Perfectly plastic metal (Simo 1992).";

  Real yield_stress = 0;  ///< [Pa]

  static void declare(ParameterTable<PerfectMetal>& table) {
    declare_elastic(table);
    table.required("yield_stress", "Pa", &PerfectMetal::yield_stress, positive(), "Von Mises' stress at which it flows.");
  }

  template <class T>
  struct Internal {
    T plastic_strain;
  };
  static constexpr std::array<InternalVariable, 1> internal_variables = {{{"plastic_strain", "1"}}};

  static constexpr bool scales_deviator = true;

  template <class State, class T>
  void flow(State& p, const Internal<T>& old, Internal<T>& updated, Real /*dt*/) const {
    const T q = T(p.shear() * (std::sqrt(6.0) * mu()));  // von Mises' stress if nothing flowed
    const T q_new = min(q, T(yield_stress));
    const T strain = T((q - q_new) * (1 / (3 * mu())));
    p.set(p.theta(), T(q_new / q));
    updated.plastic_strain = old.plastic_strain + strain;
    p.dissipated = q_new * strain;
  }
};

}  // namespace matpoint
