// What the kinds of regions share. Private to region.cpp and polygon.cpp.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/region.hpp"

namespace matpoint {

/// Adds the polygon to the registry of regions (polygon.cpp).
void add_polygon(TypeRegistry<Region>& registry);

namespace region_parts {

constexpr Real k_infinity = std::numeric_limits<Real>::infinity();

/// The value of a required key, for the place of a message.
inline const Input& value_of(const Input& table, const std::string& key) { return *table.find(key); }

/// Faces whose distances differ by less than this share of the region's size are equally near.
constexpr Real k_tie_tolerance = 1e-9;

/// The normals that belong to the smallest distances.
inline std::vector<Vec3> nearest_normals(const std::vector<std::pair<Real, Vec3>>& faces, Real size) {
  Real nearest = k_infinity;
  for (const auto& [distance, normal] : faces) nearest = std::min(nearest, distance);
  std::vector<Vec3> normals;
  for (const auto& [distance, normal] : faces) {
    if (distance <= nearest + k_tie_tolerance * size) normals.push_back(normal);
  }
  return normals;
}

/// Throws InputError when a region that exists in one dimension only stands in a case of the other. Called while the first key is read:
/// a complaint about the number of coordinates would come first otherwise, and would mislead.
inline void require_dim(int dim, const Input& input, const ReadContext& context, const std::string& text) {
  if (context.dim != dim) fail_input(input, context, fmt::format("{}; this case has dim = {}", text, context.dim));
}

/// Throws InputError for a measure that overflows or underflows: extents of 1e200 m pass every other check.
inline void check_measure(const Region& region, const Input& input, const ReadContext& context) {
  const Real measure = region.measure(context.dim).value_or(1);
  if (measure > 0 && std::isfinite(measure)) return;
  fail_input(input, context,
             fmt::format("its {} of {} {} is beyond the range of numbers; lengths are in m", context.dim == 2 ? "area" : "volume", measure,
                         context.dim == 2 ? "m^2" : "m^3"));
}

}  // namespace region_parts
}  // namespace matpoint
