// Shape functions, one direction of one cell at a time. Here their names end: sweeps ask for weights, slopes and polynomials.
//
// The functions that live on a cell are numbered from its lower side on: cell i has the nodes i, i + 1, ..., as many as `k_nodes`. In 2D
// and 3D they are products. q in [0, 1] is the place in the cell, in cell sides. T: a number, or a pack of them, one per cell.
//
// Each is made of the numbers of cells before and after its own, those beyond 2 being the same as 2, and of half the size of a particle's
// domain in cell sides.
#pragma once

#include "kernel/kernel.hpp"

#define MPM_SHAPE_INLINE inline __attribute__((always_inline))

namespace matpoint {
namespace {

template <class T>
requires std::is_floating_point_v<T> MPM_SHAPE_INLINE T min(T a, T b) { return a < b ? a : b; }
template <class T>
requires std::is_floating_point_v<T> MPM_SHAPE_INLINE T max(T a, T b) { return a > b ? a : b; }
template <class T>
requires std::is_floating_point_v<T> MPM_SHAPE_INLINE T abs(T a) { return a < T(0) ? -a : a; }

/// Multilinear functions: N_0 = 1 - q, N_1 = q.
template <class T>
struct ShapeLinear {
  static constexpr int k_nodes = 2;

  MPM_SHAPE_INLINE ShapeLinear() = default;
  MPM_SHAPE_INLINE ShapeLinear(T, T, T) {}

  MPM_SHAPE_INLINE void weights(T q, T* N, T* dN) const {
    N[0] = T(1) - q;
    N[1] = q;
    dN[0] = T(-1);
    dN[1] = T(1);
  }
  /// Place of a node, in cell sides from the cell's lower side.
  MPM_SHAPE_INLINE T place(int node) const { return T(node); }
  /// Of what a particle is for the nodes: sum N_i x_i.
  MPM_SHAPE_INLINE T centre(T q) const { return q; }
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
  MPM_SHAPE_INLINE ShapeBSpline2(T before, T after, T) : a(T(1) - T(0.5) * min(before, T(1))), b(T(1) - T(0.5) * min(after, T(1))) {}

  MPM_SHAPE_INLINE void weights(T q, T* N, T* dN) const {
    const T s = T(1) - q;
    N[0] = a * s * s;
    N[2] = b * q * q;
    N[1] = middle(q);
    dN[0] = T(-2) * a * s;
    dN[2] = T(2) * b * q;
    dN[1] = -(dN[0] + dN[2]);
  }
  MPM_SHAPE_INLINE T centre(T q) const { return q; }
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

/// Cubic B-splines on equal knots, clamped at the grid's sides, by de Boor's recursion. The knots around the cell are
/// a2 <= a1 <= 0, 1 <= b1 <= b2; nodes stand at the Greville abscissae, the means of three neighbouring knots.
template <class T>
struct ShapeBSpline3 {
  static constexpr int k_nodes = 4;
  T a1, a2, b1, b2;
  T per_left, per_right;              ///< 1 over the supports of the quadratic splines' ends: 1 - a1, b1.
  T per_first, per_middle, per_last;  ///< 1 over those of the cubic ones: 1 - a2, b1 - a1, b2.

  MPM_SHAPE_INLINE ShapeBSpline3() = default;
  MPM_SHAPE_INLINE ShapeBSpline3(T before, T after, T)
      : a1(-min(before, T(1))), a2(-min(before, T(2))), b1(T(1) + min(after, T(1))), b2(T(1) + min(after, T(2))) {
    per_left = T(1) / (T(1) - a1);
    per_right = T(1) / b1;
    per_first = T(1) / (T(1) - a2);
    per_middle = T(1) / (b1 - a1);
    per_last = T(1) / b2;
  }

