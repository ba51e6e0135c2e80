// What soils and grains share: strength in degrees and pascals, its loss with slip, and the checks of both.
#pragma once

#include <optional>

#include "material/flow_law.hpp"

namespace matpoint {

/// Cohesion, friction and dilatancy. Stresses of Kirchhoff's tau.
///
/// Where it softens, the coefficients of strength go linearly from their peak to their residual values with the share that is left,
///   w = max(0, 1 - a/a_r),   a_r = slip/(sqrt3 h),
/// a the plastic strain: a band that is one cell h wide has lost its strength when its sides have slipped by `softening_slip`, whatever h
/// is. So the work of a slip surface per area does not depend on the grid (Bazant & Oh (1983) for cracks; Rots et al. (1985)).
///
/// A law gives how it flows with given coefficients, and what these are of:
///
///   std::array<Real, 3> strength_of(Real cohesion, Real friction_angle, Real dilatancy_angle) const;
///   template <class S, class State, class T>                            // S is Real, or a number of each point
///   void flow_with(const std::array<S, 3>& strength, State& p, const Internal<T>& old, Internal<T>& updated) const;
///   template <class S> S apex(const std::array<S, 3>& strength) const;  // mean stress where they end
///   Real softening_limit() const;                                       // the greatest h/slip that does not snap back without pressure
template <class Law>
struct GranularLaw : PartingLaw<Law> {
  template <class T>
  using Internal = typename PartingLaw<Law>::template Internal<T>;

  Real cohesion = 0;                             ///< c [Pa]
  Real friction_angle = 0;                       ///< phi [deg]
  Real dilatancy_angle = 0;                      ///< psi [deg]
  std::optional<Real> tension_cutoff;            ///< Greatest mean stress [Pa]; without it that of the cone's apex.
  std::optional<Real> residual_cohesion;         ///< [Pa]
  std::optional<Real> residual_friction_angle;   ///< [deg]
  std::optional<Real> residual_dilatancy_angle;  ///< [deg]
  std::optional<Real> softening_slip;            ///< [m]
  std::optional<Real> length;                    ///< h [m]

  static void declare_strength(ParameterTable<Law>& table) {
    PartingLaw<Law>::declare_elastic(table);
    table.required("cohesion", "Pa", static_cast<Real Law::*>(&Law::cohesion), non_negative(),
                   "Shear strength without pressure; 0 for dry sand.");
    table.required("friction_angle", "deg", static_cast<Real Law::*>(&Law::friction_angle),
                   Constraint{"in the interval [0, 60)", [](Real x) { return x >= 0 && x < 60; }}, "Angle of internal friction.");
    table.optional("dilatancy_angle", "deg", static_cast<Real Law::*>(&Law::dilatancy_angle),
                   Constraint{"in the interval [0, friction_angle]", [](Real x) { return x >= 0 && x < 60; }},
                   "0: what flows keeps its volume. More than that dilates for ever, and under a fixed volume builds up pressure.");
    table.optional("tension_cutoff", "Pa", static_cast<std::optional<Real> Law::*>(&Law::tension_cutoff), non_negative(),
                   "Greatest tension, as a mean stress, at which the material parts; default: where the strength of the cone ends.");
    table.optional("residual_cohesion", "Pa", static_cast<std::optional<Real> Law::*>(&Law::residual_cohesion), non_negative(),
                   "Cohesion that is left after softening_slip, at most cohesion; default: all of it.");
    table.optional("residual_friction_angle", "deg", static_cast<std::optional<Real> Law::*>(&Law::residual_friction_angle),
                   Constraint{"in the interval [0, 60)", [](Real x) { return x >= 0 && x < 60; }},
                   "Friction that is left after softening_slip, at most friction_angle; default: all of it.");
    table.optional("residual_dilatancy_angle", "deg", static_cast<std::optional<Real> Law::*>(&Law::residual_dilatancy_angle),
                   Constraint{"in the interval [0, 60)", [](Real x) { return x >= 0 && x < 60; }},
                   "Dilatancy that is left after softening_slip, at most dilatancy_angle; 0 for a critical state; default: all of it, or "
                   "what residual_friction_angle allows.");
    table.optional("softening_slip", "m", static_cast<std::optional<Real> Law::*>(&Law::softening_slip), positive(),
                   "Slip across a band of one cell after which strength is residual.");
    table.optional(
        "length", "m", static_cast<std::optional<Real> Law::*>(&Law::length), positive(),
        "Width of the band where strength softens; default: the cell size, on B-splines three times that with `apic`, twice with `tpic`.");
  }
  void check(const Input& input, const ReadContext& context) {
    if (dilatancy_angle > friction_angle) {
      fail_input(input, context,
                 fmt::format("dilatancy_angle = {} is above friction_angle = {}: it would make energy; allowed: 0 to friction_angle",
                             dilatancy_angle, friction_angle));
    }
    const Real c = residual_cohesion.value_or(cohesion), phi = residual_friction_angle.value_or(friction_angle);
    const Real psi = residual_dilatancy_angle.value_or(std::min(dilatancy_angle, phi));
    const auto refuse_above = [&](const char* name, Real value, const char* limit, Real greatest) {
      if (value <= greatest) return;
      fail_input(input, context, fmt::format("residual_{} = {} is above {} = {}; allowed: 0 to {}", name, value, limit, greatest, limit));
    };
    refuse_above("cohesion", c, "cohesion", cohesion);
    refuse_above("friction_angle", phi, "friction_angle", friction_angle);
    refuse_above("dilatancy_angle", psi, "dilatancy_angle", dilatancy_angle);
    refuse_above("dilatancy_angle", psi, "the residual friction angle", phi);
    const bool softens = c < cohesion || phi < friction_angle || psi < dilatancy_angle;
    if (softens && !softening_slip)
      fail_input(input, context, "residual strength needs softening_slip [m], the slip after which it is reached; allowed: > 0");
    if (!softens && softening_slip) {
      fail_input(input, context,
                 fmt::format("softening_slip = {} has nothing to soften; allowed: with residual_cohesion, residual_friction_angle or "
                             "residual_dilatancy_angle below the peak values",
                             *softening_slip));
    }
    peak_ = law().strength_of(cohesion, friction_angle, dilatancy_angle);
    residual_ = law().strength_of(c, phi, psi);
    greatest_tension_ = std::min(tension_cutoff.value_or(no_limit()), law().apex(peak_));
    softening_strain_ = softens && length ? *softening_slip / (std::sqrt(3.0) * *length) : 0;
    if (softening_strain_ == 0) return;
    const Real greatest = *softening_slip * law().softening_limit();
    if (*length >= greatest) {
      fail_input(input, context,
                 fmt::format("length = {:.6g} stores more energy than softening takes (it would snap back); allowed: below {:.6g}: use smaller "
                             "cells or a longer softening_slip",
                             *length, greatest));
    }
  }
  /// Whether the strength depends on the width of a band, which is the cell size where none is given.
  bool needs_length() const { return softening_slip && !length; }

