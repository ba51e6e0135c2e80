// The section [grid] of a case: the background grid, a box of cells.
#pragma once

#include <optional>

#include "core/parameters.hpp"

namespace matpoint {

/// What happens to particles that leave the grid.
enum class OutsidePolicy { error, remove, stop };

/// A sector of a ring about an axis along z, into which a box is mapped: x becomes the radius, y the angle, z stays.
struct RingSpec {
  std::vector<Real> center{0, 0};  ///< x, y [m]
  Real inner_radius = 0;           ///< Of the side "left" [m].
  Real outer_radius = 0;           ///< Of the side "right" [m].
  Real start_angle = 0;            ///< Of the side "bottom", from the x axis, counter-clockwise [degrees].
  Real end_angle = 90;             ///< Of the side "top" [degrees].
  static void declare(ParameterTable<RingSpec>& table);
};

/// The background grid: a box of equal cells.
struct GridSpec {
  Vec3 lower{};
  Vec3 upper{};
  std::vector<int> cells;       ///< Cells per direction; either this
  std::vector<Real> cell_size;  ///< or this, one number or one per direction, is given. Both are resolved after reading.
  std::vector<std::string> periodic;
  bool is_axisymmetric = false;            ///< 2D: x is the distance from an axis, y the place along it.
  std::vector<Real> grading;               ///< Per direction: how many times as long each cell is as the one before it. Empty: equal cells.
  std::array<std::vector<Real>, 3> lines;  ///< Per direction, instead of equal or graded cells: their coordinates [m]; empty: none.
  int refinements = 0;                     ///< Cells of a mesh are halved so many times.
  std::vector<Vec3> corners;               ///< Quadrilateral into which the box is mapped, counter-clockwise from the lower left [m].
  std::optional<RingSpec> ring;            ///< Instead of it, into which the box is mapped.
  bool is_mapped() const { return !corners.empty() || ring; }
  const char* map_name() const { return ring ? "ring of grid.ring" : "quadrilateral of grid.corners"; }  ///< In messages.
  /// Where a point of the box goes.
  Vec3 mapped(const Vec3& x) const;
  OutsidePolicy particles_outside = OutsidePolicy::error;
  static void declare(ParameterTable<GridSpec>& table);
};

/// What goes beyond single values; resolves what they leave open. Throws InputError.
void check_grid(GridSpec& grid, const Input& input, const ReadContext& context);

}  // namespace matpoint
