#pragma once

#include "material/flow_law.hpp"

namespace matpoint {

/// Parameters of clay, whose stiffness to volume follows its pressure.
struct ClayParameters {
  Real density = 0;          ///< [kg/m^3]
  Real shear_modulus = 0;    ///< G [Pa]
  Real kappa_star = 0;       ///< kappa* [1]
  Real pressure_offset = 0;  ///< pt [Pa]

  Real mu() const { return shear_modulus; }  ///< G [Pa]
  /// At rest [Pa].
  Real lambda() const { return pressure_offset / kappa_star - shear_modulus * (2.0 / 3); }
};

/// Modified Cam-Clay: F = q^2/M^2 + p (p - pc) <= 0, associated. p = pt (exp(-theta/kappa*) - 1), G is constant; the preconsolidation
/// pressure hardens with the plastic volume strain x (compression positive), pc = pc0 exp(x/(lambda* - kappa*)).
/// lambda*, kappa* are slopes of ln(volume) over ln p, lambda/(1 + e0) and kappa/(1 + e0) of the classical ones: exact in finite strain.
/// With pt > 0 it is free of stress at rest, and no tension exceeds pt. It softens on the dry side, which depends on the grid. Sources:
/// Roscoe & Burland (1968); Butterfield (1979); Borja & Tamagnini (1998).
struct CamClay : FlowLaw<CamClay, ClayParameters> {
  static constexpr auto name = "cam_clay";
  static constexpr auto summary = "Modified Cam-Clay for clays that consolidate, normally or overconsolidated (Roscoe & Burland 1968).";
  static constexpr bool flows_freely = true;

  Real critical_slope = 0;    ///< M [1]
  Real lambda_star = 0;       ///< [1]
  Real preconsolidation = 0;  ///< pc0 [Pa]

  static void declare(ParameterTable<CamClay>& table) {
    table.required("density", "kg/m^3", static_cast<Real CamClay::*>(&CamClay::density), positive(), "Mass per reference volume.");
    table.required("shear_modulus", "Pa", static_cast<Real CamClay::*>(&CamClay::shear_modulus), positive(), "Shear modulus G.");
    table.required("critical_slope", "1", &CamClay::critical_slope,
                   Constraint{"in the interval (0, 2.5)", [](Real x) { return x > 0 && x < 2.5; }},
                   "M = q/p of the critical state: 6 sin(phi)/(3 - sin(phi)) in triaxial compression.");
    const Constraint slope{"in the interval (0, 1)", [](Real x) { return x > 0 && x < 1; }};
    table.required("kappa_star", "1", static_cast<Real CamClay::*>(&CamClay::kappa_star), slope,
                   "Slope of ln(volume) over ln(p) in unloading: kappa/(1 + e0).");
    table.required("lambda_star", "1", &CamClay::lambda_star, slope, "The same in first loading: lambda/(1 + e0).");
    table.required("preconsolidation", "Pa", &CamClay::preconsolidation, positive(), "The greatest pressure it has been under, pc0.");
    table.required("pressure_offset", "Pa", static_cast<Real CamClay::*>(&CamClay::pressure_offset), positive(),
                   "Pressure pt that its stiffness at rest belongs to: K = pt/kappa_star there; a hundredth of the pressures that matter.");
  }
  void check(const Input& input, const ReadContext& context) const {
    if (!(lambda_star > kappa_star)) {
      fail_input(
          input, context,
          fmt::format("lambda_star = {} is not above kappa_star = {}: first loading is softer than unloading", lambda_star, kappa_star));
    }
  }

  template <class T>
  struct Internal {
    T plastic_volume_strain;  ///< x, compression positive
  };
  static constexpr std::array<InternalVariable, 1> internal_variables = {{{"plastic_volume_strain", "1"}}};
  static constexpr bool is_symmetric = true;
  static constexpr bool scales_deviator = true;

  template <class T>
  T mean_stress(const T& theta) const {
    return T(T(pressure_offset) - pressure_offset * exp(exponent(theta)));
  }
  template <class T>
  T volume_energy(const T& theta) const {
    return T(pressure_offset * kappa_star * expm1(exponent(theta)) + pressure_offset * theta);
  }
  template <class M, class H>
  typename M::Scalar wave_modulus(const M& /*F*/, const H& history) const {
    using T = typename M::Scalar;
    // The volume's strain from det(I + h).
    const T det = determinant(M::identity() + unpacked<M>(history.h));
    const T theta = T(0.5 * log(max(det, T(1e-30))));
    return T((T(pressure_offset / kappa_star) * exp(exponent(theta)) + T(4.0 / 3 * mu())) * (T(1.0) - min(T(0.0), theta)));
  }

  /// The history of clay that has carried `ratio` times its present load: pc = ratio (p + q^2/(M^2 p)).
  template <class M, class H>
  void consolidate(H& history, Real ratio) const {
    const M tau = this->stress_of(M::identity(), history);
    const Real p = -trace(tau) / 3;
    const M s = deviator(tau);
    if (!(p > 0)) return;
    const Real q_squared = 1.5 * contract(s, s);
    const Real pc = ratio * (p + q_squared / (critical_slope * critical_slope * p));
    history.internal.plastic_volume_strain = (lambda_star - kappa_star) * std::log(pc / preconsolidation);
  }

