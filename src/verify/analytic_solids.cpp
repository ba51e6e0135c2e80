// Solids: a square that turns and travels, a sphere that bounces, Cook's membrane, a column compacted by its weight.
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "verify/analytic.hpp"

namespace matpoint {
namespace {

// --- rotating square -------------------------------------------------------------------------------------------------
constexpr const char* k_square = R"(
[grid]
lower = [-1, -1]
upper = [2, 1]
cells = [24, 16]
[time]
dt = 5e-4
end = 10
[solver]
stress_order = "musl"
[[body]]
name = "square"
region = { type = "box", lower = [-0.5, -0.5], upper = [0.5, 0.5] }
layout = { type = "per_cell", count = 4 }
velocity = { type = "rotating", center = [0, 0], angular_velocity = 1, value = [0.1, 0] }
material = { type = "neo_hookean", density = 1550, youngs_modulus = 1e6, poissons_ratio = 0.3 }
)";

/// Angular momentum about the origin [N m s].
Real angular_momentum(const Simulation& sim) {
  const Field x = sim.solver().field(0, "position");
  const Field v = sim.solver().field(0, "velocity");
  const Field m = sim.solver().field(0, "mass");
  Real sum = 0;
  for (std::size_t p = 0; p < m.values.size(); ++p) {
    sum += m.values[p] * (x.values[2 * p] * v.values[2 * p + 1] - x.values[2 * p + 1] * v.values[2 * p]);
  }
  return sum;
}

/// With B-splines and APIC a particle turns by itself, too: h^2 / 4 times its mass is its moment of inertia. Greatest change of the whole
/// angular momentum, and the greatest kinetic energy, both of 1.
Measured rotating_square_apic(const std::string& transfer) {
  Simulation sim(case_from_text("rotating_square", k_square,
                                {"solver.shape=bspline2", "solver.transfer=" + transfer, "solver.mass_cutoff_relative=1e-9"}));
  const Real h = sim.solver().grid().cell_size[0];
  const auto whole = [&] {
    const Field C = sim.solver().field(0, "affine_velocity");
    const Field m = sim.solver().field(0, "mass");
    Real sum = angular_momentum(sim);
    for (std::size_t p = 0; p < m.values.size(); ++p) sum += m.values[p] * h * h / 4 * (C.values[9 * p + 3] - C.values[9 * p + 1]);
    return sum;
  };
  const Real start = whole();
  const Real K0 = kinetic_energy(sim);
  Real drift = 0;
  Real K = 1;
  every(sim, 10, [&](const Simulation& s) {
    drift = std::max(drift, std::abs(whole() / start - 1));
    K = std::max(K, kinetic_energy(s) / K0);
  });
  sim.run();
  return {
      {"angular_momentum_drift_" + transfer, drift}, {"kinetic_energy_max_" + transfer, K}, {"energy_end_" + transfer, energy(sim) / K0}};
}

Measured rotating_square(const std::string& suffix, const Sets& sets) {
  Simulation sim(case_from_text("rotating_square", k_square, sets));
  const Real K0 = kinetic_energy(sim);
  const Real H0 = angular_momentum(sim);
  const Real P0 = sim.initial_momentum()[0];
  Range K;
  Range H;
  Range E;
  every(sim, 10, [&](const Simulation& s) {
    K.include(kinetic_energy(s) / K0);
    E.include(energy(s) / K0);
    H.include(angular_momentum(s) / H0);
  });
  sim.run();
  return {{"kinetic_energy_max" + suffix, K.greatest},
          {"energy_max" + suffix, E.greatest},
          {"energy_end" + suffix, energy(sim) / sim.initial_energy()},
          {"angular_momentum_least" + suffix, H.least},
          {"angular_momentum_greatest" + suffix, H.greatest},
          {"momentum_remainder" + suffix, momentum_remainder(sim) / P0}};
}

// --- bouncing sphere -------------------------------------------------------------------------------------------------
/// The particle that mirrors each particle in the plane x_d = c.
std::vector<std::size_t> mirror_images(const Field& position, std::size_t d, Real c) {
  const std::size_t n = position.values.size() / 3;
  std::vector<std::size_t> image(n, n);
  for (std::size_t p = 0; p < n; ++p) {
    for (std::size_t q = 0; q < n && image[p] == n; ++q) {
      bool matches = true;
      for (std::size_t e = 0; e < 3; ++e) {
        const Real expected = e == d ? 2 * c - position.values[3 * p + e] : position.values[3 * p + e];
        matches = matches && std::abs(position.values[3 * q + e] - expected) < 1e-9;
      }
      if (matches) image[p] = q;
    }
    if (image[p] == n) throw SolverError("particle {} has no mirror image at the start", p);
  }
  return image;
}

Real asymmetry(const Field& position, const std::vector<std::size_t>& image, std::size_t d, Real c) {
  Real worst = 0;
  for (std::size_t p = 0; p < image.size(); ++p) {
    for (std::size_t e = 0; e < 3; ++e) {
      const Real expected = e == d ? 2 * c - position.values[3 * p + e] : position.values[3 * p + e];
      worst = std::max(worst, std::abs(position.values[3 * image[p] + e] - expected));
    }
  }
  return worst;
}

Measured sphere(const std::string& suffix, const Sets& sets) {
  Simulation sim(load_case("sphere", sets));
  const Field start = sim.solver().field(0, "position");
  const std::vector<std::size_t> image_x = mirror_images(start, 0, 0.3);
  const std::vector<std::size_t> image_z = mirror_images(start, 2, 0.3);
  // Gravity's zero is the floor's; energies are measured by what the fall makes available.
  const Real E0 = sim.initial_energy();
  const BodyTotals first = sim.solver().totals(0);
  const Real fall = first.mass * 9.81 * first.lower[1];
  Real loss = 0;
  Real speed_down = 0;
  Real speed_up = 0;
  Real strain_energy = 0;
  every(sim, 1, [&](const Simulation& s) {
    const BodyTotals now = s.solver().totals(0);
    loss = std::max(loss, std::abs(energy(s) - E0) / fall);
    speed_down = std::max(speed_down, -now.momentum[1] / now.mass);
    speed_up = std::max(speed_up, now.momentum[1] / now.mass);
    strain_energy = std::max(strain_energy, now.strain_energy / fall);
  });
  sim.run();
  const BodyTotals last = sim.solver().totals(0);
  const Field end = sim.solver().field(0, "position");
  return {{"energy_error" + suffix, loss},
          {"restitution" + suffix, speed_up / speed_down},
          {"strain_energy_greatest" + suffix, strain_energy},
          {"asymmetry" + suffix, std::max(asymmetry(end, image_x, 0, 0.3), asymmetry(end, image_z, 2, 0.3))},
          {"momentum_sideways" + suffix, std::max(std::abs(last.momentum[0]), std::abs(last.momentum[2])) / (last.mass * speed_down)},
          {"mass_error" + suffix, std::abs(last.mass - first.mass) / first.mass},
          {"momentum_remainder" + suffix, momentum_remainder(sim) / (last.mass * speed_down)}};
}

void add_squares(VerifySuite& suite) {
  // Linear shape functions make noise whenever particles change cells, and rotation goes into it: angular momentum falls, more slowly with
  // smaller cells or more particles, whatever the time step. Kinetic energy never grows, the total one does by what the mass cutoff makes.
  const std::string free = "free motion keeps energy and angular momentum";
  const auto square_rows = [&](const std::string& suffix, Real energy_bound, Real angular_bound) {
    return std::vector<VerifyRow>{
        at_most("kinetic_energy_max" + suffix, 1, free),        at_most("energy_max" + suffix, 1 + energy_bound, free),
        within("energy_end" + suffix, 1, energy_bound, free),   at_least("angular_momentum_least" + suffix, angular_bound, free),
        at_most("angular_momentum_greatest" + suffix, 1, free), at_most("momentum_remainder" + suffix, 1e-12, "momentum up to the ledger")};
  };
  add_problem(suite,
              {"rotating_square",
               "turns and travels for 10 s, 8 cells a side, MUSL",
               "",
               true,
               true,
               5e6,
               {},
               [] { return rotating_square("", {}); }},
              square_rows("", 0.01, 0.5));
  for (const std::string transfer : {"apic", "tpic"}) {
    std::vector<VerifyRow> rows;
    if (transfer == "apic") rows.push_back(at_most("angular_momentum_drift_apic", 1e-6, "invariant"));
    rows.push_back(at_most("kinetic_energy_max_" + transfer, 1 + 1e-9, "invariant"));
    add_problem(suite,
                {"rotating_square", "B-splines, " + transfer, "", true, true, 5e6, {}, [=] { return rotating_square_apic(transfer); }},
                rows);
  }
  add_problem(suite,
              {"rotating_square",
               "the same with 16 particles per cell",
               "",
               false,
               true,
               2e7,
               {},
               [] { return rotating_square("_16_per_cell", {"body.square.layout.count=16"}); }},
              square_rows("_16_per_cell", 0.005, 0.86));
  add_problem(suite,
              {"rotating_square",
               "the same with half the cell size",
               "",
               false,
               true,
               4e7,
               {},
               [] {
                 return rotating_square("_fine", {"grid.cells=[48,32]", "time.dt=2.5e-4"});
               }},
              square_rows("_fine", 0.017, 0.82));
}

void add_spheres(VerifySuite& suite) {
  const std::string bounce = "conservation of energy and mirror symmetry";
  const auto rows = [&](const std::string& suffix) {
    return std::vector<VerifyRow>{at_most("energy_error" + suffix, 0.01, bounce),
                                  at_least("restitution" + suffix, 0.9, "1 less what stays in vibrations"),
                                  at_least("strain_energy_greatest" + suffix, 1, "m g (fall + squeeze) at rest on the floor"),
                                  at_most("asymmetry" + suffix, 1e-12, bounce),
                                  at_most("momentum_sideways" + suffix, 1e-14, bounce),
                                  at_most("mass_error" + suffix, 0, "exact"),
                                  at_most("momentum_remainder" + suffix, 1e-11, "momentum ledger")};
  };
  add_problem(suite, {"sphere", "bounces on the floor, 3D, MUSL", "sphere", true, true, 2.2e6, {}, [] { return sphere("", {}); }},
              rows(""));
  // Here rounding decides on which side of a line of the grid a particle lands, and it is kept a billionth of a cell off it: 9e-11.
  std::vector<VerifyRow> fine = rows("_fine");
  for (VerifyRow& row : fine) {
    if (row.quantity == "asymmetry_fine") row.kind = RowKind::goal;
  }
  add_problem(suite,
              {"sphere",
               "the same with half the cell size",
               "sphere",
               false,
               true,
               3.6e7,
               {},
               [] {
                 return sphere("_fine", {"grid.cells=[24,24,24]", "time.dt=2.5e-4"});
               }},
              fine);
}

// Cook's membrane: a tapered panel, clamped at the left, sheared at the right by 100 N; how far its upper right corner rises.
constexpr const char* k_cook_elements = R"(
[grid]
upper = [48, 60]
cells = [16, 16]
corners = [[0, 0], [48, 44], [48, 60], [0, 44]]
[time]
dt = 0.1
end = 1
[solver]
type = "implicit"
mode = "static"
basis = "element"
[[body]]
name = "membrane"
method = "elements"
region = { type = "polygon", vertices = [[0, 0], [48, 44], [48, 60], [0, 44]] }
[[boundary]]
side = "left"
kind = "fixed"
[[boundary]]
side = "right"
kind = "traction"
)";

