// Shape functions, a cell at a time and over the lanes of a block: in the first cell of the grid, in the last and between.
#include <gtest/gtest.h>

#include "kernel/sweep.hpp"

namespace matpoint::test {
namespace {

/// Cells before and after a cell; more than 2 count as 2.
constexpr Real k_sides[][2] = {{2, 2}, {0, 2}, {2, 0}, {0, 0}, {1, 2}, {2, 1}, {1, 1}, {0, 1}, {1, 0}};
constexpr Real k_reach = 0.3;

template <class Shape>
void check_weights() {
  constexpr int n = Shape::k_nodes;
  constexpr bool is_gimp = std::is_same_v<Shape, ShapeGimp<Real>>;
  for (const auto& side : k_sides) {
    const Shape shape(side[0], side[1], k_reach);
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
        // Exact for polynomials of degree 2, but for round-off / step. GIMP's slope is a mean of slopes, not one of means, at a side.
        if (!is_gimp) EXPECT_NEAR(dN[i], (above[i] - below[i]) / (2 * step), 1e-9);
      }
      EXPECT_NEAR(sum, 1, 1e-14);
      EXPECT_NEAR(slope_sum, 0, 1e-14);
      EXPECT_NEAR(place, shape.centre(q), 1e-14);
      EXPECT_NEAR(slope, 1, 1e-14);
    }
  }
}

TEST(Shape, weights_are_positive_sum_to_one_and_reproduce_linear_functions) {
  check_weights<ShapeLinear<Real>>();
  check_weights<ShapeBSpline2<Real>>();
  check_weights<ShapeBSpline3<Real>>();
  check_weights<ShapeGimp<Real>>();
}

TEST(Shape, gimp_weights_are_means_over_the_domain) {
  for (const auto& side : k_sides) {
    const ShapeGimp<Real> shape(side[0], side[1], k_reach);
    const auto hat = [](Real x) { return std::max(0.0, 1 - std::abs(x)); };
    for (int k = 0; k <= 50; ++k) {
      const Real q = k / 50.0;
      const Real a = std::max(q - k_reach, side[0] == 0 ? 0.0 : -1.0);
      const Real b = std::min(q + k_reach, side[1] == 0 ? 1.0 : 2.0);
      Real N[4], dN[4];
      shape.weights(q, N, dN);
      for (int i = 0; i < 4; ++i) {
        // Midpoints of 3000 parts: 1e-7 where a kink is inside one of them.
        Real sum = 0;
        for (int part = 0; part < 3000; ++part) sum += hat(a + (part + 0.5) / 3000 * (b - a) - shape.place(i)) / 3000;
        EXPECT_NEAR(N[i], sum, 1e-7);
        EXPECT_NEAR(dN[i], (hat(b - shape.place(i)) - hat(a - shape.place(i))) / (b - a), 1e-13);
      }
    }
  }
}

TEST(Shape, apic_slope_of_a_square_is_its_least_squares_slope) {
  for (const auto& side : k_sides) {
    const ShapeBSpline2<Real> shape(side[0], side[1], 0);
    for (int k = 0; k <= 100; ++k) {
      const Real q = k / 100.0;
      Real N[3], dN[3];
      shape.weights(q, N, dN);
      // v = q^2 on the cell has the nodal values 0, 0, 1/b.
      Real moment = 0, inertia = 0;
      const Real v[3] = {0, 0, side[1] == 0 ? 1.0 : 2.0};
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
  const LinearField<Dim, Shape<Real>> field{a, b, Shape<Real>(2, 2, k_reach)};
  const Shape<P> shape(P(2), P(2), P(k_reach));
  const Shape<P> shapes[3] = {shape, shape, shape};
  for (int part = 0; part < k_lanes<Real>; part += P::k_width) {
    Interpolant nodes;
    nodes.load(field, shapes, part);
    for (int k = 0; k <= 100; ++k) {
      P x[Dim], gradient[Dim];
      Real exact = a;
      for (int d = 0; d < Dim; ++d) {
        const Real xi = d == 0 ? k / 100.0 : (17 * k % 101) / 100.0;
        x[d] = P(xi);
        exact += b[static_cast<std::size_t>(d)] * xi;
      }
      const typename Interpolant::Point point(shapes, x);
      const P value = nodes.gradient(point, gradient);
      for (int i = 0; i < P::k_width; ++i) {
        // Sums of N_i and grad N_i against 1, x and 1 again: exact but for round-off of numbers up to about 20.
        const Real here = exact + b[0] * (part + i);
        EXPECT_NEAR(value.v[i], here, 20 * 1e-14);
        EXPECT_NEAR(nodes.value(point).v[i], here, 20 * 1e-14);
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
  check_interpolant<2, ShapeBSpline3, NodalValues<2, Real, ShapeBSpline3<Pack<Real>>>>(0.3, {1.1, -0.7});
  check_interpolant<3, ShapeBSpline3, NodalValues<3, Real, ShapeBSpline3<Pack<Real>>>>(0.3, {1.1, -0.7, 0.45});
  check_interpolant<2, ShapeGimp, NodalValues<2, Real, ShapeGimp<Pack<Real>>>>(0.3, {1.1, -0.7});
  check_interpolant<3, ShapeGimp, NodalValues<3, Real, ShapeGimp<Pack<Real>>>>(0.3, {1.1, -0.7, 0.45});
}

}  // namespace
}  // namespace matpoint::test
