// Laws that flow, in problems with published, closed or independently computed answers. Sources and what was found: docs/verification.md.
#include <algorithm>
#include <cmath>

#include "case/case_file.hpp"
#include "verify/materials.hpp"

namespace matpoint {
namespace {

Real plastic_work(const Simulation& sim) { return sim.solver().ledger().plastic_dissipation; }

// --- Taylor's bar: R 3.2 mm, L 32.4 mm, 227 m/s, copper with linear hardening, a wall without friction, 80 us ---------------------

const char* const k_copper = R"(
[[body]]
name = "bar"
velocity = {{ type = "uniform", value = {} }}
layout = {{ type = "per_cell", count = {} }}
region = {{ type = "box", lower = {}, upper = {} }}
material = {{ type = "j2", density = 8930, youngs_modulus = 117e9, poissons_ratio = 0.35, yield_stress = 400e6, hardening_modulus = 100e6 }}
[[boundary]]
side = "bottom"
kind = "slip"
[[boundary]]
side = "left"
kind = "slip"
)";

Measured taylor_slab() {
  constexpr Real h = 3.2e-3 / 6;
  Simulation sim(default_case("taylor", "[grid]\nupper = [0.0192, 0.0352]\ncells = [36, 66]\n[time]\nend = 80e-6\n" +
                                            fmt::format(fmt::runtime(k_copper), "[0, -227]", 4, "[0, 0]", "[0.0032, 0.0324]")));
  sim.run();
  return {{"slab_length", 1e3 * (greatest(sim, 1) + h / 4)},
          {"slab_half_width", 1e3 * (greatest(sim, 0) + h / 4)},
          {"slab_plastic_work", plastic_work(sim) / sim.initial_energy()},
          {"slab_loss", std::abs(transfer_loss(sim)) / sim.initial_energy()}};
}

/// The particles of a quarter of a round bar along y: two to an edge of a cell, those within the circle.
std::vector<Vec3> quarter_of_bar(Real R, Real L, Real h) {
  std::vector<Vec3> points;
  const int across = static_cast<int>(std::lround(2 * R / h)), along = static_cast<int>(std::lround(2 * L / h));
  for (int k = 0; k < along; ++k) {
    for (int j = 0; j < across; ++j) {
      for (int i = 0; i < across; ++i) {
        const Vec3 x{(i + 0.5) * h / 2, (k + 0.5) * h / 2, (j + 0.5) * h / 2};
        if (std::hypot(x[0], x[2]) < R && x[1] < L) points.push_back(x);
      }
    }
  }
  return points;
}
/// Distances of the particles from the bar's axis.
std::vector<Real> radii_of(const Simulation& sim) {
  std::vector<Real> radii = component(sim, 0, "position", 0);
  const std::vector<Real> z = component(sim, 0, "position", 2);
  for (std::size_t p = 0; p < radii.size(); ++p) radii[p] = std::hypot(radii[p], z[p]);
  return radii;
}

/// A quarter of the round bar, in 3D.
Measured taylor_bar(int cells_to_radius) {
  constexpr Real R = 3.2e-3, L = 32.4e-3;
  const Real h = R / cells_to_radius;
  Case problem = default_case(
      "taylor", fmt::format("dim = 3\n[grid]\nupper = [{0}, {1}, {0}]\ncells = [{2}, {3}, {2}]\n[time]\nend = 80e-6\n[solver]\nshape = "
                            "\"bspline2\"\n",
                            4 * R, 11 * R, 4 * cells_to_radius, 11 * cells_to_radius) +
                    fmt::format(fmt::runtime(k_copper), "[0, -227, 0]", 8, "[0, 0, 0]", fmt::format("[{}, {}, {}]", R, L, R)) +
                    "[[boundary]]\nside = \"front\"\nkind = \"slip\"\n");
  const std::vector<Vec3> points = quarter_of_bar(R, L, h);
  problem.bodies[0].layout = points_layout(points, std::vector<Real>(points.size(), h * h * h / 8));
  Simulation sim(std::move(problem));
  sim.run();
  const std::vector<Real> y = component(sim, 0, "position", 1), radii = radii_of(sim);
  std::vector<Real> low;
  for (std::size_t p = 0; p < y.size(); ++p) {
    if (y[p] < h) low.push_back(radii[p]);
  }
  std::sort(low.begin(), low.end());
  return {{"bar_length", 1e3 * (greatest(sim, 1) + h / 4)},
          {"bar_radius", 1e3 * (*std::max_element(radii.begin(), radii.end()) + h / 4)},
          {"bar_radius_of_most", 1e3 * low[static_cast<std::size_t>(0.99 * static_cast<Real>(low.size()))]},
          {"bar_energy", (plastic_work(sim) + kinetic_energy(sim)) / sim.initial_energy()},
          {"bar_loss", std::abs(transfer_loss(sim)) / sim.initial_energy()}};
}

/// Bars of OFHC copper, Johnson and Cook's law, 6 cells to the radius: length and radius at the end, over those at the start.
Measured taylor_ofhc(const std::string& name, Real L, Real R, Real speed, Real end) {
  constexpr int k_cells = 6;
  const Real h = R / k_cells;
  const int along = static_cast<int>(std::ceil(L / h)) + 2;
  Case problem = default_case("taylor", fmt::format(R"(
dim = 3
[grid]
upper = [{0}, {1}, {0}]
cells = [{2}, {3}, {2}]
[time]
end = {4}
[solver]
shape = "bspline2"
[[body]]
name = "bar"
velocity = {{ type = "uniform", value = [0, {5}, 0] }}
layout = {{ type = "per_cell", count = 8 }}
region = {{ type = "box", lower = [0, 0, 0], upper = [{6}, {7}, {6}] }}
material = "copper_ofhc"
[[boundary]]
side = "bottom"
kind = "slip"
[[boundary]]
side = "left"
kind = "slip"
[[boundary]]
side = "front"
kind = "slip"
)",
                                                    4 * R, along * h, 4 * k_cells, along, end, -speed, R, L));
  const std::vector<Vec3> points = quarter_of_bar(R, L, h);
  problem.bodies[0].layout = points_layout(points, std::vector<Real>(points.size(), h * h * h / 8));
  Simulation sim(std::move(problem));
  sim.run();
  const std::vector<Real> radii = radii_of(sim), heat = component(sim, 0, "temperature", 0);
  return {{name + "_length", (greatest(sim, 1) + h / 4) / L},
          {name + "_radius", (*std::max_element(radii.begin(), radii.end()) + h / 4) / R},
          {name + "_temperature", *std::max_element(heat.begin(), heat.end())},
          {name + "_rest", kinetic_energy(sim) / sim.initial_energy()},
          {name + "_loss", std::abs(transfer_loss(sim)) / sim.initial_energy()}};
}

