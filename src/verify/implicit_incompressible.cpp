// Nearly incompressible bodies in implicit statics: nothing locks, and pressures are smooth.
#include <Eigen/Dense>
#include <cmath>

#include "core/error.hpp"
#include "verify/analytic.hpp"

namespace matpoint {
namespace {

/// Root mean square of what a fit by x^i y^j, i <= 2, j <= 3, leaves of the pressure, over that of the fit, of points with a < x < b.
Real rest_of_fit(const std::vector<Real>& x, const std::vector<Real>& pressure, Real a, Real b) {
  std::vector<std::size_t> points;
  for (std::size_t p = 0; p < pressure.size(); ++p) {
    if (x[2 * p] > a && x[2 * p] < b) points.push_back(p);
  }
  Eigen::MatrixXd terms(static_cast<Eigen::Index>(points.size()), 12);
  Eigen::VectorXd values(terms.rows());
  for (Eigen::Index k = 0; k < terms.rows(); ++k) {
    const std::size_t p = points[static_cast<std::size_t>(k)];
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 4; ++j) terms(k, 4 * i + j) = std::pow(x[2 * p], i) * std::pow(x[2 * p + 1], j);
    }
    values[k] = pressure[p];
  }
  const Eigen::VectorXd fit = terms * terms.colPivHouseholderQr().solve(values);
  return (values - fit).norm() / fit.norm();
}

/// The beam under its weight: how far its end sinks, and how smooth the pressure is.
std::pair<Real, Real> beam(Real nu, bool is_elements, int factor) {
  Simulation sim(
      case_from_text("beam", fmt::format(R"(
gravity = [0, -9.81]
[grid]
upper = [1.2, 1]
cells = [{}, {}]
[time]
end = 1
dt = 0.5
[solver]
type = "implicit"
mode = "static"
basis = "{}"
[[body]]
name = "beam"
{}
region = {{ type = "box", lower = [0, 0.4], upper = [1, 0.6] }}
material = {{ type = "neo_hookean", density = 1000, youngs_modulus = 1e7, poissons_ratio = {} }}
[[boundary]]
side = "left"
kind = "fixed"
attached = true
)",
                                         24 * factor, 20 * factor, is_elements ? "element" : "bspline",
                                         is_elements ? "method = \"elements\"" : "layout = { type = \"per_cell\", count = 16 }", nu)));
  const std::vector<Real> X = sim.solver().field(0, "position").values;
  sim.run();
  const std::vector<Real> x = sim.solver().field(0, "position").values;
  Real last = 0, sum = 0, count = 0;
  for (std::size_t p = 0; p < X.size(); p += 2) last = std::max(last, X[p]);
  for (std::size_t p = 0; p < X.size(); p += 2) {
    if (X[p] < last - 1e-9) continue;
    sum += X[p + 1] - x[p + 1];
    count += 1;
  }
  // Carried on to the very end by the slope of a cantilever under its weight there, 1.28 of what it sinks per length with 4 % of shear.
  const Real way = sum / count * (1 + 1.28 * (1 - last));
  return {way, rest_of_fit(X, component(sim, 0, "pressure", 0), 0.2, 0.8)};
}

Measured beams() {
  Measured measured;
  for (const auto& [name, is_elements, factor] : {std::tuple("bspline_20", false, 1), std::tuple("bspline_40", false, 2),
                                                  std::tuple("element_20", true, 1), std::tuple("element_40", true, 2)}) {
    Range ends;
    for (const Real nu : {0.499, 0.4999, 0.49999}) {
      const auto [way, rest] = beam(nu, is_elements, factor);
      ends.include(way);
      measured[std::string(name) + "_way"] = way;
      measured[std::string(name) + "_pressure"] = rest;
    }
    measured[std::string(name) + "_spread"] = ends.greatest / ends.least - 1;
  }
  return measured;
}

/// A strip of rubber, 1 x 0.25 m, bonded between plates that come together: its apparent modulus over Young's.
Real bonded_strip(bool is_elements, int cells) {
  const Real h = 0.25 / cells;
  Simulation sim(
      case_from_text("strip", fmt::format(R"(
[grid]
lower = [{0}, 0]
upper = [{1}, 0.25]
cells = [{2}, {3}]
[time]
end = 1
dt = 1
[solver]
type = "implicit"
mode = "static"
basis = "{4}"
[[body]]
name = "strip"
{5}
region = {{ type = "box", lower = [0, 0], upper = [1, 0.25] }}
material = {{ type = "neo_hookean", density = 1, youngs_modulus = 1e6, poissons_ratio = 0.49999 }}
[[boundary]]
side = "bottom"
kind = "fixed"
[[boundary]]
side = "top"
kind = "velocity"
velocity = [0, -1.25e-4]
)",
                                          -4 * h, 1 + 4 * h, 4 * cells + 8, cells, is_elements ? "element" : "bspline",
                                          is_elements ? "method = \"elements\"" : "layout = { type = \"per_cell\", count = 9 }")));
  sim.run();
  for (const BoundaryTotals& boundary : sim.solver().boundaries()) {
    if (boundary.name == "top") return -boundary.force[1] / (1.25e-4 / 0.25) / 1e6;
  }
  return 0;
}

Measured strips() {
  return {{"strip_bspline_8", bonded_strip(false, 8)},
          {"strip_bspline_16", bonded_strip(false, 16)},
          {"strip_element_8", bonded_strip(true, 8)}};
}

}  // namespace

void add_implicit_incompressible(VerifySuite& suite) {
  std::vector<VerifyRow> rows;
  const char* const mixed = "mixed elements, four meshes";
  for (const auto& [name, tolerance] :
       {std::pair("bspline_20", 0.015), std::pair("bspline_40", 0.01), std::pair("element_20", 0.015), std::pair("element_40", 0.01)}) {
    rows.push_back(within(std::string(name) + "_way", 0.0282, tolerance * 0.0282, mixed));
    rows.push_back(at_most(std::string(name) + "_spread", 0.005, "the same for nu = 0.499 to 0.49999"));
    rows.push_back(at_most(std::string(name) + "_pressure", 0.05, "a smooth pressure"));
    // On 4 cells in the height a patch is a half of it, and the pressure's term x y is not linear: 10 %.
    if (std::string(name) == "bspline_20") rows.back().kind = RowKind::goal;
  }
  add_problem(suite, {"implicit_incompressible", "a beam, nu to 0.49999", "implicit_incompressible", true, true, 2e7, {}, &beams}, rows);
  const char* const source = "Gent & Lindley 1959, an approximation";
  add_problem(suite, {"implicit_incompressible", "a bonded rubber strip", "implicit_incompressible", true, true, 2e7, {}, &strips},
              {within("strip_bspline_8", 20.0 / 3, 0.05 * 20 / 3, source), within("strip_bspline_16", 20.0 / 3, 0.05 * 20 / 3, source),
               within("strip_element_8", 20.0 / 3, 0.05 * 20 / 3, source)});
}

}  // namespace matpoint
