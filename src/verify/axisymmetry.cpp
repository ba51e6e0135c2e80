// Bodies of rings around an axis: periods of a cylinder, a sphere and a rod, a quarter of the same body in 3D, a bar of copper that hits a
// wall, and a thick cylinder that is widened.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "verify/materials.hpp"

namespace matpoint {
namespace {

constexpr Real pi = std::numbers::pi;
// nu = 1/4, where c_p^2 = 3 c_s^2.
constexpr Real E = 1e7, nu = 0.25, rho = 1000;
const Real c_p = std::sqrt(1.2 * E / rho);
const char* const k_rubber = "{ type = \"neo_hookean\", density = 1000, youngs_modulus = 1e7, poissons_ratio = 0.25 }";

template <class F>
Real root(F&& f, Real low, Real high) {
  for (int k = 0; k < 100; ++k) {
    const Real middle = 0.5 * (low + high);
    (f(middle) > 0) == (f(low) > 0) ? low = middle : high = middle;
  }
  return low;
}

/// The period of the momentum along an axis of a body.
Real period_of(Simulation& sim, std::size_t axis) {
  ZeroCrossings crossings;
  sim.add_callback([&](const Simulation& now) {
    crossings.include(now.time(), now.solver().totals(0).momentum[axis]);
    return true;
  });
  sim.run();
  return crossings.period();
}

/// Radius 0.8; widens at first.
Measured breathing(int cells) {
  const std::string head = "gravity = [0, 0]\n[grid]\naxisymmetric = true\n";
  const std::string body = fmt::format("layout = {{ type = \"per_cell\", count = 4 }}\nmaterial = {}\n", k_rubber);
  Simulation cylinder(
      default_case("cylinder", head + fmt::format("upper = [1, 0.2]\ncells = [{}, {}]\n[time]\nend = 0.14\n", cells, cells / 5) +
                                   "[[body]]\nname = \"b\"\nregion = { type = \"box\", lower = [0, 0], upper = [0.8, 0.2] }\n"
                                   "velocity = { type = \"linear\", gradient = [[0.1, 0], [0, 0]] }\n" +
                                   body + slip_sides({"bottom", "top"})));
  Simulation sphere(default_case(
      "sphere", head + fmt::format("lower = [0, -1]\nupper = [1, 1]\ncells = [{}, {}]\n[time]\nend = 0.1\n", cells, 2 * cells) +
                    "[[body]]\nname = \"b\"\nregion = { type = \"disk\", center = [0, 0], radius = 0.8 }\n"
                    "velocity = { type = \"linear\", gradient = [[0.1, 0], [0, 0.1]] }\n" +
                    body));
  // Of surfaces without stress.
  const Real of_cylinder = root([](Real x) { return x * std::cyl_bessel_j(0, x) - 2.0 / 3 * std::cyl_bessel_j(1, x); }, 1.0, 2.3);
  const Real of_sphere = root([](Real x) { return std::tan(x) * (1 - 0.75 * x * x) - x; }, 2.0, 3.0);
  const Real once = 2 * pi * 0.8 / c_p;
  return {{"cylinder_period", period_of(cylinder, 0) / (once / of_cylinder)}, {"sphere_period", period_of(sphere, 0) / (once / of_sphere)}};
}

/// A slender rod whose lower end is stopped: a wave goes up and down.
Measured rod() {
  Simulation sim(default_case("rod", fmt::format(R"(
gravity = [0, 0]
[grid]
axisymmetric = true
upper = [0.1, 1.2]
cell_size = 0.0125
[time]
end = 0.2
[[body]]
name = "rod"
region = {{ type = "box", lower = [0, 0], upper = [0.05, 1] }}
layout = {{ type = "per_cell", count = 4 }}
velocity = {{ type = "uniform", value = [0, -0.1] }}
material = {}
)",
                                                 k_rubber) +
                                         slip_sides({"bottom"})));
  return {{"rod_period", period_of(sim, 1) / (4 / std::sqrt(E / rho))}};
}

/// A soft cylinder that sinks under its weight, in rings and as a quarter in 3D.
Measured quarter() {
  const auto run = [](bool is_3d) {
    Simulation sim(default_case(
        "column",
        (is_3d ? "dim = 3\ngravity = [0, -9.81, 0]\n[grid]\nupper = [0.8, 1, 0.8]\n"
               : "gravity = [0, -9.81]\n[grid]\naxisymmetric = true\nupper = [0.8, 1]\n") +
            std::string("cell_size = 0.05\n[time]\nend = 0.2\n[[body]]\nname = \"b\"\n") +
            (is_3d ? "region = { type = \"difference\", of = [{ type = \"cylinder\", start = [0, 0, 0], end = [0, 0.8, 0], radius = 0.4 }, "
                     "{ type = \"half_space\", point = [0, 0, 0], normal = [1, 0, 0] }, { type = \"half_space\", point = [0, 0, 0], normal "
                     "= [0, 0, 1] }] }\nlayout = { type = "
                     "\"per_cell\", count = 8 }\n"
                   : "region = { type = \"box\", lower = [0, 0], upper = [0.4, 0.8] }\nlayout = { type = \"per_cell\", count = 4 }\n") +
            "material = { type = \"neo_hookean\", density = 1000, youngs_modulus = 3e4, poissons_ratio = 0.3 }\n" +
            (is_3d ? slip_sides({"bottom", "left", "front"}) : slip_sides({"bottom"}))));
    sim.run();
    const BodyTotals totals = sim.solver().totals(0);
    std::vector<Real> radii = component(sim, 0, "position", 0);
    if (is_3d) {
      const std::vector<Real> z = component(sim, 0, "position", 2);
      for (std::size_t p = 0; p < radii.size(); ++p) radii[p] = std::hypot(radii[p], z[p]);
    }
    Real mean = 0;
    for (const Real r : radii) mean += r / static_cast<Real>(radii.size());
    if (!is_3d) {  // by mass, as particles of a lattice count it
      const std::vector<Real> mass = component(sim, 0, "mass", 0);
      mean = 0;
      for (std::size_t p = 0; p < radii.size(); ++p) mean += mass[p] * radii[p] / totals.mass;
    }
    return std::array<Real, 4>{totals.center_of_mass[1], mean, totals.mass * (is_3d ? 4 : 1), totals.strain_energy * (is_3d ? 4 : 1)};
  };
  const std::array<Real, 4> rings = run(false), solid = run(true);
  return {{"quarter_centre", rings[0] / solid[0]},
          {"quarter_radius", rings[1] / solid[1]},
          {"quarter_mass", rings[2] / solid[2]},
          {"quarter_strain_energy", rings[3] / solid[3]}};
}

/// The round bar of copper of taylor_bar_3d.
Measured copper(int cells_to_radius) {
  constexpr Real R = 3.2e-3, L = 32.4e-3;
  const Real h = R / cells_to_radius;
  Simulation sim(default_case("taylor", fmt::format(R"(
[grid]
axisymmetric = true
upper = [{}, {}]
cells = [{}, {}]
[time]
end = 80e-6
[[body]]
name = "bar"
region = {{ type = "box", lower = [0, 0], upper = [{}, {}] }}
layout = {{ type = "per_cell", count = 4 }}
velocity = {{ type = "uniform", value = [0, -227] }}
material = {{ type = "j2", density = 8930, youngs_modulus = 117e9, poissons_ratio = 0.35, yield_stress = 400e6, hardening_modulus = 100e6 }}
)",
                                                    3 * R, 11 * R, 3 * cells_to_radius, 11 * cells_to_radius, R, L) +
                                            slip_sides({"bottom"})));
  sim.run();
  const std::vector<Real> r = component(sim, 0, "position", 0), y = component(sim, 0, "position", 1);
  std::vector<Real> low;
  for (std::size_t p = 0; p < r.size(); ++p) {
    if (y[p] < h) low.push_back(r[p]);
  }
  std::sort(low.begin(), low.end());
  return {{"bar_length", 1e3 * (greatest(sim, 1) + h / 4)},
          {"bar_radius", 1e3 * (greatest(sim, 0) + h / 4)},
          {"bar_radius_of_most", 1e3 * low[static_cast<std::size_t>(0.99 * static_cast<Real>(low.size()))]},
          {"bar_energy", (sim.solver().ledger().plastic_dissipation + sim.solver().totals(0).kinetic_energy) / sim.initial_energy()}};
}

