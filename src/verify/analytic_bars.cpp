// Waves in elastic bars, nu = 0: the axial vibration of a bar, one particle between two nodes, two bars that collide.
//
// The discrete problem has closed forms, too. Equal cells of size h with n particles each carry a wave sin(b x); one step maps the
// particles' velocities to the nodes and the nodes' accelerations back, and both together multiply the wave by
//
//   S = cos^2(b h / 2)                 one particle in the middle of the cell
//   S = 0.625 + 0.375 cos(b h)         two at a quarter and three quarters
//
// while the internal forces are those of linear finite elements with lumped mass, (2 c / h)^2 sin^2(b h / 2). So for small dt FLIP
// oscillates with w_h = (2 c / h) sin(b h / 2) sqrt(S), which is below w = b c by (b h)^2 / 6 for one particle and by 0.135 (b h)^2 for
// two; and PIC multiplies velocities by S in every step. Both hold as long as no particle changes its cell.
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "verify/analytic.hpp"

namespace matpoint {
namespace {

constexpr Real k_pi = std::numbers::pi;
constexpr Real k_length = 25;  // [m]
constexpr Real k_speed = 10;   // sqrt(E / rho) [m/s]

/// b of a mode [rad/m].
Real wave_number(int mode) { return (2 * mode - 1) * k_pi / (2 * k_length); }

/// w_h of the discrete bar with one particle per cell [rad/s].
Real discrete_frequency(int cells, int mode) {
  const Real h = k_length / cells;
  return k_speed / h * std::sin(wave_number(mode) * h);
}

struct BarOptions {
  int cells = 25;
  int mode = 1;
  Real v0 = 0.1;  ///< [m/s]
  Real periods = 3;
  Real steps_per_period = 2000;
  Sets sets;  ///< Further changes of the case.
};

Case bar_case(const BarOptions& options) {
  const Real h = k_length / options.cells;
  const Real period = 2 * k_pi / (k_speed * wave_number(options.mode));
  Sets sets = {fmt::format("grid.upper=[{:.17g},{:.17g}]", h * (options.cells + 1), h),
               fmt::format("grid.cells=[{},1]", options.cells + 1),
               fmt::format("body.bar.region.upper=[25,{:.17g}]", h),
               fmt::format("body.bar.velocity.value=[{:.17g},0]", options.v0),
               fmt::format("body.bar.velocity.wave_vector=[{:.17g},0]", wave_number(options.mode)),
               fmt::format("time.dt={:.17g}", period / options.steps_per_period),
               fmt::format("time.end={:.17g}", options.periods * period)};
  sets.insert(sets.end(), options.sets.begin(), options.sets.end());
  return load_case("bar", sets);
}

struct BarMotion {
  Real period = 0;               ///< [s]
  Real velocity_error = 0;       ///< Greatest error of the centre of mass' velocity over its amplitude [1].
  Real energy_ratio = 0;         ///< Energy at the end over that of the start [1].
  std::vector<Real> velocities;  ///< Of the centre of mass after each step [m/s].
};

BarMotion bar_motion(const BarOptions& options) {
  Simulation sim(bar_case(options));
  const Real w = k_speed * wave_number(options.mode);
  const Real amplitude = options.v0 / (wave_number(options.mode) * k_length);  // the mean of sin(b x): 0.636620 v0 for mode 1
  BarMotion motion;
  ZeroCrossings crossings;
  every(sim, 1, [&](const Simulation& s) {
    const BodyTotals bar = s.solver().totals(0);
    const Real v = bar.momentum[0] / bar.mass;
    crossings.include(s.time(), v);
    motion.velocity_error = std::max(motion.velocity_error, std::abs(v - amplitude * std::cos(w * s.time())) / amplitude);
    motion.velocities.push_back(v);
  });
  sim.run();
  motion.period = crossings.period();
  motion.energy_ratio = energy(sim) / sim.initial_energy();
  return motion;
}

Measured first_mode() {
  BarOptions options;
  const BarMotion coarse = bar_motion(options);
  options.cells = 50;
  const BarMotion fine = bar_motion(options);
  return {{"period_mode1_25_cells", coarse.period},
          {"period_mode1_50_cells", fine.period},
          {"velocity_error_ratio_mode1", coarse.velocity_error / fine.velocity_error},
          {"velocity_error_mode1_25_cells", coarse.velocity_error},
          {"velocity_error_mode1_50_cells", fine.velocity_error},
          {"energy_ratio_mode1_flip", fine.energy_ratio}};
}

Measured tenth_mode(const std::vector<int>& cells) {
  Measured m;
  const Real w = k_speed * wave_number(10);
  Real last_error = 0;
  for (const int n : cells) {
    BarOptions options;
    options.cells = n;
    options.mode = 10;
    options.periods = 10;
    options.steps_per_period = 500;
    const BarMotion motion = bar_motion(options);
    const Real error = 1 - 2 * k_pi / motion.period / w;
    m[fmt::format("frequency_mode10_{}_cells", n)] = 2 * k_pi / motion.period;
    if (last_error != 0) m[fmt::format("frequency_error_ratio_mode10_{}_cells", n)] = last_error / error;
    if (n == cells.back()) m[fmt::format("energy_ratio_mode10_{}_cells", n)] = motion.energy_ratio;
    last_error = error;
  }
  return m;
}

/// The same bar with other schemes: what they do to the energy in one period.
Measured schemes() {
  BarOptions options;
  options.periods = 1;
  options.steps_per_period = 500;
  Measured m;
  for (const std::string order : {"usl", "usf", "musl"}) {
    options.sets = {"solver.stress_order=" + order};
    m["energy_ratio_mode1_" + order] = bar_motion(options).energy_ratio;
  }
  options.sets = {"solver.flip=0"};
  m["energy_ratio_mode1_pic"] = bar_motion(options).energy_ratio;
  return m;
}

/// The bar with a square section in 3D, its four long sides slip walls or periodic, against the 2D one.
Measured bar_3d() {
  BarOptions options;
  options.periods = 1;
  options.steps_per_period = 500;
  const std::vector<Real> flat = bar_motion(options).velocities;
  const auto difference = [&](bool is_periodic) {
    const Case problem = bar_case(options);
    const std::string text =
        fmt::format(R"(
dim = 3
boundary = [{{ side = "left", kind = "fixed", components = ["x"] }}{}]
[grid]
upper = [26, 1, 1]
cells = [26, 1, 1]
{}
[time]
dt = {:.17g}
end = {:.17g}
[solver]
stress_order = "usl"
[[body]]
name = "bar"
region = {{ type = "box", lower = [0, 0, 0], upper = [25, 1, 1] }}
layout = {{ type = "per_cell", count = 1 }}
velocity = {{ type = "sine", value = [0.1, 0, 0], wave_vector = [{:.17g}, 0, 0] }}
material = {{ type = "neo_hookean", density = 1, youngs_modulus = 100, poissons_ratio = 0 }}
)",
                    is_periodic ? "" : R"(, { side = "bottom", kind = "slip" }, { side = "top", kind = "slip" },
  { side = "front", kind = "slip" }, { side = "back", kind = "slip" })",
                    is_periodic ? "periodic = [\"y\", \"z\"]" : "", *problem.time.dt, problem.time.end, wave_number(1));
    Simulation sim(case_from_text("bar_3d", text));
    Real worst = 0;
    every(sim, 1, [&](const Simulation& s) {
      const BodyTotals bar = s.solver().totals(0);
      worst = std::max(worst, std::abs(bar.momentum[0] / bar.mass - flat.at(static_cast<std::size_t>(s.step_count() - 1))));
    });
    sim.run();
    return worst / options.v0;
  };
  return {{"difference_3d_slip", difference(false)}, {"difference_3d_periodic", difference(true)}};
}

