// The algebra of 3x3 matrices against Eigen, full and plane.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <limits>
#include <random>

#include "core/tensor.hpp"

namespace matpoint::test {
namespace {

constexpr Real k_bound = 20 * std::numeric_limits<Real>::epsilon();  // entries below 1, sums of at most nine products of up to three

template <bool is_plane>
Eigen::Matrix3d to_eigen(const Mat3<Real, is_plane>& a) {
  Eigen::Matrix3d result = Eigen::Matrix3d::Zero();
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) {
      if (a.is_stored(r, c)) result(r, c) = a(r, c);
    }
  }
  return result;
}

template <class M>
class TensorTest : public testing::Test {
 protected:
  M random() {
    M result;
    for (Real& entry : result.entries) entry = uniform_(random_);
    return result;
  }

 private:
  std::mt19937 random_{7};
  std::uniform_real_distribution<Real> uniform_{-1, 1};
};
using Matrices = testing::Types<Mat3<Real, false>, Mat3<Real, true>>;
TYPED_TEST_SUITE(TensorTest, Matrices);

TYPED_TEST(TensorTest, algebra_agrees_with_eigen) {
  using M = TypeParam;
  for (int n = 0; n < 50; ++n) {
    const M a = this->random();
    const M b = this->random();
    const Eigen::Matrix3d A = to_eigen(a), B = to_eigen(b);
    EXPECT_EQ(to_eigen(a + b), A + B);
    EXPECT_EQ(to_eigen(a - b), A - B);
    EXPECT_LT((to_eigen(a * b) - A * B).norm(), k_bound);
    EXPECT_LT((to_eigen(a * b * a) - A * B * A).norm(), k_bound);
    EXPECT_EQ(to_eigen(2.5 * a), 2.5 * A);
    EXPECT_EQ(to_eigen(scaled(2.5, a)), 2.5 * A);
    EXPECT_EQ(to_eigen(transpose(a)), A.transpose());
    EXPECT_LT((to_eigen(symmetric_part(a)) - (A + A.transpose()) / 2).norm(), k_bound);
    EXPECT_NEAR(trace(a), A.trace(), k_bound);
    EXPECT_NEAR(determinant(a), A.determinant(), k_bound);
    EXPECT_NEAR(contract(a, b), (A.array() * B.array()).sum(), k_bound);
    EXPECT_LT((to_eigen(deviator(a)) - (A - A.trace() / 3 * Eigen::Matrix3d::Identity())).norm(), k_bound);
  }
}

TYPED_TEST(TensorTest, zero_identity_and_diagonal_are_what_they_say) {
  using M = TypeParam;
  EXPECT_EQ(to_eigen(M::zero()), Eigen::Matrix3d::Zero());
  EXPECT_EQ(to_eigen(M::identity()), Eigen::Matrix3d::Identity());
  EXPECT_EQ(to_eigen(M::diagonal(3.5)), 3.5 * Eigen::Matrix3d::Identity());
}

TEST(Tensor, entries_are_stored_row_by_row_and_plane_ones_leave_out_the_zeros) {
  Mat3<Real> full = Mat3<Real>::zero();
  full(0, 1) = 2;
  full(2, 0) = 3;
  EXPECT_EQ(full.entries[1], 2);
  EXPECT_EQ(full.entries[6], 3);
  int stored = 0;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) stored += Mat3<Real, true>::is_stored(r, c) ? 1 : 0;
  }
  EXPECT_EQ(stored, 5);
  EXPECT_EQ(sizeof(Mat3<Real, true>), 5 * sizeof(Real));
  EXPECT_FALSE((Mat3<Real, true>::is_stored(0, 2)));
  EXPECT_FALSE((Mat3<Real, true>::is_stored(2, 1)));
  EXPECT_TRUE((Mat3<Real, true>::is_stored(2, 2)));
}

}  // namespace
}  // namespace matpoint::test
