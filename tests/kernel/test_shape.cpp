// Shape functions, a cell at a time and over the lanes of a block: in the first cell of the grid, in the last and between.
#include <gtest/gtest.h>

#include <cmath>

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
        if (!is_gimp) {
          EXPECT_NEAR(dN[i], (above[i] - below[i]) / (2 * step), 1e-9);
        }
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

template <int Dim>
void check_domains() {
  // Turned, stretched and sheared; the last is longer than a cell, so it is shortened.
  const Real shears[][3] = {{0, 0, 0}, {0.4, -0.2, 0.1}, {-0.7, 0.5, 0.3}, {3, 1, -2}};
  for (const auto& side : k_sides) {
    for (const auto& shear : shears) {
      for (int k = 0; k <= 20; ++k) {
        ShapeConvected<Real> shapes[Dim];
        Real x[Dim], edges[Dim][Dim];
        for (int d = 0; d < Dim; ++d) {
          shapes[d] = ShapeConvected<Real>(side[0], side[1], 0);
          x[d] = std::fmod(0.05 * k + 0.3 * d, 1.0001);
          for (int e = 0; e < Dim; ++e) edges[d][e] = k_reach * ((d == e) + (d == e ? 0.5 : 1) * shear[(d + e) % 3]);
        }
        const ConvectedDomain<Dim, Real> domain(shapes, x, edges);
        Real sum = 0, slope_sum[Dim] = {}, place[Dim] = {}, slope[Dim][Dim] = {};
        for (int row = 0; row < rows_of<Dim>(3); ++row) {
          const int first[3] = {0, row % 4, row / 4};
          Real N[4], dN[Dim][4];
          domain.weights_of_row(first, N, dN);
          for (int i = 0; i < 4; ++i) {
            const int node[3] = {i, first[1], first[2]};
            EXPECT_GE(N[i], 0);
            sum += N[i];
            for (int d = 0; d < Dim; ++d) {
              slope_sum[d] += dN[d][i];
              place[d] += N[i] * (node[d] - 1);
              for (int e = 0; e < Dim; ++e) slope[d][e] += dN[e][i] * (node[d] - 1);
              // Nodes beyond the sides of the grid get nothing.
              if ((side[0] == 0 && node[d] == 0) || (side[1] == 0 && node[d] == 3)) {
                EXPECT_EQ(N[i], 0);
              }
            }
          }
        }
        EXPECT_NEAR(sum, 1, 1e-14);
        // Slopes carry the round-off of the weights times R^-1, which is large for thin domains.
        Real steepest = 1;
        for (const auto& entries : domain.inverse) {
          for (const Real entry : entries) steepest = std::max(steepest, std::abs(entry));
        }
        for (int d = 0; d < Dim; ++d) {
          EXPECT_NEAR(slope_sum[d], 0, 1e-14 * steepest);
          EXPECT_NEAR(place[d], domain.centre(d), 1e-14);
          for (int e = 0; e < Dim; ++e) EXPECT_NEAR(slope[d][e], d == e, 1e-14 * steepest);
        }
      }
    }
  }
}

TEST(Shape, convected_domains_reproduce_linear_functions) {
  check_domains<2>();
  check_domains<3>();
}

TEST(Shape, gradient_over_a_convected_domain_is_the_flux_through_its_sides) {
  // By the divergence theorem: the mean of grad S over a parallelogram is the sum over its edges of n times the mean of S on the edge,
  // which is the trapezoid of its corners for a function that is linear in each edge (Sadeghirad et al. 2011, eq. 21).
  ShapeConvected<Real> shapes[2] = {{2, 2, 0}, {2, 2, 0}};
  const Real x[2] = {0.4, 0.7};
  const Real edges[2][2] = {{0.3, 0.12}, {-0.1, 0.25}};
  const ConvectedDomain<2, Real> domain(shapes, x, edges);
  const int around[4] = {0, 1, 3, 2};  // counter-clockwise
  const Real area = 4 * (edges[0][0] * edges[1][1] - edges[0][1] * edges[1][0]);
  for (int row = 0; row < 4; ++row) {
    const int node[3] = {0, row, 0};
    Real N[4], dN[2][4];
    domain.weights_of_row(node, N, dN);
    for (int i = 0; i < 4; ++i) {
      Real flux[2] = {};
      for (int c = 0; c < 4; ++c) {
        const Real* const a = domain.corner[around[c]];
        const Real* const b = domain.corner[around[(c + 1) % 4]];
        const auto S = [&](const Real* at) { return ShapeConvected<Real>::hat(at[0], i) * ShapeConvected<Real>::hat(at[1], row); };
        flux[0] += (b[1] - a[1]) * 0.5 * (S(a) + S(b));
        flux[1] -= (b[0] - a[0]) * 0.5 * (S(a) + S(b));
      }
      for (int d = 0; d < 2; ++d) EXPECT_NEAR(dN[d][i], flux[d] / area, 1e-14);
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
