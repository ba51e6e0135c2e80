// Bodies that meet: the thesis' disks, a block on an incline, and Hertz's spheres, with both kinds of contact and both formulations.
#include "verify/contact.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "verify/measure.hpp"

namespace matpoint {
namespace {

/// A way to let bodies meet, and the word for it in the rows.
struct Way {
  std::string name;
  Sets sets;
};

Sets with_formulation(Sets sets, const std::vector<std::string>& bodies, const std::string& formulation) {
  for (const std::string& body : bodies) sets.push_back("body." + body + ".formulation=" + formulation);
  return sets;
}

std::vector<Way> ways(const std::vector<std::string>& bodies, const Sets& common) {
  Sets multi_field = common;
  multi_field.push_back("solver.contact=multi_field");
  Sets pairs = common;
  pairs.push_back("solver.contact=pairs");
  return {{"contact", multi_field}, {"pairs", pairs}, {"pairs_total", with_formulation(pairs, bodies, "total")}};
}

Real whole_energy(const Simulation& sim) { return energy(sim) + sim.solver().ledger().contact_energy; }

/// With a velocity field for each disk: when they begin to slow, and what becomes of the energy.
Measured disks(int divisions, const Way& way) {
  Sets sets = way.sets;
  for (const char* body : {"lower", "upper"}) sets.push_back(fmt::format("body.{0}.layout.divisions=[{1},{1}]", body, divisions));
  Simulation sim(load_case("disks", sets));
  const std::string tail = fmt::format("_{}_{}", way.name, sim.solver().particle_count(0));
  const Real start = kinetic_energy(sim);
  Measured m;
  m["E_max_over_E0" + tail] = 1;
  m["momentum" + tail] = 0;
  every(sim, 10, [&](const Simulation& s) {
    const Real kinetic = kinetic_energy(s);
    if (kinetic < start * (1 - 1e-4) && m.count("t_contact" + tail) == 0) m["t_contact" + tail] = s.time();
    m["E_max_over_E0" + tail] = std::max(m["E_max_over_E0" + tail], whole_energy(s) / start);
    for (const Real p : momentum(s)) m["momentum" + tail] = std::max(m["momentum" + tail], std::abs(p));
  });
  sim.run();
  m["E_end_over_E0" + tail] = whole_energy(sim) / start;
  return m;
}

/// The greatest energy over that of the start. A velocity is that of half a step before the place to which it leads: so the history is off
/// by dt / 2 times the power of the forces. `in_step`: the kinetic energy at a place is the mean of those before and after it.
struct GreatestEnergy {
  Real in_history = 0;
  Real in_step = 0;
};
GreatestEnergy greatest_energy(const std::string& order, Real dt) {
  Simulation sim(
      load_case("disks", {"solver.contact=pairs", "solver.stress_order=" + order, fmt::format("time.dt={}", dt), "time.end=1.8"}));
  const Real start = kinetic_energy(sim);
  GreatestEnergy greatest;
  Real kinetic_before = 0;
  Real stored_before = 0;
  every(sim, 1, [&](const Simulation& s) {
    const Real kinetic = kinetic_energy(s);
    const Real stored = whole_energy(s) - kinetic;
    greatest.in_history = std::max(greatest.in_history, (kinetic + stored) / start);
    if (s.step_count() > 1) greatest.in_step = std::max(greatest.in_step, ((kinetic_before + kinetic) / 2 + stored_before) / start);
    kinetic_before = kinetic;
    stored_before = stored;
  });
  sim.run();
  return greatest;
}

/// Pairs make no energy: with USL at no time, with MUSL none that is not gone with the time step.
Measured energy_of_pairs() {
  const GreatestEnergy coarse = greatest_energy("musl", 2e-4);
  const GreatestEnergy fine = greatest_energy("musl", 1e-4);
  return {{"E_in_step_over_E0_pairs_usl", greatest_energy("usl", 1e-4).in_step},
          {"E_excess_over_that_of_half_dt_pairs", (coarse.in_history - 1) / (fine.in_history - 1)}};
}

/// A block slides down an incline of 30 degrees: its speed over the exact one, after half a second. Gravity grows within .1 s, so that the
/// block does not bounce: it acts as long as from .05 s on.
Measured incline(Real friction, const Way& way) {
  const std::string text = fmt::format(R"(
gravity = [4.905, -8.495709211]
gravity_times = [0, 0.1]
gravity_factors = [0, 1]
[grid]
upper = [2.4, 0.6]
cell_size = 0.05
[time]
end = 0.5
cfl = 0.3
[solver]
friction = {}
[[body]]
name = "base"
region = {{ type = "box", lower = [0, 0], upper = [2.4, 0.2] }}
layout = {{ type = "per_cell", count = 4 }}
material = {{ type = "neo_hookean", density = 1000, youngs_modulus = 1e6, poissons_ratio = 0.3 }}
[[body]]
name = "block"
region = {{ type = "box", lower = [0.2, 0.2], upper = [0.4, 0.4] }}
layout = {{ type = "per_cell", count = 4 }}
material = {{ type = "neo_hookean", density = 1000, youngs_modulus = 1e5, poissons_ratio = 0.3 }}
[[boundary]]
side = "bottom"
kind = "fixed"
[[boundary]]
side = "left"
kind = "fixed"
[[boundary]]
side = "right"
kind = "fixed"
)",
                                       friction);
  Simulation sim(case_from_text("incline", text, way.sets));
  sim.run();
  const BodyTotals block = sim.solver().totals(1);
  return {{fmt::format("on_a_body_30_mu{}_speed_ratio_{}", friction, way.name),
           block.momentum[0] / block.mass / ((4.905 - friction * 8.495709211) * (sim.time() - 0.05))}};
}

/// Particles of a ball whose outermost ones lie half a spacing under its surface: the cube [-1, 1]^3 with n^3 of them, mapped to the unit
/// ball by x sqrt(1 - y^2 / 2 - z^2 / 2 + y^2 z^2 / 3) and so on (Nowell 2005), with the volumes that the map gives them. A lattice cut by
/// a sphere would begin with a flat facet that is wider than the area in contact.
std::shared_ptr<Layout> ball(const Vec3& center, Real radius, int n) {
  std::vector<Vec3> points;
  std::vector<Real> volumes;
  const auto map = [](Real x, Real y, Real z) { return x * std::sqrt(1 - y * y / 2 - z * z / 2 + y * y * z * z / 3); };
  const auto place = [&](const Vec3& u) { return Vec3{map(u[0], u[1], u[2]), map(u[1], u[2], u[0]), map(u[2], u[0], u[1])}; };
  for (int i = 0; i < n * n * n; ++i) {
    const int index[3] = {i % n, i / n % n, i / n / n};
    Vec3 u;
    for (std::size_t d = 0; d < 3; ++d) u[d] = (2 * index[d] + 1.0) / n - 1;
    // The volume of the cell, from the vectors between the middles of its sides.
    Vec3 across[3];
    for (std::size_t d = 0; d < 3; ++d) {
      Vec3 upper = u;
      Vec3 lower = u;
      upper[d] += 1.0 / n;
      lower[d] -= 1.0 / n;
      const Vec3 x_upper = place(upper);
      const Vec3 x_lower = place(lower);
      for (std::size_t e = 0; e < 3; ++e) across[d][e] = radius * (x_upper[e] - x_lower[e]);
    }
    const Vec3& p = across[0];
    const Vec3& q = across[1];
    const Vec3& r = across[2];
    volumes.push_back(p[0] * (q[1] * r[2] - q[2] * r[1]) + p[1] * (q[2] * r[0] - q[0] * r[2]) + p[2] * (q[0] * r[1] - q[1] * r[0]));
    const Vec3 x = place(u);
    points.push_back({center[0] + radius * x[0], center[1] + radius * x[1], center[2] + radius * x[2]});
  }
  return points_layout(std::move(points), std::move(volumes));
}

/// Two equal elastic spheres collide slowly, with `cells` per radius.
Case spheres(int cells, const std::string& formulation, const Sets& sets) {
  const Real radius = 0.1;
  const Real h = radius / cells;
  const Real middle = radius + 2 * h;
  const Vec3 centers[2] = {{middle, middle, middle}, {middle + 2 * radius + h / 2, middle, middle}};
  std::string text = fmt::format(R"(
dim = 3
[grid]
upper = [{}, {}, {}]
cell_size = {}
[time]
end = 0.2
[solver]
contact = "pairs"
)",
                                 2 * middle + 2 * radius + h, 2 * middle, 2 * middle, h);
  for (const std::string name : {"left", "right"}) {
    const Vec3& center = centers[name == "left" ? 0 : 1];
    text += fmt::format(R"(
[[body]]
name = "{}"
formulation = "{}"
region = {{ type = "sphere", center = [{}, {}, {}], radius = {} }}
layout = {{ type = "per_cell", count = 1 }}
velocity = {{ type = "uniform", value = [{}, 0, 0] }}
material = {{ type = "neo_hookean", density = 1000, youngs_modulus = 1e6, poissons_ratio = 0.3 }}
)",
                        name, formulation, center[0], center[1], center[2], radius, name == "left" ? 0.25 : -0.25);
  }
  Case problem = case_from_text("hertz", text, sets);
  for (std::size_t b : {0, 1}) problem.bodies[b].layout = ball(centers[b], radius, 4 * cells);
  return problem;
}

