// Bodies of rings around an axis: uniform states are exact up to the axis, breathing bodies have their periods, books close, and what
// cannot be is refused.
#include <gmock/gmock.h>

#include <numbers>

#include "core/parallel.hpp"
#include "run/risks.hpp"
#include "support/from_toml.hpp"
#include "support/solver_case.hpp"

namespace matpoint::test {
namespace {

constexpr Real pi = std::numbers::pi;

/// A cylinder of radius and height 0.8, or a ring whose inner radius is where the grid begins.
std::string cylinder(const std::string& solver, const std::string& material, const std::string& more = "", Real lower = 0,
                     const char* steps = "dt = 1e-4") {
  return fmt::format(R"(
gravity = [0, 0]
[grid]
axisymmetric = true
lower = [{0}, 0]
upper = [{1}, 1]
cell_size = 0.1
[time]
end = 0.01
{2}
[solver]
{3}
[[body]]
name = "body"
region = {{ type = "box", lower = [{0}, 0], upper = [{4}, 0.8] }}
layout = {{ type = "per_cell", count = 4 }}
material = {5}
{6}
)",
                     lower, lower + 1, steps, solver, lower + 0.8, material, more);
}

const std::string k_soft = "{ type = \"neo_hookean\", density = 1000, youngs_modulus = 1e6, poissons_ratio = 0.25 }";
const std::string k_gas = "{ type = \"newtonian_fluid\", density = 1000, pressure_scale = 1e5, gamma = 7, viscosity = 0 }";
const std::string k_widening = "velocity = { type = \"linear\", gradient = [[2, 0], [0, -1]] }\n";

TEST(Axisymmetry, a_uniform_rate_is_exact_up_to_the_axis) {
  // Affine transfers map a linear field as it is, whatever the masses of the rings.
  for (const std::string shape : {"linear", "gimp", "bspline2", "bspline3"}) {
    for (const std::string order : {"musl", "usl", "usf"}) {
      if (shape == "linear" && order == "usl") continue;  // refused with affine transfers
      for (const Real lower : {0.0, 0.35}) {
        const std::string solver = fmt::format("shape = \"{}\"\ntransfer = \"tpic\"\nstress_order = \"{}\"\n", shape, order);
        // Of no stiffness to speak of: the first step's rate is that of the field.
        Simulation sim(read(cylinder(solver, "{ type = \"neo_hookean\", density = 1000, youngs_modulus = 1e-9, poissons_ratio = 0.25 }",
                                     k_widening, lower)));
        sim.step();
        const std::vector<Real> F = sim.solver().field(0, "deformation_gradient").values;
        for (std::size_t p = 0; 9 * p < F.size(); ++p) {
          for (std::size_t e = 0; e < 9; ++e) {
            const Real exact = e == 0 || e == 8 ? 1 + 2e-4 : e == 4 ? 1 - 1e-4 : 0;
            // A ring that begins off the axis: the rate around it is v / r of the same field.
            EXPECT_NEAR(F[9 * p + e], exact, 1e-12) << shape << " " << order << " " << lower << " " << p << " " << e;
          }
        }
      }
    }
  }
}

TEST(Axisymmetry, a_uniform_pressure_is_at_rest) {
  // In a full box, of linear shapes and GIMP, whose functions particles in rows integrate exactly.
  for (const std::string shape : {"linear", "gimp"}) {
    for (const Real lower : {0.0, 0.3}) {
      Simulation sim(read(cylinder("shape = \"" + shape + "\"\n", k_soft,
                                   "[[boundary]]\nside = \"right\"\n[[boundary]]\nside = \"bottom\"\n[[boundary]]\nside = \"top\"\n"
                                   "[[boundary]]\nside = \"left\"\n",
                                   lower),
                          {fmt::format("body.body.region.upper=[{}, 1]", lower + 1)}));
      std::vector<Real> F;
      for (Index p = 0; p < sim.solver().particle_count(0); ++p) F.insert(F.end(), {0.99, 0, 0, 0, 0.99, 0, 0, 0, 0.99});
      sim.solver().set_field(0, "deformation_gradient", F);
      for (int k = 0; k < 50; ++k) sim.step();
      EXPECT_LT(greatest_magnitude(sim.solver().field(0, "velocity").values), 1e-10) << shape << lower;  // 0.3 m/s if one hoop were missing
      EXPECT_GT(sim.solver().totals(0).strain_energy, 100);
      // The wall carries the pressure on its cylinder; of volumes that are set smaller than their places are, that share of it.
      const std::vector<Real> stress = sim.solver().field(0, "stress").values;
      EXPECT_NEAR(sim.solver().boundaries()[0].force[0], 0.970299 * stress[0] * 2 * pi * (lower + 1), 1e-6 * std::abs(stress[0]) * 2 * pi)
          << shape;
    }
  }
}

TEST(Axisymmetry, masses_are_those_of_rings) {
  Simulation sim(read(cylinder("", k_soft)));
  EXPECT_NEAR(sim.solver().totals(0).mass, 1000 * pi * 0.64 * 0.8, 1e-9 * 1000);
  Simulation ring(read(cylinder("", k_soft, "", 0.5)));
  EXPECT_NEAR(ring.solver().totals(0).mass, 1000 * pi * (1.3 * 1.3 - 0.25) * 0.8, 1e-8 * 1000);
  // What is beyond the axis is the other half of the body.
  Simulation sphere(read(cylinder("", k_soft, "", 0), {"body.body.region={ type = \"disk\", center = [0, 0.5], radius = 0.4 }"}));
  EXPECT_NEAR(sphere.solver().totals(0).mass, 1000 * 4 / 3 * pi * 0.064, 0.03 * 1000 * 4 / 3 * pi * 0.064);
}

TEST(Axisymmetry, a_fluid_that_widens_keeps_its_books) {
  // J' = J tr L, with the hoop.
  Simulation sim(read(cylinder("", k_gas, k_widening)));
  sim.step();
  const std::vector<Real> F = sim.solver().field(0, "deformation_gradient").values, x = sim.solver().field(0, "position").values;
  for (std::size_t p = 0; 9 * p < F.size(); ++p) {
    // FLIP's nodal velocities are off a linear field where rings grow by much from one to the next, and at the surface.
    const Real r = x[2 * p], z = x[2 * p + 1];
    if (r > 0.2 && r < 0.6 && z > 0.2 && z < 0.6) EXPECT_NEAR(std::log(F[9 * p] * F[9 * p + 4] * F[9 * p + 8]), 3e-4, 2e-5);
    EXPECT_NEAR(F[9 * p], F[9 * p + 8], 1e-15);
  }
}

/// A cylinder that widens, falls and shears: the greatest error of its energy, over that at the start.
Real energy_error(const std::string& solver, const char* steps) {
  const std::string moving = "fbar = true\nvelocity = { type = \"linear\", gradient = [[2, 0], [1, -1]] }\n";
  Simulation sim(
      read(cylinder(solver, k_soft, moving, 0, steps), {"gravity=[0, -9.81]", "time.end=0.05", "body.body.region.lower=[0, 0.1]"}));
  const BodyTotals before = sim.solver().totals(0);
  const Real start = whole_energy(sim.solver());
  Real worst = 0;
  sim.add_callback([&](const Simulation& now) {
    worst = std::max(worst, std::abs(whole_energy(now.solver()) / start - 1));
    return true;
  });
  sim.run();
  const BodyTotals after = sim.solver().totals(0);
  const bool is_single = solver.find("single") != std::string::npos;
  EXPECT_NEAR(after.momentum[1] - before.momentum[1], sim.solver().ledger().gravity_impulse[1], (is_single ? 1e-4 : 1e-10) * before.mass)
      << solver;
  EXPECT_EQ(after.particle_count, before.particle_count) << solver;
  return worst;
}

TEST(Axisymmetry, momentum_along_the_axis_and_the_energy_are_kept) {
  // Energies are as of one time but for half a step, so their sum is of first order in the step.
  for (const std::string solver :
       {"", "shape = \"linear\"\n", "shape = \"bspline2\"\n", "stress_order = \"usl\"\n", "stress_order = \"usf\"\n"}) {
    const Real coarse = energy_error(solver, "cfl = 0.3"), fine = energy_error(solver, "cfl = 0.15");
    EXPECT_LT(coarse, 0.03) << solver;
    EXPECT_LT(fine, 0.65 * coarse) << solver;
  }
  // What filters velocities loses some.
  for (const std::string solver : {"transfer = \"apic\"\n", "shape = \"bspline3\"\ntransfer = \"fmpm\"\n", "precision = \"single\"\n"})
    EXPECT_LT(energy_error(solver, "cfl = 0.3"), 0.06) << solver;
}

TEST(Axisymmetry, what_changes_its_cell_brings_its_hoop_along) {
  // Under one pressure, between walls, endless along the axis, along which it flies through a cell in ten steps.
  for (const std::string shape : {"linear", "gimp"}) {
    for (const std::string order : {"musl", "usl", "usf"}) {
      Simulation sim(read(cylinder(fmt::format("shape = \"{}\"\nstress_order = \"{}\"\n", shape, order), k_soft,
                                   "velocity = { type = \"uniform\", value = [0, 10] }\n[[boundary]]\nside = \"right\"\n"),
                          {"grid.periodic=[\"y\"]", "body.body.region.upper=[1, 1]", "time.dt=1e-3"}));
      std::vector<Real> F;
      for (Index p = 0; p < sim.solver().particle_count(0); ++p) F.insert(F.end(), {0.99, 0, 0, 0, 0.99, 0, 0, 0, 0.99});
      sim.solver().set_field(0, "deformation_gradient", F);
      for (int k = 0; k < 40; ++k) sim.step();
      const std::vector<Real> v = sim.solver().field(0, "velocity").values;
      for (std::size_t p = 0; 2 * p < v.size(); ++p) {
        EXPECT_NEAR(v[2 * p], 0, 1e-9) << shape << order << p;
        EXPECT_NEAR(v[2 * p + 1], 10, 1e-9) << shape << order << p;
      }
    }
  }
}

TEST(Axisymmetry, water_that_closes_over_the_axis_gains_nothing) {
  // A ring of water falls in, shoots up along the axis and against a lid.
  for (const char* scale : {"1e4", "1e5"}) {
    Simulation sim(read(fmt::format(R"(
gravity = [0, -9.81]
[grid]
axisymmetric = true
upper = [0.5, 0.5]
cells = [25, 25]
[time]
end = 0.6
[[body]]
name = "water"
region = {{ type = "box", lower = [0.3, 0], upper = [0.5, 0.3] }}
layout = {{ type = "per_cell", count = 4 }}
material = {{ type = "newtonian_fluid", density = 1000, pressure_scale = {}, viscosity = 1e-3 }}
[[boundary]]
side = "bottom"
[[boundary]]
side = "right"
[[boundary]]
side = "top"
)",
                                    scale)));
    const Real start = whole_energy(sim.solver());
    const Index count = sim.solver().particle_count(0);
    Real highest = 0;
    sim.add_callback([&](const Simulation& now) {
      EXPECT_LT(whole_energy(now.solver()), 1.005 * start) << scale << " " << now.time();
      highest = std::max(highest, now.solver().totals(0).upper[1]);
      return true;
    });
    sim.run();
    EXPECT_GT(highest, 0.45) << "the jet";
    EXPECT_EQ(sim.solver().particle_count(0), count);
  }
}

