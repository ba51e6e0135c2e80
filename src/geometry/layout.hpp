// Filling a region with particles: the layouts that a case can name.
#pragma once

#include <memory>
#include <vector>

#include "geometry/region.hpp"

namespace matpoint {

/// Equal boxes side by side.
struct BoxLattice {
  Vec3 corner{};   ///< Of one of them [m].
  Vec3 spacing{};  ///< Sides of a box [m].
};

/// The particles of one body before the first step, in the order of their ids.
struct Seeds {
  std::vector<Vec3> position;           ///< [m]
  std::vector<Real> volume;             ///< Reference volume [m^3], per metre of thickness in 2D.
  std::optional<BoxLattice> lattice{};  ///< Whose boxes have one particle each, where they do.
};

/// The background grid as far as a layout needs it.
struct SeedingGrid {
  int dim = 2;
  Vec3 lower{};           ///< [m]
  Vec3 upper{};           ///< [m]
  Vec3 cell_size{};       ///< [m]
  bool has_axis = false;  ///< x is the distance from an axis: what is beyond it is the other half of a body.
};

class Layout {
 public:
  virtual ~Layout() = default;
  /// `region` is null for a layout that needs none. Throws InputError.
  virtual Seeds fill(const Region* region, const SeedingGrid& grid) const = 0;
  virtual bool needs_region() const { return true; }
  virtual Input write(int dim) const = 0;
  virtual void check(const Input&, const ReadContext&) const {}
};

/// The layout type = "points" from arrays: positions [m] and reference volumes [m^3], one or as many as positions. Throws InputError.
std::shared_ptr<Layout> points_layout(std::vector<Vec3> positions, std::vector<Real> volumes);

const TypeRegistry<Layout>& layout_registry();

}  // namespace matpoint
