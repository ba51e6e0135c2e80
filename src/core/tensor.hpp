// 3 x 3 matrices of a scalar T (double, a dual number, ...), as constitutive laws see them.
//
// In plane strain the entries xz, yz, zx, zy are zero for every tensor that a law can form, and sums, products, transposes and
// inverses keep them so. Mat3<T, true> knows this: it stores xx xy yx yy zz only, and a law that is written once for both costs in 2D
// what it would if it had been written for 2D.
#pragma once

#include "core/types.hpp"

namespace matpoint {

template <class T, bool is_plane = false>
struct Mat3 {
  using Scalar = T;
  static constexpr int k_size = is_plane ? 5 : 9;

  T entries[k_size];

  /// Whether the entry can be other than zero.
  static constexpr bool is_stored(int r, int c) { return !is_plane || (r == 2) == (c == 2); }
  static constexpr int index(int r, int c) { return !is_plane ? 3 * r + c : r == 2 ? 4 : 2 * r + c; }

  /// Entry (r, c), which must be stored.
  T& operator()(int r, int c) { return entries[index(r, c)]; }
  const T& operator()(int r, int c) const { return entries[index(r, c)]; }

  static Mat3 zero() { return diagonal(T(0)); }
  static Mat3 identity() { return diagonal(T(1)); }
  static Mat3 diagonal(const T& value) {
    Mat3 result;
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) {
        if (is_stored(r, c)) result(r, c) = r == c ? value : T(0);
      }
    }
    return result;
  }
};

template <class T, bool is_plane>
inline Mat3<T, is_plane> operator+(const Mat3<T, is_plane>& a, const Mat3<T, is_plane>& b) {
  Mat3<T, is_plane> result;
  for (int k = 0; k < result.k_size; ++k) result.entries[k] = a.entries[k] + b.entries[k];
  return result;
}

template <class T, bool is_plane>
inline Mat3<T, is_plane> operator-(const Mat3<T, is_plane>& a, const Mat3<T, is_plane>& b) {
  Mat3<T, is_plane> result;
  for (int k = 0; k < result.k_size; ++k) result.entries[k] = a.entries[k] - b.entries[k];
  return result;
}

template <class T, bool is_plane>
inline Mat3<T, is_plane> operator*(const Mat3<T, is_plane>& a, const Mat3<T, is_plane>& b) {
  using M = Mat3<T, is_plane>;
  M result;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) {
      if (!M::is_stored(r, c)) continue;
      // The third factor is stored in full matrices only, or alone at zz.
      if constexpr (is_plane) {
        result(r, c) = r == 2 ? T(a(2, 2) * b(2, 2)) : T(a(r, 0) * b(0, c) + a(r, 1) * b(1, c));
      } else {
        result(r, c) = a(r, 0) * b(0, c) + a(r, 1) * b(1, c) + a(r, 2) * b(2, c);
      }
    }
  }
  return result;
}

/// Scalars of type T or double on the left; T may be an expression's result type.
template <class T, bool is_plane>
inline Mat3<T, is_plane> scaled(const T& factor, const Mat3<T, is_plane>& a) {
  Mat3<T, is_plane> result;
  for (int k = 0; k < result.k_size; ++k) result.entries[k] = factor * a.entries[k];
  return result;
}
template <class T, bool is_plane>
inline Mat3<T, is_plane> operator*(Real factor, const Mat3<T, is_plane>& a) {
  return scaled(T(factor), a);
}

template <class T, bool is_plane>
inline Mat3<T, is_plane> transpose(const Mat3<T, is_plane>& a) {
  Mat3<T, is_plane> result;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) {
      if (a.is_stored(r, c)) result(r, c) = a(c, r);
    }
  }
  return result;
}

template <class T, bool is_plane>
inline Mat3<T, is_plane> symmetric_part(const Mat3<T, is_plane>& a) {
  return 0.5 * (a + transpose(a));
}

template <class T, bool is_plane>
inline T trace(const Mat3<T, is_plane>& a) {
  return T(a(0, 0) + a(1, 1) + a(2, 2));
}

template <class T, bool is_plane>
inline T determinant(const Mat3<T, is_plane>& a) {
  if constexpr (is_plane) {
    return T((a(0, 0) * a(1, 1) - a(0, 1) * a(1, 0)) * a(2, 2));
  } else {
    return T(a(0, 0) * (a(1, 1) * a(2, 2) - a(1, 2) * a(2, 1)) - a(0, 1) * (a(1, 0) * a(2, 2) - a(1, 2) * a(2, 0)) +
             a(0, 2) * (a(1, 0) * a(2, 1) - a(1, 1) * a(2, 0)));
  }
}

/// det(a) a^-T, the matrix of cofactors; of a plane matrix, again a plane one.
template <class T, bool is_plane>
inline Mat3<T, is_plane> cofactor(const Mat3<T, is_plane>& a) {
  Mat3<T, is_plane> result;
  if constexpr (is_plane) {
    result(0, 0) = T(a(1, 1) * a(2, 2));
    result(0, 1) = T(-a(1, 0) * a(2, 2));
    result(1, 0) = T(-a(0, 1) * a(2, 2));
    result(1, 1) = T(a(0, 0) * a(2, 2));
    result(2, 2) = T(a(0, 0) * a(1, 1) - a(0, 1) * a(1, 0));
  } else {
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) {
        const int r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
        result(r, c) = T(a(r1, c1) * a(r2, c2) - a(r1, c2) * a(r2, c1));
      }
    }
  }
  return result;
}

/// a : b, the sum of products of entries.
template <class T, bool is_plane>
inline T contract(const Mat3<T, is_plane>& a, const Mat3<T, is_plane>& b) {
  T sum = a.entries[0] * b.entries[0];
  for (int k = 1; k < a.k_size; ++k) sum = T(sum + a.entries[k] * b.entries[k]);
  return sum;
}

template <class T, bool is_plane>
inline Mat3<T, is_plane> deviator(const Mat3<T, is_plane>& a) {
  return a - Mat3<T, is_plane>::diagonal(T(trace(a) * (1.0 / 3)));
}

}  // namespace matpoint
