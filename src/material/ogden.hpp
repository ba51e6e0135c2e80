#pragma once

#include "material/rubber.hpp"
#include "material/spectral.hpp"

namespace matpoint {

/// Ogden: W_iso = sum mu_p/alpha_p (sum l_i^alpha_p - 3) of the stretches l_i at constant volume; the shear modulus at small strains is
/// sum mu_p alpha_p/2. Source: Ogden (1972).
struct Ogden : RubberLaw<Ogden> {
  static constexpr auto name = "ogden";
  static constexpr auto summary = "Compressible Ogden solid with up to three terms, for rubber to great stretches (Ogden 1972).";

  Real mu_1 = 0, mu_2 = 0, mu_3 = 0;            ///< [Pa]
  Real alpha_1 = 2, alpha_2 = -2, alpha_3 = 1;  ///< [1]

  static void declare(ParameterTable<Ogden>& table) {
    declare_volume(table);
    const Constraint exponent{"any number but 0", [](Real x) { return std::isfinite(x) && x != 0; }};
    const Constraint factor{"of the sign of its alpha", [](Real x) { return std::isfinite(x); }};
    table.required("mu_1", "Pa", &Ogden::mu_1, factor, "Factor of the first term.");
    table.required("alpha_1", "1", &Ogden::alpha_1, exponent, "Exponent of the first term.");
    table.optional("mu_2", "Pa", &Ogden::mu_2, factor, "Of the second term; 0: there is none.");
    table.optional("alpha_2", "1", &Ogden::alpha_2, exponent, "Of the second term.");
    table.optional("mu_3", "Pa", &Ogden::mu_3, factor, "Of the third term; 0: there is none.");
    table.optional("alpha_3", "1", &Ogden::alpha_3, exponent, "Of the third term.");
  }
  void check(const Input& input, const ReadContext& context) const {
    const std::array<std::pair<Real, Real>, 3> terms = {{{mu_1, alpha_1}, {mu_2, alpha_2}, {mu_3, alpha_3}}};
    for (std::size_t p = 0; p < 3; ++p) {
      if (terms[p].first * terms[p].second >= 0) continue;
      fail_input(input, context,
                 fmt::format("mu_{0} = {1} and alpha_{0} = {2} have not the same sign: that term would pull it apart; allowed: mu_{0} "
                             "alpha_{0} > 0",
                             p + 1, terms[p].first, terms[p].second));
    }
    if (mu_1 == 0 && mu_2 == 0 && mu_3 == 0) fail_input(input, context, "mu_1, mu_2 and mu_3 are all 0: it has no shear modulus");
  }

  template <class M>
  M kirchhoff_stress(const M& F) const {
    using T = typename M::Scalar;
    const M shear = isotropic(left_cauchy_green_minus_identity(F), [this](const auto* e) {
      using U = std::remove_cvref_t<decltype(*e)>;
      std::array<U, 3> tau = {U(0.0), U(0.0), U(0.0)};
      for_terms([&](Real mu, Real alpha) {
        const std::array<U, 3> powers = powers_minus_1(e, alpha);
        const U mean = U((powers[0] + powers[1] + powers[2]) * (1.0 / 3));
        for (std::size_t i = 0; i < 3; ++i) tau[i] = U(tau[i] + mu * U(powers[i] - mean));
      });
      return tau;
    });
    return shear + M::diagonal(T(this->volume_stress(T(determinant(F)))));
  }
  template <class M>
  typename M::Scalar energy_density(const M& F) const {
    using T = typename M::Scalar;
    const M energies = isotropic(left_cauchy_green_minus_identity(F), [this](const auto* e) {
      using U = std::remove_cvref_t<decltype(*e)>;
      std::array<U, 3> W = {U(0.0), U(0.0), U(0.0)};
      for_terms([&](Real mu, Real alpha) {
        const std::array<U, 3> powers = powers_minus_1(e, alpha);
        for (std::size_t i = 0; i < 3; ++i) W[i] = U(W[i] + (mu / alpha) * powers[i]);
      });
      return W;
    });
    return T(trace(energies) + this->volume_energy(T(determinant(F))));
  }
  /// Of plane waves along a uniaxial stretch J, where tau_xx = sum mu_p 2/3 (J^(2 alpha/3) - J^(-alpha/3)) + K/2 (J^2 - 1).
  Real wave_speed(Real J) const {
    Real slope = 0.5 * this->bulk_modulus * (1 + 1 / (J * J));
    for_terms([&](Real mu, Real alpha) {
      const Real a = std::pow(J, 2 * alpha / 3), b = std::pow(J, -alpha / 3);
      slope += mu * (2.0 / 3) * ((2 * alpha / 3 - 1) * a + (alpha / 3 + 1) * b) / (J * J);
    });
    return J * std::sqrt(std::max(slope, Real{0}) / this->density);
  }
  template <class M, class H>
  typename M::Scalar wave_modulus(const M& F, const H& /*history*/) const {
    using T = typename M::Scalar;
    const T J = determinant(F);
    const T log_l = T(0.5 * log(greatest_square(T(power(J, -2.0 / 3) * trace(M(F * transpose(F)))))));
    T modulus = this->volume_modulus(J);
    // The least stretch is at least the inverse square of the greatest one.
    for_terms([&](Real mu, Real alpha) { modulus = T(modulus + mu * alpha * exp(T((alpha > 0 ? alpha : -2 * alpha) * log_l))); });
    return modulus;
  }

 private:
  template <class F>
  void for_terms(F&& f) const {
    if (mu_1 != 0) f(mu_1, alpha_1);
    if (mu_2 != 0) f(mu_2, alpha_2);
    if (mu_3 != 0) f(mu_3, alpha_3);
  }
  /// (J^(-1/3) l_i)^alpha - 1
  template <class U>
  static std::array<U, 3> powers_minus_1(const U* e, Real alpha) {
    const U mean = U((e[0] + e[1] + e[2]) * (1.0 / 3));
    return {U(expm1(U(alpha * U(e[0] - mean)))), U(expm1(U(alpha * U(e[1] - mean)))), U(expm1(U(alpha * U(e[2] - mean))))};
  }
};

}  // namespace matpoint
