// Loads on particles and on the ground: bars, cylinders and beams that they bend as the closed forms say, a plate that a pressure turns,
// and a column on a base that shakes.
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "verify/materials.hpp"

namespace matpoint {
namespace {

constexpr Real pi = std::numbers::pi;

std::string rubber(Real E, Real nu) {
  return fmt::format("material = {{ type = \"neo_hookean\", density = 1000, youngs_modulus = {}, poissons_ratio = {} }}\n", E, nu);
}
const char* const k_static = "[solver]\ntype = \"implicit\"\nmode = \"static\"\n";

/// Rows by particle of a vector field.
std::vector<Vec3> vectors(const Simulation& sim, const std::string& name) {
  const Field field = sim.solver().field(0, name);
  const auto dim = static_cast<std::size_t>(sim.solver().dim());
  std::vector<Vec3> rows(field.values.size() / dim, Vec3{});
  for (std::size_t k = 0; k < field.values.size(); ++k) rows[k / dim][k % dim] = field.values[k];
  return rows;
}

/// A bar without Poisson's effect whose end is pressed by a thousandth of its modulus: the displacement over p x / E, of the particles next
/// to the end. In dynamics the mean over two of its periods, for it swings about that.
Real pressed_bar(bool is_static, int dim, const std::string& load) {
  constexpr Real E = 1e6, p = 100;
  const Real period = 4 / std::sqrt(E / 1000);
  const bool is_3d = dim == 3;
  Simulation sim(default_case(
      "bar", fmt::format("dim = {}\ngravity = {}\n[grid]\nupper = {}\ncell_size = {}\n[time]\nend = {}\n{}", dim,
                         is_3d ? "[0, 0, 0]" : "[0, 0]", is_3d ? "[1.5, 0.2, 0.2]" : "[1.5, 0.2]", is_3d ? 0.1 : 0.05,
                         is_static ? 1 : 2 * period, is_static ? "dt = 1\n" + std::string(k_static) : "") +
                 fmt::format("[[body]]\nname = \"bar\"\nregion = {{ type = \"box\", lower = {}, upper = {} }}\nlayout = {{ type = "
                             "\"per_cell\", count = {} }}\n",
                             is_3d ? "[0, 0, 0]" : "[0, 0]", is_3d ? "[1, 0.2, 0.2]" : "[1, 0.2]", is_3d ? 8 : 4) +
                 rubber(E, 0) + (is_3d ? slip_sides({"left", "bottom", "top", "front", "back"}) : slip_sides({"left", "bottom", "top"})) +
                 "[[load]]\nbody = \"bar\"\nside = \"right\"\n" + load));
  const std::vector<Vec3> start = vectors(sim, "position");
  std::size_t end = 0;
  for (std::size_t q = 0; q < start.size(); ++q) end = start[q][0] > start[end][0] ? q : end;
  Real sum = 0;
  sim.add_callback([&](const Simulation& now) {
    sum += (vectors(now, "position")[end][0] - start[end][0]) * now.last_dt();
    return true;
  });
  sim.run();
  return sum / sim.time() / (-p * start[end][0] / E);
}

Measured bars() {
  const char* const pressure = "kind = \"pressure\"\npressure = 100\n";
  return {{"bar", pressed_bar(false, 2, pressure)},
          {"bar_3d", pressed_bar(false, 3, pressure)},
          {"bar_static", pressed_bar(true, 2, pressure)},
          {"bar_static_3d", pressed_bar(true, 3, pressure)},
          {"bar_traction", pressed_bar(true, 2, "kind = \"traction\"\ntraction = [-100, 0]\n")},
          {"bar_force", pressed_bar(true, 3, "kind = \"force\"\nforce = [-4, 0, 0]\n")}};
}

/// A tube under a pressure from inside, whose surface cuts the lattice of particles: the displacement over Lame's, mean of the particles in
/// the innermost tenth of the wall.
Measured tube(bool is_static, int cells) {
  constexpr Real E = 1e6, nu = 0.3, p = 100, a = 0.5, b = 1;
  Simulation sim(default_case(
      "tube",
      fmt::format("gravity = [0, 0]\n[grid]\nupper = [1.2, 1.2]\ncell_size = {}\n[time]\nend = {}\n{}", 1.0 / cells, is_static ? 1 : 0.5,
                  is_static ? "dt = 1\n" + std::string(k_static) : "[solver]\ndamping = 60\n") +
          "[[body]]\nname = \"tube\"\nlayout = { type = \"per_cell\", count = 9 }\nregion = { type = \"difference\", of = [\n"
          "  { type = \"disk\", center = [0, 0], radius = 1 }, { type = \"disk\", center = [0, 0], radius = 0.5 },\n"
          "  { type = \"half_space\", point = [0, 0], normal = [1, 0] }, { type = \"half_space\", point = [0, 0], normal = [0, 1] }] }\n" +
          rubber(E, nu) + slip_sides({"left", "bottom"}) +
          "[[load]]\nbody = \"tube\"\nkind = \"pressure\"\npressure = 100\nregion = { type = \"disk\", center = [0, 0], radius = 0.75 "
          "}\n"));
  const std::vector<Vec3> start = vectors(sim, "position");
  sim.run();
  const std::vector<Vec3> now = vectors(sim, "position");
  Real sum = 0;
  int count = 0;
  for (std::size_t q = 0; q < start.size(); ++q) {
    const Vec3& x = start[q];
    const Real r = std::hypot(x[0], x[1]);
    if (r > a + 0.1 * (b - a)) continue;
    const Real moved = ((now[q][0] - x[0]) * x[0] + (now[q][1] - x[1]) * x[1]) / r;
    sum += moved / ((1 + nu) / E * p * a * a / (b * b - a * a) * ((1 - 2 * nu) * r + b * b / r));
    ++count;
  }
  const std::string name = is_static ? "tube_static" : "tube";
  return {{name, sum / count}, {name + "_force", sim.solver().boundaries().back().force[0] / (p * a)}};
}

/// A hollow sphere under a pressure from inside, in rings around an axis.
Measured sphere(int cells) {
  constexpr Real E = 1e6, nu = 0.3, p = 100, a = 0.5, b = 1;
  Simulation sim(default_case(
      "sphere",
      fmt::format("gravity = [0, 0]\n[grid]\naxisymmetric = true\nupper = [1.2, 1.2]\ncell_size = {}\n[time]\nend = "
                  "0.5\n[solver]\ndamping = 60\n",
                  1.0 / cells) +
          "[[body]]\nname = \"sphere\"\nlayout = { type = \"per_cell\", count = 9 }\nregion = { type = \"difference\", of = [\n"
          "  { type = \"disk\", center = [0, 0], radius = 1 }, { type = \"disk\", center = [0, 0], radius = 0.5 },\n"
          "  { type = \"half_space\", point = [0, 0], normal = [0, 1] }] }\n" +
          rubber(E, nu) + slip_sides({"bottom"}) +
          "[[load]]\nbody = \"sphere\"\nkind = \"pressure\"\npressure = 100\nregion = { type = \"disk\", center = [0, 0], radius = 0.75 "
          "}\n"));
  const std::vector<Vec3> start = vectors(sim, "position");
  const std::vector<Real> mass = component(sim, 0, "mass", 0);
  sim.run();
  const std::vector<Vec3> now = vectors(sim, "position");
  Real sum = 0, weight = 0;
  for (std::size_t q = 0; q < start.size(); ++q) {
    const Vec3& x = start[q];
    const Real r = std::hypot(x[0], x[1]);
    if (r > a + 0.1 * (b - a)) continue;
    const Real moved = ((now[q][0] - x[0]) * x[0] + (now[q][1] - x[1]) * x[1]) / r;
    const Real closed = p * a * a * a / (E * (b * b * b - a * a * a)) * ((1 - 2 * nu) * r + (1 + nu) * b * b * b / (2 * r * r));
    sum += mass[q] * moved / closed;
    weight += mass[q];
  }
  return {{"sphere", sum / weight}, {"sphere_force", sim.solver().boundaries().back().force[1] / (p * pi * a * a)}};
}

/// A block in a corner under one pressure on all that is free: the greatest deviation of a stress from it, over it.
Real uneven(bool is_static, int dim) {
  constexpr Real p = 1000;
  const bool is_3d = dim == 3;
  Simulation sim(default_case(
      "block", fmt::format("dim = {}\ngravity = {}\n[grid]\nupper = {}\ncell_size = 0.1\n[time]\nend = {}\n{}", dim,
                           is_3d ? "[0, 0, 0]" : "[0, 0]", is_3d ? "[1, 1, 1]" : "[1, 1]", is_static ? 1.0 : 0.5,
                           is_static ? "dt = 1\n" + std::string(k_static) : "[solver]\ndamping = 100\n") +
                   fmt::format("[[body]]\nname = \"block\"\nregion = {{ type = \"box\", lower = {}, upper = {} }}\nlayout = {{ type = "
                               "\"per_cell\", count = {} }}\n",
                               is_3d ? "[0, 0, 0]" : "[0, 0]", is_3d ? "[0.65, 0.4, 0.55]" : "[0.65, 0.4]", is_3d ? 8 : 4) +
                   rubber(1e6, 0.25) + (is_3d ? slip_sides({"left", "bottom", "front"}) : slip_sides({"left", "bottom"})) +
                   "[[load]]\nbody = \"block\"\nkind = \"pressure\"\npressure = 1000\n"));
  sim.run();
  const std::vector<Real> stress = sim.solver().field(0, "stress").values;
  Real worst = 0;
  for (std::size_t k = 0; k < stress.size(); ++k) {
    const std::size_t i = k % 6;  // xx yy zz xy yz xz
    if (i == 2 && !is_3d) continue;
    worst = std::max(worst, std::abs(stress[k] / p + (i < 3 ? 1 : 0)));
  }
  return worst;
}

/// A beam that one load at its free end bends: over Timoshenko's deflection.
Real bent(int dim, const std::string& load) {
  constexpr Real E = 1e7, L = 1, H = 0.1, P = 1;
  const bool is_3d = dim == 3;
  const Real width = is_3d ? 0.1 : 1;
  Simulation sim(default_case(
      "beam", fmt::format("dim = {}\ngravity = {}\n[grid]\nlower = {}\nupper = {}\ncell_size = {}\n[time]\nend = 1\ndt = 1\n{}", dim,
                          is_3d ? "[0, 0, 0]" : "[0, 0]", is_3d ? "[0, 0, 0]" : "[0, 0]", is_3d ? "[1.1, 0.3, 0.3]" : "[1.1, 0.3]",
                          is_3d ? 0.025 : 0.0125, k_static) +
                  fmt::format("[[body]]\nname = \"beam\"\nregion = {{ type = \"box\", lower = {}, upper = {} }}\nlayout = {{ type = "
                              "\"per_cell\", count = {} }}\n",
                              is_3d ? "[0, 0.1, 0.1]" : "[0, 0.1]", is_3d ? "[1, 0.2, 0.2]" : "[1, 0.2]", is_3d ? 27 : 4) +
                  rubber(E, 0) + "[[boundary]]\nside = \"left\"\nkind = \"fixed\"\n" + load));
  const std::vector<Vec3> start = vectors(sim, "position");
  sim.run();
  const std::vector<Vec3> now = vectors(sim, "position");
  Real sum = 0;
  int count = 0;
  Real x_end = 0;
  for (const Vec3& x : start) x_end = std::max(x_end, x[0]);
  for (std::size_t q = 0; q < start.size(); ++q) {
    if (start[q][0] < x_end - 1e-9) continue;
    sum += start[q][1] - now[q][1];
    ++count;
  }
  const Real I = width * H * H * H / 12, G = E / 2;
  const Real deflection = P * x_end * x_end * (3 * L - x_end) / (6 * E * I) + P * x_end / (5.0 / 6 * G * H * width);
  return sum / count / deflection;
}

Measured beams() {
  return {
      {"beam", bent(2,
                    "[[load]]\nbody = \"beam\"\nkind = \"force\"\nforce = [0, -1]\nregion = { type = \"box\", lower = [0.99, 0], upper = "
                    "[1, 1] }\n")},
      {"beam_side", bent(2, "[[load]]\nbody = \"beam\"\nkind = \"force\"\nforce = [0, -1]\nside = \"right\"\n")},
      {"beam_3d", bent(3, "[[load]]\nbody = \"beam\"\nkind = \"force\"\nforce = [0, -1, 0]\nside = \"right\"\n")}};
}

/// A free plate that a pressure on one end of its lower face throws and turns: what its motion has gained over the work booked, and its
/// momentum over the impulse.
Measured turning(bool is_implicit) {
  Simulation sim(
      default_case("plate", std::string("gravity = [0, 0]\n[grid]\nupper = [3, 3]\ncell_size = 0.05\n[time]\nend = 0.3\n") +
                                (is_implicit ? "dt = 5e-4\n[solver]\ntype = \"implicit\"\n" : "") +
                                "[[body]]\nname = \"plate\"\nregion = { type = \"box\", lower = [1, 1], upper = [1.5, 1.25] "
                                "}\nlayout = { type = \"per_cell\", count = 4 }\n" +
                                rubber(1e6, 0.3) +
                                "[[load]]\nbody = \"plate\"\nkind = \"pressure\"\npressure = 500\nside = \"bottom\"\nregion = { type "
                                "= \"box\", lower = [0, 0], upper = [1.2, 3] }\ntimes = [0, 0.1]\nfactors = [0, 1]\n"));
  sim.run();
  const BodyTotals totals = sim.solver().totals(0);
  const BoundaryTotals load = sim.solver().boundaries()[0];
  const Real gained = totals.kinetic_energy + totals.strain_energy;
  Real error = 0, size = 0;
  for (std::size_t d = 0; d < 2; ++d) {
    error = std::max(error, std::abs(totals.momentum[d] - load.impulse[d]));
    size = std::max(size, std::abs(load.impulse[d]));
  }
  const Real closing = is_implicit ? gained + sim.solver().ledger().energy_spent() + load.work : gained;
  const std::string name = is_implicit ? "plate_implicit" : "plate";
  return {{name + "_energy", std::abs(closing / load.work - 1)}, {name + "_momentum", error / size}};
}

/// A column whose base shakes along it, without gravity.
struct Column {
  static constexpr Real E = 1e6, rho = 1000, H = 1;
  const Real first = pi / 2 * std::sqrt(E / rho) / H;  ///< Its lowest frequency [rad/s].
  void run(Real omega, Real end, const std::string& solver, const std::string& step, std::function<bool(const Simulation&)> see) const {
    std::string times, values;
    const Real dt = 2 * pi / omega / 200;
    for (int k = 0; k * dt < end + dt; ++k) {
      times += fmt::format("{}{}", k > 0 ? ", " : "", k * dt);
      values += fmt::format("{}[0, {}]", k > 0 ? ", " : "", std::sin(omega * k * dt));
    }
    Simulation sim(default_case(
        "column", fmt::format("gravity = [0, 0]\nbase_acceleration = [{}]\nbase_acceleration_times = [{}]\n[grid]\nupper = [0.2, "
                              "1.2]\ncell_size = 0.05\n[time]\nend = {}\n{}{}",
                              values, times, end, step, solver) +
                      "[[body]]\nname = \"column\"\nregion = { type = \"box\", lower = [0, 0], upper = [0.2, 1] }\nlayout = { type = "
                      "\"per_cell\", count = 4 }\n" +
                      rubber(E, 0) + slip_sides({"left", "right", "bottom"})));
    sim.add_callback(std::move(see));
    sim.run();
  }
};

/// With damping, after the start has died away: the amplitude of the top over that of the closed form.
Measured shaken() {
  const Column column;
  Measured measured;
  for (const auto& [name, share] : {std::pair("half", 0.5), std::pair("three_halves", 1.5), std::pair("five_halves", 2.5)}) {
    const Real omega = share * column.first, damping = 0.3 * column.first;
    const Real settled = 24 / damping, end = settled + 4 * 2 * pi / omega;
    std::complex<Real> amplitude = 0;
    std::size_t top = 0;
    Real start = -1, last = settled;
    column.run(omega, end, fmt::format("[solver]\ndamping = {}\n", damping), "", [&](const Simulation& now) {
      const std::vector<Vec3> x = vectors(now, "position");
      if (start < 0) {
        for (std::size_t q = 0; q < x.size(); ++q) top = x[q][1] > x[top][1] ? q : top;
        start = x[top][1];  // after a step, of next to no motion
      }
      if (now.time() < settled) return true;
      amplitude += (x[top][1] - start) * std::exp(std::complex<Real>(0, -omega * now.time())) * (now.time() - last);
      last = now.time();
      return true;
    });
    amplitude *= 2 / (last - settled);
    const std::complex<Real> square(omega * omega, -omega * damping);
    const std::complex<Real> k = std::sqrt(square / (Column::E / Column::rho));
    const Real depth = 0.0125;  // of the topmost particles
    const std::complex<Real> closed = (1.0 - std::cos(k * depth) / std::cos(k * Column::H)) / square;
    measured[name] = std::abs(amplitude) / std::abs(closed);
  }
  return measured;
}

/// Without damping, from rest: the rms error of the top's way in three of the lowest periods, over its rms, by the sum of modes.
Measured shaken_implicit() {
  const Column column;
  Measured measured;
  for (const auto& [name, share] : {std::pair("half", 0.5), std::pair("three_halves", 1.5), std::pair("five_halves", 2.5)}) {
    const Real omega = share * column.first, end = 3 * 2 * pi / column.first;
    Real error = 0, size = 0, start = -1;
    std::size_t top = 0;
    column.run(omega, end, "[solver]\ntype = \"implicit\"\n", fmt::format("dt = {}\n", end / 600), [&](const Simulation& now) {
      const std::vector<Vec3> x = vectors(now, "position");
      if (start < 0) {
        for (std::size_t q = 0; q < x.size(); ++q) top = x[q][1] > x[top][1] ? q : top;
        start = x[top][1];
      }
      Real closed = 0;
      for (int n = 1; n <= 50; ++n) {
        const Real beta = (2 * n - 1) * pi / 2 / Column::H, own = beta * std::sqrt(Column::E / Column::rho);
        const Real q = -2 / (beta * Column::H) * (std::sin(omega * now.time()) - omega / own * std::sin(own * now.time())) /
                       (own * own - omega * omega);
        closed += q * std::sin(beta * start);
      }
      error += std::pow(x[top][1] - start - closed, 2);
      size += closed * closed;
      return true;
    });
    measured[std::string(name) + "_implicit"] = std::sqrt(error / size);
  }
  return measured;
}

}  // namespace

void add_loads(VerifySuite& suite) {
  const auto add = [&](const char* title, Real cost, std::function<Measured()> run, std::vector<VerifyRow> rows) {
    add_problem(suite, {"loads", title, "loads", true, true, cost, {}, std::move(run)}, std::move(rows));
  };
  std::vector<VerifyRow> of_bars;
  for (const char* const bar : {"bar", "bar_3d", "bar_static", "bar_static_3d", "bar_traction", "bar_force"})
    of_bars.push_back(within(bar, 1, 0.01, "p x / E"));
  add("a bar under a pressure, traction or force on its end", 3e6, &bars, of_bars);
  add("a tube under pressure from inside, static", 1e6, [] { return tube(true, 20); },
      {within("tube_static", 1, 0.02, "Lame"), within("tube_static_force", 1, 0.01, "p a")});
  add("a tube under pressure from inside", 2e6, [] { return tube(false, 20); },
      {within("tube", 1, 0.02, "Lame"), within("tube_force", 1, 0.01, "p a")});
  add("a hollow sphere under pressure from inside", 2e6, [] { return sphere(20); },
      {within("sphere", 1, 0.02, "Lame"), within("sphere_force", 1, 0.01, "p pi a^2")});
  add("a block under one pressure all around", 1e6,
      [] {
        return Measured{{"uneven", uneven(false, 2)}, {"uneven_static", uneven(true, 2)}, {"uneven_static_3d", uneven(true, 3)}};
      },
      {at_most("uneven", 0.05, "-p"), at_most("uneven_static", 1e-3, "-p"), at_most("uneven_static_3d", 1e-3, "-p")});
  add("a beam with a load at its end", 1e6, &beams,
      {within("beam", 1, 0.01, "Timoshenko"), within("beam_side", 1, 0.01, "Timoshenko"), within("beam_3d", 1, 0.01, "Timoshenko")});
  add("a plate that a pressure turns", 2e6, [] { return turning(false); },
      {at_most("plate_energy", 0.01, "work of the load"), at_most("plate_momentum", 1e-10, "impulse of the load")});
  add("a plate that a pressure turns, implicit", 2e6, [] { return turning(true); },
      {at_most("plate_implicit_energy", 1e-6, "work of the load"), at_most("plate_implicit_momentum", 1e-8, "impulse of the load")});
  add("a column on a shaken base", 3e6, &shaken,
      {within("half", 1, 0.02, "transfer function"), within("three_halves", 1, 0.02, "the same"),
       within("five_halves", 1, 0.02, "the same")});
  add("a column on a shaken base, implicit", 2e6, &shaken_implicit,
      {at_most("half_implicit", 0.02, "sum of modes"), at_most("three_halves_implicit", 0.02, "the same"),
       at_most("five_halves_implicit", 0.02, "the same")});
}

}  // namespace matpoint
