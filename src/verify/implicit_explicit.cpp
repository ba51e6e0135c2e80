// The same problems with both solvers: what they answer must differ by no more than what their grids do.
#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "verify/analytic.hpp"

namespace matpoint {
namespace {

constexpr const char* k_bar = R"(
[grid]
lower = [0, 0]
upper = [26, 1]
cells = [26, 1]
[time]
end = 20
dt = 0.02
[solver]
type = "explicit"
[[body]]
name = "bar"
region = { type = "box", lower = [0, 0], upper = [25, 1] }
layout = { type = "per_cell", count = [4, 2] }
velocity = { type = "sine", value = [0.1, 0], wave_vector = [0.06283185307179587, 0] }
material = { type = "neo_hookean", density = 1, youngs_modulus = 100, poissons_ratio = 0 }
[[boundary]]
side = "left"
[[boundary]]
side = "bottom"
[[boundary]]
side = "top"
)";

constexpr const char* k_beam = R"(
gravity = [0, -9.81]
gravity_times = [0.392, 0.4]
gravity_factors = [1, 0]
[grid]
lower = [-0.5, -0.5]
upper = [0.5, 0.5]
cells = [32, 32]
[time]
end = 0.6
dt = 4e-4
[solver]
type = "explicit"
[[body]]
name = "beam"
region = { type = "box", lower = [-0.5, -0.125], upper = [0.125, 0.125] }
layout = { type = "per_cell", count = 16 }
material = { type = "neo_hookean", density = 1e4, youngs_modulus = 1.74e6, poissons_ratio = 0.4 }
[[boundary]]
side = "left"
kind = "fixed"
)";

constexpr const char* k_impact = R"(
gravity = [0, -9.81]
[grid]
lower = [0, 0]
upper = [2, 3]
cells = [20, 30]
[time]
end = 0.6
dt = 2e-4
[solver]
type = "explicit"
[[body]]
name = "disk"
region = { type = "disk", center = [1, 1.2], radius = 0.5 }
layout = { type = "per_cell", count = 16 }
material = { type = "neo_hookean", density = 1000, youngs_modulus = 1e6, poissons_ratio = 0.3 }
[[boundary]]
side = "bottom"
)";

/// The case for the implicit solver, with steps so many times longer.
Sets implicitly(Real dt, Sets sets = {}) {
  sets.insert(sets.end(), {"solver.type=implicit", fmt::format("time.dt={}", dt)});
  return sets;
}

/// Period of the momentum [s].
Real bar_period(const Sets& sets) {
  Simulation sim(case_from_text("bar", k_bar, sets));
  ZeroCrossings crossings;
  every(sim, 1, [&](const Simulation& s) { crossings.include(s.time(), s.solver().totals(0).momentum[0]); });
  sim.run();
  return crossings.period();
}

/// The lowest place of the beam's lowest particle [m].
Real beam_minimum(const Sets& sets) {
  Simulation sim(case_from_text("beam", k_beam, sets));
  Real lowest = 0;
  every(sim, 1, [&](const Simulation& s) { lowest = std::min(lowest, s.solver().totals(0).lower[1]); });
  sim.run();
  return lowest;
}

struct Impact {
  Real strain_energy = 0;  ///< The greatest [J].
  Real time = 0;           ///< When [s].
};
Impact disk_impact(int cells, Sets sets) {
  sets.push_back(fmt::format("grid.cells=[{},{}]", cells, cells * 3 / 2));
  Simulation sim(case_from_text("impact", k_impact, sets));
  Impact impact;
  every(sim, 1, [&](const Simulation& s) {
    const Real strain_energy = s.solver().totals(0).strain_energy;
    if (strain_energy > impact.strain_energy) impact = {strain_energy, s.time()};
  });
  sim.run();
  return impact;
}

}  // namespace

void add_implicit_explicit(VerifySuite& suite) {
  add_problem(
      suite,
      {"implicit_explicit",
       "axial bar",
       "implicit_explicit",
       true,
       true,
       1e6,
       {},
       [] {
         return Measured{{"bar_period_explicit", bar_period({})}, {"bar_period_implicit", bar_period(implicitly(0.05))}};
       }},
      // The explicit one is slow by up to 0.135 (b h)^2 of linear functions at b h = 0.063; Newmark's by (w dt)^2 (beta / 2 - 1/24).
      {within("bar_period_explicit", 10, 0.01, "closed form 4 L / c"), within("bar_period_implicit", 10, 0.002, "closed form 4 L / c")});
  add_problem(suite,
              {"implicit_explicit",
               "cantilever",
               "implicit_explicit",
               true,
               true,
               2e7,
               {},
               [] {
                 const Real explicit_minimum = beam_minimum({});
                 const Real implicit_minimum = beam_minimum(implicitly(0.008, {"boundary.1.attached=true"}));
                 return Measured{{"cantilever_minimum_difference", std::abs(implicit_minimum / explicit_minimum - 1)}};
               }},
              {at_most("cantilever_minimum_difference", 0.01, "dt 4e-4 and 8e-3 s; explicit changes by 4 % from 16 to 32 cells")});
  add_problem(suite,
              {"implicit_explicit",
               "disk impact",
               "implicit_explicit",
               true,
               true,
               2e7,
               {},
               [] {
                 Measured m;
                 for (const int cells : {10, 20}) {
                   const Impact one = disk_impact(cells, {});
                   const Impact other = disk_impact(cells, implicitly(4e-3));
                   m[fmt::format("impact_energy_difference_{}_cells", cells)] = std::abs(other.strain_energy / one.strain_energy - 1);
                   m[fmt::format("impact_time_difference_{}_cells", cells)] = std::abs(other.time - one.time);
                 }
                 m["impact_difference_ratio"] = m["impact_energy_difference_10_cells"] / m["impact_energy_difference_20_cells"];
                 return m;
               }},
              {at_most("impact_energy_difference_20_cells", 0.05, "greatest strain energy, relative"),
               at_most("impact_time_difference_20_cells", 0.01, "when it is greatest [s]"),
               at_least("impact_difference_ratio", 1.8, "half the cell, about half the difference")});
}

}  // namespace matpoint
