// The section [grid] of a case: the background grid, a box of cells.
#pragma once

#include "core/parameters.hpp"

namespace matpoint {

/// What happens to particles that leave the grid.
enum class OutsidePolicy { error, remove, stop };

/// The background grid: a box of equal cells.
struct GridSpec {
  Vec3 lower{};
  Vec3 upper{};
  std::vector<int> cells;       ///< Cells per direction; either this
  std::vector<Real> cell_size;  ///< or this, one number or one per direction, is given. Both are resolved after reading.
  std::vector<std::string> periodic;
  std::vector<Real> grading;               ///< Per direction: how many times as long each cell is as the one before it. Empty: equal cells.
  std::array<std::vector<Real>, 3> lines;  ///< Per direction, instead of equal or graded cells: their coordinates [m]; empty: none.
  int refinements = 0;                     ///< Cells of a mesh are halved so many times.
  std::vector<Vec3> corners;               ///< Quadrilateral into which the box is mapped, counter-clockwise from the lower left [m].
  OutsidePolicy particles_outside = OutsidePolicy::error;
  static void declare(ParameterTable<GridSpec>& table);
};

/// What goes beyond single values; resolves what they leave open. Throws InputError.
void check_grid(GridSpec& grid, const Input& input, const ReadContext& context);

}  // namespace matpoint
