// Contact between bodies of particles in fields of their own: exact tangents, forces that make no energy, Coulomb's law.
#include <gmock/gmock.h>

#include "core/parallel.hpp"
#include "implicit/tangent_error.hpp"
#include "io/history.hpp"
#include "support/solver_case.hpp"
#include "support/temporary_folder.hpp"

namespace matpoint::test {
namespace {

/// Two blocks on each other along y, of which the upper one overlaps the lower by 0.02; both end at a slip side on the left.
Case two_blocks(int dim, const std::string& mode, Real friction) {
  const bool is_3d = dim == 3;
  const auto body = [&](const char* name, const char* lower, const char* upper, Real modulus) {
    return fmt::format(R"(
[[body]]
name = "{}"
region = {{ type = "box", lower = [0, {}{}], upper = [{}{}] }}
layout = {{ type = "per_cell", count = {} }}
material = {{ type = "neo_hookean", density = 1000, youngs_modulus = {}, poissons_ratio = 0.3 }}
)",
                       name, lower, is_3d ? ", 0" : "", upper, is_3d ? ", 0.6" : "", is_3d ? 8 : 4, modulus);
  };
  return read(fmt::format(R"(
dim = {}
gravity = {}
[grid]
upper = {}
cells = {}
[time]
end = 0.1
dt = 0.01
[solver]
type = "implicit"
mode = "{}"
contact = "pairs"
friction = {}
[[boundary]]
side = "left"
[[boundary]]
side = "bottom"
kind = "fixed"
[[boundary]]
side = "top"
kind = "velocity"
velocity = {}
)",
                          dim, is_3d ? "[0, 0, 0]" : "[0, 0]", is_3d ? "[1, 0.8, 1]" : "[1, 0.8]", is_3d ? "[5, 4, 5]" : "[10, 8]", mode,
                          friction, is_3d ? "[0, -0.1, 0]" : "[0, -0.1]") +
              body("low", "0", "0.8, 0.4", 1e6) + body("high", "0.38", "0.6, 0.8", 2e6));
}

template <int Dim>
void check_tangent(bool is_dynamic, Real friction, Real slip) {
  Simulation sim(two_blocks(Dim, is_dynamic ? "dynamic" : "static", friction));
  auto& solver = dynamic_cast<ImplicitSolver<Dim>&>(sim.solver());
  // No rows and no symmetry.
  for (std::size_t b : {0, 1}) {
    std::vector<Real> x = solver.field(b, "position").values;
    for (std::size_t k = 0; k < x.size(); ++k) {
      if (k % static_cast<std::size_t>(Dim) == 1) x[k] += 0.004 * std::sin(12.9898 * static_cast<Real>(k));
    }
    solver.set_field(b, "position", x);
  }
  solver.assembly().start();
  StepLoad<Dim> load;
  load.dt = 0.01;
  if (is_dynamic) load.inertia = {4e4, 400, 1};
  // The upper block moves down and along, everything shakes a little.
  std::vector<Real> u(solver.space().nodes().size() * Dim);
  for (std::size_t k = 0; k < u.size(); ++k) {
    const bool is_upper = solver.space().slots()[k / Dim] >= solver.basis().node_count();
    const Vec<Dim> x = solver.basis().node_position(solver.space().nodes()[k / Dim]);
    u[k] = 1e-3 * std::sin(7.0 * x[0] + 11.0 * x[1] + static_cast<Real>(k % Dim));
    if (is_upper && k % Dim == 0) u[k] += slip;
    if (is_upper && k % Dim == 1) u[k] -= 2e-3;
    if (solver.space().unknown(static_cast<Index>(k / Dim), static_cast<int>(k % Dim)) < 0) u[k] = 0;
  }
  EXPECT_LT(tangent_error<Dim>(solver, load, u), 1e-7) << Dim << (is_dynamic ? " dynamic " : " static ") << friction;
  std::vector<Real> residual;
  solver.assembly().residual(u, load, residual);
  EXPECT_GT(greatest_magnitude(residual), 1) << "there should be contact";
}

TEST(BodyContact, tangents_are_exact) {
  for (const bool is_dynamic : {false, true}) {
    check_tangent<2>(is_dynamic, 0, 0);
    check_tangent<2>(is_dynamic, 0.3, 1e-4);
    check_tangent<2>(is_dynamic, 0.3, 0.02);
    check_tangent<3>(is_dynamic, 0.3, 0.02);
  }
}

