// Bodies on walls: friction, impact, books, and what must not pass.
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "verify/everyday.hpp"

namespace matpoint {
namespace {

/// A block on a floor that is pulled from under it, ever faster: it sticks for 1 s, then Coulomb.
Measured friction_ramp(const EverydaySetting& setting) {
  std::string times, velocities;
  for (int k = 0; k <= 100; ++k) {
    const Real t = 0.02 * k;
    times += fmt::format("{}{}", k == 0 ? "" : ", ", t);
    velocities += fmt::format("{}[{}, 0]", k == 0 ? "" : ", ", -0.15 * t * t);
  }
  Measured measured;
  for (const char* E : {"1e6", "1e8", "1e9"}) {
    Simulation sim(everyday_case(fmt::format(R"(
gravity = [0, -1]
[grid]
upper = [3, 1]
cells = [30, 10]
[time]
end = 2
[[body]]
name = "block"
region = {{ type = "box", lower = [1.4, 0], upper = [1.8, 0.4] }}
layout = {{ type = "per_cell", count = 4 }}
material = {{ type = "neo_hookean", density = 1000, youngs_modulus = {}, poissons_ratio = 0.3 }}
[[boundary]]
side = "bottom"
kind = "velocity"
times = [{}]
velocities = [{}]
contact = "friction"
friction = 0.3
)",
                                             E, times, velocities),
                                 setting));
    sim.run();
    const BodyTotals totals = sim.solver().totals(0);
    measured["ramp_" + std::string(E)] = totals.momentum[0] / totals.mass + 0.6;
  }
  return measured;
}

/// The same on another body, which the floor holds and pulls along. Gravity comes at once, so the block rings on the other one: while its
/// pressure swings it slips before it should. A rigid block on a floor with N = W (1 - cos 2 pi t / T), T the period of the bar, has .1505
/// to .1532 m/s for E = 1e6 and the two heights and moduli that T may be made of; to .1507 for E = 1e8.
Measured friction_between(const EverydaySetting& setting, const std::vector<const char*>& moduli, int dim) {
  std::string times, velocities;
  for (int k = 0; k <= 100; ++k) {
    const Real t = 0.02 * k;
    times += fmt::format("{}{}", k == 0 ? "" : ", ", t);
    velocities += fmt::format("{}[{}, 0{}]", k == 0 ? "" : ", ", -0.15 * t * t, dim == 3 ? ", 0" : "");
  }
  // Corners of the grid, of the block and of the body below.
  const char* const corners[][2] = {{"3, 1", "3, 1, 1.2"},
                                    {"1.4, 0.2", "1.4, 0.2, 0.4"},
                                    {"1.8, 0.6", "1.8, 0.6, 0.8"},
                                    {"0.7, 0", "0.7, 0, 0.2"},
                                    {"2.7, 0.2", "2.7, 0.2, 1"}};
  const auto corner = [&](int k) { return corners[k][dim - 2]; };
  Measured measured;
  for (const char* contact : {"multi_field", "pairs"}) {
    for (const char* E : moduli) {
      const std::string material =
          fmt::format("{{ type = \"neo_hookean\", density = 1000, youngs_modulus = {}, poissons_ratio = 0.3 }}", E);
      Simulation sim(everyday_case(fmt::format(R"(
dim = {}
gravity = [0, -1{}]
[grid]
upper = [{}]
cell_size = 0.1
[time]
end = 2
[solver]
contact = "{}"
friction = 0.3
[[body]]
name = "block"
region = {{ type = "box", lower = [{}], upper = [{}] }}
layout = {{ type = "per_cell", count = {} }}
material = {}
[[body]]
name = "below"
region = {{ type = "box", lower = [{}], upper = [{}] }}
layout = {{ type = "per_cell", count = {} }}
material = {}
[[boundary]]
side = "bottom"
kind = "velocity"
times = [{}]
velocities = [{}]
)",
                                               dim, dim == 3 ? ", 0" : "", corner(0), contact, corner(1), corner(2), 1 << dim, material,
                                               corner(3), corner(4), 1 << dim, material, times, velocities),
                                   setting));
      sim.run();
      const BodyTotals totals = sim.solver().totals(0);
      measured[fmt::format("rub_{}{}_{}", dim == 3 ? "3d_" : "", contact, E)] = totals.momentum[0] / totals.mass + 0.6;
    }
  }
  return measured;
}

