#pragma once

#include <algorithm>

#include "core/types.hpp"

namespace matpoint {

inline Real mixed(Real a, Real b, Real share) { return a + share * (b - a); }
inline Vec3 mixed(const Vec3& a, const Vec3& b, Real share) {
  return {mixed(a[0], b[0], share), mixed(a[1], b[1], share), mixed(a[2], b[2], share)};
}

/// A table's value at x: linear between its places, which ascend, and constant before the first and after the last.
template <class T>
T interpolated(const std::vector<Real>& places, const std::vector<T>& values, Real x) {
  const auto after = std::upper_bound(places.begin(), places.end(), x);
  if (after == places.begin()) return values.front();
  if (after == places.end()) return values.back();
  const auto k = static_cast<std::size_t>(after - places.begin());
  return mixed(values[k - 1], values[k], (x - places[k - 1]) / (places[k] - places[k - 1]));
}

}  // namespace matpoint
