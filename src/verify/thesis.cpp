// The seven examples of the thesis by Kamuth, as measured by its author and by an independent reference computation of ours: the numbers
// and bounds stand in verification/explicit_acceptance.csv, the problems in cases/*.toml.
#include <algorithm>
#include <cmath>
#include <optional>

#include "verify/acceptance.hpp"
#include "verify/contact.hpp"
#include "verify/measure.hpp"
#include "verify/verify.hpp"

namespace matpoint {
namespace {

enum class Presets { quick, full, both };

std::vector<std::string> with_suffix(std::vector<std::string> names, const std::string& suffix) {
  for (std::string& name : names) name += suffix;
  return names;
}

/// The schemes as they were published, also where a set changes the shape.
Simulation make(const std::string& name, Sets sets) {
  sets.insert(sets.end(), {"solver.co_rotating=false", "solver.fluid_correction=false"});
  return Simulation(load_case(name, sets));
}

// --- 8.1 spring ------------------------------------------------------------------------------------------------------
Measured spring(const std::string& alpha, bool is_published) {
  Simulation sim = make("spring", {"solver.damping=" + alpha});
  const std::vector<Real> start = component(sim, 0, "position", 1);
  const auto lowest = static_cast<std::size_t>(std::min_element(start.begin(), start.end()) - start.begin());
  Real sum = 0;
  Real last = 0;
  every(sim, 1, [&](const Simulation& s) {
    last = start[lowest] - component(s, 0, "position", 1)[lowest];
    sum += last;
  });
  sim.run();
  const Real mean = sum / static_cast<Real>(sim.step_count());
  if (!is_published) return {{"mean_u_alpha" + alpha, mean}};
  return {{"mean_u_alpha" + alpha + "_20000_steps", mean},
          {"final_u_alpha" + alpha, last},
          {"energy_remainder_over_elastic", std::abs(transfer_loss(sim)) / sim.solver().totals(0).strain_energy}};
}

// --- 8.2 truss -------------------------------------------------------------------------------------------------------
Measured truss(int cells, int points, bool escapes, Sets sets = {}, const std::string& suffix = "") {
  sets.push_back(fmt::format("grid.cells=[{},{}]", cells, cells));
  sets.push_back(fmt::format("body.truss.layout.divisions=[{},{}]", points, points));
  sets.push_back("grid.particles_outside=stop");
  Simulation sim = make("truss", sets);
  const RunEnd end = sim.run();
  const std::string tail = fmt::format("{}x{}_{}{}", cells, cells, points, suffix);
  if (escapes) return {{"escape_time_" + tail, end == RunEnd::particle_left ? sim.time() : std::numeric_limits<Real>::infinity()}};
  if (end != RunEnd::finished) throw SolverError("a particle left the grid at t = {}", sim.time());
  const std::vector<Real> x = component(sim, 0, "position", 0);
  const std::vector<Real> y = component(sim, 0, "position", 1);
  const auto n = static_cast<std::size_t>(points);
  // Top and bottom of the middle column; with an odd count the top of column (n-1)/2 and the bottom of the next one.
  const std::size_t top_column = (n - 1) / 2 + (n % 2 == 0 ? 1 : 0);
  const std::size_t bottom_column = n % 2 == 0 ? top_column : top_column + 1;
  return {{"ly_" + tail, y[top_column * n + n - 1] - y[bottom_column * n]}, {"lx_" + tail, x[(n - 1) * n + n - 1] - x[n - 1]}};
}

Measured truss_slim(const std::string& law, const std::string& label) {
  Simulation sim = make("truss_slim", {"body.truss.material.type=" + law, "time.end=0.12"});
  Measured measured;
  int index = 0;
  for (const Real t : {0.04, 0.08, 0.12}) {
    const std::string quantity = fmt::format("{}_ymin_t0.04_0.08_0.12[{}]", label, ++index);
    at(sim, t, [&measured, quantity](const Simulation& s) { measured[quantity] = s.solver().totals(0).lower[1]; });
  }
  sim.run();
  return measured;
}

// --- 8.3 disks -------------------------------------------------------------------------------------------------------
/// The thesis' eq. 88, 1/2 sigma : (F - I) V0: not the stored energy, but what its figure 16 shows.
Real thesis_energy(const Simulation& sim) {
  Real sum = 0;
  for (std::size_t b = 0; b < sim.solver().body_count(); ++b) {
    const Field stress = sim.solver().field(b, "stress");
    const Field F = sim.solver().field(b, "deformation_gradient");
    const Field J = sim.solver().field(b, "J");
    const Field volume = sim.solver().field(b, "volume");
    for (std::size_t p = 0; p < J.values.size(); ++p) {
      const Real* s = &stress.values[6 * p];
      const Real* f = &F.values[9 * p];
      const Real product = s[0] * (f[0] - 1) + s[1] * (f[4] - 1) + s[3] * (f[1] + f[3]);
      sum += 0.5 * product * volume.values[p] / J.values[p];
    }
  }
  return sum;
}

Measured disks_usl() {
  Simulation sim = make("disks", {});
  Measured m;
  m["KE_initial"] = kinetic_energy(sim);
  m["KE_min"] = m["KE_initial"];
  const Real p1_start = sim.solver().totals(0).momentum[0];
  Real p1_before = p1_start;
  Real U_max = 0;
  Real total_momentum = 0;
  sim.add_callback([&](const Simulation& s) {
    const BodyTotals a = s.solver().totals(0);
    const BodyTotals b = s.solver().totals(1);
    if (s.step_count() == 12157) m["KE_after_step_12157"] = a.kinetic_energy + b.kinetic_energy;
    m["KE_min"] = std::min(m["KE_min"], a.kinetic_energy + b.kinetic_energy);
    m["max_stored_energy"] = std::max(m["max_stored_energy"], a.strain_energy + b.strain_energy);
    for (std::size_t d = 0; d < 2; ++d) total_momentum = std::max(total_momentum, std::abs(a.momentum[d] + b.momentum[d]));
    if (p1_before > 0 && a.momentum[0] <= 0) {
      m["t_momentum_zero"] = s.time() - s.last_dt() * a.momentum[0] / (a.momentum[0] - p1_before);
    }
    p1_before = a.momentum[0];
    if (s.time() > 1.5 && s.time() < 1.8) {
      const Real U = thesis_energy(s);
      if (U > U_max) {
        U_max = U;
        m["t_max_U_thesis"] = s.time();
      }
    }
    return true;
  });
  sim.run();
  m["restitution_p"] = -p1_before / p1_start;
  m["total_momentum_abs"] = total_momentum;
  m["TE_end_over_TE0"] = energy(sim) / sim.initial_energy();
  return m;
}

Measured disks_musl() {
  Simulation sim = make("disks", {"solver.stress_order=musl"});
  sim.run();
  return {{"TE_end_over_TE0_musl", energy(sim) / sim.initial_energy()}};
}

// --- 8.4 dam ---------------------------------------------------------------------------------------------------------
std::vector<std::string> dam_quantities(const std::string& viscosity, const std::string& suffix) {
  const std::string tail = "_mu" + viscosity + suffix;
  if (viscosity == "220") return {"ymax" + tail, "t_ymax" + tail};
  if (viscosity == "50") return {"escape" + tail};
  return {"escape" + tail, "front_x4" + tail, "energy_remainder_over_max_KE" + suffix, "momentum_balance_with_reactions_relative" + suffix};
}

Measured dam(const std::string& viscosity, Sets sets, const std::string& suffix) {
  sets.push_back("body.water.material.viscosity=" + viscosity);
  Simulation sim = make("dam", sets);
  const std::string tail = "_mu" + viscosity + suffix;
  constexpr Real k_never = std::numeric_limits<Real>::infinity();
  Real front = k_never;
  Real y_max = 0;
  Real t_y_max = 0;
  Real KE_max = 0;
  Real momentum_max = 0;
  // Every 1e-4 s: a twentieth of the narrowest bound, and the totals cost next to nothing then.
  every(sim, steps_in(sim, 1e-4), [&](const Simulation& s) {
    const BodyTotals water = s.solver().totals(0);
    if (water.upper[0] >= 4) front = std::min(front, s.time());
    if (water.upper[1] > y_max) {
      y_max = water.upper[1];
      t_y_max = s.time();
    }
    KE_max = std::max(KE_max, water.kinetic_energy);
    momentum_max = std::max({momentum_max, std::abs(water.momentum[0]), std::abs(water.momentum[1])});
  });
  Measured m;
  if (viscosity == "0.01") {
    at(sim, 1.26, [&](const Simulation& s) {
      m["energy_remainder_over_max_KE" + suffix] = std::abs(transfer_loss(s)) / KE_max;
      m["momentum_balance_with_reactions_relative" + suffix] = momentum_remainder(s) / momentum_max;
    });
  }
  const RunEnd end = sim.run();
  if (viscosity == "220") {
    if (end != RunEnd::finished) throw SolverError("water escaped at t = {}, it should not", sim.time());
    return {{"ymax" + tail, y_max}, {"t_ymax" + tail, t_y_max}};
  }
  m["escape" + tail] = end == RunEnd::particle_left ? sim.time() : k_never;
  if (viscosity == "0.01") m["front_x4" + tail] = front;
  return m;
}

// --- 8.5 drop --------------------------------------------------------------------------------------------------------
struct DropResult {
  Real crater_depth = 0;
  Real drop_ymin = 0;
  Real crown = 0;
  Real energy_remainder = 0;
};

DropResult drop(const std::string& pressure_scale, Sets sets) {
  sets.push_back("body.drop.material.pressure_scale=" + pressure_scale);
  sets.push_back("body.tank.material.pressure_scale=" + pressure_scale);
  Simulation sim = make("drop", sets);
  DropResult result;
  const Real KE0 = kinetic_energy(sim);
  every(sim, steps_in(sim, 1e-4), [&](const Simulation& s) {
    const Field tank = s.solver().field(1, "position");
    Real surface = -1;
    for (std::size_t p = 0; p < tank.values.size(); p += 2) {
      if (std::abs(tank.values[p] - 0.06) < 5e-4) surface = std::max(surface, tank.values[p + 1]);
    }
    if (surface < 0) throw SolverError("t = {}: no particle of the tank within 5e-4 of x = 0.06", s.time());
    result.crater_depth = std::max(result.crater_depth, 0.02 - surface);
  });
  at(sim, 0.075, [&](const Simulation& s) {
    result.drop_ymin = s.solver().totals(0).lower[1];
    result.crown = s.solver().totals(1).upper[1];
  });
  sim.run();
  result.energy_remainder = std::abs(transfer_loss(sim)) / KE0;
  return result;
}

std::vector<std::string> drop_quantities(const std::string& suffix) {
  std::vector<std::string> names = {"energy_remainder_over_KE0" + suffix, "depth_strictly_decreasing_with_kappa" + suffix};
  for (const std::string pressure_scale : {"15000", "30000", "60000"}) names.push_back("crater_depth_" + pressure_scale + suffix);
  for (int index = 1; index <= 3; ++index) {
    names.push_back(fmt::format("drop_ymin_t0.075{}[{}]", suffix, index));
    names.push_back(fmt::format("crown_t0.075{}[{}]", suffix, index));
  }
  return names;
}

Measured drops(Sets sets, const std::string& suffix) {
  Measured m;
  Real previous_depth = std::numeric_limits<Real>::infinity();
  Real worst_remainder = 0;
  bool is_decreasing = true;
  int index = 0;
  for (const std::string pressure_scale : {"15000", "30000", "60000"}) {
    const DropResult result = drop(pressure_scale, sets);
    ++index;
    m["crater_depth_" + pressure_scale + suffix] = result.crater_depth;
    m[fmt::format("drop_ymin_t0.075{}[{}]", suffix, index)] = result.drop_ymin;
    m[fmt::format("crown_t0.075{}[{}]", suffix, index)] = result.crown;
    worst_remainder = std::max(worst_remainder, result.energy_remainder);
    is_decreasing = is_decreasing && result.crater_depth < previous_depth;
    previous_depth = result.crater_depth;
  }
  m["energy_remainder_over_KE0" + suffix] = worst_remainder;
  m["depth_strictly_decreasing_with_kappa" + suffix] = is_decreasing ? 1 : 0;
  return m;
}

// --- 8.6 gravity current ---------------------------------------------------------------------------------------------
Measured gravity_current(Real end) {
  Simulation sim = make("gravity_current", {fmt::format("time.end={}", end)});
  Measured m;
  at(sim, 0.10, [&](const Simulation& s) { m["heavy_front_t0.10"] = s.solver().totals(1).lower[0]; });
  at(sim, 0.25, [&](const Simulation& s) {
    m["heavy_front_t0.25"] = s.solver().totals(1).lower[0];
    m["light_front_t0.25"] = s.solver().totals(0).upper[0];
  });
  at(sim, 0.5, [&](const Simulation& s) {
    m["ybar_light_t0.5"] = s.solver().totals(0).center_of_mass[1];
    m["ybar_heavy_t0.5"] = s.solver().totals(1).center_of_mass[1];
  });
  sim.run();
  return m;
}

Measured gravity_current_musl() {
  Simulation sim = make("gravity_current", {"solver.stress_order=musl", "time.dt=5e-6", "time.end=2"});
  sim.run();
  return {{"ybar_light_minus_heavy_T2", sim.solver().totals(0).center_of_mass[1] - sim.solver().totals(1).center_of_mass[1]}};
}

// --- 8.7 float -------------------------------------------------------------------------------------------------------
/// Two bottom particles of the block straddle x = 0.2; the left one is followed.
std::size_t keel_of(const Simulation& sim) {
  const std::vector<Real> x = component(sim, 1, "position", 0);
  const std::vector<Real> y = component(sim, 1, "position", 1);
  const Real bottom = *std::min_element(y.begin(), y.end());
  std::size_t followed = 0;
  Real best = -1;
  for (std::size_t p = 0; p < x.size(); ++p) {
    if (y[p] < bottom + 1e-9 && x[p] < 0.2 && x[p] > best) {
      best = x[p];
      followed = p;
    }
  }
  return followed;
}

Measured floating(Sets sets, const std::string& suffix) {
  Simulation sim = make("float", sets);
  const std::size_t followed = keel_of(sim);
  Real KE_max = 0;
  Real lowest = 1;
  Real t_lowest = 0;
  Real highest = 0;
  Real last = 0;
  every(sim, steps_in(sim, 1e-3), [&](const Simulation& s) {
    KE_max = std::max(KE_max, kinetic_energy(s));
    last = component(s, 1, "position", 1)[followed];
    if (s.time() < 1.0 && last < lowest) {
      lowest = last;
      t_lowest = s.time();
    }
    if (s.time() >= 1.1 && s.time() <= 1.35) highest = std::max(highest, last);
  });
  sim.run();
  return {{"first_min_y" + suffix, lowest},
          {"t_first_min" + suffix, t_lowest},
          {"first_max_y" + suffix, highest},
          {"y_t2" + suffix, last},
          {"energy_remainder_over_max_KE" + suffix, std::abs(transfer_loss(sim)) / KE_max}};
}

/// With contact between the bodies: the mean place of the keel from 2 to 2.5 s, and the greatest energy less that at the start [J].
Measured floating_with_contact(const std::string& method, const std::string& name) {
  Simulation sim = make("float", {"solver.stress_order=musl", "time.dt=1e-5", "time.end=2.5", "solver.contact=" + method});
  const auto whole_energy = [](const Simulation& s) { return energy(s) + s.solver().ledger().contact_energy; };
  const Real start = whole_energy(sim);
  const std::size_t keel = keel_of(sim);
  Real sum = 0;
  Real greatest = start;
  int count = 0;
  every(sim, steps_in(sim, 1e-2), [&](const Simulation& s) {
    greatest = std::max(greatest, whole_energy(s));
    if (s.time() < 2) return;
    sum += component(s, 1, "position", 1)[keel];
    ++count;
  });
  sim.run();
  return {{"keel_y_" + name, sum / count}, {"energy_gain_" + name, greatest - start}};
}

using Names = std::vector<std::string>;

class JobList {
 public:
  explicit JobList(std::vector<VerifyJob>& jobs) : jobs_(jobs) {}
  /// Group and case of the jobs that follow.
  void start(std::string group, std::string case_name) {
    group_ = std::move(group);
    case_name_ = std::move(case_name);
  }
  void add(const std::string& name, Presets presets, double cost, Names quantities, std::function<Measured()> run) {
    jobs_.push_back(
        {group_, name, case_name_, presets != Presets::full, presets != Presets::quick, cost, std::move(quantities), std::move(run)});
  }

