// Soils that lose strength with slip: closed forms, and what a step must keep whatever it is.
#include "material/point_path.hpp"
#include "material/point_test.hpp"
#include "support/from_toml.hpp"

namespace matpoint::test {
namespace {

constexpr Real k_slip = 0.02, k_length = 0.05;
const std::string k_soil = "density = 1800\nyoungs_modulus = 1e7\npoissons_ratio = 0.3\ncohesion = 1e4\nfriction_angle = 30\n";
const std::string k_softening = "softening_slip = 0.02\nlength = 0.05\n";

Real radians(Real degrees) { return degrees * std::acos(Real{-1}) / 180; }

/// sqrt(J2) after a plane isochoric stretch diag(e^t, e^-t, 1) of a law whose strength without pressure goes from `peak` to `residual`:
/// r = 2 G t - sqrt3 G a, r = residual + (peak - residual) (1 - a/a_r), a_r = slip/(sqrt3 h).
Real shear_stress(Real t, Real G, Real peak, Real residual) {
  const Real a_r = k_slip / (std::sqrt(3.0) * k_length);
  if (2 * G * t < peak) return 2 * G * t;
  const Real lost = (peak - residual) / a_r;
  const Real a = (2 * G * t - peak) / (std::sqrt(3.0) * G - lost);
  return a < a_r ? peak - lost * a : residual;
}

template <class Law>
void compare_with_closed_form(const Law& law, Real peak, Real residual) {
  for (const int steps : {1, 7, 40}) {
    for (const Real end : {0.002, 0.01, 0.1, 0.19, 0.3}) {
      PointOnPath<Law> point(law);
      for (int n = 1; n <= steps; ++n) {
        const Real t = end * n / steps;
        point.step(Eigen::Vector3d(std::exp(t), std::exp(-t), 1).asDiagonal(), 1);
      }
      const Real found = 0.5 * (point.tau(0, 0) - point.tau(1, 1));
      EXPECT_NEAR(found, shear_stress(end, law.mu(), peak, residual), 1e-9 * peak) << steps << " steps to " << end;
    }
  }
}

TEST(Softening, strength_without_volume_change_falls_along_its_line) {
  const std::string text = k_soil + k_softening + "residual_cohesion = 2e3";
  const Real c = std::cos(radians(30));
  compare_with_closed_form(law_of<MohrCoulomb>(text), c * 1e4, c * 2e3);
  compare_with_closed_form(law_of<DruckerPrager>(text, 2), c * 1e4, c * 2e3);
  compare_with_closed_form(law_of<DruckerPrager>(text + "\nfit = \"compression\""), 1.2e4, 2.4e3);
}

TEST(Softening, a_band_loses_its_strength_after_the_slip_whatever_its_width) {
  for (const Real length : {0.01, 0.02, 0.05}) {
    const auto law = law_of<MohrCoulomb>(
        k_soil + fmt::format("residual_cohesion = 0\nresidual_friction_angle = 0\nsoftening_slip = 0.02\nlength = {}", length));
    const auto stress_at = [&](Real slip) {
      PointOnPath<MohrCoulomb, true> point(law);
      // The work of a shear up to here, per area of the band.
      for (int n = 1; n <= 2000; ++n) {
        Eigen::Matrix3d F = Eigen::Matrix3d::Identity();
        F(0, 1) = n * slip / length / 2000;
        point.step(F, 1);
      }
      return std::pair{point.tau(0, 1), point.dissipated * length};
    };
    const Real elastic = law.cohesion / law.mu() * length;
    EXPECT_GT(stress_at(0.9 * (k_slip + elastic)).first, 0.05 * law.cohesion) << length;
    const auto [left, work] = stress_at(1.5 * k_slip);
    EXPECT_NEAR(left, 0, 1e-9 * law.cohesion) << length;
    // A triangle; that shear is no stretch costs the square of the angle between them.
    EXPECT_NEAR(work, 0.5 * law.cohesion * std::cos(radians(30)) * k_slip, 0.02 * law.cohesion * k_slip) << length;
  }
}

TEST(Softening, triaxial_strength_goes_from_the_peak_to_the_residual_one) {
  auto material = std::make_shared<LawMaterial<MohrCoulomb>>();
  material->law = law_of<MohrCoulomb>(k_soil + k_softening +
                                      "dilatancy_angle = 10\nresidual_cohesion = 1e3\nresidual_friction_angle = 25\n"
                                      "residual_dilatancy_angle = 0\n");
  PointTestSpec spec;
  spec.path = "triaxial";
  spec.confining = 5e4;
  spec.strain = -0.4;
  spec.steps = 2000;
  const PointTestResult result = run_point_test(material, spec);
  const auto column = [&](const char* name) {
    return static_cast<std::size_t>(std::find(result.names.begin(), result.names.end(), name) - result.names.begin());
  };
  Real greatest = 0;
  for (const auto& row : result.rows) greatest = std::max(greatest, row[column("q")]);
  const auto strength = [](Real c, Real phi) {
    const Real K = std::pow(std::tan(radians(45 + phi / 2)), 2);
    return (K - 1) * 5e4 + 2 * c * std::sqrt(K);
  };
  // The strength is one of Kirchhoff stresses, J times Cauchy's.
  EXPECT_NEAR(greatest, strength(1e4, 30), 0.01 * strength(1e4, 30));
  const auto& last = result.rows.back();
  const Real K = std::pow(std::tan(radians(45 + 12.5)), 2);
  EXPECT_NEAR(last[column("q")], (K - 1) * 5e4 + 2 * 1e3 * std::sqrt(K) / last[column("J")], 1);
  // Its volume has found its end.
  const auto& before = result.rows[result.rows.size() - 200];
  EXPECT_NEAR(last[column("J")], before[column("J")], 1e-9);
  EXPECT_GT(last[column("J")], 1.005);
}

/// How far stress is above the strength that its plastic strain has left [Pa].
Real excess(const MohrCoulomb& law, const PointOnPath<MohrCoulomb>& point) {
  const Real a_r = *law.softening_slip / (std::sqrt(3.0) * *law.length);
  const Real w = std::max(Real{0}, 1 - point.history.internal.plastic_strain / a_r);
  const auto mixed = [&](Real peak, Real residual) { return residual + w * (peak - residual); };
  const Real s = mixed(std::sin(radians(law.friction_angle)), std::sin(radians(*law.residual_friction_angle)));
  const Real two_c = mixed(2 * law.cohesion * std::cos(radians(law.friction_angle)),
                           2 * *law.residual_cohesion * std::cos(radians(*law.residual_friction_angle)));
  const Eigen::Vector3d t = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(to_eigen(point.tau)).eigenvalues();
  return t[2] - t[0] + (t[2] + t[0]) * s - two_c;
}

TEST(Softening, stress_ends_on_the_strength_that_is_left) {
  const auto law = law_of<MohrCoulomb>(k_soil + k_softening +
                                       "dilatancy_angle = 10\nresidual_cohesion = 1e3\nresidual_friction_angle = 20\n"
                                       "residual_dilatancy_angle = 0\n");
  Samples samples;
  Real worst = 0;
  for (int path = 0; path < 2000; ++path) {
    PointOnPath<MohrCoulomb> point(law);
    point.press(3e4);
    Eigen::Matrix3d F = Eigen::Matrix3d::Identity();
    for (int n = 0; n < 6; ++n) {
      F = (Eigen::Matrix3d::Identity() + samples.matrix(path % 2 == 0 ? 0.002 : 0.03)) * F;
      point.step(F, 1);
      worst = std::max(worst, excess(law, point) / (law.cohesion + to_eigen(point.tau).norm()));
    }
  }
  EXPECT_LT(worst, 1e-7);
}

template <class Law>
Real tension_after_slip(const std::string& residual) {
  const auto law = law_of<Law>(k_soil + k_softening + residual, 2);
  PointOnPath<Law> point(law);
  Eigen::Matrix3d F = Eigen::Matrix3d::Identity();
  for (int n = 1; n <= 100; ++n) {
    F(0, 1) = 0.01 * n;
    point.step(F, 1);
  }
  for (int n = 1; n <= 10; ++n) point.step(std::exp(0.01 * n) * F, 1);
  return to_eigen(point.tau).trace() / 3;
}

TEST(Softening, nothing_holds_more_tension_for_having_slipped) {
  const Real peak = 1e4 / std::tan(radians(30));
  for (const char* residual :
       {"residual_friction_angle = 10", "residual_friction_angle = 0", "residual_friction_angle = 0\nresidual_cohesion = 0"}) {
    EXPECT_LT(tension_after_slip<MohrCoulomb>(residual), peak * (1 + 1e-9)) << residual;
    EXPECT_LT(tension_after_slip<DruckerPrager>(residual), peak * (1 + 1e-9)) << residual;
  }
  EXPECT_LT(tension_after_slip<MohrCoulomb>("residual_cohesion = 0"), 1e-9 * peak) << "what has no cohesion holds none";
}

TEST(Softening, a_point_without_a_length_is_refused) {
  const auto refuses = [](const char* type, const std::string& text) {
    const auto material =
        material_registry().read(parse_toml(fmt::format("type = \"{}\"\n{}", type, text), "law.toml"), {3, ""}, "material");
    return complaint_of([&] { MaterialPoint point(material); });
  };
  EXPECT_NE(refuses("mohr_coulomb", k_soil + "residual_cohesion = 0\nsoftening_slip = 0.1").find("needs `length` [m]"), std::string::npos);
  EXPECT_EQ(refuses("mohr_coulomb", k_soil), "");
  EXPECT_NE(
      refuses("rankine_damage", "density = 900\nyoungs_modulus = 1e9\npoissons_ratio = 0.3\ntensile_strength = 1e6\nfracture_energy = 9")
          .find("needs `length` [m]"),
      std::string::npos);
}

}  // namespace
}  // namespace matpoint::test
