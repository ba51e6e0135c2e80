// Bodies of particles in contact with each other in the implicit solver: Hertz, Coulomb, collisions as the explicit solver has them; and
// layers in one field.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "verify/analytic.hpp"

namespace matpoint {
namespace {

constexpr Real k_modulus = 1e6, k_poisson = 0.3;

/// A quarter of a disk of radius 0.5 in rings with square pieces: its middle at the bottom left of the grid, or at its top left, `top`
/// above.
std::string quarter_disk(const char* name, bool is_upper, Real spacing, Real top = 1) {
  std::string positions, volumes;
  const int rings = static_cast<int>(std::lround(0.5 / spacing));
  const Real width = 0.5 / rings;
  for (int i = 0; i < rings; ++i) {
    const Real r = (i + 0.5) * width;
    const int count = std::max(1, static_cast<int>(std::lround(0.5 * std::numbers::pi * r / width)));
    for (int j = 0; j < count; ++j) {
      const Real angle = (j + 0.5) * 0.5 * std::numbers::pi / count;
      const Real y = r * std::cos(angle);
      positions += fmt::format("[{}, {}], ", r * std::sin(angle), is_upper ? top - y : y);
      volumes += fmt::format("{}, ", r * width * 0.5 * std::numbers::pi / count);
    }
  }
  return fmt::format(R"(
[[body]]
name = "{}"
layout = {{ type = "points", positions = [{}], volumes = [{}] }}
material = {{ type = "neo_hookean", density = 1000, youngs_modulus = {}, poissons_ratio = {} }}
)",
                     name, positions, volumes, k_modulus, k_poisson);
}

/// sigma_yy at the distance x from the middle of a contact of half-width a under the force P, in the depth z (McEwen 1949; Johnson 1985,
/// eq. 4.49).
Real hertz_stress(Real P, Real a, Real x, Real z) {
  const Real sum = a * a - x * x + z * z;
  const Real root = std::sqrt(sum * sum + 4 * x * x * z * z);
  const Real m2 = 0.5 * (root + sum), n2 = 0.5 * (root - sum);
  return -2 * P / (std::numbers::pi * a * a) * std::sqrt(m2) * (1 - (z * z + n2) / (m2 + n2));
}

/// Two disks between planes of symmetry, of which the upper one comes nearer by `way` in one load step; or one of them on a side that lets
/// go, which is such a plane, too.
Measured hertz(const std::string& which, int cells, Real way, bool is_on_side = false) {
  const Real spacing = 0.5 / cells, height = is_on_side ? 0.5 : 1;
  Simulation sim(
      case_from_text("hertz", fmt::format(R"(
[grid]
upper = [0.6, {}]
cells = [{}, {}]
[time]
end = 1
dt = 1
[solver]
type = "implicit"
mode = "static"
{}
[[boundary]]
side = "left"
[[boundary]]
side = "bottom"
{}
[[boundary]]
side = "top"
kind = "velocity"
components = ["y"]
velocity = [0, {}]
)",
                                          height, cells * 6 / 10, is_on_side ? cells / 2 : cells, is_on_side ? "" : "contact = \"pairs\"",
                                          is_on_side ? "contact = \"no_tension\"" : "", -way) +
                                  (is_on_side ? "" : quarter_disk("low", false, spacing)) + quarter_disk("high", true, spacing, height)));
  sim.run();
  const Real P = 2 * sim.solver().boundaries()[1].force[1];
  if (is_on_side) way *= 2;
  const Real plane = (1 - k_poisson * k_poisson) / k_modulus;
  const Real a = std::sqrt(4 * P * 0.25 * 2 * plane / std::numbers::pi);
  // Of a disk between two others, half of it for each half (Johnson 1985, eq. 5.57).
  const Real approach = 2 * P * plane / std::numbers::pi * (2 * std::log(4 * 0.5 / a) - 1);
  // The half-width whose stresses are those of the third row of particles and the fourth: force enters over two.
  const std::vector<Real> x = component(sim, 0, "position", 0), y = component(sim, 0, "position", 1);
  const std::vector<Real> stress = component(sim, 0, "stress", 1);
  Real top = 0, greatest = 0, least = 0;
  for (std::size_t p = 0; p < x.size(); ++p) {
    if (x[p] < spacing) top = is_on_side ? 0 : std::max(top, y[p] + 0.5 * spacing);
    greatest = std::max(greatest, stress[p]);
    least = std::min(least, stress[p]);
  }
  const auto misfit = [&](Real half_width) {
    Real sum = 0;
    for (std::size_t p = 0; p < x.size(); ++p) {
      const Real z = is_on_side ? y[p] : top - y[p];
      if (x[p] > 2 * a || z < 2.7 * spacing || z > 4.2 * spacing) continue;
      const Real difference = hertz_stress(P, half_width, x[p], z) - stress[p];
      sum += difference * difference;
    }
    return sum;
  };
  Real low = 0.5 * a, high = 2 * a;
  while (high - low > 1e-6 * a) {
    const Real one = low + 0.382 * (high - low), other = low + 0.618 * (high - low);
    (misfit(one) < misfit(other) ? high : low) = misfit(one) < misfit(other) ? other : one;
  }
  return {{"hertz_half_width_" + which, low / a}, {"hertz_approach_" + which, way / approach}, {"hertz_pull_" + which, -greatest / least}};
}

