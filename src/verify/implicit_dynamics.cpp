// A heavy beam that is let go: does the motion converge with the grid, and does the background's reset keep its energy?
#include <cmath>

#include "verify/analytic.hpp"

namespace matpoint {
namespace {

/// Of the centre at .2, .4, ... 2 s [m]: finite elements, 16 and 32 to the height, extrapolated.
constexpr Real k_heights[] = {-0.0960, -0.1625, 0.0327, 0.1524, -0.0555, -0.1493, 0.0765, 0.1465, -0.0899, -0.1313};

Measured heavy_beam(int cells, const std::string& dt, int particles) {
  Simulation sim(case_from_text("heavy_beam",
                                fmt::format(R"(
gravity = [0, -9.81]
gravity_times = [0.392, 0.4]
gravity_factors = [1, 0]
[grid]
lower = [0, -0.5]
upper = [0.75, 0.5]
cells = [{}, {}]
[time]
end = 2
dt = {}
[solver]
type = "implicit"
surface_penalty = 10
[[body]]
name = "beam"
region = {{ type = "box", lower = [0, -0.125], upper = [0.625, 0.125] }}
layout = {{ type = "per_cell", count = {} }}
material = {{ type = "neo_hookean", density = 1e4, youngs_modulus = 1.74e6, poissons_ratio = 0.4 }}
[[boundary]]
side = "left"
kind = "fixed"
)",
                                            3 * cells, 4 * cells, dt, particles),
                                {}));
  const auto energy = [&] {
    const BodyTotals totals = sim.solver().totals(0);
    return totals.kinetic_energy + totals.strain_energy;
  };
  Real difference = 0, size = 0, let_go = 0;
  sim.add_callback([&](const Simulation& now) {
    const Real place = now.time() / 0.2;
    const auto k = static_cast<int>(std::lround(place)) - 1;
    if (k < 0 || std::abs(place - (k + 1)) > 1e-6) return true;
    const Real off = now.solver().totals(0).center_of_mass[1] - k_heights[k];
    difference += off * off;
    size += k_heights[k] * k_heights[k];
    if (k == 2) let_go = energy();
    return true;
  });
  sim.run();
  const std::string suffix = fmt::format("_{}_cells_dt{}_{}_particles", cells, dt, particles);
  return {{"error" + suffix, std::sqrt(difference / size)}, {"energy_kept" + suffix, energy() / let_go}};
}

}  // namespace

void add_implicit_dynamics(VerifySuite& suite) {
  const std::string elements = "finite elements";
  const auto add = [&](int cells, const char* dt, int particles, std::vector<VerifyRow> rows, bool is_quick) {
    add_problem(suite,
                {"implicit_dynamics",
                 fmt::format("a heavy beam, {} cells to its height, {} s, {} particles a cell", cells, dt, particles),
                 "",
                 is_quick,
                 true,
                 2.5e3 * cells * cells * particles,
                 {},
                 [=] { return heavy_beam(cells, dt, particles); }},
                std::move(rows));
  };
  const auto error = [&](const char* suffix, Real bound) { return at_most(std::string("error") + suffix, bound, elements); };
  const auto kept = [&](const char* suffix) { return at_least(std::string("energy_kept") + suffix, 0.99, "nothing takes it"); };
  add(4, "8e-3", 16, {error("_4_cells_dt8e-3_16_particles", 0.03)}, true);
  add(8, "8e-3", 16, {error("_8_cells_dt8e-3_16_particles", 0.01), kept("_8_cells_dt8e-3_16_particles")}, true);
  add(8, "8e-3", 9, {error("_8_cells_dt8e-3_9_particles", 0.03)}, true);
  add(16, "8e-3", 16, {error("_16_cells_dt8e-3_16_particles", 0.01), kept("_16_cells_dt8e-3_16_particles")}, false);
  add(16, "4e-3", 16, {error("_16_cells_dt4e-3_16_particles", 0.01), kept("_16_cells_dt4e-3_16_particles")}, false);
  add(16, "8e-3", 9, {error("_16_cells_dt8e-3_9_particles", 0.03)}, false);
}

}  // namespace matpoint
