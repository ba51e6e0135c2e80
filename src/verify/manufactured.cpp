// The explicit solver's orders of convergence: two exact motions that body forces bring about, for combinations of shape functions,
// transfers and formulations. Those that stall or diverge are shown beside those that converge (docs/verification.md).
#include <algorithm>
#include <cmath>
#include <numbers>

#include "verify/analytic.hpp"

namespace matpoint {
namespace {

constexpr Real k_pi = std::numbers::pi;

/// A combination, and how many particles a cell has in each direction.
struct Scheme {
  std::string name;  ///< As in the rows: "total_bspline2_flip".
  std::string shape;
  std::string transfer;
  std::string formulation;
  int particles = 2;
};

Scheme scheme_of(const std::string& formulation, const std::string& shape, const std::string& transfer, int particles) {
  return {fmt::format("{}_{}_{}_{}", formulation, shape, transfer, particles), shape, transfer, formulation, particles};
}

/// An exact motion on a square (or a bar of it, in 3D) that is at rest before t = 0.
struct Motion {
  Real lower = 0;
  Real upper = 1;
  Real E = 0;
  Real nu = 0.3;
  Real rho = 1000;
  Real end = 0;           ///< [s]
  std::string wall_kind;  ///< Of all sides.
  std::function<Vec3(const Vec3& X, Real t)> displacement;
  std::function<Vec3(const Vec3& X, Real t)> velocity;
  std::function<Vec3(const Vec3& X, Real t)> force;  ///< Per mass [m/s^2].
  std::function<bool(const Vec3& X)> is_measured = [](const Vec3&) { return true; };
};

struct MotionVelocity final : VelocityField {
  const Motion& motion;
  Real t;
  MotionVelocity(const Motion& of, Real at) : motion(of), t(at) {}
  Vec3 at(const Vec3& X) const override { return motion.velocity(X, t); }
  Input write(int) const override { return Input::table(); }
};

Case motion_case(const Motion& motion, const Scheme& scheme, int cells, int dim, Real dt) {
  // In 3D a bar, five cells thick.
  const Real h = (motion.upper - motion.lower) / cells;
  const std::string lower = fmt::format("[{0}, {0}{1}]", motion.lower, dim == 3 ? ", 0" : "");
  const std::string upper = fmt::format("[{0}, {0}{1}]", motion.upper, dim == 3 ? fmt::format(", {}", 5 * h) : "");
  std::string text = fmt::format(
      "dim = {}\n[grid]\nlower = {}\nupper = {}\ncells = [{}, {}{}]\n[time]\ndt = {}\nend = {}\n"
      "[solver]\nstress_order = \"usl\"\nshape = \"{}\"\ntransfer = \"{}\"\n"
      "[[body]]\nname = \"square\"\nformulation = \"{}\"\nregion = {{ type = \"box\", lower = {}, upper = {} }}\n"
      "layout = {{ type = \"per_cell\", count = {} }}\n"
      "material = {{ type = \"neo_hookean\", density = {}, youngs_modulus = {}, poissons_ratio = {} }}\n",
      dim, lower, upper, cells, cells, dim == 3 ? ", 5" : "", dt, motion.end, scheme.shape, scheme.transfer, scheme.formulation, lower,
      upper, static_cast<int>(std::lround(std::pow(scheme.particles, dim))), motion.rho, motion.E, motion.nu);
  for (const char* side : {"left", "right", "bottom", "top"})
    text += fmt::format("[[boundary]]\nside = \"{}\"\nkind = \"{}\"\n", side, motion.wall_kind);
  if (dim == 3) text += "[[boundary]]\nside = \"front\"\n[[boundary]]\nside = \"back\"\n";
  return case_from_text("motion", text);
}

/// Greatest RMS error [m] of the particles' positions during the motion; infinite when the run fails.
Real motion_error(const Motion& motion, const Scheme& scheme, int cells, int dim = 2) {
  const Real h = (motion.upper - motion.lower) / cells;
  const Index steps = static_cast<Index>(std::ceil(motion.end / (0.2 * h / (1.2 * std::sqrt(motion.E / motion.rho)))));
  const Real dt = motion.end / static_cast<Real>(steps);
  Case problem = motion_case(motion, scheme, cells, dim, dt);
  // USL's velocities are those of the middle of a step.
  problem.bodies[0].velocity = std::make_shared<MotionVelocity>(motion, -0.5 * dt);
  std::vector<Real> X;
  const auto components = static_cast<std::size_t>(dim);
  const auto place = [&](std::size_t p) {
    Vec3 x{};
    std::copy_n(X.begin() + static_cast<std::ptrdiff_t>(p * components), dim, x.begin());
    return x;
  };
  problem.body_force = std::make_shared<BodyForce>();
  problem.body_force->is_of_particles = true;
  problem.body_force->at = [&](Real t, const std::vector<Real>&, std::vector<Real>& values) {
    for (std::size_t p = 0; p < values.size() / components; ++p) {
      const Vec3 b = motion.force(place(p), t);
      std::copy_n(b.begin(), dim, values.begin() + static_cast<std::ptrdiff_t>(p * components));
    }
  };
  Simulation sim(problem);
  X = sim.solver().field(0, "position").values;
  Real greatest = 0;
  every(sim, std::max<Index>(1, steps / 40), [&](const Simulation& now) {
    const std::vector<Real> x = now.solver().field(0, "position").values;
    Real sum = 0;
    std::size_t count = 0;
    for (std::size_t p = 0; p < x.size() / components; ++p) {
      if (!motion.is_measured(place(p))) continue;
      const Vec3 u = motion.displacement(place(p), now.time());
      for (std::size_t d = 0; d < components; ++d) sum += std::pow(x[p * components + d] - X[p * components + d] - u[d], 2);
      ++count;
    }
    greatest = std::max(greatest, std::sqrt(sum / static_cast<Real>(count)));
  });
  try {
    sim.run();
  } catch (const SolverError&) {
    return std::numeric_limits<Real>::infinity();
  }
  return greatest;
}

/// u_1 = A sin(2 pi X) sin(c pi t), u_2 the same in Y half a period later. Source: Wallstedt & Guilkey (2008), axis-aligned displacement.
Motion axis_aligned(Real A) {
  Motion motion;
  motion.E = 1e7;
  motion.end = 0.02;
  motion.wall_kind = "slip";
  const Real c = std::sqrt(motion.E / motion.rho);
  const Real mu = motion.E / (2 * (1 + motion.nu));
  const Real lambda = motion.E * motion.nu / ((1 + motion.nu) * (1 - 2 * motion.nu));
  const auto phase = [=](std::size_t i, Real t) { return c * k_pi * t + (i == 1 ? k_pi : 0); };
  const auto u = [=](const Vec3& X, std::size_t i, Real t) { return A * std::sin(2 * k_pi * X[i]) * std::sin(phase(i, t)); };
  motion.displacement = [=](const Vec3& X, Real t) { return Vec3{u(X, 0, t), u(X, 1, t), 0}; };
  motion.velocity = [=](const Vec3& X, Real t) {
    const auto v = [&](std::size_t i) { return A * c * k_pi * std::sin(2 * k_pi * X[i]) * std::cos(phase(i, t)); };
    return Vec3{v(0), v(1), 0};
  };
  motion.force = [=, rho = motion.rho, E = motion.E](const Vec3& X, Real t) {
    const auto stretch = [&](std::size_t i) { return 1 + 2 * k_pi * A * std::cos(2 * k_pi * X[i]) * std::sin(phase(i, t)); };
    const Real log_J = std::log(stretch(0) * stretch(1));
    const auto b = [&](std::size_t i) {
      return k_pi * k_pi * u(X, i, t) / rho * (4 * mu - E + 4 / (stretch(i) * stretch(i)) * (lambda * (1 - log_J) + mu));
    };
    return Vec3{b(0), b(1), 0};
  };
  return motion;
}

/// A ring whose points turn by the angle g(t) h(R) about the centre and back. Source: Kamojjala, Brannon, Sadeghirad & Guilkey (2015),
/// generalized vortex; the body force by the balance of momentum, as derived in docs/verification.md.
Motion vortex(Real G) {
  Motion motion;
  motion.lower = -1.5;
  motion.upper = 1.5;
  motion.E = 1e3;
  motion.end = 1;
  motion.wall_kind = "fixed";
  const Real m = motion.E / (2 * (1 + motion.nu)) / motion.rho;
  constexpr Real w = 0.5;
  const auto radius = [](const Vec3& X) { return std::hypot(X[0], X[1]); };
  const auto is_in_ring = [=](Real R) { return std::abs(R - 1) < w / 2; };
  const auto h = [=](Real R) { return is_in_ring(R) ? 1 - 8 * std::pow((R - 1) / w, 2) + 16 * std::pow((R - 1) / w, 4) : 0; };
  const auto dh = [=](Real R) { return is_in_ring(R) ? (-16 * (R - 1) / w + 64 * std::pow((R - 1) / w, 3)) / w : 0; };
  const auto ddh = [=](Real R) { return is_in_ring(R) ? (-16 + 192 * std::pow((R - 1) / w, 2)) / (w * w) : 0; };
  const auto g = [=](Real t) { return G * std::sin(k_pi * t); };
  const auto dg = [=](Real t) { return G * k_pi * std::cos(k_pi * t); };
  motion.displacement = [=](const Vec3& X, Real t) {
    const Real R = radius(X);
    const Real angle = std::atan2(X[1], X[0]) + g(t) * h(R);
    return Vec3{R * std::cos(angle) - X[0], R * std::sin(angle) - X[1], 0};
  };
  motion.velocity = [=](const Vec3& X, Real t) {
    const Real R = radius(X);
    const Real angle = std::atan2(X[1], X[0]) + g(t) * h(R);
    const Real speed = R * dg(t) * h(R);
    return Vec3{-speed * std::sin(angle), speed * std::cos(angle), 0};
  };
  motion.force = [=](const Vec3& X, Real t) {
    const Real R = radius(X);
    if (!is_in_ring(R)) return Vec3{};
    const Real a = g(t) * h(R);
    const Real K = m * (3 * g(t) * dh(R) + R * g(t) * ddh(R)) + R * k_pi * k_pi * g(t) * h(R);
    const Real centre = m * R * std::pow(g(t) * dh(R), 2) - R * std::pow(dg(t) * h(R), 2);
    const Real b_R = K * std::sin(a) + centre * std::cos(a);
    const Real b_T = -K * std::cos(a) + centre * std::sin(a);
    return Vec3{(b_R * X[0] - b_T * X[1]) / R, (b_R * X[1] + b_T * X[0]) / R, 0};
  };
  motion.is_measured = [=](const Vec3& X) { return radius(X) > 0.6 && radius(X) < 1.4; };
  return motion;
}

Real order(Real coarse, Real fine, int halvings) { return std::log2(coarse / fine) / halvings; }

/// A least order, or, with a minus, a greatest one: of what stalls or diverges.
VerifyRow bound_of(const std::string& quantity, Real order, const std::string& source) {
  return order > 0 ? at_least(quantity, order, source) : at_most(quantity, -order, source + "; does not converge");
}

/// Errors of a scheme on cells[0], cells[1], ..., divided by `scale`, and the order between the first and another of them.
Measured errors(const std::string& head, const Motion& motion, const Scheme& scheme, const std::vector<int>& cells, Real scale,
                int dim = 2) {
  Measured m;
  for (const int n : cells) m[fmt::format("{}_{}_{}", scheme.name, head, n)] = motion_error(motion, scheme, n, dim) / scale;
  return m;
}

}  // namespace

void add_manufactured(VerifySuite& suite) {
  const std::string wallstedt = "Wallstedt & Guilkey (2008)";
  const std::string kamojjala = "Kamojjala et al. (2015)";
  const auto axis_job = [&](const Scheme& scheme, const std::string& A, const std::vector<int>& cells, bool is_quick, Real bound,
                            int order_end) {
    const std::string tail = fmt::format("{}_A{}", scheme.name, A);
    const std::string quantity = fmt::format("{}_order_{}_{}", tail, cells.front(), order_end);
    VerifyJob job{"axis_aligned", tail, "axis_aligned", is_quick, true, 2e5 * std::pow(cells.back() / 8.0, 3), {}, {}};
    job.run = [=] {
      const Real amplitude = std::stod(A);
      Measured m = errors("A" + A, axis_aligned(amplitude), scheme, cells, amplitude);
      const auto at = [&](int n) { return m.at(fmt::format("{}_{}", tail, n)); };
      m[quantity] = order(at(cells.front()), at(order_end), static_cast<int>(std::lround(std::log2(order_end / cells.front()))));
      return m;
    };
    add_problem(suite, job, {bound_of(quantity, bound, wallstedt)});
  };
  const std::vector<int> to_64 = {8, 16, 32, 64};
  const std::vector<int> to_32 = {8, 16, 32};
  axis_job(scheme_of("total", "linear", "flip", 2), "0.05", to_64, true, 1.9, 64);
  axis_job(scheme_of("total", "bspline2", "flip", 2), "0.05", to_64, true, 1.9, 64);
  axis_job(scheme_of("updated", "bspline2", "flip", 4), "1e-4", to_64, false, 1.9, 64);
  axis_job(scheme_of("updated", "bspline2", "apic", 4), "1e-4", to_64, false, 1.9, 64);
  axis_job(scheme_of("updated", "bspline2", "flip", 4), "0.05", to_64, false, 1.8, 32);
  axis_job(scheme_of("updated", "bspline2", "apic", 4), "0.05", to_64, false, 1.8, 32);
  // Shown beside them. What stalls or diverges is bounded from above: the page of theory says so where users choose.
  axis_job(scheme_of("updated", "linear", "flip", 2), "1e-4", to_64, false, 1.9, 64);
  axis_job(scheme_of("updated", "linear", "flip", 2), "0.02", to_64, false, -0.5, 64);
  axis_job(scheme_of("updated", "linear", "flip", 2), "0.05", to_64, false, -0.5, 64);
  axis_job(scheme_of("updated", "bspline2", "apic", 2), "1e-4", to_64, false, 1.9, 64);
  axis_job(scheme_of("updated", "bspline2", "apic", 2), "0.02", to_64, false, 1.7, 64);
  axis_job(scheme_of("updated", "bspline2", "apic", 2), "0.05", to_64, false, -0.8, 64);
  axis_job(scheme_of("updated", "bspline2", "tpic", 4), "1e-4", to_64, false, 1.9, 64);
  axis_job(scheme_of("updated", "bspline2", "tpic", 4), "0.02", to_64, false, 1.8, 64);
  axis_job(scheme_of("updated", "bspline2", "tpic", 4), "0.05", to_64, false, 1.5, 64);
  axis_job(scheme_of("updated", "bspline2", "flip", 2), "0.05", to_64, false, -1, 64);
  axis_job(scheme_of("updated", "bspline3", "flip", 4), "1e-4", to_64, false, 1.9, 64);
  axis_job(scheme_of("updated", "bspline3", "flip", 4), "0.05", to_64, false, 1.9, 64);
  axis_job(scheme_of("updated", "bspline3", "apic", 4), "0.05", to_64, false, 1.9, 64);
  axis_job(scheme_of("updated", "bspline2", "fmpm", 4), "0.05", to_64, false, 1.8, 32);
  axis_job(scheme_of("updated", "gimp", "flip", 2), "1e-4", to_64, true, 1.9, 64);
  axis_job(scheme_of("updated", "gimp", "flip", 2), "0.05", to_64, false, -1.2, 64);
  axis_job(scheme_of("updated", "gimp", "flip", 4), "0.05", to_64, false, -1.5, 64);
  axis_job(scheme_of("updated", "cpdi", "flip", 2), "1e-4", to_64, false, 1.9, 64);
  axis_job(scheme_of("updated", "cpdi", "flip", 2), "0.05", {16, 32, 64}, true, 1.7, 64);
  axis_job(scheme_of("total", "bspline3", "flip", 2), "0.05", to_64, false, 1.7, 64);
  axis_job(scheme_of("total", "gimp", "flip", 2), "0.05", to_64, false, 1.9, 64);
  {
    // In 3D a bar of the same square, between rollers: 3D agrees with 2D.
    const Scheme scheme = scheme_of("total", "bspline2", "flip", 2);
    VerifyJob job{"axis_aligned", "3D, " + scheme.name, "axis_aligned", true, true, 1e7, {}, {}};
    job.run = [=] {
      const Motion motion = axis_aligned(0.05);
      const Real coarse = motion_error(motion, scheme, 8, 3);
      const Real fine = motion_error(motion, scheme, 16, 3);
      return Measured{{"3D_over_2D_16", fine / motion_error(motion, scheme, 16)}, {"3D_order_8_16", order(coarse, fine, 1)}};
    };
    add_problem(suite, job, {within("3D_over_2D_16", 1, 1e-6, "the same in 2D"), at_least("3D_order_8_16", 1.8, wallstedt)});
  }
  {
    const Scheme scheme = scheme_of("updated", "bspline2", "apic", 4);
    VerifyJob job{"axis_aligned", "3D, " + scheme.name, "axis_aligned", false, true, 1e7, {}, {}};
    job.run = [=] {
      const Motion motion = axis_aligned(0.05);
      const Real fine = motion_error(motion, scheme, 16, 3);
      return Measured{{"3D_over_2D_apic_16", fine / motion_error(motion, scheme, 16)}};
    };
    add_problem(suite, job, {within("3D_over_2D_apic_16", 1, 1e-6, "the same in 2D")});
  }

  const auto vortex_job = [&](const Scheme& scheme, const std::string& G, const std::vector<int>& cells, Real bound, int from) {
    const std::string tail = fmt::format("{}_G{}", scheme.name, G);
    const std::string quantity = fmt::format("{}_order_{}_{}", tail, from, cells.back());
    VerifyJob job{"vortex", tail, "vortex", false, true, 1e6 * std::pow(cells.back() / 48.0, 3), {}, {}};
    job.run = [=] {
      Measured m = errors("G" + G, vortex(std::stod(G)), scheme, cells, 1);
      const auto at = [&](int n) { return m.at(fmt::format("{}_{}", tail, n)); };
      m[quantity] = order(at(from), at(cells.back()), static_cast<int>(std::lround(std::log2(cells.back() / from))));
      return m;
    };
    add_problem(suite, job, {bound_of(quantity, bound, kamojjala)});
  };
  vortex_job(scheme_of("total", "bspline2", "flip", 2), "0.5", {48, 96, 192, 384}, 1.8, 48);
  vortex_job(scheme_of("total", "linear", "flip", 2), "0.5", {48, 96, 192}, 1.1, 48);
  vortex_job(scheme_of("updated", "bspline2", "apic", 4), "0.1", {24, 48, 96, 192}, 2, 24);
  vortex_job(scheme_of("updated", "bspline2", "apic", 4), "0.5", {24, 48, 96, 192}, -0.5, 24);
  vortex_job(scheme_of("updated", "linear", "flip", 2), "0.1", {24, 48, 96, 192}, -0.5, 24);
  vortex_job(scheme_of("updated", "cpdi", "flip", 2), "0.1", {24, 48, 96, 192}, 1.7, 24);
  vortex_job(scheme_of("updated", "cpdi", "flip", 2), "0.5", {24, 48, 96, 192}, -0.5, 24);
  {
    const Scheme scheme = scheme_of("total", "bspline2", "flip", 2);
    VerifyJob job{"vortex", scheme.name + "_G1", "vortex", true, true, 1e7, {scheme.name + "_G1_96"}, {}};
    job.run = [=] { return errors("G1", vortex(1), scheme, {48, 96}, 1); };
    add_problem(suite, job, {at_most(scheme.name + "_G1_96", 0.015, kamojjala)});
  }
}

}  // namespace matpoint