/// A block glued to the top of the grid, pressed on one that is glued to the bottom, and pushed: force along over force across, from when
/// it slips.
/// Of particles on B-splines; or, where `elements` names one of the two or both, with that as a body of elements.
Real push(int dim, const char* cell_size, Real friction, const std::string& elements = "") {
  const bool is_3d = dim == 3;
  const auto body = [&](const char* name, const char* lower, const char* upper, const char* y0, const char* y1) {
    return fmt::format(R"(
[[body]]
name = "{}"
region = {{ type = "box", lower = [{}, {}{}], upper = [{}, {}{}] }}
{}
material = {{ type = "neo_hookean", density = 1000, youngs_modulus = 1e6, poissons_ratio = 0.3 }}
)",
                       name, lower, y0, is_3d ? ", 0.1" : "", upper, y1, is_3d ? ", 0.5" : "",
                       elements.find(name) != std::string::npos ? "method = \"elements\""
                       : is_3d                                  ? "layout = { type = \"per_cell\", count = 8 }"
                                                                : "layout = { type = \"per_cell\", count = 4 }");
  };
  const std::string z = is_3d ? ", 0" : "";
  Simulation sim(case_from_text("push", fmt::format(R"(
dim = {}
gravity = [0, 0{}]
[grid]
upper = [1.2, 0.4{}]
cell_size = {}
[time]
end = 1
dt = 0.05
[solver]
type = "implicit"
mode = "static"
contact = "pairs"
{}friction = {}
[[boundary]]
side = "bottom"
kind = "fixed"
attached = true
[[boundary]]
side = "top"
kind = "velocity"
velocity = [0.1, -0.004{}]
attached = true
)",
                                                    dim, z, is_3d ? ", 0.6" : "", cell_size,
                                                    elements.empty() ? "" : "basis = \"element\"\nelement_order = 1\n", friction, z) +
                                            body("low", "0.1", "1.1", "0", "0.2") + body("high", "0.3", "0.7", "0.2", "0.4")));
  Real along = 0, across = 0;
  sim.add_callback([&](const Simulation& now) {
    if (now.time() < 0.15) return true;
    along -= now.solver().boundaries()[0].force[0];
    across += now.solver().boundaries()[0].force[1];
    return true;
  });
  sim.run();
  return along / across;
}

struct Collision {
  Real speed = 0;     ///< Of the disks after it; 1 before.
  Real gain = 0;      ///< Of energy, over that at the start.
  Real momentum = 0;  ///< Greatest, over that of one disk.
};

Collision collide(const std::string& solver, const char* modulus, int count) {
  std::string text = fmt::format(R"(
gravity = [0, 0]
[grid]
upper = [1.5, 1]
cell_size = 0.025
[time]
end = 0.3
{}
)",
                                 solver);
  for (const char* disk :
       {"one\"\nregion = { type = \"disk\", center = [0.5, 0.5], radius = 0.2 }\nvelocity = { type = \"uniform\", value = [1, 0] }",
        "other\"\nregion = { type = \"disk\", center = [1, 0.5], radius = 0.2 }\nvelocity = { type = \"uniform\", value = [-1, 0] }"}) {
    text += fmt::format(
        "[[body]]\nname = \"{}\nlayout = {{ type = \"per_cell\", count = {} }}\n"
        "material = {{ type = \"neo_hookean\", density = 1000, youngs_modulus = {}, poissons_ratio = 0.3 }}\n",
        disk, count, modulus);
  }
  Simulation sim(case_from_text("collide", text));
  const Real one = sim.solver().totals(0).momentum[0];
  Collision found;
  sim.add_callback([&](const Simulation& now) {
    found.gain = std::max(found.gain, (energy(now) + now.solver().ledger().contact_energy) / now.initial_energy() - 1);
    found.momentum = std::max(found.momentum, std::abs(momentum(now)[0]) / one);
    return true;
  });
  sim.run();
  found.speed = -sim.solver().totals(0).momentum[0] / one;
  return found;
}