  template <class State, class T>
  void flow(State& p, const Internal<T>& old, Internal<T>& updated, Real /*dt*/) const {
    const Real G = mu(), M = critical_slope;
    const T theta = p.theta();
    const T q = T(p.shear() * (std::sqrt(6.0) * G));
    const T x0 = old.plastic_volume_strain;
    const T p_trial = T(-mean_stress(theta)), pc_old = hardened(x0);
    const auto is_plastic = T(q * q * (1 / (M * M)) + p_trial * (p_trial - pc_old)) > T(0.0);

    T x = T(0.0), q_new = q;
    if (any(is_plastic)) {
      const auto [strain, stress] = return_to_ellipse(theta, q, x0);
      x = select(is_plastic, strain, T(0.0));
      q_new = select(is_plastic, stress, q);
    }
    updated.plastic_volume_strain = x0 + x;
    // tau : (e* - e)
    p.dissipated = T(q_new * (q - q_new) * (1 / (3 * G)) - mean_stress(T(theta + x)) * x);
    p.set(T(theta + x), T(q_new / q));
  }

 private:
  /// The plastic volume strain of the step and q on the ellipse.
  template <class T>
  std::pair<T, T> return_to_ellipse(const T& theta, const T& q, const T& x0) const {
    const Real G = mu(), M = critical_slope;
    // The ellipse by t: p = pc w(t), q = M pc t/(1 + t^2); from its end at p = pc (wet) or p = 0 (dry) at t = 0 to the critical state at 1.
    const T at_critical = volume_strain(theta, x0, T(0.5), T(0.0), 8);
    const auto is_wet = at_critical >= T(0.0);
    const T side = select(is_wet, T(1.0), T(-1.0));
    const auto on_ellipse = [&](const T& t) {
      const T inverse = T(T(1.0) / (T(1.0) + t * t));
      return select(is_wet, inverse, T(t * t * inverse));
    };
    // The flow rule, (q* - q)(1 - t^2) = 6 G |x| t/M, has one root there.
    const auto flow_rule = [&](const T& t, const T& x) {
      const T q_y = T(M * hardened(T(x0 + x)) * t / (T(1.0) + t * t));
      return T((q - q_y) * (T(1.0) - t * t) - (6 * G / M) * side * x * t);
    };
    T x = at_critical;
    T low = T(0.0), high = T(1.0);
    T at_low = q, at_high = flow_rule(high, x);
    constexpr int k_iterations = 10;
    for (int i = 0; i < k_iterations; ++i) {
      // Illinois: the secant, with the end that stays counted half.
      const T difference = T(at_high - at_low);
      const auto is_flat = T(abs(difference)) < T(1e-30);
      T t = T(high - at_high * (high - low) / select(is_flat, T(1.0), difference));
      t = select(is_flat, high, t);
      x = volume_strain(theta, x0, on_ellipse(t), x, 2);
      const T at_t = flow_rule(t, x);
      const auto crosses = T(at_t * at_high) < T(0.0);
      low = select(crosses, high, low);
      at_low = select(crosses, at_high, T(0.5 * at_low));
      high = t;
      at_high = at_t;
    }
    // Newton's method for t and x together is regular at both ends; it carries the derivatives, too.
    T t = high;
    constexpr int k_polish = 3;
    for (int i = 0; i < k_polish; ++i) {
      const T pc = hardened(T(x0 + x)), pc_slope = T(pc * (1 / (lambda_star - kappa_star)));
      const T inverse = T(T(1.0) / (T(1.0) + t * t));
      const T w = on_ellipse(t), w_slope = T(-2.0 * side * t * inverse * inverse);
      const T ratio = T(w * pc * (1 / pressure_offset)), over = T(T(kappa_star) / (T(1.0) + ratio));
      const T r1 = T(theta + x + kappa_star * log1p(ratio));
      const T r1_x = T(T(1.0) + over * w * pc_slope * (1 / pressure_offset));
      const T r1_t = T(over * w_slope * pc * (1 / pressure_offset));
      const T q_y = T(M * pc * t * inverse);
      const T rest = T(T(1.0) - t * t);
      const T r2 = T((q - q_y) * rest - (6 * G / M) * side * x * t);
      const T r2_x = T(-M * pc_slope * t * inverse * rest - (6 * G / M) * side * t);
      const T r2_t = T(-M * pc * inverse * inverse * rest * rest - 2.0 * t * (q - q_y) - (6 * G / M) * side * x);
      const T det = T(r1_x * r2_t - r1_t * r2_x);
      x = x - (r1 * r2_t - r1_t * r2) / det;
      t = t - (r1_x * r2 - r1 * r2_x) / det;
    }
    return {x, T(M * hardened(T(x0 + x)) * t / (T(1.0) + t * t))};
  }

  /// Kept where squares of its exponential are finite.
  template <class T>
  static T limited(const T& x) {
    constexpr Real k_roundoff = k_unit_roundoff<T>;
    constexpr Real k_limit = k_roundoff > 1e-10 ? 35 : 300;
    return T(max(T(-k_limit), min(T(k_limit), x)));
  }
  /// -theta/kappa*
  template <class T>
  T exponent(const T& theta) const {
    return limited(T(theta * (-1 / kappa_star)));
  }
  /// pc at the plastic volume strain x.
  template <class T>
  T hardened(const T& x) const {
    return T(preconsolidation * exp(limited(T(x * (1 / (lambda_star - kappa_star))))));
  }
  /// The x at which p(theta + x) = w pc(x0 + x), theta + x + kappa* ln(1 + w pc/pt) = 0, by Newton's method: it rises everywhere.
  template <class T>
  T volume_strain(const T& theta, const T& x0, const T& w, const T& start, int iterations) const {
    T x = start;
    for (int i = 0; i < iterations; ++i) {
      const T ratio = T(w * hardened(T(x0 + x)) * (1 / pressure_offset));
      const T slope = T(T(1.0) + ratio / (T(1.0) + ratio) * (kappa_star / (lambda_star - kappa_star)));
      x = x - (theta + x + kappa_star * log1p(ratio)) / slope;
    }
    return x;
  }
};

}  // namespace matpoint
