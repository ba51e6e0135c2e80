// Bodies of elements in contact with bodies of particles, with each other and with sides: exact tangents, momentum and energy, layers
// that are pressed, bounces, and what is refused.
#include <gmock/gmock.h>

#include <numbers>

#include "implicit/tangent_error.hpp"
#include "io/history.hpp"
#include "support/from_toml.hpp"
#include "support/solver_case.hpp"

namespace matpoint::test {
namespace {

const std::string k_elements = "method = \"elements\"\n";

std::string particles(int dim) { return fmt::format("layout = {{ type = \"per_cell\", count = {} }}\n", dim == 3 ? 27 : 9); }

/// [a, b] in 2D, [a, b, c] in 3D.
std::string vector_of(int dim, Real a, Real b, Real c) {
  return dim == 3 ? fmt::format("[{}, {}, {}]", a, b, c) : fmt::format("[{}, {}]", a, b);
}

std::string block(int dim, const char* name, const std::string& method, Vec3 lower, Vec3 upper, const std::string& more = "") {
  return fmt::format(R"(
[[body]]
name = "{}"
region = {{ type = "box", lower = {}, upper = {} }}
{}material = {{ type = "neo_hookean", density = 1000, youngs_modulus = 1e6, poissons_ratio = 0.3 }}
{})",
                     name, vector_of(dim, lower[0], lower[1], lower[2]), vector_of(dim, upper[0], upper[1], upper[2]), method, more);
}

std::string head(int dim, Real width, Real height, const std::string& solver, const char* time = "end = 0.1\ndt = 0.01") {
  return fmt::format(R"(
dim = {}
gravity = {}
[grid]
upper = {}
cell_size = 0.1
[time]
{}
[solver]
type = "implicit"
basis = "element"
{}
)",
                     dim, vector_of(dim, 0, 0, 0), vector_of(dim, width, height, 0.2), time, solver);
}

template <int Dim>
void check_tangent(const std::string& low, const std::string& high, int order, bool is_dynamic, Real friction) {
  const std::string solver = fmt::format("mode = \"{}\"\nelement_order = {}\ncontact = \"pairs\"\nfriction = {}\n",
                                         is_dynamic ? "dynamic" : "static", order, friction);
  Simulation sim(read(head(Dim, 0.4, 0.4, solver) + block(Dim, "low", low, {0, 0, 0}, {0.4, 0.2, 0.2}) +
                      block(Dim, "high", high, {0.1, 0.2, 0}, {0.3, 0.4, 0.2}) +
                      "[[boundary]]\nside = \"bottom\"\nkind = \"fixed\"\n[[boundary]]\nside = \"top\"\nkind = \"velocity\"\nvelocity = " +
                      vector_of(Dim, 0, -0.1, 0)));
  auto& solver_of = dynamic_cast<ImplicitSolver<Dim>&>(sim.solver());
  // Deformed, so that the undeformed gradients would be wrong.
  sim.step();
  solver_of.assembly().start();
  StepLoad<Dim> load;
  load.dt = 0.01;
  if (is_dynamic) load.inertia = {4e4, 400, 1};
  std::vector<Real> u(solver_of.space().nodes().size() * Dim);
  for (std::size_t k = 0; k < u.size(); ++k) {
    const bool is_upper = solver_of.space().is_of(1, k / Dim);
    const Vec<Dim> x = solver_of.space().place(k / Dim);
    u[k] = 1e-3 * std::sin(7.0 * x[0] + 11.0 * x[1] + static_cast<Real>(k % Dim));
    if (is_upper && k % Dim == 0) u[k] += 2e-3;
    if (is_upper && k % Dim == 1) u[k] -= 3e-3;
    if (solver_of.space().unknown(static_cast<Index>(k / Dim), static_cast<int>(k % Dim)) < 0) u[k] = 0;
  }
  EXPECT_LT(tangent_error<Dim>(solver_of, load, u), 1e-7) << Dim << low << high << order << is_dynamic << friction;
}

TEST(ElementContact, tangents_are_exact) {
  for (const bool is_dynamic : {false, true}) {
    check_tangent<2>(k_elements, k_elements, 2, is_dynamic, 0);
    check_tangent<2>(k_elements, k_elements, 2, is_dynamic, 0.3);
    check_tangent<2>(k_elements, particles(2), 1, is_dynamic, 0.3);
    check_tangent<2>(particles(2), k_elements, 1, is_dynamic, 0.3);
    check_tangent<3>(k_elements, k_elements, 1, is_dynamic, 0.3);
  }
}

