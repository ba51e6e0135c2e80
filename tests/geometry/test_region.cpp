// Regions: what is inside, how large it is, where its surface looks. Sizes are checked by counting points, normals by walking along them.
#include <cmath>
#include <limits>
#include <numbers>

#include "support/from_toml.hpp"

namespace matpoint::test {
namespace {

constexpr Real k_infinity = std::numeric_limits<Real>::infinity();
constexpr Real k_epsilon = std::numeric_limits<Real>::epsilon();

/// Area or volume from a lattice of n^dim points in the bounding box, each standing for its cell.
Real counted_measure(const Region& region, int dim, int n) {
  const Vec3 lower = region.lower(), upper = region.upper();
  Real cell = 1;
  for (std::size_t d = 0; d < static_cast<std::size_t>(dim); ++d) cell *= (upper[d] - lower[d]) / n;
  Index count = 0;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      for (int k = 0; k < (dim == 3 ? n : 1); ++k) {
        const std::array<int, 3> index{i, j, k};
        Vec3 x{};
        for (std::size_t d = 0; d < static_cast<std::size_t>(dim); ++d) x[d] = lower[d] + (index[d] + 0.5) * (upper[d] - lower[d]) / n;
        if (region.contains(x)) ++count;
      }
    }
  }
  return static_cast<Real>(count) * cell;
}

void expect_normals(const std::vector<Vec3>& normals, const std::vector<Vec3>& expected) {
  ASSERT_EQ(normals.size(), expected.size());
  for (const Vec3& wanted : expected) {
    bool is_there = false;
    for (const Vec3& n : normals) is_there = is_there || std::hypot(n[0] - wanted[0], n[1] - wanted[1], n[2] - wanted[2]) < 10 * k_epsilon;
    EXPECT_TRUE(is_there) << wanted[0] << " " << wanted[1] << " " << wanted[2];
  }
}

const char* const k_box2 = "{ type = 'box', lower = [-1.0, 0.5], upper = [2.0, 1.0] }";
const char* const k_box3 = "{ type = 'box', lower = [-1.0, 0.5, 0.0], upper = [2.0, 1.0, 4.0] }";
const char* const k_disk = "{ type = 'disk', center = [0.3, 0.2], radius = 0.7 }";
const char* const k_sphere = "{ type = 'sphere', center = [0.3, 0.2, 1.0], radius = 0.7 }";
// An L: the square of side 2 without its upper right quarter. Area 3.
const char* const k_concave = "{ type = 'polygon', vertices = [[0,0], [2,0], [2,1], [1,1], [1,2], [0,2]] }";
const char* const k_concave_reversed = "{ type = 'polygon', vertices = [[0,2], [1,2], [1,1], [2,1], [2,0], [0,0]] }";

TEST(Region, box_is_closed_and_has_its_measure) {
  const RegionPointer flat = region(k_box2);
  for (const Vec3& x : {Vec3{-1, 0.5, 0}, Vec3{2, 1, 0}, Vec3{0, 0.7, 0}}) EXPECT_TRUE(flat->contains(x));
  for (const Vec3& x : {Vec3{-1.0000001, 0.7, 0}, Vec3{2.0000001, 0.7, 0}, Vec3{0, 0.4999, 0}, Vec3{0, 1.0001, 0}})
    EXPECT_FALSE(flat->contains(x));
  EXPECT_DOUBLE_EQ(*flat->measure(2), 1.5);
  EXPECT_EQ(flat->lower(), (Vec3{-1, 0.5, 0}));
  EXPECT_EQ(flat->upper(), (Vec3{2, 1, 0}));
  const RegionPointer solid = region(k_box3, 3);
  EXPECT_DOUBLE_EQ(*solid->measure(3), 6);
  EXPECT_TRUE(solid->contains({0, 0.7, 4}));
  EXPECT_FALSE(solid->contains({0, 0.7, 4.001}));
  EXPECT_FALSE(solid->contains({0, 0.7, -0.001}));
}

