// The tangent that the implicit solver takes out of each law by automatic differentiation, against central differences of its stress.
#include "material/damaged_neo_hookean.hpp"
#include "material/law_samples.hpp"
#include "material/tangent_of_law.hpp"

namespace matpoint::test {
namespace {

template <class Law>
class TangentTest : public testing::Test {};
TYPED_TEST_SUITE(TangentTest, TestedLaws);

/// One point of an implicit step.
template <int Dim>
struct Point {
  static constexpr int n = Dim * Dim;
  std::array<Real, n> A{};
  std::array<Real, n> F{};
  std::vector<Real> history;
  Real dt = 0.01;

  explicit Point(Samples& samples, int history_size) : history(static_cast<std::size_t>(std::max(1, history_size)), 0) {
    const Eigen::Matrix3d F3 = samples.deformation();
    const Eigen::Matrix3d change = samples.matrix(0.1);
    for (int r = 0; r < Dim; ++r) {
      for (int c = 0; c < Dim; ++c) {
        F[static_cast<std::size_t>(r * Dim + c)] = F3(r, c);
        A[static_cast<std::size_t>(r * Dim + c)] = (r == c ? 1 : 0) + change(r, c);
      }
    }
    // A plane part of a deformation may be turned inside out.
    const Eigen::Matrix<Real, Dim, Dim> plane = Eigen::Map<const Eigen::Matrix<Real, Dim, Dim, Eigen::RowMajor>>(F.data());
    if (plane.determinant() < 0.2) F = A;
  }

  template <class Law>
  std::array<Real, n> stress(const Law& law, Real* tangent = nullptr, Real* tau = nullptr) const {
    std::array<Real, n> S;
    TangentPoints points;
    points.count = 1;
    points.dt = dt;
    points.A = A.data();
    points.F = F.data();
    points.history = history.data();
    points.S = S.data();
    points.tangent = tangent;
    points.tau = tau;
    evaluate_tangent<Dim, Law>(&law, points);
    return S;
  }
};

template <int Dim, class Law>
void expect_tangent(const Law& law, Point<Dim> point) {
  constexpr int n = Dim * Dim;
  std::array<Real, n * n> D;
  const std::array<Real, n> S = point.stress(law, D.data());
  const std::array<Real, n> same = point.stress(law);
  Real size = 0;
  for (const Real entry : D) size += entry * entry;
  size = std::sqrt(size);
  for (std::size_t i = 0; i < n; ++i) EXPECT_NEAR(S[i], same[i], 100 * k_epsilon * size);
  Real difference = 0;
  for (std::size_t k = 0; k < n; ++k) {
    // Truncation of (1e-6)^2 and rounding of eps / 1e-6, both about 1e-10; steps of two sizes remove the first.
    const auto slope = [&](Real step) {
      Point<Dim> plus = point, minus = point;
      plus.A[k] += step;
      minus.A[k] -= step;
      const auto up = plus.stress(law), down = minus.stress(law);
      std::array<Real, n> result;
      for (std::size_t i = 0; i < n; ++i) result[i] = (up[i] - down[i]) / (2 * step);
      return result;
    };
    const auto coarse = slope(2e-4), fine = slope(1e-4);
    for (std::size_t i = 0; i < n; ++i) difference += std::pow((4 * fine[i] - coarse[i]) / 3 - D[i * n + k], 2);
  }
  EXPECT_LT(std::sqrt(difference), 1e-8 * size);
}

TYPED_TEST(TangentTest, equals_central_differences_in_2d_and_3d) {
  for (int set = 0; set < k_sample_count; ++set) {
    const TypeParam law = sample_law<TypeParam>(set);
    Samples samples;
    for (int k = 0; k < 20; ++k) {
      expect_tangent<2>(law, Point<2>(samples, k_history_size<TypeParam>));
      expect_tangent<3>(law, Point<3>(samples, k_history_size<TypeParam>));
    }
  }
}

TYPED_TEST(TangentTest, stress_is_tau_times_the_inverse_transpose_of_the_step) {
  const TypeParam law = sample_law<TypeParam>(0);
  Samples samples;
  for (int k = 0; k < 20; ++k) {
    const Point<3> point(samples, k_history_size<TypeParam>);
    std::array<Real, 6> tau;
    const auto S = point.stress(law, nullptr, tau.data());
    using Matrix = Eigen::Matrix<Real, 3, 3, Eigen::RowMajor>;
    const Matrix A = Eigen::Map<const Matrix>(point.A.data());
    const Matrix S3 = Eigen::Map<const Matrix>(S.data());
    const Matrix back = S3 * A.transpose();
    const Real scale = S3.norm() + stiffness(law);
    EXPECT_NEAR(back(0, 0), tau[0], 1e-12 * scale);
    EXPECT_NEAR(back(1, 1), tau[1], 1e-12 * scale);
    EXPECT_NEAR(back(2, 2), tau[2], 1e-12 * scale);
    EXPECT_NEAR(back(0, 1), tau[3], 1e-12 * scale);
    EXPECT_NEAR(back(1, 2), tau[4], 1e-12 * scale);
    EXPECT_NEAR(back(0, 2), tau[5], 1e-12 * scale);
  }
}

TEST(Tangent, history_is_read_and_written_once_and_not_by_the_derivative) {
  DamagedNeoHookean law;
  law.density = 1000;
  law.youngs_modulus = 1e5;
  law.poissons_ratio = 0.3;
  law.damage_energy = 500;
  Samples samples;
  Point<2> point(samples, 1);
  point.A = {1.1, 0.05, 0, 1.02};
  point.F = {1, 0, 0, 1};
  expect_tangent<2>(law, point);
  std::array<Real, 4> S;
  Real written = -1;
  TangentPoints points;
  points.count = 1;
  points.A = point.A.data();
  points.F = point.F.data();
  points.history = point.history.data();
  points.S = S.data();
  points.new_history = &written;
  evaluate_tangent<2, DamagedNeoHookean>(&law, points);
  EXPECT_NEAR(written, (NeoHookean{law}.energy_density(Plane{{1.1, 0.05, 0, 1.02, 1}})), 1e-9);
  EXPECT_EQ(point.history[0], 0);
  // Less deformed than it was: the tangent of the softened, elastic material.
  point.history[0] = 4 * written;
  expect_tangent<2>(law, point);
}

TEST(Tangent, rates_are_those_of_the_step) {
  // Pure shear of a viscous fluid: tau_xy = mu d_xy 2 J with d = sym((A - I) A^-1) / dt.
  NewtonianFluid fluid;
  fluid.density = 1000;
  fluid.pressure_scale = 1e5;
  fluid.viscosity = 3;
  Samples samples;
  Point<2> point(samples, 0);
  point.A = {1, 0.02, 0, 1};
  point.F = {1, 0, 0, 1};
  point.dt = 0.1;
  std::array<Real, 6> tau;
  point.stress(fluid, nullptr, tau.data());
  EXPECT_NEAR(tau[3], 3 * 0.02 / 0.1, 1e-12);
  EXPECT_NEAR(tau[0], 0, 1e-9);
}

}  // namespace
}  // namespace matpoint::test
