// A body that no force acts on: nothing may happen to it, however stiff it is, wherever its particles are in their cells, in every
// combination of shape, transfer, order and precision on offer. With nodes of next to no mass this is a hard test.
#include <random>

#include "case/case_file.hpp"
#include "support/solver_case.hpp"

namespace matpoint::test {
namespace {

struct Scheme {
  std::string shape, transfer, order, precision;
  bool is_single() const { return precision == "single"; }
};

std::vector<Scheme> schemes() {
  std::vector<Scheme> all;
  for (const char* shape : {"linear", "bspline2", "bspline3", "gimp", "cpdi"}) {
    for (const char* transfer : {"flip", "pic", "apic", "tpic", "fmpm"}) {
      for (const char* order : {"usl", "usf", "musl"}) {
        for (const char* precision : {"double", "single"}) all.push_back({shape, transfer, order, precision});
      }
    }
  }
  return all;
}

/// The case with the scheme; nothing where that is refused, which only these may be.
std::optional<Case> read(const std::string& text, const Scheme& scheme) {
  Input input = parse_toml(text, "flight.toml");
  apply_set(input, "solver.shape=" + scheme.shape);
  apply_set(input, "solver.transfer=" + scheme.transfer);
  apply_set(input, "solver.stress_order=" + scheme.order);
  apply_set(input, "solver.precision=" + scheme.precision);
  try {
    return Case::from_input(input, "flight");
  } catch (const InputError& error) {
    const bool is_affine = scheme.transfer == "apic" || scheme.transfer == "tpic";
    EXPECT_TRUE((scheme.shape == "cpdi" && (scheme.order == "usf" || scheme.transfer == "apic")) ||
                (scheme.shape == "linear" && scheme.is_single() && (is_affine || (scheme.transfer == "fmpm" && scheme.order == "usl"))))
        << error.what();
    return std::nullopt;
  }
}

TEST(FreeFlight, of_20_cells_at_0_4_c_changes_nothing) {
  for (const Real E : {1e5, 2e11}) {
    const Real c = std::sqrt(E * 0.7 / (1.3 * 0.4) / 7800);
    const std::string text = fmt::format(
        R"(
[grid]
upper = [2, 1.2]
cell_size = 0.05
[time]
end = {}
[[body]]
name = "disk"
region = {{ type = "disk", center = [0.5, 0.5], radius = 0.2 }}
layout = {{ type = "per_cell", count = 4 }}
velocity = {{ type = "uniform", value = [{}, {}] }}
material = {{ type = "neo_hookean", density = 7800, youngs_modulus = {}, poissons_ratio = 0.3 }}
)",
        2.5 / c, 0.4 * c, 0.1 * c, E);
    for (const Scheme& scheme : schemes()) {
      const std::optional<Case> problem = read(text, scheme);
      if (!problem) continue;
      Simulation sim(*problem);
      const BodyTotals start = sim.solver().totals(0);
      Real J_off = 0, energy_off = 0;
      sim.add_callback([&](const Simulation& now) {
        const BodyTotals totals = now.solver().totals(0);
        J_off = std::max({J_off, std::abs(totals.J_min - 1), std::abs(totals.J_max - 1)});
        energy_off = std::max(energy_off, std::abs((totals.kinetic_energy + totals.strain_energy) / start.kinetic_energy - 1));
        return true;
      });
      sim.run();
      const std::string name = scheme.shape + " " + scheme.transfer + " " + scheme.order + " " + scheme.precision;
      const BodyTotals end = sim.solver().totals(0);
      for (std::size_t d = 0; d < 2; ++d) {
        EXPECT_NEAR(end.momentum[d], start.momentum[d], (scheme.is_single() ? 1e-4 : 1e-10) * start.momentum[0]) << name;
      }
      EXPECT_LT(energy_off, scheme.is_single() ? 1e-4 : 1e-10) << name;
      EXPECT_LT(J_off, scheme.is_single() ? 1e-5 : 1e-10) << name;
      EXPECT_EQ(sim.solver().ledger().cutoff_impulse[0], 0) << name;
    }
  }
}

/// 7 x 7 (x 7) points `spacing` [m] apart from .5 on.
std::vector<Vec3> lattice_of(int dim, Real spacing) {
  std::vector<Vec3> points;
  for (int k = 0; k < (dim == 3 ? 7 : 1); ++k) {
    for (int j = 0; j < 7; ++j) {
      for (int i = 0; i < 7; ++i) points.push_back({0.5 + spacing * i, 0.5 + spacing * j, dim == 3 ? 0.5 + spacing * k : 0});
    }
  }
  return points;
}

TEST(FreeFlight, one_step_strains_nothing_wherever_the_points_are) {
  for (const int dim : {2, 3}) {
    std::vector<std::vector<Vec3>> arrangements = {lattice_of(dim, 0.05), lattice_of(dim, 0.1)};  // on lines and middles, on nodes
    std::mt19937 generator(1);
    std::uniform_real_distribution<Real> anywhere(0.5, 0.8);
    std::vector<Vec3> random(200);
    for (Vec3& x : random) x = {anywhere(generator), anywhere(generator), dim == 3 ? anywhere(generator) : 0};
    arrangements.push_back(random);
    for (const std::vector<Vec3>& points : arrangements) {
      for (const Scheme& scheme : schemes()) {
        const std::string box = dim == 2 ? "upper = [2, 2]\ncells = [20, 20]" : "upper = [2, 2, 2]\ncells = [20, 20, 20]";
        std::optional<Case> problem =
            read(fmt::format("dim = {}\n[grid]\n{}\n[time]\nend = 1\ndt = 1e-3\n[[body]]\nname = \"b\"\nlayout = {{ type = \"points\", "
                             "positions = [{}], volumes = [1e-3] }}\nvelocity = {{ type = \"uniform\", value = {} }}\nmaterial = {{ type = "
                             "\"neo_hookean\", density = 1000, youngs_modulus = 1e5, poissons_ratio = 0.3 }}\n",
                             dim, box, dim == 2 ? "[0.5, 0.5]" : "[0.5, 0.5, 0.5]", dim == 2 ? "[1, 0.5]" : "[1, 0.5, 0.25]"),
                 scheme);
        if (!problem) continue;
        problem->bodies[0].layout = points_layout(points, {1e-3});
        Simulation sim(*problem);
        sim.step();
        const std::vector<Real> F = sim.solver().field(0, "deformation_gradient").values;
        Real off = 0;
        for (std::size_t k = 0; k < F.size(); ++k) off = std::max(off, std::abs(F[k] - (k % 9 % 4 == 0 ? 1 : 0)));
        EXPECT_LT(off, scheme.is_single() ? 1e-6 : 1e-12) << dim << "D " << scheme.shape << " " << scheme.transfer << " " << scheme.order;
      }
    }
  }
}

TEST(FreeFlight, steel_falls_as_everything_does) {
  for (const int dim : {2, 3}) {
    Case problem = make_case(dim, {0, 0, 0}, {1, 2, dim == 3 ? 1.0 : 0.0}, {20, 40, 20});
    problem.grid.cells.resize(static_cast<std::size_t>(dim));
    problem.bodies.push_back(make_body("ball", lattice(dim, {0.3, 1.4, 0.3}, {0.7, 1.8, 0.7}, {16, 16, 16}), neo_hookean(1e9, 0.3, 7800)));
    problem.gravity = {0, -9.81, 0};
    problem.time.end = 0.1;
    Simulation sim(problem);
    Real sum_of_squares = 0;
    sim.add_callback([&](const Simulation& now) {
      sum_of_squares += now.last_dt() * now.last_dt();
      return true;
    });
    const Real mass = sim.solver().totals(0).mass;
    sim.run();
    // A step moves with its new velocity: g/2 sum dt^2 beyond g t^2 / 2.
    const BodyTotals end = sim.solver().totals(0);
    EXPECT_NEAR(end.center_of_mass[1], 1.6 - 9.81 * 0.005 - 0.5 * 9.81 * sum_of_squares, 1e-9);
    EXPECT_NEAR(end.momentum[1], -mass * 9.81 * 0.1, 1e-10 * mass);
    EXPECT_LT(end.von_mises_max, 1e-10 * 1e9);
    EXPECT_NEAR(end.J_max, 1, 1e-10);
  }
}

}  // namespace
}  // namespace matpoint::test
