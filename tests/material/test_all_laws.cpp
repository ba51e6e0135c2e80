// One suite over all laws: a law is tested by standing in AllLaws (material/laws.hpp), with parameters drawn from its own declaration.
// Stresses are compared with the tangent and energy that automatic differentiation takes out of the law itself, with differences, and
// with what every law must obey: objectivity, symmetry, Hooke's law for small strains.
#include "material/law_samples.hpp"

namespace matpoint::test {
namespace {

template <class Law>
class AllLawsTest : public testing::Test {
 protected:
  template <class Check>
  static void for_samples(Check&& check) {
    for (int set = 0; set < k_sample_count; ++set) {
      SCOPED_TRACE(testing::Message() << Law::name << ", parameter set " << set);
      check(sample_law<Law>(set));
    }
  }
};

struct LawNames {
  template <class Law>
  static std::string GetName(int) {
    return Law::name;
  }
};
TYPED_TEST_SUITE(AllLawsTest, TestedLaws, LawNames);

TYPED_TEST(AllLawsTest, undeformed_material_has_no_stress_and_no_energy) {
  this->for_samples([](const TypeParam& law) {
    const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
    // Sums of a few terms of the size of the stiffness, which cancel.
    EXPECT_LT(stress(law, I).norm(), 10 * k_epsilon * stiffness(law));
    if constexpr (has_energy<TypeParam>) {
      EXPECT_LT(std::abs(law.energy_density(from_eigen(I))), 10 * k_epsilon * stiffness(law));
    }
  });
}

TYPED_TEST(AllLawsTest, stress_is_objective_and_symmetric) {
  this->for_samples([](const TypeParam& law) {
    Samples samples;
    for (int n = 0; n < 100; ++n) {
      const Eigen::Matrix3d F = samples.deformation();
      const Eigen::Matrix3d L = n % 2 == 0 ? Eigen::Matrix3d(Eigen::Matrix3d::Zero()) : samples.matrix(10);
      const Eigen::Matrix3d Q = samples.rotation();
      const Eigen::Matrix3d tau = stress(law, F, L);
      const Eigen::Matrix3d rotated = stress(law, Q * F, Q * L * Q.transpose());
      // Round-off of products of three matrices, and of J^-gamma, which multiplies that of J by gamma: 100 eps of the terms that are
      // summed.
      const Real scale = tau.norm() + 3 * stiffness(law);
      EXPECT_LT((rotated - Q * tau * Q.transpose()).norm(), 100 * k_epsilon * scale);
      EXPECT_LT((tau - tau.transpose()).norm(), 10 * k_epsilon * scale);
    }
  });
}

TYPED_TEST(AllLawsTest, elastic_stress_is_the_derivative_of_the_energy) {
  if constexpr (has_energy<TypeParam>) {
    this->for_samples([](const TypeParam& law) {
      Samples samples;
      for (int n = 0; n < 100; ++n) {
        const Eigen::Matrix3d F = samples.deformation();
        const Eigen::Matrix3d tau = stress(law, F);
        const Real scale = tau.norm() + 3 * stiffness(law);
        const Dual W = law.energy_density(with_derivatives(F));
        const Eigen::Matrix3d P = Eigen::Map<const Eigen::Matrix<Real, 3, 3, Eigen::RowMajor>>(W.derivatives().data());
        EXPECT_LT((tau - P * F.transpose()).norm(), 100 * k_epsilon * scale);
        EXPECT_DOUBLE_EQ(W.value(), law.energy_density(from_eigen(F)));
        // Central differences share no code with the other derivative: h^2/6 of the third derivative, which is below 1e4 stiffnesses for
        // J^-gamma here, and eps W / h.
        const Real h = 1e-6;
        Eigen::Matrix3d difference;
        for (int k = 0; k < 9; ++k) {
          Eigen::Matrix3d ahead = F, behind = F;
          ahead(k / 3, k % 3) += h;
          behind(k / 3, k % 3) -= h;
          difference(k / 3, k % 3) = (law.energy_density(from_eigen(ahead)) - law.energy_density(from_eigen(behind))) / (2 * h);
        }
        EXPECT_LT((tau - difference * F.transpose()).norm(), 1e-8 * scale);
      }
    });
  }
}

TYPED_TEST(AllLawsTest, energy_is_positive_away_from_rotations) {
  if constexpr (has_energy<TypeParam>) {
    this->for_samples([](const TypeParam& law) {
      Samples samples;
      for (int n = 0; n < 300; ++n) {
        const Eigen::Matrix3d F = samples.deformation(n % 3 == 0 ? 1e-3 : n % 3 == 1 ? 0.1 : 0.4);
        EXPECT_GT(law.energy_density(from_eigen(F)), -10 * k_epsilon * stiffness(law));
        // Every law here resists a change of volume, and none stores energy in a rotation.
        const Real stretch = 1 + (n % 2 == 0 ? 0.01 : -0.01) * (1 + n % 7);
        EXPECT_GT(law.energy_density(from_eigen(stretch * Eigen::Matrix3d::Identity())), 1e-6 * stiffness(law));
        EXPECT_LT(std::abs(law.energy_density(from_eigen(samples.rotation()))), 100 * k_epsilon * stiffness(law));
      }
    });
  }
}

TYPED_TEST(AllLawsTest, tangent_by_automatic_differentiation_is_that_of_differences) {
  this->for_samples([](const TypeParam& law) {
    Samples samples;
    for (int n = 0; n < 50; ++n) {
      const Eigen::Matrix3d F = samples.deformation();
      const Eigen::Matrix3d L = samples.matrix(10);
      Mat3<Dual> L_constant;
      for (int k = 0; k < 9; ++k) L_constant.entries[k] = Dual(L(k / 3, k % 3));
      const Mat3<Dual> tau = stress(law, with_derivatives(F), L_constant);
      Eigen::Matrix<Real, 9, 9> tangent, difference;
      // Of central differences of tau, relative to the tangent: h^2 gamma^3, and eps / h.
      const Real h = 1e-6;
      for (int j = 0; j < 9; ++j) {
        Eigen::Matrix3d ahead = F, behind = F;
        ahead(j / 3, j % 3) += h;
        behind(j / 3, j % 3) -= h;
        const Eigen::Matrix3d slope = (stress(law, ahead, L) - stress(law, behind, L)) / (2 * h);
        for (int i = 0; i < 9; ++i) {
          tangent(i, j) = tau.entries[i].derivatives()(j);
          difference(i, j) = slope(i / 3, i % 3);
        }
      }
      EXPECT_LT((tangent - difference).norm(), 1e-7 * (tangent.norm() + stiffness(law)));
      EXPECT_GT(tangent.norm(), 0.1 * stiffness(law));
    }
  });
}

TYPED_TEST(AllLawsTest, plane_matrices_give_the_numbers_of_full_ones) {
  this->for_samples([](const TypeParam& law) {
    Samples samples;
    for (int n = 0; n < 100; ++n) {
      const Eigen::Matrix3d F3 = samples.deformation();
      const Eigen::Matrix3d L3 = samples.matrix(10);
      Plane F = Plane::identity(), L = Plane::zero();
      Full F_full = Full::identity(), L_full = Full::zero();
      for (int r = 0; r < 2; ++r) {
        for (int c = 0; c < 2; ++c) {
          F(r, c) = F_full(r, c) = F3(r, c);
          L(r, c) = L_full(r, c) = L3(r, c);
        }
      }
      if (determinant(F) < 0.5) continue;
      const Plane tau = stress(law, F, L);
      const Full tau_full = stress(law, F_full, L_full);
      // Only the order of sums, and which products are fused, can differ.
      const Real bound = 100 * k_epsilon * (to_eigen(tau_full).norm() + 3 * stiffness(law));
      for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) {
          if (Plane::is_stored(r, c)) {
            EXPECT_NEAR(tau(r, c), tau_full(r, c), bound);
          } else {
            EXPECT_EQ(tau_full(r, c), 0);
          }
        }
      }
      if constexpr (has_energy<TypeParam>) {
        EXPECT_NEAR(law.energy_density(F), law.energy_density(F_full), bound);
      }
      if constexpr (has_dissipation<TypeParam>) {
        const Real rate = law.dissipation_rate(Kinematics<Full>{F_full, L_full, 1});
        EXPECT_NEAR(law.dissipation_rate(Kinematics<Plane>{F, L, 1}), rate, 100 * k_epsilon * rate);
      }
    }
  });
}

