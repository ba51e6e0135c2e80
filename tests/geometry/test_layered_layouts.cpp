// Counts, masses and radii of the generators of Aulisa & Capodaglio (appendix A), and what is refused.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>

#include "core/error.hpp"
#include "support/from_toml.hpp"

namespace matpoint::test {
namespace {

const SeedingGrid k_grid{2, {-10, -10, 0}, {10, 10, 0}, {0.1, 0.1, 0}};

struct Numbers {
  std::size_t count;
  Real area;
  Real radius;
};

Numbers disk(Real radius, const std::string& layout_text) {
  const RegionPointer shape = region(fmt::format("{{ type = \"disk\", center = [0.1, -0.2], radius = {} }}", radius));
  const Seeds seeds = layout("{ type = \"layered_disk\", " + layout_text + " }")->fill(shape.get(), k_grid);
  Numbers numbers{seeds.position.size(), std::accumulate(seeds.volume.begin(), seeds.volume.end(), Real{0}), 0};
  for (const Vec3& x : seeds.position) numbers.radius = std::max(numbers.radius, std::hypot(x[0] - 0.1, x[1] + 0.2));
  EXPECT_EQ(seeds.position[0], (Vec3{0.1, -0.2, 0}));
  return numbers;
}

TEST(LayeredDisk, has_the_published_counts_and_masses) {
  const Numbers incline = disk(1.6, "core_radius = 1.4, points = 300, ratio = 1.14, normalized = false");
  EXPECT_EQ(incline.count, 48738u);
  EXPECT_NEAR(1000 * incline.area, 8060.34, 0.005);
  EXPECT_NEAR(incline.radius, 1.600854, 5e-7);
  const Numbers plate = disk(1.6, "core_radius = 1.4, points = 600, ratio = 1.05, normalized = false");
  EXPECT_NEAR(static_cast<Real>(plate.count), 57083, 2);
  EXPECT_NEAR(1000 * plate.area, 8082.19, 0.05);
  EXPECT_NEAR(plate.radius, 1.603348, 5e-7);
  const Numbers bounce = disk(0.16, "core_radius = 0.14, points = 300, normalized = false");
  EXPECT_EQ(bounce.count, 48738u);
  EXPECT_NEAR(1000 * bounce.area, 80.6034, 5e-4);
}

TEST(LayeredDisk, a_number_of_layers_ends_at_the_edge) {
  // The appendix' own rule, of which the reference computation has 46,982 particles (a rounded quotient more or less on some rings).
  const Numbers disk_22 = disk(1.6, "core_radius = 1.4, points = 300, layers = 22, normalized = false");
  EXPECT_NEAR(static_cast<Real>(disk_22.count), 46982, 6);
  EXPECT_NEAR(1000 * disk_22.area, 8051.56, 0.005);
  EXPECT_NEAR(disk_22.radius, 1.6, 1e-13);
  EXPECT_NEAR(disk(0.7, "core_radius = 0.2, points = 40, layers = 40").radius, 0.7, 1e-13);
}

TEST(LayeredDisk, too_few_layers_and_a_ratio_beside_them_are_refused) {
  const std::string few = complaint_of([] { disk(1.6, "core_radius = 1.4, points = 300, layers = 6"); });
  EXPECT_NE(few.find("layers = 6 of at most 0.0291667 m cannot fill the 0.2 m between the core and the edge"), std::string::npos) << few;
  EXPECT_NE(few.find("give at least 7"), std::string::npos) << few;
  EXPECT_NEAR(disk(1.6, "core_radius = 1.4, points = 300, layers = 7").radius, 1.6, 1e-13);
  EXPECT_NE(complaint_of([] {
              disk(1.6, "core_radius = 1.4, points = 300, layers = 22, ratio = 1.1");
            }).find("ratio and layers are both given; give one of them"),
            std::string::npos);
}

TEST(LayeredDisk, normalized_volumes_are_the_disks) {
  EXPECT_NEAR(disk(1.6, "core_radius = 1.4, points = 300").area, std::numbers::pi * 1.6 * 1.6, 1e-11);
  EXPECT_NEAR(disk(0.5, "core_radius = 0.3, points = 60, ratio = 1.02").area, std::numbers::pi * 0.25, 1e-12);
}

TEST(LayeredDisk, layers_that_never_reach_the_surface_are_refused) {
  // For ever, if the sum were only added up: DL / (f - 1) = 1.4 / 95 / 0.14 = 0.105 < 0.2.
  const std::string complaint = complaint_of([] { disk(1.6, "core_radius = 1.4, points = 600, ratio = 1.14"); });
  EXPECT_NE(complaint.find("fill at most 0.105263 m, but 0.2 m lie between"), std::string::npos) << complaint;
  EXPECT_NE(complaint_of([] { disk(1.6, "core_radius = 1.6, points = 600"); }).find("must be below the disk's radius, 1.6 m"),
            std::string::npos);
  EXPECT_NE(complaint_of([] {
              layout("{ type = \"layered_disk\", core_radius = 1, points = 300 }")
                  ->fill(region("{ type = \"box\", lower = [0, 0], upper = [1, 1] }").get(), k_grid);
            }).find("fills disks only"),
            std::string::npos);
}

Numbers beam(const std::string& layout_text) {
  const RegionPointer shape = region("{ type = \"box\", lower = [-0.5, -0.125], upper = [0.125, 0.125] }");
  const Seeds seeds = layout("{ type = \"layered_beam\", " + layout_text + " }")->fill(shape.get(), k_grid);
  Numbers numbers{seeds.position.size(), std::accumulate(seeds.volume.begin(), seeds.volume.end(), Real{0}), 0};
  Real right = 0, top = 0;
  for (const Vec3& x : seeds.position) {
    EXPECT_GE(x[0], -0.5);
    right = std::max(right, x[0]);
    top = std::max(top, x[1]);
  }
  numbers.radius = right + 0.5;
  return numbers;
}

TEST(LayeredBeam, has_the_published_counts_and_masses) {
  const Numbers paper = beam("core_height = 0.15, rows = 20, ratio = 1.148, normalized = false");
  EXPECT_EQ(paper.count, 23040u);
  EXPECT_NEAR(1e4 * paper.area, 1569.62, 0.005);
  EXPECT_NEAR(paper.radius, 0.624854, 5e-7);
  const Numbers fine = beam("core_height = 0.2, rows = 40, ratio = 1.2, normalized = false");
  EXPECT_EQ(fine.count, 70008u);
  EXPECT_NEAR(1e4 * fine.area, 1564.56, 0.005);
  const Numbers finest = beam("core_height = 0.225, rows = 80, ratio = 1.224, normalized = false");
  EXPECT_EQ(finest.count, 178790u);
  EXPECT_NEAR(1e4 * finest.area, 1562.92, 0.005);
  EXPECT_NEAR(beam("core_height = 0.15, rows = 20").area, 0.15625, 1e-13);
}

TEST(LayeredBeam, refuses_other_regions_and_impossible_layers) {
  EXPECT_NE(complaint_of([] {
              layout("{ type = \"layered_beam\", core_height = 0.1, rows = 4 }")
                  ->fill(region("{ type = \"disk\", center = [0, 0], radius = 1 }").get(), k_grid);
            }).find("fills boxes only"),
            std::string::npos);
  EXPECT_NE(complaint_of([] { beam("core_height = 0.25, rows = 20"); }).find("must be below the box's height"), std::string::npos);
  EXPECT_NE(complaint_of([] { beam("core_height = 0.05, rows = 200"); }).find("fill at most"), std::string::npos);
}

}  // namespace
}  // namespace matpoint::test
