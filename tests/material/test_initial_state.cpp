// Every law that has elasticity can start with a stress that it can carry.
#include "material/initial_state.hpp"

#include "material/law_samples.hpp"
#include "support/from_toml.hpp"

namespace matpoint::test {
namespace {

/// The materials of all laws, with parameters from their declarations.
std::vector<std::shared_ptr<Material>> all_materials() {
  std::vector<std::shared_ptr<Material>> materials;
  for (const auto& entry : material_registry().entries()) {
    Input table = Input::table();
    table.set("type", Input::string(entry.name));
    std::shared_ptr<Material> material;
    const auto read = [&](const Input& input) { material = material_registry().read(input, {3, ""}, "material"); };
    read(sample_table(entry.parameters, 2, read, table));
    materials.push_back(material->needs_length() ? material->with_length(1e-9, Input::table(), {3, ""}) : material);
  }
  return materials;
}

Real stiffness_of(const Material& material) { return material.density() * std::pow(material.wave_speed(1), 2); }

/// Cauchy stress of a state.
std::array<Real, 6> stress_of(const Material& material, const InitialState& state) {
  std::array<Real, 6> sigma = components_of(material.kirchhoff_stress(state.F, state.history));
  const Real J =
      determinant(Mat3<Real>{{state.F[0], state.F[1], state.F[2], state.F[3], state.F[4], state.F[5], state.F[6], state.F[7], state.F[8]}});
  for (Real& component : sigma) component /= J;
  return sigma;
}

TEST(InitialState, every_law_carries_the_stress_that_it_starts_with) {
  for (const auto& material : all_materials()) {
    for (const int dim : {2, 3}) {
      SCOPED_TRACE(material->type() + fmt::format(" in {}D", dim));
      const Real p = 1e-3 * stiffness_of(*material);
      std::array<Real, 6> sigma = {-p, -0.9 * p, -1.1 * p, 0.05 * p, 0, 0};
      if (dim == 3) sigma[4] = -0.04 * p, sigma[5] = 0.03 * p;
      if (material->is_fluid()) sigma = {-p, -p, -p, 0, 0, 0};
      // A gas starts at its own pressure, from which a stress is only so far.
      const std::array<Real, 6> rest = components_of(material->kirchhoff_stress({1, 0, 0, 0, 1, 0, 0, 0, 1}));
      for (std::size_t s = 0; s < 6; ++s) sigma[s] += rest[s];
      const InitialState state = initial_state(*material, dim, sigma, std::nullopt);
      const std::array<Real, 6> found = stress_of(*material, state);
      for (std::size_t s = 0; s < (dim == 2 ? 4u : 6u); ++s) {
        if (dim == 2 && s == 2 && !material->remembers_strain() && !material->is_fluid()) continue;  // follows from the others
        EXPECT_NEAR(found[s], sigma[s], 1e-9 * stiffness_of(*material)) << s;
      }
      if (material->remembers_strain()) {
        for (std::size_t k = 0; k < 9; ++k) EXPECT_EQ(state.F[k], k % 4 == 0 ? 1 : 0) << "F counts from the stress";
      }
      if (dim == 2) {
        EXPECT_EQ(state.F[8], 1) << "plane strain";
      }
    }
  }
}

TEST(InitialState, clay_remembers_what_it_has_carried) {
  const auto clay = material_registry().read(
      parse_toml("type = \"cam_clay\"\ndensity = 1700\nshear_modulus = 3e6\ncritical_slope = 1.2\nlambda_star = 0.1\nkappa_star = 0.02\n"
                 "preconsolidation = 4e5\npressure_offset = 1e3",
                 "clay.toml"),
      {3, ""}, "material");
  const std::array<Real, 6> sigma = {-5e4, -1e5, -5e4, 0, 0, 0};
  const Real p = 2e5 / 3, q = 5e4, pc = p + q * q / (1.44 * p);
  // On the surface with a ratio of 1, inside with more, outside with less.
  for (const Real ratio : {1.0, 1.5, 3.0}) {
    const InitialState state = initial_state(*clay, 3, sigma, ratio);
    EXPECT_NEAR(4e5 * std::exp(state.history.back() / 0.08), ratio * pc, 1e-6 * pc);
    EXPECT_LT(yields_by(*clay, 3, state), 1e-9);
    EXPECT_NEAR(stress_of(*clay, state)[1], -1e5, 1e-4);
  }
  EXPECT_LT(yields_by(*clay, 3, initial_state(*clay, 3, sigma, std::nullopt)), 1e-9) << "4e5 is more than it carries";
  InitialState weak = initial_state(*clay, 3, sigma, 1.0);
  weak.history.back() = 0.08 * std::log(0.5 * pc / 4e5);
  EXPECT_GT(yields_by(*clay, 3, weak), 0.05);
}

TEST(InitialState, what_a_law_cannot_carry_is_said) {
  const auto water = material_registry().read(parse_toml("type = \"newtonian_fluid\"\ndensity = 1000\npressure_scale = 1e5", "w.toml"),
                                              {2, ""}, "material");
  const auto complaint = [&](const std::array<Real, 6>& sigma) {
    try {
      initial_state(*water, 2, sigma, std::nullopt);
      return std::string();
    } catch (const SolverError& error) {
      return std::string(error.what());
    }
  };
  EXPECT_NE(complaint({-1e3, -2e3, -1e3, 0, 0, 0}).find("the same pressure in all directions"), std::string::npos);
  EXPECT_EQ(complaint({-1e3, -1e3, -1e3, 0, 0, 0}), "");
  const auto sand = material_registry().read(
      parse_toml("type = \"mohr_coulomb\"\ndensity = 1800\nyoungs_modulus = 1e7\npoissons_ratio = 0.3\ncohesion = 0\nfriction_angle = 30",
                 "s.toml"),
      {2, ""}, "material");
  // K0 = 1/3 is the limit of 30 degrees.
  EXPECT_LT(yields_by(*sand, 2, initial_state(*sand, 2, {-0.34e5, -1e5, -0.5e5, 0, 0, 0}, std::nullopt)), 1e-12);
  EXPECT_GT(yields_by(*sand, 2, initial_state(*sand, 2, {-0.30e5, -1e5, -0.5e5, 0, 0, 0}, std::nullopt)), 0.01);
}

}  // namespace
}  // namespace matpoint::test