/// Settlement of the top of a column of two layers, and the mean stresses in them, over those of the closed form; and the reaction over the
/// weight.
Measured layers(int dim) {
  const Real g = 0.01, a = 0.5;
  std::string text = fmt::format(R"(
dim = {}
gravity = [0, {}{}]
[grid]
upper = [0.5, 1{}]
cell_size = 0.25
[time]
end = 1
dt = 1
[solver]
type = "implicit"
mode = "static"
basis = "element"
[[boundary]]
side = "bottom"
kind = "fixed"
)",
                                 dim, -g, dim == 3 ? ", 0" : "", dim == 3 ? ", 0.5" : "");
  const auto layer = [&](const char* name, Real from, Real to, Real density, Real E, Real nu) {
    text += fmt::format(R"([[body]]
name = "{}"
region = {{ type = "box", lower = [0, {}{}], upper = [0.5, {}{}] }}
layout = {{ type = "per_cell", count = {} }}
material = {{ type = "neo_hookean", density = {}, youngs_modulus = {}, poissons_ratio = {} }}
)",
                        name, from, dim == 3 ? ", 0" : "", to, dim == 3 ? ", 0.5" : "", dim == 3 ? 216 : 100, density, E, nu);
  };
  layer("low", 0, a, 2000, 1e6, 0.3);
  layer("top", a, 1, 1500, 4e6, 0.2);
  for (const char* side : {"left", "right", "front", "back"}) {
    if (dim == 3 || side[0] == 'l' || side[0] == 'r') text += fmt::format("[[boundary]]\nside = \"{}\"\n", side);
  }
  const auto modulus = [](Real E, Real nu) { return E * (1 - nu) / ((1 + nu) * (1 - 2 * nu)); };
  const Real low = modulus(1e6, 0.3), top = modulus(4e6, 0.2);
  Simulation sim(case_from_text("layers", text));
  const std::vector<Real> X = component(sim, 1, "position", 1);
  sim.run();
  const std::vector<Real> x = component(sim, 1, "position", 1);
  const std::string name = fmt::format("_{}d", dim);
  Measured measured;
  Real highest = 0, settlement = 0;
  Real& error = measured["layers_profile" + name];
  const Real way_low = g * (2000 * a * a / 2 + 1500 * (1 - a) * a) / low;
  const Real whole = way_low + g * 1500 * (1 - a) * (1 - a) / 2 / top;
  for (std::size_t p = 0; p < X.size(); ++p) {
    const Real y = X[p] - a;
    const Real right = way_low + g * 1500 * ((1 - a) * y - y * y / 2) / top;
    error = std::max(error, std::abs(X[p] - x[p] - right) / whole);
    if (y > highest) {
      highest = y;
      settlement = (X[p] - x[p]) / right;
    }
  }
  measured["layers_settlement" + name] = settlement;
  const Real right[2] = {g * (2000 * a / 2 + 1500 * (1 - a)), g * 1500 * (1 - a) / 2};
  for (std::size_t body : {0, 1}) {
    const std::vector<Real> stress = component(sim, body, "stress", 1);
    Real sum = 0;
    for (const Real one : stress) sum -= one;
    measured[(body == 0 ? "layers_stress_low" : "layers_stress_top") + name] = sum / static_cast<Real>(stress.size()) / right[body];
  }
  measured["layers_reaction" + name] =
      sim.solver().boundaries()[0].force[1] / (g * (sim.solver().totals(0).mass + sim.solver().totals(1).mass));
  return measured;
}