/// Hill's cylinder (thick_cylinder.cpp), widened in 2 ms, a hundred times as long as a wave takes across it: the mean pressure while the
/// inner radius goes from 0.02 mm before a place to as much beyond it, over that of the outer displacement.
Measured widened() {
  constexpr Real a = 0.1, b = 0.2, modulus = 210e9, poisson = 0.3, strength = 0.24e9, h = 0.005, end = 2e-3, way = 0.5e-3;
  constexpr Real speed = way / (end * 39 / 40);
  Simulation sim(default_case("cylinder", fmt::format(R"(
gravity = [0, 0]
[grid]
axisymmetric = true
lower = [{0}, 0]
upper = [0.22, {1}]
cells = [24, 2]
[time]
end = {2}
[[body]]
name = "cylinder"
region = {{ type = "box", lower = [{0}, 0], upper = [{3}, {1}] }}
layout = {{ type = "per_cell", count = 4 }}
material = {{ type = "j2", density = 7800, youngs_modulus = {4}, poissons_ratio = {5}, yield_stress = {6} }}
[[boundary]]
name = "inside"
side = "left"
kind = "velocity"
components = ["x"]
times = [0, {7}]
velocities = [[0, 0], [{8}, 0]]
)",
                                                      a, 2 * h, end, b, modulus, poisson, strength, end / 20, speed) +
                                              slip_sides({"bottom", "top"})));
  const std::vector<Real> start = component(sim, 0, "position", 0);
  const std::size_t outermost = static_cast<std::size_t>(std::max_element(start.begin(), start.end()) - start.begin());
  const Real k = strength / std::sqrt(3.0);
  Real sums[2] = {0, 0}, closed[2] = {0, 0};
  sim.add_callback([&](const Simulation& now) {
    const Real t = now.time();
    const Real moved = t < end / 20 ? 0.5 * speed * t * t / (end / 20) : speed * (t - end / 40);
    const Real force = now.solver().boundaries()[0].force[0];
    for (int which : {0, 1}) {
      const Real place = which == 0 ? 0.2e-3 : 0.48e-3;
      if (std::abs(moved - place) > 0.02e-3) continue;
      const Real u = now.solver().field(0, "position").values[2 * outermost] - start[outermost];
      const Real c = std::min(b, std::sqrt(u * modulus * b / ((1 - poisson * poisson) * 2 * k)));
      sums[which] += force / (2 * pi * (a + moved) * 2 * h);
      closed[which] += k * (1 - c * c / (b * b) + 2 * std::log(c / a));
    }
    return true;
  });
  sim.run();
  return {{"pressure_explicit_02", sums[0] / closed[0]}, {"pressure_explicit_05", sums[1] / closed[1]}};
}

}  // namespace