void add_taylor(VerifySuite& suite) {
  add_problem(suite,
              {"taylor_ofhc",
               "three bars of OFHC copper, Johnson and Cook's law",
               "materials",
               true,
               true,
               4e7,
               {},
               [] {
                 Measured measured = taylor_ofhc("bar_210", 23.47e-3, 3.81e-3, 210, 60e-6);
                 for (const auto& [name, value] : taylor_ofhc("bar_162", 34.5e-3, 3.9e-3, 162, 80e-6)) measured[name] = value;
                 for (const auto& [name, value] : taylor_ofhc("bar_225", 34.5e-3, 3.9e-3, 225, 90e-6)) measured[name] = value;
                 return measured;
               }},
              {within("bar_210_length", 0.643, 0.02 * 0.643, "finite elements: 0.6424 to 0.6431; experiment 0.630 (Wilkins & Guinan 1973)"),
               within("bar_210_radius", 2.08, 0.04 * 2.08, "finite elements: 2.074 to 2.087; experiment 2.204"),
               within("bar_210_temperature", 597, 20, "finite elements, the hottest"), at_most("bar_210_rest", 0.01, "it is at rest"),
               at_most("bar_210_loss", 0.02, "energy closes"),
               within("bar_162_length", 0.737, 0.02 * 0.737, "finite elements; experiment .763, with harder copper"),
               within("bar_162_radius", 1.700, 0.04 * 1.700, "finite elements; experiment 1.701"),
               within("bar_225_length", 0.595, 0.02 * 0.595, "finite elements; experiment .645, with harder copper"),
               within("bar_225_radius", 2.270, 0.04 * 2.270, "finite elements; experiment 2.056")});
  add_problem(suite, {"taylor_bar", "slab of copper", "materials", true, true, 3e6, {}, taylor_slab},
              {within("slab_length", 21.6, 0.35, "finite elements Q1P0: 21.68 to 21.86 mm"),
               within("slab_half_width", 13.0, 0.7, "finite elements Q1P0: 12.62 to 12.81 mm; not converged in either method"),
               at_least("slab_plastic_work", 0.97, "finite elements Q1P0: 0.984"), at_most("slab_loss", 0.02, "energy closes")});
  add_problem(suite,
              {"taylor_bar_3d", "quarter of a bar of copper, R/h = 8", "materials", true, true, 8e7, {}, [] { return taylor_bar(8); }},
              {within("bar_length", 21.5, 0.15, "published: 21.42 to 21.43 mm; finite elements: 21.54 to 21.56"),
               at_most("bar_radius", 7.6, "published: 7.11 to 7.22 mm; the outermost particle"),
               at_least("bar_radius_of_most", 6.95, "the same; 99 % of the lowest cell"),
               within("bar_energy", 1, 0.02, "plastic work and the kinetic rest"), at_most("bar_loss", 0.02, "energy closes")});
}

