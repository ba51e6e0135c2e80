// Bodies of finite elements in the implicit solver, alone and beside particles. Numbers of whole problems are in src/verify.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "case/case_file.hpp"
#include "core/parallel.hpp"
#include "implicit/implicit_solver.hpp"
#include "run/simulation.hpp"
#include "support/solver_case.hpp"
#include "support/temporary_folder.hpp"

namespace matpoint::test {
namespace {

/// A disk of particles falls on a block of elements that stands in a basket of elements: below and at one side.
constexpr const char* k_basket = R"(
gravity = [0, -9.81]
[grid]
lower = [0, 0]
upper = [2, 2]
cells = [10, 10]
[time]
end = 1
dt = 0.005
[solver]
type = "implicit"
basis = "element"
soft_stiffness = [1e-3, 1e-7]
[[body]]
name = "disk"
region = { type = "disk", center = [0.85, 0.78], radius = 0.3 }
layout = { type = "per_cell", count = 36 }
velocity = { type = "uniform", value = [-1, -1] }
material = { type = "neo_hookean", density = 1000, youngs_modulus = 1e6, poissons_ratio = 0.3 }
[[body]]
name = "basket"
method = "elements"
region = { type = "union", of = [{ type = "box", lower = [0.2, 0], upper = [1.6, 0.4] }, { type = "box", lower = [0.2, 0.4], upper = [0.4, 1] }] }
material = { type = "neo_hookean", density = 1200, youngs_modulus = 4e6, poissons_ratio = 0.3 }
receding_correction = 0.2
[[boundary]]
side = "bottom"
kind = "fixed"
)";

std::string refused(const std::string& text, const std::vector<std::string>& sets = {}) {
  return message_of<InputError>([&] { Simulation sim(read(text, sets)); });
}

TEST(Coupled, the_order_of_bodies_changes_nothing_also_where_a_rule_makes_the_steps) {
  std::string text = k_basket;
  text.replace(text.find("dt = 0.005"), 10,
               "rule = { type = \"distance\", toward = \"bottom\", positions = [0.4, 0.5], steps = [0.002, 0.01] }");
  const auto run = [&](bool is_swapped) {
    Case problem = read(text, {"time.end=0.08"});
    if (is_swapped) std::swap(problem.bodies[0], problem.bodies[1]);
    Simulation sim(std::move(problem));
    sim.run();
    const BodyTotals disk = sim.solver().totals(is_swapped ? 1 : 0);
    return std::tuple(sim.step_count(), disk.center_of_mass[0], disk.center_of_mass[1], disk.strain_energy);
  };
  const auto [steps, x, y, energy] = run(false);
  const auto [steps_swapped, x_swapped, y_swapped, energy_swapped] = run(true);
  EXPECT_EQ(steps_swapped, steps);
  EXPECT_NEAR(x_swapped, x, 1e-9);
  EXPECT_NEAR(y_swapped, y, 1e-9);
  EXPECT_NEAR(energy_swapped, energy, 1e-9 * energy);
}

TEST(Coupled, momentum_balances_with_the_supports_and_no_particle_enters) {
  Simulation sim(read(k_basket));
  const Real scale = momentum_scale(sim.solver());
  Real strain = 0, receding = 0;
  for (int k = 0; k < 80; ++k) {
    sim.step();
    EXPECT_LT(momentum_remainder(sim), 1e-8 * scale) << "step " << k;
    EXPECT_EQ(number_of(sim.solver(), "penetrated_particles"), 0);
    strain = std::max(strain, sim.solver().totals(1).strain_energy);
    receding = std::max(receding, number_of(sim.solver(), "receding_particles"));
  }
  EXPECT_GT(strain, 1);
  EXPECT_GT(receding, 0);
  const Ledger& ledger = sim.solver().ledger();
  EXPECT_NE(ledger.receding_work, 0);
  EXPECT_GT(ledger.soft_dissipation, 0);
  EXPECT_LT(std::abs(transfer_loss(sim)), 1e-3 * std::abs(sim.initial_energy()));
}

TEST(Coupled, particles_recede_from_a_wall_as_from_a_floor_and_from_a_corner_as_from_both) {
  // Along the diagonal into the corner of a floor and a wall that hardly yield. Floors go by the vertical velocity and walls by the one
  // along their normal: on faces that stay as they are the same.
  const std::string text = std::string(k_basket) + "[[boundary]]\nside = \"left\"\nkind = \"fixed\"\n";
  Simulation sim(read(text, {"gravity=[0,0]", "body.disk.region.center=[0.85,0.85]", "body.disk.velocity.value=[-1.5,-1.5]",
                             "body.basket.region.of=[{ type = \"box\", lower = [0, 0], upper = [2, 0.4] },"
                             "{ type = \"box\", lower = [0, 0.4], upper = [0.4, 2] }]",
                             "body.basket.material.youngs_modulus=1e9", "body.basket.receding_correction=0.3"}));
  Real receding = 0, return_speed = 0;
  for (int k = 0; k < 60; ++k) {
    sim.step();
    const BodyTotals disk = sim.solver().totals(0);
    EXPECT_NEAR(disk.center_of_mass[0], disk.center_of_mass[1], 1e-6) << "step " << k;
    EXPECT_NEAR(disk.momentum[0], disk.momentum[1], 1e-4 * disk.mass) << "step " << k;
    receding = std::max(receding, number_of(sim.solver(), "receding_particles"));
    return_speed = std::max(return_speed, disk.momentum[0] / disk.mass);
  }
  EXPECT_GT(receding, 50);
  EXPECT_GT(return_speed, 1);
}

TEST(Coupled, the_mirror_image_of_a_problem_has_the_mirror_image_of_its_motion) {
  const auto run = [](Real side) {
    std::string text = k_basket;
    const auto box = [&](Real from, Real to, const char* y) {
      const Real a = 1 + side * (from - 1), b = 1 + side * (to - 1);
      return fmt::format("{{ type = \"box\", lower = [{}, {}], upper = [{}, {}] }}", std::min(a, b), y[0] == 'f' ? 0.0 : 0.4,
                         std::max(a, b), y[0] == 'f' ? 0.4 : 1.0);
    };
    auto sim = std::make_unique<Simulation>(read(
        text, {fmt::format("body.disk.region.center=[{},0.78]", 1 - 0.15 * side), fmt::format("body.disk.velocity.value=[{},-1]", -side),
               fmt::format("body.basket.region.of=[{},{}]", box(0.2, 1.6, "floor"), box(0.2, 0.4, "wall"))}));
    for (int k = 0; k < 60; ++k) sim->step();
    return sim;
  };
  const auto sim = run(1), image = run(-1);
  EXPECT_GT(number_of(sim->solver(), "receding_particles"), 0);
  for (std::size_t body = 0; body < 2; ++body) {
    const BodyTotals a = sim->solver().totals(body), b = image->solver().totals(body);
    EXPECT_NEAR(a.center_of_mass[0] - 1, 1 - b.center_of_mass[0], 1e-6);
    EXPECT_NEAR(a.center_of_mass[1], b.center_of_mass[1], 1e-6);
    EXPECT_NEAR(a.strain_energy, b.strain_energy, 1e-4 * a.strain_energy);
  }
}

TEST(Coupled, any_number_of_threads_gives_the_same_bits) {
  const int before = thread_count();
  std::vector<Real> first;
  for (const int threads : {1, 2, 3}) {
    set_thread_count(threads);
    Simulation sim(read(k_basket));
    for (int k = 0; k < 15; ++k) sim.step();
    std::vector<Real> state = sim.solver().field(0, "position").values;
    const std::vector<Real> other = sim.solver().field(1, "stress").values;
    state.insert(state.end(), other.begin(), other.end());
    if (first.empty()) first = state;
    EXPECT_EQ(first, state) << threads << " threads";
  }
  set_thread_count(before);
}

TEST(Coupled, the_background_follows_the_body_and_cells_stay_cells) {
  Simulation sim(read(k_basket, {"body.basket.material.youngs_modulus=2e5"}));
  for (int k = 0; k < 40; ++k) sim.step();
  const auto& solver = dynamic_cast<const ImplicitSolver<2>&>(sim.solver());
  const FemBody<2>& basket = *solver.sources()[1].fem;
  Real moved = 0;
  std::vector<Real> N(9), g(18);
  for (Index cell = 0; cell < solver.basis().cell_count(); ++cell) {
    for (const auto& point : solver.basis().quadrature(cell)) EXPECT_GT(point.weight, 0);
  }
  for (Index node = 0; node < solver.basis().node_count(); ++node) {
    if (basket.has_node(node)) moved = std::max(moved, std::abs(basket.displacement[static_cast<std::size_t>(node)][1]));
  }
  EXPECT_GT(moved, 1e-3);
}

TEST(FemBody, gauss_points_fill_the_region_and_weigh_what_it_weighs) {
  Simulation sim(read(k_basket));
  const BodyTotals totals = sim.solver().totals(1);
  EXPECT_NEAR(totals.mass, 1200 * (1.4 * 0.4 + 0.2 * 0.6), 1e-9);
  EXPECT_NEAR(totals.center_of_mass[0], (0.56 * 0.9 + 0.12 * 0.3) / 0.68, 1e-12);
  EXPECT_NEAR(totals.center_of_mass[1], (0.56 * 0.2 + 0.12 * 0.7) / 0.68, 1e-12);
  Simulation light(read(k_basket, {"body.basket.weight_density=0"}));
  EXPECT_EQ(light.solver().totals(1).gravitational_energy, 0);
}

TEST(FemBody, a_free_one_falls_as_newmark_has_it_and_turns_without_strain) {
  std::string text = k_basket;
  text.erase(text.find("[[body]]"), text.find("[[body]]\nname = \"basket\"") - text.find("[[body]]"));
  text.erase(text.find("[[boundary]]"));
  Simulation sim(read(text));
  for (int k = 0; k < 20; ++k) sim.step();
  const BodyTotals totals = sim.solver().totals(0);
  EXPECT_NEAR(totals.center_of_mass[1] - (0.56 * 0.2 + 0.12 * 0.7) / 0.68, -9.81 * 0.1 * 0.1 / 2, 1e-12);
  EXPECT_LT(totals.strain_energy, 1e-12 * totals.kinetic_energy);
}

TEST(FemBody, what_is_no_body_is_refused) {
  EXPECT_THAT(refused(k_basket, {"body.basket.region={ type = \"box\", lower = [0.2, 0], upper = [1.5, 0.4] }"}),
              testing::HasSubstr(
                  "body \"basket\": its region cuts the cell around (1.5, 0.1), but a body of finite elements consists of whole cells"));
  EXPECT_THAT(refused(k_basket, {"body.basket.region={ type = \"disk\", center = [5, 5], radius = 0.1 }"}),
              testing::HasSubstr("its region contains no cell of the grid"));
  EXPECT_THAT(refused(k_basket, {"body.disk.region.center=[0.6,0.5]"}),
              testing::AllOf(testing::HasSubstr("body \"disk\": particle"), testing::HasSubstr("is inside of a body of elements")));
  EXPECT_THAT(refused(k_basket, {"solver.basis=bspline"}),
              testing::HasSubstr("body basket: method = \"elements\" needs solver.basis = \"element\""));
  EXPECT_THAT(refused(k_basket, {"body.basket.layout={ type = \"per_cell\", count = 4 }"}),
              testing::HasSubstr("method = \"elements\" needs no layout"));
  EXPECT_THAT(refused(k_basket, {"body.disk.weight_density=1"}), testing::HasSubstr("weight_density is for method = \"elements\" only"));
  std::string twice = k_basket;
  const std::size_t at = twice.find("[[boundary]]");
  twice.insert(at,
               "[[body]]\nname = \"block\"\nmethod = \"elements\"\nregion = { type = \"box\", lower = [1.4, 0], upper = [1.8, 0.4] }\n"
               "material = { type = \"neo_hookean\", density = 1, youngs_modulus = 1, poissons_ratio = 0.3 }\n");
  EXPECT_THAT(refused(twice), testing::HasSubstr("belongs to another body of elements, too"));
}

TEST(FemBody, a_side_named_twice_is_refused) {
  const std::string again = std::string(k_basket) + "[[boundary]]\nside = \"bottom\"\n";
  EXPECT_THAT(refused(again + "kind = \"slip\"\n"),
              testing::HasSubstr("boundary 2: side = \"bottom\" has its component y already from boundary 1; keep one of them"));
  EXPECT_THAT(refused(again + "kind = \"velocity\"\ncomponents = [\"x\"]\nvelocity = [1, 0]\n"),
              testing::HasSubstr("has its component x already from boundary 1"));
  EXPECT_EQ(refused(again + "kind = \"velocity\"\ncomponents = [\"x\"]\nvelocity = [1, 0]\n", {"boundary.1.kind=slip"}), "no exception");
  const std::string load = "[[boundary]]\nside = \"bottom\"\nkind = \"traction\"\ntraction = [1, 0]\n";
  EXPECT_THAT(refused(std::string(k_basket) + load + load),
              testing::HasSubstr("boundary 3: side = \"bottom\" has a traction already from boundary 2"));
}

TEST(FemBody, a_static_one_needs_support) {
  std::string text = k_basket;
  text.erase(text.find("[[body]]"), text.find("[[body]]\nname = \"basket\"") - text.find("[[body]]"));
  EXPECT_EQ(refused(text, {"solver.mode=static", "time.dt=0.5"}), "no exception");
  EXPECT_THAT(refused(text, {"solver.mode=static", "time.dt=0.5", "boundary.1.kind=slip"}),
              testing::HasSubstr("nothing holds the body, it is free to move along x"));
}

TEST(FemBody, traction_is_for_faces_of_elements_and_its_work_and_impulse_are_booked) {
  std::string text = k_basket;
  text.erase(text.find("[[body]]"), text.find("[[body]]\nname = \"basket\"") - text.find("[[body]]"));
  text.erase(text.find("[[boundary]]"));
  text +=
      "[[boundary]]\nregion = { type = \"box\", lower = [1.55, -0.01], upper = [1.65, 0.41] }\nkind = \"traction\"\ntraction = [500, 0]\n";
  Simulation sim(read(text, {"gravity=[0,0]"}));
  for (int k = 0; k < 20; ++k) sim.step();
  // A force of 500 Pa on 0.4 m for 0.1 s.
  EXPECT_NEAR(sim.solver().totals(0).momentum[0], 500 * 0.4 * 0.1, 1e-9 * 20);
  EXPECT_NEAR(sim.solver().ledger().body_force_impulse[0], 500 * 0.4 * 0.1, 1e-9 * 20);
  EXPECT_LT(std::abs(transfer_loss(sim)), 1e-3 * sim.solver().ledger().body_force_work);
  // Gauss points stay where they are in their cells: forces balance at the start of a step as at the end of the last. The accelerations
  // of the start are good to some 1e-7.
  EXPECT_LT(std::abs(sim.solver().ledger().reset_loss), 1e-6 * sim.solver().ledger().body_force_work);
  EXPECT_THAT(refused(text + "[[boundary]]\nside = \"top\"\nkind = \"traction\"\ntraction = [1, 0]\n"),
              testing::HasSubstr("boundary 2: kind = \"traction\" loads faces of bodies of elements, and there is none on this side"));
  EXPECT_THAT(refused(text + "[[boundary]]\nregion = { type = \"box\", lower = [1.5, 0.1], upper = [1.7, 0.41] }\nkind = \"traction\"\n"
                             "traction = [1, 0]\n"),
              testing::HasSubstr("boundary 2: the face of body \"basket\" at (1.6, 0.3) is loaded already by boundary 1"));
}

}  // namespace
}  // namespace matpoint::test
