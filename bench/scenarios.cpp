#include "scenarios.hpp"

#include <cmath>

#include "core/parallel.hpp"

namespace matpoint::bench {
namespace {

constexpr Arrangement k_lattice = Arrangement::lattice;
constexpr Arrangement k_jitter = Arrangement::jitter;
constexpr Arrangement k_random = Arrangement::random;

std::string order_name(StressOrder order) { return order == StressOrder::usl ? "usl" : order == StressOrder::usf ? "usf" : "musl"; }
std::string arrangement_name(Arrangement arrangement) {
  return arrangement == k_lattice ? "lattice" : arrangement == k_jitter ? "jitter" : "random";
}

Scenario bodies(int dim, Arrangement arrangement, std::size_t particles, StressOrder order = StressOrder::usl) {
  Scenario scenario;
  scenario.scene = {dim, arrangement, particles};
  scenario.solver.stress_order = order;
  scenario.name = fmt::format("{}D {} {}", dim, arrangement_name(arrangement), order_name(order));
  return scenario;
}

Scenario without_plain(Scenario scenario) {
  scenario.has_plain = false;
  return scenario;
}

ScenarioSet of_sizes(const std::string& name, const std::string& about, int dim, const std::vector<std::size_t>& sizes) {
  ScenarioSet set{name, about, {}};
  for (const std::size_t size : sizes) {
    for (const Arrangement arrangement : {k_lattice, k_jitter, k_random}) set.scenarios.push_back(bodies(dim, arrangement, size));
  }
  return set;
}

ScenarioSet schemes(std::size_t particles) {
  ScenarioSet set{"schemes", "USL, USF and MUSL in 2D and 3D against the plain loops", {}};
  for (const StressOrder order : {StressOrder::usl, StressOrder::usf, StressOrder::musl}) {
    for (const int dim : {2, 3}) {
      for (const Arrangement arrangement : {k_lattice, k_jitter}) set.scenarios.push_back(bodies(dim, arrangement, particles, order));
    }
  }
  return set;
}

ScenarioSet shapes(std::size_t particles) {
  ScenarioSet set{"shapes", "quadratic B-splines against the plain loops, and with other transfers", {}};
  for (const int dim : {2, 3}) {
    for (const Arrangement arrangement : {k_lattice, k_jitter}) {
      Scenario scenario = bodies(dim, arrangement, particles);
      scenario.solver.shape = ShapeKind::bspline2;
      scenario.name = fmt::format("{}D {} bspline2", dim, arrangement_name(arrangement));
      set.scenarios.push_back(scenario);
    }
    for (const ShapeKind shape : {ShapeKind::linear, ShapeKind::bspline2}) {
      Scenario scenario = without_plain(bodies(dim, k_jitter, particles));
      scenario.solver.shape = shape;
      scenario.solver.transfer = Transfer::apic;
      scenario.name = fmt::format("{}D {} apic", dim, shape == ShapeKind::linear ? "linear" : "bspline2");
      set.scenarios.push_back(scenario);
    }
  }
  return set;
}

ScenarioSet contacts(std::size_t particles) {
  ScenarioSet set{"contact", "one velocity field against one per body: bodies that share nodes, and bodies apart", {}};
  for (const int dim : {2, 3}) {
    for (const double gap : {1.0, 8.0}) {
      for (const ContactMethod method : {ContactMethod::single_field, ContactMethod::multi_field}) {
        Scenario scenario = without_plain(bodies(dim, k_jitter, particles));
        scenario.scene.gap = gap;
        scenario.solver.contact = method;
        scenario.name = fmt::format("{}D {} {}", dim, gap > 1 ? "apart" : "near",
                                    method == ContactMethod::single_field ? "single_field" : "multi_field");
        set.scenarios.push_back(scenario);
      }
    }
  }
  return set;
}

ScenarioSet laws(std::size_t particles) {
  ScenarioSet set{"laws", "every law, in 2D and 3D", {}};
  const std::pair<const char*, const char*> all[] = {
      {"neo_hookean", R"({ type = "neo_hookean", density = 1000, youngs_modulus = 1000, poissons_ratio = 0.3 })"},
      {"st_venant_kirchhoff", R"({ type = "st_venant_kirchhoff", density = 1000, youngs_modulus = 1000, poissons_ratio = 0.3 })"},
      {"newtonian_fluid", R"({ type = "newtonian_fluid", density = 1000, pressure_scale = 140, gamma = 7, viscosity = 0.1 })"},
      {"hencky", R"({ type = "hencky", density = 1000, youngs_modulus = 1000, poissons_ratio = 0.3 })"},
      {"j2", R"({ type = "j2", density = 1000, youngs_modulus = 1000, poissons_ratio = 0.3, yield_stress = 1, hardening_modulus = 10 })"},
      {"drucker_prager",
       R"({ type = "drucker_prager", density = 1000, youngs_modulus = 1000, poissons_ratio = 0.3, cohesion = 1, friction_angle = 30 })"},
      {"mohr_coulomb",
       R"({ type = "mohr_coulomb", density = 1000, youngs_modulus = 1000, poissons_ratio = 0.3, cohesion = 1, friction_angle = 30 })"},
      {"mu_i", R"({ type = "mu_i", density = 1000, youngs_modulus = 1000, poissons_ratio = 0.3, mu_s = 0.38, mu_2 = 0.64, I0 = 0.28, )"
               R"(grain_diameter = 1e-3, grain_density = 1600 })"},
      {"herschel_bulkley",
       R"({ type = "herschel_bulkley", density = 1000, youngs_modulus = 1000, poissons_ratio = 0.3, yield_stress = 1, consistency = 1 })"},
      {"johnson_cook",
       R"({ type = "johnson_cook", density = 1000, youngs_modulus = 1000, poissons_ratio = 0.3, A = 1, B = 1, n = 0.3, C = 0.02, )"
       R"(melting_temperature = 1356, heat_capacity = 383 })"},
      {"cam_clay", R"({ type = "cam_clay", density = 1000, shear_modulus = 400, critical_slope = 1, lambda_star = 0.1, kappa_star = 0.02, )"
                   R"(preconsolidation = 30, pressure_offset = 20 })"},
      {"snow", R"({ type = "snow", density = 1000, youngs_modulus = 1000, poissons_ratio = 0.3 })"},
      {"fixed_corotated", R"({ type = "fixed_corotated", density = 1000, youngs_modulus = 1000, poissons_ratio = 0.3 })"},
      {"mooney_rivlin", R"({ type = "mooney_rivlin", density = 1000, c1 = 200, bulk_modulus = 1000 })"},
      {"ogden", R"({ type = "ogden", density = 1000, mu_1 = 400, alpha_1 = 2, bulk_modulus = 1000 })"},
      {"viscoelastic",
       R"({ type = "viscoelastic", density = 1000, bulk_modulus = 1000, shear_modulus = 200, modulus_1 = 200, time_1 = 1 })"},
      {"rankine_damage", R"({ type = "rankine_damage", density = 1000, youngs_modulus = 1000, poissons_ratio = 0.3, )"
                         R"(tensile_strength = 1, fracture_energy = 1, length = 0.001 })"}};
  for (const int dim : {2, 3}) {
    for (const auto& [name, law] : all) {
      Scenario scenario = without_plain(bodies(dim, k_jitter, particles));
      scenario.law = law;
      scenario.name = fmt::format("{}D {}", dim, name);
      set.scenarios.push_back(scenario);
    }
  }
  return set;
}

ScenarioSet precisions(std::size_t particles) {
  ScenarioSet set{"precision", "single against double precision", {}};
  for (const int dim : {2, 3}) {
    for (const Arrangement arrangement : {k_lattice, k_jitter}) {
      for (const char* precision : {"double", "single"}) {
        Scenario scenario = without_plain(bodies(dim, arrangement, particles));
        scenario.solver.precision = precision;
        scenario.name += fmt::format(" {}", precision);
        set.scenarios.push_back(scenario);
      }
    }
  }
  return set;
}

ScenarioSet threads(std::size_t particles) {
  ScenarioSet set{"threads", "one thread against all processors", {}};
  for (const int dim : {2, 3}) {
    for (const int count : {1, thread_count()}) {
      Scenario scenario = without_plain(bodies(dim, k_jitter, particles));
      scenario.threads = count;
      scenario.is_wall_time = true;
      scenario.name += fmt::format(" {} thr.", count);
      set.scenarios.push_back(scenario);
    }
  }
  return set;
}

ScenarioSet boxes(std::size_t particles) {
  ScenarioSet set{"sparse", "the same bodies in boxes of 1 and of 100 times the cells", {}};
  for (const int dim : {2, 3}) {
    for (const double factor : {1.0, 100.0}) {
      Scenario scenario = without_plain(bodies(dim, k_jitter, particles));
      scenario.scene.box_factor = factor;
      scenario.name += fmt::format(" x{:.0f}", factor);
      set.scenarios.push_back(scenario);
    }
  }
  return set;
}

ScenarioSet movers(std::size_t particles) {
  ScenarioSet set{"movers", "bodies that move against bodies at rest: what a change of cell costs", {}};
  for (const int dim : {2, 3}) {
    for (const bool is_at_rest : {true, false}) {
      Scenario scenario = without_plain(bodies(dim, k_jitter, particles));
      scenario.scene.is_at_rest = is_at_rest;
      scenario.name += is_at_rest ? " rest" : " moving";
      set.scenarios.push_back(scenario);
    }
  }
  return set;
}

// A column of water that has collapsed and splashed against the far wall: cells of every occupancy, and gaps.
Scenario dam(std::size_t particles, double time) {
  const double h = std::sqrt(0.06 * 4 / static_cast<double>(particles));
  const int rows = static_cast<int>(std::lround(0.8 / h));
  Scenario scenario;
  scenario.name = fmt::format("2D dam t={}", time);
  scenario.has_plain = false;
  scenario.warm_up = time;
  scenario.case_text = fmt::format(R"(
gravity = [0, -9.81]
[solver]
shape = "linear"
[grid]
upper = [0.8, 0.8]
cells = [{0}, {0}]
particles_outside = "remove"
[time]
end = 10
[[body]]
name = "water"
region = {{ type = "box", lower = [0, 0], upper = [0.2, 0.3] }}
layout = {{ type = "per_cell", count = 4 }}
material = {{ type = "newtonian_fluid", density = 1000, pressure_scale = 16000, gamma = 7, viscosity = 1e-3 }}
[[boundary]]
side = "left"
kind = "slip"
[[boundary]]
side = "right"
kind = "slip"
[[boundary]]
side = "bottom"
kind = "slip"
[[boundary]]
side = "top"
kind = "slip"
)",
                                   rows);
  return scenario;
}

// A layer of 20 cells that slides down a slope of 1 : 3; the box around it is more than 99 % empty.
Scenario landslide(std::size_t particles) {
  const double length = static_cast<double>(particles) / 4 / 20;  // along x, in cells of 1 m
  const int across = static_cast<int>(length) + 64;
  const int up = static_cast<int>(length / 3) + 64;
  Scenario scenario;
  scenario.name = "2D landslide";
  scenario.has_plain = false;
  scenario.warm_up = 0.2;
  scenario.case_text = fmt::format(R"(
gravity = [0, -9.81]
[solver]
shape = "linear"
[grid]
upper = [{0}, {1}]
cells = [{0}, {1}]
[time]
end = 1000
[[body]]
name = "slide"
region = {{ type = "polygon", vertices = [[32, {2}], [{3}, 10], [{3}, 30], [32, {4}]] }}
layout = {{ type = "per_cell", count = 4 }}
material = {{ type = "newtonian_fluid", density = 2000, pressure_scale = 1e6, gamma = 7, viscosity = 1e4 }}
velocity = {{ type = "uniform", value = [9, -3] }}
[[boundary]]
kind = "slip"
region = {{ type = "half_space", point = [32, {2}], normal = [1, 3] }}
)",
                                   across, up, 10 + length / 3, 32 + length, 30 + length / 3);
  return scenario;
}

}  // namespace

