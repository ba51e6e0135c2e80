// Coulomb's law on an incline: blocks that stick or slide, a disk and a sphere that roll, on rigid surfaces and on another body.
#include <cmath>
#include <numbers>

#include "verify/analytic.hpp"

namespace matpoint {
namespace {

constexpr Real k_gravity = 9.81;

/// Gravity is turned instead of the surface, and grows within .2 s, so that bodies are pressed on gently: it acts as long as from .1 s on.
constexpr Real k_late = 0.1;

std::string gravity_text(int dim, Real angle) {
  return fmt::format("dim = {}\ngravity = [{:.17g}, {:.17g}{}]\ngravity_times = [0, 0.2]\ngravity_factors = [0, 1]\n", dim,
                     k_gravity * std::sin(angle), -k_gravity * std::cos(angle), dim == 3 ? ", 0" : "");
}

std::string surface_text(Real mu) {
  return fmt::format("[[boundary]]\nside = \"bottom\"\nkind = \"fixed\"\ncontact = \"friction\"\nfriction = {}\n", mu);
}

/// Speed along the incline over g (t - .1 s) of what starts at rest.
Real acceleration_over_g(const std::string& text) {
  Simulation sim(case_from_text("incline", text));
  sim.run();
  const BodyTotals totals = sim.solver().totals(0);
  return totals.momentum[0] / totals.mass / (k_gravity * (sim.time() - k_late));
}

/// A block that is twice as long as high.
Real sliding_block(int dim, Real angle, Real mu, const std::string& shape) {
  std::string text = gravity_text(dim, angle) + fmt::format(R"([grid]
upper = [3, 0.5{}]
cell_size = 0.0625
[time]
end = 0.8
cfl = 0.15
[solver]
shape = "{}"
mass_cutoff = 0
[[body]]
name = "block"
region = {{ type = "box", lower = [0.5, 0{}], upper = [1, 0.25{}] }}
layout = {{ type = "per_cell", count = {} }}
material = {{ type = "neo_hookean", density = 1000, youngs_modulus = 2e5, poissons_ratio = 0.3 }}
)",
                                                            dim == 3 ? ", 0.5" : "", shape, dim == 3 ? ", 0.125" : "",
                                                            dim == 3 ? ", 0.375" : "", dim == 3 ? 8 : 4);
  return acceleration_over_g(text + surface_text(mu));
}

/// A disk or a sphere of radius .25 m.
Real rolling(int dim, Real angle, Real mu, Real cell_size) {
  const std::string text = gravity_text(dim, angle) + fmt::format(R"([grid]
upper = [2, 0.6{}]
cell_size = {}
[time]
end = 0.6
cfl = 0.4
[solver]
mass_cutoff = 0
[[body]]
name = "wheel"
region = {{ type = "{}", center = [0.35, 0.25{}], radius = 0.25 }}
layout = {{ type = "per_cell", count = {} }}
material = {{ type = "neo_hookean", density = 1000, youngs_modulus = 1e6, poissons_ratio = 0.3 }}
)",
                                                                  dim == 3 ? ", 0.6" : "", cell_size, dim == 3 ? "sphere" : "disk",
                                                                  dim == 3 ? ", 0.3" : "", dim == 3 ? 8 : 4);
  return acceleration_over_g(text + surface_text(mu));
}

/// A block slides down another body, by contact between bodies: its speed over the exact one, after half a second.
Measured block_on_a_body() {
  Case problem = case_from_text("incline", R"(
gravity = [4.905, -8.495709211]
[grid]
upper = [2.4, 0.6]
cell_size = 0.05
[time]
end = 0.5
cfl = 0.3
[solver]
contact = "multi_field"
friction = 0.3
[[body]]
name = "base"
region = { type = "box", lower = [0, 0], upper = [2.4, 0.2] }
layout = { type = "per_cell", count = 4 }
material = { type = "neo_hookean", density = 1000, youngs_modulus = 1e6, poissons_ratio = 0.3 }
[[body]]
name = "block"
region = { type = "box", lower = [0.2, 0.2], upper = [0.4, 0.4] }
layout = { type = "per_cell", count = 4 }
material = { type = "neo_hookean", density = 1000, youngs_modulus = 1e5, poissons_ratio = 0.3 }
[[boundary]]
side = "bottom"
kind = "fixed"
[[boundary]]
side = "left"
kind = "fixed"
[[boundary]]
side = "right"
kind = "fixed"
)");
  Simulation sim(problem);
  sim.run();
  const BodyTotals block = sim.solver().totals(1);
  return {{"on_a_body_30_mu0.3_speed_ratio", block.momentum[0] / block.mass / ((4.905 - 0.3 * 8.495709211) * sim.time())}};
}

}  // namespace

void add_inclines(VerifySuite& suite) {
  const Real angle = std::numbers::pi / 6;
  const auto slipping = [=](Real mu) { return std::sin(angle) - mu * std::cos(angle); };
  {
    VerifyJob job{"incline", "block on a rigid incline", "incline", true, true, 3e7, {}, {}};
    job.run = [=] {
      return Measured{{"rigid_30_mu0.3", sliding_block(2, angle, 0.3, "linear")},
                      {"rigid_30_mu0", sliding_block(2, angle, 0, "linear")},
                      {"rigid_30_mu0.7", sliding_block(2, angle, 0.7, "linear")},
                      {"rigid_30_mu0.3_bspline2", sliding_block(2, angle, 0.3, "bspline2")},
                      {"rigid_30_mu0.3_3D", sliding_block(3, angle, 0.3, "linear")}};
    };
    add_problem(
        suite, job,
        {within("rigid_30_mu0.3", slipping(0.3), 2.4e-4, "Coulomb, of g"), within("rigid_30_mu0", slipping(0), 5e-4, "Coulomb, of g"),
         within("rigid_30_mu0.7", 0, 1e-3, "it sticks, for tan 30 = 0.58"),
         within("rigid_30_mu0.3_bspline2", slipping(0.3), 2.4e-4, "Coulomb, of g"),
         within("rigid_30_mu0.3_3D", slipping(0.3), 2.4e-4, "Coulomb, of g")});
  }
  {
    VerifyJob job{"incline", "disk on a rigid incline", "incline", true, true, 3e7, {}, {}};
    job.run = [=] { return Measured{{"disk_30_mu0.6", rolling(2, angle, 0.6, 0.0125)}, {"disk_30_mu0.1", rolling(2, angle, 0.1, 0.025)}}; };
    add_problem(suite, job,
                {within("disk_30_mu0.6", 2.0 / 3 * std::sin(angle), 0.02, "it rolls: 2/3 g sin 30"),
                 within("disk_30_mu0.1", slipping(0.1), 0.01, "it slips: Coulomb")});
  }
  {
    VerifyJob job{"incline", "sphere on a rigid incline", "incline", false, true, 1e9, {}, {}};
    job.run = [=] { return Measured{{"sphere_30_mu0.6", rolling(3, angle, 0.6, 0.025)}}; };
    add_problem(suite, job, {within("sphere_30_mu0.6", 5.0 / 7 * std::sin(angle), 0.02, "it rolls: 5/7 g sin 30")});
  }
  {
    VerifyJob job{"incline", "block on an incline, contact", "incline", true, true, 1e7, {}, {}};
    job.run = [] { return block_on_a_body(); };
    add_problem(suite, job, {within("on_a_body_30_mu0.3_speed_ratio", 1, 0.05, "Coulomb")});
  }
}

}  // namespace matpoint