/// A block flies at another, not quite straight.
void check_collision(int dim, const std::string& low, const std::string& high, int order, Real friction) {
  const std::string at = fmt::format("{} {} {} {} {}", dim, low, high, order, friction);
  const std::string solver = fmt::format("element_order = {}\ncontact = \"pairs\"\nfriction = {}\n", order, friction);
  const std::string thrown = fmt::format("velocity = {{ type = \"uniform\", value = {} }}\n", vector_of(dim, 0.5, -1, 0));
  Simulation sim(read(head(dim, 1.2, 1.2, solver, "end = 0.12\ndt = 0.001") + block(dim, "low", low, {0.2, 0.2, 0}, {1, 0.5, 0.2}) +
                      block(dim, "high", high, {0.4, 0.6, 0}, {0.7, 0.9, 0.2}, thrown)));
  const BodyTotals before = sim.solver().totals(1);
  const Real start = whole_energy(sim.solver());
  Real rest = 0;
  sim.add_callback([&](const Simulation& now) {
    for (std::size_t d = 0; d < static_cast<std::size_t>(dim); ++d) {
      const Real sum = now.solver().totals(0).momentum[d] + now.solver().totals(1).momentum[d];
      EXPECT_NEAR(sum, before.momentum[d], 1e-10 * std::abs(before.momentum[1])) << at << " " << now.time();
      // What the pair has given is what the momentum says.
      EXPECT_NEAR(now.solver().boundaries().back().impulse[d], now.solver().totals(0).momentum[d],
                  (friction > 0 ? 1e-3 : 1e-8) * std::abs(before.momentum[1]))
          << at << ": what starts to slip has no slope";
    }
    const Ledger& ledger = now.solver().ledger();
    rest = whole_energy(now.solver()) + ledger.contact_dissipation + ledger.reset_loss + ledger.integrator_loss - start;
    EXPECT_LT(whole_energy(now.solver()), 1.0001 * start) << at << " " << now.time();
    return true;
  });
  sim.run();
  const BodyTotals after = sim.solver().totals(1);
  EXPECT_GT(after.momentum[1], 0.5 * before.momentum[1]) << at << ": it is thrown back";
  EXPECT_NEAR(rest, 0, 1e-3 * start) << at << ": the rest is Newmark's rule for the stresses";
  const Real ratio = (before.momentum[0] - after.momentum[0]) / (after.momentum[1] - before.momentum[1]);
  EXPECT_NEAR(ratio, friction, friction > 0 ? 0.02 : 0.005) << at << ": Coulomb's law, while it slips";
  const bool has_particles = low != k_elements || high != k_elements;
  EXPECT_LT(sim.solver().ledger().reset_loss, (has_particles ? 0.03 : 0.01) * start) << at;
}

TEST(ElementContact, a_collision_keeps_momentum_and_makes_no_energy) {
  for (const Real friction : {0.0, 0.2}) {
    check_collision(2, k_elements, k_elements, 2, friction);
    check_collision(2, k_elements, particles(2), 1, friction);
    check_collision(2, particles(2), k_elements, 1, friction);
  }
  check_collision(3, k_elements, k_elements, 1, 0.2);
}

TEST(ElementContact, what_flies_past_keeps_its_vibrations) {
  // Near each other from the start, and never touching: as if each were alone.
  const std::string thrown = "velocity = { type = \"linear\", gradient = [[0, 0], [0, 3]] }\n";
  const std::string bodies =
      block(2, "low", k_elements, {0, 0, 0}, {0.4, 0.2, 0}) + block(2, "high", k_elements, {0, 0.3, 0}, {0.4, 0.5, 0}, thrown);
  const std::string solver = "contact = \"pairs\"\n";
  Simulation sim(read(head(2, 0.4, 0.6, solver, "end = 0.05\ndt = 0.0005") + bodies));
  sim.run();
  EXPECT_GT(sim.solver().totals(1).kinetic_energy + sim.solver().totals(1).strain_energy, 0.999 * sim.initial_energy());
  EXPECT_LT(std::abs(sim.solver().ledger().reset_loss), 1e-9 * sim.initial_energy());
}

