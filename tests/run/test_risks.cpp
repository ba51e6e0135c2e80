// What a case asks for and does not want: named before the run, and the setting that is named does it.
#include "case/case_file.hpp"
#include "run/risks.hpp"
#include "support/solver_case.hpp"

namespace matpoint::test {
namespace {

Case read(const std::string& text, const std::vector<std::string>& sets = {}) {
  Input input = parse_toml(text, "case.toml");
  for (const std::string& set : sets) apply_set(input, set);
  return Case::from_input(input, "case");
}

/// The warnings with a phrase in them.
std::size_t warnings_of(const Case& problem, const std::string& phrase) {
  const std::vector<std::string> all = Simulation(problem).warnings();
  return static_cast<std::size_t>(
      std::count_if(all.begin(), all.end(), [&](const std::string& text) { return text.find(phrase) != std::string::npos; }));
}

const char* const k_two_blocks = R"(
[grid]
upper = [2, 1]
cells = [40, 20]
[time]
end = 0.2
[[body]]
name = "a"
region = { type = "box", lower = [0.5, 0.3], upper = [0.9, 0.7] }
layout = { type = "per_cell", count = 4 }
material = { type = "neo_hookean", density = 1000, youngs_modulus = 1e6, poissons_ratio = 0.3 }
[[body]]
name = "b"
region = { type = "box", lower = [0.8, 0.3], upper = [1.2, 0.7] }
layout = { type = "per_cell", count = 4 }
material = { type = "neo_hookean", density = 1000, youngs_modulus = 1e6, poissons_ratio = 0.3 }
)";

TEST(Risks, a_total_lagrangian_body_is_not_stopped_by_a_side_that_it_does_not_touch) {
  const std::string text = R"(
gravity = [0, -9.81]
[grid]
upper = [1, 1]
cells = [20, 20]
[time]
end = 0.6
[[body]]
name = "ball"
formulation = "total"
region = { type = "box", lower = [0.4, 0.5], upper = [0.6, 0.7] }
layout = { type = "per_cell", count = 4 }
material = { type = "neo_hookean", density = 1000, youngs_modulus = 1e6, poissons_ratio = 0.3 }
[[boundary]]
side = "bottom"
kind = "slip"
)";
  EXPECT_EQ(warnings_of(read(text), "the side \"bottom\", 0.5"), 1u);
  EXPECT_EQ(warnings_of(read(text, {"body.ball.region.lower=[0.4, 0]"}), "the side"), 0u);
  EXPECT_EQ(warnings_of(read(text, {"body.ball.formulation=updated"}), "the side"), 0u);
  // It is so, and the remedy is one.
  const auto lowest = [&](const std::vector<std::string>& sets) {
    Simulation sim(read(text, sets));
    sim.run();
    return sim.solver().totals(0).lower[1];
  };
  EXPECT_LT(lowest({}), -0.5);
  EXPECT_GT(lowest({"body.ball.formulation=updated"}), -0.05);
}

TEST(Risks, bodies_that_overlap_are_named_and_neighbours_are_not) {
  EXPECT_EQ(warnings_of(read(k_two_blocks), "bodies \"a\" and \"b\" overlap at the start: 0.04 m^2"), 1u);
  for (const char* lower : {"0.9", "0.912", "0.937"}) {
    EXPECT_EQ(warnings_of(read(k_two_blocks, {fmt::format("body.b.region.lower=[{}, 0.3]", lower)}), "overlap"), 0u) << lower;
  }
  // By a particle, along a line within the cells.
  EXPECT_EQ(warnings_of(read(k_two_blocks, {"body.b.region.lower=[0.86, 0.3]"}), "overlap"), 1u);
}

TEST(Risks, one_particle_in_a_cell_is_too_few_for_linear_shapes) {
  const std::vector<std::string> apart = {"solver.shape=linear", "body.b.region.lower=[1, 0.3]", "body.a.layout.count=1"};
  EXPECT_EQ(warnings_of(read(k_two_blocks, apart), "body \"a\" has 1 particle in a cell"), 1u);
  EXPECT_EQ(warnings_of(read(k_two_blocks, apart), "body \"b\" has"), 0u);
  std::vector<std::string> mended = apart;
  mended.push_back("solver.shape=bspline2");
  EXPECT_EQ(warnings_of(read(k_two_blocks, mended), "in a cell"), 0u);
}

TEST(Risks, fbar_of_a_fluid_that_is_corrected_is_named) {
  const std::vector<std::string> water = {"body.b.region.lower=[1, 0.3]", "body.b.fbar=true",
                                          "body.b.material={type=\"newtonian_fluid\",density=1000,pressure_scale=1e5}"};
  EXPECT_EQ(warnings_of(read(k_two_blocks, water), "body \"b\": fbar does nothing"), 1u);
  std::vector<std::string> alone = water;
  alone.push_back("solver.fluid_correction=false");
  EXPECT_EQ(warnings_of(read(k_two_blocks, alone), "fbar"), 0u);
  EXPECT_EQ(warnings_of(read(k_two_blocks, {"body.b.region.lower=[1, 0.3]", "body.b.fbar=true"}), "fbar"), 0u);
}