TEST(Axisymmetry, a_body_upside_down_is_its_mirror_image) {
  const auto run = [](Real sign) {
    Simulation sim(
        read(cylinder("", k_soft,
                      fmt::format("velocity = {{ type = \"linear\", gradient = [[2, {}], [0, -1]], center = [0, 0.5] }}\n", sign), 0),
             {"body.body.region.lower=[0, 0.2]", "time.end=0.03"}));
    sim.run();
    return std::pair(sim.solver().field(0, "position").values, sim.solver().field(0, "stress").values);
  };
  const auto [one, one_stress] = run(1);
  const auto [other, other_stress] = run(-1);
  const std::size_t n = one.size() / 2, width = one_stress.size() / n;
  // Particles are in rows from below: of 12 rows the k-th from below is the k-th from above.
  for (std::size_t p = 0; p < n; ++p) {
    bool is_found = false;
    for (std::size_t q = 0; q < n && !is_found; ++q) {
      is_found = std::abs(one[2 * p] - other[2 * q]) < 1e-9 && std::abs(one[2 * p + 1] + other[2 * q + 1] - 1) < 1e-9 &&
                 std::abs(one_stress[width * p] - other_stress[width * q]) < 1e-4;
    }
    EXPECT_TRUE(is_found) << p;
  }
}

