// Regions of space: what a body fills, where a boundary condition holds, what an obstacle occupies.
// In 2D all points have z = 0, so a disk is a sphere and a rectangle is a box.
#pragma once

#include <memory>
#include <optional>

#include "core/parameters.hpp"

namespace matpoint {

class Region {
 public:
  virtual ~Region() = default;
  /// Whether the closed region contains x [m].
  virtual bool contains(const Vec3& x) const = 0;
  /// Corners of the bounding box [m]; infinite where the region is unbounded.
  virtual Vec3 lower() const = 0;
  virtual Vec3 upper() const = 0;
  /// Area [m^2] in 2D, volume [m^3] in 3D, where a formula gives it; nothing for unions and differences.
  virtual std::optional<Real> measure(int dim) const = 0;
  virtual Input write(int dim) const = 0;
  virtual void check(const Input&, const ReadContext&) const {}
};

using RegionPointer = std::shared_ptr<Region>;

const TypeRegistry<Region>& region_registry();

}  // namespace matpoint
