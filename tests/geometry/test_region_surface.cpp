// Surfaces of regions as tools see them: distances grow at one along their normals, change their sign at the surface, and are the least
// ones; what is solid has the volume, centre and inertia of its points.
#include <cmath>
#include <random>

#include "support/from_toml.hpp"

namespace matpoint::test {
namespace {

struct Shape {
  std::string text;
  int dim;
  bool has_corners_inside = true;  ///< Where inner distances have creases.
};

std::vector<Shape> shapes() {
  return {{"{ type = 'disk', center = [0.4, 0.5], radius = 0.3 }", 2},
          {"{ type = 'box', lower = [0.2, 0.1], upper = [0.7, 0.9] }", 2},
          {"{ type = 'polygon', vertices = [[0.1, 0.1], [0.9, 0.2], [0.6, 0.5], [0.7, 0.9], [0.2, 0.8]] }", 2},
          {"{ type = 'polygon', vertices = [[0.2, 0.8], [0.7, 0.9], [0.9, 0.2], [0.1, 0.1]] }", 2},
          {"{ type = 'half_space', point = [0.5, 0.5], normal = [2, -1] }", 2},
          {"{ type = 'union', of = [{ type = 'disk', center = [0.3, 0.5], radius = 0.2 }, { type = 'box', lower = [0.5, 0.2], upper = "
           "[0.8, 0.8] "
           "}] }",
           2},
          {"{ type = 'sphere', center = [0.4, 0.5, 0.6], radius = 0.3 }", 3},
          {"{ type = 'box', lower = [0.2, 0.1, 0.3], upper = [0.7, 0.9, 0.8] }", 3},
          {"{ type = 'cylinder', start = [0.2, 0.3, 0.4], end = [0.7, 0.6, 0.8], radius = 0.25 }", 3},
          {"{ type = 'half_space', point = [0.5, 0.5, 0.5], normal = [2, -1, 3] }", 3}};
}

TEST(RegionSurface, has_distances_that_grow_at_one_along_normals) {
  for (const Shape& shape : shapes()) {
    const RegionPointer of = region(shape.text, shape.dim);
    std::mt19937 random(5);
    std::uniform_real_distribution<Real> uniform(-0.2, 1.2);
    int checked = 0;
    for (int k = 0; k < 500; ++k) {
      const Vec3 x{uniform(random), uniform(random), shape.dim == 3 ? uniform(random) : 0};
      const NearSurface near = *of->surface_near(x, shape.dim);
      EXPECT_EQ(near.distance < 0, of->contains(x)) << shape.text;
      EXPECT_NEAR(std::hypot(near.normal[0], near.normal[1], near.normal[2]), 1, 1e-12);
      Vec3 slope{};
      for (std::size_t d = 0; d < static_cast<std::size_t>(shape.dim); ++d) {
        Vec3 up = x, down = x;
        up[d] += 1e-6;
        down[d] -= 1e-6;
        slope[d] = (of->surface_near(up, shape.dim)->distance - of->surface_near(down, shape.dim)->distance) / 2e-6;
      }
      // Between two faces the distance has a crease.
      if (std::hypot(slope[0], slope[1], slope[2]) < 0.99) continue;
      ++checked;
      for (std::size_t d = 0; d < 3; ++d) EXPECT_NEAR(slope[d], near.normal[d], 1e-6) << shape.text;
      // The foot of the normal lies on the surface.
      const Vec3 foot{x[0] - near.distance * near.normal[0], x[1] - near.distance * near.normal[1], x[2] - near.distance * near.normal[2]};
      if (shape.text.find("union") == std::string::npos || near.distance > 0) {
        EXPECT_NEAR(of->surface_near(foot, shape.dim)->distance, 0, 1e-9) << shape.text;
      }
    }
    EXPECT_GT(checked, 450) << shape.text;
  }
}

TEST(RegionSurface, of_the_middle_of_a_cylinder_has_a_direction) {
  const NearSurface near = *region("{ type = 'cylinder', start = [0, 0, 0], end = [0, 0, 4], radius = 1 }", 3)->surface_near({0, 0, 2}, 3);
  EXPECT_DOUBLE_EQ(near.distance, -1);
  EXPECT_NEAR(std::hypot(near.normal[0], near.normal[1]), 1, 1e-12);
}

TEST(RegionSolid, has_the_volume_centre_and_inertia_of_its_points) {
  for (const Shape& shape : shapes()) {
    const RegionPointer of = region(shape.text, shape.dim);
    const std::optional<Solid> solid = of->solid(shape.dim);
    if (shape.text.find("union") != std::string::npos || shape.text.find("half") != std::string::npos) {
      EXPECT_FALSE(solid);
      continue;
    }
    const int n = shape.dim == 2 ? 800 : 120;
    const Vec3 lower = of->lower(), upper = of->upper();
    Real cell = 1, volume = 0;
    Vec3 first{};
    std::array<Real, 9> second{};
    for (std::size_t d = 0; d < static_cast<std::size_t>(shape.dim); ++d) cell *= (upper[d] - lower[d]) / n;
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) {
        for (int k = 0; k < (shape.dim == 3 ? n : 1); ++k) {
          Vec3 x{lower[0] + (i + 0.5) / n * (upper[0] - lower[0]), lower[1] + (j + 0.5) / n * (upper[1] - lower[1]),
                 shape.dim == 3 ? lower[2] + (k + 0.5) / n * (upper[2] - lower[2]) : 0};
          if (!of->contains(x)) continue;
          volume += cell;
          for (std::size_t d = 0; d < 3; ++d) {
            first[d] += cell * x[d];
            x[d] -= solid->center[d];
          }
          const Real square = x[0] * x[0] + x[1] * x[1] + x[2] * x[2];
          for (std::size_t d = 0; d < 3; ++d) {
            for (std::size_t e = 0; e < 3; ++e) second[3 * d + e] += cell * ((d == e ? square : 0) - x[d] * x[e]);
          }
        }
      }
    }
    EXPECT_NEAR(solid->volume, volume, 0.01 * volume) << shape.text;
    for (std::size_t d = 0; d < 3; ++d) EXPECT_NEAR(solid->center[d], first[d] / volume, 2e-3) << shape.text;
    for (std::size_t e = shape.dim == 3 ? 0 : 8; e < 9; ++e)
      EXPECT_NEAR(solid->inertia[e], second[e], 0.015 * second[8]) << shape.text << e;
  }
}

}  // namespace
}  // namespace matpoint::test
