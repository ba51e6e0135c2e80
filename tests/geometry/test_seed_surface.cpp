// The free faces of particles' boxes: areas of boxes are exact wherever the lattice lies, staircases have the body's shadow, closed
// surfaces have no resultant, and what is no lattice is refused.
#include "geometry/seed_surface.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "support/from_toml.hpp"

namespace matpoint::test {
namespace {

struct Areas {
  Real lower[3] = {0, 0, 0}, upper[3] = {0, 0, 0};
};

Areas areas_of(const std::vector<SeedFace>& faces) {
  Areas sums;
  for (const SeedFace& face : faces) (face.is_upper ? sums.upper : sums.lower)[face.axis] += face.area;
  return sums;
}

Seeds seeds_in(const std::string& text, const Region& region, int dim) {
  return layout(text, dim)->fill(&region, {dim, {0, 0, 0}, {2, 2, 2}, {0.1, 0.1, 0.1}, false});
}

TEST(SeedSurface, of_a_box_is_its_own) {
  // Aligned with the lattice of cells, beside it, and of layouts that follow the box.
  for (const std::string of : {"{ type = \"per_cell\", count = 4 }", "{ type = \"per_cell\", count = [2, 3] }",
                               "{ type = \"lattice\", divisions = [7, 5] }", "{ type = \"lattice\", divisions = [7, 5], points = 2 }"}) {
    for (const Real shift : {0.0, 0.013, 0.04}) {
      const auto box = region(fmt::format("{{ type = \"box\", lower = [{}, {}], upper = [{}, 0.83] }}", 0.2 + shift, 0.3 - shift, 0.9), 2);
      const Areas areas = areas_of(surface_of(seeds_in(of, *box, 2), box.get(), 2));
      const Real width = 0.7 - shift, height = 0.53 + shift;
      EXPECT_NEAR(areas.lower[0], height, 1e-12) << of << shift;
      EXPECT_NEAR(areas.upper[0], height, 1e-12) << of << shift;
      EXPECT_NEAR(areas.lower[1], width, 1e-12) << of << shift;
      EXPECT_NEAR(areas.upper[1], width, 1e-12) << of << shift;
    }
  }
  const auto block = region("{ type = \"box\", lower = [0.1, 0.2, 0.3], upper = [0.5, 0.83, 0.7] }", 3);
  const Areas areas = areas_of(surface_of(seeds_in("{ type = \"per_cell\", count = 8 }", *block, 3), block.get(), 3));
  EXPECT_NEAR(areas.upper[0], 0.63 * 0.4, 1e-12);
  EXPECT_NEAR(areas.upper[1], 0.4 * 0.4, 1e-12);
  EXPECT_NEAR(areas.lower[2], 0.63 * 0.4, 1e-12);
}

TEST(SeedSurface, of_a_disk_has_its_shadow_and_no_resultant) {
  const auto disk = region("{ type = \"disk\", center = [1, 1], radius = 0.5 }", 2);
  const Areas areas = areas_of(surface_of(seeds_in("{ type = \"per_cell\", count = 16 }", *disk, 2), disk.get(), 2));
  for (int d : {0, 1}) {
    EXPECT_DOUBLE_EQ(areas.lower[d], areas.upper[d]);
    EXPECT_NEAR(areas.upper[d], 1, 0.025);
  }
}

TEST(SeedSurface, has_holes) {
  const auto ring = region(
      "{ type = \"difference\", of = [{ type = \"box\", lower = [0.2, 0.2], upper = [0.8, 0.8] }, { type = \"box\", lower = [0.4, 0.4], "
      "upper = "
      "[0.6, 0.6] }] }",
      2);
  const Areas areas = areas_of(surface_of(seeds_in("{ type = \"per_cell\", count = 4 }", *ring, 2), ring.get(), 2));
  EXPECT_NEAR(areas.upper[0], 0.8, 1e-12);
  EXPECT_NEAR(areas.lower[1], 0.8, 1e-12);
}

TEST(SeedSurface, of_points_is_found_where_they_are_a_lattice) {
  Seeds seeds;
  for (int i = 0; i < 5; ++i) {
    for (int j = 0; j < 4; ++j) seeds.position.push_back({1000.1 + 0.05 * i, -3.2 + 0.1 * j, 0});
  }
  seeds.volume.assign(20, 0.005);
  const Areas areas = areas_of(surface_of(seeds, nullptr, 2));
  EXPECT_NEAR(areas.upper[0], 0.4, 1e-9);
  EXPECT_NEAR(areas.upper[1], 0.25, 1e-9);
  seeds.position[7][0] += 0.01;
  EXPECT_THAT(complaint_of([&] { surface_of(seeds, nullptr, 2); }), testing::HasSubstr("its particles do not lie on a lattice"));
  seeds.position[7] = seeds.position[8];
  EXPECT_THAT(complaint_of([&] { surface_of(seeds, nullptr, 2); }), testing::HasSubstr("its particles do not lie on a lattice"));
  const auto disk = region("{ type = \"disk\", center = [1, 1], radius = 0.5 }", 2);
  EXPECT_THAT(complaint_of([&] { surface_of(seeds_in("{ type = \"polar\", rings = 6 }", *disk, 2), disk.get(), 2); }),
              testing::HasSubstr("its particles do not lie on a lattice"));
}

TEST(SeedSurface, has_particles_half_their_volume_behind_it) {
  const auto box = region("{ type = \"box\", lower = [0.2, 0.3], upper = [0.84, 0.7] }", 2);
  const Seeds seeds = seeds_in("{ type = \"per_cell\", count = 4 }", *box, 2);
  for (const SeedFace& face : surface_of(seeds, box.get(), 2)) EXPECT_NEAR(face.depth * face.area, seeds.volume[face.seed] / 2, 1e-15);
  // Gauss points, at 1/2 - 1/(2 sqrt 3) of their box's side.
  for (const SeedFace& face : surface_of(seeds_in("{ type = \"lattice\", divisions = 4, points = 2 }", *box, 2), box.get(), 2))
    EXPECT_NEAR(face.depth, (0.5 - 0.5 / std::sqrt(3.0)) * (face.axis == 0 ? 0.16 : 0.1), 1e-12);
}

}  // namespace
}  // namespace matpoint::test