// --- one particle between two nodes ----------------------------------------------------------------------------------
constexpr const char* k_oscillator = R"(
[grid]
upper = [1, 1]
cells = [1, 1]
[time]
dt = 0.001
end = 10
[solver]
stress_order = "usl"
[[body]]
name = "particle"
region = { type = "box", upper = [1, 1], lower = [0, 0] }
layout = { type = "per_cell", count = 1 }
velocity = { type = "uniform", value = [0.1, 0] }
material = { type = "neo_hookean", density = 1, youngs_modulus = 39.47841760435743, poissons_ratio = 0 }
[[boundary]]
side = "left"
kind = "fixed"
components = ["x"]
[[boundary]]
side = "bottom"
kind = "slip"
[[boundary]]
side = "top"
kind = "slip"
)";

Measured oscillator() {
  Measured m;
  for (const std::string order : {"usl", "musl"}) {
    Simulation sim(case_from_text("one_particle", k_oscillator, {"solver.stress_order=" + order}));
    ZeroCrossings crossings;
    Range velocity;
    every(sim, 1, [&](const Simulation& s) {
      const BodyTotals particle = s.solver().totals(0);
      crossings.include(s.time(), particle.momentum[0]);
      velocity.include(particle.momentum[0]);
    });
    sim.run();
    m["period_" + order] = crossings.period();
    m["velocity_amplitude_" + order] = -velocity.least;
  }
  return m;
}

