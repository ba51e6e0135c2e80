// Ground that stands or slides: a vertical cut, a slope, an infinite slope. What is strong enough settles while its weight comes and then
// rests; what is not goes on.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "verify/materials.hpp"

namespace matpoint {
namespace {

constexpr Real g = 9.81;

/// Way [m] of the particle that was nearest to a point, when all of the weight is there and at the end, which is as much later.
struct Way {
  Real settled = 0;
  Real end = 0;
};
Way way_of(Simulation& sim, const Vec3& point) {
  const std::vector<Real> start = sim.solver().field(0, "position").values;
  std::size_t nearest = 0;
  Real least = std::numeric_limits<Real>::infinity();
  for (std::size_t p = 0; 2 * p < start.size(); ++p) {
    const Real distance = std::hypot(start[2 * p] - point[0], start[2 * p + 1] - point[1]);
    if (distance < least) {
      least = distance;
      nearest = p;
    }
  }
  const auto way = [&] {
    const std::vector<Real> now = sim.solver().field(0, "position").values;
    return std::hypot(now[2 * nearest] - start[2 * nearest], now[2 * nearest + 1] - start[2 * nearest + 1]);
  };
  Way found;
  sim.run(nullptr, sim.problem().time.end / 2);
  found.settled = way();
  sim.run();
  found.end = way();
  return found;
}

/// A block 1 m high and 2 m wide of clay (Tresca) with a free side; N = rho g H/c. It stands up to N = 3.78 (limit analysis).
Way cut(Real N) {
  constexpr Real c = 1e3, T = 2;
  Simulation sim(default_case("cut", fmt::format(R"(
gravity = [0, {}]
gravity_times = [0, {}]
gravity_factors = [0, 1]
[grid]
upper = [4, 1.2]
cells = [40, 12]
[time]
end = {}
[[body]]
name = "clay"
region = {{ type = "box", lower = [0, 0], upper = [2, 1] }}
layout = {{ type = "per_cell", count = 4 }}
material = {{ type = "mohr_coulomb", density = {}, youngs_modulus = 1e6, poissons_ratio = 0.4, cohesion = {}, friction_angle = 0 }}
[[boundary]]
side = "bottom"
kind = "fixed"
)",
                                                 -g, T / 2, T, N * c / g, c) +
                                         slip_sides({"left"})));
  return way_of(sim, {2, 1, 0});
}

/// A slope of 2:1, 1 m high, phi = 20 degrees, c = 0.05 rho g H, both divided by F. It stands up to F = 1.38 to 1.40.
Way slope(Real F) {
  constexpr Real rho = 2000, T = 3, weight = rho * g;
  const Real phi = std::atan(std::tan(20 * std::numbers::pi / 180) / F) * 180 / std::numbers::pi;
  Simulation sim(default_case("slope", fmt::format(R"(
gravity = [0, {}]
gravity_times = [0, {}]
gravity_factors = [0, 1]
[grid]
upper = [6, 1.3]
cells = [60, 13]
[time]
end = {}
[[body]]
name = "ground"
region = {{ type = "polygon", vertices = [[1.5, 0], [6, 0], [6, 1], [3.5, 1]] }}
layout = {{ type = "per_cell", count = 4 }}
material = {{ type = "mohr_coulomb", density = {}, youngs_modulus = {}, poissons_ratio = 0.3, cohesion = {}, friction_angle = {} }}
[[boundary]]
side = "bottom"
kind = "fixed"
)",
                                                   -g, T / 2, T, rho, 500 * weight, 0.05 * weight / F, phi) +
                                           slip_sides({"right"})));
  return way_of(sim, {3.5, 1, 0});
}

