// Velocities as functions of the position: what a body can start with, and a boundary prescribe.
#pragma once

#include <memory>

#include "core/parameters.hpp"

namespace matpoint {

class VelocityField {
 public:
  virtual ~VelocityField() = default;
  /// Velocity [m/s] at the position x [m].
  virtual Vec3 at(const Vec3& x) const = 0;
  /// A bound of the speed in a box: of what is linear in the position, the greatest at its corners [m/s].
  virtual Real greatest_speed(const Vec3& lower, const Vec3& upper) const;
  virtual Input write(int dim) const = 0;
  virtual void check(const Input&, const ReadContext&) const {}
};

/// What stands for a velocity, as the table of its type: a list of numbers is a uniform one.
Input velocity_table(const Input& input);

/// uniform, linear, rotating, sine.
const TypeRegistry<VelocityField>& velocity_registry();

}  // namespace matpoint