  template <class State, class T>
  void flow(State& p, const Internal<T>& old, Internal<T>& updated, Real /*dt*/) const {
    if (softening_strain_ == 0) {
      law().flow_with(peak_, p, old, updated);
    } else {
      law().flow_with(strength_at(share_after(p, old)), p, old, updated);
    }
  }

 protected:
  auto& peak() const { return peak_; }
  auto& residual() const { return residual_; }
  /// Of the peak, [Pa]: the apex of a cone that loses friction wanders off, but nothing holds more tension for having slipped.
  Real greatest_tension() const { return greatest_tension_; }
  static Real radians(Real degrees) { return degrees * (3.14159265358979323846 / 180); }
  /// For a cone without an apex [Pa].
  Real no_limit() const { return 1e6 * this->youngs_modulus; }
  /// Where the strength of a cone ends, slope sigma_m <= cohesive [Pa]; without friction it does not.
  template <class S>
  S apex_of(const S& slope, const S& cohesive) const {
    const S most = S(no_limit());
    return select(slope > S(0.0), S(min(most, S(cohesive / S(max(slope, S(1e-30)))))), most);
  }

 private:
  /// Coefficients of friction, dilatancy and cohesion.
  template <class S>
  using Strength = std::array<S, 3>;

  const Law& law() const { return static_cast<const Law&>(*this); }

  template <class T>
  Strength<T> strength_at(const T& share) const {
    Strength<T> strength;
    for (std::size_t i = 0; i < strength.size(); ++i) strength[i] = T(residual_[i] + share * (peak_[i] - residual_[i]));
    return strength;
  }
  template <class T>
  T share_at(const T& plastic_strain) const {
    return T(max(T(0.0), T(T(1.0) - plastic_strain * (1 / softening_strain_))));
  }
  /// The share at the end of the step: that whose flow leads to itself. More strength flows less and keeps more, so the root lies between
  /// nothing and the share at the start, and both ends are on its two sides. (Illinois' regula falsi: Dowell & Jarratt (1971).)
  template <class State, class T>
  T share_after(const State& start, const Internal<T>& old) const {
    constexpr int k_tries = 4;
    const auto miss_of = [&](const T& share) {
      State p = start;
      Internal<T> updated = old;
      law().flow_with(strength_at(share), p, old, updated);
      return T(share - share_at(updated.plastic_strain));
    };
    T low = T(0.0), high = share_at(old.plastic_strain);
    T low_miss = miss_of(low), high_miss = miss_of(high);
    // Ends that are nearer than this differ by rounding, and so would the derivative of what lies between.
    const T near = T(std::sqrt(k_unit_roundoff<T>));
    T last = T(0.0), next = high;
    for (int i = 0;; ++i) {
      const T between = T(high - high_miss * (high - low) / T(max(T(1e-30), T(high_miss - low_miss))));
      next = select(high - low > near, between, next);
      if (i == k_tries) return next;
      const T miss = miss_of(next);
      const auto is_high = miss > T(0.0);
      // The end that stays twice counts half.
      const T low_share = select(last > T(0.0), T(0.5), T(1.0)), high_share = select(last < T(0.0), T(0.5), T(1.0));
      low = select(is_high, low, next);
      low_miss = select(is_high, T(low_miss * low_share), miss);
      high = select(is_high, next, high);
      high_miss = select(is_high, miss, T(high_miss * high_share));
      last = select(is_high, T(1.0), T(-1.0));
    }
  }

  Strength<Real> peak_{}, residual_{};
  Real greatest_tension_ = 0;  ///< [Pa]
  Real softening_strain_ = 0;  ///< a_r [1]; 0: keeps its strength, or has no length yet.
};

}  // namespace matpoint
