// What gases and other materials share whose pressure follows from their volume and their energy: p = A(J) + B(J) u.
#pragma once

#include <limits>
#include <optional>

#include "material/law.hpp"
#include "material/material.hpp"

namespace matpoint {

/// An inviscid material with the internal energy u [J/m^3 of reference volume], which heats by compression and by shocks; no heat is
/// conducted. A step is adiabatic and of second order, u' = u - ((p + p')/2 + Q)(J' - J), which is closed since p is linear in u.
/// Q = rho h |d| (c1 h |d| + c2 c), d = tr L < 0, spreads shocks over some cells (von Neumann & Richtmyer 1950; Landshoff 1955).
///
/// A law says:
///   Real start_energy() const;                                            // u0 [J/m^3]
///   template <class T> PressureLine<T> line(const T& J) const;            // A, B and their slopes
template <class T>
struct PressureLine {
  T A;        ///< [Pa]
  T B;        ///< [1]
  T A_slope;  ///< dA/dJ [Pa]
  T B_slope;  ///< dB/dJ [1]
};

template <class Law>
struct EquationOfState {
  Real density = 0;                    ///< [kg/m^3]
  Real shock_quadratic = 2;            ///< c1 [1]
  Real shock_linear = 0.3;             ///< c2 [1]
  std::optional<Real> length;          ///< h [m]
  std::optional<Real> spall_pressure;  ///< [Pa]

  static void declare_shocks(ParameterTable<Law>& table) {
    table.required("density", "kg/m^3", static_cast<Real Law::*>(&Law::density), positive(), "Mass per reference volume, at the start.");
    table.optional("shock_quadratic", "1", static_cast<Real Law::*>(&Law::shock_quadratic), non_negative(),
                   "Artificial viscosity c1 of strong shocks; with both 0 shocks ring and heat too little.");
    table.optional("shock_linear", "1", static_cast<Real Law::*>(&Law::shock_linear), non_negative(),
                   "Artificial viscosity c2, which damps what rings behind them.");
    table.optional("length", "m", static_cast<std::optional<Real> Law::*>(&Law::length), positive(),
                   "Width that shocks are spread over; default: the cell size.");
  }
  static void declare_spall(ParameterTable<Law>& table) {
    table.optional("spall_pressure", "Pa", static_cast<std::optional<Real> Law::*>(&Law::spall_pressure), non_negative(),
                   "Greatest tension, as a pressure; 0 for none. Without it the equation holds as it stands.");
  }

  static constexpr bool has_state = true;
  static constexpr bool is_viscous = true;
  static constexpr bool is_fluid = true;
  static constexpr bool is_rate_dependent = true;

  template <class T, bool is_plane>
  struct History {
    T J_minus_1;  ///< Of the step's start.
    T heated;     ///< u - u0 [J/m^3]
  };
  std::array<InternalVariable, 1> variables() const { return {{{"internal_energy", "J/m^3", law().start_energy()}}}; }

  template <class M, class H, class T = typename M::Scalar>
  M update(const Kinematics<M>& k, const H& old, H& updated, T& dissipated) const {
    dissipated = T(0.0);
    const T J = determinant(k.F);
    const T J_old = T(T(1.0) + old.J_minus_1);
    const T dJ = T(J - J_old);
    const T squeezed = T(max(T(0.0), T(dJ / T(J + J_old) * (k.dt > 0 ? -2 / k.dt : 0))));
    const Real h = length.value_or(0);
    const T c = T(sqrt(T(wave_modulus_at(J_old, old.heated) * (1 / density))));
    const T Q = T(T(density / J) * h * squeezed * T(shock_quadratic * h * squeezed + shock_linear * c));

    const T u = T(T(law().start_energy()) + old.heated);
    const T p = pressure_at(J_old, old.heated);
    const PressureLine<T> line = law().line(J);
    T heated = T(old.heated - (T(0.5 * T(p + line.A + line.B * u)) + Q) * dJ / T(T(1.0) + 0.5 * line.B * dJ));
    T p_new = T(line.A + line.B * T(T(law().start_energy()) + heated));
    if (spall_pressure) {
      const auto is_parting = p_new < T(-*spall_pressure);
      p_new = max(p_new, T(-*spall_pressure));
      heated = select(is_parting, T(old.heated - T(T(0.5 * T(p + p_new)) + Q) * dJ), heated);
    }
    updated.heated = heated;
    updated.J_minus_1 = T(J - T(1.0));
    return M::diagonal(T(-J * T(p_new + Q)));
  }
  template <class M, class H>
  M stress_of(const M& F, const H& history) const {
    using T = typename M::Scalar;
    const T J = determinant(F);
    return M::diagonal(T(-J * pressure_at(J, history.heated)));
  }
  template <class M, class H>
  typename M::Scalar energy_of(const M& /*F*/, const H& history) const {
    return history.heated;
  }
  /// Along an isentrope.
  template <class M, class H>
  void deform(const M& F, H& history) const {
    using T = typename M::Scalar;
    constexpr int k_steps = 50;
    const T J = determinant(F);
    history.J_minus_1 = history.heated = T(0.0);
    T unused(0.0);
    Kinematics<M> k{M::identity(), M::zero(), 0, M::zero()};
    for (int i = 1; i <= k_steps; ++i) {
      const H old = history;
      k.F(0, 0) = T(exp(T(log(J) * (static_cast<Real>(i) / k_steps))));
      update(k, old, history, unused);
    }
  }
  Real wave_speed(Real J) const {
    History<Real, false> at_J{};
    auto F = Mat3<Real>::identity();
    F(0, 0) = J;
    deform(F, at_J);
    return std::sqrt(wave_modulus_at(J, at_J.heated) / density);
  }
  template <class M, class H>
  typename M::Scalar wave_modulus(const M& F, const H& history) const {
    using T = typename M::Scalar;
    return wave_modulus_at(T(determinant(F)), history.heated);
  }

 private:
  const Law& law() const { return static_cast<const Law&>(*this); }
  template <class T>
  T pressure_at(const T& J, const T& heated) const {
    const PressureLine<T> line = law().line(J);
    const T p = T(line.A + line.B * T(T(law().start_energy()) + heated));
    return spall_pressure ? T(max(p, T(-*spall_pressure))) : p;
  }
  /// rho0 c^2 = -J^2 (dp/dJ - p dp/du)
  template <class T>
  T wave_modulus_at(const T& J, const T& heated) const {
    const PressureLine<T> line = law().line(J);
    const T u = T(T(law().start_energy()) + heated);
    const T p = T(line.A + line.B * u);
    return T(max(T(0.0), T(J * J * T(p * line.B - line.A_slope - line.B_slope * u))));
  }
};

}  // namespace matpoint