TYPED_TEST(AllLawsTest, small_strains_give_hookes_law_with_a_stable_stiffness) {
  this->for_samples([](const TypeParam& law) {
    const Mat3<Dual> zero = Mat3<Dual>::zero();
    const Mat3<Dual> tau = stress(law, with_derivatives(Eigen::Matrix3d::Identity()), zero);
    const auto slope = [&](int i, int j, int k, int l) { return tau(i, j).derivatives()(3 * k + l); };
    const Real lambda = slope(0, 0, 1, 1);
    const Real mu = slope(0, 1, 0, 1);
    const Real bound = 100 * k_epsilon * stiffness(law);
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        for (int k = 0; k < 3; ++k) {
          for (int l = 0; l < 3; ++l) {
            // lambda tr(eps) I + 2 mu eps, eps the symmetric part of F - I.
            const Real hooke = lambda * (i == j && k == l) + mu * ((i == k && j == l) + (i == l && j == k));
            EXPECT_NEAR(slope(i, j, k, l), hooke, bound) << i << j << k << l;
          }
        }
      }
    }
    EXPECT_GE(mu, -bound);
    EXPECT_GT(lambda + 2 * mu / 3, 0) << "bulk modulus";
    EXPECT_NEAR(lambda + 2 * mu, stiffness(law), bound) << "the speed of pressure waves at rest";
    if constexpr (std::is_base_of_v<ElasticParameters, TypeParam>) {
      const Real E = law.youngs_modulus, nu = law.poissons_ratio;
      EXPECT_NEAR(mu, E / (2 * (1 + nu)), bound);
      EXPECT_NEAR(lambda, E * nu / ((1 + nu) * (1 - 2 * nu)), bound);
    }
  });
}