TEST(Axisymmetry, any_number_of_threads_gives_the_same_bits) {
  std::vector<std::vector<Real>> results;
  for (const int threads : {1, 2, 3}) {
    set_thread_count(threads);
    Simulation sim(read(cylinder("", k_soft, k_widening, 0, "cfl = 0.3"), {"time.end=0.04"}));
    sim.run();
    results.push_back(sim.solver().field(0, "deformation_gradient").values);
  }
  set_thread_count(0);
  EXPECT_EQ(results[0], results[1]);
  EXPECT_EQ(results[0], results[2]);
}

TEST(Axisymmetry, the_axis_is_held_unless_a_case_says_otherwise) {
  const Case on_axis = read(cylinder("", k_soft));
  ASSERT_EQ(on_axis.boundaries.size(), 1u);
  EXPECT_EQ(on_axis.boundaries[0].side, "left");
  EXPECT_EQ(on_axis.boundaries[0].name, "axis");
  EXPECT_EQ(on_axis.boundaries[0].kind, BoundaryKind::slip);
  EXPECT_TRUE(read(cylinder("", k_soft, "", 0.5)).boundaries.empty()) << "a tube has no axis in it";
  EXPECT_EQ(read(cylinder("", k_soft, "[[boundary]]\nside = \"left\"\nkind = \"fixed\"\n")).boundaries.size(), 1u);
}