std::vector<VerifyRow> layer_rows(int dim) {
  const std::string name = fmt::format("_{}d", dim), law = "closed form of a column between slip sides";
  return {within("layers_settlement" + name, 1, 1e-3, law), at_most("layers_profile" + name, 1e-3, law),
          within("layers_stress_low" + name, 1, 1e-3, law), within("layers_stress_top" + name, 1, 1e-3, law),
          within("layers_reaction" + name, 1, 1e-8, "weight")};
}

}  // namespace

void add_implicit_contact(VerifySuite& suite) {
  const auto add = [&](const std::string& name, bool is_quick, double cost, std::function<Measured()> run, std::vector<VerifyRow> rows) {
    add_problem(suite, {"implicit_contact", name, "", is_quick, true, cost, {}, std::move(run)}, std::move(rows));
  };
  // At the free surface beside the contact particles are stretched along it, the more the coarser they are.
  const auto hertz_rows = [](const std::string& which, Real pull = 0.02) {
    return std::vector<VerifyRow>{within("hertz_half_width_" + which, 1, 0.04, "Hertz"),
                                  within("hertz_approach_" + which, 1, 0.03, "Johnson 1985, eq. 5.57"),
                                  at_most("hertz_pull_" + which, pull, "nothing pulls; of the greatest pressure")};
  };
  add(
      "disks pressed together", true, 1e6, [] { return hertz("80", 80, 0.0153); }, hertz_rows("80"));
  add(
      "disks pressed together, 160 cells", false, 1e7, [] { return hertz("160", 160, 0.006); }, hertz_rows("160"));
  add(
      "a disk pressed on a side", true, 1e6, [] { return hertz("side", 80, 0.00765, true); }, hertz_rows("side", 0.03));
  add("a block pushed over another", true, 2e6,
      [] {
        return Measured{{"push_mu0.3", push(2, "0.025", 0.3)}};
      },
      {within("push_mu0.3", 0.3, 0.005 * 0.3, "Coulomb's law")});
  add("a block pushed over another in 3D", false, 1e8,
      [] {
        return Measured{{"push_mu0.3_3d", push(3, "0.05", 0.3)}};
      },
      {within("push_mu0.3_3d", 0.3, 0.02 * 0.3, "Coulomb's law")});
  add("a block pushed over another, of which one or both are elements", true, 1e7,
      [] {
        return Measured{{"push_elements_on_particles", push(2, "0.05", 0.3, "high")},
                        {"push_particles_on_elements", push(2, "0.05", 0.3, "low")},
                        {"push_elements_on_elements", push(2, "0.05", 0.3, "high low")}};
      },
      {within("push_elements_on_particles", 0.3, 0.005 * 0.3, "Coulomb's law"),
       within("push_particles_on_elements", 0.3, 0.005 * 0.3, "Coulomb's law"),
       within("push_elements_on_elements", 0.3, 0.005 * 0.3, "Coulomb's law")});
  add("a block of elements pushed over another in 3D", false, 1e8,
      [] {
        return Measured{{"push_elements_on_elements_3d", push(3, "0.1", 0.3, "high low")}};
      },
      {within("push_elements_on_elements_3d", 0.3, 0.02 * 0.3, "Coulomb's law")});
  add("disks that collide", true, 5e7,
      [] {
        Measured measured;
        const Collision fast = collide("[solver]\ncontact = \"pairs\"", "1e7", 4);
        const Collision slow = collide("dt = 1e-3\n[solver]\ntype = \"implicit\"\ncontact = \"pairs\"", "1e7", 4);
        const Collision rubbing = collide("dt = 1e-3\n[solver]\ntype = \"implicit\"\ncontact = \"pairs\"\nfriction = 0.3", "1e5", 4);
        measured["rebound_over_explicit_E1e7"] = slow.speed / fast.speed;
        measured["collision_energy_gain"] = std::max(slow.gain, rubbing.gain);
        measured["collision_momentum"] = std::max(slow.momentum, rubbing.momentum);
        return measured;
      },
      {within("rebound_over_explicit_E1e7", 1, 0.01, "the explicit solver with pairs, same cells and particles"),
       at_most("collision_energy_gain", 0.005, "what pushes only makes no energy"), at_most("collision_momentum", 1e-10, "conserved")});
  add(
      "layers in one field", true, 1e6, [] { return layers(2); }, layer_rows(2));
  add(
      "layers in one field in 3D", true, 2e6, [] { return layers(3); }, layer_rows(3));
}

}  // namespace matpoint
