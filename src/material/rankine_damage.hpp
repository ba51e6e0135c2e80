#pragma once

#include <optional>

#include "material/law.hpp"
#include "material/material.hpp"
#include "material/spectral.hpp"

namespace matpoint {

/// Brittle solids that break in tension: Hencky's solid, whose positive principal stresses are reduced to (1 - d), while closed cracks
/// carry. With the greatest of all times k = max <sigma_1>/E of the undamaged stress,
///   d = 1 - (k0/k) exp(-(k - k0)/kf),   k0 = ft/E,   kf = Gf/(h ft) - k0/2 > 0,
/// so that a row of cells of the size h takes the energy Gf to break, whatever h is; h < 2 E Gf/ft^2, or it would snap back.
/// What a step dissipates is its work less what is stored; where tension and pressure mix, a broken point may give a little back.
/// Sources: Oliver, Cervera, Oller & Lubliner (1990); Bazant & Oh (1983) for the length.
struct RankineDamage : ElasticParameters {
  static constexpr auto name = "rankine_damage";
  static constexpr auto summary = "Brittle solid that breaks in tension with a fracture energy: rock, ice, concrete (Oliver et al. 1990).";

  Real tensile_strength = 0;   ///< ft [Pa]
  Real fracture_energy = 0;    ///< Gf [J/m^2]
  std::optional<Real> length;  ///< h [m]

  static void declare(ParameterTable<RankineDamage>& table) {
    declare_elastic(table);
    table.required("tensile_strength", "Pa", &RankineDamage::tensile_strength, positive(), "Greatest principal stress.");
    table.required("fracture_energy", "J/m^2", &RankineDamage::fracture_energy, positive(), "Energy that a crack takes per area.");
    table.optional("length", "m", &RankineDamage::length, positive(), "Width of what breaks; default: the cell size.");
  }
  void check(const Input& input, const ReadContext& context) {
    const Real k0 = tensile_strength / youngs_modulus;
    if (!length) return;
    softening_strain_ = fracture_energy / (*length * tensile_strength) - 0.5 * k0;
    if (softening_strain_ > 0) return;
    fail_input(input, context,
               fmt::format("length = {} stores more energy than fracture_energy takes when it breaks (it would snap back); allowed: "
                           "below 2 E Gf/ft^2 = {:.6g}: use smaller cells",
                           *length, 2 * youngs_modulus * fracture_energy / (tensile_strength * tensile_strength)));
  }

  static constexpr bool has_state = true;
  static constexpr std::array<InternalVariable, 2> internal_variables = {{{"crack_strain", "1"}, {"damage", "1"}}};

  template <class T, bool is_plane>
  struct History {
    T crack_strain;  ///< k - k0
    T damage;        ///< d
  };

  template <class M, class H, class T = typename M::Scalar>
  M update(const Kinematics<M>& k, const H& old, H& updated, T& dissipated) const {
    const M h = left_cauchy_green_minus_identity(k.F);
    if constexpr (k_has_derivatives<T>) {
      return isotropic(h, [&](const auto* e) {
        using U = std::remove_cvref_t<decltype(*e)>;
        return stress(e, damage_at(strain_after(e, U(old.crack_strain.value()))));
      });
    } else {
      const Spectrum<T, M::k_size == 5> spectrum(h);
      updated.crack_strain = strain_after(spectrum.half_log, old.crack_strain);
      updated.damage = damage_at(updated.crack_strain);
      const M tau = spectrum.compose(stress(spectrum.half_log, updated.damage).data());
      // The work of the step less what is stored: with some principal stresses reduced and others not, the stress has no energy that it is
      // the derivative of, so that (W+ of what broke) would not close the books.
      const M f = M::identity() + k.g;
      const M F_old = scaled(T(T(1.0) / determinant(f)), transpose(cofactor(f)) * k.F);
      const M before = f * stress_of(F_old, old) * transpose(f);
      const T work = T(0.5 * contract(before + tau, symmetric_part(k.g - 0.5 * (k.g * k.g))));
      const T stored = T(energy_of(k.F, updated) - energy_of(F_old, old));
      dissipated = select(updated.damage > T(0.0), T(work - stored), T(0.0));
      return tau;
    }
  }
  template <class M, class H>
  M stress_of(const M& F, const H& history) const {
    return isotropic(left_cauchy_green_minus_identity(F), [&](const auto* e) { return stress(e, history.damage); });
  }
  template <class M, class H>
  typename M::Scalar energy_of(const M& F, const H& history) const {
    using T = typename M::Scalar;
    const Spectrum<T, M::k_size == 5> spectrum(left_cauchy_green_minus_identity(F));
    const std::array<T, 2> energy = energies(spectrum.half_log);
    return T(T(T(1.0) - history.damage) * energy[0] + energy[1]);
  }
  template <class M, class H>
  void deform(const M& /*F*/, H& /*history*/) const {}

  Real wave_speed(Real J) const { return std::sqrt(std::max(mu(), (lambda() + 2 * mu()) * (1 - std::log(J))) / density); }

 private:
  template <class T>
  std::array<T, 3> whole_stress(const T* e) const {
    const T shared = T(lambda() * T(e[0] + e[1] + e[2]));
    return {T(shared + 2 * mu() * e[0]), T(shared + 2 * mu() * e[1]), T(shared + 2 * mu() * e[2])};
  }
  template <class T>
  std::array<T, 3> stress(const T* e, const T& damage) const {
    std::array<T, 3> tau = whole_stress(e);
    for (T& one : tau) one = select(one > T(0.0), T(one * T(T(1.0) - damage)), one);
    return tau;
  }
  /// Of positive and of negative principal stresses [J/m^3].
  template <class T>
  std::array<T, 2> energies(const T* e) const {
    const std::array<T, 3> tau = whole_stress(e);
    std::array<T, 2> energy = {T(0.0), T(0.0)};
    for (std::size_t i = 0; i < 3; ++i) {
      const T one = T(0.5 * tau[i] * e[i]);
      const auto is_positive = tau[i] > T(0.0);
      energy[0] = T(energy[0] + select(is_positive, one, T(0.0)));
      energy[1] = T(energy[1] + select(is_positive, T(0.0), one));
    }
    return energy;
  }
  /// k - k0 after a strain.
  template <class T>
  T strain_after(const T* e, const T& old) const {
    const std::array<T, 3> tau = whole_stress(e);
    const T J = T(exp(T(e[0] + e[1] + e[2])));
    const T greatest = T(max(tau[0], max(tau[1], tau[2])) / J);
    return T(max(old, T(greatest * (1 / youngs_modulus) - T(tensile_strength / youngs_modulus))));
  }
  template <class T>
  T damage_at(const T& crack_strain) const {
    const Real k0 = tensile_strength / youngs_modulus;
    const T x = T(max(crack_strain, T(0.0)));
    return T(T(1.0) - T(k0) / T(x + T(k0)) * exp(T(max(T(-80.0), T(x * (-1 / softening_strain_))))));
  }

  Real softening_strain_ = 1;  ///< kf [1]
};

}  // namespace matpoint
