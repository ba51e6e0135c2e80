// Bodies that nothing acts on, and that turn, and halves of models.
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "verify/everyday.hpp"

namespace matpoint {
namespace {

/// How far a ball of each stiffness ends from g t^2 / 2 after a fall of 1 m, or from what steps of a finite length make of that.
Measured free_fall(const EverydaySetting& setting, const std::string& prefix, const std::string& place, const std::string& ball,
                   std::size_t down, const std::vector<std::string>& moduli) {
  Measured measured;
  for (const std::string& E : moduli) {
    Simulation sim(everyday_case(fmt::format(R"(
{}
[time]
end = 0.4515236409857309
[[body]]
name = "ball"
{}
material = {{ type = "neo_hookean", density = 7800, youngs_modulus = {}, poissons_ratio = 0.3 }}
)",
                                             place, ball, E),
                                 setting));
    Real squares = 0;
    sim.add_callback([&](const Simulation& now) {
      squares += now.last_dt() * now.last_dt();
      return true;
    });
    const Real start = sim.solver().totals(0).center_of_mass[down];
    sim.run();
    const Real way = start - sim.solver().totals(0).center_of_mass[down];
    measured[prefix + E] = std::min(std::abs(way - 1), std::abs(way - 1 - 0.5 * 9.81 * squares));
  }
  return measured;
}

Measured free_fall_of_a_disk(const EverydaySetting& setting) {
  return free_fall(setting, "free_fall_", "gravity = [0, -9.81]\n[grid]\nupper = [1, 2]\ncells = [20, 40]",
                   "region = { type = \"disk\", center = [0.5, 1.6], radius = 0.2 }\nlayout = { type = \"per_cell\", count = 4 }", 1,
                   {"1e5", "1e8", "2e11"});
}

Measured free_fall_of_a_sphere(const EverydaySetting& setting) {
  return free_fall(setting, "free_fall_3d_", "dim = 3\ngravity = [0, 0, -9.81]\n[grid]\nupper = [1, 1, 2]\ncells = [10, 10, 20]",
                   "region = { type = \"sphere\", center = [0.5, 0.5, 1.6], radius = 0.2 }\nlayout = { type = \"per_cell\", count = 8 }", 2,
                   {"1e5", "2e11"});
}

/// Free flight over 20 cells at .4 of the speed of sound: nothing happens to the disk.
Measured free_flight(const EverydaySetting& setting) {
  Measured measured{{"flight_momentum", 0}, {"flight_energy", 0}, {"flight_J", 0}};
  for (const Real E : {1e5, 2e11}) {
    const Real c = std::sqrt(E * 0.7 / (1.3 * 0.4) / 7800);
    Simulation sim(everyday_case(fmt::format(R"(
[grid]
upper = [2, 1.2]
cell_size = 0.05
[time]
end = {}
[[body]]
name = "disk"
region = {{ type = "disk", center = [0.5, 0.5], radius = 0.2 }}
layout = {{ type = "per_cell", count = 4 }}
velocity = {{ type = "uniform", value = [{}, {}] }}
material = {{ type = "neo_hookean", density = 7800, youngs_modulus = {}, poissons_ratio = 0.3 }}
)",
                                             2.5 / c, 0.4 * c, 0.1 * c, E),
                                 setting));
    const BodyTotals start = sim.solver().totals(0);
    const Real energy_start = total_energy(sim);
    sim.run();
    const BodyTotals end = sim.solver().totals(0);
    const auto see = [&](const char* name, Real value) { measured[name] = std::max(measured[name], std::abs(value)); };
    see("flight_momentum", end.momentum[0] / start.momentum[0] - 1);
    see("flight_energy", total_energy(sim) / energy_start - 1);
    see("flight_J", std::max(end.J_max - 1, 1 - end.J_min));
  }
  return measured;
}