TEST(Region, box_normal_is_that_of_the_nearest_face_and_of_all_at_edges_and_corners) {
  const RegionPointer flat = region(k_box2);
  expect_normals(flat->normals({-0.9, 0.7, 0}, 2), {{-1, 0, 0}});
  expect_normals(flat->normals({1.95, 0.7, 0}, 2), {{1, 0, 0}});
  expect_normals(flat->normals({0, 0.55, 0}, 2), {{0, -1, 0}});
  expect_normals(flat->normals({0, 1, 0}, 2), {{0, 1, 0}});
  expect_normals(flat->normals({2, 1, 0}, 2), {{1, 0, 0}, {0, 1, 0}});
  expect_normals(flat->normals({1.9, 0.9, 0}, 2), {{1, 0, 0}, {0, 1, 0}});
  const RegionPointer solid = region(k_box3, 3);
  expect_normals(solid->normals({0, 0.75, 0.1}, 3), {{0, 0, -1}});
  expect_normals(solid->normals({2, 1, 4}, 3), {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
  expect_normals(solid->normals({2, 0.75, 4}, 3), {{1, 0, 0}, {0, 0, 1}});
}

TEST(Region, half_space_lies_behind_its_plane_for_normals_of_any_length) {
  for (const Real length : {1e-200, 1.0, 7.0, 1e200}) {
    const Real angle = std::numbers::pi / 6;
    const Vec3 n{-std::sin(angle), std::cos(angle), 0};
    const RegionPointer half =
        region(fmt::format("{{ type = 'half_space', point = [1.0, 2.0], normal = [{}, {}] }}", n[0] * length, n[1] * length));
    for (const Real along : {-3.0, 0.0, 10.0}) {
      for (const Real out : {-5.0, -1e-9, 1e-9, 5.0}) {
        const Vec3 x{1 + along * n[1] + out * n[0], 2 - along * n[0] + out * n[1], 0};
        EXPECT_EQ(half->contains(x), out < 0) << along << " " << out;
      }
    }
    EXPECT_TRUE(half->contains({1, 2, 0}));
    expect_normals(half->normals({0, 0, 0}, 2), {n});
    EXPECT_FALSE(half->measure(2).has_value());
    EXPECT_EQ(half->lower(), (Vec3{-k_infinity, -k_infinity, -k_infinity}));
    EXPECT_EQ(half->upper(), (Vec3{k_infinity, k_infinity, k_infinity}));
  }
  const RegionPointer space = region("{ type = 'half_space', point = [0.0, 0.0, 3.0], normal = [1.0, 2.0, 2.0] }", 3);
  expect_normals(space->normals({0, 0, 0}, 3), {{1.0 / 3, 2.0 / 3, 2.0 / 3}});
  EXPECT_TRUE(space->contains({2, 2, 0}));  // 2 + 4 + 2 (0 - 3) = 0: on the plane
  EXPECT_FALSE(space->contains({2.001, 2, 0}));
}

TEST(Region, half_space_along_an_axis_is_bounded_on_one_side) {
  const RegionPointer below = region("{ type = 'half_space', point = [5.0, 0.1], normal = [0.0, 3.0] }");
  EXPECT_EQ(below->upper(), (Vec3{k_infinity, 0.1, k_infinity}));
  EXPECT_EQ(below->lower(), (Vec3{-k_infinity, -k_infinity, -k_infinity}));
  EXPECT_TRUE(below->contains({-1e9, 0.1, 0})) << "a plane along an axis is exact";
  EXPECT_FALSE(below->contains({0, std::nextafter(0.1, 1.0), 0}));
  const RegionPointer right = region("{ type = 'half_space', point = [0.3, 0.1], normal = [-0.2, 0.0] }");
  EXPECT_EQ(right->lower(), (Vec3{0.3, -k_infinity, -k_infinity}));
  EXPECT_TRUE(right->contains({0.3, 7, 0}));
}

TEST(Region, cylinder_has_its_measure_box_and_normals) {
  // Along an axis, and aslant: 1.5 m from (0.3, 0.2, 1).
  for (const char* const text : {"{ type = 'cylinder', start = [0.3, 0.2, 1.0], end = [0.3, 1.7, 1.0], radius = 0.7 }",
                                 "{ type = 'cylinder', start = [0.3, 0.2, 1.0], end = [1.3, 1.2, 1.5], radius = 0.7 }",
                                 "{ type = 'cylinder', start = [1.3, 1.2, 1.5], end = [0.3, 0.2, 1.0], radius = 0.7 }"}) {
    const RegionPointer bar = region(text, 3);
    EXPECT_NEAR(*bar->measure(3), std::numbers::pi * 0.49 * 1.5, 1e-14);
    EXPECT_NEAR(counted_measure(*bar, 3, 80), *bar->measure(3), 0.01 * *bar->measure(3));
    // The box touches the surface everywhere: a little smaller it would cut some of it off.
    const Vec3 lower = bar->lower(), upper = bar->upper();
    Vec3 least{9, 9, 9}, most{-9, -9, -9};
    for (int k = 0; k < 200'000; ++k) {
      const Vec3 x{lower[0] - 0.1 + std::fmod(k * 0.7548776662, 1) * (upper[0] - lower[0] + 0.2),
                   lower[1] - 0.1 + std::fmod(k * 0.5698402910, 1) * (upper[1] - lower[1] + 0.2),
                   lower[2] - 0.1 + std::fmod(k * 0.3141592654, 1) * (upper[2] - lower[2] + 0.2)};
      if (!bar->contains(x)) continue;
      for (std::size_t d = 0; d < 3; ++d) {
        least[d] = std::min(least[d], x[d]);
        most[d] = std::max(most[d], x[d]);
      }
      // A step outwards as long as to the nearest surface ends on it: a bit less is inside, a bit more is not.
      for (const Vec3& n : bar->normals(x, 3)) {
        EXPECT_NEAR(std::hypot(n[0], n[1], n[2]), 1, 1e-12);
        const auto at = [&](Real way) { return Vec3{x[0] + way * n[0], x[1] + way * n[1], x[2] + way * n[2]}; };
        EXPECT_FALSE(bar->contains(at(0.7500001))) << "the nearest surface is at most half of the length away";
        Real low = 0, high = 0.76;
        for (int half = 0; half < 40; ++half) (bar->contains(at((low + high) / 2)) ? low : high) = (low + high) / 2;
        // In no other direction it is nearer.
        for (const Vec3& m : {Vec3{n[1], n[2], n[0]}, Vec3{-n[0], -n[1], -n[2]}, Vec3{n[2], -n[0], n[1]}})
          EXPECT_TRUE(bar->contains({x[0] + 0.999 * low * m[0], x[1] + 0.999 * low * m[1], x[2] + 0.999 * low * m[2]}));
      }
    }
    for (std::size_t d = 0; d < 3; ++d) {
      EXPECT_GE(least[d], lower[d]);
      EXPECT_LE(most[d], upper[d]);
      EXPECT_LT(least[d], lower[d] + 0.06);
      EXPECT_GT(most[d], upper[d] - 0.06);
    }
  }
  const RegionPointer bar = region("{ type = 'cylinder', start = [0, 0, 0], end = [0, 0, 4], radius = 1 }", 3);
  expect_normals(bar->normals({0, 0, 2}, 3), {{1, 0, 0}, {0, 1, 0}});
  expect_normals(bar->normals({0.5, 0, 2}, 3), {{1, 0, 0}});
  expect_normals(bar->normals({0, 0, 3.5}, 3), {{0, 0, 1}});
  EXPECT_TRUE(bar->reaches({1 + 1e-9, 0, 2}, 1e-8));
  EXPECT_FALSE(bar->contains({1 + 1e-9, 0, 2}));
  EXPECT_TRUE(bar->contains({0, 1, 4}));
}

TEST(Region, disk_and_sphere_have_their_measure_box_and_radial_normals) {
  for (const int dim : {2, 3}) {
    const RegionPointer ball = region(dim == 2 ? k_disk : k_sphere, dim);
    const Vec3 center{0.3, 0.2, dim == 3 ? 1.0 : 0.0};
    const Real exact = dim == 2 ? std::numbers::pi * 0.49 : 4 * std::numbers::pi / 3 * 0.343;
    EXPECT_DOUBLE_EQ(*ball->measure(dim), exact);
    const int n = dim == 2 ? 400 : 80;
    // Only cells cut by the surface, at most half a diagonal away from it, can count wrong: surface times diagonal, over two as half of
    // each is right on average.
    const Real surface = dim == 2 ? 2 * std::numbers::pi * 0.7 : 4 * std::numbers::pi * 0.49;
    EXPECT_NEAR(counted_measure(*ball, dim, n), exact, surface * 1.4 / n * std::sqrt(dim) / 2);
    for (std::size_t d = 0; d < static_cast<std::size_t>(dim); ++d) {
      EXPECT_DOUBLE_EQ(ball->lower()[d], center[d] - 0.7);
      EXPECT_DOUBLE_EQ(ball->upper()[d], center[d] + 0.7);
    }
    const Vec3 r = dim == 2 ? Vec3{0.6, -0.8, 0} : Vec3{2.0 / 7, -3.0 / 7, 6.0 / 7};
    const auto at = [&](Real distance) {
      return Vec3{center[0] + distance * r[0], center[1] + distance * r[1], center[2] + distance * r[2]};
    };
    expect_normals(ball->normals(at(0.7), dim), {r});
    expect_normals(ball->normals(at(0.1), dim), {r});
    EXPECT_TRUE(ball->contains(at(0.7 * (1 - 4 * k_epsilon))));
    EXPECT_FALSE(ball->contains(at(0.7 * (1 + 4 * k_epsilon))));
  }
}

TEST(Region, polygon_counts_its_area_and_knows_its_inside_in_both_orientations) {
  for (const char* text : {k_concave, k_concave_reversed}) {
    const RegionPointer L = region(text);
    EXPECT_DOUBLE_EQ(*L->measure(2), 3);
    EXPECT_DOUBLE_EQ(counted_measure(*L, 2, 100), 3) << "no lattice point lies on an edge: the count is exact";
    EXPECT_TRUE(L->contains({0.5, 1.5, 0}));
    EXPECT_TRUE(L->contains({1.5, 0.5, 0}));
    EXPECT_FALSE(L->contains({1.5, 1.5, 0}));
    EXPECT_FALSE(L->contains({-1, 1, 0})) << "on the line of an edge, but outside";
    EXPECT_EQ(L->lower(), (Vec3{0, 0, 0}));
    EXPECT_EQ(L->upper(), (Vec3{2, 2, 0}));
    // All of the outline belongs to it, and nothing beside the outline does.
    const Real step = 1.0 / 64;
    for (Real s = 0; s <= 1; s += step) {
      for (const Vec3& x : {Vec3{2 * s, 0, 0}, Vec3{2, s, 0}, Vec3{1 + s, 1, 0}, Vec3{1, 1 + s, 0}, Vec3{s, 2, 0}, Vec3{0, 2 * s, 0}}) {
        EXPECT_TRUE(L->contains(x)) << x[0] << " " << x[1];
      }
      for (const Vec3& x : {Vec3{2 * s, -1e-9, 0}, Vec3{2 + 1e-9, s, 0}, Vec3{1 + s + 1e-3, 1 + 1e-9, 0}, Vec3{-1e-9, 2 * s, 0}}) {
        EXPECT_FALSE(L->contains(x)) << x[0] << " " << x[1];
      }
    }
    expect_normals(L->normals({0.5, 0.01, 0}, 2), {{0, -1, 0}});
    expect_normals(L->normals({1.99, 0.5, 0}, 2), {{1, 0, 0}});
    expect_normals(L->normals({1.5, 0.99, 0}, 2), {{0, 1, 0}});
    expect_normals(L->normals({0.99, 1.5, 0}, 2), {{1, 0, 0}});
    expect_normals(L->normals({2, 0, 0}, 2), {{0, -1, 0}, {1, 0, 0}});
    expect_normals(L->normals({1, 1, 0}, 2), {{0, 1, 0}, {1, 0, 0}});
  }
}

TEST(Region, polygon_with_slanted_edges_has_normals_at_right_angles_to_them) {
  const Real c = std::sqrt(0.5);
  for (const char* vertices : {"[[0,0], [1,0], [0,1]]", "[[0,0], [0,1], [1,0]]"}) {
    const RegionPointer triangle = region(fmt::format("{{ type = 'polygon', vertices = {} }}", vertices));
    EXPECT_DOUBLE_EQ(*triangle->measure(2), 0.5);
    expect_normals(triangle->normals({0.5, 0.5, 0}, 2), {{c, c, 0}});
    expect_normals(triangle->normals({0.48, 0.48, 0}, 2), {{c, c, 0}});
    for (const Real s : {0.0, 0.1, 0.3, 0.7, 0.9}) EXPECT_TRUE(triangle->contains({s, 1 - s, 0})) << s;
    EXPECT_FALSE(triangle->contains({0.5, 0.5 + 1e-9, 0}));
  }
  // A star with five corners: the area by counting, the boundary by its edges.
  std::string star = "{ type = 'polygon', vertices = [";
  for (int k = 0; k < 10; ++k) {
    const Real radius = k % 2 == 0 ? 1 : 0.4;
    star += fmt::format("{}[{}, {}]", k > 0 ? ", " : "", radius * std::cos(k * std::numbers::pi / 5),
                        radius * std::sin(k * std::numbers::pi / 5));
  }
  const RegionPointer region_star = region(star + "] }");
  const Real area = 10 * 0.5 * 1 * 0.4 * std::sin(std::numbers::pi / 5);  // ten triangles from the centre
  EXPECT_NEAR(*region_star->measure(2), area, 20 * k_epsilon);
  // Ten edges of 0.72 m, cells of 0.005 m: as for the disk.
  EXPECT_NEAR(counted_measure(*region_star, 2, 400), area, 7.2 * 0.005 * std::sqrt(2) / 2);
}

TEST(Region, union_and_difference_are_pointwise_or_and_and_not) {
  for (const int dim : {2, 3}) {
    const std::string a = dim == 2 ? k_box2 : k_box3, b = dim == 2 ? k_disk : k_sphere;
    const RegionPointer first = region(a, dim), second = region(b, dim);
    const RegionPointer both = region("{ type = 'union', of = [" + a + ", " + b + "] }", dim);
    const RegionPointer rest = region("{ type = 'difference', of = [" + a + ", " + b + "] }", dim);
    int seen[2][2] = {};
    for (Real x = -1.5; x < 2.5; x += 0.13) {
      for (Real y = -1; y < 1.5; y += 0.11) {
        for (Real z = dim == 3 ? -0.5 : 0; z < (dim == 3 ? 4.5 : 0.1); z += 0.17) {
          const Vec3 point{x, y, dim == 3 ? z : 0};
          const bool in_first = first->contains(point), in_second = second->contains(point);
          ++seen[in_first][in_second];
          EXPECT_EQ(both->contains(point), in_first || in_second);
          EXPECT_EQ(rest->contains(point), in_first && !in_second);
        }
      }
    }
    for (const auto& row : seen) {
      for (const int count : row) EXPECT_GT(count, 0) << "the parts should overlap";
    }
    EXPECT_FALSE(both->measure(dim).has_value());
    EXPECT_FALSE(rest->measure(dim).has_value());
    EXPECT_FALSE(both->has_normal());
    EXPECT_FALSE(rest->has_normal());
    for (std::size_t d = 0; d < static_cast<std::size_t>(dim); ++d) {
      EXPECT_EQ(both->lower()[d], std::min(first->lower()[d], second->lower()[d]));
      EXPECT_EQ(both->upper()[d], std::max(first->upper()[d], second->upper()[d]));
      EXPECT_EQ(rest->lower()[d], first->lower()[d]);
      EXPECT_EQ(rest->upper()[d], first->upper()[d]);
    }
  }
  const RegionPointer cut = region(
      "{ type = 'difference', of = [{ type = 'disk', center = [0, 0], radius = 1 }, { type = 'half_space', point = [0, 0], normal = [0, "
      "-1] }] }");
  EXPECT_FALSE(cut->contains({0, 0.5, 0}));
  EXPECT_FALSE(cut->contains({0.5, 0, 0})) << "the boundary of what is cut out is removed with it";
  EXPECT_TRUE(cut->contains({0, -0.5, 0}));
}

TEST(Region, following_a_normal_leaves_the_region_by_the_shortest_way) {
  // From each inner point, the surface in the direction of the normal is as near as in the best of 180 directions.
  for (const char* text : {k_box2, k_disk, k_concave, k_concave_reversed}) {
    const RegionPointer shape = region(text);
    const auto way_out = [&](const Vec3& x, Real nx, Real ny) {
      Real inside = 0, outside = 4;
      for (Real s = 0; s < 4; s += 0.01) {
        if (!shape->contains({x[0] + s * nx, x[1] + s * ny, 0})) {
          outside = s;
          inside = s - 0.01;
          break;
        }
      }
      for (int k = 0; k < 40; ++k)
        (shape->contains({x[0] + (inside + outside) / 2 * nx, x[1] + (inside + outside) / 2 * ny, 0}) ? inside : outside) =
            (inside + outside) / 2;
      return outside;
    };
    int checked = 0;
    for (Real u = 0.07; u < 1; u += 0.19) {
      for (Real v = 0.05; v < 1; v += 0.17) {
        const Vec3 lower = shape->lower(), upper = shape->upper();
        const Vec3 x{lower[0] + u * (upper[0] - lower[0]), lower[1] + v * (upper[1] - lower[1]), 0};
        const std::vector<Vec3> normals = shape->normals(x, 2);
        if (!shape->contains(x) || normals.size() != 1) continue;
        EXPECT_NEAR(std::hypot(normals[0][0], normals[0][1]), 1, 10 * k_epsilon);
        Real best = 10;
        for (int k = 0; k < 180; ++k)
          best = std::min(best, way_out(x, std::cos(k * std::numbers::pi / 90), std::sin(k * std::numbers::pi / 90)));
        EXPECT_LT(way_out(x, normals[0][0], normals[0][1]), best + 1e-9) << text << " at " << x[0] << " " << x[1];
        ++checked;
      }
    }
    EXPECT_GT(checked, 10);
  }
}

TEST(Region, without_size_or_in_the_wrong_dimension_is_refused) {
  const auto text = [](const std::string& toml, int dim = 2) { return complaint_of([&] { region(toml, dim); }); };
  const auto expect = [](const std::string& given, const std::string& part) { EXPECT_NE(given.find(part), std::string::npos) << given; };
  expect(text("{ type = 'box', lower = [0, 0], upper = [1, 0] }"), "upper[1] = 0 must be greater than lower[1] = 0");
  expect(text("{ type = 'box', lower = [0, 0], upper = [1e200, 1e200] }"), "its area of inf m^2 is beyond the range of numbers");
  expect(text("{ type = 'half_space', point = [0, 0], normal = [0, 0] }"), "normal = [0, 0] must not be zero");
  expect(text("{ type = 'disk', center = [0, 0], radius = 0 }"), "radius = 0 is not allowed, it must be > 0");
  expect(text("{ type = 'disk', center = [0, 0, 0], radius = 1 }", 3), "a disk exists in 2D only, use type = \"sphere\"");
  expect(text("{ type = 'sphere', center = [0, 0], radius = 1 }"), "a sphere exists in 3D only, use type = \"disk\"");
  expect(text("{ type = 'cylinder', start = [0, 0], end = [0, 1], radius = 1 }"), "a cylinder exists in 3D only, use type = \"box\"");
  expect(text("{ type = 'cylinder', start = [0, 0, 1], end = [0, 0, 1], radius = 1 }", 3), "end must be another point than start");
  expect(text("{ type = 'polygon', vertices = [[0, 0], [1, 0]] }"), "vertices has 2 points, a polygon needs at least 3");
  expect(text("{ type = 'polygon', vertices = [[0, 0], [1, 1], [2, 2]] }"), "the polygon's area is zero");
  expect(text("{ type = 'polygon', vertices = [[0, 0], [1, 1], [1, 0], [0, 1]] }"), "the polygon crosses or touches itself");
  expect(text("{ type = 'polygon', vertices = [[0, 0], [0, 0], [1, 0], [0, 1]] }"),
         "vertices[0] and vertices[1] are the same point [0, 0]");
  expect(text("{ type = 'polygon', vertices = [[0, 0], [2, 0], [1, 0], [1, 1]] }"),
         "the polygon folds back on itself at vertices[1] = [2, 0]");
  expect(text("{ type = 'union', of = [" + std::string(k_disk) + "] }"), "of has 1 regions, a union needs at least 2");
}

TEST(Region, written_regions_read_back_as_the_same) {
  for (const char* text : {k_box2, k_disk, k_concave, "{ type = 'half_space', point = [0.1, 0.2], normal = [1.0, 3.0] }"}) {
    const std::string joined = "{ type = 'union', of = [" + std::string(text) + ", " + k_disk + "] }";
    for (const std::string& toml : {std::string(text), joined}) {
      const RegionPointer original = region(toml);
      const RegionPointer again = region_registry().read(original->write(2), {2, ""}, "region");
      for (Real x = -1.5; x < 2.5; x += 0.19) {
        for (Real y = -1.5; y < 2.5; y += 0.17) EXPECT_EQ(original->contains({x, y, 0}), again->contains({x, y, 0}));
      }
    }
  }
}

TEST(Region, reaches_what_rounding_has_moved_off_its_face_and_nothing_else) {
  const Real tolerance = 1e-10;
  const std::vector<std::pair<RegionPointer, Vec3>> faces = {
      {region("{ type = 'box', lower = [0, 0], upper = [1, 0.3] }"), {0.5, 0.3, 0}},
      {region("{ type = 'disk', center = [0.5, 0], radius = 0.3 }"), {0.5, 0.3, 0}},
      {region("{ type = 'half_space', point = [0, 0.3], normal = [0, 2] }"), {0.5, 0.3, 0}},
      {region("{ type = 'polygon', vertices = [[0, 0], [1, 0], [1, 0.3], [0, 0.3]] }"), {0.5, 0.3, 0}},
      {region("{ type = 'union', of = [{ type = 'box', lower = [0, 0], upper = [1, 0.3] }, { type = 'box', lower = [5, 5], upper = [6, 6] "
              "}] }"),
       {0.5, 0.3, 0}}};
  for (const auto& [shape, place] : faces) {
    EXPECT_TRUE(shape->reaches({place[0], place[1] + 0.5 * tolerance, 0}, tolerance));
    EXPECT_FALSE(shape->reaches({place[0], place[1] + 2 * tolerance, 0}, tolerance));
    EXPECT_FALSE(shape->contains({place[0], place[1] + 0.5 * tolerance, 0}));
  }
  // What is cut out is closed: a node on its face is out, on either side of rounding.
  const RegionPointer cut = region(
      "{ type = 'difference', of = [{ type = 'box', lower = [0, 0], upper = [1, 1] }, { type = 'box', lower = [0, 0], upper = [1, 0.3] }] "
      "}");
  for (const Real off : {-0.5, 0.5}) EXPECT_FALSE(cut->reaches({0.5, 0.3 + off * tolerance, 0}, tolerance));
  EXPECT_TRUE(cut->reaches({0.5, 0.3 + 2 * tolerance, 0}, tolerance));
  // Far below a cell, above the rounding of far-away nodes.
  EXPECT_LT(node_tolerance({1, 1, 0}, 0.1), 1e-9);
  EXPECT_GT(node_tolerance({5e5, 4.6e6, 0}, 0.05), 4.6e6 * std::numeric_limits<Real>::epsilon());
}

}  // namespace
}  // namespace matpoint::test