  MPM_SHAPE_INLINE void weights(T q, T* N, T* dN) const {
    const T s = T(1) - q;
    // Quadratic splines over their supports.
    const T low = s * s * per_left * per_first;
    const T middle = ((q - a1) * s * per_left + (b1 - q) * q * per_right) * per_middle;
    const T high = q * q * per_right * per_last;
    N[0] = s * low;
    N[1] = (q - a2) * low + (b1 - q) * middle;
    N[2] = (q - a1) * middle + (b2 - q) * high;
    N[3] = q * high;
    dN[0] = T(-3) * low;
    dN[1] = T(3) * (low - middle);
    dN[2] = T(3) * (middle - high);
    dN[3] = T(3) * high;
  }
  MPM_SHAPE_INLINE T place(int node) const {
    const T third = T(1.0 / 3);
    return node == 0 ? third * (a1 + a2) : node == 1 ? third * (a1 + T(1)) : node == 2 ? third * (b1 + T(1)) : third * (T(1) + b1 + b2);
  }
  MPM_SHAPE_INLINE T centre(T q) const { return q; }
};

/// Generalized interpolation (uGIMP; Bardenhagen & Kober 2004, Steffen et al. 2008): linear functions and their slopes, averaged over a
/// particle's domain of the given size, which keeps its size and stays in its cell and the neighbours. What of the domain is beyond the
/// side of the grid is cut off, so no function beyond a side is needed. Nodes are the corners of the cells, from the one before the cell
/// on.
template <class T>
struct ShapeGimp {
  static constexpr int k_nodes = 4;
  T lower, upper, reach;

  MPM_SHAPE_INLINE ShapeGimp() = default;
  MPM_SHAPE_INLINE ShapeGimp(T before, T after, T half_size)
      : lower(-min(before, T(1))), upper(T(1) + min(after, T(1))), reach(half_size) {}

  MPM_SHAPE_INLINE void weights(T q, T* N, T* dN) const {
    const T a = max(q - reach, lower);
    const T b = min(q + reach, upper);
    const T per_size = T(1) / (b - a);
    // The lengths of the domain before, in and after the cell.
    const T before = max(-a, T(0));
    const T after = max(b - T(1), T(0));
    const T from = max(a, T(0));
    const T to = min(b, T(1));
    const T inside = to - from;
    const T half = T(0.5);
    N[0] = half * before * before * per_size;
    N[3] = half * after * after * per_size;
    N[1] = (before * (T(1) - half * before) + inside * (T(1) - half * (from + to))) * per_size;
    N[2] = (after * (T(1) - half * after) + inside * half * (from + to)) * per_size;
    dN[0] = -before * per_size;
    dN[1] = (before - inside) * per_size;
    dN[2] = (inside - after) * per_size;
    dN[3] = after * per_size;
  }
  MPM_SHAPE_INLINE T place(int node) const { return T(node - 1); }
  MPM_SHAPE_INLINE T centre(T q) const { return T(0.5) * (max(q - reach, lower) + min(q + reach, upper)); }
};

/// The nodes and limits of convected domains (kernel/domain.hpp has their weights).
template <class T>
struct ShapeConvected {
  static constexpr int k_nodes = 4;
  T lower, upper;

  MPM_SHAPE_INLINE ShapeConvected() = default;
  MPM_SHAPE_INLINE ShapeConvected(T before, T after, T) : lower(-min(before, T(1))), upper(T(1) + min(after, T(1))) {}

  MPM_SHAPE_INLINE static T place(int node) { return T(node - 1); }
  /// The linear function of a node at a place in [-1, 2].
  MPM_SHAPE_INLINE static T hat(T q, int node) {
    const T beyond = q - place(node);
    return max(min(T(1) + beyond, T(1) - beyond), T(0));
  }
};

/// The weights of APIC's velocity slope, sum N_i (x_i - x_p) v_i / sum N_i (x_i - x_p)^2 (Jiang et al. 2015), for shapes that have no
/// closed form of it.
template <class Shape, class T>
MPM_SHAPE_INLINE void affine_weights(const Shape& shape, T q, const T* N, T* slope) {
  const T centre = shape.centre(q);
  T inertia = T(1e-30);
  for (int i = 0; i < Shape::k_nodes; ++i) {
    const T to_node = shape.place(i) - centre;
    slope[i] = N[i] * to_node;
    inertia += slope[i] * to_node;
  }
  const T per_inertia = T(1) / inertia;
  for (int i = 0; i < Shape::k_nodes; ++i) slope[i] *= per_inertia;
}

}  // namespace
}  // namespace matpoint
