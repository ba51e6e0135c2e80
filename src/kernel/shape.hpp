// Shape functions, one direction of one cell at a time. Here their names end: sweeps ask for weights, slopes and polynomials.
//
// The functions that live on a cell are numbered from its lower side on: cell i has the nodes i, i + 1, ..., as many as `k_nodes`. In 2D
// and 3D they are products. q in [0, 1] is the place in the cell, in cell sides. T: a number, or a pack of them, one per cell.
#pragma once

#include "kernel/kernel.hpp"

#define MPM_SHAPE_INLINE inline __attribute__((always_inline))

namespace matpoint {
namespace {

/// Multilinear functions: N_0 = 1 - q, N_1 = q.
template <class T>
struct ShapeLinear {
  static constexpr int k_nodes = 2;

  MPM_SHAPE_INLINE ShapeLinear() = default;
  MPM_SHAPE_INLINE ShapeLinear(T, T) {}

  MPM_SHAPE_INLINE void weights(T q, T* N, T* dN) const {
    N[0] = T(1) - q;
    N[1] = q;
    dN[0] = T(-1);
    dN[1] = T(1);
  }
  /// Place of a node, in cell sides from the cell's lower side.
  MPM_SHAPE_INLINE T place(int node) const { return T(node); }
  /// Nodal values as the coefficients of their polynomial in q.
  MPM_SHAPE_INLINE void to_polynomial(const T* v, T* c) const {
    c[0] = v[0];
    c[1] = v[1] - v[0];
  }
  /// Slope that APIC sees of the term q^2; there is none.
  MPM_SHAPE_INLINE T affine_slope(T) const { return T(0); }
};

/// Quadratic B-splines on equal knots, clamped at the grid's sides (Steffen, Kirby & Berzins 2008; Piegl & Tiller, The NURBS Book, for
/// the clamped knots):
///
///     N_0 = a (1 - q)^2,  N_1 = 1 - N_0 - N_2,  N_2 = b q^2,     a = 1 in the first cell of the grid, b = 1 in the last, else 1/2.
///
/// Nodes are control points. They stand at the Greville abscissae, the cells' centres and the grid's two sides, so that nodal values of
/// a linear function give this function.
template <class T>
struct ShapeBSpline2 {
  static constexpr int k_nodes = 3;
  T a, b;

  MPM_SHAPE_INLINE ShapeBSpline2() = default;
  /// a, b: 1 at the grid's lower and upper side, else 1/2.
  MPM_SHAPE_INLINE ShapeBSpline2(T lower, T upper) : a(lower), b(upper) {}

  MPM_SHAPE_INLINE void weights(T q, T* N, T* dN) const {
    const T s = T(1) - q;
    N[0] = a * s * s;
    N[2] = b * q * q;
    N[1] = middle(q);
    dN[0] = T(-2) * a * s;
    dN[2] = T(2) * b * q;
    dN[1] = -(dN[0] + dN[2]);
  }
  MPM_SHAPE_INLINE T place(int node) const { return node == 0 ? a - T(1) : node == 1 ? T(0.5) : T(2) - b; }
  MPM_SHAPE_INLINE void to_polynomial(const T* v, T* c) const {
    const T first = v[1] - v[0];
    const T second = v[2] - v[1];
    c[0] = v[1] - a * first;
    c[1] = T(2) * a * first;
    c[2] = b * second - a * first;
  }
  /// APIC's velocity slope is sum N_i (x_i - x_p) v_i / sum N_i (x_i - x_p)^2 (Jiang et al. 2015). Of v = q^2, whose only nodal value on
  /// the cell is 1/b at the last node, that is the quotient below; all sums are of terms that are not negative, so it is exact to
  /// rounding also at a clamped side, where both vanish.
  MPM_SHAPE_INLINE T affine_slope(T q) const {
    const T s = T(1) - q;
    const T to_0 = place(0) - q;
    const T to_1 = T(0.5) - q;
    const T to_2 = place(2) - q;
    const T inertia = a * s * s * to_0 * to_0 + middle(q) * to_1 * to_1 + b * q * q * to_2 * to_2;
    return q * q * to_2 / (inertia + T(1e-30));
  }

 private:
  /// 1 - N_0 - N_2 without cancellation.
  MPM_SHAPE_INLINE T middle(T q) const {
    const T s = T(1) - q;
    return (T(1) - a) * s * s + T(2) * q * s + (T(1) - b) * q * q;
  }
};

}  // namespace
}  // namespace matpoint
