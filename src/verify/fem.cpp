// Bodies of finite elements by themselves, without particles: uniform stress, a rod bent to a bow, the cantilever of the implicit examples,
// the elastic structure of Turek & Hron, a manufactured solution; and a body of particles that meets one.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "implicit/implicit_solver.hpp"
#include "verify/acceptance.hpp"
#include "verify/analytic.hpp"

namespace matpoint {
namespace {

/// A node of the background, found at the start by where it is.
class NodeProbe {
 public:
  NodeProbe(const Simulation& sim, std::size_t body, Real x, Real y)
      : solver_(dynamic_cast<const ImplicitSolver<2>&>(sim.solver())), body_(body) {
    for (Index n = 0; n < solver_.basis().node_count(); ++n) {
      const Vec<2> position = solver_.basis().node_position(n);
      if (std::hypot(position[0] - x, position[1] - y) < 1e-9) node_ = static_cast<std::size_t>(n);
    }
    if (node_ == k_none) throw SolverError("there is no node at ({}, {})", x, y);
  }
  Real displacement(std::size_t d) const { return solver_.sources()[body_].fem->displacement[node_][d]; }

 private:
  static constexpr std::size_t k_none = static_cast<std::size_t>(-1);
  const ImplicitSolver<2>& solver_;
  std::size_t body_;
  std::size_t node_ = k_none;
};

/// A block of elements that fills the grid, clamped at its left side.
std::string clamped_block(Real x0, Real length, Real height, int nx, int ny, const std::string& material, const std::string& solver,
                          const std::string& time) {
  return fmt::format(R"(
[grid]
lower = [{0}, {1}]
upper = [{2}, {3}]
cells = [{4}, {5}]
[time]
{8}
[solver]
type = "implicit"
basis = "element"
{7}
[[body]]
name = "beam"
method = "elements"
region = {{ type = "box", lower = [{0}, {1}], upper = [{2}, {3}] }}
material = {{ {6} }}
[[boundary]]
side = "left"
kind = "fixed"
)",
                     x0, -height / 2, x0 + length, height / 2, nx, ny, material, solver, time);
}

// --- patch test ------------------------------------------------------------------------------------------------------
Measured patch(int order) {
  const std::string text = R"(
[grid]
lower = [0, 0]
upper = [2, 1]
cells = [4, 3]
grading = [1.4, 0.7]
[time]
end = 1
dt = 0.25
[solver]
type = "implicit"
basis = "element"
mode = "static"
[[body]]
name = "block"
method = "elements"
region = { type = "box", lower = [0, 0], upper = [2, 1] }
material = { type = "neo_hookean", density = 1, youngs_modulus = 1000, poissons_ratio = 0.3 }
[[boundary]]
side = "left"
[[boundary]]
side = "bottom"
[[boundary]]
side = "right"
kind = "traction"
traction = [200, 0]
)";
  Simulation sim(case_from_text("patch", text, {fmt::format("solver.element_order={}", order)}));
  sim.run();
  const Field F = sim.solver().field(0, "deformation_gradient");
  const Field stress = sim.solver().field(0, "stress");
  const Field J = sim.solver().field(0, "J");
  Real spread = 0;
  Real stress_error = 0;
  for (std::size_t p = 0; p < J.values.size(); ++p) {
    for (std::size_t k = 0; k < 9; ++k) spread = std::max(spread, std::abs(F.values[9 * p + k] - F.values[k]));
    // P_xx = J sigma_xx / F_xx is the traction, the side is free.
    stress_error = std::max(stress_error, std::abs(J.values[p] * stress.values[6 * p] / F.values[9 * p] / 200 - 1));
    stress_error = std::max(stress_error, std::abs(stress.values[6 * p + 1]) / 200);
  }
  return {{fmt::format("patch_spread_of_F_order{}", order), spread}, {fmt::format("patch_stress_error_order{}", order), stress_error}};
}

// --- elastica --------------------------------------------------------------------------------------------------------
/// Deflection and shortening over the length under a dead load at the end with k = P L^2 / (E I); slenderness 40.
std::pair<Real, Real> elastica(Real k) {
  const Real L = 1, h = L / 40, E = 1e6;
  const Real P = k * E * h * h * h / 12 / (L * L);
  std::string text =
      clamped_block(0, L, h, 40, 1, fmt::format("type = \"neo_hookean\", density = 1, youngs_modulus = {}, poissons_ratio = 0", E),
                    "mode = \"static\"", "end = 1\ndt = 0.05");
  text += fmt::format("[[boundary]]\nside = \"right\"\nkind = \"traction\"\ntraction = [0, {}]\n", -P / h);
  Simulation sim(case_from_text("elastica", text));
  const NodeProbe tip(sim, 0, L, 0);
  sim.run();
  return {-tip.displacement(1) / L, -tip.displacement(0) / L};
}

