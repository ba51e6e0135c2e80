#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "material/law_samples.hpp"

namespace matpoint::test {
namespace {

TEST(Power, agrees_with_the_standard_library_for_whole_fractional_and_negative_exponents) {
  for (int k = 1; k <= 60; ++k) {
    const Real x = 0.05 * k;
    for (int exponent = -20; exponent <= 20; ++exponent) {
      const Real expected = std::pow(x, exponent);
      // Two roundings per factor, at most ten products up to the 16th power; above, exp(e log x) multiplies the rounding of e log x,
      // which is below 60 here.
      EXPECT_NEAR(power(x, exponent), expected, 60 * k_epsilon * expected) << x << "^" << exponent;
    }
    for (const Real exponent : {0.5, -0.4, 2.0 / 3, -4.0 / 3, 1.4, 6.15, -16.5}) {
      const Real expected = std::pow(x, exponent);
      EXPECT_NEAR(power(x, exponent), expected, 60 * k_epsilon * expected) << x << "^" << exponent;
    }
  }
  EXPECT_EQ(power(3.7, 0), 1);
  EXPECT_EQ(power(3.0, 4), 81);
  EXPECT_EQ(power(2.0, -2), 0.25);
}

TEST(Power, of_a_dual_number_has_the_derivative_e_x_to_the_e_minus_1) {
  for (const Real exponent : {-7.0, -2.0, -0.4, 0.0, 1.0, 1.4, 3.0, 16.0, 17.0}) {
    const Dual result = power(Dual(1.3, 9, 4), exponent);
    EXPECT_NEAR(result.value(), std::pow(1.3, exponent), 60 * k_epsilon * std::pow(1.3, exponent));
    const Real slope = exponent * std::pow(1.3, exponent - 1);
    EXPECT_NEAR(result.derivatives()(4), slope, 100 * k_epsilon * std::abs(slope));
    EXPECT_EQ(result.derivatives()(0), 0);
  }
}

}  // namespace
}  // namespace matpoint::test
