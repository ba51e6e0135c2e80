// Velocities as functions of the position: what a body can start with.
#pragma once

#include <memory>

#include "core/parameters.hpp"

namespace matpoint {

class VelocityField {
 public:
  virtual ~VelocityField() = default;
  /// Velocity [m/s] at the position x [m].
  virtual Vec3 at(const Vec3& x) const = 0;
  virtual Input write(int dim) const = 0;
  virtual void check(const Input&, const ReadContext&) const {}
};

/// uniform, linear, rotating, sine.
const TypeRegistry<VelocityField>& velocity_registry();

}  // namespace matpoint