void add_axisymmetry(VerifySuite& suite) {
  const auto add = [&](const char* title, bool is_quick, Real cost, std::function<Measured()> run, std::vector<VerifyRow> rows) {
    add_problem(suite, {"axisymmetry", title, "axisymmetry", is_quick, true, cost, {}, std::move(run)}, std::move(rows));
  };
  add("a cylinder and a sphere that breathe", true, 1e6, [] { return breathing(20); },
      {within("cylinder_period", 1, 0.01, "root of x J0(x) = 2/3 J1(x)"), within("sphere_period", 1, 0.01, "Lamb 1882")});
  add("a wave in a rod", true, 3e6, &rod, {within("rod_period", 1, 0.01, "4 L / sqrt(E / rho)")});
  add("a sinking cylinder, beside a quarter of it in 3D", true, 2e6, &quarter,
      {within("quarter_centre", 1, 0.02, "a quarter in 3D"), within("quarter_radius", 1, 0.02, "the same"),
       within("quarter_mass", 1, 0.02, "the same"), within("quarter_strain_energy", 1, 0.02, "the same")});
  add("a round bar of copper hits a wall", true, 1e7, [] { return copper(16); },
      {within("bar_length", 21.5, 0.15, "published 21.42 to 21.43"), at_most("bar_radius", 7.6, "published 7.11 to 7.22"),
       at_least("bar_radius_of_most", 6.95, "the same"), within("bar_energy", 1, 0.02, "kept")});
  add("a thick cylinder of metal is widened", true, 3e6, &widened,
      {within("pressure_explicit_02", 1, 0.015, "Hill 1950, at the same outer displacement, 0.2 mm"),
       within("pressure_explicit_05", 1, 0.015, "the same, 0.48 mm")});
}

}  // namespace matpoint