/// On the bottom, and on the surface of a region at every line of the lower half of a grid.
Measured sliding_stop(const EverydaySetting& setting, int cells) {
  const auto way = [&](Real floor, const std::string& boundary) {
    Simulation sim(everyday_case(fmt::format(R"(
gravity = [0, -9.81]
[grid]
upper = [2, 1]
cells = [{4}, {5}]
[time]
end = 0.5
[[body]]
name = "block"
region = {{ type = "box", lower = [0.4, {0}], upper = [0.8, {1}] }}
layout = {{ type = "per_cell", count = 4 }}
velocity = {{ type = "uniform", value = [1, 0] }}
{2}
[[boundary]]
{3}
kind = "fixed"
contact = "friction"
friction = 0.3
)",
                                             floor, floor + 0.4, k_everyday_solid, boundary, 2 * cells, cells),
                                 setting));
    const Real start = sim.solver().totals(0).center_of_mass[0];
    sim.run();
    return sim.solver().totals(0).center_of_mass[0] - start;
  };
  Measured measured{{"sliding_side", way(0, "side = \"bottom\"")}};
  Range lines;
  for (int k = 1; k <= cells / 2; ++k) {
    for (const Real y : {k / static_cast<Real>(cells), k * (1 / static_cast<Real>(cells))}) {
      lines.include(way(y, fmt::format("region = {{ type = \"box\", lower = [-0.1, -0.1], upper = [2.1, {}] }}", y)));
    }
  }
  measured["sliding_region"] = lines.greatest;
  measured["sliding_region_spread"] = lines.greatest - lines.least;
  return measured;
}

Measured flat_landing(const EverydaySetting& setting, int cells) {
  Simulation sim(everyday_case(fmt::format(R"(
gravity = [0, -9.81]
[grid]
upper = [2, 1.5]
cells = [{}, {}]
[time]
end = 0.25
[[body]]
name = "block"
region = {{ type = "box", lower = [0.35, 0.3], upper = [0.65, 0.6] }}
layout = {{ type = "per_cell", count = 4 }}
velocity = {{ type = "uniform", value = [0.4, -3] }}
material = {{ type = "neo_hookean", density = 2700, youngs_modulus = 1e8, poissons_ratio = 0.3 }}
[[boundary]]
side = "bottom"
contact = "no_tension"
)",
                                           cells, cells * 3 / 4),
                               setting));
  const std::vector<Real> X = sim.solver().field(0, "position").values;
  const BodyTotals start = sim.solver().totals(0);
  sim.run();
  const std::vector<Real> x = sim.solver().field(0, "position").values;
  const BodyTotals end = sim.solver().totals(0);
  Real cosine = 0, sine = 0;  // of the rotation that fits best
  for (std::size_t k = 0; k < X.size(); k += 2) {
    const Real a = X[k] - start.center_of_mass[0], b = X[k + 1] - start.center_of_mass[1];
    const Real c = x[k] - end.center_of_mass[0], d = x[k + 1] - end.center_of_mass[1];
    cosine += a * c + b * d;
    sine += a * d - b * c;
  }
  const Real speed = std::sqrt(9 + 2 * 9.81 * 0.3);
  return {{"landing_angle", std::abs(std::atan2(sine, cosine)) * 180 / std::numbers::pi},
          {"landing_restitution", sim.solver().ledger().boundary_impulse[1] / (end.mass * speed) - 1}};
}

/// What friction and a wall that lets go have taken, by the books and really.
Measured books_of_walls(const EverydaySetting& setting) {
  Measured measured;
  {
    Simulation sim(everyday_case(R"(
gravity = [0, -9.81]
[grid]
upper = [2, 2]
cells = [8, 8]
[time]
end = 2
[[body]]
name = "b"
region = { type = "box", lower = [0.5, 0], upper = [1.5, 1] }
layout = { type = "per_cell", count = 4 }
material = { type = "neo_hookean", density = 1000, youngs_modulus = 5e6, poissons_ratio = 0.2 }
[[boundary]]
side = "bottom"
kind = "fixed"
contact = "friction"
friction = 0.3
)",
                                 setting));
    const Real start = total_energy(sim);
    sim.run();
    measured["books_at_rest"] = std::abs(sim.solver().ledger().contact_dissipation) / start;
  }
  {
    const Real angle = 35 * std::numbers::pi / 180;
    Simulation sim(everyday_case(fmt::format(R"(
gravity = [{}, {}]
[grid]
upper = [3, 1]
cells = [30, 10]
[time]
end = 0.8
[[body]]
name = "b"
region = {{ type = "box", lower = [0.3, 0], upper = [0.7, 0.4] }}
layout = {{ type = "per_cell", count = 4 }}
{}
[[boundary]]
side = "bottom"
kind = "fixed"
contact = "friction"
friction = 0.25
)",
                                             9.81 * std::sin(angle), -9.81 * std::cos(angle), k_everyday_solid),
                                 setting));
    const Real start = sim.solver().totals(0).center_of_mass[0];
    sim.run();
    const BodyTotals end = sim.solver().totals(0);
    const Real force = 0.25 * end.mass * 9.81 * std::cos(angle);
    measured["books_sliding"] = sim.solver().ledger().contact_dissipation / (force * (end.center_of_mass[0] - start));
  }
  {
    Simulation sim(everyday_case(R"(
[grid]
upper = [1.6, 0.1]
cell_size = 0.05
[time]
end = 0.3
[[body]]
name = "b"
region = { type = "box", lower = [0.1, 0], upper = [1.1, 0.1] }
layout = { type = "per_cell", count = 4 }
velocity = { type = "uniform", value = [-1, 0] }
material = { type = "neo_hookean", density = 1000, youngs_modulus = 1e6, poissons_ratio = 0 }
[[boundary]]
side = "left"
contact = "no_tension"
)",
                                 setting));
    const Real start = total_energy(sim);
    sim.run();
    measured["books_bar"] = std::abs(start - total_energy(sim) - sim.solver().ledger().contact_dissipation) / start;
  }
  return measured;
}

