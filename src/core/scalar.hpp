// The functions that constitutive laws may call on their scalar. Laws are templates on it, so they write `log(J)` and never `std::log(J)`:
// for double the names below are found, for other scalars (dual numbers, ...) those of the scalar's own namespace.
#pragma once

#include <algorithm>
#include <cmath>

#include "core/types.hpp"

namespace matpoint {

using std::abs;
using std::exp;
using std::expm1;
using std::log;
using std::log1p;
using std::max;
using std::min;
using std::sqrt;

/// a where the condition holds, else b. Laws write this instead of a branch: with packs the condition differs from lane to lane.
template <class T>
inline T select(bool condition, const T& a, const T& b) {
  return condition ? a : b;
}

/// Whether a condition holds in any lane.
inline bool any(bool condition) { return condition; }

/// What a number of the type loses to rounding, relative to itself.
template <class T>
constexpr Real k_unit_roundoff = 1.1e-16;

/// x^exponent for x > 0. Small whole exponents, the usual case in equations of state, are products: about ten times faster than the
/// general power, and within two roundings per factor.
template <class T>
inline T power(const T& x, Real exponent) {
  constexpr Real k_largest_product = 16;
  const Real magnitude = exponent < 0 ? -exponent : exponent;
  if (magnitude > k_largest_product || magnitude != static_cast<Real>(static_cast<int>(magnitude))) return T(exp(T(exponent * log(x))));
  T result(1);
  T square = x;
  for (int rest = static_cast<int>(magnitude); rest > 0; rest /= 2) {
    if (rest % 2 == 1) result = T(result * square);
    square = T(square * square);
  }
  return exponent < 0 ? T(T(1) / result) : result;
}

}  // namespace matpoint
