// Coulomb friction on a side of the grid in the implicit solver: a block on an incline, as a point mass moves, and the paper's disk, which
// rolls or slips.
#include <cmath>

#include "verify/analytic.hpp"
#include "verify/implicit_series.hpp"

namespace matpoint {
namespace {

constexpr Real k_gravity = 9.81;

/// A block of 1 m on an incline of 30 degrees. Gravity grows over five of the block's periods, so that it hardly bounces.
Case block_on_incline(int dim, Real mu) {
  const Real down = k_gravity * 0.5, into = -k_gravity * std::sqrt(0.75);
  const auto point = [&](Real x, Real y) { return dim == 3 ? fmt::format("[{}, {}, {}]", x, y, x) : fmt::format("[{}, {}]", x, y); };
  // In 3D it slides along the diagonal of its face.
  const Real part = dim == 3 ? down * std::sqrt(0.5) : down;
  return case_from_text("block_on_incline", fmt::format(R"({}gravity = {}
gravity_times = [0, 0.2]
gravity_factors = [0, 1]
[grid]
lower = {}
upper = {}
cells = {}
[time]
end = {}
dt = 0.01
[solver]
type = "implicit"
[[body]]
name = "block"
region = {{ type = "box", lower = {}, upper = {} }}
layout = {{ type = "per_cell", count = {} }}
material = {{ type = "neo_hookean", density = 1000, youngs_modulus = 1e7, poissons_ratio = 0.3 }}
[[boundary]]
side = "bottom"
kind = "fixed"
contact = "friction"
friction = {}
)",
                                                        dim == 3 ? "dim = 3\n" : "", point(part, into), point(0, 0),
                                                        dim == 3 ? point(4, 2) : point(6, 1.5), dim == 3 ? "[4, 2, 4]" : "[24, 6]",
                                                        dim == 3 ? 0.4 : 1.0, point(0.5, 0), point(1.5, 1), dim == 3 ? 27 : 16, mu));
}

struct Slide {
  Real acceleration;  ///< Along x from 0.2 s on [m/s^2].
  Real way;           ///< The same [m].
  Real dissipation;   ///< Over friction times the way [1].
};

Slide slide(int dim, Real mu) {
  Simulation sim(block_on_incline(dim, mu));
  const Real mass = sim.solver().totals(0).mass;
  Real t = 0, v = 0, x = 0, dissipation = 0;
  at(sim, 0.2, [&](const Simulation& s) {
    const BodyTotals totals = s.solver().totals(0);
    t = s.time();
    v = totals.momentum[0] / mass;
    x = totals.center_of_mass[0];
    dissipation = s.solver().ledger().contact_dissipation;
  });
  sim.run();
  const BodyTotals totals = sim.solver().totals(0);
  const Real way = totals.center_of_mass[0] - x;
  const Real friction = mu * k_gravity * std::sqrt(0.75) * mass;
  return {(totals.momentum[0] / mass - v) / (sim.time() - t), way,
          (sim.solver().ledger().contact_dissipation - dissipation) / (friction * way * (dim == 3 ? std::sqrt(2) : 1))};
}

/// g (sin 30 - mu cos 30)
Real exact(Real mu) { return k_gravity * (0.5 - mu * std::sqrt(0.75)); }

/// The disk's acceleration from 0.5 s on [m/s^2], and the averaged error of its tracked centre as one that rolls.
Measured disk(int cells, Real mu) {
  Simulation sim(disk_on_splines(cells, 0, fmt::format("contact = \"friction\"\nfriction = {}", mu)));
  AveragedError tracked;
  Real t = 0, p = 0;
  every(sim, 1, [&](const Simulation& s) { tracked.include(s.time(), s.solver().field(0, "position").values[0]); });
  at(sim, 0.5, [&](const Simulation& s) {
    t = s.time();
    p = s.solver().totals(0).momentum[0];
  });
  sim.run();
  const BodyTotals totals = sim.solver().totals(0);
  return {{"acceleration", (totals.momentum[0] - p) / totals.mass / (sim.time() - t)}, {"error", tracked.mean()}};
}

}  // namespace

void add_implicit_friction(VerifySuite& suite) {
  const std::string law = "Coulomb's law, a point mass";
  add_problem(suite,
              {"implicit_friction",
               "a block on an incline",
               "implicit_friction",
               true,
               true,
               5e5,
               {},
               [] {
                 const Slide fast = slide(2, 0.3), slow = slide(2, 0.5), smooth = slide(2, 0), solid = slide(3, 0.3);
                 return Measured{{"incline_30_mu0.3_acceleration_ratio", fast.acceleration / exact(0.3)},
                                 {"incline_30_mu0.5_acceleration_ratio", slow.acceleration / exact(0.5)},
                                 {"incline_30_mu0_acceleration_ratio", smooth.acceleration / exact(0)},
                                 {"incline_30_mu0.3_acceleration_ratio_3d", solid.acceleration * std::sqrt(2) / exact(0.3)},
                                 {"incline_30_mu0.3_dissipation_ratio", fast.dissipation},
                                 {"incline_30_mu0.6_way", slide(2, 0.6).way}};
               }},
              {within("incline_30_mu0.3_acceleration_ratio", 1, 1e-4, law), within("incline_30_mu0.5_acceleration_ratio", 1, 1e-3, law),
               within("incline_30_mu0_acceleration_ratio", 1, 1e-6, law),
               within("incline_30_mu0.3_acceleration_ratio_3d", 1, 5e-3, law + "; along the diagonal of its face"),
               within("incline_30_mu0.3_dissipation_ratio", 1, 5e-4, law),
               at_most("incline_30_mu0.6_way", 5e-4, "tan 30 = 0.577 < mu: it stays [m]; without friction 2.6")});
  for (const int cells : {80, 160}) {
    const std::string quantity = fmt::format("disk_slips_mu0.2_acceleration_ratio_{}x{}", cells, cells / 5);
    add_problem(suite,
                {"implicit_friction",
                 fmt::format("a disk that slips, {} x {} cells", cells, cells / 5),
                 "rolling_disk",
                 false,
                 true,
                 cells * 2e7,
                 {},
                 [=] {
                   return Measured{{quantity, disk(cells, 0.2).at("acceleration") / (9.81 * std::sqrt(0.5) * 0.8)}};
                 }},
                {within(quantity, 1, 2e-3, "Coulomb's law: mu < tan(45) / 3; no C_c, no gap")});
  }
  add_problem(
      suite,
      {"implicit_friction",
       "a disk that rolls",
       "rolling_disk",
       false,
       true,
       4e9,
       {},
       [] {
         return Measured{{"disk_rolls_mu0.6_error_160x32", disk(160, 0.6).at("error")}};
       }},
      {at_most("disk_rolls_mu0.6_error_160x32", 0.25, "mu > tan(45) / 3: as with a face that holds, rolling_disk; no C_c, no gap")});
}

}  // namespace matpoint
