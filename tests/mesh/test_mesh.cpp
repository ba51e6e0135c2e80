#include "mesh/mesh.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/error.hpp"
#include "mesh/basis.hpp"
#include "support/from_toml.hpp"

namespace matpoint::test {
namespace {

GridSpec grid_of(int dim, std::vector<int> cells, const Vec3& lower, const Vec3& upper) {
  GridSpec grid;
  grid.lower = lower;
  grid.upper = upper;
  grid.cells = std::move(cells);
  for (std::size_t d = 0; d < static_cast<std::size_t>(dim); ++d) grid.cell_size.push_back((upper[d] - lower[d]) / grid.cells[d]);
  return grid;
}

/// Values of the basis at x reproduce every linear field, and the gradients its slope.
template <int Dim>
void expect_linear_fields(const Basis<Dim>& basis, const Vec3& lower, const Vec3& upper) {
  std::mt19937 random(3);
  std::uniform_real_distribution<Real> uniform(0, 1);
  const auto n = static_cast<std::size_t>(basis.functions_per_cell());
  std::vector<Real> N(n), g(n * Dim);
  for (int k = 0; k < 200; ++k) {
    Vec<Dim> x;
    for (std::size_t d = 0; d < Dim; ++d) x[d] = lower[d] + uniform(random) * (upper[d] - lower[d]);
    const auto point = basis.locate(x);
    ASSERT_TRUE(point.has_value());
    basis.evaluate(*point, N.data(), g.data());
    Real sum = 0;
    Vec<Dim> position{};
    Real slope[Dim][Dim] = {};
    for (std::size_t i = 0; i < n; ++i) {
      const Vec<Dim> node = basis.node_position(basis.cell_nodes(point->element)[i]);
      sum += N[i];
      for (std::size_t d = 0; d < Dim; ++d) {
        position[d] += N[i] * node[d];
        for (std::size_t e = 0; e < Dim; ++e) slope[d][e] += node[d] * g[i * Dim + e];
      }
    }
    EXPECT_NEAR(sum, 1, 1e-14);
    for (std::size_t d = 0; d < Dim; ++d) {
      EXPECT_NEAR(position[d], x[d], 1e-13);
      for (std::size_t e = 0; e < Dim; ++e) EXPECT_NEAR(slope[d][e], d == e ? 1 : 0, 1e-12);
    }
  }
}

TEST(Mesh, graded_line_is_geometric_and_refined_at_midpoints) {
  const std::vector<Real> line = graded_line(-1.6, 3.4, 4, 1.25, 0);
  ASSERT_EQ(line.size(), 5u);
  EXPECT_NEAR(line[1] - line[0], 0.867208672, 1e-9);
  EXPECT_NEAR(line[2] - line[1], 1.084011, 1e-6);
  EXPECT_NEAR(line[3] - line[2], 1.355014, 1e-6);
  EXPECT_NEAR(line[4] - line[3], 1.693767, 1e-6);
  EXPECT_EQ(line[4], 3.4);
  const std::vector<Real> fine = graded_line(-1.6, 3.4, 4, 1.25, 2);
  ASSERT_EQ(fine.size(), 17u);
  for (std::size_t k = 0; k < 5; ++k) EXPECT_EQ(fine[4 * k], line[k]);
  EXPECT_NEAR(fine[2], 0.5 * (line[0] + line[1]), 1e-15);
  EXPECT_NEAR(fine[1], 0.25 * (3 * line[0] + line[1]), 1e-15);
}

TEST(Mesh, tensor_mesh_counts_nodes_faces_and_boundary) {
  const Mesh<2> mesh = tensor_mesh<2>({std::vector<Real>{0, 1, 3}, std::vector<Real>{0, 2, 3, 4}}, 2);
  EXPECT_EQ(mesh.element_count(), 6);
  EXPECT_EQ(mesh.node_count(), 5 * 7);
  EXPECT_EQ(mesh.boundary_nodes().size(), 2u * 5 + 2 * 5);
  EXPECT_EQ(mesh.parts().at("left").size(), 3u);
  EXPECT_EQ(mesh.parts().at("top").size(), 2u);
  for (const ElementFace& face : mesh.parts().at("right")) {
    for (const Index node : mesh.face_nodes(face)) EXPECT_EQ(mesh.nodes()[static_cast<std::size_t>(node)][0], 3);
  }
  const Mesh<3> solid = tensor_mesh<3>({std::vector<Real>{0, 1, 2}, std::vector<Real>{0, 1}, std::vector<Real>{0, 1}}, 1);
  EXPECT_EQ(solid.node_count(), 12);
  EXPECT_EQ(solid.parts().at("back").size(), 2u);
}

/// Bends the mesh: sides and middles of elements are curved.
template <int Dim>
std::vector<Vec<Dim>> bent(std::vector<Vec<Dim>> nodes) {
  for (Vec<Dim>& x : nodes) {
    const Vec<Dim> old = x;
    for (std::size_t d = 0; d < Dim; ++d) x[d] += 0.08 * std::sin(2 * old[(d + 1) % Dim] + 0.3) * std::cos(old[d]);
  }
  return nodes;
}

template <int Dim>
void expect_inverse_map(int order) {
  std::array<std::vector<Real>, Dim> lines;
  for (auto& line : lines) line = {0, 0.3, 0.7, 1.2};
  Mesh<Dim> mesh = tensor_mesh<Dim>(lines, order);
  mesh.set_nodes(bent<Dim>(mesh.nodes()));
  std::mt19937 random(5);
  std::uniform_real_distribution<Real> uniform(-0.999, 0.999);
  for (int k = 0; k < 300; ++k) {
    ElementPoint<Dim> point{k % mesh.element_count(), {}};
    for (Real& xi : point.xi) xi = uniform(random);
    const Vec<Dim> x = mesh.position(point);
    // From the far corner by hops, and without a guess.
    for (const auto& found : {mesh.locate(x, 0), mesh.locate(x, mesh.element_count() - 1), mesh.locate(x)}) {
      ASSERT_TRUE(found.has_value());
      EXPECT_EQ(found->element, point.element);
      for (std::size_t d = 0; d < Dim; ++d) EXPECT_NEAR(found->xi[d], point.xi[d], 1e-10);
    }
  }
  Vec<Dim> far;
  far.fill(5);
  EXPECT_FALSE(mesh.locate(far).has_value());
  EXPECT_FALSE(mesh.locate(far, 0).has_value());
  far.fill(std::numeric_limits<Real>::quiet_NaN());
  EXPECT_FALSE(mesh.locate(far).has_value());
}

TEST(Mesh, inverse_map_finds_points_of_a_bent_mesh) {
  expect_inverse_map<2>(1);
  expect_inverse_map<2>(2);
  expect_inverse_map<3>(1);
  expect_inverse_map<3>(2);
}

TEST(Mesh, inverse_map_finds_points_far_from_the_origin) {
  // Where positions are rounded to more than what the local coordinates of a cell are usually found to.
  Mesh<2> mesh = tensor_mesh<2>({std::vector<Real>{0, 0.1, 0.2}, std::vector<Real>{0, 0.1, 0.2}}, 2);
  std::vector<Vec<2>> nodes = bent<2>(mesh.nodes());
  for (Vec<2>& x : nodes) x = {x[0] + 1000, x[1] - 3000};
  mesh.set_nodes(nodes);
  std::mt19937 random(11);
  std::uniform_real_distribution<Real> uniform(-0.999, 0.999);
  for (int k = 0; k < 2000; ++k) {
    const ElementPoint<2> point{k % 4, {uniform(random), uniform(random)}};
    const auto found = mesh.locate(mesh.position(point), 3);
    ASSERT_TRUE(found.has_value()) << k;
    EXPECT_EQ(found->element, point.element);
    for (std::size_t d = 0; d < 2; ++d) EXPECT_NEAR(found->xi[d], point.xi[d], 1e-8);
  }
}

TEST(Mesh, places_on_a_face_belong_to_the_upper_cell_whatever_the_rounding) {
  const std::array<std::vector<Real>, 2> lines = {std::vector<Real>{-0.2, -0.1, 0, 0.1}, std::vector<Real>{0, 0.1, 0.2}};
  const Mesh<2> mesh = tensor_mesh<2>(lines, 2);
  GridSpec grid;
  grid.lower = {-0.2, 0, 0};
  grid.upper = {0.1, 0.2, 0};
  grid.cells = {3, 2};
  grid.cell_size = {0.1, 0.1};
  const auto basis = make_element_basis<2>(grid, 2);
  for (const Real noise : {0.0, 1e-16, -1e-16, 1e-13, -1e-13}) {
    for (Index guess = 0; guess < 6; ++guess) {
      EXPECT_EQ(mesh.locate({noise, 0.05}, guess)->element, 2) << noise;
      EXPECT_EQ(mesh.locate({-0.15, 0.1 + noise}, guess)->element, 3) << noise;
      EXPECT_EQ(mesh.locate({noise, 0.1 + noise}, guess)->element, 5) << noise;
    }
    EXPECT_EQ(basis->locate({noise, 0.05})->element, 2) << noise;
    EXPECT_EQ(basis->locate({noise, 0.1 + noise})->element, 5) << noise;
  }
  EXPECT_EQ(mesh.locate({-1e-9, 0.05}, 5)->element, 1);
  EXPECT_EQ(basis->locate({-1e-9, 0.05})->element, 1);
  // Not into a barred element, and at the border where there is none.
  const std::vector<bool> is_barred = {false, false, true, false, false, true};
  EXPECT_EQ(mesh.locate({-1e-16, 0.05}, 0, &is_barred)->element, 1);
  EXPECT_EQ(mesh.locate({0.1, 0.2}, 0)->element, 5);
}

TEST(Mesh, gradients_on_a_bent_mesh_are_those_of_a_linear_field) {
  Mesh<2> mesh = tensor_mesh<2>({std::vector<Real>{0, 0.5, 1}, std::vector<Real>{0, 0.5, 1}}, 2);
  mesh.set_nodes(bent<2>(mesh.nodes()));
  std::vector<Real> N(9), g(18);
  const ElementPoint<2> point{3, {0.3, -0.7}};
  EXPECT_GT(mesh.evaluate(point, N.data(), g.data()), 0);
  Real slope[2] = {};
  for (int i = 0; i < 9; ++i) {
    const Vec<2>& x = mesh.nodes()[static_cast<std::size_t>(mesh.element(3)[i])];
    for (int d = 0; d < 2; ++d) slope[d] += (2 * x[0] - 3 * x[1]) * g[static_cast<std::size_t>(2 * i + d)];
  }
  EXPECT_NEAR(slope[0], 2, 1e-12);
  EXPECT_NEAR(slope[1], -3, 1e-12);
}

TEST(Mesh, refuses_what_is_no_mesh) {
  const std::vector<Vec<2>> square = {{0, 0}, {1, 0}, {0, 1}, {1, 1}};
  EXPECT_NO_THROW(Mesh<2>(1, square, {0, 1, 2, 3}, {}));
  EXPECT_NE(complaint_of([&] { Mesh<2>(1, square, {0, 2, 1, 3}, {}); }).find("element 0 is turned inside out"), std::string::npos);
  EXPECT_NE(complaint_of([&] {
              Mesh<2>(1, square, {0, 1, 2, 4}, {});
            }).find("element 0 has node 4, but there are nodes 0 to 3"),
            std::string::npos);
  EXPECT_NE(complaint_of([&] { Mesh<2>(1, square, {0, 1, 2}, {}); }).find("not a multiple of 4"), std::string::npos);
  EXPECT_NE(complaint_of([&] { Mesh<2>(1, square, {}, {}); }).find("no element"), std::string::npos);
}

TEST(Basis, elements_and_splines_reproduce_linear_fields) {
  const Vec3 lower{-0.5, 1, 2}, upper{1.5, 2, 5};
  GridSpec flat = grid_of(2, {5, 3}, lower, upper);
  expect_linear_fields<2>(*make_spline_basis<2>(flat), lower, upper);
  expect_linear_fields<2>(*make_element_basis<2>(flat, 1), lower, upper);
  flat.grading = {1.3, 0.8};
  flat.refinements = 1;
  expect_linear_fields<2>(*make_element_basis<2>(flat, 2), lower, upper);
  const GridSpec solid = grid_of(3, {3, 1, 2}, lower, upper);
  expect_linear_fields<3>(*make_spline_basis<3>(solid), lower, upper);
  expect_linear_fields<3>(*make_element_basis<3>(solid, 2), lower, upper);
}

TEST(Basis, corners_map_the_box_with_its_lines) {
  GridSpec grid = grid_of(2, {4, 3}, {0, 0, 0}, {3, 2, 0});
  grid.grading = {1.2, 1};
  grid.corners = {{0.1, 0.2, 0}, {2.9, 0, 0}, {2.5, 1.9, 0}, {0, 1.4, 0}};
  const auto basis = make_element_basis<2>(grid, 2);
  // A linear field at places that are found again, and no place beside the quadrilateral.
  std::vector<Real> N(9), g(18);
  for (const Vec<2>& x : {Vec<2>{0.11, 0.21}, Vec<2>{1.3, 0.9}, Vec<2>{2.4, 1.8}, Vec<2>{2.8, 0.02}}) {
    const auto point = basis->locate(x);
    ASSERT_TRUE(point.has_value());
    basis->evaluate(*point, N.data(), g.data());
    Vec<2> sum{};
    for (std::size_t i = 0; i < 9; ++i) {
      const Vec<2> node = basis->node_position(basis->cell_nodes(point->element)[i]);
      for (std::size_t d = 0; d < 2; ++d) sum[d] += N[i] * node[d];
    }
    EXPECT_NEAR(sum[0], x[0], 1e-13);
    EXPECT_NEAR(sum[1], x[1], 1e-13);
  }
  EXPECT_FALSE(basis->locate({2.8, 1.8}).has_value());
  EXPECT_FALSE(basis->locate({0.01, 0.1}).has_value());
  // The area by the shoelace formula.
  Real area = 0;
  for (Index cell = 0; cell < basis->cell_count(); ++cell) {
    for (const QuadraturePoint<2>& point : basis->quadrature(cell)) area += point.weight;
  }
  EXPECT_NEAR(area, 0.5 * (-0.58 + 5.51 + 3.5 - 0.14), 1e-13);
}

TEST(Basis, a_ring_maps_the_box_to_radius_and_angle) {
  for (const int order : {1, 2}) {
    GridSpec grid = grid_of(3, {3, 4, 2}, {-1, -1, 0}, {3, 3, 1});
    grid.ring = RingSpec{{0.5, 0.25}, 1, 2, 30, 120};
    const auto basis = make_element_basis<3>(grid, order);
    for (const char* side : {"left", "right"}) {
      const Real radius = std::string(side) == "left" ? 1 : 2;
      for (const Index n : basis->side_nodes(side)) {
        const Vec<3> x = basis->node_position(n);
        EXPECT_NEAR(std::hypot(x[0] - 0.5, x[1] - 0.25), radius, 1e-14) << order << side;
      }
    }
    for (const Index n : basis->side_nodes("top")) {
      const Vec<3> x = basis->node_position(n);
      EXPECT_NEAR(std::atan2(x[1] - 0.25, x[0] - 0.5) * 180 / std::acos(-1.0), 120, 1e-12);
    }
    Real volume = 0;
    for (Index cell = 0; cell < basis->cell_count(); ++cell) {
      for (const QuadraturePoint<3>& point : basis->quadrature(cell)) volume += point.weight;
    }
    // Chords of 4 cells, or of parabolas that are nearly arcs.
    const Real exact = std::acos(-1.0) / 4 * 3, turn = std::acos(-1.0) / 8;
    EXPECT_NEAR(volume, order == 1 ? 4 * 0.5 * std::sin(turn) * 3 : exact, order == 1 ? 1e-13 : 1e-3 * exact) << order;
    const auto found = basis->locate({0.5, 1.75, 0.3});
    ASSERT_TRUE(found.has_value());
    EXPECT_NEAR(basis->position(*found)[1], 1.75, 1e-12);
    EXPECT_FALSE(basis->locate({0.5, 1.1, 0.3}).has_value()) << "within the inner circle";
    EXPECT_FALSE(basis->locate({2.0, 0.3, 0.3}).has_value()) << "before the first angle";
  }
}

TEST(Basis, splines_are_smooth_across_cells) {
  const auto basis = make_spline_basis<2>(grid_of(2, {4, 4}, {0, 0, 0}, {1, 1, 0}));
  EXPECT_EQ(basis->node_count(), 36);
  std::vector<Real> N(9), g(18);
  // Derivatives of one function from both sides of a face.
  const auto derivative = [&](Real x, Index node) {
    const auto point = *basis->locate({x, 0.4});
    basis->evaluate(point, N.data(), g.data());
    Real found = 0;
    for (int i = 0; i < 9; ++i) {
      if (basis->cell_nodes(point.element)[i] == node) found = g[static_cast<std::size_t>(2 * i)];
    }
    return found;
  };
  for (Index node = 0; node < 36; ++node) EXPECT_NEAR(derivative(0.5 - 1e-9, node), derivative(0.5 + 1e-9, node), 1e-6);
}

TEST(Basis, only_functions_of_a_side_are_not_zero_there) {
  for (const auto& basis : {make_spline_basis<2>(grid_of(2, {4, 3}, {0, 0, 0}, {1, 1, 0})),
                            make_element_basis<2>(grid_of(2, {4, 3}, {0, 0, 0}, {1, 1, 0}), 2)}) {
    const std::vector<Index> nodes = basis->side_nodes("right");
    EXPECT_EQ(nodes.size(), basis->is_interpolating() ? 7u : 5u);
    const auto point = *basis->locate({1, 0.37});
    std::vector<Real> N(9), g(18);
    basis->evaluate(point, N.data(), g.data());
    for (int i = 0; i < 9; ++i) {
      const bool is_on_side = std::find(nodes.begin(), nodes.end(), basis->cell_nodes(point.element)[i]) != nodes.end();
      EXPECT_TRUE(is_on_side || std::abs(N[static_cast<std::size_t>(i)]) < 1e-15);
    }
    EXPECT_EQ(basis->side_faces("right").size(), 3u);
    EXPECT_FALSE(basis->locate({1.0001, 0.5}).has_value());
  }
}

TEST(Basis, quadrature_integrates_products_of_gradients_exactly) {
  // int x^4 over a cell is the highest power that two gradients of quadratic functions, and a half of it, make.
  const auto basis = make_element_basis<2>(grid_of(2, {1, 1}, {0, 0, 0}, {2, 1, 0}), 2);
  Real volume = 0, fourth = 0;
  for (const auto& q : basis->quadrature(0)) {
    const Real x = 1 + q.point.xi[0];
    volume += q.weight;
    fourth += q.weight * std::pow(x, 4);
  }
  EXPECT_NEAR(volume, 2, 1e-14);
  EXPECT_NEAR(fourth, std::pow(2, 5) / 5, 1e-13);
}

}  // namespace
}  // namespace matpoint::test
