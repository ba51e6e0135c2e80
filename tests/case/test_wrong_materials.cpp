// Laws whose parameters fit one by one and not together, and materials that do not fit the case: one message each, with what is allowed.
#include "support/from_toml.hpp"

#include "case/case.hpp"

namespace matpoint::test {
namespace {

const char* const k_case = R"(
[grid]
upper = [1, 1]
cells = [10, 10]
[time]
end = 0.1
dt = 1e-3
[[body]]
name = "block"
region = { type = "box", lower = [0.2, 0.2], upper = [0.6, 0.6] }
layout = { type = "per_cell", count = 4 }
)";

std::string complaint(const std::string& material, const std::vector<std::string>& sets = {}) {
  return complaint_of([&] {
    Input input = parse_toml(k_case + ("material = " + material + "\n"), "case.toml");
    for (const std::string& set : sets) apply_set(input, set);
    Case::from_input(input, "case");
  });
}
const std::string k_elastic = "density = 1000, youngs_modulus = 1e9, poissons_ratio = 0.3";

TEST(WrongMaterials, parameters_that_do_not_fit_together_are_refused_with_what_is_allowed) {
  const std::string clay =
      "{ type = \"cam_clay\", density = 1700, shear_modulus = 3e6, critical_slope = 1, pressure_offset = 1e3, "
      "preconsolidation = 1e5, ";
  const std::string copper = "{ type = \"johnson_cook\", A = 9e7, " + k_elastic;
  const std::string ice = "{ type = \"rankine_damage\", tensile_strength = 1e6, fracture_energy = 10, " + k_elastic;
  const std::string soil = "{ type = \"mohr_coulomb\", cohesion = 1e5, friction_angle = 30, " + k_elastic;
  const std::string cone = "{ type = \"drucker_prager\", cohesion = 1e5, friction_angle = 30, " + k_elastic;
  const std::string rubber = "density = 1000, bulk_modulus = 1e8";
  const std::vector<std::pair<std::string, std::string>> wrong = {
      {clay + "lambda_star = 0.02, kappa_star = 0.02 }", "lambda_star = 0.02 is not above kappa_star = 0.02"},
      {clay + "lambda_star = 0.1, kappa_star = 1.5 }", "kappa_star = 1.5 is not allowed, it must be in the interval (0, 1)"},
      {copper + ", melting_temperature = 200 }", "melting_temperature = 200 is not above reference_temperature = 298"},
      {copper + ", melting_temperature = 1000, temperature = 1200 }", "temperature = 1200: it has melted at 1000"},
      {copper + ", D3 = -1 }", "D1 and D2 are both 0: it would fail at once"},
      {copper + ", D1 = 0.5, D3 = 1 }", "D3 = 1 is not allowed, it must be at most 0"},
      {copper + ", n = 1.5 }", "n = 1.5 is not allowed, it must be in the interval (0, 1]"},
      {"{ type = \"johnson_cook\", A = 9e7, density = 1, youngs_modulus = 1, poissons_ratio = 0.5 }",
       "poissons_ratio = 0.5 is not allowed"},
      {ice + " }", "length = 0.1 stores more energy than fracture_energy takes when it breaks"},
      {ice + ", length = 1 }", "allowed: below 2 E Gf/ft^2 = 0.02"},
      {soil + ", dilatancy_angle = 31 }", "dilatancy_angle = 31 is above friction_angle = 30"},
      {soil + ", residual_cohesion = 2e5, softening_slip = 0.1 }",
       "residual_cohesion = 200000 is above cohesion = 100000; allowed: 0 to cohesion"},
      {soil + ", residual_friction_angle = 31, softening_slip = 0.1 }", "residual_friction_angle = 31 is above friction_angle = 30"},
      {soil + ", residual_dilatancy_angle = 1, softening_slip = 0.1 }", "residual_dilatancy_angle = 1 is above dilatancy_angle = 0"},
      {soil + ", dilatancy_angle = 20, residual_dilatancy_angle = 15, residual_friction_angle = 10, softening_slip = 0.1 }",
       "residual_dilatancy_angle = 15 is above the residual friction angle = 10"},
      {soil + ", residual_cohesion = 0 }", "residual strength needs softening_slip [m]"},
      {soil + ", softening_slip = 0.1 }", "softening_slip = 0.1 has nothing to soften"},
      // slip G/(c cos phi), without dilatancy
      {soil + ", residual_cohesion = 0, softening_slip = 1e-5 }",
       "length = 0.3 stores more energy than softening takes (it would snap back); allowed: below 0.0444116"},
      {cone + ", residual_cohesion = 0, softening_slip = 1e-5 }", "allowed: below 0.0444116: use smaller cells or a longer softening_slip"},
      {"{ type = \"snow\", hardening_limit = 0.5, " + k_elastic + " }", "hardening_limit = 0.5 is not allowed, it must be at least 1"},
      {"{ type = \"yeoh\", c1 = 1e4, c2 = -1e4, c3 = 10, " + rubber + " }", "allowed: c2 > -sqrt(3 c1 c3)"},
      {"{ type = \"gent\", shear_modulus = 1e4, Jm = 0, " + rubber + " }", "Jm = 0 is not allowed"},
      {"{ type = \"ogden\", mu_1 = 1e4, alpha_1 = -2, " + rubber + " }", "mu_1 = 10000 and alpha_1 = -2 have not the same sign"},
      {"{ type = \"ogden\", mu_1 = 0, alpha_1 = 2, " + rubber + " }", "it has no shear modulus"},
      {"{ type = \"viscoelastic\", density = 1, bulk_modulus = 1e6, modulus_1 = 1e5, time_1 = 0 }", "time_1 = 0 is not allowed"},
      {"{ type = \"ideal_gas\", density = 1, pressure = 0 }", "pressure = 0 is not allowed"},
      {"{ type = \"ideal_gas\", density = 1, pressure = 1, gamma = 1 }", "gamma = 1 is not allowed"},
      {"{ type = \"stiffened_gas\", density = 1, gamma = 2, stiff_pressure = 0 }", "nothing would resist"},
      {"\"copper_ofch\"", "names no parameter set, allowed: \"copper_ofhc\""}};
  for (const auto& [material, text] : wrong) {
    const std::string message = complaint(material);
    EXPECT_NE(message.find(text), std::string::npos) << material << "\n" << message;
    EXPECT_EQ(message.find("case.toml:"), 0u) << message;
  }
}

TEST(WrongMaterials, a_case_chooses_what_its_materials_need) {
  const auto chosen = [](const std::string& material, const std::vector<std::string>& sets = {}) {
    Input input = parse_toml(k_case + ("material = " + material + "\n"), "case.toml");
    for (const std::string& set : sets) apply_set(input, set);
    return Case::from_input(input, "case");
  };
  std::string moving = k_case;
  moving.replace(moving.find("dt = 1e-3\n"), 10, "");
  const std::string water = "{ type = \"newtonian_fluid\", density = 1000, pressure_scale = 1e5 }";
  const auto automatic = [&](const std::string& material, const std::vector<std::string>& sets = {}) {
    Input input = parse_toml(moving + "material = " + material + "\n", "case.toml");
    for (const std::string& set : sets) apply_set(input, set);
    return Case::from_input(input, "case");
  };
  EXPECT_EQ(automatic("\"air\"").time.cfl, 0.2);
  EXPECT_EQ(automatic("\"air\"", {"time.cfl=0.5"}).time.cfl, 0.5);
  EXPECT_EQ(automatic("\"air\"", {"solver.quality=robust"}).time.cfl, 0.1);
  EXPECT_EQ(automatic(water).time.cfl, 0.4);
  EXPECT_FALSE(*chosen("\"air\"").solver.fluid_correction);
  EXPECT_TRUE(*chosen(water).solver.fluid_correction);
  const std::string sand = "{ type = \"mohr_coulomb\", cohesion = 1e3, friction_angle = 30, " + k_elastic + " }";
  const std::vector<std::string> resting = {"gravity=[0, -10]", "body.block.initial_stress={ type = \"geostatic\", K0 = 0.5 }"};
  EXPECT_EQ(chosen(sand).solver.shape, ShapeKind::bspline2);
  EXPECT_EQ(chosen(sand, resting).solver.shape, ShapeKind::gimp);
  EXPECT_EQ(chosen(sand, resting).solver.transfer, Transfer::apic);
}

TEST(WrongMaterials, what_does_not_fit_the_case_is_refused) {
  EXPECT_EQ(complaint("\"air\""), "");
  EXPECT_NE(complaint("\"air\"", {"solver.fluid_correction=true"}).find("moves volume without its energy"), std::string::npos);
  EXPECT_NE(complaint("\"air\"", {"solver.type=implicit"}).find("\"ideal_gas\" is for solver.type = \"explicit\" only"), std::string::npos);
  // A length is the cell size, so cells that are not equal need one.
  const std::vector<std::string> graded = {"solver.type=implicit", "solver.basis=element", "grid.grading=[1.1, 1]"};
  const std::string ice = "{ type = \"rankine_damage\", tensile_strength = 1e5, fracture_energy = 10, " + k_elastic;
  EXPECT_NE(complaint(ice + " }", graded).find("length is missing: it is the cell size, and the cells are not equal"), std::string::npos);
  EXPECT_EQ(complaint(ice + ", length = 0.1 }", graded), "");
  Input input = parse_toml(k_case + ("material = " + ice + " }\n"), "case.toml");
  const Input written = Case::from_input(input, "case").bodies[0].material->write(2);
  ASSERT_NE(written.find("length"), nullptr);
  EXPECT_NEAR(written.find("length")->as_real(), 0.1, 1e-12) << "the manifest has it";
}

}  // namespace
}  // namespace matpoint::test
