#pragma once

#include <limits>

#include "material/granular.hpp"

namespace matpoint {

/// Soils and grains: (t1 - t3) + (t1 + t3) sin phi <= 2 c cos phi with the principal stresses t1 >= t2 >= t3 of tau, flow with psi for phi;
/// exact edges and apex, where it parts. With the linear logarithmic law each projection is a closed formula.
/// friction_angle = 0 is Tresca. Sources: Coulomb (1776); de Souza Neto, Peric & Owen (2008), sec. 8.2.
struct MohrCoulomb : GranularLaw<MohrCoulomb> {
  static constexpr auto name = "mohr_coulomb";
  static constexpr auto summary =
      "Mohr-Coulomb plasticity for soils and grains with exact edges (Souza Neto, Peric & Owen 2008, sec. 8.2); Tresca's without friction.";

  static void declare(ParameterTable<MohrCoulomb>& table) { declare_strength(table); }

  /// sin phi, sin psi, 2 c cos phi.
  std::array<Real, 3> strength_of(Real c, Real phi, Real psi) const {
    return {std::sin(radians(phi)), std::sin(radians(psi)), 2 * c * std::cos(radians(phi))};
  }
  template <class S>
  S apex(const std::array<S, 3>& strength) const {
    return apex_of(S(2.0 * strength[0]), strength[2]);
  }
  Real softening_limit() const {
    const auto [s, s_b, two_c] = residual();
    const Real lost = peak()[2] - two_c;
    const Real A = 4 * lambda() * s * s_b + 4 * mu() * (1 + s * s_b);
    return lost > 0 ? A / (lost * std::sqrt(4 + 4.0 / 3 * s_b * s_b)) : std::numeric_limits<Real>::infinity();
  }

  template <class S, class State, class T>
  void flow_with(const std::array<S, 3>& strength, State& p, const Internal<T>& old, Internal<T>& updated) const {
    const auto& [s, s_b, two_c] = strength;
    const S apex = this->apex(strength);
    const S cutoff = S(min(apex, S(greatest_tension())));
    const Real G = mu(), la = lambda();
    T gap = p.close(old.gap);
    const std::array<T, 3> before = {p.e[0], p.e[1], p.e[2]};
    // t1 >= t2 >= t3, by three exchanges, which are undone at the end: with equal strains, too, each keeps its own.
    const auto keeps_01 = exchange(p.e[0], p.e[1]);
    const auto keeps_12 = exchange(p.e[1], p.e[2]);
    const auto keeps_again = exchange(p.e[0], p.e[1]);
    const T theta = p.theta();
    const T t1 = T(la * theta + 2 * G * p.e[0]), t2 = T(la * theta + 2 * G * p.e[1]), t3 = T(la * theta + 2 * G * p.e[2]);

    const T none = T(0.0);
    const auto above = [&](const T& high, const T& low) { return T((high - low) + s * (high + low) - T(two_c)); };
    const T F13 = T(max(none, above(t1, t3)));
    // One plane: t - C b F/(a . C b), with b = (1 + s_b, 0, s_b - 1).
    const S one = S(1.0);
    const S across = S(2 * la * s_b);
    const S up = S(across + 2 * G * (one + s_b)), down = S(across - 2 * G * (one - s_b));
    const S traces = S(4 * la * s * s_b);
    const S A = S(traces + 2 * G * ((one + s) * (one + s_b) + (one - s) * (one - s_b)));
    const T l = T(F13 * S(one / A));
    const T one1 = T(t1 - up * l), one2 = T(t2 - across * l), one3 = T(t3 - down * l);
    // t1 = t2, triaxial compression: planes 13 and 23.
    const S B_c = S(traces + 2 * G * (one - s) * (one - s_b));
    const S inverse_c = S(one / S(A * A - B_c * B_c));
    const T F23 = above(t2, t3);
    const T c1 = T((A * F13 - B_c * F23) * inverse_c);
    const T c2 = T((A * F23 - B_c * F13) * inverse_c);
    const T com1 = T(t1 - up * c1 - across * c2), com2 = T(t2 - across * c1 - up * c2), com3 = T(t3 - down * (c1 + c2));
    // t2 = t3, extension: planes 13 and 12.
    const S B_e = S(traces + 2 * G * (one + s) * (one + s_b));
    const S inverse_e = S(one / S(A * A - B_e * B_e));
    const T F12 = above(t1, t2);
    const T e1 = T((A * F13 - B_e * F12) * inverse_e);
    const T e2 = T((A * F12 - B_e * F13) * inverse_e);
    const T ext1 = T(t1 - up * (e1 + e2)), ext2 = T(t2 - across * e1 - down * e2), ext3 = T(t3 - down * e1 - across * e2);

    const auto is_compression = one2 > one1;
    const auto is_extension = one3 > one2;
    T r1 = select(is_compression, com1, select(is_extension, ext1, one1));
    T r2 = select(is_compression, com2, select(is_extension, ext2, one2));
    T r3 = select(is_compression, com3, select(is_extension, ext3, one3));
    const T slack = T((64 * k_unit_roundoff<T>) * (abs(t1) + abs(t2) + abs(t3)));
    const T mean = T((r1 + r2 + r3) * (1.0 / 3));
    const auto is_apex = (mean > T(apex)) | (r2 > r1 + slack) | (r3 > r2 + slack);
    r1 = select(is_apex, T(apex), r1);
    r2 = select(is_apex, T(apex), r2);
    r3 = select(is_apex, T(apex), r3);
    // Tension, where less is allowed than at the apex: the mean stress falls, the rest of the stress stays.
    const T excess = T(max(none, T((r1 + r2 + r3) * (1.0 / 3) - T(cutoff))));
    r1 = r1 - excess;
    r2 = r2 - excess;
    r3 = r3 - excess;

    const T new_theta = T((r1 + r2 + r3) * (1 / (3 * bulk_modulus())));
    p.e[0] = T((r1 - la * new_theta) * (0.5 / G));
    p.e[1] = T((r2 - la * new_theta) * (0.5 / G));
    p.e[2] = T((r3 - la * new_theta) * (0.5 / G));
    undo(keeps_again, p.e[0], p.e[1]);
    undo(keeps_12, p.e[1], p.e[2]);
    undo(keeps_01, p.e[0], p.e[1]);

    const auto is_parting = is_apex | (excess > none);
    updated.gap = gap + select(is_parting, T(theta - new_theta), none);
    const T third = T((theta - new_theta) * (1.0 / 3));
    T squares = T(1e-30), work = none;
    for (std::size_t i = 0; i < 3; ++i) {
      const T change = T(before[i] - p.e[i]);
      const T stress = T(la * new_theta + 2 * G * p.e[i]);
      work = work + stress * change;
      squares = squares + (change - third) * (change - third);
    }
    const T strain = T(sqrt(T(squares * (2.0 / 3))));
    const auto is_flowing = (F13 > none) | is_parting;
    updated.plastic_strain = old.plastic_strain + select(is_flowing, strain, none);
    p.dissipated = select(is_flowing, work, none);
  }

 private:
  /// Puts the greater one first; whether it was.
  template <class T>
  static auto exchange(T& a, T& b) {
    const auto keeps = a >= b;
    undo(keeps, a, b);
    return keeps;
  }
  template <class T, class Keeps>
  static void undo(const Keeps& keeps, T& a, T& b) {
    const T first = select(keeps, a, b);
    b = select(keeps, b, a);
    a = first;
  }
};

}  // namespace matpoint
