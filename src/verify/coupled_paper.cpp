// The coupled examples of the paper by Aulisa & Capodaglio: a disk of particles rolls down a plate of finite elements (its Table 2), and
// bounces on one. Numbers and bounds stand in verification/coupled_acceptance.csv, the problems in cases/*.toml.
#include <algorithm>
#include <cmath>

#include "verify/acceptance.hpp"
#include "verify/analytic.hpp"
#include "verify/implicit_series.hpp"

namespace matpoint {
namespace {

// --- disk on a plate -------------------------------------------------------------------------------------------------
/// Rows 1 to 3: both moduli, the soft stiffness and the gap go together. J: refinements.
Sets plate_sets(int row, int J, Real x0) {
  const Real E[] = {4.2e5, 4.2e6, 4.2e7};
  const Real gap[] = {0.15, 0.20, 0.25};
  const char* const soft[] = {"[1e-2,1e-6]", "[1e-3,1e-7]", "[1e-4,1e-8]"};
  return {fmt::format("grid.refinements={}", J), fmt::format("body.disk.region.center=[{},{}]", x0, gap[row - 1] / std::pow(2, J - 1)),
          fmt::format("body.disk.material.youngs_modulus={}", E[row - 1]),
          fmt::format("body.plate.material.youngs_modulus={}", 2 * E[row - 1]), fmt::format("solver.soft_stiffness={}", soft[row - 1])};
}

/// Averaged relative error (eq. 52) of the tracked particle, and how many particles were ever found in the plate.
Measured plate(const Sets& sets, const std::string& tail, const std::string& case_name = "disk_on_plate") {
  Simulation sim(load_case(case_name, sets));
  const Real start = sim.solver().field(0, "position").values[0];
  AveragedError tracked;
  Real penetrated = 0;
  every(sim, 1, [&](const Simulation& s) {
    tracked.include(s.time(), s.solver().field(0, "position").values[0] - start);
    for (const StepNumber& number : s.solver().step_numbers()) {
      if (number.name == "penetrated_particles") penetrated = std::max(penetrated, number.value);
    }
  });
  sim.run();
  return {{"error_tracked_" + tail, tracked.mean()}, {"penetrated_" + tail, penetrated}};
}

/// On a plate that hardly yields the disk rolls as on the rigid incline of the first example. From x = 1.2 m, away from the left side, and
/// with the particles of the paper's own rule.
Measured rigid_limit() {
  const auto layout = [](int layers) {
    return fmt::format("body.disk.layout={{ type = \"layered_disk\", core_radius = 1.4, points = 600, layers = {}, normalized = false }}",
                       layers);
  };
  Sets on_plate = plate_sets(2, 1, 1.2);
  on_plate.insert(on_plate.end(), {"body.plate.material.youngs_modulus=8.4e10", layout(24)});
  Measured m = plate(on_plate, "stiff_plate");
  m.merge(plate({"grid.refinements=1", "body.disk.region.center=[1.2,0.2]", "body.disk.material.youngs_modulus=4.2e6",
                 "solver.soft_stiffness=[1e-3,1e-7]", "boundary.1.receding_correction=0.5", layout(22)},
                "rigid_incline", "rolling_disk"));
  m["stiff_plate_over_rigid_incline"] = m.at("error_tracked_stiff_plate") / m.at("error_tracked_rigid_incline");
  m.erase("penetrated_rigid_incline");
  return m;
}

void add_plates(VerifySuite& suite) {
  for (int row = 1; row <= 3; ++row) {
    for (int J = 1; J <= 4; ++J) {
      const std::string tail = fmt::format("row{}_J{}", row, J);
      const Real x0 = row == 3 && J == 1 ? 0.1 : 0;
      add_problem(suite,
                  {"disk_on_plate",
                   fmt::format("row {}, J = {}", row, J),
                   "disk_on_plate",
                   false,
                   true,
                   8e8 * std::pow(2, J),
                   {"error_tracked_" + tail},
                   [=] { return plate(plate_sets(row, J, x0), tail); }},
                  {at_most("penetrated_" + tail, 0, "no particle in the plate")});
    }
  }
  suite.jobs.push_back(
      {"disk_on_plate", "row 3, J = 1, from x = 0", "disk_on_plate", false, true, 1e9, {"error_tracked_row3_J1_from_0"}, [] {
         return plate(plate_sets(3, 1, 0), "row3_J1_from_0");
       }});
  add_problem(suite,
              {"disk_on_plate",
               "row 2, J = 2, first steps",
               "disk_on_plate",
               true,
               true,
               6e7,
               {},
               [] {
                 Simulation sim(load_case("disk_on_plate", plate_sets(2, 2, 0)));
                 return Measured{{"series_row2_J2", series_difference(sim, "series_disk_on_plate", 0)}};
               }},
              {series_row("series_row2_J2")});
  add_problem(
      suite, {"disk_on_plate", "the plate's rigid limit", "disk_on_plate", false, true, 1.6e9, {}, &rigid_limit},
      {within("error_tracked_stiff_plate", 0.1194, 0.0012, "reference; plate of 8.4e10 Pa, disk of row 2 from x = 1.2, J = 1"),
       within("error_tracked_rigid_incline", 0.1190, 0.0012, "reference; rolling_disk E1, C_c = 0.5, from x = 1.2, J = 1"),
       within("stiff_plate_over_rigid_incline", 1, 0.01, "the limit"), at_most("penetrated_stiff_plate", 0, "no particle in the plate")});
}

// --- bouncing disk ---------------------------------------------------------------------------------------------------
struct Bounce {
  std::string name;
  int refinements;
  Real correction;
  Real dt_plate;
  const char* soft;
};

Sets bounce_sets(const Bounce& run) {
  const Real h = 0.184 / std::pow(2, run.refinements);
  const Real y0 = -1.52 + h;
  return {fmt::format("grid.refinements={}", run.refinements), fmt::format("body.plate.receding_correction={}", run.correction),
          fmt::format("solver.soft_stiffness={}", run.soft), fmt::format("time.rule.positions=[{},{},-0.16]", y0, 0.5 * (y0 - 0.16)),
          fmt::format("time.rule.steps=[{},0.01,0.005]", run.dt_plate)};
}

Measured bounce(const Bounce& run) {
  Simulation sim(load_case("bouncing_disk", bounce_sets(run)));
  std::vector<Real> t = {0}, y = {sim.solver().totals(0).center_of_mass[1]}, force = {0};
  Real momentum = 0;
  Real penetrated = 0;
  Real fall = 0;  // the greatest distance from Newmark's free fall before contact
  const Real mass = sim.solver().totals(0).mass;
  Real first_dt = 0;
  every(sim, 1, [&](const Simulation& s) {
    const BodyTotals totals = s.solver().totals(0);
    if (first_dt == 0) first_dt = s.last_dt();
    t.push_back(s.time());
    y.push_back(totals.center_of_mass[1]);
    force.push_back((totals.momentum[1] - momentum) / s.last_dt() + mass * 9.81);
    momentum = totals.momentum[1];
    if (s.time() < 0.45) {
      const Real after = s.time() - first_dt;
      const Real exact = -9.81 * (0.3 * first_dt * first_dt + 0.5 * first_dt * after + 0.5 * after * after);
      fall = std::max(fall, std::abs(totals.center_of_mass[1] - y[0] - exact));
    }
    for (const StepNumber& number : s.solver().step_numbers()) {
      if (number.name == "penetrated_particles") penetrated = std::max(penetrated, number.value);
    }
  });
  sim.run();
  const auto tail = "_" + run.name;
  Measured m = {{"penetrated" + tail, penetrated}, {"free_fall" + tail, fall}};
  // Contacts are intervals with more than 1 % of the greatest force of the run.
  const Real threshold = 0.01 * *std::max_element(force.begin(), force.end());
  int contacts = 0;
  Real begin = 0;
  Real peak = 0;
  for (std::size_t k = 1; k < t.size(); ++k) {
    const bool is_touching = force[k] > threshold;
    if (is_touching && force[k - 1] <= threshold) {
      begin = t[k];
      ++contacts;
    }
    if (contacts == 1) peak = std::max(peak, force[k]);
    if (!is_touching && force[k - 1] > threshold && contacts == 1) m["contact_duration_1" + tail] = t[k - 1] - begin;
  }
  m["peak_force_1" + tail] = peak;
  m["contacts_until_3.5s" + tail] = contacts;
  int maxima = 0;
  for (std::size_t k = 1; k + 1 < t.size(); ++k) {
    // The parabola through three steps, of different lengths.
    const Real a = (y[k] - y[k - 1]) / (t[k] - t[k - 1]), b = (y[k + 1] - y[k]) / (t[k + 1] - t[k]);
    const Real curvature = (b - a) / (t[k + 1] - t[k - 1]);
    const Real slope = a + curvature * (t[k] - t[k - 1]);
    const Real at = t[k] - slope / (2 * curvature);
    const Real value = y[k] - slope * slope / (4 * curvature);
    if (y[k] >= y[k - 1] && y[k] > y[k + 1] && y[k] > -0.5 && maxima < 3) {
      ++maxima;
      m[fmt::format("rebound_{}{}", maxima, tail)] = value + 1.36;
      m[fmt::format("t_max_{}{}", maxima, tail)] = at;
    }
    if (y[k] <= y[k - 1] && y[k] < y[k + 1] && m.count("y_cm_min_1" + tail) == 0) m["y_cm_min_1" + tail] = value;
  }
  return m;
}

void add_bounces(VerifySuite& suite) {
  const Bounce runs[] = {{"CE1_J2", 1, 0.06, 5e-4, "[1e-2,1e-6]"},
                         {"CE2_J2", 1, 0, 1e-3, "[1e-5,1e-9]"},
                         {"CE1_J3", 2, 0.1, 2.5e-4, "[1e-2,1e-6]"},
                         {"CE2_J3", 2, 0.1, 5e-4, "[1e-5,1e-9]"}};
  for (const Bounce& run : runs) {
    std::vector<std::string> quantities;
    for (const char* quantity : {"peak_force_1", "contact_duration_1", "contacts_until_3.5s", "y_cm_min_1", "rebound_1", "rebound_2",
                                 "rebound_3", "t_max_1", "t_max_2", "t_max_3"})
      quantities.push_back(std::string(quantity) + "_" + run.name);
    add_problem(suite, {"bouncing_disk", run.name, "bouncing_disk", false, true, 3e9, quantities, [=] { return bounce(run); }},
                {at_most("penetrated_" + run.name, 0, "no particle in the plate"),
                 at_most("free_fall_" + run.name, 1e-12, "the integrator's own formula, before contact")});
    if (run.name.substr(0, 3) != "CE1") continue;
    const auto first_steps = [=] {
      Simulation sim(load_case("bouncing_disk", bounce_sets(run)));
      return Measured{{"series_" + run.name, series_difference(sim, "series_bouncing_disk_" + run.name, 0, 6)}};
    };
    add_problem(suite, {"bouncing_disk", run.name + ", first steps", "bouncing_disk", true, true, 5e7, {}, first_steps},
                {series_row("series_" + run.name)});
  }
}

/// The fall alone: greatest distance from Newmark's free fall [m].
Measured bounce_fall() {
  Simulation sim(load_case("bouncing_disk", {"grid.refinements=1"}));
  const Real start = sim.solver().totals(0).center_of_mass[1];
  Real fall = 0;
  Real first_dt = 0;
  every(sim, 1, [&](const Simulation& s) {
    if (first_dt == 0) first_dt = s.last_dt();
    const Real after = s.time() - first_dt;
    const Real exact = -9.81 * (0.3 * first_dt * first_dt + 0.5 * first_dt * after + 0.5 * after * after);
    fall = std::max(fall, std::abs(s.solver().totals(0).center_of_mass[1] - start - exact));
  });
  sim.run(nullptr, 0.2);
  return {{"free_fall_to_0.2", fall}};
}

}  // namespace

void add_coupled_paper(VerifySuite& suite) {
  for (VerifyRow& row : acceptance_rows("coupled_acceptance")) suite.rows.push_back(std::move(row));
  add_plates(suite);
  add_bounces(suite);
  add_problem(suite, {"bouncing_disk", "the fall", "bouncing_disk", true, true, 1e7, {}, &bounce_fall},
              {at_most("free_fall_to_0.2", 1e-12, "the integrator's own formula")});
}

}  // namespace matpoint