// --- two bars collide ------------------------------------------------------------------------------------------------
constexpr const char* k_colliding_bars = R"(
[solver]
stress_order = "musl"
[grid]
upper = [1, 1]
cells = [1, 1]
[time]
dt = 0.001
end = 4
[[body]]
name = "left"
region = { type = "box", lower = [0, 0], upper = [1, 1] }
layout = { type = "per_cell", count = [2, 1] }
velocity = { type = "uniform", value = [0.1, 0] }
material = { type = "neo_hookean", density = 1, youngs_modulus = 100, poissons_ratio = 0 }
[[body]]
name = "right"
region = { type = "box", lower = [0, 0], upper = [1, 1] }
layout = { type = "per_cell", count = [2, 1] }
velocity = { type = "uniform", value = [-0.1, 0] }
material = { type = "neo_hookean", density = 1, youngs_modulus = 100, poissons_ratio = 0 }
[[boundary]]
side = "bottom"
kind = "slip"
[[boundary]]
side = "top"
kind = "slip"
)";

struct Collision {
  Real stress = 0;        ///< Greatest mean compressive stress of a bar [Pa].
  Real contact_time = 0;  ///< From the impulse and the force in the middle of the contact [s].
  Real restitution = 0;   ///< Momentum of a bar at the end over the one before, with its sign changed [1].
  Real energy_ratio = 0;
};

/// Bars of 10 m with one empty cell between them: the particles at their ends enter it, and with that meet, at one time.
Collision collide(int cells) {
  const Real h = 10.0 / cells;
  Simulation sim(
      case_from_text("colliding_bars", k_colliding_bars,
                     {fmt::format("grid.upper=[{:.17g},{:.17g}]", h * (2 * cells + 5), h), fmt::format("grid.cells=[{},1]", 2 * cells + 5),
                      fmt::format("time.dt={:.17g}", 0.1 * h / k_speed), fmt::format("body.left.region.lower=[{:.17g},0]", 2 * h),
                      fmt::format("body.left.region.upper=[{:.17g},{:.17g}]", (cells + 2) * h, h),
                      fmt::format("body.right.region.lower=[{:.17g},0]", (cells + 3) * h),
                      fmt::format("body.right.region.upper=[{:.17g},{:.17g}]", (2 * cells + 3) * h, h)}));
  const Real P = sim.solver().totals(0).momentum[0];
  Collision result;
  Real t_first = 0;  // when three quarters, and when a quarter of the momentum were left
  Real t_last = 0;
  every(sim, 1, [&](const Simulation& s) {
    const std::vector<Real> stress = component(s, 0, "stress", 0);
    Real mean = 0;
    for (const Real value : stress) mean -= value / static_cast<Real>(stress.size());
    result.stress = std::max(result.stress, mean);
    const Real now = s.solver().totals(0).momentum[0];
    if (t_first == 0 && now < 0.75 * P) t_first = s.time();
    if (t_last == 0 && now < -0.75 * P) t_last = s.time();
  });
  sim.run();
  result.contact_time = (t_last - t_first) / 0.75;
  result.restitution = -sim.solver().totals(0).momentum[0] / P;
  result.energy_ratio = energy(sim) / sim.initial_energy();
  return result;
}

Measured colliding_bars() {
  Measured m;
  for (const int cells : {40, 80}) {
    const Collision result = collide(cells);
    const std::string tail = fmt::format("_{}_cells", cells);
    m["stress" + tail] = result.stress;
    m["contact_time" + tail] = result.contact_time;
    m["restitution" + tail] = result.restitution;
    m["energy_ratio" + tail] = result.energy_ratio;
  }
  return m;
}

}  // namespace

