// What every scheme keeps in every dimension: mass, momentum up to what the ledger books, mirror symmetry. An elastic ball flies into a
// ball of fluid, near a wall and under gravity, so that every entry of the momentum ledger is at work.
#include <fmt/format.h>

#include <cmath>

#include "verify/analytic.hpp"

namespace matpoint {
namespace {

constexpr const char* k_flat = R"(
gravity = [0, -9.81]
[grid]
upper = [1, 1]
cells = [20, 20]
[time]
dt = 1e-4
end = 0.2
[[body]]
name = "solid"
region = { type = "disk", center = [0.5, 0.6], radius = 0.2 }
layout = { type = "per_cell", count = 4 }
velocity = { type = "uniform", value = [0, -2] }
material = { type = "neo_hookean", density = 1500, youngs_modulus = 1e5, poissons_ratio = 0.3 }
[[body]]
name = "fluid"
region = { type = "box", lower = [0, 0], upper = [1, 0.3] }
layout = { type = "per_cell", count = 4 }
material = { type = "newtonian_fluid", density = 1000, pressure_scale = 2e4, viscosity = 0.1 }
[[boundary]]
side = "left"
kind = "slip"
[[boundary]]
side = "right"
kind = "slip"
[[boundary]]
side = "bottom"
kind = "slip"
)";

constexpr const char* k_solid = R"(
dim = 3
gravity = [0, -9.81, 0]
[grid]
upper = [1, 1, 1]
cells = [10, 10, 10]
[time]
dt = 2e-4
end = 0.2
[[body]]
name = "solid"
region = { type = "sphere", center = [0.5, 0.6, 0.5], radius = 0.2 }
layout = { type = "per_cell", count = 8 }
velocity = { type = "uniform", value = [0, -2, 0] }
material = { type = "neo_hookean", density = 1500, youngs_modulus = 1e5, poissons_ratio = 0.3 }
[[body]]
name = "fluid"
region = { type = "box", lower = [0, 0, 0], upper = [1, 0.3, 1] }
layout = { type = "per_cell", count = 8 }
material = { type = "newtonian_fluid", density = 1000, pressure_scale = 2e4, viscosity = 0.1 }
[[boundary]]
side = "left"
kind = "slip"
[[boundary]]
side = "right"
kind = "slip"
[[boundary]]
side = "front"
kind = "slip"
[[boundary]]
side = "back"
kind = "slip"
[[boundary]]
side = "bottom"
kind = "slip"
)";

Real mass(const Simulation& sim) { return sim.solver().totals(0).mass + sim.solver().totals(1).mass; }

Real nodal_mass(const Simulation& sim) {
  Real sum = 0;
  for (const Field& field : sim.solver().grid_fields()) {
    if (field.name != "mass") continue;
    for (const Real value : field.values) sum += value;
  }
  return sum;
}

Measured invariants(const std::string& suffix, const char* text, const Sets& sets) {
  Simulation sim(case_from_text("invariants", text, sets));
  const Real m0 = mass(sim);
  const Real K0 = kinetic_energy(sim);
  const Real scale = sim.solver().totals(0).mass * 2;  // the solid's momentum at the start, 2 m/s
  Real mass_error = 0;
  Real nodal_error = 0;
  Real remainder = 0;
  Real sideways = 0;
  every(sim, 10, [&](const Simulation& s) {
    mass_error = std::max(mass_error, std::abs(mass(s) - m0) / m0);
    nodal_error = std::max(nodal_error, std::abs(nodal_mass(s) - m0) / m0);
    remainder = std::max(remainder, momentum_remainder(s) / scale);
    sideways = std::max({sideways, std::abs(momentum(s)[0]) / scale, std::abs(momentum(s)[2]) / scale});
  });
  sim.run();
  Real off_center = 0;
  for (std::size_t b = 0; b < 2; ++b) off_center = std::max(off_center, std::abs(sim.solver().totals(b).center_of_mass[0] - 0.5));
  return {{"transfer_loss_over_KE0" + suffix, transfer_loss(sim) / K0},
          {"mass_error" + suffix, mass_error},
          {"nodal_mass_error" + suffix, nodal_error},
          {"momentum_remainder" + suffix, remainder},
          {"momentum_sideways" + suffix, sideways},
          {"off_center" + suffix, off_center}};
}

}  // namespace

void add_invariants(VerifySuite& suite) {
  struct Variant {
    std::string suffix;
    std::string name;
    const char* text;
    Sets sets;
  };
  const std::vector<Variant> variants = {
      {"_2d_musl", "2D, MUSL, FLIP", k_flat, {}},
      {"_2d_usf", "2D, USF, FLIP 0.95, damped", k_flat, {"solver.stress_order=usf", "solver.flip=0.95", "solver.damping=1"}},
      {"_2d_usl",
       "2D, USL, FLIP 0.95, large mass cutoff",
       k_flat,
       {"solver.stress_order=usl", "solver.flip=0.95", "solver.mass_cutoff_relative=0.1"}},
      {"_3d_musl", "3D, MUSL, FLIP", k_solid, {}},
      {"_3d_usf", "3D, USF, FLIP 0.95, damped", k_solid, {"solver.stress_order=usf", "solver.flip=0.95", "solver.damping=1"}}};
  // Round-off: some 1e-16 times the number of steps and of particles per node.
  const std::string exact = "invariant";
  for (const Variant& variant : variants) {
    const std::string& s = variant.suffix;
    add_problem(suite,
                {"invariants",
                 "a ball drops into water, " + variant.name,
                 "",
                 true,
                 true,
                 variant.text == k_flat ? 3e6 : 4e6,
                 {},
                 [=] { return invariants(variant.suffix, variant.text, variant.sets); }},
                {at_most("mass_error" + s, 0, exact), at_most("nodal_mass_error" + s, 1e-13, exact),
                 at_most("momentum_remainder" + s, 2e-12, exact), at_most("momentum_sideways" + s, 1e-12, exact),
                 at_most("off_center" + s, 1e-12, exact)});
  }
}

}  // namespace matpoint
