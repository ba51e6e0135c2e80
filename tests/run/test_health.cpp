// What a run says about itself at its end, and that the remedy it names is one.
#include "run/health.hpp"

#include <random>

#include "case/case_file.hpp"
#include "support/solver_case.hpp"

namespace matpoint::test {
namespace {

const char* const k_block = R"(
[grid]
upper = [1, 1]
cells = [10, 10]
[time]
end = 0.1
[[body]]
name = "block"
region = { type = "box", lower = [0.3, 0.3], upper = [0.7, 0.7] }
layout = { type = "per_cell", count = 9 }
velocity = { type = "rotating", center = [0.5, 0.5], angular_velocity = 1 }
material = { type = "neo_hookean", density = 1000, youngs_modulus = 1e4, poissons_ratio = 0.3 }
)";

/// A block that turns, with `noise` [m/s] added to each velocity, after a short run.
HealthLine noise_of_block(Real noise, const std::vector<std::string>& sets = {}) {
  Input input = parse_toml(k_block, "case.toml");
  for (const std::string& set : sets) apply_set(input, set);
  Simulation sim(Case::from_input(input, "case"));
  std::vector<Real> v = sim.solver().field(0, "velocity").values;
  std::mt19937 random(1);
  std::normal_distribution<Real> some(0, noise);
  if (noise > 0) {
    for (Real& one : v) one += some(random);
    sim.set_field(0, "velocity", v);
  }
  sim.run();
  for (const HealthLine& line : sim.health()) {
    if (line.name == "noise") return line;
  }
  ADD_FAILURE() << "no line of noise";
  return {};
}

TEST(Health, energy_inside_cells_is_that_of_random_velocities_and_none_of_linear_ones) {
  for (const int dim : {2, 3}) {
    const auto size = static_cast<std::size_t>(dim);
    std::mt19937 random(7);
    std::normal_distribution<Real> normal(0, 1);
    std::uniform_real_distribution<Real> place(-3, 3);
    const std::size_t count = 4000;
    std::vector<Real> x(count * size), linear(count * size), mixed(count * size), mass(count, 2);
    Real energy = 0;
    for (std::size_t p = 0; p < count; ++p) {
      for (std::size_t d = 0; d < size; ++d) x[p * size + d] = place(random);
      for (std::size_t d = 0; d < size; ++d) {
        linear[p * size + d] = 5 + 3 * x[p * size] - 7 * x[p * size + size - 1];
        const Real noise = normal(random);
        mixed[p * size + d] = linear[p * size + d] + noise;
        energy += noise * noise;  // m / 2 = 1
      }
    }
    const Vec3 cell{1, 1, 1};
    EXPECT_LT(unresolved_energy(x, linear, mass, dim, cell), 1e-20 * energy);
    EXPECT_NEAR(unresolved_energy(x, mixed, mass, dim, cell) / energy, 1, 0.05) << dim;
  }
}

TEST(Health, particles_in_a_line_and_lone_ones_do_not_spoil_the_measure) {
  const std::vector<Real> x{0.1, 0.5, 0.3, 0.5, 0.6, 0.5, 0.9, 0.5, 3.5, 3.5}, mass(5, 1);
  std::vector<Real> v{0.1, 0, 0.3, 0, 0.6, 0, 0.9, 0, 100, 100};
  EXPECT_LT(unresolved_energy(x, v, mass, 2, {1, 1, 1}), 1e-20);
  v[1] = 1;
  EXPECT_GT(unresolved_energy(x, v, mass, 2, {1, 1, 1}), 0.01);
}

TEST(Health, noise_is_a_warning_whose_remedy_does_away_with_it) {
  const HealthLine calm = noise_of_block(0), shaken = noise_of_block(1);
  EXPECT_TRUE(calm.is_good) << calm.text;
  EXPECT_FALSE(shaken.is_good) << shaken.text;
  EXPECT_NE(shaken.remedy.find("solver.transfer = \"apic\""), std::string::npos) << shaken.remedy;
  EXPECT_TRUE(noise_of_block(1, {"solver.transfer=apic"}).is_good);
}

TEST(Health, what_may_change_its_volume_or_come_apart_is_no_fault) {
  const auto line_of = [&](const std::string& material, const std::string& speed) {
    Input input = parse_toml(k_block, "case.toml");
    for (const std::string& set :
         {"body.block.material=" + material,
          "body.block.velocity={ type = \"linear\", center = [0.5, 0.5], gradient = [[" + speed + ", 0], [0, " + speed + "]] }",
          std::string("grid.particles_outside=remove"), std::string("time.end=0.02")})
      apply_set(input, set);
    Simulation sim(Case::from_input(input, "case"));
    sim.run();
    const auto lines = sim.health();
    return *std::find_if(lines.begin(), lines.end(), [](const HealthLine& line) { return line.name == "body block"; });
  };
  // A gas that doubles its area, ice that flies apart and sand that does; rubber torn as far would be a fault.
  EXPECT_TRUE(line_of("{ type = \"ideal_gas\", density = 1, pressure = 1 }", "25").is_good);
  EXPECT_TRUE(line_of("{ type = \"rankine_damage\", density = 1000, youngs_modulus = 1e4, poissons_ratio = 0.3, tensile_strength = 1, "
                      "fracture_energy = 1 }",
                      "400")
                  .is_good);
  EXPECT_TRUE(
      line_of(
          "{ type = \"drucker_prager\", density = 1000, youngs_modulus = 1e4, poissons_ratio = 0.3, cohesion = 0, friction_angle = 30 }",
          "400")
          .is_good);
  EXPECT_FALSE(line_of("{ type = \"neo_hookean\", density = 1000, youngs_modulus = 10, poissons_ratio = 0.3 }", "400").is_good);
}

}  // namespace
}  // namespace matpoint::test
