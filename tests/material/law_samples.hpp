// What the tests over all laws need: the list of laws, parameters for a law that nobody has told us about, random deformations, and the
// way from Mat3 to Eigen, which checks our algebra from outside.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <functional>
#include <random>
#include <unsupported/Eigen/AutoDiff>

#include "material/law_material.hpp"
#include "material/laws.hpp"
#include "material/my_rubber.hpp"
#include "support/law_tables.hpp"

namespace matpoint::test {

constexpr Real k_epsilon = std::numeric_limits<Real>::epsilon();

template <class Law>
using IfItFlows = std::conditional_t<k_has_state<Law>, std::tuple<Law>, std::tuple<>>;
template <class Law>
using IfItDoesNot = std::conditional_t<k_has_state<Law>, std::tuple<>, std::tuple<Law>>;
template <class Tuple>
struct TypesOf;
template <class... Laws>
struct TypesOf<std::tuple<Laws...>> {
  using Type = testing::Types<Laws...>;
  // The last one is the example of docs/add_a_material.md.
  using Elastic = TypesOf<decltype(std::tuple_cat(IfItDoesNot<Laws>()..., std::tuple<MyRubber>()))>;
  using Flowing = TypesOf<decltype(std::tuple_cat(IfItFlows<Laws>()...))>;
};
/// Those whose stress follows from F and L.
using TestedLaws = TypesOf<AllLaws>::Elastic::Type;
/// Those that flow (test_flow_laws.cpp).
using FlowingLaws = TypesOf<AllLaws>::Flowing::Type;

using Full = Mat3<Real>;
using Plane = Mat3<Real, true>;
/// A number with its derivatives with respect to the nine entries of F, row by row.
using Dual = Eigen::AutoDiffScalar<Eigen::Matrix<double, 9, 1>>;

inline Eigen::Matrix3d to_eigen(const Full& a) { return Eigen::Map<const Eigen::Matrix<Real, 3, 3, Eigen::RowMajor>>(a.entries); }
inline Full from_eigen(const Eigen::Matrix3d& a) {
  Full result;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) result(r, c) = a(r, c);
  }
  return result;
}
inline Mat3<Dual> with_derivatives(const Eigen::Matrix3d& F) {
  Mat3<Dual> result;
  for (int k = 0; k < 9; ++k) result.entries[k] = Dual(F(k / 3, k % 3), 9, k);
  return result;
}

/// The law with parameters from its own declaration.
template <class Law>
Law sample_law(int set) {
  const ParameterTable<Law>& declared = parameters_of<Law>();
  Law law;
  const auto read = [&](const Input& input) { declared.read(input, {3, ""}, law); };
  const Input table = sample_table(declared.describe(), set, read);
  read_law(table, {3, ""}, law);
  return law;
}
constexpr int k_sample_count = 3;

/// Random deformations with det F in [0.6, 1.6], and velocity gradients. The numbers are the same in every run.
class Samples {
 public:
  Eigen::Matrix3d matrix(Real amount) {
    Eigen::Matrix3d a;
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) a(r, c) = amount * uniform_(random_);
    }
    return a;
  }
  Eigen::Matrix3d deformation(Real amount = 0.4) {
    for (;;) {
      const Eigen::Matrix3d F = Eigen::Matrix3d::Identity() + matrix(amount);
      if (F.determinant() > 0.6 && F.determinant() < 1.6) return F;
    }
  }
  Eigen::Matrix3d rotation() {
    return Eigen::Quaterniond(uniform_(random_), uniform_(random_), uniform_(random_), uniform_(random_)).normalized().toRotationMatrix();
  }

 private:
  std::mt19937 random_{20250101};
  std::uniform_real_distribution<Real> uniform_{-1, 1};
};

/// tau(F, L) of virgin material.
template <class Law, class M>
M stress(const Law& law, const M& F, const M& L) {
  typename LawHistory<Law, typename M::Scalar>::Type old_history{};
  typename LawHistory<Law, typename M::Scalar>::Type new_history{};
  // Of a law that flows: deformed from rest in one step.
  typename M::Scalar dissipated(0.0);
  return kirchhoff_stress_of(law, Kinematics<M>{F, L, 1e-3, F - M::identity()}, old_history, new_history, dissipated);
}
template <class Law>
Eigen::Matrix3d stress(const Law& law, const Eigen::Matrix3d& F, const Eigen::Matrix3d& L = Eigen::Matrix3d::Zero()) {
  return to_eigen(stress(law, from_eigen(F), from_eigen(L)));
}

/// rho0 c^2 at rest: the stiffness that stresses are measured by [Pa].
template <class Law>
Real stiffness(const Law& law) {
  return law.density * law.wave_speed(1) * law.wave_speed(1);
}

template <class Law>
constexpr bool has_energy = requires(const Law& law, const Full& F) {
  law.energy_density(F);
};
template <class Law>
constexpr bool has_dissipation = requires(const Law& law, const Kinematics<Full>& k) {
  law.dissipation_rate(k);
};

}  // namespace matpoint::test
