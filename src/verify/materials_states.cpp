// Gases, shocks, brittle solids and ground at rest, against closed forms. Sources and what was found: docs/verification.md.
#include <algorithm>
#include <cmath>

#include "verify/materials.hpp"

namespace matpoint {
namespace {

// --- Tubes of gas: two halves in a strip of two cells, parted at 0.5 ---------------------------------------------------------------

Case tube(int dim, int cells, Real end, const std::string& left, const std::string& right) {
  const Real h = 1.0 / cells;
  const std::string depth = dim == 3 ? fmt::format(", {}", 2 * h) : "", zero = dim == 3 ? ", 0" : "";
  const auto body = [&](const char* name, Real from, Real to, const std::string& material) {
    return fmt::format(
        "[[body]]\nname = \"{}\"\nregion = {{ type = \"box\", lower = [{}, 0{}], upper = [{}, {}{}] }}\nlayout = {{ type = \"per_cell\", "
        "count "
        "= {} }}\nmaterial = {}\n",
        name, from, zero, to, 2 * h, depth, dim == 2 ? 4 : 8, material);
  };
  std::string text = fmt::format("dim = {}\n[grid]\nupper = [1, {}{}]\ncells = [{}, 2{}]\n[time]\nend = {}\n", dim, 2 * h, depth, cells,
                                 dim == 3 ? ", 2" : "", end) +
                     body("left", 0, 0.5, left) + body("right", 0.5, 1, right) + slip_sides({"left", "right", "bottom", "top"});
  if (dim == 3) text += slip_sides({"front", "back"});
  return default_case("tube", text);
}

/// What the tube has at its end, particle by particle, by place.
struct Profile {
  std::vector<Real> x, density, pressure, velocity;