/// One step of uniform motion of points on lines of the grid, and on its nodes.
Measured one_step(const EverydaySetting& setting) {
  Real greatest = 0;
  for (const Real first : {0.25, 0.2}) {
    std::string points;
    for (int j = 0; j < 7; ++j) {
      for (int i = 0; i < 7; ++i) points += fmt::format("[{}, {}], ", first + 0.1 * i, first + 0.1 * j);
    }
    Simulation sim(everyday_case(fmt::format(R"(
[grid]
upper = [1, 1]
cell_size = 0.1
[time]
end = 1e-3
dt = 1e-3
[[body]]
name = "points"
layout = {{ type = "points", positions = [{}], volumes = 0.01 }}
velocity = {{ type = "uniform", value = [1, 0.5] }}
{})",
                                             points, k_everyday_solid),
                                 setting));
    sim.run();
    const std::vector<Real> F = sim.solver().field(0, "deformation_gradient").values;
    for (std::size_t k = 0; k < F.size(); ++k) greatest = std::max(greatest, std::abs(F[k] - (k % 9 % 4 == 0 ? 1 : 0)));
  }
  return {{"one_step_F", greatest}};
}

/// Two half disks on a slip side meet as the whole ones do.
Measured half_models(const EverydaySetting& setting) {
  const auto momenta = [&](const std::string& contact, bool is_half, int cells) {
    const auto region = [&](Real x, Real radius) {
      const std::string disk = fmt::format("{{ type = \"disk\", center = [{}, 0], radius = {} }}", x, radius);
      // As a difference, whose measure is not known, both have particles of the same volume.
      if (!is_half) return fmt::format("{{ type = \"difference\", of = [{}, {{ type = \"disk\", center = [9, 9], radius = 1 }}] }}", disk);
      return fmt::format("{{ type = \"difference\", of = [{}, {{ type = \"half_space\", point = [0, 0], normal = [0, 1] }}] }}", disk);
    };
    std::string text = fmt::format(R"(
[grid]
lower = [0, {}]
upper = [1, 0.5]
cells = [{}, {}]
[time]
dt = 2e-4
end = 0.5
[solver]
contact = "{}"
)",
                                   is_half ? 0 : -0.5, cells, is_half ? cells / 2 : cells, contact);
    for (const auto& [name, x, radius, v] : {std::tuple("a", 0.3, 0.2, 0.5), std::tuple("b", 0.72, 0.21, -0.5)}) {
      text += fmt::format(R"([[body]]
name = "{}"
region = {}
layout = {{ type = "per_cell", count = 4 }}
velocity = {{ type = "uniform", value = [{}, 0] }}
material = {{ type = "neo_hookean", density = 1000, youngs_modulus = 1e4, poissons_ratio = 0.3 }}
)",
                          name, region(x, radius), v);
    }
    if (is_half) text += "[[boundary]]\nside = \"bottom\"\nkind = \"slip\"\n";
    Simulation sim(everyday_case(text, setting));
    std::vector<Real> all{sim.solver().totals(0).momentum[0]};
    every(sim, 5, [&](const Simulation& now) { all.push_back(now.solver().totals(0).momentum[0]); });
    sim.run();
    return all;
  };
  Measured measured;
  for (const std::string contact : {"single_field", "multi_field", "pairs"}) {
    try {
      const std::vector<Real> full = momenta(contact, false, 40), half = momenta(contact, true, 40);
      Real greatest = 0;
      for (std::size_t k = 0; k < full.size(); ++k) greatest = std::max(greatest, std::abs(half[k] / half[0] - full[k] / full[0]));
      measured["half_" + contact] = greatest;
    } catch (const InputError&) {
      measured["half_" + contact] = 0;  // refused: multi_field is for linear shapes
    }
  }
  return measured;
}

