// Numbers with a few derivatives, for what is differentiated inside of a constitutive law (material/spectral.hpp).
#pragma once

#include <cmath>

#include "core/scalar.hpp"

namespace matpoint {

/// x + sum d_i eps_i with eps_i eps_j = 0: arithmetic gives values and exact first derivatives.
template <int N>
struct Dual {
  Real value = 0;
  Real d[N] = {};

  Dual() = default;
  Dual(Real x) : value(x) {}
  /// The i-th variable.
  static Dual variable(Real x, int i) {
    Dual result(x);
    result.d[i] = 1;
    return result;
  }
  /// f(x) with f'(x) given.
  Dual through(Real f, Real slope) const {
    Dual result(f);
    for (int i = 0; i < N; ++i) result.d[i] = slope * d[i];
    return result;
  }

  friend Dual operator+(const Dual& a, const Dual& b) {
    Dual result(a.value + b.value);
    for (int i = 0; i < N; ++i) result.d[i] = a.d[i] + b.d[i];
    return result;
  }
  friend Dual operator-(const Dual& a, const Dual& b) {
    Dual result(a.value - b.value);
    for (int i = 0; i < N; ++i) result.d[i] = a.d[i] - b.d[i];
    return result;
  }
  friend Dual operator*(const Dual& a, const Dual& b) {
    Dual result(a.value * b.value);
    for (int i = 0; i < N; ++i) result.d[i] = a.d[i] * b.value + a.value * b.d[i];
    return result;
  }
  friend Dual operator/(const Dual& a, const Dual& b) {
    const Real inverse = 1 / b.value;
    Dual result(a.value * inverse);
    for (int i = 0; i < N; ++i) result.d[i] = (a.d[i] - result.value * b.d[i]) * inverse;
    return result;
  }
  Dual operator-() const { return through(-value, -1); }
  Dual& operator+=(const Dual& b) { return *this = *this + b; }
  Dual& operator-=(const Dual& b) { return *this = *this - b; }
  Dual& operator*=(const Dual& b) { return *this = *this * b; }

  friend bool operator<(const Dual& a, const Dual& b) { return a.value < b.value; }
  friend bool operator>(const Dual& a, const Dual& b) { return a.value > b.value; }
  friend bool operator<=(const Dual& a, const Dual& b) { return a.value <= b.value; }
  friend bool operator>=(const Dual& a, const Dual& b) { return a.value >= b.value; }

  friend Dual sqrt(const Dual& a) {
    const Real root = std::sqrt(a.value);
    return a.through(root, 0.5 / root);
  }
  friend Dual exp(const Dual& a) {
    const Real e = std::exp(a.value);
    return a.through(e, e);
  }
  friend Dual log(const Dual& a) { return a.through(std::log(a.value), 1 / a.value); }
  friend Dual log1p(const Dual& a) { return a.through(std::log1p(a.value), 1 / (1 + a.value)); }
  friend Dual expm1(const Dual& a) { return a.through(std::expm1(a.value), std::exp(a.value)); }
  friend Dual abs(const Dual& a) { return a.value < 0 ? -a : a; }
  friend Dual min(const Dual& a, const Dual& b) { return b.value < a.value ? b : a; }
  friend Dual max(const Dual& a, const Dual& b) { return a.value < b.value ? b : a; }
};

}  // namespace matpoint
