// The sections [[tool]] of a case: rigid bodies that touch particles.
#pragma once

#include <memory>
#include <optional>

#include "core/parameters.hpp"
#include "geometry/region.hpp"

namespace matpoint {

struct ToolSpec {
  std::string name;
  RegionPointer shape;            ///< Where it is at the start.
  std::optional<Real> density;    ///< [kg/m^3]; this or the mass: it moves freely.
  std::optional<Real> mass;       ///< [kg], per metre of thickness in 2D.
  std::vector<Real> velocity;     ///< [m/s], dim numbers; of what moves freely, at the start.
  Vec3 angular_velocity{};        ///< [rad/s]; in 2D the last one.
  std::vector<Real> times;        ///< [s], with factors of both velocities, or with velocities.
  std::vector<Real> factors;      ///< [1]
  std::vector<Vec3> velocities;   ///< [m/s], one per time.
  std::optional<Vec3> pivot;      ///< That a prescribed turn is about [m]; without it the middle of the shape.
  std::vector<std::string> held;  ///< Of what moves freely: "x", "y", "z", "rotation".
  std::optional<Vec3> hinge;      ///< A point of it that stays where it is [m].
  std::optional<Vec3> axis;       ///< Through the hinge, 3D; without it all turns are free.
  Real spring = 0;                ///< Of the hinge, about the axis [N m/rad].
  Real spring_damping = 0;        ///< [N m s/rad]
  std::vector<Real> force;        ///< On what moves freely [N], dim numbers.
  Real friction = 0;              ///< Coulomb's coefficient [1].
  Real stiffness = 1;             ///< Of its contact, over what particles have [1].
  std::string place;
  bool is_free() const { return density || mass; }
  /// Of what is prescribed, at time t.
  Vec3 velocity_at(Real t) const;
  Vec3 angular_velocity_at(Real t) const;
  static void declare(ParameterTable<ToolSpec>& table);
};

/// What goes beyond single values. Throws InputError.
void check_tool(ToolSpec& tool, const Input& input, const ReadContext& context);

}  // namespace matpoint
