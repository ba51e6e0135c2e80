#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "body/seeding.hpp"
#include "case/case_file.hpp"

namespace matpoint {
namespace {

std::shared_ptr<VelocityField> read(const std::string& text, int dim) {
  const Input input = parse_toml("velocity = " + text, "test");
  return velocity_registry().read(*input.find("velocity"), {dim, "test"}, "velocity");
}

TEST(VelocitySine, test_standing_wave_along_a_direction) {
  constexpr Real pi = std::numbers::pi;
  const auto field =
      read("{ type = \"sine\", value = [2, -1], wave_vector = [3.141592653589793, 6.283185307179586], center = [0.5, 0.25] }", 2);
  EXPECT_EQ(field->at({0.5, 0.25, 0})[0], 0);
  // A quarter of a wave along x, then the same along y; a wave length of 2 along x.
  EXPECT_NEAR(field->at({1.0, 0.25, 0})[0], 2, 1e-14);
  EXPECT_NEAR(field->at({1.0, 0.25, 0})[1], -1, 1e-14);
  EXPECT_NEAR(field->at({0.5, 0.5, 0})[0], 2, 1e-14);
  EXPECT_NEAR(field->at({1.5, 0.25, 0})[0], 0, 1e-14);
  EXPECT_NEAR(field->at({0.7, 0.2, 0})[0], 2 * std::sin(pi * 0.2 - 2 * pi * 0.05), 1e-14);
}

TEST(VelocitySine, test_standing_wave_in_3d_and_written_back) {
  const auto field = read("{ type = \"sine\", value = [0, 0, 3], wave_vector = [0, 0, 1] }", 3);
  EXPECT_NEAR(field->at({5, 7, 0.4})[2], 3 * std::sin(0.4), 1e-15);
  const auto again = velocity_registry().read(field->write(3), {3, "test"}, "velocity");
  EXPECT_EQ(again->at({1, 2, 3}), field->at({1, 2, 3}));
}

}  // namespace
}  // namespace matpoint