/// Two layers under a lid that comes down by one percent: the force on it over that of one layer, and the greatest error of stresses.
std::array<Real, 2> press_layers(const std::string& low, const std::string& high, int order, Real cell) {
  const std::string solver = fmt::format("mode = \"static\"\nelement_order = {}\ncontact = \"pairs\"\n", order);
  const std::string text = head(2, 0.4, 0.8, solver, "end = 1\ndt = 0.5") + block(2, "low", low, {0, 0, 0}, {0.4, 0.4, 0}) +
                           block(2, "high", high, {0, 0.4, 0}, {0.4, 0.8, 0}) + R"(
[[boundary]]
side = "left"
kind = "slip"
[[boundary]]
side = "right"
kind = "slip"
[[boundary]]
side = "bottom"
[[boundary]]
side = "top"
kind = "velocity"
components = ["y"]
velocity = [0, -0.008]
)";
  Simulation sim(read(text, {fmt::format("grid.cell_size={}", cell)}));
  sim.run();
  const std::vector<BoundaryTotals> totals = sim.solver().boundaries();
  const Real force = totals[2].force[1];
  EXPECT_NEAR(totals[3].force[1], -force, 1e-8 * force);
  EXPECT_NEAR(totals.back().force[1], -force, 1e-8 * force);
  Real worst = 0;
  for (const std::size_t b : {0, 1}) {
    const std::vector<Real> stress = sim.solver().field(b, "stress").values, x = sim.solver().field(b, "position").values;
    const std::size_t width = stress.size() / (x.size() / 2);
    for (std::size_t p = 0; 2 * p < x.size(); ++p) {
      if (std::abs(x[2 * p + 1] - 0.4) < 1.5 * cell) continue;  // there the force enters
      worst = std::max(worst, std::abs(stress[p * width + 1] * 0.4 / force + 1));
    }
  }
  return {force / (0.4 * 0.01 * 1e6 * 0.7 / (1.3 * 0.4)), worst};
}

TEST(ElementContact, layers_that_are_pressed_have_one_stress) {
  for (const auto& [low, high, order] :
       {std::tuple{k_elements, k_elements, 2}, {k_elements, particles(2), 1}, {particles(2), k_elements, 1}}) {
    const auto [coarse, error] = press_layers(low, high, order, 0.1);
    const auto [fine, finer_error] = press_layers(low, high, order, 0.05);
    // The surfaces are as soft as a layer of a point's spacing.
    EXPECT_LT(coarse, 1) << low << high;
    EXPECT_GT(coarse, 0.9) << low << high;
    EXPECT_NEAR((1 - fine) / (1 - coarse), 0.5, 0.1) << low << high;
    EXPECT_LT(std::max(error, finer_error), 0.005) << low << high;
  }
}

/// The restitution of a block of elements that is thrown at a side.
Real bounce(int dim, const std::string& boundary, int order, const std::string& side, Real& gain) {
  const BoundarySide at = side_of(side);
  const auto axis = static_cast<std::size_t>(at.axis);
  Vec3 v{};
  v[axis] = at.is_upper ? 3 : -3;
  const std::string thrown = fmt::format("velocity = {{ type = \"uniform\", value = {} }}\n", vector_of(dim, v[0], v[1], v[2]));
  Simulation sim(read(head(dim, 0.6, 0.6, fmt::format("element_order = {}", order), "end = 0.06\ndt = 0.0002") +
                      block(dim, "block", k_elements, {0.1, 0.1, 0}, {0.5, 0.5, 0.2}, thrown) +
                      fmt::format("[[boundary]]\nside = \"{}\"\n{}\n", side, boundary)));
  const Real start = sim.initial_energy();
  const Real before = sim.solver().totals(0).momentum[axis];
  sim.add_callback([&](const Simulation& now) {
    gain = std::max(gain, whole_energy(now.solver()) / start - 1);
    EXPECT_NEAR(now.solver().boundaries()[0].impulse[axis], now.solver().totals(0).momentum[axis] - before, 1e-9 * std::abs(before));
    return true;
  });
  sim.run();
  return -sim.solver().totals(0).momentum[axis] / before;
}

TEST(ElementContact, a_block_comes_back_from_a_side) {
  // Finite elements that converge: 0.785; flat faces meet many times, and with longer steps it scatters by
  // a tenth.
  for (const std::string side : {"bottom", "top", "left", "right"}) {
    for (const int order : {1, 2}) {
      Real gain = 0;
      EXPECT_NEAR(bounce(2, "kind = \"fixed\"\ncontact = \"no_tension\"", order, side, gain), 0.785, order == 1 ? 0.03 : 0.02)
          << side << order;
      EXPECT_LT(gain, 1e-4) << side << order;
    }
  }
  Real gain = 0;
  EXPECT_GT(bounce(3, "kind = \"slip\"\ncontact = \"no_tension\"", 1, "bottom", gain), 0.6);
  EXPECT_LT(gain, 1e-4);
}