void add_bars(VerifySuite& suite) {
  const std::string exact = "closed form, v = v0 sin(b x) cos(w t)";
  const std::string discrete = "closed form of the discrete bar, w_h = (c / h) sin(b h)";
  // Strains up to v0 / c = 0.01 shift frequencies by some (v0 / c)^2 = 1e-4 beyond the linear theory, phases in 3 periods by some 2e-3.
  // The discrete bar is late by (b h)^2 / 6 = 6.6e-4 of a period with 25 cells: a velocity error of 6 pi 6.6e-4 = 0.0124 after 3 periods.
  add_problem(suite, {"axial_bar", "mode 1, 25 and 50 cells, USL", "bar", true, true, 4.5e5, {}, first_mode},
              {within("period_mode1_25_cells", 2 * k_pi / discrete_frequency(25, 1), 5e-4, discrete),
               within("period_mode1_50_cells", 2 * k_pi / discrete_frequency(50, 1), 5e-4, discrete),
               at_most("velocity_error_mode1_25_cells", 0.0124, exact), at_most("velocity_error_mode1_50_cells", 0.0032, exact),
               within("velocity_error_ratio_mode1", 4, 0.2, "second order"), within("energy_ratio_mode1_flip", 1, 5e-5, exact)});
  add_problem(
      suite,
      {"axial_bar",
       "mode 10, 50 to 200 cells, USL",
       "bar",
       true,
       true,
       1.8e6,
       {},
       [] {
         return tenth_mode({50, 100, 200});
       }},
      {within("frequency_mode10_50_cells", discrete_frequency(50, 10), 4e-3, discrete),
       within("frequency_mode10_100_cells", discrete_frequency(100, 10), 4e-3, discrete),
       within("frequency_mode10_200_cells", discrete_frequency(200, 10), 4e-3, discrete),
       within("frequency_error_ratio_mode10_100_cells", 4, 0.2, "second order"),
       within("frequency_error_ratio_mode10_200_cells", 4, 0.3, "second order; the nonlinear shift of 1e-4 is a part of the error here"),
       within("energy_ratio_mode10_200_cells", 1, 0.01, exact)});
  // PIC: velocities times S per step, so the energy falls as exp(-(1 - S) t / dt); 500 steps.
  const Real pic = std::exp(-500 * std::pow(std::sin(wave_number(1) * k_length / 25 / 2), 2));
  add_problem(suite, {"axial_bar", "mode 1 with USL, USF, MUSL and PIC", "bar", true, true, 5e4, {}, schemes},
              {within("energy_ratio_mode1_usl", 1, 2e-4, exact), within("energy_ratio_mode1_usf", 1, 1e-4, exact),
               within("energy_ratio_mode1_musl", 1, 1e-4, exact),
               within("energy_ratio_mode1_pic", pic, 0.003, "closed form of the discrete bar, exp(-(1 - S) t / dt)")});
  add_problem(suite, {"axial_bar", "in 3D with slip and with periodic sides", "bar", true, true, 4e4, {}, bar_3d},
              {at_most("difference_3d_slip", 1e-12, "the same in 2D"), at_most("difference_3d_periodic", 1e-12, "the same in 2D")});
  // d(ln F)/dt = v, dv/dt = -E/2 (F^2 - 1): with A = v0 / w = 0.0159 the period is 1 + A^2 / 6 = 1.000042.
  // USL takes L from p / m + a dt with twice the particle's acceleration (N = 1/2), so the strain decays on the way: rate w^2 dt / 2.
  const Real usl_decay = 4 * k_pi * k_pi * 0.001 / 2;  // [1/s]
  const std::string spring = "closed form, w = sqrt(E / rho) / l; + A^2 / 6 = 4.2e-5";
  add_problem(
      suite, {"one_particle", "one particle between two nodes, USL and MUSL", "", true, true, 2e4, {}, oscillator},
      {within("period_usl", 1, 5e-5, spring), within("period_musl", 1, 5e-5, spring),
       within("velocity_amplitude_usl", 0.1 * std::exp(-usl_decay / 2), 5e-5, "closed form of the discrete particle after half a period"),
       within("velocity_amplitude_musl", 0.1, 5e-6, spring)});
  const std::string impact = "closed form: stress rho c v, contact 2 L / c, velocities exchanged";
  add_problem(suite, {"colliding_bars", "two bars collide, 40 and 80 cells, MUSL", "", true, true, 4e6, {}, colliding_bars},
              {within("stress_40_cells", 1, 0.03, impact), within("stress_80_cells", 1, 0.02, impact),
               within("contact_time_40_cells", 2, 0.03, impact), within("contact_time_80_cells", 2, 0.015, impact),
               within("restitution_40_cells", 1, 0.03, impact), within("restitution_80_cells", 1, 0.03, impact),
               within("energy_ratio_40_cells", 1, 2.5e-3, impact), within("energy_ratio_80_cells", 1, 5e-4, impact)});
}

}  // namespace matpoint