// --- cantilever ------------------------------------------------------------------------------------------------------
Measured fem_cantilever(int nx, int ny) {
  Simulation sim(case_from_text(
      "fem_cantilever",
      "gravity = [0, -9.81]\ngravity_times = [0.392, 0.4]\ngravity_factors = [1, 0]\n" +
          clamped_block(-0.5, 0.625, 0.25, nx, ny, "type = \"neo_hookean\", density = 1e4, youngs_modulus = 1.74e6, poissons_ratio = 0.4",
                        "beta = 0.3\ninitial_acceleration = \"zero\"", "end = 8\ndt = 0.008")));
  const NodeProbe tip(sim, 0, 0.125, 0);
  Real E_start = 0, first_minimum = 0;
  std::vector<Real> crossings;
  Real y_last = 0, y_before = 0, t_last = 0;
  const auto inner = [](const Simulation& s) { return s.solver().totals(0).kinetic_energy + s.solver().totals(0).strain_energy; };
  every(sim, 1, [&](const Simulation& s) {
    const Real y = tip.displacement(1);
    if (s.step_count() == 50) E_start = inner(s);
    if (first_minimum == 0 && y_last <= y_before && y_last < y && s.step_count() > 2) {
      const Real curvature = y_before - 2 * y_last + y;
      const Real shift = 0.5 * (y_before - y) / curvature;
      first_minimum = y_last - 0.25 * (y_before - y) * shift;
    }
    if (t_last >= 0.4 && y_last < 0 && y >= 0) crossings.push_back(t_last - y_last * (s.time() - t_last) / (y - y_last));
    y_before = y_last;
    y_last = y;
    t_last = s.time();
  });
  sim.run();
  const std::string tail = fmt::format("_{}x{}", nx, ny);
  return {{"period" + tail, (crossings.back() - crossings.front()) / static_cast<Real>(crossings.size() - 1)},
          {"first_minimum" + tail, first_minimum},
          {"energy_ratio_8s" + tail, inner(sim) / E_start}};
}

// --- Turek & Hron ----------------------------------------------------------------------------------------------------
std::string turek_hron(const std::string& solver, const std::string& time) {
  return "gravity = [0, -2]\n" +
         clamped_block(0.25, 0.35, 0.02, 35, 2,
                       "type = \"st_venant_kirchhoff\", density = 1000, youngs_modulus = 1.4e6, poissons_ratio = 0.4", solver, time);
}

Measured csm1() {
  Simulation sim(case_from_text("csm1", turek_hron("mode = \"static\"", "end = 1\ndt = 0.1")));
  const NodeProbe tip(sim, 0, 0.6, 0);
  sim.run();
  return {{"csm1_ux", tip.displacement(0)}, {"csm1_uy", tip.displacement(1)}};
}

Measured csm3() {
  Simulation sim(case_from_text("csm3", turek_hron("beta = 0.25", "end = 4\ndt = 0.01")));
  const NodeProbe tip(sim, 0, 0.6, 0);
  Range range;
  ZeroCrossings crossings;
  every(sim, 1, [&](const Simulation& s) {
    range.include(tip.displacement(1));
    crossings.include(s.time(), tip.displacement(1) + 0.0636);
  });
  sim.run();
  return {{"csm3_uy_mean", 0.5 * (range.greatest + range.least)},
          {"csm3_uy_amplitude", 0.5 * (range.greatest - range.least)},
          {"csm3_frequency", 1 / crossings.period()}};
}

// --- Cook's membrane -------------------------------------------------------------------------------------------------
/// Vertical displacement [mm] of the upper right corner of the tapered panel under shear at its right side, n x n elements. The published
/// values are of linear elasticity, so the load is a thousandth of theirs.
Real cook_membrane(int n) {
  constexpr Real k_share = 1e-3;
  const char* const corners = "[[0, 0], [0.048, 0.044], [0.048, 0.06], [0, 0.044]]";
  Simulation sim(case_from_text("cook_membrane", fmt::format(R"(
[grid]
lower = [0, 0]
upper = [0.048, 0.06]
cells = [{0}, {0}]
corners = {1}
[time]
end = 1
dt = 1
[solver]
type = "implicit"
basis = "element"
mode = "static"
[[body]]
name = "membrane"
method = "elements"
region = {{ type = "polygon", vertices = {1} }}
material = {{ type = "neo_hookean", density = 1, youngs_modulus = 70e6, poissons_ratio = 0.3333333333333333 }}
[[boundary]]
side = "left"
kind = "fixed"
[[boundary]]
side = "right"
kind = "traction"
traction = [0, {2}]
)",
                                                             n, corners, k_share * 6.25e6)));
  const NodeProbe corner(sim, 0, 0.048, 0.06);
  sim.run();
  return corner.displacement(1) / k_share / 1e-3;
}