/// A layer of depth h on 30 degrees, phi = 20 degrees, c = 0.1 rho g m, without dilatancy: what it holds along a plane is then not
/// c + sigma tan phi but (c + sigma tan phi) cos phi (Davis 1968), for its principal stresses turn while it slips. It stands up to 0.461 m.
struct Layer {
  Real growth = 0;        ///< Way of its top at the end over that when all of the weight was there.
  Real acceleration = 0;  ///< Over g (sin b - cos b sin phi) - c cos phi/(rho h).
};
Layer layer(Real h, int cells) {
  constexpr Real rho = 2000, T = 2, c = 0.1 * rho * g, b = 30 * std::numbers::pi / 180, phi = 20 * std::numbers::pi / 180;
  const Real dx = h / cells;
  Simulation sim(
      default_case("layer", fmt::format(R"(
gravity = [{}, {}]
gravity_times = [0, {}]
gravity_factors = [0, 1]
[grid]
upper = [{}, {}]
cells = [4, {}]
periodic = ["x"]
[time]
end = {}
[output]
fields = ["velocity", "displacement"]
[[body]]
name = "ground"
region = {{ type = "box", lower = [0, 0], upper = [{}, {}] }}
layout = {{ type = "per_cell", count = 4 }}
material = {{ type = "mohr_coulomb", density = {}, youngs_modulus = 1e7, poissons_ratio = 0.3, cohesion = {}, friction_angle = 20 }}
[[boundary]]
side = "bottom"
kind = "fixed"
)",
                                        g * std::sin(b), -g * std::cos(b), T / 2, 4 * dx, h + 3 * dx, cells + 3, T, 4 * dx, h, rho, c)));
  const auto top = [&](const char* name) {
    const std::vector<Real> x = component(sim, 0, name, 0);
    return *std::max_element(x.begin(), x.end());
  };
  sim.run(nullptr, T / 2);
  const Real settled = top("displacement");
  sim.run(nullptr, 0.75 * T);
  const Real speed = top("velocity"), time = sim.time();
  sim.run();
  const Real exact = g * (std::sin(b) - std::cos(b) * std::sin(phi)) - c * std::cos(phi) / (rho * h);
  return {top("displacement") / settled, (top("velocity") - speed) / (sim.time() - time) / exact};
}

}  // namespace

void add_slopes(VerifySuite& suite) {
  add_problem(
      suite,
      {"slopes",
       "a vertical cut in clay and a slope, which stand or slide",
       "materials",
       true,
       true,
       1.5e7,
       {},
       [] {
         Measured measured;
         for (const auto& [name, way] :
              {std::pair{"cut_3.4", cut(3.4)}, {"cut_4.2", cut(4.2)}, {"slope_1.3", slope(1.3)}, {"slope_1.5", slope(1.5)}})
           measured[name] = way.end / way.settled;
         return measured;
       }},
      {at_most("cut_3.4", 1.15, "N = rho g H/c = 3.4: it stands (limit analysis: up to 3.78); way at the end over that under the weight"),
       at_least("cut_4.2", 3, "N = 4.2: it fails"),
       at_most("slope_1.3", 1.1, "strength over 1.3: it stands (factor of safety 1.38 by Bishop's circles, 1.4 by Griffiths & Lane 1999)"),
       at_least("slope_1.5", 5, "strength over 1.5: it slides")});
  add_problem(suite,
              {"infinite_slope",
               "a layer on a slope of 30 degrees",
               "materials",
               true,
               true,
               1e7,
               {},
               [] {
                 return Measured{{"stands", layer(0.42, 16).growth},
                                 {"slides_16", layer(0.7, 16).acceleration},
                                 {"slides_32", layer(0.7, 32).acceleration}};
               }},
              {at_most("stands", 1.1, "0.42 m deep: it stands (up to 0.461 m); way at the end over that under the weight"),
               within("slides_16", 1, 0.08, "0.7 m deep, 16 cells: acceleration over the closed form"),
               within("slides_32", 1, 0.05, "32 cells: of first order, for what slips is a row of cells at the floor")});
}

}  // namespace matpoint
