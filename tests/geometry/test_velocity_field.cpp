// Initial velocities: rigid motion, standing waves, what is written back.
#include <cmath>
#include <numbers>

#include "support/from_toml.hpp"

namespace matpoint::test {
namespace {

TEST(VelocityField, uniform_is_the_same_everywhere) {
  EXPECT_EQ(velocity_field("{ type = 'uniform', value = [1.5, -2] }")->at({3, 4, 0}), (Vec3{1.5, -2, 0}));
  EXPECT_EQ(velocity_field("{ type = 'uniform', value = [1.5, -2, 7] }", 3)->at({3, 4, 5}), (Vec3{1.5, -2, 7}));
}

TEST(VelocityField, linear_is_value_plus_gradient_times_distance) {
  // Rows belong to components: a shear du_x/dy = 3 moves points along x.
  EXPECT_EQ(velocity_field("{ type = 'linear', gradient = [[0, 3], [0, 0]] }")->at({1, 2, 0}), (Vec3{6, 0, 0}));
  const std::shared_ptr<VelocityField> field =
      velocity_field("{ type = 'linear', value = [1, 2, 3], center = [1, 1, 1], gradient = [[1, 2, 3], [4, 5, 6], [7, 8, 9]] }", 3);
  EXPECT_EQ(field->at({1, 1, 1}), (Vec3{1, 2, 3}));
  EXPECT_EQ(field->at({2, 1, 1}), (Vec3{2, 6, 10}));
  EXPECT_EQ(field->at({1, 2, 1}), (Vec3{3, 7, 11}));
  EXPECT_EQ(field->at({1, 1, 2}), (Vec3{4, 8, 12}));
  EXPECT_NE(complaint_of([] {
              velocity_field("{ type = 'linear', gradient = [[1, 2]] }");
            }).find("gradient has 1 rows; the case has dim = 2, so it must have 2"),
            std::string::npos);
}

TEST(VelocityField, rotating_is_the_rigid_motion_about_its_center) {
  // Counter-clockwise in 2D: right of the center the velocity points up.
  const std::shared_ptr<VelocityField> flat = velocity_field("{ type = 'rotating', center = [1, 2], angular_velocity = 3 }");
  EXPECT_EQ(flat->at({2, 2, 0}), (Vec3{0, 3, 0}));
  EXPECT_EQ(flat->at({1, 3, 0}), (Vec3{-3, 0, 0}));
  // In 3D, against a small rotation by Rodrigues' formula about the axis: (x(t) - x(-t))/2t, wrong by |omega|^2 t^2/6.
  const Vec3 omega{0.5, -1, 2}, center{1, 0, -1}, value{0.1, 0.2, 0.3};
  const std::shared_ptr<VelocityField> solid =
      velocity_field("{ type = 'rotating', value = [0.1, 0.2, 0.3], center = [1, 0, -1], angular_velocity = [0.5, -1, 2] }", 3);
  const Real rate = std::sqrt(0.25 + 1 + 4);
  const Vec3 axis{omega[0] / rate, omega[1] / rate, omega[2] / rate};
  const Vec3 r{0.3, 0.7, -0.4};
  const Real along = axis[0] * r[0] + axis[1] * r[1] + axis[2] * r[2];
  const Vec3 across{axis[1] * r[2] - axis[2] * r[1], axis[2] * r[0] - axis[0] * r[2], axis[0] * r[1] - axis[1] * r[0]};
  const auto rotated = [&](Real t, std::size_t d) {
    return r[d] * std::cos(rate * t) + across[d] * std::sin(rate * t) + axis[d] * along * (1 - std::cos(rate * t));
  };
  const Vec3 v = solid->at({center[0] + r[0], center[1] + r[1], center[2] + r[2]});
  for (std::size_t d = 0; d < 3; ++d) EXPECT_NEAR(v[d], value[d] + (rotated(1e-5, d) - rotated(-1e-5, d)) / 2e-5, 1e-9);
}

TEST(VelocityField, reads_back_as_written) {
  for (const char* text :
       {"{ type = 'uniform', value = [1, 2] }", "{ type = 'linear', gradient = [[1, 2], [3, 4]], center = [5, 6], value = [7, 8] }",
        "{ type = 'rotating', center = [1, 2], angular_velocity = 3, value = [4, 5] }"}) {
    const std::shared_ptr<VelocityField> original = velocity_field(text);
    EXPECT_EQ(velocity_registry().read(original->write(2), {2, ""}, "velocity")->at({0.1, 0.7, 0}), original->at({0.1, 0.7, 0})) << text;
  }
}

TEST(VelocityField, sine_is_a_standing_wave_along_a_direction) {
  constexpr Real pi = std::numbers::pi;
  const auto field =
      velocity_field("{ type = \"sine\", value = [2, -1], wave_vector = [3.141592653589793, 6.283185307179586], center = [0.5, 0.25] }", 2);
  EXPECT_EQ(field->at({0.5, 0.25, 0})[0], 0);
  // A quarter of a wave along x, then the same along y; a wave length of 2 along x.
  EXPECT_NEAR(field->at({1.0, 0.25, 0})[0], 2, 1e-14);
  EXPECT_NEAR(field->at({1.0, 0.25, 0})[1], -1, 1e-14);
  EXPECT_NEAR(field->at({0.5, 0.5, 0})[0], 2, 1e-14);
  EXPECT_NEAR(field->at({1.5, 0.25, 0})[0], 0, 1e-14);
  EXPECT_NEAR(field->at({0.7, 0.2, 0})[0], 2 * std::sin(pi * 0.2 - 2 * pi * 0.05), 1e-14);
}

TEST(VelocityField, sine_in_3d_reads_back_as_written) {
  const auto field = velocity_field("{ type = \"sine\", value = [0, 0, 3], wave_vector = [0, 0, 1] }", 3);
  EXPECT_NEAR(field->at({5, 7, 0.4})[2], 3 * std::sin(0.4), 1e-15);
  const auto again = velocity_registry().read(field->write(3), {3, "test"}, "velocity");
  EXPECT_EQ(again->at({1, 2, 3}), field->at({1, 2, 3}));
}

}  // namespace
}  // namespace matpoint::test
