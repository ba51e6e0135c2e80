// Shape functions, a cell at a time and over the lanes of a block: in the first cell of the grid, in the last and between.
#include <gtest/gtest.h>

#include "kernel/sweep.hpp"

namespace matpoint::test {
namespace {

/// a, b of a cell: 1 at the grid's lower and upper side.
constexpr Real k_sides[][2] = {{0.5, 0.5}, {1, 0.5}, {0.5, 1}, {1, 1}};

template <class Shape>
void check_weights() {
  constexpr int n = Shape::k_nodes;
  for (const auto& side : k_sides) {
    const Shape shape(side[0], side[1]);
    for (int k = 0; k <= 100; ++k) {
      const Real q = k / 100.0;
      Real N[n], dN[n], above[n], below[n], unused[n];
      shape.weights(q, N, dN);
      constexpr Real step = 1e-6;
      shape.weights(q + step, above, unused);
      shape.weights(q - step, below, unused);
      Real sum = 0, slope_sum = 0, place = 0, slope = 0;
      for (int i = 0; i < n; ++i) {
        sum += N[i];
        slope_sum += dN[i];
        place += N[i] * shape.place(i);
        slope += dN[i] * shape.place(i);
        EXPECT_GE(N[i], 0);
        EXPECT_NEAR(dN[i], (above[i] - below[i]) / (2 * step), 1e-9);  // exact for polynomials of degree 2, but for round-off / step
      }
      EXPECT_NEAR(sum, 1, 1e-14);
      EXPECT_NEAR(slope_sum, 0, 1e-14);
      EXPECT_NEAR(place, q, 1e-14);
      EXPECT_NEAR(slope, 1, 1e-14);
    }
  }
}

TEST(Shape, weights_are_positive_sum_to_one_and_reproduce_linear_functions) {
  check_weights<ShapeLinear<Real>>();
  check_weights<ShapeBSpline2<Real>>();
}

TEST(Shape, apic_slope_of_a_square_is_its_least_squares_slope) {
  for (const auto& side : k_sides) {
    const ShapeBSpline2<Real> shape(side[0], side[1]);
    for (int k = 0; k <= 100; ++k) {
      const Real q = k / 100.0;
      Real N[3], dN[3];
      shape.weights(q, N, dN);
      // v = q^2 on the cell has the nodal values 0, 0, 1/b.
      Real moment = 0, inertia = 0;
      const Real v[3] = {0, 0, 1 / side[1]};
      for (int i = 0; i < 3; ++i) {
        moment += N[i] * (shape.place(i) - q) * v[i];
        inertia += N[i] * (shape.place(i) - q) * (shape.place(i) - q);
      }
      if (inertia > 1e-10) {
        EXPECT_NEAR(shape.affine_slope(q), moment / inertia, 1e-12 / inertia);
      }
      EXPECT_GE(shape.affine_slope(q), 0);
      EXPECT_LE(shape.affine_slope(q), 2 + 1e-12);
    }
  }
}

/// The nodes' values of a + b . x in cell units, on the tile of 8 nodes at (row, tile), for shapes whose nodes stand at `place`.
template <int Dim, class Shape>
struct LinearField {
  Real a;
  Vec<Dim> b;
  Shape shape;
  alignas(64) mutable Real tile[rows_of<Dim>(Shape::k_nodes - 1)][2][k_lanes<Real>] = {};
  const Real* operator()(int row, int next) const {
    constexpr int n = Shape::k_nodes;
    for (int lane = 0; lane < k_lanes<Real>; ++lane) {
      // Node i stands in cell i at its first place.
      Real value = a + b[0] * (lane + next * k_lanes<Real> + shape.place(0)) + b[1] * shape.place(row % n);
      if constexpr (Dim == 3) value += b[2] * shape.place(row / n);
      tile[row][next][lane] = value;
    }
    return tile[row][next];
  }
};

template <int Dim, template <class> class Shape, class Interpolant>
void check_interpolant(Real a, const Vec<Dim>& b) {
  using P = Pack<Real>;
  const LinearField<Dim, Shape<Real>> field{a, b, Shape<Real>(0.5, 0.5)};
  const Shape<P> shapes[3] = {{P(0.5), P(0.5)}, {P(0.5), P(0.5)}, {P(0.5), P(0.5)}};
  for (int part = 0; part < k_lanes<Real>; part += P::k_width) {
    Interpolant nodes;
    nodes.load(field, shapes, part);
    for (int k = 0; k <= 100; ++k) {
      P x[Dim], square_slope[Dim], gradient[Dim];
      Real exact = a;
      for (int d = 0; d < Dim; ++d) {
        const Real xi = d == 0 ? k / 100.0 : (17 * k % 101) / 100.0;
        x[d] = P(xi);
        square_slope[d] = P(2 * xi);
        exact += b[static_cast<std::size_t>(d)] * xi;
      }
      const P value = nodes.gradient(x, square_slope, gradient);
      for (int i = 0; i < P::k_width; ++i) {
        // Sums of N_i and grad N_i against 1, x and 1 again: exact but for round-off of numbers up to about 20.
        const Real here = exact + b[0] * (part + i);
        EXPECT_NEAR(value.v[i], here, 20 * 1e-14);
        EXPECT_NEAR(nodes.value(x).v[i], here, 20 * 1e-14);
        for (int d = 0; d < Dim; ++d) EXPECT_NEAR(gradient[d].v[i], b[static_cast<std::size_t>(d)], 20 * 1e-14);
      }
    }
  }
}

TEST(Shape, constants_and_linear_fields_are_reproduced_with_their_gradients) {
  check_interpolant<2, ShapeLinear, Multilinear<2, Real>>(1, {0, 0});
  check_interpolant<2, ShapeLinear, Multilinear<2, Real>>(0.3, {1.1, -0.7});
  check_interpolant<3, ShapeLinear, Multilinear<3, Real>>(0.3, {1.1, -0.7, 0.45});
  check_interpolant<2, ShapeBSpline2, Polynomial<2, Real, ShapeBSpline2<Pack<Real>>>>(1, {0, 0});
  check_interpolant<2, ShapeBSpline2, Polynomial<2, Real, ShapeBSpline2<Pack<Real>>>>(0.3, {1.1, -0.7});
  check_interpolant<3, ShapeBSpline2, Polynomial<3, Real, ShapeBSpline2<Pack<Real>>>>(0.3, {1.1, -0.7, 0.45});
}

}  // namespace
}  // namespace matpoint::test