/// Water behind an inclined plate, half a cell thick and three, and behind a wall that stands on the floor: how much passes.
Measured plates(const EverydaySetting& setting) {
  const auto passed = [&](const std::string& grid, const std::string& water, const std::string& obstacle, auto&& is_past) {
    std::string text = fmt::format(R"(
gravity = [0, -9.81]
[grid]
{}
[time]
end = 3
[[body]]
name = "water"
region = {}
layout = {{ type = "per_cell", count = 4 }}
material = {{ type = "newtonian_fluid", density = 1000, pressure_scale = 57142.857, tension = 0 }}
)",
                                   grid, water);
    for (const char* side : {"left", "right", "bottom", "top"})
      text += fmt::format("[[boundary]]\nside = \"{}\"\ncontact = \"no_tension\"\n", side);
    Simulation sim(everyday_case(text + "[[boundary]]\n" + obstacle, setting));
    Real greatest = 0;
    every(sim, 20, [&](const Simulation& now) {
      const std::vector<Real> x = now.solver().field(0, "position").values;
      Real count = 0;
      for (std::size_t k = 0; k < x.size(); k += 2) count += is_past(x[k], x[k + 1]) ? 1 : 0;
      greatest = std::max(greatest, count);
    });
    sim.run();
    return greatest;
  };
  const std::string trough = "{ type = \"polygon\", vertices = [[0, 0], [0.3, 0], [0.66, 0.6], [0, 0.6]] }";
  const auto plate = [](const char* vertices) {
    return fmt::format("region = {{ type = \"polygon\", vertices = [{}] }}\nkind = \"fixed\"\n", vertices);
  };
  return {{"passed_plate", passed("upper = [1, 1]\ncells = [20, 20]", trough, plate("[0.3, 0], [0.325, 0], [0.925, 1], [0.9, 1]"),
                                  [](Real x, Real y) { return x > 0.325 + 0.6 * y; })},
          {"passed_thick_plate", passed("upper = [1.1, 1]\ncells = [22, 20]", trough, plate("[0.3, 0], [0.45, 0], [1.05, 1], [0.9, 1]"),
                                        [](Real x, Real y) { return x > 0.45 + 0.6 * y; })},
          {"passed_wall", passed("upper = [1, 1]\ncells = [20, 20]", "{ type = \"box\", lower = [0, 0], upper = [0.425, 0.6] }",
                                 "region = { type = \"box\", lower = [0.449999, 0], upper = [0.550001, 1] }\nkind = \"slip\"\n"
                                 "contact = \"no_tension\"\n",
                                 [](Real x, Real) { return x > 0.55; })}};
}

/// A soft block falls on a step whose top is a line of the grid, and is damped: how far its lowest particle is above the step.
Measured on_a_step(const EverydaySetting& setting) {
  Simulation sim(everyday_case(R"(
gravity = [0, -9.81]
[grid]
upper = [1, 1]
cells = [10, 10]
[time]
end = 1.5
dt = 2e-4
[solver]
stress_order = "musl"
damping = 10
[[body]]
name = "block"
region = { type = "box", lower = [0.4, 0.45], upper = [0.6, 0.65] }
layout = { type = "per_cell", count = 16 }
material = { type = "neo_hookean", density = 1000, youngs_modulus = 2e5, poissons_ratio = 0.3 }
[[boundary]]
region = { type = "box", lower = [0.2, 0], upper = [0.8, 0.3] }
kind = "fixed"
)",
                               setting));
  sim.run();
  const Real lowest = sim.solver().totals(0).lower[1];
  return {{"step_lowest", lowest}, {"step_lowest_too", lowest}};
}

}  // namespace