TEST(ElementContact, nodes_that_turn_go_by_where_they_are) {
  // A wheel whose nodes all turn by one radian, beside a body in a field of its own.
  Simulation sim(read(head(2, 1, 1, "contact = \"pairs\"\n", "end = 1\ndt = 0.05") +
                      block(2, "wheel", k_elements, {0.2, 0.2, 0}, {0.6, 0.6, 0}) + block(2, "far", k_elements, {0.8, 0.8, 0}, {1, 1, 0}) +
                      R"(
[[boundary]]
region = { type = "box", lower = [0.1, 0.1], upper = [0.7, 0.7] }
kind = "velocity"
velocity = { type = "rotating", center = [0.4, 0.4], angular_velocity = 1 }
)"));
  const std::vector<Real> before = sim.solver().field(0, "position").values;
  sim.run();
  const std::vector<Real> after = sim.solver().field(0, "position").values;
  for (std::size_t k = 0; k < before.size(); k += 2) {
    const Real x = before[k] - 0.4, y = before[k + 1] - 0.4;
    EXPECT_NEAR(after[k], 0.4 + std::cos(1.0) * x - std::sin(1.0) * y, 1e-8);
    EXPECT_NEAR(after[k + 1], 0.4 + std::sin(1.0) * x + std::cos(1.0) * y, 1e-8);
  }
  EXPECT_LT(sim.solver().totals(0).strain_energy, 1e-6);
}

TEST(ElementContact, loads_on_faces_press_one_body_on_another) {
  // Two blocks side by side; the left one is pulled away from the right one, which does not follow and has no load of its own.
  const std::string body =
      block(2, "left", k_elements, {0, 0, 0}, {0.2, 0.2, 0}) + block(2, "right", k_elements, {0.2, 0, 0}, {0.4, 0.2, 0});
  const auto run = [&](const char* side, Real traction) {
    Simulation sim(read(head(2, 0.4, 0.2, "contact = \"pairs\"\n", "end = 0.02\ndt = 0.001") + body +
                        fmt::format("[[boundary]]\nside = \"{}\"\nkind = \"traction\"\ntraction = [{}, 0]\n", side, traction)));
    sim.run();
    return std::array<Real, 2>{sim.solver().totals(0).momentum[0], sim.solver().totals(1).momentum[0]};
  };
  const Real impulse = 1000 * 0.2 * 0.02;
  const std::array<Real, 2> pulled = run("left", -1000), away = run("right", 1000), pressed = run("left", 1000);
  EXPECT_NEAR(pulled[0], -impulse, 1e-9);
  EXPECT_NEAR(pulled[1], 0, 1e-12);
  EXPECT_NEAR(away[0], 0, 1e-12);
  EXPECT_NEAR(away[1], impulse, 1e-9);
  EXPECT_NEAR(pressed[0] + pressed[1], impulse, 1e-9);
  EXPECT_GT(pressed[1], 0.5);
}

TEST(ElementContact, what_passes_a_side_that_holds_other_nodes_is_said) {
  Simulation sim(read(head(2, 0.6, 0.6, "", "end = 0.2\ndt = 0.001") +
                      block(2, "block", k_elements, {0.2, 0.1, 0}, {0.4, 0.3, 0}, "velocity = { type = \"uniform\", value = [0, -3] }\n") +
                      "[[boundary]]\nside = \"bottom\"\n"));
  try {
    sim.run();
    FAIL() << "it passed";
  } catch (const SolverError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("body \"block\" of elements has passed the bottom side"));
    EXPECT_THAT(error.what(), testing::HasSubstr("contact = \"no_tension\""));
  }
}

TEST(ElementContact, what_a_side_holds_may_swing_past_it) {
  // A plate that the left side holds by its end, and whose other end is turned around until it is behind that.
  Simulation sim(
      read(head(2, 1, 0.8, "mode = \"static\"\n", "end = 1\ndt = 0.02") + block(2, "plate", k_elements, {0, 0.3, 0}, {0.8, 0.4, 0}) + R"(
[[boundary]]
side = "left"
kind = "fixed"
[[boundary]]
region = { type = "box", lower = [0.75, 0.25], upper = [0.85, 0.45] }
kind = "velocity"
velocity = { type = "rotating", center = [0.15, 0.35], angular_velocity = 2.6 }
)"));
  sim.run();
  EXPECT_LT(sim.solver().totals(0).lower[0], -0.1) << "beyond the side by a cell";
}

TEST(ElementContact, what_cannot_be_is_refused_by_name) {
  const auto message = [](const std::string& text) {
    try {
      read(text);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  const std::string two = block(2, "low", k_elements, {0, 0, 0}, {0.4, 0.2, 0});
  EXPECT_THAT(message(head(2, 0.4, 0.4, "contact = \"pairs\"\n") + two +
                      block(2, "high", k_elements, {0, 0.2, 0}, {0.4, 0.4, 0}, "receding_correction = 0.3\n")),
              testing::HasSubstr("receding_correction is for particles that share the nodes"));
  EXPECT_THAT(message(head(2, 0.4, 0.4, "element_order = 1\n") + two + block(2, "high", particles(2), {0, 0.2, 0}, {0.4, 0.4, 0}) +
                      "[[boundary]]\nside = \"top\"\ncontact = \"no_tension\"\n"),
              testing::HasSubstr("where particles and bodies of elements share their nodes, sides do not let go"));
}

}  // namespace
}  // namespace matpoint::test
