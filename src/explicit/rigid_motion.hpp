// How a rigid tool moves: as it is told, or freely under forces.
//
// Free: v += dt f / m, then x += dt v, as the particles do. Turns about the centre of mass or a hinge keep the angular momentum L, which
// only moments change; the turn itself is a product of five about the principal axes e_a of inertia, with the rates e_a . L / I_a, first
// and last for half of the step: this splitting is symplectic, so the energy of a free top stays without a drift (McLachlan 1993; Reich
// 1994). About an axis that is fixed (in 2D always) there is one angle and its rate.
#pragma once

#include "case/tool_spec.hpp"
#include "core/state.hpp"
#include "core/types.hpp"

namespace matpoint {

class RigidMotion {
 public:
  RigidMotion(const ToolSpec& spec, int dim);

  /// From time t to t + dt, with a force and the moment about pivot(), both at t, and gravity.
  void advance(Real t, Real dt, const Vec3& force, const Vec3& torque, const Vec3& gravity);

  bool is_free() const { return spec_.is_free(); }
  const Vec3& pivot() const { return pivot_; }  ///< [m]
  Vec3 center() const;                          ///< Of mass; of what is prescribed, the pivot.
  const Vec3& velocity() const { return velocity_; }
  const Vec3& angular_velocity() const { return angular_velocity_; }
  Vec3 velocity_of(const Vec3& x) const;
  /// The place of the shape at the start that is at x now.
  Vec3 at_start(const Vec3& x) const;
  /// A direction of the shape at the start, as it is now.
  Vec3 turned(const Vec3& direction) const;
  /// How far it has turned [rad]: about an axis through all turns, in general as a rotation vector.
  Vec3 turn() const;
  Real mass() const { return mass_; }
  Real kinetic_energy() const;
  Vec3 angular_momentum() const { return angular_momentum_; }  ///< About the pivot, of what turns freely [N m s].
  /// Of a spring at a hinge [s].
  Real stable_dt() const;
  void declare_state(State& state);

 private:
  void turn_freely(Real dt);
  void turn_by(const Vec3& axis, Real angle);
  void update_rate();

  ToolSpec spec_;
  Vec3 start_pivot_{};
  Vec3 arm_{};                      ///< From the pivot to the centre of mass, at the start [m].
  Real mass_ = 0;                   ///< [kg]
  std::array<Real, 9> axes_{};      ///< Principal axes of inertia about the pivot at the start, one a row.
  Vec3 moments_{};                  ///< Of inertia about them [kg m^2].
  std::optional<Vec3> fixed_axis_;  ///< Of what turns about one.
  Real inertia_ = 0;                ///< About it [kg m^2].
  bool is_turn_held_ = false;

  Vec3 pivot_{};
  Vec3 velocity_{};  ///< Of the pivot [m/s].
  std::array<Real, 9> R_{1, 0, 0, 0, 1, 0, 0, 0, 1};
  Vec3 angular_velocity_{};
  Vec3 angular_momentum_{};
  Real angle_ = 0;  ///< About the fixed axis [rad].
};

}  // namespace matpoint
