#pragma once

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
  void check(const Input& input, const ReadContext& context) {
    GranularLaw::check(input, context);
    s_ = std::sin(radians(friction_angle));
    s_b_ = std::sin(radians(dilatancy_angle));
    strength_ = 2 * cohesion * std::cos(radians(friction_angle));
    apex_ = friction_angle > 0 ? cohesion / std::tan(radians(friction_angle)) : no_limit();
    cutoff_ = tension_cutoff ? std::min(apex_, *tension_cutoff) : apex_;
  }

  template <class State, class T>
  void flow(State& p, const Internal<T>& old, Internal<T>& updated, Real /*dt*/) const {
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
    const T F13 = T(max(none, above(t1, t3)));
    // One plane: t - C b F/(a . C b), with b = (1 + s_b, 0, s_b - 1).
    const Real volume = 2 * la * s_b_;
    const Real up = volume + 2 * G * (1 + s_b_), across = volume, down = volume - 2 * G * (1 - s_b_);
    const Real traces = 4 * la * s_ * s_b_;
    const Real A = traces + 2 * G * ((1 + s_) * (1 + s_b_) + (1 - s_) * (1 - s_b_));
    const T l = T(F13 * (1 / A));
    const T one1 = T(t1 - up * l), one2 = T(t2 - across * l), one3 = T(t3 - down * l);
    // t1 = t2, triaxial compression: planes 13 and 23.
    const Real B_c = traces + 2 * G * (1 - s_) * (1 - s_b_);
    const T F23 = above(t2, t3);
    const T c1 = T((A * F13 - B_c * F23) * (1 / (A * A - B_c * B_c)));
    const T c2 = T((A * F23 - B_c * F13) * (1 / (A * A - B_c * B_c)));
    const T com1 = T(t1 - up * c1 - across * c2), com2 = T(t2 - across * c1 - up * c2), com3 = T(t3 - down * (c1 + c2));
    // t2 = t3, extension: planes 13 and 12.
    const Real B_e = traces + 2 * G * (1 + s_) * (1 + s_b_);
    const T F12 = above(t1, t2);
    const T e1 = T((A * F13 - B_e * F12) * (1 / (A * A - B_e * B_e)));
    const T e2 = T((A * F12 - B_e * F13) * (1 / (A * A - B_e * B_e)));
    const T ext1 = T(t1 - up * (e1 + e2)), ext2 = T(t2 - across * e1 - down * e2), ext3 = T(t3 - down * e1 - across * e2);

    const auto is_compression = one2 > one1;
    const auto is_extension = one3 > one2;
    T r1 = select(is_compression, com1, select(is_extension, ext1, one1));
    T r2 = select(is_compression, com2, select(is_extension, ext2, one2));
    T r3 = select(is_compression, com3, select(is_extension, ext3, one3));
    const T slack = T((64 * k_unit_roundoff<T>)*(abs(t1) + abs(t2) + abs(t3)));
    const T mean = T((r1 + r2 + r3) * (1.0 / 3));
    const auto is_apex = (mean > T(apex_)) | (r2 > r1 + slack) | (r3 > r2 + slack);
    r1 = select(is_apex, T(apex_), r1);
    r2 = select(is_apex, T(apex_), r2);
    r3 = select(is_apex, T(apex_), r3);
    // Tension, where less is allowed than at the apex: the mean stress falls, the rest of the stress stays.
    const T excess = T(max(none, T((r1 + r2 + r3) * (1.0 / 3) - T(cutoff_))));
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
  /// The yield function of a plane.
  template <class T>
  T above(const T& high, const T& low) const {
    return T((high - low) + s_ * (high + low) - T(strength_));
  }

  Real s_ = 0, s_b_ = 0;  ///< sin phi, sin psi
  Real strength_ = 0;     ///< 2 c cos phi [Pa]
  Real apex_ = 0;         ///< c cot phi [Pa]
  Real cutoff_ = 0;       ///< Greatest mean stress [Pa].
};

}  // namespace matpoint