// --- Cook's membrane with Voce's hardening, static -----------------------------------------------------------------------------

Real cook(int cells, int order, bool is_fbar) {
  Simulation sim(default_case("cook", fmt::format(R"(
[grid]
upper = [48, 60]
cells = [{0}, {0}]
corners = [[0, 0], [48, 44], [48, 60], [0, 44]]
[time]
end = 1
dt = 0.05
[solver]
type = "implicit"
mode = "static"
basis = "element"
element_order = {1}
[[body]]
name = "plate"
method = "elements"
fbar = {2}
region = {{ type = "box", lower = [-1, -1], upper = [49, 61] }}
material = {{ type = "j2", density = 1e-9, youngs_modulus = 206.9, poissons_ratio = 0.29, yield_stress = 0.45, saturation_stress = 0.715, saturation_rate = 16.93, hardening_modulus = 0.12924 }}
[[boundary]]
side = "left"
kind = "fixed"
[[boundary]]
side = "right"
kind = "traction"
traction = [0, 0.3125]
)",
                                                  cells, order, is_fbar)));
  sim.run();
  const std::vector<Real> x = sim.solver().node_field(0, "position").values, u = sim.solver().node_field(0, "displacement").values;
  std::size_t corner = 0;
  for (std::size_t k = 0; k < x.size(); k += 2) {
    const auto place = [&](std::size_t n) { return x[n] - u[n] + x[n + 1] - u[n + 1]; };
    if (place(k) > place(corner)) corner = k;
  }
  return u[corner + 1];
}

void add_cook(VerifySuite& suite) {
  add_problem(
      suite,
      {"cook_plastic",
       "Cook's membrane that yields, implicit",
       "materials",
       true,
       true,
       2e6,
       {},
       [] {
         return Measured{{"way_32", cook(32, 2, false)}, {"way_16_fbar", cook(16, 2, true)}, {"way_linear_32_fbar", cook(32, 1, true)}};
       }},
      {within("way_32", 6.93, 0.15, "8-node bricks with 32 cells: 6.923; published 6.90 to 6.94 (Simo & Armero 1992)"),
       within("way_16_fbar", 6.93, 0.15, "the same"), within("way_linear_32_fbar", 6.93, 0.15, "the same; without F-bar 5.6")});
}

// --- Waves: a bar in uniaxial strain hits a wall at 1 m/s ---------------------------------------------------------------------