 private:
  std::vector<VerifyJob>& jobs_;
  std::string group_;
  std::string case_name_;
};

void add_solid_jobs(JobList& jobs) {
  jobs.start("8.1", "spring");
  jobs.add("spring, alpha = 15", Presets::both, 2e5, {"mean_u_alpha15_20000_steps", "final_u_alpha15", "energy_remainder_over_elastic"},
           [] { return spring("15", true); });
  jobs.add("spring, alpha = 20", Presets::both, 2e5, {"mean_u_alpha20"}, [] { return spring("20", false); });
  jobs.start("8.2", "truss");
  for (const int points : {5, 20, 100}) {
    for (const int cells : {3, 4, 7, 8}) {
      const bool escapes = cells >= 7 && points <= 20;
      const double steps = escapes ? 6000 : 199500;
      const std::string tail = fmt::format("{0}x{0}_{1}", cells, points);
      jobs.add(fmt::format("truss, {0} x {0} cells, {1} x {1} points", cells, points), points <= 20 ? Presets::both : Presets::full,
               steps * points * points, escapes ? Names{"escape_time_" + tail} : Names{"ly_" + tail, "lx_" + tail},
               [=] { return truss(cells, points, escapes); });
    }
  }
  // Quadratic B-splines instead of linear shapes, at ten times the thesis' time step: no numerical fracture.
  for (const char* transfer : {"flip", "apic"}) {
    for (const int points : {20, 100}) {
      for (const int cells : {7, 8}) {
        const std::string suffix = fmt::format("_bspline2_{}", transfer);
        const std::string tail = fmt::format("{0}x{0}_{1}{2}", cells, points, suffix);
        Sets sets = {"solver.shape=bspline2", fmt::format("solver.transfer={}", transfer), "time.dt=1e-4"};
        if (std::string(transfer) == "flip") sets.push_back("solver.flip=0.999");
        jobs.add(fmt::format("truss, {0} x {0} cells, {1} x {1} points, B-splines, {2}", cells, points, transfer),
                 points <= 20 ? Presets::both : Presets::full, 19950.0 * points * points, {"ly_" + tail, "lx_" + tail},
                 [=] { return truss(cells, points, false, sets, suffix); });
      }
    }
  }
  for (const int cells : {7, 8}) {
    const std::string tail = fmt::format("{0}x{0}_20_cpdi", cells);
    jobs.add(fmt::format("truss, {0} x {0} cells, 20 x 20 points, CPDI", cells), Presets::both, 8e6, {"ly_" + tail, "lx_" + tail}, [=] {
      return truss(cells, 20, false, {"solver.shape=cpdi", "time.dt=1e-4"}, "_cpdi");
    });
  }
  jobs.start("8.2.1", "truss_slim");
  for (const auto& [law, label] : {std::pair<std::string, std::string>("neo_hookean", "NH"), {"st_venant_kirchhoff", "StVK"}}) {
    const std::string head = label + "_ymin_t0.04_0.08_0.12";
    jobs.add("slim truss, " + law, Presets::both, 3.6e7, {head + "[1]", head + "[2]", head + "[3]"},
             [law = law, label = label] { return truss_slim(law, label); });
  }
  jobs.start("8.3", "disks");
  jobs.add("disks, 316 points, USL", Presets::both, 6e7,
           {"KE_initial", "KE_after_step_12157", "t_momentum_zero", "max_stored_energy", "t_max_U_thesis", "KE_min", "restitution_p",
            "total_momentum_abs", "TE_end_over_TE0"},
           [] { return disks_usl(); });
  jobs.add("disks, 316 points, MUSL", Presets::both, 3e7, {"TE_end_over_TE0_musl"}, [] { return disks_musl(); });
}

void add_fluid_jobs(JobList& jobs) {
  jobs.start("8.4", "dam");
  for (const std::string mu : {"0.01", "50", "220"}) {
    jobs.add("dam, mu = " + mu + ", USL", Presets::full, mu == "220" ? 7.7e9 : 2.6e9, dam_quantities(mu, ""),
             [=] { return dam(mu, {}, ""); });
    // The most viscous one runs for two minutes.
    jobs.add("dam, mu = " + mu + ", MUSL at 10 x the time step", mu == "220" ? Presets::full : Presets::both, mu == "220" ? 1.5e9 : 5e8,
             dam_quantities(mu, "_musl"), [=] {
               return dam(mu, {"solver.stress_order=musl", "time.dt=1e-4"}, "_musl");
             });
  }
  jobs.add("dam, mu = 0.01, B-splines, 36 x 48 cells, MUSL", Presets::full, 5e8, {"escape_mu0.01_bspline2_36x48"}, [] {
    return dam("0.01", {"solver.stress_order=musl", "time.dt=1e-4", "solver.shape=bspline2", "grid.cells=[36,48]"}, "_bspline2_36x48");
  });
  jobs.start("8.5", "drop");
  jobs.add("drop, three kappas, USL", Presets::full, 1.2e10, drop_quantities(""), [] { return drops({}, ""); });
  jobs.add("drop, three kappas, MUSL at 10 x the time step", Presets::both, 2.4e9, drop_quantities("_musl"), [] {
    return drops({"solver.stress_order=musl", "time.dt=1e-5"}, "_musl");
  });
  jobs.add("drop, three kappas, B-splines, F-bar, MUSL", Presets::full, 2.4e9,
           {"crater_depth_15000_bspline2_fbar", "crater_depth_30000_bspline2_fbar", "crater_depth_60000_bspline2_fbar"}, [] {
             return drops(
                 {"solver.stress_order=musl", "time.dt=1e-5", "solver.shape=bspline2", "body.drop.fbar=true", "body.tank.fbar=true"},
                 "_bspline2_fbar");
           });
  jobs.start("8.6", "gravity_current");
  jobs.add("gravity current to t = 0.10, USL", Presets::quick, 7.2e8, {"heavy_front_t0.10"}, [] { return gravity_current(0.1); });
  jobs.add("gravity current to t = 0.5, USL", Presets::full, 3.6e9,
           {"heavy_front_t0.10", "heavy_front_t0.25", "light_front_t0.25", "ybar_light_t0.5", "ybar_heavy_t0.5"},
           [] { return gravity_current(0.5); });
  jobs.add("gravity current to t = 2, MUSL", Presets::full, 5.8e9, {"ybar_light_minus_heavy_T2"}, [] { return gravity_current_musl(); });
  jobs.start("8.7", "float");
  const Names floating_names = {"first_min_y", "t_first_min", "first_max_y", "y_t2", "energy_remainder_over_max_KE"};
  jobs.add("floating block to t = 2, USL", Presets::full, 1.3e10, floating_names, [] { return floating({}, ""); });
  jobs.add("floating block, contact", Presets::full, 3e9, {"keel_y_contact", "energy_gain_contact"},
           [] { return floating_with_contact("multi_field", "contact"); });
  jobs.add("floating block, pairs", Presets::full, 1e10, {"keel_y_pairs", "energy_gain_pairs"},
           [] { return floating_with_contact("pairs", "pairs"); });
  jobs.add("floating block to t = 2, MUSL at 10 x the time step", Presets::both, 2.6e9, with_suffix(floating_names, "_musl"), [] {
    return floating({"solver.stress_order=musl", "time.dt=1e-5"}, "_musl");
  });
}

}  // namespace

VerifySuite thesis_suite() {
  VerifySuite suite;
  suite.rows = acceptance_rows();
  JobList jobs(suite.jobs);
  add_solid_jobs(jobs);
  add_fluid_jobs(jobs);
  add_contact_jobs(suite.jobs);
  return suite;
}

}  // namespace matpoint
