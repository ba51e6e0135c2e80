#pragma once

#include "material/fixed_corotated.hpp"
#include "material/flow_law.hpp"

namespace matpoint {

/// Snow: the fixed corotated solid, whose elastic stretches l_i are kept within [1 - theta_c, 1 + theta_s]; what is beyond flows, and the
/// volume J_p that has flowed hardens or softens: both moduli times exp(xi (1 - J_p)), at most `hardening_limit` times.
/// A loaded body that hardens gains energy; that is taken off what the step dissipates, so that the books close.
/// Source: Stomakhin, Schroeder, Chai, Teran & Selle (2013).
struct Snow : FlowLaw<Snow> {
  static constexpr auto name = "snow";
  static constexpr auto summary = "Snow, which packs, hardens and falls apart (Stomakhin et al. 2013).";
  static constexpr bool flows_freely = true;

  Real critical_compression = 0.025;  ///< theta_c [1]
  Real critical_stretch = 0.0075;     ///< theta_s [1]
  Real hardening = 10;                ///< xi [1]
  Real hardening_limit = 20;          ///< [1]

  static void declare(ParameterTable<Snow>& table) {
    declare_elastic(table);
    const Constraint small{"in the interval (0, 0.5)", [](Real x) { return x > 0 && x < 0.5; }};
    table.optional("critical_compression", "1", &Snow::critical_compression, small, "Compression beyond which it packs.");
    table.optional("critical_stretch", "1", &Snow::critical_stretch, small, "Stretch beyond which it comes apart.");
    table.optional("hardening", "1", &Snow::hardening, non_negative(), "xi of exp(xi (1 - J_p)).");
    table.optional("hardening_limit", "1", &Snow::hardening_limit, Constraint{"at least 1", [](Real x) { return x >= 1; }},
                   "Greatest factor of the moduli; without a limit the stable step falls without bound as snow packs.");
  }

  template <class T>
  struct Internal {
    T packed;  ///< ln J_p
  };
  static constexpr std::array<InternalVariable, 1> internal_variables = {{{"plastic_volume_strain", "1"}}};

  template <class State, class T>
  void flow(State& p, const Internal<T>& old, Internal<T>& updated, Real /*dt*/) const {
    const std::array<T, 3> before = p.e;
    T flowed = T(0.0);
    for (std::size_t i = 0; i < 3; ++i) {
      p.e[i] = max(T(std::log1p(-critical_compression)), min(T(std::log1p(critical_stretch)), before[i]));
      flowed = T(flowed + (before[i] - p.e[i]));
    }
    updated.packed = old.packed + flowed;
    p.dissipated = principal_energy(before.data(), old) - principal_energy(p.e.data(), updated);
  }
  template <class T, class I>
  std::array<T, 3> principal_stress(const T* e, const I& now) const {
    const T factor = hardened(now.packed);
    return FixedCorotated::principal_stress(e, T(factor * lambda()), T(factor * mu()));
  }
  template <class T, class I>
  T principal_energy(const T* e, const I& now) const {
    const T factor = hardened(now.packed);
    return FixedCorotated::principal_energy(e, T(factor * lambda()), T(factor * mu()));
  }
  template <class M, class H>
  typename M::Scalar wave_modulus(const M& /*F*/, const H& history) const {
    using T = typename M::Scalar;
    return T(hardened(history.internal.packed) * ((lambda() + 2 * mu()) * std::pow(1 + critical_stretch, 6)));
  }

 private:
  template <class T>
  T hardened(const T& packed) const {
    // The exponent is limited, so that what flies apart does not lose its stiffness to the last digit.
    const T exponent = T(hardening * -expm1(max(T(-3.0), min(packed, T(3.0)))));
    return T(exp(max(T(-30.0), min(T(std::log(hardening_limit)), exponent))));
  }
};

}  // namespace matpoint
