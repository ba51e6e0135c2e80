// The kernel of contact by pairs of particles: its derivatives against differences, and its secants, which are exact over any step.
#include <gtest/gtest.h>

#include "geometry/pair_kernel.hpp"

namespace matpoint::test {
namespace {

TEST(PairKernel, secants_are_differences_over_any_step) {
  const PairKernel<2> kernel(0.5);
  const auto value = [&](Real q) { return q > 0 ? kernel.value(q) : 0; };
  const Real r2 = kernel.range() * kernel.range();
  for (const Real q0 : {-0.7, -0.1, 0.0, 0.2, 0.6}) {
    for (const Real q1 : {-0.4, -0.05, 0.1, 0.3, 0.9}) {
      const auto secant = kernel.secant(q0, q1);
      EXPECT_NEAR(secant.value * r2 * (q0 - q1), value(q1) - value(q0), 1e-12 * kernel.value(1)) << q0 << " " << q1;
      const Real e = 1e-6;
      const Real slope = (kernel.secant(q0, q1 - e).value - kernel.secant(q0, q1 + e).value) / (2 * e * r2);
      EXPECT_NEAR(secant.slope, slope, 1e-6 * kernel.value(1) / (r2 * r2)) << q0 << " " << q1;
    }
  }
}

TEST(PairKernel, secants_of_no_step_are_the_slope_and_half_the_curvature) {
  const PairKernel<3> kernel(0.5);
  for (const Real q : {0.1, 0.5, 0.9}) {
    EXPECT_NEAR(kernel.secant(q, q).value, kernel.tangent(q).value, 1e-12 * std::abs(kernel.tangent(q).value));
    EXPECT_NEAR(kernel.secant(q, q).slope, 0.5 * kernel.tangent(q).slope, 1e-12 * kernel.tangent(q).slope);
    EXPECT_NEAR(-2 * kernel.tangent(q).value, kernel.slope(q), 1e-12 * kernel.slope(q));  // by d^2 and by d
  }
  EXPECT_EQ(kernel.tangent(-0.1).value, 0);
}

}  // namespace
}  // namespace matpoint::test