TEST(Axisymmetry, an_initial_stress_reaches_around_the_axis) {
  Simulation sim(read(cylinder("", k_soft, "initial_stress = { type = \"uniform\", value = [-1e4, -2e4, -1e4, 0] }\n")));
  const std::vector<Real> stress = sim.solver().field(0, "stress").values;
  const std::size_t width = stress.size() / static_cast<std::size_t>(sim.solver().particle_count(0));
  for (std::size_t p = 0; p * width < stress.size(); ++p) {
    EXPECT_NEAR(stress[p * width], -1e4, 1e-5);
    EXPECT_NEAR(stress[p * width + 1], -2e4, 1e-5);
    EXPECT_NEAR(stress[p * width + 2], -1e4, 1e-5);
  }
}

TEST(Axisymmetry, bodies_that_touch_overlap_no_more_than_they_do) {
  const auto risks = [](const char* lower) {
    const std::string second = fmt::format(
        "[[body]]\nname = \"two\"\nregion = {{ type = \"box\", lower = [3, {}], upper = [3.8, 0.9] }}\nlayout = {{ type = \"per_cell\", "
        "count = 4 "
        "}}\nmaterial = {}\n",
        lower, k_soft);
    const Case problem = read(cylinder("", k_soft, second, 3));
    const Simulation sim(problem);
    return fmt::format("{}", fmt::join(risks_of(problem, sim.solver()), " "));
  };
  EXPECT_THAT(risks("0.8"), testing::Not(testing::HasSubstr("overlap")));
  EXPECT_THAT(risks("0.6"), testing::HasSubstr("overlap at the start: 0.16 m^2"));
}

