#pragma once

#include <limits>

#include "material/granular.hpp"

namespace matpoint {

/// Soils and grains on a cone: sqrt(J2) + eta sigma_m <= xi c, flow with eta_b for eta; it parts at the apex.
///   fit = "compression", "extension": eta = 6 sin phi/(sqrt3 (3 -+ sin phi)), xi = 6 cos phi/(the same): Mohr-Coulomb's strength there.
///   fit = "plane": eta = sin phi/d, xi = cos phi/d, d = sqrt(1 - eta_b^2/3) + (eta_b/3) sin phi, eta_b = 3 tan psi/sqrt(9 + 12 tan^2 psi):
///     its strength in plane strain, for every dilatancy. (The plane cone of textbooks is that of psi = phi.)
/// The three differ by a factor of two in plane strain. Sources: Drucker & Prager (1952); de Souza Neto, Peric & Owen (2008), sec. 8.3.
struct DruckerPrager : GranularLaw<DruckerPrager> {
  static constexpr auto name = "drucker_prager";
  static constexpr auto summary =
      "Drucker-Prager plasticity for soils and grains, with the cone fitted to Mohr-Coulomb's (Drucker & Prager 1952).";

  enum class Fit { by_dimension, compression, extension, plane };
  Fit fit = Fit::by_dimension;

  static void declare(ParameterTable<DruckerPrager>& table) {
    declare_strength(table);
    table.choice(
        "fit", &DruckerPrager::fit,
        {{"by_dimension", Fit::by_dimension}, {"compression", Fit::compression}, {"extension", Fit::extension}, {"plane", Fit::plane}},
        "Where it has Mohr-Coulomb's strength: in triaxial compression or extension, or in plane strain. by_dimension: plane in 2D, "
        "compression in 3D and around an axis.");
  }
  void check(const Input& input, const ReadContext& context) {
    fit_ = fit != Fit::by_dimension ? fit : context.dim == 2 ? Fit::plane : Fit::compression;
    GranularLaw::check(input, context);
  }

  /// eta, eta_b, xi c.
  std::array<Real, 3> strength_of(Real c, Real phi, Real psi) const {
    const Real sin_phi = std::sin(radians(phi)), cos_phi = std::cos(radians(phi));
    if (fit_ == Fit::plane) {
      const Real t = std::tan(radians(psi));
      const Real eta_b = 3 * t / std::sqrt(9 + 12 * t * t);
      const Real d = std::sqrt(1 - eta_b * eta_b / 3) + eta_b / 3 * sin_phi;
      return {sin_phi / d, eta_b, cos_phi / d * c};
    }
    const Real sign = fit_ == Fit::compression ? -1 : 1;
    const Real d = std::sqrt(3.0) * (3 + sign * sin_phi);
    const Real sin_psi = std::sin(radians(psi));
    return {6 * sin_phi / d, 6 * sin_psi / (std::sqrt(3.0) * (3 + sign * sin_psi)), 6 * cos_phi / d * c};
  }
  template <class S>
  S apex(const std::array<S, 3>& strength) const {
    return apex_of(strength[0], strength[2]);
  }
  Real softening_limit() const {
    const auto [eta, eta_b, xi_c] = residual();
    const Real lost = peak()[2] - xi_c;
    return lost > 0 ? (mu() + bulk_modulus() * eta * eta_b) / lost : std::numeric_limits<Real>::infinity();
  }

  static constexpr bool scales_deviator = true;

  template <class S, class State, class T>
  void flow_with(const std::array<S, 3>& strength, State& p, const Internal<T>& old, Internal<T>& updated) const {
    const auto& [eta, eta_b, xi_c] = strength;
    const S apex = S(min(this->apex(strength), S(greatest_tension())));
    const Real K = bulk_modulus(), G = mu();
    T gap = p.close(old.gap);
    const T theta = p.theta();
    const T m = T(K * theta);
    const T r = T(p.shear() * (std::sqrt(2.0) * G));
    const T flow = T(max(T(0.0), T(r + eta * m - T(xi_c))) * S(S(1.0) / S(G + K * eta * eta_b)));
    const T on_cone_r = T(r - G * flow);
    const T on_cone_m = T(m - S(K * eta_b) * flow);
    const auto is_parting = (on_cone_m > T(apex)) | (on_cone_r < T(0.0));
    const T new_m = select(is_parting, T(apex), on_cone_m);
    const T new_r = select(is_parting, T(min(r, T(max(T(0.0), T(xi_c - eta * apex))))), on_cone_r);
    const T new_theta = T(new_m * (1 / K));
    gap = gap + select(is_parting, T(theta - new_theta), T(0.0));
    p.set(new_theta, T(new_r / r));
    updated.plastic_strain = old.plastic_strain + (r - new_r) * (1 / (std::sqrt(3.0) * G));
    updated.gap = gap;
    p.dissipated = T(new_m * (theta - new_theta) + new_r * (r - new_r) * (1 / G));
  }

 private:
  Fit fit_ = Fit::plane;  ///< Of the dimension, where the case leaves it to that.
};

}  // namespace matpoint