Real cook_by_elements(Real E, Real nu, Real traction) {
  Simulation sim(
      case_from_text("cook", k_cook_elements,
                     {fmt::format("body.membrane.material={{type=\"neo_hookean\",density=1,youngs_modulus={},poissons_ratio={}}}", E, nu),
                      fmt::format("boundary.2.traction=[0,{}]", traction)}));
  sim.run();
  // The corner is the node that is highest at the end.
  const std::vector<Real> x = sim.solver().node_field(0, "position").values;
  Real highest = 0;
  for (std::size_t k = 1; k < x.size(); k += 2) highest = std::max(highest, x[k]);
  return highest - 60;
}

/// Total Lagrangian particles, the load on the last column of particles, nu = .499, brought to rest by damping.
Real cook_by_particles(int cell_size, bool has_fbar) {
  Case problem = case_from_text("cook", R"(
[grid]
lower = [0, -8]
upper = [64, 88]
[time]
end = 180
cfl = 0.5
[solver]
stress_order = "usl"
damping = 0.08
[[body]]
name = "membrane"
formulation = "total"
region = { type = "polygon", vertices = [[0, 0], [48, 44], [48, 60], [0, 44]] }
layout = { type = "per_cell", count = 4 }
material = { type = "neo_hookean", density = 1, youngs_modulus = 240.565, poissons_ratio = 0.499 }
[[boundary]]
side = "left"
kind = "fixed"
)",
                                {fmt::format("grid.cell_size={}", cell_size), fmt::format("body.membrane.fbar={}", has_fbar)});
  std::vector<Real> X;
  problem.body_force = std::make_shared<BodyForce>();
  problem.body_force->is_of_particles = true;
  problem.body_force->at = [&](Real, const std::vector<Real>&, std::vector<Real>& values) {
    Index loaded = 0;
    for (std::size_t k = 0; k < X.size(); k += 2) loaded += X[k] > 48 - 0.5 * cell_size ? 1 : 0;
    const Real mass = static_cast<Real>(loaded) * cell_size * cell_size / 4;
    for (std::size_t k = 0; k < X.size(); k += 2) {
      if (X[k] > 48 - 0.5 * cell_size) values[k + 1] = 100 / mass;
    }
  };
  Simulation sim(problem);
  X = sim.solver().field(0, "position").values;
  std::size_t corner = 0;
  const auto away = [&](std::size_t k) { return std::hypot(X[k] - 48, X[k + 1] - 60); };
  for (std::size_t k = 0; k < X.size(); k += 2) corner = away(k) < away(corner) ? k : corner;
  sim.run();
  return sim.solver().field(0, "position").values[corner + 1] - X[corner + 1];
}