TEST(Axisymmetry, laws_that_go_by_the_dimension_are_those_of_space) {
  const auto run = [](const char* fit) {
    const std::string sand = fmt::format(
        "{{ type = \"drucker_prager\", density = 1500, youngs_modulus = 1e6, poissons_ratio = 0.3, friction_angle = 30, cohesion = 0{} }}",
        fit);
    Simulation sim(read(cylinder("", sand, "[[boundary]]\nside = \"bottom\"\nkind = \"fixed\"\n", 0, "cfl = 0.4"),
                        {"gravity=[0, -9.81]", "time.end=0.1", "body.body.region.upper=[0.4, 0.8]"}));
    sim.run();
    return sim.solver().field(0, "position").values;
  };
  const std::vector<Real> left_open = run("");
  EXPECT_EQ(left_open, run(", fit = \"compression\""));
  EXPECT_NE(left_open, run(", fit = \"plane\""));
}

TEST(Axisymmetry, what_knows_no_axis_is_refused_by_name) {
  const auto message = [](const std::string& text, std::vector<std::string> set = {}) {
    try {
      Simulation sim(read(text, set));
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  using testing::HasSubstr;
  EXPECT_THAT(message(cylinder("shape = \"cpdi\"\n", k_soft)), HasSubstr("shape cannot be used with grid.axisymmetric = true"));
  EXPECT_THAT(message(cylinder("co_rotating = true\n", k_soft)), HasSubstr("a ring does not turn"));
  EXPECT_THAT(message(cylinder("fluid_correction = true\nshape = \"bspline2\"\n", k_gas)), HasSubstr("fluid_correction cannot be used"));
  EXPECT_THAT(message(cylinder("transfer = \"apic\"\n", k_gas)), HasSubstr("transfer cannot be used with grid.axisymmetric = true unless"));
  EXPECT_THAT(message(cylinder("", k_soft, "formulation = \"total\"\n")), HasSubstr("formulation = \"total\" cannot be used"));
  EXPECT_THAT(message(cylinder("", k_soft), {"gravity=[1, 0]"}), HasSubstr("gravity[0] = 1"));
  EXPECT_THAT(message(cylinder("", k_soft, "", -0.5)), HasSubstr("lower[0] = -0.5 must be >= 0"));
  EXPECT_THAT(message(cylinder("", k_soft), {"grid.periodic=[\"x\"]"}), HasSubstr("periodic cannot be used"));
  const std::string points = "body.body.layout={{ type = \"points\", positions = [[{}, 0.5]], volumes = 0.01 }}";
  const auto at = [&](const char* x) {
    const std::string text = cylinder("", k_soft);
    const std::size_t region = text.find("region =");
    return message(text.substr(0, region) + text.substr(text.find("layout =")), {fmt::format(fmt::runtime(points), x)});
  };
  EXPECT_THAT(at("-0.5"), HasSubstr("outside the grid")) << "a point that is named is not dropped";
  EXPECT_THAT(at("0"), HasSubstr("lies on the axis"));
  EXPECT_THAT(message(cylinder("type = \"implicit\"\n", k_soft)), HasSubstr("axisymmetric is for solver.type = \"explicit\" only"));
  EXPECT_THAT(message(cylinder("contact = \"pairs\"\n", k_soft,
                               "[[body]]\nname = \"two\"\nregion = { type = \"box\", lower = [0, 0.8], upper = [0.5, 1] }\n"
                               "layout = { type = \"per_cell\", count = 4 }\nmaterial = " +
                                   k_soft)),
              HasSubstr("contact cannot be used"));
}

}  // namespace
}  // namespace matpoint::test