/// Two disks (spheres) that fly at each other, not quite head on.
std::string two_disks(int dim, const char* modulus, const char* dt, Real friction) {
  const bool is_3d = dim == 3;
  const auto body = [&](const char* name, const char* x, const char* v) {
    return fmt::format(R"(
[[body]]
name = "{}"
region = {{ type = "{}", center = [{}{}], radius = 0.2 }}
layout = {{ type = "per_cell", count = {} }}
velocity = {{ type = "uniform", value = [{}{}] }}
material = {{ type = "neo_hookean", density = 1000, youngs_modulus = {}, poissons_ratio = 0.3 }}
)",
                       name, is_3d ? "sphere" : "disk", x, is_3d ? ", 0.3" : "", is_3d ? 8 : 4, v, is_3d ? ", 0" : "", modulus);
  };
  return fmt::format(R"(
dim = {}
gravity = {}
[grid]
upper = {}
cell_size = {}
[time]
end = {}
dt = {}
[solver]
type = "implicit"
contact = "pairs"
friction = {}
)",
                     dim, is_3d ? "[0, 0, 0]" : "[0, 0]", is_3d ? "[1.5, 1, 0.6]" : "[1.5, 1]", is_3d ? 0.1 : 0.05, is_3d ? 0.12 : 0.4, dt,
                     friction) +
         body("one", "0.47, 0.5", "1, 0") + body("other", "1.03, 0.52", "-1, 0");
}

TEST(BodyContact, a_collision_makes_no_energy_and_keeps_momentum) {
  for (const int dim : {2, 3}) {
    for (const char* modulus : {"1e5", "1e7"}) {
      for (const Real friction : {0.0, 0.3}) {
        if (dim == 3 && (friction == 0 || std::string(modulus) == "1e5")) continue;  // as it takes its time
        Simulation sim(read(two_disks(dim, modulus, "2e-3", friction)));
        const Real scale = momentum_scale(sim.solver());
        Real greatest = 0;
        sim.add_callback([&](const Simulation& now) {
          greatest = std::max(greatest, whole_energy(now.solver()));
          const Sums sums = sums_of(now.solver());
          for (std::size_t d = 0; d < 3; ++d) EXPECT_NEAR(sums.momentum[d], 0, 1e-10 * scale);
          return true;
        });
        sim.run();
        const std::string which = fmt::format("{} {} {}", dim, modulus, friction);
        // Waves of the stiff ones cross five cells in a step.
        EXPECT_LT(greatest, sim.initial_energy() * (1 + 5e-3)) << which;
        EXPECT_LT(sim.solver().totals(0).momentum[0] / sim.solver().totals(0).mass, -0.5) << which << ": they come back";
        // What the pair reports is what the first of them has got.
        const BoundaryTotals pair = sim.solver().boundaries().back();
        EXPECT_EQ(pair.name, "one|other");
        const BodyTotals one = sim.solver().totals(0);
        const Real rounding = (friction == 0 ? 1e-8 : 1e-4) * one.mass;  // what starts to slip has no slope
        EXPECT_NEAR(pair.impulse[0], one.momentum[0] - one.mass, rounding) << which;
        EXPECT_NEAR(pair.impulse[1], one.momentum[1], rounding) << which;
        EXPECT_NEAR(pair.work, one.kinetic_energy + one.strain_energy - 0.5 * one.mass, 0.06 * one.mass) << which;
        EXPECT_EQ(sim.solver().ledger().contact_dissipation > 0, friction > 0) << which;
        // The work of contact is the change of what it stores, in any step; the rest is Newmark's rule for the stresses.
        EXPECT_LT(std::abs(transfer_loss(sim)), 1e-3 * sim.initial_energy()) << which;
      }
    }
  }
}

TEST(BodyContact, a_block_that_slides_on_another_is_braked_by_coulombs_law) {
  // Of the explicit solver: contact is as stiff, so both are compared with a point mass. Gravity grows, so that nothing rings.
  for (const char* modulus : {"1e6", "1e8"}) {
    Simulation sim(read(fmt::format(R"(
gravity = [0, -9.81]
gravity_times = [0, 0.05]
gravity_factors = [0, 1]
[grid]
upper = [2, 1]
cell_size = 0.05
[time]
end = 0.2
dt = 2e-3
[solver]
type = "implicit"
contact = "pairs"
friction = 0.3
[[body]]
name = "low"
region = {{ type = "box", lower = [0.2, 0], upper = [2, 0.2] }}
layout = {{ type = "per_cell", count = 4 }}
material = {{ type = "neo_hookean", density = 1000, youngs_modulus = {0}, poissons_ratio = 0.3 }}
[[body]]
name = "high"
region = {{ type = "box", lower = [0.5, 0.2], upper = [0.9, 0.5] }}
layout = {{ type = "per_cell", count = 4 }}
velocity = {{ type = "uniform", value = [1, 0] }}
material = {{ type = "neo_hookean", density = 1000, youngs_modulus = {0}, poissons_ratio = 0.3 }}
[[boundary]]
side = "bottom"
kind = "fixed"
)",
                                    modulus)));
    EXPECT_EQ(sim.solver().ledger().contact_energy, 0) << "laid down, they touch and do not press yet";
    sim.run();
    const BodyTotals high = sim.solver().totals(1);
    const Real braked = 1 - high.momentum[0] / high.mass;
    const Real pressed = 9.81 * (0.2 - 0.025) + high.momentum[1] / high.mass;  // it swings a little
    EXPECT_NEAR(braked, 0.3 * pressed, 0.01 * 0.3 * pressed) << modulus;
    EXPECT_NEAR(high.center_of_mass[1], 0.35, 0.002) << modulus;
    EXPECT_EQ(number_of(sim.solver(), "step_cuts"), 0);
  }
}