// --- a body of particles meets one of elements -----------------------------------------------------------------------
constexpr const char* k_meeting = R"(
[grid]
lower = [-1, -1]
upper = [1, 1]
cells = [10, 10]
[time]
end = 0.3
dt = 0.002
[solver]
type = "implicit"
basis = "element"
soft_stiffness = [1e-4, 1e-8]
[[body]]
name = "disk"
region = { type = "disk", center = [0.05, 0.25], radius = 0.2 }
layout = { type = "per_cell", count = 49 }
velocity = { type = "uniform", value = [0.3, -1] }
material = { type = "neo_hookean", density = 1000, youngs_modulus = 1e6, poissons_ratio = 0.3 }
[[body]]
name = "block"
method = "elements"
region = { type = "box", lower = [-0.4, -0.6], upper = [0.4, -0.2] }
material = { type = "neo_hookean", density = 1200, youngs_modulus = 2e6, poissons_ratio = 0.3 }
[[boundary]]
side = "bottom"
kind = "fixed"
[[boundary]]
side = "top"
kind = "fixed"
)";

Measured meeting(Real correction, const std::string& tail) {
  Simulation sim(case_from_text("meeting", k_meeting, {fmt::format("body.block.receding_correction={}", correction)}));
  const Vec3 start = momentum(sim);
  const Real scale = sim.solver().totals(0).mass;  // times 1 m/s
  const Real KE = kinetic_energy(sim);
  Real worst = 0, block_greatest = 0, remainder = 0;
  every(sim, 1, [&](const Simulation& s) {
    const Vec3 now = momentum(s);
    for (std::size_t d = 0; d < 2; ++d) worst = std::max(worst, std::abs(now[d] - start[d]) / scale);
    block_greatest = std::max(block_greatest, s.solver().totals(1).momentum[1] / start[1]);
    remainder = std::max(remainder, std::abs(transfer_loss(s)) / KE);
  });
  sim.run();
  const Ledger& ledger = sim.solver().ledger();
  return {{"meeting_momentum_change" + tail, worst},
          {"meeting_share_of_momentum" + tail, block_greatest},
          {"meeting_energy_remainder" + tail, remainder},
          {"meeting_soft_dissipation" + tail, ledger.soft_dissipation / KE},
          {"meeting_receding_work" + tail, ledger.receding_work / KE},
          {"meeting_reset_loss" + tail, ledger.reset_loss / KE},
          {"meeting_integrator_loss" + tail, ledger.integrator_loss / KE}};
}

// --- the basket ------------------------------------------------------------------------------------------------------
Measured basket() {
  Simulation sim(load_case("basket", {}));
  const Vec3 start = sim.solver().totals(0).center_of_mass;
  const Real mass = sim.solver().totals(0).mass;
  Range K;
  Real penetrated = 0, fall = 0, remainder = 0, lowest = 0;
  every(sim, 1, [&](const Simulation& s) {
    const Vec3 center = s.solver().totals(0).center_of_mass;
    const Real t = s.time();
    if (t <= 0.2) {
      fall = std::max({fall, std::abs(center[0] - start[0] - 1.5 * t), std::abs(center[1] - start[1] + t + 0.5 * 9.81 * t * t)});
    }
    K.include(kinetic_energy(s));
    remainder = std::max(remainder, momentum_remainder(s) / mass);
    lowest = std::min(lowest, center[1] - start[1]);
    for (const StepNumber& number : s.solver().step_numbers()) {
      if (number.name == "penetrated_particles") penetrated = std::max(penetrated, number.value);
    }
  });
  sim.run();
  return {{"free_fall", fall},
          {"penetrated", penetrated},
          {"momentum_remainder", remainder},
          {"energy_remainder", std::abs(transfer_loss(sim)) / K.greatest},
          {"deepest", lowest}};
}

}  // namespace