void add_cook(VerifySuite& suite) {
  const std::string fem = "finite elements of second order, 32 x 32, of this program";
  add_problem(suite,
              {"cook",
               "elements",
               "",
               true,
               true,
               1e5,
               {},
               [] {
                 return Measured{{"corner_elements_nu0.35", cook_by_elements(200, 0.35, 4)}};
               }},
              {within("corner_elements_nu0.35", 6.1469, 0.03, "Mueller (2015), thesis on mixed least squares elements")});
  add_problem(suite,
              {"cook",
               "F-bar",
               "",
               false,
               true,
               3e7,
               {},
               [] {
                 return Measured{{"corner_fbar_2", cook_by_particles(2, true)},
                                 {"corner_fbar_4", cook_by_particles(4, true)},
                                 {"corner_2", cook_by_particles(2, false)}};
               }},
              {within("corner_fbar_2", 6.872, 0.05 * 6.872, fem), within("corner_fbar_4", 6.872, 0.1 * 6.872, fem),
               at_most("corner_2", 0.9 * 6.872, fem + "; it locks")});
}

// --- column compacted by its weight ----------------------------------------------------------------------------------
// Height 50 m, one cell wide, nu = 0: sigma_yy = -rho g (H - Y) at any strain. With E = 1e4 Pa the lowest particle is pressed to an eighth.
// Gravity grows over four periods of the column, and damping brings it to rest. Source: Bardenhagen & Kober (2004); Coombs et al. (2020).
constexpr const char* k_compaction = R"(
gravity = [0, -10]
gravity_factors = [0, 1]
gravity_times = [0, {2}]
[grid]
upper = [{0}, 50]
cells = [1, {1}]
[time]
end = {3}
cfl = 0.3
[solver]
stress_order = "usl"
shape = "{4}"
damping = {5}
[[body]]
name = "column"
formulation = "{6}"
region = {{ type = "box", lower = [0, 0], upper = [{0}, 50] }}
layout = {{ type = "per_cell", count = {7} }}
material = {{ type = "neo_hookean", density = 80, youngs_modulus = {8}, poissons_ratio = 0 }}
[[boundary]]
side = "left"
[[boundary]]
side = "right"
[[boundary]]
side = "bottom"
)";

