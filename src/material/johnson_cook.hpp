#pragma once

#include "material/flow_law.hpp"

namespace matpoint {

/// Metals under impact: von Mises' flow at sigma_y = (A + B a^n) (1 + C ln(r/r0)) (1 - T*^m), with the plastic strain a, the rate of strain
/// r >= r0 of the step, and T* = (T - Tr)/(Tm - Tr) of the temperature T at its start. The share `taylor_quinney` of the plastic work
/// heats: rho0 cv dT = chi dD; there is no conduction. With D1 to D5 it fails: damage grows by da/eps_f,
///   eps_f = (D1 + D2 exp(D3 sigma_m/q)) (1 + D4 ln(r/r0)) (1 + D5 T*),  tension positive,
/// and at 1 it carries pressure alone. Sources: Johnson & Cook (1983, 1985).
struct JohnsonCook : FlowLaw<JohnsonCook> {
  static constexpr auto name = "johnson_cook";
  static constexpr auto summary =
      "Johnson-Cook plasticity for metals under impact, with hardening, rate, heating and failure (Johnson & Cook 1983, 1985).";

  Real A = 0;                               ///< [Pa]
  Real B = 0;                               ///< [Pa]
  Real n = 1;                               ///< [1]
  Real C = 0;                               ///< [1]
  Real m = 1;                               ///< [1]
  Real reference_rate = 1;                  ///< r0 [1/s]
  Real reference_temperature = 298;         ///< Tr [K]
  std::optional<Real> melting_temperature;  ///< Tm [K]; without it heat does not soften.
  std::optional<Real> temperature;          ///< At the start [K]; without it Tr.
  std::optional<Real> heat_capacity;        ///< cv [J/(kg K)]; without it nothing is heated.
  Real taylor_quinney = 0.9;                ///< chi [1]
  std::optional<Real> D1, D2, D3, D4, D5;   ///< [1]; without any it does not fail.

  static void declare(ParameterTable<JohnsonCook>& table) {
    declare_elastic(table);
    table.required("A", "Pa", &JohnsonCook::A, positive(), "Yield stress at the reference rate and temperature.");
    table.optional("B", "Pa", &JohnsonCook::B, non_negative(), "Hardening, B a^n at the plastic strain a.");
    table.optional("n", "1", &JohnsonCook::n, Constraint{"in the interval (0, 1]", [](Real x) { return x > 0 && x <= 1; }},
                   "Exponent of the hardening.");
    table.optional("C", "1", &JohnsonCook::C, Constraint{"in the interval [0, 1)", [](Real x) { return x >= 0 && x < 1; }},
                   "Strengthening by the rate of strain.");
    table.optional("m", "1", &JohnsonCook::m, positive(), "Exponent of the softening by heat.");
    table.optional("reference_rate", "1/s", &JohnsonCook::reference_rate, positive(), "Rate at which A and B were measured.");
    table.optional("reference_temperature", "K", &JohnsonCook::reference_temperature, non_negative(),
                   "Temperature at which A and B were measured.");
    table.optional("melting_temperature", "K", &JohnsonCook::melting_temperature, positive(),
                   "Where its strength ends; without it heat does not soften.");
    table.optional("temperature", "K", &JohnsonCook::temperature, non_negative(), "At the start; default: reference_temperature.");
    table.optional("heat_capacity", "J/(kg K)", &JohnsonCook::heat_capacity, positive(), "Without it plastic work does not heat.");
    table.optional("taylor_quinney", "1", &JohnsonCook::taylor_quinney, between_closed(0, 1), "Share of the plastic work that heats.");
    const Constraint any = any_number();
    table.optional("D1", "1", &JohnsonCook::D1, non_negative(),
                   "Failure: strain at failure without the terms of D2; with D1 = 0 only those.");
    table.optional("D2", "1", &JohnsonCook::D2, non_negative(), "Failure: factor of exp(D3 sigma_m/q).");
    table.optional("D3", "1", &JohnsonCook::D3, Constraint{"at most 0", [](Real x) { return x <= 0; }},
                   "Failure: tension, which is positive here, makes brittle; some papers write this number without its sign.");
    table.optional("D4", "1", &JohnsonCook::D4, any, "Failure: by the rate of strain.");
    table.optional("D5", "1", &JohnsonCook::D5, non_negative(), "Failure: by heat.");
  }
  void check(const Input& input, const ReadContext& context) const {
    if (melting_temperature && *melting_temperature <= reference_temperature) {
      fail_input(
          input, context,
          fmt::format("melting_temperature = {} is not above reference_temperature = {}", *melting_temperature, reference_temperature));
    }
    if (temperature && melting_temperature && *temperature >= *melting_temperature)
      fail_input(input, context, fmt::format("temperature = {}: it has melted at {}", *temperature, *melting_temperature));
    if (fails() && !(D1.value_or(0) + D2.value_or(0) > 0))
      fail_input(input, context, "D1 and D2 are both 0: it would fail at once; give one of them, or none of D1 to D5");
  }
  bool fails() const { return D1 || D2 || D3 || D4 || D5; }
  Real start_temperature() const { return temperature.value_or(reference_temperature); }

  template <class T>
  struct Internal {
    T plastic_strain;
    T temperature_rise;
    T damage;
    T gap;  ///< Of what has failed.
  };
  std::array<InternalVariable, 4> variables() const {
    return {{{"plastic_strain", "1"}, {"temperature", "K", start_temperature()}, {"damage", "1"}, {"gap", "1"}}};
  }

