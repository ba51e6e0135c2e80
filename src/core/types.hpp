// The few plain types that every folder shares.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace matpoint {

using Real = double;
using Index = std::int64_t;

/// A point or vector of a problem in Dim dimensions.
template <int Dim>
using Vec = std::array<Real, Dim>;

/// A point or vector at interfaces that hide the dimension: in 2D the third component is 0.
using Vec3 = std::array<Real, 3>;

template <std::size_t n>
Real dot(const std::array<Real, n>& a, const std::array<Real, n>& b) {
  Real sum = 0;
  for (std::size_t d = 0; d < n; ++d) sum += a[d] * b[d];
  return sum;
}

inline Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// A named field of a body or of the grid, copied out in the order of ids: values has shape (n, components), row by row.
struct Field {
  std::string name;
  std::string unit;
  int components = 1;
  std::vector<Real> values;

  Index count() const { return components > 0 ? static_cast<Index>(values.size()) / components : 0; }
};

}  // namespace matpoint