/// Mean error of sigma_yy over rho g H.
Real compaction_error(const std::string& formulation, const std::string& shape, int cells, Real E, int particles) {
  const Real period = 4 * 50 / std::sqrt(E / 80);
  Simulation sim(case_from_text("compaction", fmt::format(k_compaction, 50.0 / cells, cells, 4 * period, 8 * period, shape,
                                                          2 * std::numbers::pi / period, formulation, particles, E)));
  const Field X = sim.solver().field(0, "position");
  sim.run();
  const Field stress = sim.solver().field(0, "stress");
  const std::size_t n = X.values.size() / 2;
  Real sum = 0;
  for (std::size_t p = 0; p < n; ++p)
    sum += std::abs(stress.values[p * static_cast<std::size_t>(stress.components) + 1] + 800 * (50 - X.values[2 * p + 1]));
  return sum / (static_cast<Real>(n) * 800 * 50);
}

void add_compaction(VerifySuite& suite) {
  const auto job = [&](const std::string& formulation, const std::string& shape, int particles, const std::string& E,
                       const VerifyRow& row) {
    const std::string name = fmt::format("{}_{}_{}_E{}", formulation, shape, particles, E);
    add_problem(suite,
                {"compaction",
                 name,
                 "",
                 shape == "cpdi" && E == "1e4",
                 true,
                 1e7,
                 {},
                 [=] {
                   Measured m;
                   for (const int n : {8, 16, 32, 64})
                     m[fmt::format("{}_{}", name, n)] = compaction_error(formulation, shape, n, std::stod(E), particles * particles);
                   m["order_" + name] = std::log2(m.at(name + "_8") / m.at(name + "_64")) / 3;
                   return m;
                 }},
                {row});
  };
  const std::string source = "closed form; Bardenhagen & Kober (2004)";
  job("total", "bspline2", 4, "1e4", at_least("order_total_bspline2_4_E1e4", 1.9, source));
  job("total", "linear", 2, "1e4", at_least("order_total_linear_2_E1e4", 0.95, source));
  job("updated", "cpdi", 2, "1e4", at_least("order_updated_cpdi_2_E1e4", 1.8, source));
  job("updated", "cpdi", 2, "1e6", at_least("order_updated_cpdi_2_E1e6", 1.6, source));
  // Shown beside them.
  job("updated", "bspline2", 4, "1e4", at_most("order_updated_bspline2_4_E1e4", 1.2, source + "; stalls"));
  job("updated", "bspline3", 4, "1e4", at_most("order_updated_bspline3_4_E1e4", 1.2, source + "; stalls"));
  job("updated", "bspline2", 2, "1e6", at_most("order_updated_bspline2_2_E1e6", 0.8, source + "; stalls"));
}

}  // namespace

void add_solids(VerifySuite& suite) {
  add_squares(suite);
  add_spheres(suite);
  add_cook(suite);
  add_compaction(suite);
}

}  // namespace matpoint
