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

/// A value that the parameter may have, from its unit; `set` picks among several. Numbers without a unit can mean anything, so the
/// first of a list that the declaration allows is taken.
inline std::vector<Real> candidates(const ParameterDescription& parameter, int set, std::size_t position) {
  const Real spread = 1 + 0.37 * static_cast<Real>(position) + 0.5 * set;
  if (parameter.unit == "kg/m^3") return {1200 * spread};
  if (parameter.unit == "Pa") return {2e4 * spread};
  if (parameter.unit == "Pa s") return {30 * spread};
  if (parameter.unit == "deg") return {30 - static_cast<Real>(position)};
  if (parameter.name == "Jm") return {30 * spread};  // a limit of stretch is far from where it is sampled
  if (parameter.name.starts_with("alpha_")) return {1.1 * spread};
  const Real rising = 1 + 0.1 * static_cast<Real>(position);
  if (set == 0) return {0.3 * rising, 1.4, 3, 7};
  return {-0.25, 0.2 * rising, 2, 7};
}

/// A table of parameters that `read` accepts, made from their declarations: all given (sets 0 and 1), or the required ones only (set 2).
inline Input sample_table(const std::vector<ParameterDescription>& parameters, int set, const std::function<void(const Input&)>& read,
                          Input table = Input::table()) {
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const ParameterDescription& parameter = parameters[k];
    if ((set == 2 && !parameter.is_required) || parameter.type == "string") continue;
    bool is_allowed = false;
    for (const Real value : candidates(parameter, set, k)) {
      table.set(parameter.name, Input::real(value));
      try {
        read(table);
        is_allowed = true;
      } catch (const InputError& error) {
        // The parameters after this one are still to come.
        is_allowed = std::string(error.what()).find("is missing") != std::string::npos;
      }
      if (is_allowed) break;
    }
    if (!is_allowed && !parameter.is_required) {
      table.entries().pop_back();  // it may be one that excludes another
      continue;
    }
    if (!is_allowed) ADD_FAILURE() << "give candidates() a value for " << parameter.name << " [" << parameter.unit << "]";
  }
  return table;
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
