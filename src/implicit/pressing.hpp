// What a contact that only pushes does over a step.
#pragma once

#include <algorithm>

#include "core/state.hpp"
#include "core/types.hpp"

namespace matpoint {

/// The spring along a surface of a particle that rubs on it.
template <int Dim>
struct Hold {
  Vec<Dim> pulled{};  ///< [m]
  Real energy = 0;    ///< [J]
  bool slips = false;
  void declare_state(State& state) {
    state.add("pulled", pulled);
    state.add("energy", energy);
    state.add("slips", slips);
  }
};

/// The change of <g>^2 / 2 over that of g, with which energy is kept over any step (Gonzalez 1996), and its derivative by the second g; in
/// statics its slope at the end.
struct Pressing {
  Real value;
  Real slope;
};

inline Pressing pressing(Real g0, Real g1, bool is_dynamic) {
  if (!is_dynamic || (g0 <= 0 && g1 <= 0)) return {std::max(Real{0}, g1), g1 > 0 ? 1.0 : 0.0};
  if (g0 > 0 && g1 > 0) return {0.5 * (g0 + g1), 0.5};
  const Real way = g1 - g0;
  if (g1 > 0) return {0.5 * g1 * g1 / way, g1 * (0.5 * g1 - g0) / (way * way)};
  return {-0.5 * g0 * g0 / way, 0.5 * g0 * g0 / (way * way)};
}

// Of m: almost as deep as nothing comes.
constexpr Real k_through = 0.99;

/// The same of m <g>^2 / (m - g) / 2, which is endless at g = m: nothing comes so deep. Where a guess would, the force goes on in a line.
inline Pressing pressing_up_to(Real m, Real g0, Real g1, bool is_dynamic) {
  if (g1 > k_through * m && m > 0) {
    const Pressing last = pressing_up_to(m, g0, k_through * m, is_dynamic);
    return {last.value + last.slope * (g1 - k_through * m), last.slope};
  }
  if (!is_dynamic) {
    if (g1 <= 0) return {0, 0};
    const Real left = m - g1;
    return {m * g1 * (m + left) / (2 * left * left), m * m * m / (left * left * left)};
  }
  if (g0 <= 0 && g1 <= 0) return {0, 0};
  if (g0 > 0 && g1 > 0)
    return {0.5 * m * (m * (g0 + g1) - g0 * g1) / ((m - g0) * (m - g1)), 0.5 * m * m * m / ((m - g0) * (m - g1) * (m - g1))};
  const Real way = g1 - g0;
  const Real g = std::max(g0, g1), left = m - g;
  const Real stored = 0.5 * m * g * g / left;
  if (g1 > 0) return {stored / way, (0.5 * m * g * (m + left) / (left * left) - stored / way) / way};
  return {stored / -way, stored / (way * way)};
}

}  // namespace matpoint