void add_fem(VerifySuite& suite) {
  add_problem(
      suite,
      {"fem",
       "patch test",
       "fem",
       true,
       true,
       1e4,
       {},
       [] {
         Measured m = patch(2);
         m.merge(patch(1));
         return m;
       }},
      {at_most("patch_spread_of_F_order2", 1e-11, "uniform on a graded mesh"), at_most("patch_stress_error_order2", 1e-10, "the traction"),
       at_most("patch_spread_of_F_order1", 1e-11, "uniform on a graded mesh"),
       at_most("patch_stress_error_order1", 1e-10, "the traction")});
  struct Elastica {
    Real k, deflection, shortening;
  };
  const std::vector<Elastica> table = {{0.25, 0.08275, 0.00412}, {0.5, 0.16214, 0.01592}, {1, 0.30172, 0.05643},
                                       {2, 0.49346, 0.16064},    {5, 0.71379, 0.38763},   {10, 0.81061, 0.55500}};
  std::vector<VerifyRow> rows;
  for (const Elastica& one : table) {
    rows.push_back(within(fmt::format("elastica_deflection_k{}", one.k), one.deflection, 0.01 * one.deflection, "Mattiasson (1981)"));
    rows.push_back(within(fmt::format("elastica_shortening_k{}", one.k), one.shortening, 0.01 * one.shortening, "Mattiasson (1981)"));
  }
  add_problem(suite,
              {"fem",
               "elastica",
               "fem",
               true,
               true,
               1e6,
               {},
               [table] {
                 Measured m;
                 for (const Elastica& one : table) {
                   const auto [deflection, shortening] = elastica(one.k);
                   m[fmt::format("elastica_deflection_k{}", one.k)] = deflection;
                   m[fmt::format("elastica_shortening_k{}", one.k)] = shortening;
                 }
                 return m;
               }},
              std::move(rows));
  const auto add_cantilever = [&](int nx, int ny, Real period, Real minimum, bool is_quick) {
    const std::string tail = fmt::format("_{}x{}", nx, ny);
    add_problem(
        suite, {"fem", "cantilever" + tail, "fem", is_quick, true, 1e7, {}, [=] { return fem_cantilever(nx, ny); }},
        {within("period" + tail, period, 0.002 * period, "reference"),
         within("first_minimum" + tail, minimum, -0.002 * minimum, "reference"), within("energy_ratio_8s" + tail, 1, 0.001, "no loss")});
  };
  add_cantilever(5, 2, 0.7574, -0.3683, true);
  add_cantilever(10, 4, 0.7672, -0.3751, false);
  add_cantilever(20, 8, 0.7698, -0.3771, false);
  add_problem(suite, {"fem", "Turek & Hron CSM1", "fem", true, true, 1e5, {}, &csm1},
              {within("csm1_ux", -7.187e-3, 0.03 * 7.187e-3, "Turek & Hron (2006)"),
               within("csm1_uy", -66.10e-3, 0.03 * 66.10e-3, "Turek & Hron (2006)")});
  add_problem(suite, {"fem", "Turek & Hron CSM3", "fem", true, true, 1e6, {}, &csm3},
              {within("csm3_uy_mean", -63.607e-3, 0.03 * 63.607e-3, "Turek & Hron (2006)"),
               within("csm3_uy_amplitude", 65.160e-3, 0.03 * 65.160e-3, "Turek & Hron (2006)"),
               within("csm3_frequency", 1.0995, 0.03 * 1.0995, "Turek & Hron (2006)")});
  add_problem(
      suite,
      {"fem",
       "Cook's membrane",
       "fem",
       true,
       true,
       1e5,
       {},
       [] {
         return Measured{{"cook_uy", cook_membrane(32)}};
       }},
      {within("cook_uy", 32.24, 0.005 * 32.24, "CoFEA, Calculix 32.27, Code_Aster 32.20, Elmer 32.28 mm; E = 70 MPa, nu = 1/3, 6.25 MPa")});
  add_problem(suite, {"basket", "a disk thrown into a basket", "basket", true, true, 1e7, {}, &basket},
              {at_most("free_fall", 1e-11, "the parabola, before contact"), at_most("penetrated", 0, "no particle in the basket"),
               at_most("momentum_remainder", 1e-8, "over 1 m/s of the disk"),
               at_most("energy_remainder", 5e-3, "of the greatest kinetic energy, beside the parts that the ledger names")});
  for (const Real correction : {0.0, 0.3}) {
    const std::string tail = correction > 0 ? "_Cc0.3" : "";
    add_problem(suite,
                {"fem",
                 fmt::format("a body of particles meets one of elements, C_c = {}", correction),
                 "fem",
                 true,
                 true,
                 1e6,
                 {},
                 [=] { return meeting(correction, tail); }},
                {at_most("meeting_momentum_change" + tail, 1e-10, "both bodies free"),
                 at_least("meeting_share_of_momentum" + tail, 0.1, "they did meet"),
                 at_most("meeting_energy_remainder" + tail, 1e-3, "of the kinetic energy, beside the parts that the ledger names")});
  }
}

}  // namespace matpoint
