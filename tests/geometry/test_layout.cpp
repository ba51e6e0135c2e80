// Layouts: the published particle counts, the places and volumes of the particles, moments.
#include <cmath>
#include <numbers>

#include "support/from_toml.hpp"

namespace matpoint::test {
namespace {

constexpr Real k_epsilon = std::numeric_limits<Real>::epsilon();
const SeedingGrid k_unit_grid{2, {0, 0, 0}, {1, 1, 0}, {0.1, 0.1, 0}};

Real sum(const std::vector<Real>& values) {
  Real total = 0;
  for (const Real value : values) total += value;
  return total;
}
/// Sum of V x^a y^b, a and b from 0 to 2.
Real moment(const Seeds& seeds, int a, int b) {
  Real total = 0;
  for (std::size_t p = 0; p < seeds.position.size(); ++p)
    total += seeds.volume[p] * std::pow(seeds.position[p][0], a) * std::pow(seeds.position[p][1], b);
  return total;
}

TEST(Lattice, gives_the_counts_of_the_thesis_and_volumes_that_sum_to_the_body) {
  struct Row {
    const char* region;
    const char* layout;
    std::size_t count;
    Real area;
  };
  const Real disk = std::numbers::pi * 0.2 * 0.2;
  // Kamuth (thesis on explicit MPM): two disks, coarse and fine; the drop; a triangle.
  const Row rows[] = {
      {"{ type = 'disk', center = [0.2, 0.2], radius = 0.2 }", "{ type = 'lattice', divisions = 10, points = 2 }", 316, disk},
      {"{ type = 'disk', center = [0.8, 0.8], radius = 0.2 }", "{ type = 'lattice', divisions = 10, points = 2 }", 316, disk},
      {"{ type = 'disk', center = [0.2, 0.2], radius = 0.2 }", "{ type = 'lattice', divisions = [31, 31], points = 2 }", 3016, disk},
      {"{ type = 'disk', center = [0.5, 0.7], radius = 0.2 }", "{ type = 'lattice', divisions = 20, points = 2 }", 1256, disk},
      {"{ type = 'polygon', vertices = [[0.1, 0.0], [0.3, 0.0], [0.2, 0.2]] }", "{ type = 'lattice', divisions = 10, points = 2 }", 200,
       0.02},
  };
  for (const Row& row : rows) {
    const Seeds seeds = layout(row.layout)->fill(region(row.region).get(), k_unit_grid);
    EXPECT_EQ(seeds.position.size(), row.count) << row.region << " " << row.layout;
    EXPECT_EQ(seeds.volume.size(), row.count);
    EXPECT_NEAR(sum(seeds.volume), row.area, static_cast<Real>(row.count) * k_epsilon * row.area);
    EXPECT_EQ(seeds.volume.front(), seeds.volume.back()) << "all particles weigh the same";
  }
}

TEST(Lattice, goes_through_x_outside_and_y_inside_in_boxes_and_in_the_points_of_a_box) {
  const RegionPointer box = region("{ type = 'box', lower = [1.0, 0.0], upper = [3.0, 3.0] }");
  const Seeds middles = layout("{ type = 'lattice', divisions = [2, 3] }")->fill(box.get(), k_unit_grid);
  ASSERT_EQ(middles.position.size(), 6u);
  for (std::size_t p = 0; p < 6; ++p) {
    EXPECT_DOUBLE_EQ(middles.position[p][0], 1.5 + static_cast<Real>(p / 3));
    EXPECT_DOUBLE_EQ(middles.position[p][1], 0.5 + static_cast<Real>(p % 3));
    EXPECT_DOUBLE_EQ(middles.volume[p], 1);
  }
  const Seeds gauss = layout("{ type = 'lattice', divisions = [1, 3], points = 2 }")->fill(box.get(), k_unit_grid);
  ASSERT_EQ(gauss.position.size(), 12u);
  const Real g = 1 / (2 * std::sqrt(3.0));
  for (std::size_t p = 0; p < 12; ++p) {
    const auto box_y = static_cast<Real>(p / 4);
    EXPECT_NEAR(gauss.position[p][0], 2 + (p % 4 < 2 ? -g : g) * 2, 10 * k_epsilon) << p;
    EXPECT_NEAR(gauss.position[p][1], box_y + 0.5 + (p % 2 == 0 ? -g : g), 10 * k_epsilon) << p;
    EXPECT_DOUBLE_EQ(gauss.volume[p], 0.5);
  }
}

TEST(Lattice, gauss_points_integrate_cubics_over_a_box_exactly) {
  // Two Gauss points per direction are exact to the third degree: x^2 y^2 and x^3 tell them from any other points.
  const Seeds seeds = layout("{ type = 'lattice', divisions = [2, 1], points = 2 }")
                          ->fill(region("{ type = 'box', lower = [0, 0], upper = [1, 2] }").get(), k_unit_grid);
  EXPECT_NEAR(moment(seeds, 2, 2), 1.0 / 3 * 8 / 3, 20 * k_epsilon);
  EXPECT_NEAR(moment(seeds, 3, 0), 2 * 1.0 / 4, 20 * k_epsilon);
  EXPECT_NEAR(moment(seeds, 0, 3), 4, 100 * k_epsilon);
}

TEST(Lattice, in_3d_runs_z_innermost) {
  const SeedingGrid grid{3, {0, 0, 0}, {1, 1, 1}, {0.1, 0.1, 0.1}};
  const Seeds seeds = layout("{ type = 'lattice', divisions = [2, 3, 4], points = 1 }", 3)
                          ->fill(region("{ type = 'box', lower = [0, 0, 0], upper = [2, 3, 4] }", 3).get(), grid);
  ASSERT_EQ(seeds.position.size(), 24u);
  for (std::size_t p = 0; p < 24; ++p) {
    EXPECT_DOUBLE_EQ(seeds.position[p][0], 0.5 + static_cast<Real>(p / 12));
    EXPECT_DOUBLE_EQ(seeds.position[p][1], 0.5 + static_cast<Real>(p / 4 % 3));
    EXPECT_DOUBLE_EQ(seeds.position[p][2], 0.5 + static_cast<Real>(p % 4));
  }
  EXPECT_NEAR(sum(seeds.volume), 24, 100 * k_epsilon);
  const Seeds ball = layout("{ type = 'lattice', divisions = 20, points = 2 }", 3)
                         ->fill(region("{ type = 'sphere', center = [0.5, 0.5, 0.5], radius = 0.2 }", 3).get(), grid);
  const Real volume = 4 * std::numbers::pi / 3 * 0.008;
  EXPECT_NEAR(sum(ball.volume), volume, static_cast<Real>(ball.volume.size()) * k_epsilon * volume);
  // 40^3 points in the cube around the ball: pi/6 of them are inside, but for those near the surface (as in the tests of regions).
  EXPECT_NEAR(static_cast<Real>(ball.volume.size()), 64000 * std::numbers::pi / 6, std::numbers::pi * 1600 * std::sqrt(3.0) / 2);
}

TEST(Lattice, of_a_region_without_a_formula_gives_each_particle_its_box) {
  const std::string ring =
      "{ type = 'difference', of = [{ type = 'disk', center = [0, 0], radius = 1 }, { type = 'disk', center = [0, 0], radius = 0.5 }] }";
  const Seeds seeds = layout("{ type = 'lattice', divisions = 200 }")->fill(region(ring).get(), k_unit_grid);
  EXPECT_DOUBLE_EQ(seeds.volume.front(), 0.01 * 0.01);
  // Cells along the two circles, 9.4 m in all, half a diagonal on either side, half of them right.
  EXPECT_NEAR(sum(seeds.volume), 0.75 * std::numbers::pi, 9.4 * 0.01 * std::sqrt(2) / 2);
}

TEST(PerCell, puts_the_same_points_into_each_cell_of_a_shifted_grid) {
  const SeedingGrid grid{2, {-0.35, 0.07, 0}, {10, 10, 0}, {0.2, 0.5, 0}};
  // Two cells along x, three along y, on the lines of the grid.
  const RegionPointer box = region("{ type = 'box', lower = [0.05, 0.57], upper = [0.45, 2.07] }");
  const Seeds seeds = layout("{ type = 'per_cell', count = [2, 3] }")->fill(box.get(), grid);
  ASSERT_EQ(seeds.position.size(), 2u * 3u * 6u);
  std::map<std::pair<int, int>, std::vector<std::pair<Real, Real>>> cells;
  for (const Vec3& x : seeds.position) {
    const Real a = (x[0] - grid.lower[0]) / 0.2, b = (x[1] - grid.lower[1]) / 0.5;
    cells[{static_cast<int>(std::floor(a)), static_cast<int>(std::floor(b))}].emplace_back(a - std::floor(a), b - std::floor(b));
  }
  EXPECT_EQ(cells.size(), 6u);
  for (const auto& [cell, points] : cells) {
    EXPECT_GE(cell.first, 2);
    EXPECT_LE(cell.first, 3);
    EXPECT_GE(cell.second, 1);
    EXPECT_LE(cell.second, 3);
    ASSERT_EQ(points.size(), 6u);
    for (std::size_t p = 0; p < 6; ++p) {
      EXPECT_NEAR(points[p].first, p < 3 ? 0.25 : 0.75, 100 * k_epsilon);
      EXPECT_NEAR(points[p].second, (static_cast<Real>(p % 3) + 0.5) / 3, 100 * k_epsilon);
    }
  }
  EXPECT_NEAR(sum(seeds.volume), 0.4 * 1.5, 100 * k_epsilon);
  for (std::size_t p = 1; p < seeds.position.size(); ++p) {
    const Vec3 &a = seeds.position[p - 1], &b = seeds.position[p];
    EXPECT_TRUE(b[0] > a[0] + 1e-9 || (std::abs(b[0] - a[0]) < 1e-9 && b[1] > a[1])) << "x outside, y inside";
  }
}

TEST(PerCell, one_number_is_spread_evenly_and_works_in_3d_and_for_regions_off_the_grid_lines) {
  const Seeds flat =
      layout("{ type = 'per_cell', count = 4 }")->fill(region("{ type = 'box', lower = [0, 0], upper = [1, 1] }").get(), k_unit_grid);
  EXPECT_EQ(flat.position.size(), 400u);
  EXPECT_NEAR(flat.position[0][0], 0.025, 10 * k_epsilon);
  const SeedingGrid grid{3, {0.1, 0, -0.2}, {10, 10, 10}, {0.25, 0.25, 0.5}};
  const Seeds solid = layout("{ type = 'per_cell', count = 8 }", 3)
                          ->fill(region("{ type = 'box', lower = [0.1, 0, -0.2], upper = [1.1, 1, 0.8] }", 3).get(), grid);
  EXPECT_EQ(solid.position.size(), 8u * 4 * 4 * 2);
  EXPECT_NEAR(sum(solid.volume), 1, 256 * k_epsilon);
  // The disk ends inside of cells; its particles still sit where those of any other body would.
  const Seeds disk = layout("{ type = 'per_cell', count = 4 }")
                         ->fill(region("{ type = 'disk', center = [0.53, 0.41], radius = 0.33 }").get(), k_unit_grid);
  for (const Vec3& x : disk.position) {
    for (std::size_t d = 0; d < 2; ++d) EXPECT_NEAR(x[d] / 0.05 - 0.5, std::round(x[d] / 0.05 - 0.5), 100 * k_epsilon);
  }
  EXPECT_NEAR(sum(disk.volume), std::numbers::pi * 0.33 * 0.33, 200 * k_epsilon);
}

TEST(Polar, rings_have_the_moments_of_a_disk) {
  const Real r = 0.4;
  for (const char* text : {"{ type = 'polar', rings = 20 }", "{ type = 'polar', rings = 20, sectors = 64 }"}) {
    const Seeds seeds = layout(text)->fill(region("{ type = 'disk', center = [0, 0], radius = 0.4 }").get(), k_unit_grid);
    const Real area = std::numbers::pi * r * r;
    const Real bound = static_cast<Real>(seeds.volume.size()) * k_epsilon;
    EXPECT_NEAR(sum(seeds.volume), area, bound * area);
    EXPECT_NEAR(moment(seeds, 1, 0), 0, bound * area * r);
    EXPECT_NEAR(moment(seeds, 0, 1), 0, bound * area * r);
    EXPECT_NEAR(moment(seeds, 1, 1), 0, bound * area * r * r);
    EXPECT_NEAR(moment(seeds, 2, 0), moment(seeds, 0, 2), bound * area * r * r);
    // Points at the centres of mass leave out the pieces' own moments of inertia: width^2/12 along and across, which is
    // (r/20)^2/12 : r^2/4 = 1/1200 of the disk's for pieces that are about square, and at most the mean of that and 1/622 with 64 sectors.
    const Real exact = std::numbers::pi * r * r * r * r / 4;
    EXPECT_LT(moment(seeds, 2, 0), exact);
    EXPECT_NEAR(moment(seeds, 2, 0), exact, exact / 400);
  }
}

TEST(Polar, particles_are_the_centers_of_mass_of_their_pieces) {
  // Four quarters of a disk: 4 r/(3 pi) from either straight side.
  const Seeds quarters = layout("{ type = 'polar', rings = 1, sectors = 4 }")
                             ->fill(region("{ type = 'disk', center = [0, 0], radius = 3 }").get(), k_unit_grid);
  EXPECT_NEAR(quarters.position[0][0], 4 / std::numbers::pi, 10 * k_epsilon);
  EXPECT_NEAR(quarters.position[0][1], 4 / std::numbers::pi, 10 * k_epsilon);
}

TEST(Polar, second_moment_converges_with_the_square_of_the_rings) {
  const auto error = [](int rings) {
    const Seeds seeds = layout(fmt::format("{{ type = 'polar', rings = {} }}", rings))
                            ->fill(region("{ type = 'disk', center = [0, 0], radius = 1 }").get(), k_unit_grid);
    return std::numbers::pi / 4 - moment(seeds, 2, 0);
  };
  EXPECT_NEAR(std::log2(error(10) / error(20)), 2, 0.1);
  EXPECT_NEAR(std::log2(error(20) / error(40)), 2, 0.1);
}

TEST(Polar, follows_the_center_and_keeps_ring_by_ring_order) {
  const Seeds seeds = layout("{ type = 'polar', rings = 3, sectors = 5 }")
                          ->fill(region("{ type = 'disk', center = [2, -1], radius = 0.3 }").get(), k_unit_grid);
  ASSERT_EQ(seeds.position.size(), 15u);
  for (std::size_t p = 0; p < 15; ++p) {
    const Real distance = std::hypot(seeds.position[p][0] - 2, seeds.position[p][1] + 1);
    EXPECT_GT(distance, 0.1 * static_cast<Real>(p / 5) * std::sin(std::numbers::pi / 5) / (std::numbers::pi / 5));
    EXPECT_LT(distance, 0.1 * static_cast<Real>(p / 5 + 1));
    // Rings of radii k to k+1: areas as 1 : 3 : 5.
    EXPECT_NEAR(seeds.volume[p], std::numbers::pi * 0.01 / 5 * static_cast<Real>(2 * (p / 5) + 1), 10 * k_epsilon);
  }
}

TEST(Layout, that_cannot_fill_its_region_is_refused) {
  const RegionPointer half = region("{ type = 'half_space', point = [0, 0], normal = [0, 1] }");
  const RegionPointer box = region("{ type = 'box', lower = [0, 0], upper = [1, 1] }");
  const auto text = [](const char* toml, const Region& shape) { return complaint_of([&] { layout(toml)->fill(&shape, k_unit_grid); }); };
  EXPECT_NE(text("{ type = 'lattice', divisions = 4 }", *half).find("its region is unbounded"), std::string::npos);
  EXPECT_NE(text("{ type = 'per_cell', count = 4 }", *half).find("its region is unbounded"), std::string::npos);
  EXPECT_NE(text("{ type = 'polar', rings = 4 }", *box).find("layout type = \"polar\" fills disks only"), std::string::npos);
  EXPECT_NE(text("{ type = 'lattice', divisions = 100000 }", *box).find("its layout would try 1e+10 places"), std::string::npos);
  EXPECT_NE(text("{ type = 'lattice', divisions = [1, 2, 3] }", *box).find("has 3 numbers; give one, or one per direction (2)"),
            std::string::npos);
  EXPECT_NE(text("{ type = 'lattice', divisions = 0 }", *box).find("divisions = 0 is not allowed, it must be >= 1"), std::string::npos);
  EXPECT_NE(text("{ type = 'lattice', divisions = 1, points = 3 }", *box).find("points = 3 is not allowed"), std::string::npos);
  EXPECT_NE(
      text("{ type = 'per_cell', count = 5 }", *box).find("count = 5 is no square number, so it cannot be spread evenly; the nearest is 4"),
      std::string::npos);
}

TEST(Layout, reads_back_as_written) {
  const RegionPointer disk = region("{ type = 'disk', center = [0.5, 0.5], radius = 0.3 }");
  for (const char* text :
       {"{ type = 'lattice', divisions = [7, 9], points = 2 }", "{ type = 'per_cell', count = [2, 3] }", "{ type = 'per_cell', count = 9 }",
        "{ type = 'polar', rings = 4 }", "{ type = 'polar', rings = 4, sectors = 7 }"}) {
    const std::shared_ptr<Layout> original = layout(text);
    EXPECT_EQ(layout_registry().read(original->write(2), {2, ""}, "layout")->fill(disk.get(), k_unit_grid).position,
              original->fill(disk.get(), k_unit_grid).position)
        << text;
  }
}

}  // namespace
}  // namespace matpoint::test