/// Two blocks that fill a column, on a fixed bottom, in statics.
constexpr const char* k_column = R"(
[grid]
upper = [1, 0.8]
cells = [10, 8]
[time]
end = 1
dt = 1
[solver]
type = "implicit"
mode = "static"
contact = "pairs"
[[body]]
name = "low"
region = { type = "box", lower = [0, 0], upper = [1, 0.4] }
layout = { type = "per_cell", count = 25 }
material = { type = "neo_hookean", density = 1000, youngs_modulus = 1e6, poissons_ratio = 0 }
[[body]]
name = "high"
region = { type = "box", lower = [0, 0.4], upper = [1, 0.8] }
layout = { type = "per_cell", count = 25 }
material = { type = "neo_hookean", density = 1000, youngs_modulus = 1e6, poissons_ratio = 0 }
[[boundary]]
side = "bottom"
kind = "fixed"
)";

TEST(BodyContact, bodies_that_one_step_would_drive_through_each_other_stop) {
  // In one load step, of four particles' spacings. Without halved increments the upper block ended inside the lower one, without a force.
  Simulation sim(read(std::string(k_column) + "[[boundary]]\nside = \"top\"\nkind = \"velocity\"\nvelocity = [0, -0.08]\n"
                                              "[[boundary]]\nside = \"left\"\n[[boundary]]\nside = \"right\"\n"));
  sim.run();
  // A column shortened by a tenth; the neo-Hookean law without lateral strain: P = mu (l - 1/l) with mu = E / 2.
  const Real stretch = 0.9;
  const Real force = sim.solver().boundaries()[1].force[1];
  EXPECT_NEAR(force, 0.5e6 * (stretch - 1 / stretch), 0.02 * 1e5);
  EXPECT_LT(sim.solver().totals(0).upper[1], sim.solver().totals(1).lower[1]) << "none has entered the other";
}

TEST(BodyContact, any_number_of_threads_gives_the_same_bits) {
  const auto state_with = [](int threads) {
    set_thread_count(threads);
    Simulation sim(two_blocks(3, "dynamic", 0.3));
    for (int k = 0; k < 3; ++k) sim.step();
    std::vector<Real> state = sim.solver().field(0, "velocity").values;
    const std::vector<Real> x = sim.solver().field(1, "position").values;
    state.insert(state.end(), x.begin(), x.end());
    return state;
  };
  const int before = thread_count();
  const std::vector<Real> one = state_with(1);
  EXPECT_EQ(one, state_with(2));
  EXPECT_EQ(one, state_with(5));
  set_thread_count(before);
}

TEST(BodyContact, what_is_set_apart_counts_as_the_starts_energy) {
  Simulation sim(two_blocks(2, "dynamic", 0.3));
  EXPECT_GT(sim.solver().ledger().contact_energy, 0) << "they overlap";
  std::vector<Real> x = sim.solver().field(1, "position").values;
  for (std::size_t k = 1; k < x.size(); k += 2) x[k] -= x[k] > 0.78 ? 0 : 1e-4;
  const Real before = sim.solver().ledger().contact_energy;
  sim.set_field(1, "position", x);
  EXPECT_GT(sim.solver().ledger().contact_energy, before);
  EXPECT_NEAR(sim.initial_energy(), whole_energy(sim.solver()), 1e-9 * sim.initial_energy());
}

TEST(BodyContact, contact_alone_does_not_hold_a_body_in_statics) {
  EXPECT_THAT(message_of<InputError>([&] { Simulation sim(read(k_column)); }),
              testing::AllOf(testing::HasSubstr("body \"high\""), testing::HasSubstr("contact, which may end, does not hold")));
}

}  // namespace
}  // namespace matpoint::test