Measured spinning_disk(const EverydaySetting& setting) {
  Simulation sim(everyday_case(fmt::format(R"(
[grid]
upper = [1, 1]
cell_size = 0.05
[time]
end = 10
[[body]]
name = "disk"
region = {{ type = "disk", center = [0.5, 0.5], radius = 0.3 }}
layout = {{ type = "per_cell", count = 4 }}
velocity = {{ type = "rotating", center = [0.5, 0.5], angular_velocity = {} }}
{})",
                                           2 * std::numbers::pi, k_everyday_solid),
                               setting));
  const auto angular_momentum = [&] {
    const std::vector<Real> x = sim.solver().field(0, "position").values, v = sim.solver().field(0, "velocity").values,
                            m = sim.solver().field(0, "mass").values;
    const std::vector<std::string> names = sim.solver().field_names(0);
    std::vector<Real> C;
    if (std::find(names.begin(), names.end(), "affine_velocity") != names.end()) C = sim.solver().field(0, "affine_velocity").values;
    const BodyTotals totals = sim.solver().totals(0);
    const std::size_t width = C.empty() ? 0 : C.size() / m.size();
    Real sum = 0;
    for (std::size_t p = 0; p < m.size(); ++p) {
      sum += m[p] * ((x[2 * p] - totals.center_of_mass[0]) * v[2 * p + 1] - (x[2 * p + 1] - totals.center_of_mass[1]) * v[2 * p]);
      // D of quadratic splines is h^2 / 4; C row by row.
      if (width > 0) sum += m[p] * 0.05 * 0.05 / 4 * (C[p * width + (width == 9 ? 3 : 2)] - C[p * width + 1]);
    }
    return sum;
  };
  const Real start = angular_momentum();
  const Range range = run_with_energy(sim);
  return {
      {"spin_angular_momentum", angular_momentum() / start}, {"spin_energy_least", range.least}, {"spin_energy_greatest", range.greatest}};
}

}  // namespace

std::vector<EverydayProblem> everyday_motion() {
  return {
      {"free fall of a steel disk", free_fall_of_a_disk,
       [](bool) -> std::vector<VerifyRow> {
         return {at_most("free_fall_1e5", 1e-6, "g t^2 / 2"), at_most("free_fall_1e8", 1e-6, "g t^2 / 2"),
                 at_most("free_fall_2e11", 1e-6, "g t^2 / 2")};
       },
       6e6},
      {"free fall of a steel sphere", free_fall_of_a_sphere,
       [](bool) -> std::vector<VerifyRow> {
         return {at_most("free_fall_3d_1e5", 1e-6, "g t^2 / 2"), at_most("free_fall_3d_2e11", 1e-6, "g t^2 / 2")};
       },
       2e7, false},
      {"free flight over 20 cells", free_flight,
       [](bool is_single) -> std::vector<VerifyRow> {
         const Real bound = is_single ? 1e-4 : 1e-10;
         return {at_most("flight_momentum", bound, "nothing acts"), at_most("flight_energy", bound, "nothing acts"),
                 at_most("flight_J", is_single ? 1e-5 : 1e-10, "nothing acts")};
       },
       2e6},
      {"one step of points on lines and nodes", one_step,
       [](bool is_single) -> std::vector<VerifyRow> { return {at_most("one_step_F", is_single ? 1e-6 : 1e-12, "F = I")}; }, 1e2},
      {"a disk spins ten times", spinning_disk,
       [](bool) -> std::vector<VerifyRow> {
         return {within("spin_angular_momentum", 1, 0.01, "no torque acts"), at_least("spin_energy_least", 0.97, "energy is kept"),
                 at_most("spin_energy_greatest", 1.03, "energy is kept")};
       },
       1e7},
      {"half a model on a slip side", half_models,
       [](bool) -> std::vector<VerifyRow> {
         return {at_most("half_single_field", 0.01, "the whole model"), at_most("half_multi_field", 0.01, "the whole model"),
                 at_most("half_pairs", 0.01, "the whole model")};
       },
       2e7},
  };
}

}  // namespace matpoint