TYPED_TEST(AllLawsTest, wave_speed_is_that_of_the_uniaxial_stress_and_never_below_it) {
  this->for_samples([](const TypeParam& law) {
    // In uniaxial strain the cross-section stays, so the first Piola-Kirchhoff stress is tau_xx / J, and J c_0 = c in space.
    const auto P = [&](Real J) { return stress(law, Eigen::Vector3d(J, 1, 1).asDiagonal().toDenseMatrix())(0, 0) / J; };
    int exact_count = 0;
    for (int n = 0; n <= 80; ++n) {
      const Real J = (70 + n) / 100.0;  // 1 exactly, where a law may have a kink
      const Real h = 1e-5;
      const Real c_squared = J * J * (P(J + h) - P(J - h)) / (2 * h) / law.density;
      const Real given = law.wave_speed(J) * law.wave_speed(J);
      // Central differences: h^2/6 times a third derivative of gamma^3 at most, and eps / h.
      const Real bound = 1e-7 * (given + stiffness(law) / law.density);
      EXPECT_GT(given, c_squared - bound) << "J = " << J << ": a step that counts on this would be unstable";
      if (std::abs(given - c_squared) < bound) ++exact_count;
    }
    EXPECT_GE(exact_count, 70) << "a law may give more where the material softens, and nowhere else";
    // From the side of compression, to second order.
    const Real slope = (3 * P(1) - 4 * P(1 - 1e-5) + P(1 - 2e-5)) / 2e-5;
    EXPECT_NEAR(law.wave_speed(1), std::sqrt(slope / law.density), 1e-7 * law.wave_speed(1));
  });
}

TYPED_TEST(AllLawsTest, dissipation_is_the_power_of_the_viscous_stress) {
  this->for_samples([](const TypeParam& law) {
    Samples samples;
    for (int n = 0; n < 100; ++n) {
      const Eigen::Matrix3d F = samples.deformation();
      const Eigen::Matrix3d L = samples.matrix(10);
      const Eigen::Matrix3d viscous = stress(law, F, L) - stress(law, F);
      const Eigen::Matrix3d d = (L + L.transpose()) / 2;
      const Real power_of_stress = (viscous.array() * d.array()).sum();
      // The viscous stress is a difference of two stresses.
      const Real bound = 100 * k_epsilon * (stress(law, F, L).norm() + stiffness(law)) * d.norm();
      if constexpr (has_dissipation<TypeParam>) {
        const Real rate = law.dissipation_rate(Kinematics<Full>{from_eigen(F), from_eigen(L), 1});
        EXPECT_NEAR(rate, power_of_stress, bound);
        EXPECT_GE(rate, 0);
        // A stress that follows a rotation without deformation would be felt by a spinning body.
        const Eigen::Matrix3d spin = (L - L.transpose()) / 2;
        EXPECT_LT((stress(law, F, spin) - stress(law, F)).norm(), bound);
      } else if (k_history_size<TypeParam> == 0) {
        EXPECT_EQ(viscous.norm(), 0) << "the stress depends on L: the law needs a dissipation_rate";
      }
    }
  });
}

TYPED_TEST(AllLawsTest, parameters_are_declared_with_unit_and_help) {
  bool has_density = false;
  for (const ParameterDescription& parameter : parameters_of<TypeParam>().describe()) {
    EXPECT_FALSE(parameter.unit.empty()) << parameter.name;
    EXPECT_FALSE(parameter.help.empty()) << parameter.name;
    EXPECT_FALSE(parameter.allowed.empty()) << parameter.name << ": no number is right without any limit";
    has_density = has_density || parameter.name == "density";
  }
  EXPECT_TRUE(has_density);
  EXPECT_FALSE(std::string(TypeParam::summary).empty());
}

}  // namespace
}  // namespace matpoint::test