std::vector<EverydayProblem> everyday_walls() {
  constexpr const char* k_ringing = "Coulomb, a block that rings: .1505 to .1532";
  return {
      {"friction that sets in", friction_ramp,
       [](bool) -> std::vector<VerifyRow> {
         return {within("ramp_1e6", 0.15, 0.0015, "Coulomb"), within("ramp_1e8", 0.15, 0.0015, "Coulomb"),
                 within("ramp_1e9", 0.15, 0.0015, "Coulomb")};
       },
       3e6},
      {"friction between bodies", [](const EverydaySetting& setting) { return friction_between(setting, {"1e6"}, 2); },
       [](bool) -> std::vector<VerifyRow> {
         return {within("rub_multi_field_1e6", 0.152, 0.003, k_ringing), within("rub_pairs_1e6", 0.152, 0.003, k_ringing)};
       },
       2e6},
      {"friction between stiff bodies",
       [](const EverydaySetting& setting) {
         return friction_between(setting, {"1e8", "1e9"}, 2);
       },
       [](bool) -> std::vector<VerifyRow> {
         return {within("rub_multi_field_1e8", 0.15, 0.003, "Coulomb"), within("rub_pairs_1e8", 0.15, 0.003, "Coulomb"),
                 within("rub_multi_field_1e9", 0.15, 0.003, "Coulomb"), within("rub_pairs_1e9", 0.15, 0.003, "Coulomb")};
       },
       3e7, false},
      {"friction between bodies in 3D", [](const EverydaySetting& setting) { return friction_between(setting, {"1e6"}, 3); },
       [](bool) -> std::vector<VerifyRow> {
         return {within("rub_3d_multi_field_1e6", 0.152, 0.003, k_ringing), within("rub_3d_pairs_1e6", 0.152, 0.003, k_ringing)};
       },
       1e7, false},
      {"a block slides to rest", [](const EverydaySetting& setting) { return sliding_stop(setting, 10); },
       [](bool) -> std::vector<VerifyRow> {
         return {within("sliding_side", 0.1699, 0.0017, "v^2 / (2 mu g)"), within("sliding_region", 0.1699, 0.0017, "v^2 / (2 mu g)"),
                 at_most("sliding_region_spread", 1e-6, "all lines of a grid are alike")};
       },
       1e6},
      {"a flat block lands flat", [](const EverydaySetting& setting) { return flat_landing(setting, 80); },
       [](bool) -> std::vector<VerifyRow> {
         return {at_most("landing_angle", 1, "no torque acts"), within("landing_restitution", 0.785, 0.05 * 0.785, k_fe)};
       },
       2e6},
      {"the books of friction and impact", books_of_walls,
       [](bool) -> std::vector<VerifyRow> {
         return {at_most("books_at_rest", 1e-3, "nothing slides"), within("books_sliding", 1, 0.02, "mu N x way"),
                 at_most("books_bar", 0.01, "what was lost")};
       },
       1e6},
      {"water behind a plate and a wall", plates,
       [](bool) -> std::vector<VerifyRow> {
         return {at_most("passed_plate", 0, "nothing passes"), at_most("passed_thick_plate", 0, "nothing passes"),
                 at_most("passed_wall", 0, "nothing passes")};
       },
       5e6},
      {"a block comes to rest on a step", on_a_step,
       [](bool) -> std::vector<VerifyRow> {
         return {at_least("step_lowest", 0.3, "it does not sink in"),
                 at_most("step_lowest_too", 0.4, "it rests on the step, within a cell")};
       },
       2e5},
      {"a flat block lands flat, 24 cells a side",
       [](const EverydaySetting& setting) { return with_prefix("fine_", flat_landing(setting, 160)); },
       [](bool) -> std::vector<VerifyRow> {
         return {at_most("fine_landing_angle", 1, "no torque acts"), within("fine_landing_restitution", 0.785, 0.03 * 0.785, k_fe)};
       },
       2e7, false},
      {"a block slides to rest on 20 lines", [](const EverydaySetting& setting) { return with_prefix("fine_", sliding_stop(setting, 40)); },
       [](bool) -> std::vector<VerifyRow> {
         return {within("fine_sliding_side", 0.1699, 0.0017, "v^2 / (2 mu g)"),
                 within("fine_sliding_region", 0.1699, 0.0017, "v^2 / (2 mu g)"),
                 at_most("fine_sliding_region_spread", 1e-6, "all lines of a grid are alike")};
       },
       1e8, false},
  };
}

}  // namespace matpoint
