// What is refused in a case for the implicit solver, and in one for the explicit solver that has keys of the other.
#include "case/linear_solver_names.hpp"
#include "case/wrong_input.hpp"

namespace matpoint::test {
namespace {

const std::string k_implicit_case = R"(gravity = [0, -10]
gravity_times = [0, 1]
gravity_factors = [1, 0]

[grid]
lower = [0, 0]
upper = [1, 1]
cells = [8, 8]
grading = [1, 1.1]
refinements = 0

[time]
dt = 1e-2
end = 0.1

[solver]
type = "implicit"
basis = "element"
element_order = 2
beta = 0.3
gamma = 0.5
soft_stiffness = [1e-6, 1e-10]
linear_solver = "auto"
iterations_max = 20

[[body]]
name = "block"
region = { type = "box", lower = [0.25, 0], upper = [0.75, 0.75] }
layout = { type = "per_cell", count = 16 }
material = { type = "neo_hookean", density = 1000, youngs_modulus = 1e5, poissons_ratio = 0.3 }

[[boundary]]
side = "bottom"
kind = "fixed"
receding_correction = 0.5
)";

class WrongImplicit : public testing::TestWithParam<WrongInput> {};

TEST(WrongImplicit, case_itself_is_right) { EXPECT_EQ(refusal(k_implicit_case), "no exception"); }
TEST_P(WrongImplicit, is_refused_in_words) { expect_refused(k_implicit_case, GetParam()); }

INSTANTIATE_TEST_SUITE_P(
    solver, WrongImplicit,
    testing::Values(
        WrongInput{
            "explicit_key", "element_order = 2", "stress_order = \"usl\"", {"solver: stress_order is for solver.type = \"explicit\" only"}},
        WrongInput{
            "unknown_key", "element_order = 2", "element_oder = 2", {"unknown key \"element_oder\"", "did you mean \"element_order\"?"}},
        WrongInput{"basis",
                   "\"element\"",
                   "\"bsplines\"",
                   {"basis = \"bsplines\" is unknown, allowed: \"bspline\" or \"element\"", "did you mean \"bspline\"?"}},
        WrongInput{"order", "element_order = 2", "element_order = 3", {"element_order = 3"}},
        WrongInput{"order_of_splines",
                   "basis = \"element\"\nelement_order = 2",
                   "basis = \"bspline\"\n@element_order = 2",
                   {"element_order is for basis = \"element\" only"}},
        WrongInput{"beta", "beta = 0.3", "beta = 0.2", {"beta = 0.2"}},
        WrongInput{"unstable", "beta = 0.3\ngamma = 0.5", "@beta = 0.3\ngamma = 0.7", {"beta = 0.3 is below gamma / 2 = 0.35"}},
        WrongInput{"soft_stiffness", "[1e-6, 1e-10]", "[1e-6]", {"soft_stiffness has 1 numbers, it must have 2"}},
        WrongInput{
            "surface_penalty", "element_order = 2", "surface_penalty = 10", {"surface_penalty = 10 is for basis = \"bspline\" only"}},
        WrongInput{"linear_solver", "\"auto\"", "\"umfpak\"", {"linear_solver: \"umfpak\" is unknown", "did you mean \"umfpack\"?"}},
        WrongInput{"iterations", "iterations_max = 20", "iterations_max = 0", {"iterations_max = 0"}},
        WrongInput{"contact_of_one_body",
                   "element_order = 2",
                   "@contact = \"pairs\"",
                   {"contact = \"pairs\" is for two or more bodies, and the case has one"}},
        WrongInput{"contact_of_fields",
                   "element_order = 2",
                   "contact = \"multi_field\"",
                   {"contact = \"multi_field\" is unknown, allowed: \"single_field\" or \"pairs\""}},
        WrongInput{"friction_in_one_field",
                   "element_order = 2",
                   "@friction = 0.3",
                   {"friction is for contact = \"pairs\": in one field bodies stick"}},
        WrongInput{"mode",
                   "element_order = 2",
                   "mode = \"quasistatic\"",
                   {"mode = \"quasistatic\" is unknown, allowed: \"dynamic\" or \"static\""}}),
    name_of);

INSTANTIATE_TEST_SUITE_P(
    rest, WrongImplicit,
    testing::Values(
        WrongInput{"no_step", "dt = 1e-2\n", "", {"^case.toml:12: ", "time: dt is missing: the implicit solver needs dt = ..., or rule"}},
        WrongInput{"cfl",
                   "dt = 1e-2",
                   "cfl = 0.5\n@rule = { type = \"table\", times = [0], steps = [0.1] }",
                   {"^case.toml:13: ", "cfl is for the explicit solver"}},
        WrongInput{"step_and_rule",
                   "dt = 1e-2",
                   "dt = 1e-2\n@rule = { type = \"table\", times = [0], steps = [0.1] }",
                   {"dt and rule are both given"}},
        WrongInput{"rule_type",
                   "dt = 1e-2",
                   "rule = { type = \"newton\" }",
                   {"rule type = \"newton\" is unknown, allowed: \"table\", \"distance\" or \"newton_count\""}},
        WrongInput{"rule_lengths",
                   "dt = 1e-2",
                   "rule = { type = \"table\", times = [0, 1], steps = [0.1] }",
                   {"times has 2 numbers and steps 1; they must match"}},
        WrongInput{"rule_order",
                   "dt = 1e-2",
                   "rule = { type = \"table\", times = [1, 0], steps = [0.1, 0.1] }",
                   {"times[1] = 0 must be greater than times[0] = 1"}},
        WrongInput{"rule_side",
                   "dt = 1e-2",
                   "rule = { type = \"distance\", toward = \"front\", positions = [0], steps = [0.1] }",
                   {"toward = \"front\" is unknown"}},
        WrongInput{"rule_parabola",
                   "dt = 1e-2",
                   "rule = { type = \"distance\", positions = [0, 1], steps = [0.1, 0.2], interpolation = \"quadratic\" }",
                   {"\"quadratic\" needs 3 positions, positions has 2"}},
        WrongInput{"rule_negative",
                   "dt = 1e-2",
                   "rule = { type = \"distance\", positions = [0, 9, 10], steps = [0.1, 0.1, 10], interpolation = \"quadratic\" }",
                   {"the parabola through steps is", "it must be > 0"}},
        WrongInput{"rule_newton",
                   "dt = 1e-2",
                   "rule = { type = \"newton_count\", first = 1, smallest = 0.1, largest = 0.5 }",
                   {"first = 1 must lie between smallest = 0.1 and largest = 0.5"}},
        WrongInput{"rule_few",
                   "dt = 1e-2",
                   "rule = { type = \"newton_count\", first = 0.2, smallest = 0.1, largest = 0.5, few = 9 }",
                   {"few = 9 must be below many = 8"}},
        WrongInput{"grading_length", "[1, 1.1]", "[1, 1, 1]", {"grading has 3 numbers"}},
        WrongInput{"grading_zero", "[1, 1.1]", "[1, 0]", {"grading"}},
        WrongInput{"grading_extreme", "[1, 1.1]", "[1, 100]", {"grading = 100 over 8 cells makes the last 1e+14 times as long"}},
        WrongInput{"refinements", "refinements = 0", "refinements = -1", {"refinements = -1"}},
        WrongInput{"correction_on_an_inclined_side",
                   "refinements = 0",
                   "corners = [[0, 0.1], [1, 0], [1, 1], [0, 1]]",
                   {"^case.toml:32: ", "receding_correction is for sides along an axis, but grid.corners inclines side = \"bottom\""}},
        WrongInput{"contact_on_9_node_elements",
                   "receding_correction = 0.5",
                   "contact = \"no_tension\"",
                   {"^case.toml:32: ", "contact is for basis = \"bspline\" or element_order = 1"}},
        WrongInput{"contact_by_nodes_on_elements",
                   "receding_correction = 0.5",
                   "contact = \"no_tension\"\ncontact_by = \"nodes\"",
                   {"^case.toml:32: ", "contact_by = \"nodes\" goes by the signs of reactions at nodes, which mean nothing on elements"}},
        WrongInput{"contact_by_unknown",
                   "receding_correction = 0.5",
                   "contact = \"no_tension\"\n@contact_by = \"node\"",
                   {"contact_by", "\"node\"", "did you mean \"nodes\"?"}},
        WrongInput{"contact_by_without_contact",
                   "receding_correction = 0.5",
                   "@contact_by = \"nodes\"",
                   {"contact_by is for contact = \"no_tension\" or \"friction\""}},
        WrongInput{
            "contact_unknown",
            "receding_correction = 0.5",
            "contact = \"no_tensions\"",
            {"contact = \"no_tensions\" is unknown, allowed: \"stick\", \"no_tension\" or \"friction\"", "did you mean \"no_tension\"?"}},
        WrongInput{"contact_of_slip",
                   "kind = \"fixed\"\nreceding_correction = 0.5",
                   "kind = \"slip\"\ncontact = \"no_tension\"\ncontact_by = \"nodes\"",
                   {"^case.toml:32: ", "contact_by = \"nodes\" is for kind = \"fixed\" or \"velocity\"; use \"particles\""}},
        WrongInput{"friction_of_slip",
                   "kind = \"fixed\"\nreceding_correction = 0.5",
                   "kind = \"slip\"\ncontact = \"friction\"\nfriction = 0.3",
                   {"^case.toml:35: ", "contact = \"friction\" is for kind = \"fixed\" or \"velocity\""}},
        WrongInput{"friction_on_elements",
                   "receding_correction = 0.5",
                   "contact = \"friction\"\nfriction = 0.3",
                   {"^case.toml:32: ", "contact_by = \"nodes\" goes by the signs of reactions at nodes, which mean nothing on elements"}},
        WrongInput{"friction_missing",
                   "receding_correction = 0.5",
                   "contact = \"friction\"",
                   {"^case.toml:35: ", "contact = \"friction\" needs friction, Coulomb's coefficient"}},
        WrongInput{"friction_negative",
                   "receding_correction = 0.5",
                   "contact = \"friction\"\n@friction = -0.1",
                   {"friction = -0.1 is not allowed, it must be >= 0"}},
        WrongInput{"friction_of_no_tension",
                   "receding_correction = 0.5",
                   "contact = \"no_tension\"\n@friction = 0.3",
                   {"friction is for contact = \"friction\" only"}},
        WrongInput{"contact_of_components",
                   "receding_correction = 0.5",
                   "components = [\"x\"]\ncontact = \"no_tension\"",
                   {"^case.toml:36: ", "contact = \"no_tension\" needs all components"}},
        WrongInput{
            "corners_count", "refinements = 0", "corners = [[0, 0], [1, 0], [1, 1]]", {"corners has 3 points; give 4, counter-clockwise"}},
        WrongInput{"corners_beyond",
                   "refinements = 0",
                   "corners = [[0, 0], [1, 0], [1.5, 1], [0, 1]]",
                   {"^case.toml:10: ", "corners[2] = [1.5, 1] is outside of the box from lower = [0, 0] to upper = [1, 1]"}},
        WrongInput{"corners_clockwise",
                   "refinements = 0",
                   "corners = [[0, 0], [0, 1], [1, 1], [1, 0]]",
                   {"corners[0] = [0, 0]: cells there would be turned inside out; go counter-clockwise"}},
        WrongInput{"corners_reentrant",
                   "refinements = 0",
                   "corners = [[0, 0], [1, 0], [0.3, 0.3], [0, 1]]",
                   {"corners[2] = [0.3, 0.3]: cells there would be turned inside out"}},
        WrongInput{"corners_miss_the_body",
                   "refinements = 0",
                   "corners = [[0, 0], [1, 0], [0.5, 1], [0, 1]]",
                   {"^case.toml:26: ", "body \"block\": particle", "is outside of the quadrilateral of grid.corners"}},
        WrongInput{"slip_on_an_inclined_side",
                   "refinements = 0",
                   "corners = [[0, 0], [1, 0], [1, 1], [0, 0.9]]\n@[[boundary]]\nside = \"top\"\nkind = \"slip\"\n",
                   {"kind = \"slip\" holds the component across a side, but grid.corners inclines side = \"top\""}},
        WrongInput{"ring_and_corners",
                   "refinements = 0",
                   "corners = [[0, 0], [1, 0], [1, 1], [0, 1]]\nring = { inner_radius = 0.5, outer_radius = 1 }",
                   {"^case.toml:11: ", "ring and corners are both given"}},
        WrongInput{"ring_inside_out",
                   "refinements = 0",
                   "ring = { inner_radius = 1, outer_radius = 0.5 }",
                   {"^case.toml:10: ", "outer_radius = 0.5 must be greater than inner_radius = 1"}},
        WrongInput{"ring_that_closes",
                   "refinements = 0",
                   "ring = { center = [0.5, 0.5], inner_radius = 0.1, outer_radius = 0.4, start_angle = 0, end_angle = 360 }",
                   {"make 360 degrees, allowed: above 0, below 360"}},
        WrongInput{
            "ring_of_wide_cells",
            "cells = [8, 8]\ngrading = [1, 1.1]\nrefinements = 0",
            "cells = [8, 4]\nring = { center = [0.5, 0.5], inner_radius = 0.1, outer_radius = 0.4, start_angle = 0, end_angle = 359 }",
            {"^case.toml:9: ", "359 degrees in 4 cells make cells of 89.75 degrees, allowed: 45 at the most"}},
        WrongInput{"ring_beyond",
                   "refinements = 0",
                   "ring = { inner_radius = 0.5, outer_radius = 1, start_angle = 80, end_angle = 100 }",
                   {"it reaches from -0.173648 to 0.173648 in x, outside of the box"}},
        WrongInput{
            "ring_of_a_number", "refinements = 0", "ring = 3", {"ring must be a table { inner_radius = ..., outer_radius = ... }, got 3"}},
        WrongInput{"ring_misses_the_body",
                   "refinements = 0",
                   "ring = { inner_radius = 0.1, outer_radius = 0.2 }",
                   {"^case.toml:26: ", "body \"block\": particle", "is outside of the ring of grid.ring"}},
        WrongInput{"slip_on_a_round_side",
                   "refinements = 0",
                   "ring = { inner_radius = 0.1, outer_radius = 1 }\n@[[boundary]]\nside = \"left\"\nkind = \"slip\"\n",
                   {"kind = \"slip\" holds the component across a side, but grid.ring inclines side = \"left\""}},
        WrongInput{
            "velocity_by_place_with_contact",
            "refinements = 0",
            "@[[boundary]]\nside = \"top\"\nkind = \"velocity\"\ncontact = \"no_tension\"\nvelocity = { type = \"linear\", gradient = [[1, "
            "0], [0, 0]] }\n",
            {"a velocity by place is for nodes that a boundary holds, not for contact in the implicit solver"}},
        WrongInput{
            "corners_of_splines",
            "grading = [1, 1.1]\nrefinements = 0\n\n[time]\ndt = 1e-2\nend = 0.1\n\n[solver]\ntype = \"implicit\"\nbasis = "
            "\"element\"\nelement_order = 2",
            "corners = [[0, 0], [1, 0], [1, 1], [0, 1]]\n[time]\ndt = 1e-2\nend = 0.1\n[solver]\ntype = \"implicit\"\nbasis = \"bspline\"",
            {"corners is for solver.basis = \"element\"; B-splines need equal cells"}},
        WrongInput{"grading_of_splines",
                   "basis = \"element\"\nelement_order = 2",
                   "basis = \"bspline\"",
                   {"^case.toml:9: ", "grading is for solver.basis = \"element\"; B-splines need equal cells"}},
        WrongInput{"periodic", "refinements = 0", "periodic = [\"x\"]", {"the implicit solver has no periodic sides"}},
        WrongInput{"region",
                   "side = \"bottom\"\nkind = \"fixed\"\nreceding_correction = 0.5",
                   "region = { type = \"box\", lower = [0, 0], upper = [1, 0.2] }\nkind = \"slip\"",
                   {"^case.toml:32: ", "has no kind = \"slip\" for a region"}},
        WrongInput{
            "correction", "receding_correction = 0.5", "receding_correction = 1.5", {"^case.toml:35: ", "receding_correction = 1.5"}},
        WrongInput{"grid_output", "", "[output]\n@grid = true\n", {"the implicit solver writes no fields of nodes"}},
        WrongInput{"gravity_table",
                   "gravity_factors = [1, 0]",
                   "gravity_factors = [1]",
                   {"^case.toml:2: ", "gravity_times has 2 entries and gravity_factors 1; they must match"}},
        WrongInput{"gravity_order",
                   "gravity_times = [0, 1]",
                   "gravity_times = [1, 1]",
                   {"gravity_times[1] = 1 must be greater than gravity_times[0] = 1"}}),
    name_of);

class ImplicitKeys : public testing::TestWithParam<WrongInput> {};
TEST_P(ImplicitKeys, are_refused_by_the_explicit_solver) { expect_refused(k_case, GetParam()); }

INSTANTIATE_TEST_SUITE_P(
    all, ImplicitKeys,
    testing::Values(WrongInput{"corners",
                               "periodic = []",
                               "corners = [[0, 0], [1, 0], [1, 1], [0, 1]]",
                               {"corners is for solver.type = \"implicit\" only"}},
                    WrongInput{"beta", "flip = 1", "beta = 0.3", {"solver: beta is for solver.type = \"implicit\" only"}},
                    WrongInput{"grading", "periodic = []", "grading = 1.1", {"grading is for solver.type = \"implicit\" only"}},
                    WrongInput{"rule",
                               "dt = 1e-4",
                               "rule = { type = \"table\", times = [0], steps = [0.1] }",
                               {"rule is for solver.type = \"implicit\" only"}},
                    WrongInput{"attached",
                               "side = \"bottom\"\nkind = \"slip\"",
                               "side = \"bottom\"\nattached = true",
                               {"^case.toml:33: ", "attached is for solver.type = \"implicit\" only"}}),
    name_of);

TEST(WrongImplicit, static_runs_have_no_rates_and_no_velocities) {
  const std::vector<std::string> sets = {"solver.mode=static"};
  EXPECT_EQ(refusal(k_implicit_case, sets), "no exception");
  std::string fluid = k_implicit_case;
  const std::string law = "neo_hookean\", density = 1000, youngs_modulus = 1e5, poissons_ratio = 0.3";
  fluid.replace(fluid.find(law), law.size(), "newtonian_fluid\", density = 1000, pressure_scale = 1e5");
  EXPECT_THAT(refusal(fluid, sets),
              testing::HasSubstr("body block: the law \"newtonian_fluid\" depends on rates, which mode = \"static\" does not have"));
  std::string moving = k_implicit_case;
  moving.insert(moving.find("material ="), "velocity = { type = \"uniform\", value = [1, 0] }\n");
  EXPECT_THAT(refusal(moving, sets), testing::HasSubstr("body block: a body in mode = \"static\" has no velocity"));
}

TEST(WrongImplicit, particles_outside_are_named) {
  EXPECT_THAT(refusal(k_implicit_case, {"body.block.region.upper=[0.75,1.2]"}),
              testing::HasSubstr("is outside the grid [0, 0] to [1, 1]; move the body or enlarge the grid"));
}

TEST(WrongImplicit, methods_of_petsc_need_a_program_with_it_and_its_options_such_a_method) {
  const std::vector<std::string>& names = linear_solver_names();
  const bool has_petsc = std::find(names.begin(), names.end(), "gamg") != names.end();
  for (const std::string name : {"gamg", "mumps"}) {
    EXPECT_THAT(refusal(k_implicit_case, {"solver.linear_solver=" + name}),
                testing::HasSubstr(has_petsc ? "no exception" : "built without PETSc (-DMATPOINT_MPI=ON builds it in)"));
  }
  EXPECT_THAT(refusal(k_implicit_case, {"solver.petsc=\"-ksp_monitor\""}),
              testing::HasSubstr("petsc holds options for linear_solver = \"gamg\" or \"mumps\", and it is \"auto\""));
  EXPECT_EQ(refusal(k_implicit_case, {"solver.petsc=\"\""}), "no exception");
}

TEST(WrongImplicit, friction_needs_a_solver_for_unsymmetric_matrices) {
  std::string text = k_implicit_case;
  for (const auto& [from, to] : {std::pair<std::string, std::string>{"basis = \"element\"\nelement_order = 2\n", ""},
                                 {"grading = [1, 1.1]\n", ""},
                                 {"receding_correction = 0.5", "contact = \"friction\"\nfriction = 0.3"}}) {
    text.replace(text.find(from), from.size(), to);
  }
  EXPECT_EQ(refusal(text), "no exception");
  for (const char* name : {"ldlt", "cg"}) {
    const std::vector<std::string> sets = {fmt::format("solver.linear_solver={}", name)};
    EXPECT_THAT(refusal(text, sets), testing::HasSubstr(fmt::format(
                                         "boundary 1: friction makes the matrix unsymmetric, and linear_solver = \"{}\" is for", name)));
  }
  EXPECT_EQ(refusal(text, {"solver.linear_solver=ldlt", "boundary.1.friction=0"}), "no exception");
}

}  // namespace
}  // namespace matpoint::test
