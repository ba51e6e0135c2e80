#pragma once

#include "material/law.hpp"
#include "material/material.hpp"
#include "material/spectral.hpp"

namespace matpoint {

/// Polymers and tissue that relax: Hencky's solid with the shear modulus G_inf of long times, and up to three Maxwell branches beside it,
/// each with a modulus G_a, a time t_a and an elastic state h_a = b_a - I of its own, without volume:
///   tau = K theta I + 2 G_inf dev e + sum 2 G_a dev e_a,   dev e_a = dev e_a*/(1 + dt/t_a)  (backward Euler: it never makes energy).
/// At small strains that is a Prony series, G(t) = G_inf + sum G_a exp(-t/t_a). Source: Reese & Govindjee (1998), with linear viscosity.
struct Viscoelastic {
  static constexpr auto name = "viscoelastic";
  static constexpr auto summary = "Viscoelastic solid with up to three relaxation times (Reese & Govindjee 1998).";
  static constexpr int k_branches = 3;

  Real density = 0;                                  ///< [kg/m^3]
  Real bulk_modulus = 0;                             ///< K [Pa]
  Real shear_modulus = 0;                            ///< G_inf [Pa]
  Real modulus_1 = 0, modulus_2 = 0, modulus_3 = 0;  ///< G_a [Pa]
  Real time_1 = 1, time_2 = 1, time_3 = 1;           ///< t_a [s]

  static void declare(ParameterTable<Viscoelastic>& table) {
    table.required("density", "kg/m^3", &Viscoelastic::density, positive(), "Mass per reference volume.");
    table.required("bulk_modulus", "Pa", &Viscoelastic::bulk_modulus, positive(), "Resistance to changes of volume, which does not relax.");
    table.optional("shear_modulus", "Pa", &Viscoelastic::shear_modulus, non_negative(),
                   "What is left after a long time; 0: it flows in the end.");
    table.required("modulus_1", "Pa", &Viscoelastic::modulus_1, positive(), "Shear modulus of the first branch.");
    table.required("time_1", "s", &Viscoelastic::time_1, positive(), "Its relaxation time.");
    table.optional("modulus_2", "Pa", &Viscoelastic::modulus_2, non_negative(), "Of the second branch; 0: there is none.");
    table.optional("time_2", "s", &Viscoelastic::time_2, positive(), "Its relaxation time.");
    table.optional("modulus_3", "Pa", &Viscoelastic::modulus_3, non_negative(), "Of the third branch; 0: there is none.");
    table.optional("time_3", "s", &Viscoelastic::time_3, positive(), "Its relaxation time.");
  }

  static constexpr bool has_state = true;
  static constexpr bool is_viscous = true;
  static constexpr bool is_symmetric = true;
  static constexpr std::array<InternalVariable, 0> internal_variables = {};

  template <class T, bool is_plane>
  struct History {
    T h[k_branches][is_plane ? 4 : 6];  ///< b_a - I: xx yy zz xy (yz xz).
  };

  template <class M, class H, class T = typename M::Scalar>
  M update(const Kinematics<M>& k, const H& old_history, H& updated, T& dissipated) const {
    M tau = equilibrium_stress(k.F);
    dissipated = T(0.0);
    for (int a = 0; a < k_branches; ++a) {
      const auto [G, time] = branch(a);
      if (G == 0) continue;
      const M h = unpacked<M>(old_history.h[a]);
      const M moved = k.g + k.g * h;
      const M trial = h + moved + transpose(moved) + moved * transpose(k.g);
      const Real kept = 1 / (1 + k.dt / time);
      if constexpr (k_has_derivatives<T>) {
        tau = tau + isotropic(trial, [&](const auto* e) { return deviatoric(e, 2 * G * kept); });
      } else {
        const Spectrum<T, M::k_size == 5> spectrum(trial);
        const std::array<T, 3> dev = deviatoric(spectrum.half_log, kept);
        T values[3], stress[3], squared = T(0.0);
        for (std::size_t i = 0; i < 3; ++i) {
          values[i] = expm1(T(2.0 * dev[i]));
          stress[i] = T(2 * G * dev[i]);
          squared = T(squared + dev[i] * dev[i]);
        }
        pack(spectrum.compose(values), updated.h[a]);
        tau = tau + spectrum.compose(stress);
        dissipated = T(dissipated + (2 * G * k.dt / time) * squared);
      }
    }
    return tau;
  }
  template <class M, class H>
  M stress_of(const M& F, const H& history) const {
    M tau = equilibrium_stress(F);
    for (int a = 0; a < k_branches; ++a) {
      const Real G = branch(a).first;
      if (G > 0) tau = tau + isotropic(unpacked<M>(history.h[a]), [&](const auto* e) { return deviatoric(e, 2 * G); });
    }
    return tau;
  }
  template <class M, class H>
  typename M::Scalar energy_of(const M& F, const H& history) const {
    using T = typename M::Scalar;
    using S = Spectrum<T, M::k_size == 5>;
    const T theta = T(log(determinant(F)));
    T energy = T(0.5 * bulk_modulus * theta * theta);
    const auto add = [&](const M& h, Real G) {
      const std::array<T, 3> dev = deviatoric(S(h).half_log, 1);
      energy = T(energy + G * T(dev[0] * dev[0] + dev[1] * dev[1] + dev[2] * dev[2]));
    };
    if (shear_modulus > 0) add(left_cauchy_green_minus_identity(F), shear_modulus);
    for (int a = 0; a < k_branches; ++a) {
      if (branch(a).first > 0) add(unpacked<M>(history.h[a]), branch(a).first);
    }
    return energy;
  }
  template <class M, class H>
  void deform(const M& F, H& history) const {
    using T = typename M::Scalar;
    const Spectrum<T, M::k_size == 5> spectrum(left_cauchy_green_minus_identity(F));
    const std::array<T, 3> dev = deviatoric(spectrum.half_log, 1);
    T values[3];
    for (std::size_t i = 0; i < 3; ++i) values[i] = expm1(T(2.0 * dev[i]));
    for (int a = 0; a < k_branches; ++a) {
      if (branch(a).first > 0) pack(spectrum.compose(values), history.h[a]);
    }
  }
  /// Of waves that are faster than it relaxes.
  Real wave_speed(Real J) const {
    const Real G = shear_modulus + modulus_1 + modulus_2 + modulus_3;
    return std::sqrt((bulk_modulus + G * (4.0 / 3)) * (1 - std::min(std::log(J), Real{0})) / density);
  }

 private:
  std::pair<Real, Real> branch(int a) const {
    return a == 0 ? std::pair(modulus_1, time_1) : a == 1 ? std::pair(modulus_2, time_2) : std::pair(modulus_3, time_3);
  }
  template <class T>
  static std::array<T, 3> deviatoric(const T* e, Real factor) {
    const T mean = T((e[0] + e[1] + e[2]) * (1.0 / 3));
    return {T(factor * T(e[0] - mean)), T(factor * T(e[1] - mean)), T(factor * T(e[2] - mean))};
  }
  template <class M>
  M equilibrium_stress(const M& F) const {
    using T = typename M::Scalar;
    const M volume = M::diagonal(T(bulk_modulus * log(determinant(F))));
    if (shear_modulus == 0) return volume;
    return volume + isotropic(left_cauchy_green_minus_identity(F), [this](const auto* e) { return deviatoric(e, 2 * shear_modulus); });
  }
};

}  // namespace matpoint