/// Hertz's theory (Johnson, Contact Mechanics, section 11.4): spheres touch for 2.87 (m^2 / (R E*^2 v))^(1/5), with m and R half of a
/// sphere's mass and radius, v their speed towards each other and E* = E / (2 (1 - nu^2)).
Measured hertz(int cells, const std::string& formulation, const Sets& sets = {}) {
  Simulation sim(spheres(cells, formulation, sets));
  const Real m = sim.solver().totals(0).mass / 2;
  const Real start = sim.solver().totals(0).momentum[0];
  const Real E = 1e6 / (2 * (1 - 0.3 * 0.3));
  const Real exact = 2.87 * std::pow(m * m / (0.05 * E * E * 0.5), 0.2);
  Real first = -1;
  Real last = -1;
  sim.add_callback([&](const Simulation& s) {
    const bool is_touching = s.solver().ledger().contact_energy > 0;
    if (is_touching && first < 0) first = s.time();
    if (is_touching) last = s.time();
    return last < 0 || is_touching || s.time() < last + 0.2 * exact;
  });
  sim.run();
  const std::string tail = fmt::format("_{}_{}", formulation, cells);
  return {{"contact_time_over_hertz" + tail, (last - first) / exact},
          {"restitution" + tail, -sim.solver().totals(0).momentum[0] / start},
          {"E_end_over_E0" + tail, whole_energy(sim) / sim.initial_energy()}};
}

}  // namespace