Measured plastic_wave(int cells) {
  constexpr Real E = 1e7, nu = 0.3, rho = 1000;
  constexpr Real K = E / (3 * (1 - 2 * nu)), G = E / (2 * (1 + nu));
  const Real c_e = std::sqrt((K + 4 * G / 3) / rho);
  Simulation sim(default_case("wave", fmt::format(R"(
[grid]
upper = [{0}, {1}]
cells = [{2}, 2]
[time]
end = {3}
[[body]]
name = "bar"
region = {{ type = "box", lower = [0, 0], upper = [1, {1}] }}
layout = {{ type = "per_cell", count = 4 }}
velocity = {{ type = "uniform", value = [-1, 0] }}
material = {{ type = "j2", density = 1000, youngs_modulus = 1e7, poissons_ratio = 0.3, yield_stress = 2e4, hardening_modulus = 1e6 }}
[solver]
shape = "bspline2"
[[boundary]]
side = "left"
kind = "slip"
[[boundary]]
side = "bottom"
kind = "slip"
[[boundary]]
side = "top"
kind = "slip"
)",
                                                  1 + 20.0 / cells, 2.0 / cells, cells + 20, 0.5 / c_e)));
  sim.run();
  const std::vector<Real> x = component(sim, 0, "position", 0), stress = component(sim, 0, "stress", 0);
  const auto mean = [&](Real from, Real to) {
    Real sum = 0, count = 0;
    for (std::size_t p = 0; p < x.size(); ++p) {
      if (x[p] < from || x[p] > to) continue;
      sum -= stress[p];
      count += 1;
    }
    return sum / count;
  };
  // The last place at which the stress, as a mean over eight particles' places, is above half of a step.
  const auto front = [&](Real level) {
    Real place = 0;
    for (Real at = 0.2; at < 0.6; at += 0.0005) {
      if (mean(at - 1.0 / cells, at + 1.0 / cells) > level) place = at;
    }
    return place;
  };
  return {
      {"plateau", mean(0.1, 0.33)}, {"precursor", mean(0.435, 0.475)}, {"plastic_front", front(67648)}, {"elastic_front", front(17500)}};
}

void add_waves(VerifySuite& suite) {
  const std::string source = "rho c_p (v - HEL/(rho c_e)) + HEL with c_p^2 = (K + 4/3 G H/(3G + H))/rho, HEL = sy (K + 4G/3)/(2G)";
  add_problem(suite,
              {"plastic_wave",
               "bar in uniaxial strain against a wall",
               "materials",
               true,
               true,
               5e6,
               {},
               [] {
                 Measured measured = plastic_wave(200);
                 for (const auto& [name, value] : plastic_wave(1600)) measured["fine_" + name] = value;
                 return measured;
               }},
              {within("plateau", 100295, 0.015 * 100295, source), within("plastic_front", 0.3988, 0.012, "c_p t less the wall's push"),
               within("elastic_front", 0.4957, 0.012, "c_e t less it"), reported("precursor", 35000, "HEL"),
               within("fine_plateau", 100295, 0.015 * 100295, source), within("fine_precursor", 35000, 700, "HEL; coarse cells overshoot"),
               within("fine_plastic_front", 0.3988, 0.005, "c_p t"), within("fine_elastic_front", 0.4957, 0.005, "c_e t")});
}

}  // namespace

Case default_case(const std::string& name, const std::string& text) { return Case::from_input(parse_toml(text, name), name); }

Real quantile(const Simulation& sim, std::size_t axis, Real share) {
  std::vector<Real> x = component(sim, 0, "position", axis);
  const auto k = static_cast<std::ptrdiff_t>(share * static_cast<Real>(x.size() - 1));
  std::nth_element(x.begin(), x.begin() + k, x.end());
  return x[static_cast<std::size_t>(k)];
}
std::string slip_sides(std::initializer_list<const char*> sides) {
  std::string text;
  for (const char* side : sides) text += fmt::format("[[boundary]]\nside = \"{}\"\nkind = \"slip\"\n", side);
  return text;
}
Real greatest(const Simulation& sim, std::size_t axis) { return quantile(sim, axis, 1); }

void add_materials(VerifySuite& suite) {
  add_taylor(suite);
  add_cook(suite);
  add_waves(suite);
  add_necking(suite);
  add_yielding_cylinder(suite);
  add_grains(suite);
  add_slopes(suite);
  add_flows(suite);
  add_states(suite);
}

}  // namespace matpoint