TEST(Risks, schemes_that_light_nodes_upset_are_named_with_what_would_do) {
  const std::vector<std::string> apart = {"solver.shape=linear", "body.b.region.lower=[1, 0.3]"};
  const auto with = [&](std::vector<std::string> sets) {
    sets.insert(sets.begin(), apart.begin(), apart.end());
    return read(k_two_blocks, sets);
  };
  EXPECT_TRUE(Simulation(with({})).warnings().empty());
  EXPECT_EQ(warnings_of(with({"solver.stress_order=usl"}), "stress_order = \"usl\" with shape = \"linear\" is unstable"), 1u);
  EXPECT_EQ(warnings_of(with({"solver.transfer=apic"}), "transfer = \"apic\" with shape = \"linear\" is unstable"), 1u);
  EXPECT_TRUE(Simulation(with({"solver.stress_order=usl", "solver.shape=bspline2"})).warnings().empty());
  EXPECT_TRUE(Simulation(with({"solver.stress_order=usl", "time.dt=1e-5"})).warnings().empty()) << "as the published examples";
}

// A cantilever that sinks to rest; beam theory with shear, E/(1 - nu^2): 0.0489 m at its end.
const char* const k_cantilever = R"(
gravity = [0, -9.81]
[grid]
upper = [1.2, 1]
cells = [24, 20]
[time]
end = 2
[solver]
damping = 5
[[body]]
name = "beam"
region = { type = "box", lower = [0, 0.5], upper = [0.6, 0.7] }
layout = { type = "per_cell", count = 4 }
material = { type = "neo_hookean", density = 1000, youngs_modulus = 1e6, poissons_ratio = 0.3 }
[[boundary]]
side = "left"
kind = "fixed"
)";

TEST(Risks, the_order_that_is_advised_for_damping_brings_a_beam_to_rest) {
  for (const char* shape : {"linear", "bspline2"}) {
    const std::string chosen = std::string("solver.shape=") + shape;
    const std::vector<std::string> warnings = Simulation(read(k_cantilever, {chosen})).warnings();
    ASSERT_EQ(warnings.size(), 1u);
    const std::string key = "use stress_order = \"";
    const std::string order = warnings[0].substr(warnings[0].find(key) + key.size(), 3);
    Simulation sim(read(k_cantilever, {chosen, "solver.stress_order=" + order}));
    EXPECT_TRUE(sim.warnings().empty());
    const std::vector<Real> start = sim.solver().field(0, "position").values;
    sim.run();
    const std::vector<Real> end = sim.solver().field(0, "position").values;
    // The last column of particles is at .5875 m; the deflection there and its slope.
    Real at_end = 0, before = 0;
    int count = 0;
    for (std::size_t k = 0; k < start.size(); k += 2) {
      if (std::abs(start[k] - 0.5875) < 1e-9) at_end += start[k + 1] - end[k + 1], ++count;
      if (std::abs(start[k] - 0.5625) < 1e-9) before += start[k + 1] - end[k + 1];
    }
    const Real tip = (at_end + 0.5 * (at_end - before)) / count;
    EXPECT_NEAR(tip, 0.0489, 0.04 * 0.0489) << shape;
  }
}

TEST(Risks, domains_of_what_breaks_are_warned_of) {
  const std::string phrase = "may break, and with shape = \"cpdi\"";
  const std::vector<std::string> ice = {
      "body.b.region.lower=[0.9, 0.3]",
      "body.a.material={ type = \"rankine_damage\", density = 1000, youngs_modulus = 1e6, poissons_ratio = 0.3, tensile_strength = 1e3, "
      "fracture_energy = 1 }",
      "solver.shape=cpdi"};
  EXPECT_EQ(warnings_of(read(k_two_blocks, ice), phrase), 1u);
  EXPECT_EQ(warnings_of(read(k_two_blocks, {ice[0], ice[1]}), phrase), 0u);
  EXPECT_EQ(warnings_of(read(k_two_blocks, {ice[0], ice[2]}), phrase), 0u);
}

TEST(Risks, thin_tools_are_seen) {
  const auto said = [](const std::string& shape) {
    const Case problem = read(
        "[grid]\nupper = [1, 1]\ncells = [20, 20]\n[time]\nend = 1\n[[body]]\nname = \"block\"\nregion = { type = "
        "\"box\", lower = [0.3, 0.5], upper = [0.6, 0.7] }\nlayout = { type = \"per_cell\", count = 4 }\nmaterial = { type = "
        "\"neo_hookean\", density = 1000, youngs_modulus = 1e5, poissons_ratio = 0.3 }\n[[tool]]\nname = \"blade\"\nshape = " +
        shape + "\n");
    Simulation sim(problem);
    std::string all;
    for (const std::string& risk : risks_of(problem, sim.solver())) all += risk.find("tool") != std::string::npos ? risk : "";
    return all;
  };
  EXPECT_EQ(
      said("{ type = \"box\", lower = [0.1, 0.2], upper = [0.9, 0.29] }"),
      "tool \"blade\" is 0.09 m thick, less than two cells of 0.05 m: what is before it drags what is behind it, and particles that hit it "
      "fast may pass; make it thicker, or the cells smaller");
  EXPECT_EQ(said("{ type = \"box\", lower = [0.1, 0.2], upper = [0.9, 0.3] }"), "");
  EXPECT_EQ(said("{ type = \"disk\", center = [0.5, 0.3], radius = 0.05 }"), "");
  EXPECT_EQ(said("{ type = \"half_space\", point = [0.5, 0.3], normal = [0, 1] }"), "");
}

}  // namespace
}  // namespace matpoint::test
