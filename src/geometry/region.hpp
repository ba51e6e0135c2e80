// Regions of space: what a body fills, where a boundary condition holds, what an obstacle occupies.
// In 2D all points have z = 0, so a disk is a sphere and a rectangle is a box.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "core/parameters.hpp"

namespace matpoint {

/// Where a point is, seen from the surface of a region.
struct NearSurface {
  Real distance = 0;  ///< To the surface [m]; negative inside.
  Vec3 normal{};      ///< Outward where it is nearest: along it the distance grows.
};

/// What a region weighs if it is solid, per density; in 2D per metre of thickness.
struct Solid {
  Real volume = 0;                ///< [m^dim]
  Vec3 center{};                  ///< [m]
  std::array<Real, 9> inertia{};  ///< About the centre, row by row [m^(dim+2)]; in 2D the last one counts.
};

class Region {
 public:
  virtual ~Region() = default;
  /// Whether the closed region contains x [m]. What a difference removes is closed, too: its boundary is removed with it.
  virtual bool contains(const Vec3& x) const = 0;
  /// Whether x is in the region, or outside of it by no more than `tolerance` [m] (at corners a little more): for nodes, whose places are
  /// rounded, so that one on a face of the region is in it whatever the last digit says. Regions of programs answer exactly.
  virtual bool reaches(const Vec3& x, Real /*tolerance*/) const { return contains(x); }
  /// Corners of the bounding box [m]; infinite where the region is unbounded.
  virtual Vec3 lower() const = 0;
  virtual Vec3 upper() const = 0;
  /// Area [m^2] in 2D, volume [m^3] in 3D, where a formula gives it; nothing for half-spaces, unions and differences.
  virtual std::optional<Real> measure(int dim) const = 0;
  /// Whether the region has one smooth surface, or one of faces, so that `normals` has an answer.
  virtual bool has_normal() const { return false; }
  /// Outward unit normals of the surface where it is nearest to the inner point x [m]: one, or one for each face that is equally near.
  virtual std::vector<Vec3> normals(const Vec3&, int /*dim*/) const { return {}; }
  /// For tools, whose surfaces touch; nothing where it is not known.
  virtual std::optional<NearSurface> surface_near(const Vec3&, int /*dim*/) const { return std::nullopt; }
  virtual std::optional<Solid> solid(int /*dim*/) const { return std::nullopt; }
  virtual Input write(int dim) const = 0;
  virtual void check(const Input&, const ReadContext&) const {}
};

using RegionPointer = std::shared_ptr<Region>;

/// The tolerance for Region::reaches at a node x [m] of cells with the shortest side `cell_size` [m]: far below a cell, and above what
/// rounding makes of x, also far away from the origin.
Real node_tolerance(const Vec3& x, Real cell_size);

/// The points not farther than `radius` [m] from `center` [m]: a disk in 2D, a sphere in 3D.
template <int Dim>
struct Ball final : Region {
  static constexpr auto name = Dim == 2 ? "disk" : "sphere";
  static constexpr auto summary = Dim == 2 ? "A disk, 2D only." : "A sphere, 3D only.";

  Vec3 center{};
  Real radius = 1;

  static void declare(ParameterTable<Ball>& table);
  bool contains(const Vec3& x) const override { return reaches(x, 0); }
  bool reaches(const Vec3& x, Real tolerance) const override;
  Vec3 lower() const override;
  Vec3 upper() const override;
  std::optional<Real> measure(int dim) const override;
  bool has_normal() const override { return true; }
  std::vector<Vec3> normals(const Vec3& x, int dim) const override;
  std::optional<NearSurface> surface_near(const Vec3& x, int dim) const override;
  std::optional<Solid> solid(int dim) const override;
  Input write(int dim) const override;
  void check(const Input& input, const ReadContext& context) const override;
};
using Disk = Ball<2>;
using Sphere = Ball<3>;

/// box, disk, sphere, cylinder, polygon, half_space, union, difference.
const TypeRegistry<Region>& region_registry();

}  // namespace matpoint
