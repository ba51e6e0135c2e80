#pragma once

#include "material/neo_hookean.hpp"

namespace matpoint {

/// Neo-Hookean solid that softens with the greatest energy it has stored: tau = exp(-W_max/W_d) tau_0, W_max = max over time of W_0(F).
/// Source: Simo (1987), sec. 3, with an exponential in place of his function of damage. Reloading below W_max is elastic.
struct DamagedNeoHookean : ElasticParameters {
  static constexpr auto name = "damaged_neo_hookean";
  static constexpr auto summary = "Neo-Hookean solid that softens with the greatest energy it has stored.";

  Real damage_energy = 0;  ///< W_d [J/m^3]

  static void declare(ParameterTable<DamagedNeoHookean>& table) {
    declare_elastic(table);
    table.required("damage_energy", "J/m^3", &DamagedNeoHookean::damage_energy, positive(),
                   "Stored energy that softens to a share of 1/e.");
  }

  template <class T>
  struct History {
    T energy_max;  ///< W_max [J/m^3]; every history starts as zeros.
  };

  template <class M, class T = typename M::Scalar>
  M kirchhoff_stress(const Kinematics<M>& k, const History<T>& old_history, History<T>& updated) const {
    const NeoHookean virgin{*this};
    const T W = virgin.energy_density(k.F);
    updated.energy_max = select(W > old_history.energy_max, W, old_history.energy_max);
    return scaled(T(exp(T(updated.energy_max * (-1 / damage_energy)))), virgin.kirchhoff_stress(k.F));
  }

  /// Of virgin material, which is the fastest.
  Real wave_speed(Real J) const { return NeoHookean{*this}.wave_speed(J); }
};

}  // namespace matpoint
