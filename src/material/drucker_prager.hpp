#pragma once

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
        "compression in 3D.");
  }
  void check(const Input& input, const ReadContext& context) {
    GranularLaw::check(input, context);
    const Real s = std::sin(radians(friction_angle)), c = std::cos(radians(friction_angle));
    const Real s_b = std::sin(radians(dilatancy_angle)), t_b = std::tan(radians(dilatancy_angle));
    const Fit where = fit != Fit::by_dimension ? fit : context.dim == 2 ? Fit::plane : Fit::compression;
    if (where == Fit::plane) {
      eta_b_ = 3 * t_b / std::sqrt(9 + 12 * t_b * t_b);
      const Real d = std::sqrt(1 - eta_b_ * eta_b_ / 3) + eta_b_ / 3 * s;
      eta_ = s / d;
      xi_c_ = c / d * cohesion;
    } else {
      const Real sign = where == Fit::compression ? -1 : 1;
      const Real d = std::sqrt(3.0) * (3 + sign * s);
      eta_ = 6 * s / d;
      xi_c_ = 6 * c / d * cohesion;
      eta_b_ = 6 * s_b / (std::sqrt(3.0) * (3 + sign * s_b));
    }
    apex_ = eta_ > 0 ? xi_c_ / eta_ : no_limit();
    if (tension_cutoff) apex_ = std::min(apex_, *tension_cutoff);
  }

  static constexpr bool scales_deviator = true;

  template <class State, class T>
  void flow(State& p, const Internal<T>& old, Internal<T>& updated, Real /*dt*/) const {
    const Real K = bulk_modulus(), G = mu();
    T gap = p.close(old.gap);
    const T theta = p.theta();
    const T m = T(K * theta);
    const T r = T(p.shear() * (std::sqrt(2.0) * G));
    const T flow = T(max(T(0.0), T(r + eta_ * m - T(xi_c_))) * (1 / (G + K * eta_ * eta_b_)));
    const T on_cone_r = T(r - G * flow);
    const T on_cone_m = T(m - (K * eta_b_) * flow);
    const auto is_parting = (on_cone_m > T(apex_)) | (on_cone_r < T(0.0));
    const T new_m = select(is_parting, T(apex_), on_cone_m);
    const T new_r = select(is_parting, T(min(r, T(std::max(xi_c_ - eta_ * apex_, Real{0})))), on_cone_r);
    const T new_theta = T(new_m * (1 / K));
    gap = gap + select(is_parting, T(theta - new_theta), T(0.0));
    p.set(new_theta, T(new_r / r));
    updated.plastic_strain = old.plastic_strain + (r - new_r) * (1 / (std::sqrt(3.0) * G));
    updated.gap = gap;
    p.dissipated = T(new_m * (theta - new_theta) + new_r * (r - new_r) * (1 / G));
  }

 private:
  Real eta_ = 0, eta_b_ = 0;
  Real xi_c_ = 0;  ///< [Pa]
  Real apex_ = 0;  ///< [Pa]
};

}  // namespace matpoint
