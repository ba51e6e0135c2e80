// Water in boxes.
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "verify/everyday.hpp"

namespace matpoint {
namespace {

std::string box_of_water(const std::string& grid, const std::string& body, const std::string& rest) {
  std::string text =
      "gravity = [0, -9.81]\n" + grid + "[[body]]\nname = \"water\"\nlayout = { type = \"per_cell\", count = 4 }\n" + body + rest;
  for (const char* side : {"left", "right", "bottom", "top"}) text += fmt::format("[[boundary]]\nside = \"{}\"\n", side);
  return text;
}

Measured corner(const EverydaySetting& setting) {
  Simulation sim(everyday_case(box_of_water("[grid]\nupper = [1, 1]\ncells = [32, 32]\n[time]\nend = 0.5\n",
                                            "region = { type = \"box\", lower = [0.3, 0.3], upper = [0.7, 0.7] }\n"
                                            "velocity = { type = \"uniform\", value = [-10, -10] }\n",
                                            k_everyday_water),
                               setting));
  return {{"corner_energy_greatest", run_with_energy(sim).greatest}};
}

Measured closed_box(const EverydaySetting& setting, int cells) {
  Simulation sim(everyday_case(box_of_water(fmt::format("[grid]\nupper = [1, 1]\ncells = [{0}, {0}]\n[time]\nend = 20\n", cells),
                                            "region = { type = \"box\", lower = [0, 0], upper = [0.4, 0.6] }\n", k_everyday_water),
                               setting));
  const auto rows = static_cast<std::size_t>(cells / 5);  // of cells below y = 0.2
  std::vector<Real> pressure(rows, 0), depth(rows, 0), count(rows, 0);
  every(sim, 50, [&](const Simulation& now) {
    if (now.time() < 15) return;
    const std::vector<Real> x = now.solver().field(0, "position").values;
    const std::vector<Real> xx = component(now, 0, "stress", 0);  // of water without viscosity -p
    for (std::size_t p = 0; p < xx.size(); ++p) {
      const auto row = static_cast<std::size_t>(x[2 * p + 1] * cells);
      if (row >= rows) continue;
      pressure[row] -= xx[p];
      depth[row] += 0.24 - x[2 * p + 1];
      count[row] += 1;
    }
  });
  Real sum = 0, time = 0, early = 1;
  const Real start = total_energy(sim);
  sim.add_callback([&](const Simulation& now) {
    if (now.time() < 0.25) early = total_energy(now) / start;
    if (now.time() >= 15) {
      sum += now.last_dt() * now.solver().totals(0).center_of_mass[1];
      time += now.last_dt();
    }
    return true;
  });
  const Range range = run_with_energy(sim);
  Real squares = 0;
  for (std::size_t row = 0; row < rows; ++row) {
    const Real difference = (pressure[row] / 9810 - depth[row]) / count[row] / 0.24;
    squares += difference * difference / static_cast<Real>(rows);
  }
  return {{"box_energy_greatest", range.greatest},
          {"box_energy_at_0.25", early},
          {"box_centre", sum / time},
          {"box_pressure", std::sqrt(squares)}};
}

Measured dam_front(const EverydaySetting& setting) {
  Measured measured;
  Range fronts;
  for (const auto& [name, scale] : {std::pair("c20", 4e5 / 7), std::pair("c200", 4e7 / 7), std::pair("c1483", 2.2e9 / 7)}) {
    Simulation sim(everyday_case(
        box_of_water("[grid]\nupper = [1, 1]\ncells = [40, 40]\n[time]\nend = 0.25\n",
                     "region = { type = \"box\", lower = [0, 0], upper = [0.4, 0.6] }\n",
                     fmt::format("material = {{ type = \"newtonian_fluid\", density = 1000, pressure_scale = {} }}\n", scale)),
        setting));
    sim.run();
    const Real front = sim.solver().totals(0).upper[0] + 0.025 / 4;
    fronts.include(front);
    measured[std::string("dam_front_") + name] = front;
  }
  measured["dam_front_difference"] = fronts.greatest / fronts.least - 1;
  return measured;
}

Measured still_water(const EverydaySetting& setting, Real end) {
  Simulation sim(everyday_case(box_of_water(fmt::format("[grid]\nupper = [1, 0.7]\ncell_size = 0.025\n[time]\nend = {}\n", end),
                                            "fbar = true\nregion = { type = \"box\", lower = [0, 0], upper = [1, 0.5] }\n",
                                            "material = { type = \"newtonian_fluid\", density = 1000, pressure_scale = 70071.4 }\n"),
                               setting));
  Real greatest = 0;
  sim.add_callback([&](const Simulation& now) {
    greatest = std::max(greatest, now.solver().totals(0).kinetic_energy);
    return true;
  });
  sim.run();
  return {{"still_kinetic_energy", greatest}, {"still_centre", sim.solver().totals(0).center_of_mass[1]}};
}

/// Idelsohn, Marti, Limache & Onate 2008, with a lid: how far the corner of the obstacle goes, and when.
Measured obstacle(const EverydaySetting& setting, Real end) {
  std::string text = fmt::format(R"(
gravity = [0, -9.81]
[grid]
upper = [0.584, 0.4]
cell_size = 0.004
[time]
end = {}
[[body]]
name = "water"
region = {{ type = "box", lower = [0, 0], upper = [0.146, 0.292] }}
layout = {{ type = "per_cell", count = 4 }}
material = {{ type = "newtonian_fluid", density = 1000, pressure_scale = 1e5 }}
[[body]]
name = "obstacle"
region = {{ type = "box", lower = [0.286, 0], upper = [0.298, 0.08] }}
layout = {{ type = "per_cell", count = 4 }}
material = {{ type = "neo_hookean", density = 2500, youngs_modulus = 1e6, poissons_ratio = 0 }}
)",
                                 end);
  for (const char* side : {"bottom", "left", "right", "top"}) text += fmt::format("[[boundary]]\nside = \"{}\"\n", side);
  text += "[[boundary]]\nregion = { type = \"box\", lower = [0.286, -0.001], upper = [0.298, 0.001] }\nkind = \"fixed\"\n";
  Simulation sim(everyday_case(text, setting));
  const std::vector<Real> X = sim.solver().field(1, "position").values;
  std::size_t corner = 0;
  const auto distance = [&](std::size_t k) { return std::hypot(X[k] - 0.286, X[k + 1] - 0.08); };
  for (std::size_t k = 0; k < X.size(); k += 2) corner = distance(k) < distance(corner) ? k : corner;
  Real way = 0, time = 0;
  every(sim, 5, [&](const Simulation& now) {
    const Real u = now.solver().field(1, "position").values[corner] - X[corner];
    if (u <= way || now.time() > 0.5) return;
    way = u;
    time = now.time();
  });
  const Range range = run_with_energy(sim);
  return {{"obstacle_way", way}, {"obstacle_time", time}, {"obstacle_energy_greatest", range.greatest}};
}

/// The same box in 3D: a column of 0.5 x 0.6 m and 0.8 m high in the corner of a cube.
Measured cube(const EverydaySetting& setting) {
  std::string text = R"(
dim = 3
gravity = [0, 0, -9.81]
[grid]
upper = [1, 1, 1]
cells = [20, 20, 20]
[time]
end = 20
[[body]]
name = "water"
region = { type = "box", lower = [0, 0, 0], upper = [0.5, 0.6, 0.8] }
layout = { type = "per_cell", count = 8 }
)" + std::string(k_everyday_water);
  for (const char* side : {"left", "right", "bottom", "top", "front", "back"}) text += fmt::format("[[boundary]]\nside = \"{}\"\n", side);
  Simulation sim(everyday_case(text, setting));
  Real sum = 0, time = 0, early = 1;
  const Real start = total_energy(sim);
  sim.add_callback([&](const Simulation& now) {
    if (now.time() < 0.25) early = total_energy(now) / start;
    if (now.time() >= 15) {
      sum += now.last_dt() * now.solver().totals(0).center_of_mass[2];
      time += now.last_dt();
    }
    return true;
  });
  const Range range = run_with_energy(sim);
  return {{"cube_energy_greatest", range.greatest}, {"cube_energy_at_0.25", early}, {"cube_centre", sum / time}};
}