  Profile(const Simulation& sim, const std::vector<Real>& densities) {
    for (std::size_t b = 0; b < sim.solver().body_count(); ++b) {
      const std::vector<Real> place = component(sim, b, "position", 0), J = component(sim, b, "J", 0);
      const std::vector<Real> p = component(sim, b, "pressure", 0), v = component(sim, b, "velocity", 0);
      for (std::size_t k = 0; k < place.size(); ++k) {
        x.push_back(place[k]);
        density.push_back(densities[b] / J[k]);
        pressure.push_back(p[k]);
        velocity.push_back(v[k]);
      }
    }
  }
  Real mean(const std::vector<Real>& values, Real from, Real to) const {
    Real sum = 0, count = 0;
    for (std::size_t k = 0; k < x.size(); ++k) {
      if (x[k] < from || x[k] > to) continue;
      sum += values[k];
      count += 1;
    }
    return sum / count;
  }
  /// The last place at which the mean over a cell is above the level.
  Real front(const std::vector<Real>& values, Real level, Real from, Real to, Real cell) const {
    Real place = from;
    for (Real at = from; at < to; at += 0.05 * cell) {
      if (mean(values, at - 0.5 * cell, at + 0.5 * cell) > level) place = at;
    }
    return place;
  }
};

/// Of the mean density of cells, against Sod's solution.
Real density_error(const Profile& found, int cells, Real t) {
  constexpr Real g = 1.4, u = 0.92745262, left = 0.42631943, right = 0.26557371, shock = 1.75215573, tail = -0.07027281;
  const Real c = std::sqrt(g);
  Real sum = 0, count = 0;
  for (int i = 0; i < cells; ++i) {
    const Real place = (i + 0.5) / cells, xi = (place - 0.5) / t;
    const Real fan = std::pow(2 / (g + 1) * (c - (g - 1) / 2 * xi) / c, 2 / (g - 1));
    const Real exact = xi < -c ? 1 : xi < tail ? fan : xi < u ? left : xi < shock ? right : 0.125;
    const Real mean = found.mean(found.density, place - 0.5 / cells, place + 0.5 / cells);
    if (!std::isfinite(mean)) continue;  // in the expansion not every cell has a particle
    sum += std::abs(mean - exact);
    ++count;
  }
  return sum / count;
}

Measured sod(int dim, int cells, const std::string& prefix) {
  Simulation sim(tube(dim, cells, 0.2, "{ type = \"ideal_gas\", density = 1, pressure = 1 }",
                      "{ type = \"ideal_gas\", density = 0.125, pressure = 0.1 }"));
  sim.run();
  const Profile found(sim, {1, 0.125});
  return {{prefix + "density_L1", density_error(found, cells, 0.2)},
          {prefix + "pressure", found.mean(found.pressure, 0.71, 0.82)},
          {prefix + "velocity", found.mean(found.velocity, 0.71, 0.82)},
          {prefix + "density_left", found.mean(found.density, 0.53, 0.66)},
          {prefix + "density_right", found.mean(found.density, 0.71, 0.82)},
          {prefix + "shock", found.front(found.pressure, 0.5 * (0.30313 + 0.1), 0.8, 0.9, 1.0 / cells)},
          {prefix + "loss", std::abs(transfer_loss(sim)) / kinetic_energy(sim)}};
}

Measured water_tube() {
  const std::string water = "{{ type = \"stiffened_gas\", density = 1000, gamma = 4.4, stiff_pressure = 6e8, pressure = {} }}";
  constexpr Real t = 1.2e-4;
  Simulation sim(tube(2, 200, t, fmt::format(fmt::runtime(water), "1e9"), fmt::format(fmt::runtime(water), "1e5")));
  sim.run();
  const Profile found(sim, {1000, 1000});
  return {{"water_pressure", found.mean(found.pressure, 0.57, 0.7)},
          {"water_velocity", found.mean(found.velocity, 0.57, 0.7)},
          {"water_shock", found.front(found.pressure, 2.28e8, 0.65, 0.85, 1.0 / 200)}};
}

/// A body of 1 m that runs against a wall.
Profile against_wall(const std::string& material, Real density, Real speed, int cells, Real end) {
  Simulation sim(default_case(
      "wall",
      fmt::format("[grid]\nupper = [1.1, {0}]\ncells = [{1}, 2]\n[time]\nend = {2}\n[[body]]\nname = \"gas\"\nregion = {{ type = "
                  "\"box\", lower = [0, 0], upper = [1, {0}] }}\nlayout = {{ type = \"per_cell\", count = 4 }}\nvelocity = {{ type = "
                  "\"uniform\", value = [{3}, 0] }}\nmaterial = {4}\n",
                  2.0 / cells, cells + cells / 10, end, -speed, material) +
          slip_sides({"left", "bottom", "top"})));
  sim.run();
  return Profile(sim, {density});
}

Measured noh() {
  const Profile gas = against_wall("{ type = \"ideal_gas\", density = 1, pressure = 1e-6, gamma = 1.6666666666666667 }", 1, 1, 200, 0.6);
  return {{"noh_density", gas.mean(gas.density, 0.25 * 0.2, 0.85 * 0.2)}, {"noh_shock", gas.front(gas.density, 2.5, 0.1, 0.3, 1.0 / 200)}};
}

Measured plate_impact() {
  const Real t = 8e-5;
  const Profile copper = against_wall("\"copper_shock\"", 8930, 1000, 200, t);
  // The shock runs at Us - up in space.
  return {{"impact_pressure", copper.mean(copper.pressure, 0.08, 0.28)},
          {"impact_speed", copper.front(copper.pressure, 2.4e10, 0.2, 0.5, 1.0 / 200) / t + 1000}};
}

void add_gases(VerifySuite& suite) {
  const std::string source = "Riemann's solution (Sod 1978)";
  add_problem(suite,
              {"sod",
               "Sod's tube, 200 cells; and in 3D",
               "materials",
               true,
               true,
               4e6,
               {},
               [] {
                 Measured measured = sod(2, 200, "");
                 for (const auto& [name, value] : sod(3, 100, "solid_")) measured[name] = value;
                 return measured;
               }},
              {at_most("density_L1", 0.009, source), within("pressure", 0.30313018, 0.015 * 0.30313018, source),
               within("velocity", 0.92745262, 0.015 * 0.92745262, source), within("density_left", 0.42631943, 0.015 * 0.42631943, source),
               within("density_right", 0.26557371, 0.015 * 0.26557371, "the same; an isentropic gas has 0.2742"),
               within("shock", 0.85043115, 0.5 / 200, "the same, within half a cell"), at_most("loss", 0.05, "of the kinetic energy"),
               at_most("solid_density_L1", 0.014, "the same, 100 cells"), within("solid_shock", 0.85043115, 0.5 / 100, "the same")});
  add_problem(suite, {"water_tube", "1e9 against 1e5 Pa in water", "materials", true, true, 2e6, {}, water_tube},
              {within("water_pressure", 4.5576018e8, 0.015 * 4.5576018e8, "Riemann's solution of the stiffened gas"),
               within("water_velocity", 231.60347, 0.015 * 231.60347, "the same"),
               within("water_shock", 0.5 + 1967.4152 * 1.2e-4, 1.0 / 200, "the same, within a cell")});
  add_problem(suite, {"noh", "Noh's gas against a wall", "materials", true, true, 2e6, {}, noh},
              {within("noh_density", 4, 0.04, "Noh (1987): between 0.25 and 0.85 of the shock's way"),
               within("noh_shock", 0.2, 1.5 / 200, "the same; the shock is two cells wide")});
  add_problem(
      suite, {"plate_impact", "copper against copper, 1000 m/s each", "materials", true, true, 2e6, {}, plate_impact},
      {within("impact_pressure", 4.848097e10, 0.015 * 4.848097e10, "rho0 Us up"), within("impact_speed", 5429, 0.015 * 5429, "c0 + s up")});
}

// --- Ground at rest: a column of three layers, K0 = 0.5 ----------------------------------------------------------------------------

/// The greatest change of a stress and the greatest kinetic energy over 10 s, relative to rho g H and rho g H^2 L.
Measured layers(int dim, Real end, const std::string& solver, const std::string& prefix) {
  const bool is_solid = dim == 3;
  const auto point = [&](Real x, Real y) {
    return is_solid ? fmt::format("[{}, {}, {}]", x, y, x > 0 ? 0.4 : 0) : fmt::format("[{}, {}]", x, y);
  };
  std::string text =
      fmt::format("dim = {}\ngravity = {}\n[grid]\nupper = {}\ncells = {}\n[time]\nend = {}\n{}", dim,
                  is_solid ? "[0, -9.81, 0]" : "[0, -9.81]", point(2, 4), is_solid ? "[10, 20, 2]" : "[10, 20]", end, solver);
  const char* const materials[] = {
      "{ type = \"mohr_coulomb\", density = 2200, youngs_modulus = 5e7, poissons_ratio = 0.3, cohesion = 5e3, friction_angle = 35 }",
      "{ type = \"cam_clay\", density = 1700, shear_modulus = 3e6, critical_slope = 1, lambda_star = 0.1, kappa_star = 0.02, "
      "preconsolidation = 1e5, pressure_offset = 1e3 }",
      "{ type = \"neo_hookean\", density = 1900, youngs_modulus = 2e7, poissons_ratio = 0.3 }"};
  for (int k = 0; k < 3; ++k) {
    text += fmt::format(
        "[[body]]\nname = \"layer_{}\"\nregion = {{ type = \"box\", lower = {}, upper = {} }}\nlayout = {{ type = \"per_cell\", count = {} "
        "}}\ninitial_stress = {{ type = \"geostatic\", K0 = 0.5{} }}\nmaterial = {}\n",
        k, point(0, k), point(2, k + 1), is_solid ? 8 : 4, k == 1 ? ", overconsolidation = 2" : "", materials[k]);
  }
  text += slip_sides({"left", "right"}) + "[[boundary]]\nside = \"bottom\"\nkind = \"fixed\"\n";
  if (is_solid) text += slip_sides({"front", "back"});
  Simulation sim(default_case("layers", text));
  constexpr Real densities[] = {2200, 1700, 1900};
  constexpr Real weight = (densities[0] + densities[1] + densities[2]) * 9.81;
  std::vector<std::vector<Real>> start;
  Real corrected = 0;
  for (std::size_t b = 0; b < 3; ++b) {
    start.push_back(sim.solver().field(b, "stress").values);
    const std::vector<Real> height = component(sim, b, "position", 1);
    for (std::size_t p = 0; p < height.size(); ++p) {
      Real above = 0;
      for (std::size_t layer = b; layer < 3; ++layer)
        above += densities[layer] * 9.81 * (static_cast<Real>(layer) + 1 - std::max(height[p], static_cast<Real>(layer)));
      corrected = std::max(corrected, std::abs(start[b][6 * p + 1] + above));
    }
  }
  Real moved = 0, kinetic = 0;
  Index steps = 0;
  while (sim.time() < (1 - 1e-9) * end) {
    sim.step();
    kinetic = std::max(kinetic, kinetic_energy(sim));
    if (++steps % 500 != 0 && sim.time() < (1 - 1e-9) * end) continue;
    for (std::size_t b = 0; b < 3; ++b) {
      const std::vector<Real> now = sim.solver().field(b, "stress").values;
      for (std::size_t k = 0; k < now.size(); ++k) moved = std::max(moved, std::abs(now[k] - start[b][k]));
    }
  }
  return {{prefix + "stress", moved / weight},
          {prefix + "start", corrected / weight},
          {prefix + "kinetic_energy", kinetic / (weight * 3 * 2 * (is_solid ? 0.4 : 1))}};
}

void add_ground(VerifySuite& suite) {
  const std::string implicit_run = "dt = 0.1\n[solver]\ntype = \"implicit\"\n";
  add_problem(suite,
              {"layers",
               "a column of three layers at rest, K0 = 0.5",
               "materials",
               true,
               true,
               5e7,
               {},
               [=] {
                 Measured measured = layers(2, 10, "", "");
                 for (const auto& [name, value] : layers(3, 1, "", "solid_")) measured[name] = value;
                 for (const auto& [name, value] : layers(2, 10, implicit_run, "implicit_")) measured[name] = value;
                 for (const auto& [name, value] : layers(3, 0.5, implicit_run, "implicit_solid_")) measured[name] = value;
                 return measured;
               }},
              {at_most("stress", 1e-3, "equilibrium"), at_most("kinetic_energy", 1e-8, "the same"),
               at_most("solid_stress", 1e-3, "the same"), at_most("solid_kinetic_energy", 1e-8, "the same"),
               at_most("implicit_stress", 1e-3, "the same"), at_most("implicit_kinetic_energy", 1e-8, "the same"),
               at_most("implicit_start", 0.02, "the weight above, but for the balance of rows at wall and surface"),
               at_most("implicit_solid_stress", 1e-3, "equilibrium"), at_most("implicit_solid_kinetic_energy", 1e-8, "the same")});
}

// --- A bar that breaks takes its fracture energy, whatever the cells ----------------------------------------------------------------

/// A bar of 0.4 x 0.02 m, weaker in one row of cells, is pulled at its end until it has broken there: what it took, over Gf times its
/// height.
Real broken(int cells_to_height) {
  const Real h = 0.02 / cells_to_height;
  std::string text = fmt::format(R"(
[grid]
upper = [0.48, 0.02]
cells = [{0}, {1}]
[time]
end = 0.06
[solver]
shape = "linear"
[[boundary]]
side = "left"
kind = "slip"
[[boundary]]
name = "grip"
region = {{ type = "box", lower = [{2}, -1], upper = [0.41, 1] }}
kind = "velocity"
velocity = [0.01, 0]
components = ["x"]
)",
                                 static_cast<int>(std::lround(0.48 / h)), cells_to_height, 0.4 - 0.5 * h);
  const auto part = [&](const char* name, Real from, Real to, Real strength) {
    text += fmt::format(R"(
[[body]]
name = "{}"
region = {{ type = "box", lower = [{}, 0], upper = [{}, 0.02] }}
layout = {{ type = "per_cell", count = 1 }}
velocity = {{ type = "linear", gradient = [[0.025, 0], [0, 0]] }}
material = {{ type = "rankine_damage", density = 2400, youngs_modulus = 1e9, poissons_ratio = 0, tensile_strength = {}, fracture_energy = 4 }}
)",
                        name, from, to, strength);
  };
  part("left", 0, 0.2, 1e5);
  part("weak", 0.2, 0.2 + h, 0.8e5);
  part("right", 0.2 + h, 0.4, 1e5);
  Simulation sim(default_case("bar", text));
  sim.run();
  return sim.solver().ledger().plastic_dissipation / (4 * 0.02);
}

void add_breaking(VerifySuite& suite) {
  add_problem(suite,
              {"breaking_bar",
               "a bar pulled until it breaks, two sizes of cells",
               "materials",
               true,
               true,
               1e6,
               {},
               [] {
                 return Measured{{"energy", broken(1)}, {"fine_energy", broken(4)}};
               }},
              {within("energy", 1, 0.05, "the fracture energy Gf per area"),
               within("fine_energy", 1, 0.05, "the same with cells of a quarter of the size")});
}

}  // namespace

void add_states(VerifySuite& suite) {
  add_gases(suite);
  add_ground(suite);
  add_breaking(suite);
}

}  // namespace matpoint
