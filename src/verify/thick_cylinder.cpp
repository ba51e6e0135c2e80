// A thick cylinder that is widened from inside, in plane strain and statics, on a grid that is a quarter of a ring: the pressure by the
// reaction.
#include <cmath>

#include "verify/materials.hpp"

namespace matpoint {
namespace {

constexpr Real a = 0.1, b = 0.2, pi = 3.14159265358979323846;

/// Widened by `rate` of its radius per second.
Case cylinder(const std::string& material, const std::string& body, Real rate, Real dt, int cells) {
  return default_case("cylinder", fmt::format(R"(
[grid]
upper = [0.2, 0.2]
cells = [{}, {}]
ring = {{ inner_radius = 0.1, outer_radius = 0.2 }}
[time]
end = 1
dt = {}
[solver]
type = "implicit"
mode = "static"
basis = "element"
[[body]]
name = "cylinder"
{}
material = {}
[[boundary]]
name = "inside"
side = "left"
kind = "velocity"
velocity = {{ type = "linear", gradient = [[{}, 0], [0, {}]] }}
[[boundary]]
side = "bottom"
kind = "slip"
[[boundary]]
side = "top"
kind = "fixed"
components = ["x"]
)",
                                              cells, cells, dt, body, material, rate, rate));
}

const char* const k_elements = "method = \"elements\"\nfbar = true\nregion = { type = \"box\", lower = [0, 0], upper = [0.2, 0.2] }";

/// The pressure inside, which on a quarter pushes with itself times the radius in each direction.
Real pressure_inside(const Simulation& sim, Real rate) {
  const Vec3 force = sim.solver().boundaries()[0].force;
  return 0.5 * (force[0] + force[1]) / (a * std::exp(rate * sim.time()));
}

/// Hill's cylinder of metal without hardening, closed form at small strains: over the pressure at the outer displacement that it has.
Measured yielding(int cells) {
  constexpr Real E = 210e9, nu = 0.3, strength = 0.24e9, rate = 5e-3, dt = 0.02;
  Simulation sim(cylinder(
      fmt::format("{{ type = \"j2\", density = 7800, youngs_modulus = {}, poissons_ratio = {}, yield_stress = {} }}", E, nu, strength),
      k_elements, rate, dt, cells));
  const auto outer_radius = [&] {
    const std::vector<Real> x = sim.solver().node_field(0, "position").values;
    Real greatest = 0;
    for (std::size_t n = 0; n < x.size(); n += 2) greatest = std::max(greatest, std::hypot(x[n], x[n + 1]));
    return greatest;
  };
  const Real k = strength / std::sqrt(3.0);
  Measured measured;
  while (sim.time() < 1 - 1e-9) {
    sim.step();
    const Real c = std::min(b, std::sqrt((outer_radius() - b) * E * b / ((1 - nu * nu) * 2 * k)));  // as far as it yields
    if (c < a) continue;
    const Real over = pressure_inside(sim, rate) / (k * (1 - c * c / (b * b) + 2 * std::log(c / a)));
    if (std::abs(sim.time() - 0.4) < 0.5 * dt) measured["pressure_02"] = over;
    measured["pressure_05"] = over;
  }
  return measured;
}

/// Over Lame's solution.
Real elastic(Real nu, const std::string& body, int cells, std::shared_ptr<Layout> layout) {
  constexpr Real E = 1e6, rate = 1e-4;
  Case problem = cylinder(fmt::format("{{ type = \"neo_hookean\", density = 1, youngs_modulus = {}, poissons_ratio = {} }}", E, nu), body,
                          rate, 1, cells);
  if (layout) problem.bodies[0].layout = std::move(layout);
  Simulation sim(std::move(problem));
  const Real G = E / (2 * (1 + nu));
  const Real u = a * (std::exp(rate) - 1);
  const Real B = u / ((1 - 2 * nu) * a / (b * b) + 1 / a);
  sim.step();
  return pressure_inside(sim, rate) / (2 * G * B * (1 / (a * a) - 1 / (b * b)));
}

/// 3 x 3 particles in each cell, at the same distances in radius and angle.
std::shared_ptr<Layout> particles(int cells) {
  std::vector<Vec3> points;
  std::vector<Real> volumes;
  const int n = 3 * cells;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const Real r = a + (i + 0.5) * (b - a) / n, angle = (j + 0.5) * pi / 2 / n;
      points.push_back({r * std::cos(angle), r * std::sin(angle), 0});
      volumes.push_back(r * (b - a) / n * pi / 2 / n);
    }
  }
  return points_layout(points, volumes);
}

Measured nearly_incompressible() {
  Measured measured;
  for (const auto& [name, nu] : {std::pair("3", 0.3), std::pair("499", 0.499), std::pair("4999", 0.4999), std::pair("49999", 0.49999)}) {
    measured[std::string("elements_") + name] = elastic(nu, k_elements, 8, nullptr);
    measured[std::string("particles_") + name] =
        elastic(nu, "fbar = true\nlayout = { type = \"points\", positions = [[0.1, 0.1]], volumes = 1 }", 8, particles(8));
  }
  return measured;
}

}  // namespace

void add_yielding_cylinder(VerifySuite& suite) {
  const char* const source = "Hill 1950, at the same outer displacement";
  add_problem(suite,
              {"cylinder", "a thick cylinder of metal is widened, static", "materials", true, true, 1e7, {}, [] { return yielding(10); }},
              {within("pressure_02", 1, 0.015, fmt::format("{}, 0.2 mm", source)), within("pressure_05", 1, 0.015, "the same, 0.5 mm")});
}

void add_elastic_cylinder(VerifySuite& suite) {
  std::vector<VerifyRow> rows;
  for (const char* const body : {"elements_", "particles_"}) {
    for (const char* const nu : {"3", "499", "4999", "49999"}) rows.push_back(within(std::string(body) + nu, 1, 0.01, "Lame"));
  }
  add_problem(suite,
              {"implicit_cylinder", "a thick cylinder, nu to 0.49999", "implicit_cylinder", true, true, 1e6, {}, &nearly_incompressible},
              rows);
}

}  // namespace matpoint
