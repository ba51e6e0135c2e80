// Rigid tools: friction on a plate, tops, a gate that holds water, a box that floats and rights itself.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "case/case_file.hpp"
#include "explicit/rigid_motion.hpp"
#include "verify/materials.hpp"

namespace matpoint {
namespace {

constexpr Real pi = std::numbers::pi;

/// A number of the history of a tool, now.
Real number_of(const Simulation& sim, const std::string& name) {
  for (const StepNumber& number : sim.solver().step_numbers()) {
    if (number.name == name) return number.value;
  }
  return std::numeric_limits<Real>::quiet_NaN();
}

/// Of momentum that no book has, over what moved.
Real momentum_error(const Simulation& sim) {
  const Ledger& ledger = sim.solver().ledger();
  Real error = 0, size = 0;
  for (std::size_t d = 0; d < 3; ++d) {
    Real momentum = 0;
    for (std::size_t b = 0; b < sim.solver().body_count(); ++b) momentum += sim.solver().totals(b).momentum[d];
    const Real booked = sim.initial_momentum()[d] + ledger.gravity_impulse[d] + ledger.boundary_impulse[d];
    error = std::max(error, std::abs(momentum - booked));
    size = std::max({size, std::abs(momentum), std::abs(ledger.boundary_impulse[d])});
  }
  return error / size;
}

/// A block on a plate that is pulled away under it, without gravity's help along it: rubbing over pressing impulse, and what it has gained
/// over mu g t.
Measured pulled(int dim) {
  constexpr Real mu = 0.2, g = 10, end = 0.6;
  const bool is_3d = dim == 3;
  Simulation sim(default_case(
      "pulled",
      fmt::format("dim = {}\ngravity = {}\n[grid]\nupper = {}\ncell_size = {}\n[time]\nend = {}\n", dim, is_3d ? "[0, -10, 0]" : "[0, -10]",
                  is_3d ? "[2, 1, 0.6]" : "[2, 1]", is_3d ? 0.1 : 0.05, end) +
          fmt::format(
              "[[body]]\nname = \"block\"\nregion = {{ type = \"box\", lower = {}, upper = {} }}\nlayout = {{ type = \"per_cell\", count "
              "= {} }}\nmaterial = {{ type = \"neo_hookean\", density = 1000, youngs_modulus = 1e6, poissons_ratio = 0.3 }}\n",
              is_3d ? "[0.4, 0.3, 0.1]" : "[0.4, 0.3]", is_3d ? "[0.8, 0.5, 0.5]" : "[0.8, 0.5]", is_3d ? 8 : 4) +
          fmt::format("[[tool]]\nname = \"plate\"\nshape = {{ type = \"box\", lower = {}, upper = {} }}\nvelocity = {}\nfriction = 0.2\n",
                      is_3d ? "[-9, 0.1, -1]" : "[-9, 0.1]", is_3d ? "[9, 0.3, 2]" : "[9, 0.3]", is_3d ? "[5, 0, 0]" : "[5, 0]")));
  sim.run();
  const BoundaryTotals plate = sim.solver().boundaries()[0];
  const BodyTotals block = sim.solver().totals(0);
  const std::string name = is_3d ? "pulled_3d" : "pulled";
  const Real energy = block.kinetic_energy + block.strain_energy + block.gravitational_energy - sim.initial_energy();
  return {{name + "_friction", plate.impulse[0] / plate.impulse[1] / mu},
          {name + "_velocity", block.momentum[0] / block.mass / (mu * g * end)},
          {name + "_momentum", momentum_error(sim)},
          {name + "_energy_made", (energy + sim.solver().ledger().energy_spent()) / plate.work}};
}

/// Two tops in 3D, without particles: 100 turns.
Measured tops() {
  // A brick with three moments of inertia that turns about all axes.
  ToolSpec brick;
  brick.name = "brick";
  brick.shape = region_registry().read(*parse_toml("x = { type = \"box\", lower = [0, 0, 0], upper = [0.1, 0.2, 0.4] }", "x").find("x"),
                                       {3, ""}, "shape");
  brick.density = 1000;
  brick.angular_velocity = {3, 5, 2};
  RigidMotion top(brick, 3);
  const Vec3 L = top.angular_momentum();
  constexpr Real m = 8;
  const Vec3 moments{m / 12 * (0.04 + 0.16), m / 12 * (0.01 + 0.16), m / 12 * (0.01 + 0.04)};
  const Real E = top.kinetic_energy();
  Real worst_L = 0, worst_E = 0;
  constexpr Real dt = 1e-3;
  const Real rate = std::sqrt(38.0);
  for (int k = 0; k * dt * rate < 100 * 2 * pi; ++k) {
    top.advance(k * dt, dt, {}, {}, {});
    // That of the turn and its rate, and not the number that is kept.
    Vec3 now{};
    for (std::size_t a = 0; a < 3; ++a) {
      Vec3 axis{};
      axis[a] = 1;
      axis = top.turned(axis);
      const Real share = moments[a] * dot(axis, top.angular_velocity());
      for (std::size_t d = 0; d < 3; ++d) now[d] += share * axis[d];
    }
    for (std::size_t d = 0; d < 3; ++d) worst_L = std::max(worst_L, std::abs(now[d] - L[d]));
    worst_E = std::max(worst_E, std::abs(top.kinetic_energy() - E));
  }
  const Real size = std::sqrt(dot(L, L));
  // A cylinder that stands on its point and leans.
  ToolSpec heavy;
  heavy.name = "heavy";
  heavy.shape = region_registry().read(
      *parse_toml("x = { type = \"cylinder\", start = [0.1, 0, 0.2], end = [0.15, 0, 0.3], radius = 0.1 }", "x").find("x"), {3, ""},
      "shape");
  heavy.density = 1000;
  heavy.hinge = Vec3{0, 0, 0};
  const Real spin = 1000;
  const Vec3 axis{0.05 / std::hypot(0.05, 0.1), 0, 0.1 / std::hypot(0.05, 0.1)};
  heavy.angular_velocity = {spin * axis[0], 0, spin * axis[2]};
  RigidMotion leaning(heavy, 3);
  const Vec3 start = leaning.angular_momentum();
  const Real height = std::hypot(0.05, 0.1), lean = std::sqrt(dot(leaning.center(), leaning.center()));
  const Real round = 0.5 * leaning.mass() * 0.01, across = leaning.mass() * ((3 * 0.01 + height * height) / 12 + lean * lean);
  constexpr Real g = 9.81;
  const Real energy = leaning.kinetic_energy() + leaning.mass() * g * leaning.center()[2];
  Real worst_z = 0, worst_heavy = 0, turned = 0, last = 0;
  constexpr Real fine = 2e-5;
  int steps = 0;
  for (; steps * fine * spin < 100 * 2 * pi; ++steps) {
    leaning.advance(steps * fine, fine, {}, {}, {0, 0, -g});
    // Of its turn and its rate, too.
    const Vec3 a = leaning.turned(axis), w = leaning.angular_velocity();
    const Real along = dot(w, a);
    worst_z = std::max(worst_z, std::abs(round * along * a[2] + across * (w[2] - along * a[2]) - start[2]));
    worst_heavy = std::max(worst_heavy, std::abs(leaning.kinetic_energy() + leaning.mass() * g * leaning.center()[2] - energy));
    const Real angle = std::atan2(leaning.center()[1], leaning.center()[0]);
    turned += std::remainder(angle - last, 2 * pi);
    last = angle;
  }
  // The slow precession of a fast top: m g l / (I3 w).
  return {{"top_momentum", worst_L / size},
          {"top_energy", worst_E / E},
          {"heavy_top_momentum", worst_z / std::sqrt(dot(start, start))},
          {"heavy_top_energy", worst_heavy / energy},
          {"heavy_top_precession", turned / (steps * fine) / (leaning.mass() * g * lean / (round * spin))}};
}

/// Water behind a gate that is hinged at its foot: the moment of its spring, over rho g H^3 / 6, as a mean of the last two thirds.
Measured gate(int cells) {
  constexpr Real H = 0.5, spring = 1e5;
  Simulation sim(default_case(
      "gate",
      fmt::format("gravity = [0, -9.81]\n[grid]\nupper = [1.2, 0.8]\ncell_size = {}\n[time]\nend = 1.5\n", 1.0 / cells) +
          "[[body]]\nname = \"water\"\nregion = { type = \"box\", lower = [0, 0], upper = [0.8, 0.5] }\nlayout = { type = "
          "\"per_cell\", count = 4 }\nmaterial = { type = \"newtonian_fluid\", density = 1000, viscosity = 1e-3, pressure_scale = 1e5 }\n" +
          slip_sides({"left", "bottom"}) +
          fmt::format("[[tool]]\nname = \"gate\"\nshape = {{ type = \"box\", lower = [0.8, 0], upper = [0.9, 0.7] }}\nhinge = [0.8, "
                      "0]\ndensity = 100\nspring = {}\nspring_damping = 1e3\n",
                      spring)));
  Real sum = 0, time = 0;
  sim.add_callback([&](const Simulation& now) {
    if (now.time() < 0.5) return true;
    // Less what the gate weighs where it stands, on its half width.
    sum += -spring * number_of(now, "gate.turn") * now.last_dt();
    time += now.last_dt();
    return true;
  });
  sim.run();
  const Real weight = 100 * 0.1 * 0.7 * 9.81 * 0.05;
  Real leaked = 0;
  for (const Real x : component(sim, 0, "position", 0)) leaked += x > 0.95 ? 1 : 0;
  return {{"gate_moment", (sum / time - weight) / (1000 * 9.81 * H * H * H / 6)}, {"gate_leaked", leaked}};
}

/// A box of 0.6 of the density of water, in a tank three times as wide: how deep it lies, over what Archimedes says of the water's level,
/// and the tank's load, over all weights; means of the last third.
Measured floating(int cells) {
  constexpr Real H = 0.5, width = 0.4, height = 0.2, share = 0.6, draft = share * height;
  Simulation sim(default_case(
      "floating",
      fmt::format("gravity = [0, -9.81]\n[grid]\nupper = [1.2, 0.8]\ncell_size = {}\n[time]\nend = 3\n[solver]\ndamping = 2\n",
                  1.0 / cells) +
          fmt::format(
              "[[body]]\nname = \"water\"\nregion = {{ type = \"difference\", of = [{{ type = \"box\", lower = [0, 0], upper = [1.2, "
              "{}] }}, {{ type = \"box\", lower = [0.4, {}], upper = [0.8, 1] }}] }}\n",
              H, H - draft) +
          "layout = { type = \"per_cell\", count = 4 }\nmaterial = { type = \"newtonian_fluid\", density = 1000, viscosity = 1e-3, "
          "pressure_scale = 1e5 }\n" +
          slip_sides({"left", "right", "bottom"}) +
          fmt::format("[[tool]]\nname = \"box\"\nshape = {{ type = \"box\", lower = [0.4, {}], upper = [0.8, {}] }}\ndensity = {}\n",
                      H - draft, H - draft + height, 1000 * share)));
  Real depth = 0, push = 0, time = 0;
  sim.add_callback([&](const Simulation& now) {
    if (now.time() < 2) return true;
    depth += (H - (number_of(now, "box.position_y") - height / 2)) * now.last_dt();
    push -= sim.solver().boundaries().back().force[1] * now.last_dt();
    time += now.last_dt();
    return true;
  });
  sim.run();
  return {{"draft", depth / time / draft}, {"buoyancy", push / time / (1000 * share * width * height * 9.81)}};
}

}  // namespace

void add_tools(VerifySuite& suite) {
  const auto add = [&](const char* title, Real cost, std::function<Measured()> run, std::vector<VerifyRow> rows) {
    add_problem(suite, {"tools", title, "tools", true, true, cost, {}, std::move(run)}, std::move(rows));
  };
  for (const int dim : {2, 3}) {
    const std::string name = dim == 3 ? "pulled_3d" : "pulled";
    add(dim == 3 ? "a block on a plate that is pulled away, 3D" : "a block on a plate that is pulled away", 2e6,
        [dim] { return pulled(dim); },
        {within(name + "_friction", 1, 0.02, "Coulomb"), within(name + "_velocity", 1, 0.02, "mu g t"),
         at_most(name + "_momentum", 1e-10, "books"), at_most(name + "_energy_made", 0.005, "books")});
  }
  add("a gate that holds water", 5e6, [] { return gate(25); },
      {within("gate_moment", 1, 0.03, "rho g H^3 / 6"), at_most("gate_leaked", 0, "nothing passes")});
  add("a box that floats", 5e6, [] { return floating(25); },
      {within("draft", 1, 0.03, "Archimedes"), within("buoyancy", 1, 0.03, "its weight")});
  add("tops", 1e5, &tops,
      {at_most("top_momentum", 1e-10, "kept"), at_most("top_energy", 1e-4, "kept"), at_most("heavy_top_momentum", 1e-10, "kept"),
       at_most("heavy_top_energy", 1e-3, "kept"), within("heavy_top_precession", 1, 0.03, "m g l / (I w)")});
}

}  // namespace matpoint