std::vector<ScenarioSet> scenario_sets(std::size_t particles) {
  std::vector<ScenarioSet> sets;
  sets.push_back(schemes(particles));
  sets.push_back(of_sizes("disks", "two disks in 2D, 1e3 to 1e6 particles: lattice, jittered, random", 2, {1000, 10000, 100000, 1000000}));
  sets.push_back(
      of_sizes("spheres", "two spheres in 3D, 1e3 to 1e6 particles: lattice, jittered, random", 3, {1000, 10000, 100000, 1000000}));
  sets.push_back({"large",
                  "1e6 against 1e7 particles",
                  {without_plain(bodies(2, k_jitter, 1000000)), without_plain(bodies(2, k_jitter, 10000000)),
                   without_plain(bodies(3, k_jitter, 1000000)), without_plain(bodies(3, k_jitter, 10000000))}});
  sets.push_back({"tiny", "500 and 2000 particles", {bodies(2, k_lattice, 500), bodies(2, k_lattice, 2000), bodies(3, k_lattice, 2000)}});
  sets.push_back(shapes(particles));
  sets.push_back(contacts(particles));
  sets.push_back(laws(particles));
  sets.push_back(precisions(particles));
  sets.push_back(threads(particles));
  sets.push_back(boxes(particles));
  sets.push_back(movers(particles));
  sets.push_back({"dam", "a dam break at its start and when it has splashed", {dam(50000, 0), dam(50000, 0.5)}});
  sets.push_back({"landslide", "a thin layer on a slope, 99 % of the box empty", {landslide(particles)}});
  return sets;
}

}  // namespace matpoint::bench