void add_contact_jobs(std::vector<VerifyJob>& jobs) {
  for (const auto& [divisions, points] : {std::pair<int, int>(10, 316), {31, 3016}}) {
    for (const Way& way : ways({"lower", "upper"}, {"solver.stress_order=musl"})) {
      const std::string tail = fmt::format("_{}_{}", way.name, points);
      jobs.push_back({"8.3",
                      fmt::format("disks, {} points, {}", points, way.name),
                      "disks",
                      points < 1000,
                      true,
                      1e5 * points,
                      {"t_contact" + tail, "E_max_over_E0" + tail, "E_end_over_E0" + tail, "momentum" + tail},
                      [divisions = divisions, way] { return disks(divisions, way); }});
    }
  }
  jobs.push_back({"8.3",
                  "disks, energy of pairs",
                  "disks",
                  true,
                  true,
                  3e7,
                  {"E_in_step_over_E0_pairs_usl", "E_excess_over_that_of_half_dt_pairs"},
                  energy_of_pairs});
  for (const Way& way : ways({"base", "block"}, {})) {
    if (way.name == "contact") continue;  // src/verify/incline.cpp
    for (const Real friction : {0.0, 0.3}) {
      jobs.push_back({"incline",
                      fmt::format("block on an incline, mu = {}, {}", friction, way.name),
                      "incline",
                      true,
                      true,
                      1e7,
                      {fmt::format("on_a_body_30_mu{}_speed_ratio_{}", friction, way.name)},
                      [=] { return incline(friction, way); }});
    }
  }
  for (const std::string formulation : {"updated", "total"}) {
    for (const int cells : {5, 10}) {
      const std::string tail = fmt::format("_{}_{}", formulation, cells);
      jobs.push_back({"hertz",
                      fmt::format("spheres, {} cells per radius, {}", cells, formulation),
                      "hertz",
                      cells == 5 && formulation == "total",
                      true,
                      cells == 5 ? 4e6 : 6e7,
                      {"contact_time_over_hertz" + tail, "restitution" + tail, "E_end_over_E0" + tail},
                      [=] { return hertz(cells, formulation); }});
    }
  }
}

}  // namespace matpoint