  static constexpr bool scales_deviator = true;
  static constexpr bool needs_rate = true;

  template <class State, class T>
  void flow(State& p, const Internal<T>& old, Internal<T>& updated, Real dt) const {
    const Real K = bulk_modulus(), G = mu(), G3 = 3 * G;
    const T a = old.plastic_strain;
    const T log_rate = dt > 0 && (C > 0 || D4) ? T(log(max(T(1.0), T(p.rate * (1 / reference_rate))))) : T(0.0);
    T heat = T(0.0);
    if (melting_temperature) {
      const Real range = 1 / (*melting_temperature - reference_temperature);
      heat = min(T(1.0), max(T(0.0), T((old.temperature_rise + T(start_temperature() - reference_temperature)) * range)));
    }
    const T softened = any(heat > T(0.0)) ? T(T(1.0) - raised(heat, m)) : T(1.0);
    const T strength = T(T(T(1.0) + C * log_rate) * softened);

    const T q = T(p.shear() * (std::sqrt(6.0) * G));
    const T yield = T(strength * T(T(A) + B * raised(a, n)));
    const auto is_plastic = q > yield;
    // Where no lane yields there is nothing to solve.
    const T x = any(is_plastic) ? plastic_step(q, yield, strength, a) : T(0.0);
    const T q_new = select(is_plastic, T(q - G3 * x), q);
    T scale = T(q_new / q);
    updated.plastic_strain = a + x;
    p.dissipated = q_new * x;
    updated.temperature_rise = old.temperature_rise;
    if (heat_capacity)
      updated.temperature_rise = updated.temperature_rise + p.dissipated * (taylor_quinney / (this->density * *heat_capacity));
    updated.damage = old.damage;
    updated.gap = old.gap;
    T theta = p.theta();
    if (fails()) {
      const T triaxiality = T(K * theta / max(q_new, T(1e-9 * A)));
      const T by_pressure = T(T(D1.value_or(0)) + D2.value_or(0) * exp(T(D3.value_or(0) * max(T(-50.0), min(T(1.5), triaxiality)))));
      const T by_rate = T(T(1.0) + D4.value_or(0) * log_rate);
      const T at_failure = T(by_pressure * by_rate * T(T(1.0) + D5.value_or(0) * heat));
      updated.damage = min(T(1.0), T(old.damage + x / max(at_failure, T(1e-6))));
      // What has failed carries pressure alone, and closes before it presses: only that has a gap that closes. What it had stored is lost
      // in the step in which it fails.
      const auto had_failed = old.damage > T(1 - 1e-6);
      const auto has_failed = updated.damage > T(1 - 1e-6);
      const T stored = T(0.5 * K * theta * theta + q_new * q_new * (1 / (6 * G)));
      const T left = p.close(old.gap);
      const T pressed = min(T(0.0), p.theta());
      updated.gap = select(has_failed, T(left + (p.theta() - pressed)), T(0.0));
      theta = select(has_failed, pressed, theta);
      scale = select(has_failed, T(0.0), scale);
      updated.plastic_strain = select(had_failed, a, updated.plastic_strain);
      updated.temperature_rise = select(had_failed, old.temperature_rise, updated.temperature_rise);
      const T lost = T(p.dissipated + stored - 0.5 * K * pressed * pressed);
      p.dissipated = select(had_failed, T(0.0), select(has_failed, lost, p.dissipated));
    }
    p.set(theta, scale);
  }

 private:
  /// x^exponent, 0 at 0.
  template <class T>
  static T raised(const T& x, Real exponent) {
    return select(x > T(0.0), T(exp(T(exponent * log(max(x, T(1e-30)))))), T(0.0));
  }
  /// q - 3 G x = S (A + B (a + x)^n) for x. a^n has an infinite slope at 0; in y = (a + x)^n the equation is concave and falling, so that
  /// Newton's method comes down to its root from above without overshoot.
  template <class T>
  T plastic_step(const T& q, const T& yield, const T& strength, const T& a) const {
    const Real G3 = 3 * mu();
    const T tiny = T(1e-30);
    const auto is_plastic = q > yield;
    const T driven = select(is_plastic, q, T(2.0 * yield + T(A)));
    const T no_hardening = T((driven - yield) * (1 / G3));
    if (B == 0) return select(is_plastic, no_hardening, T(0.0));
    const T SB = T(strength * B);
    T y = T(exp(T(n * log(max(T(a + no_hardening), tiny)))));
    y = min(y, T((driven - strength * A) / max(SB, T(1e-9 * B))));
    constexpr int k_iterations = 5;
    for (int i = 0; i < k_iterations; ++i) {
      y = max(y, tiny);
      const T total = T(exp(T((1 / n) * log(y))));
      y = T(y + (driven - G3 * (total - a) - strength * (T(A) + B * y)) / (G3 / n * total / y + SB));
    }
    T x = T(max(T(0.0), T(exp(T((1 / n) * log(max(y, tiny)))) - a)));
    // Once more in x, which keeps its digits where it is small beside a.
    const T total = T(max(T(a + x), tiny));
    const T hardened = T(SB * exp(T(n * log(total))));
    x = T(x + (driven - G3 * x - strength * A - hardened) / (T(G3) + n * hardened / total));
    return select(is_plastic, T(max(x, T(0.0))), T(0.0));
  }
};

}  // namespace matpoint