/// A long, shallow dam of 25 cells in height: it must come to its end.
Measured shallow_dam(const EverydaySetting& setting) {
  Simulation sim(everyday_case(R"(
gravity = [0, -9.8]
[grid]
upper = [2.6, 0.14]
cell_size = 0.004
[time]
end = 0.5
[[body]]
name = "water"
region = { type = "box", lower = [0, 0], upper = [1, 0.1] }
layout = { type = "per_cell", count = 4 }
material = { type = "newtonian_fluid", density = 1000, pressure_scale = 175000 }
[[boundary]]
side = "left"
[[boundary]]
side = "bottom"
)",
                               setting));
  const Index start = sim.solver().particle_count(0);
  const Range range = run_with_energy(sim);
  return {{"shallow_dam_lost", static_cast<Real>(start - sim.solver().particle_count(0))}, {"shallow_dam_energy_greatest", range.greatest}};
}

}  // namespace

std::vector<EverydayProblem> everyday_fluids() {
  return {
      {"fluid thrown into a corner", corner,
       [](bool) -> std::vector<VerifyRow> { return {at_most("corner_energy_greatest", 1.01, "energy is kept")}; }, 3e6},
      {"a dam breaks in a closed box", [](const EverydaySetting& setting) { return closed_box(setting, 20); },
       [](bool) -> std::vector<VerifyRow> {
         return {at_most("box_energy_greatest", 1.005, "energy is kept"),
                 at_least("box_energy_at_0.25", 0.98, "nothing has hit a wall yet"),
                 within("box_centre", 0.1195, 0.02 * 0.1195, "the water keeps its volume"), at_most("box_pressure", 0.05, "hydrostatics")};
       },
       2e7},
      {"the front of a dam break", dam_front,
       [](bool) -> std::vector<VerifyRow> {
         const char* const source = "boundary elements";
         return {within("dam_front_c20", 0.94, 0.03 * 0.94, source), within("dam_front_c200", 0.94, 0.03 * 0.94, source),
                 within("dam_front_c1483", 0.94, 0.03 * 0.94, source),
                 at_most("dam_front_difference", 0.01, "stiff water flows as soft water does")};
       },
       6e7},
      {"still water with fbar", [](const EverydaySetting& setting) { return still_water(setting, 5); },
       [](bool) -> std::vector<VerifyRow> {
         return {at_most("still_kinetic_energy", 5, "4.09 J/m: gravity comes at once"), within("still_centre", 0.25, 0.005, "it stays")};
       },
       4e7},
      {"a dam breaks on an elastic obstacle, to 0.3 s", [](const EverydaySetting& setting) { return obstacle(setting, 0.3); },
       [](bool) -> std::vector<VerifyRow> {
         return {within("obstacle_way", 0.045, 0.005, "Walhorn et al. and others"),
                 within("obstacle_time", 0.245, 0.015, "Walhorn et al. and others"),
                 at_most("obstacle_energy_greatest", 1.01, "energy is kept")};
       },
       1e7},
      {"a dam breaks in a closed box of 40 cells",
       [](const EverydaySetting& setting) { return with_prefix("long_", closed_box(setting, 40)); },
       [](bool) -> std::vector<VerifyRow> {
         return {at_most("long_box_energy_greatest", 1.005, "energy is kept"),
                 at_least("long_box_energy_at_0.25", 0.98, "nothing has hit a wall yet"),
                 within("long_box_centre", 0.1195, 0.02 * 0.1195, "the water keeps its volume"),
                 at_most("long_box_pressure", 0.05, "hydrostatics")};
       },
       1e8, false},
      {"still water with fbar, 20 s", [](const EverydaySetting& setting) { return with_prefix("long_", still_water(setting, 20)); },
       [](bool) -> std::vector<VerifyRow> {
         return {at_most("long_still_kinetic_energy", 5, "4.09 J/m: gravity comes at once"),
                 within("long_still_centre", 0.25, 0.005, "it stays")};
       },
       2e8, false},
      {"a dam breaks on an elastic obstacle, to 2 s",
       [](const EverydaySetting& setting) { return with_prefix("long_", obstacle(setting, 2)); },
       [](bool) -> std::vector<VerifyRow> { return {at_most("long_obstacle_energy_greatest", 1.01, "energy is kept")}; }, 4e8, false},
      {"a column of water collapses in a cube", cube,
       [](bool) -> std::vector<VerifyRow> {
         return {at_most("cube_energy_greatest", 1.005, "energy is kept"),
                 at_least("cube_energy_at_0.25", 0.98, "nothing has hit a wall yet"),
                 within("cube_centre", 0.12, 0.02 * 0.12, "the water keeps its volume")};
       },
       1e8, false},
      {"a long, shallow dam", shallow_dam,
       [](bool) -> std::vector<VerifyRow> {
         return {at_most("shallow_dam_lost", 0, "the sides are closed"), at_most("shallow_dam_energy_greatest", 1.01, "energy is kept")};
       },
       1e8, false},
  };
}

}  // namespace matpoint
