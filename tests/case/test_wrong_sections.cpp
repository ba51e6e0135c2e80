// Wrong values in [grid], [time], [solver], [output] and at the top of a case.
#include "case/wrong_input.hpp"

namespace matpoint::test {
namespace {

class WrongSection : public testing::TestWithParam<WrongInput> {};
TEST_P(WrongSection, is_refused_in_words) { expect_refused(k_case, GetParam()); }

INSTANTIATE_TEST_SUITE_P(
    unknown_keys, WrongSection,
    testing::Values(
        WrongInput{"case_key", "gravity = [0, -10]", "gravitiy = [0, -10]", {"unknown key \"gravitiy\"", "did you mean \"gravity\"?"}},
        WrongInput{"case_section", "[solver]", "[sovler]", {"unknown key \"sovler\"", "did you mean \"solver\"?"}},
        WrongInput{"grid", "periodic = []", "periodicity = []", {"grid: unknown key \"periodicity\"", "did you mean \"periodic\"?"}},
        WrongInput{"time", "end = 0.01", "end = 0.01\n@t_end = 1", {"time: unknown key \"t_end\"", "did you mean \"end\"?"}},
        WrongInput{"solver", "damping = 0", "dampping = 0", {"solver: unknown key \"dampping\"", "did you mean \"damping\"?"}},
        WrongInput{"output", "precision = \"single\"", "precison = \"single\"", {"output: unknown key", "did you mean \"precision\"?"}},
        WrongInput{
            "body", "name = \"block\"", "name = \"block\"\n@materail = 1", {"body \"block\": unknown key", "did you mean \"material\"?"}},
        WrongInput{"boundary", "kind = \"slip\"", "kindd = \"slip\"", {"boundary 1: unknown key \"kindd\"", "did you mean \"kind\"?"}},
        WrongInput{"probe", "particle = 0", "particel = 0", {"probe \"tip\": unknown key \"particel\"", "did you mean \"particle\"?"}},
        WrongInput{
            "region", "lower = [0.25, 0.5]", "lowr = [0.25, 0.5]", {"body \"block\": region: unknown key", "did you mean \"lower\"?"}},
        WrongInput{"layout", "count = 4", "cuont = 4", {"body \"block\": layout: unknown key", "did you mean \"count\"?"}},
        WrongInput{"velocity", "value = [0, 0]", "values = [0, 0]", {"body \"block\": velocity: unknown key", "did you mean \"value\"?"}},
        WrongInput{"material", "density", "densty", {"body \"block\": material: unknown key \"densty\"", "did you mean \"density\"?"}},
        WrongInput{"far_from_all_names",
                   "damping = 0",
                   "qqqqqqqqqqqqqq = 0",
                   {"solver: unknown key", "known keys: \"quality\", \"type\", \"stress_order\""}},
        WrongInput{"endless_name", "damping = 0", std::string(1000, 'q') + " = 0", {std::string(60, 'q') + "...\""}},
        WrongInput{"with_line_break", "damping = 0", "\"a\\nb\" = 0", {"unknown key \"a?b\""}}),
    name_of);

INSTANTIATE_TEST_SUITE_P(
    wrong_types, WrongSection,
    testing::Values(
        WrongInput{"string", "title = \"A block falls\"", "title = 7", {"title must be a string, got 7 (an integer)"}},
        WrongInput{"number", "damping = 0", "damping = \"0\"", {"solver: damping must be a number, got \"0\" (a string)"}},
        WrongInput{"number_boolean", "damping = 0", "damping = true", {"damping must be a number, got true (true or false)"}},
        WrongInput{"number_array", "damping = 0", "damping = [1, 2]", {"damping must be a number, got [1, 2] (an array)"}},
        WrongInput{"boolean", "precision", "grid = 1\nprecision", {"output: grid must be true or false, got 1 (an integer)"}},
        WrongInput{"integer", "particle = 0", "particle = 0.5", {"probe \"tip\": particle must be an integer, got 0.5 (a number)"}},
        WrongInput{"vector", "gravity = [0, -10]", "gravity = -10", {"gravity must be an array of 2 numbers, got -10 (an integer)"}},
        WrongInput{"vector_entry", "gravity = [0, -10]", "gravity = [0, \"g\"]", {"gravity[1] must be a number, got \"g\" (a string)"}},
        WrongInput{
            "numbers", "fields_at = [0.005]", "fields_at = \"all\"", {"fields_at must be a number or an array of numbers, got \"all\""}},
        WrongInput{"integers", "cells = [8, 8]", "cells = 8", {"grid: cells must be an array of integers, got 8"}},
        WrongInput{"integers_entry", "cells = [8, 8]", "cells = [8, 8.5]", {"grid: cells[1] must be an integer, got 8.5"}},
        WrongInput{"strings", "formats = [\"vtkhdf\"]", "formats = \"vtu\"", {"formats must be an array of strings, got \"vtu\""}},
        WrongInput{"strings_entry", "formats = [\"vtkhdf\"]", "formats = [1]", {"formats[0] must be a string, got 1"}},
        WrongInput{"points",
                   "type = \"box\", lower = [0.25, 0.5], upper = [0.75, 0.75]",
                   "type = \"polygon\", vertices = 3",
                   {"vertices must be an array of points, got 3"}},
        WrongInput{"points_entry",
                   "type = \"box\", lower = [0.25, 0.5], upper = [0.75, 0.75]",
                   "type = \"polygon\", vertices = [1, 2, 3]",
                   {"vertices[0] must be an array of 2 numbers, got 1"}},
        WrongInput{"section", "[output]\n", "[[output]]\n", {"output: expected a table, got [{...}]"}},
        WrongInput{"list", "[[probe]]\n", "[probe]\n", {"probe must be a list of tables [[probe]], got {...} (a table)"}},
        WrongInput{"date", "title = \"A block falls\"", "title = 2020-01-01", {"dates and times are not used in case files"}},
        WrongInput{"time_of_day", "damping = 0", "damping = 07:32:00", {"times are numbers in seconds"}},
        WrongInput{"long_string",
                   "damping = 0",
                   "damping = \"" + std::string(1000, 'x') + "\"",
                   {"got \"" + std::string(59, 'x') + "... (a string)"}}),
    name_of);

INSTANTIATE_TEST_SUITE_P(
    top, WrongSection,
    testing::Values(
        WrongInput{"dim", "title", "dim = 4\ntitle", {"dim = 4 is not allowed, it must be 2 or 3"}},
        WrongInput{"dim_not_whole", "title", "dim = 2.5\ntitle", {"dim must be an integer, got 2.5"}},
        WrongInput{"gravity_components",
                   "gravity = [0, -10]",
                   "gravity = [0, 0, -10]",
                   {"gravity = [0, 0, -10] has 3 numbers; the case has dim = 2, so it must have 2"}},
        WrongInput{"gravity_infinite", "gravity = [0, -10]", "gravity = [0, -inf]", {"gravity[1] = -inf is not a finite number"}},
        WrongInput{"no_time", "[time]\ndt = 1e-4\nend = 0.01\n", "", {"^case.toml: ", "time is missing (table): End and time step."}},
        WrongInput{"no_grid",
                   "[grid]\nlower = [0, 0]\nupper = [1, 1]\ncells = [8, 8]\nperiodic = []\nparticles_outside = \"error\"\n",
                   "",
                   {"^case.toml: ", "grid is missing (table)"}}),
    name_of);

INSTANTIATE_TEST_SUITE_P(
    grid, WrongSection,
    testing::Values(
        WrongInput{"upper_below_lower", "upper = [1, 1]", "upper = [1, -1]", {"grid: upper[1] = -1 must be greater than lower[1] = 0"}},
        WrongInput{"upper_equals_lower", "upper = [1, 1]", "upper = [0, 1]", {"grid: upper[0] = 0 must be greater than lower[0] = 0"}},
        WrongInput{"no_upper", "upper = [1, 1]\n", "", {"^case.toml:4: ", "grid: upper is missing (dim numbers [m]): Corner"}},
        WrongInput{"upper_nan", "upper = [1, 1]", "upper = [1, nan]", {"grid: upper[1] = nan is not a finite number"}},
        WrongInput{"cells_and_size",
                   "cells = [8, 8]",
                   "cells = [8, 8]\ncell_size = 0.125",
                   {"^case.toml:4: grid: ", "cells and cell_size are both given; give one of them"}},
        WrongInput{"no_cells", "cells = [8, 8]\n", "", {"^case.toml:4: grid: ", "cells is missing: give cells = [...], or cell_size"}},
        WrongInput{"cells_zero", "cells = [8, 8]", "cells = [8, 0]", {"grid: cells[1] = 0 is not allowed, it must be >= 1"}},
        WrongInput{
            "cells_components", "cells = [8, 8]", "cells = [8, 8, 8]", {"cells = [8, 8, 8] has 3 numbers", "dim = 2, so it must have 2"}},
        WrongInput{"cells_too_large", "cells = [8, 8]", "cells = [3e9, 1]", {"cells[0] = 3000000000 is too large"}},
        WrongInput{"too_many_nodes",
                   "cells = [8, 8]",
                   "cells = [1e6, 1e6]",
                   {"^case.toml:4: grid: ", "the grid has 1e+12 nodes, at most 4e+09 are possible; take larger cells"}},
        WrongInput{"size_does_not_divide",
                   "cells = [8, 8]",
                   "cell_size = 0.3",
                   {"grid: cell_size = 0.3 does not divide the side of 1 m in x", "the nearest that does is 0.3333333333"}},
        WrongInput{"size_above_the_side",
                   "cells = [8, 8]",
                   "cell_size = [0.5, 3]",
                   {"cell_size = 3 does not divide the side of 1 m in y", "the nearest that does is 1"}},
        WrongInput{"size_components",
                   "cells = [8, 8]",
                   "cell_size = [1, 1, 1]",
                   {"cell_size = [1, 1, 1] has 3 numbers; give one, or one per direction (2)"}},
        WrongInput{"size_negative", "cells = [8, 8]", "cell_size = -0.125", {"grid: cell_size = -0.125 is not allowed, it must be > 0"}},
        WrongInput{"periodic", "periodic = []", "periodic = [\"z\"]", {"grid: periodic: \"z\" is unknown, allowed: \"x\" or \"y\""}},
        WrongInput{"particles_outside",
                   "\"error\"",
                   "\"removed\"",
                   {"particles_outside = \"removed\" is unknown, allowed: \"error\", \"remove\" or \"stop\"", "did you mean \"remove\"?"}},
        WrongInput{"beyond_numbers_above",
                   "lower = [0, 0]\nupper = [1, 1]",
                   "lower = [-1e308, 0]\nupper = [1e308, 1]",
                   {"^case.toml:4: grid: ", "the cells' side of inf m in x is beyond the range of numbers; lengths are in m"}},
        WrongInput{"beyond_numbers", "upper = [1, 1]", "upper = [1e-320, 1]", {"^case.toml:4: grid: ", "beyond the range of numbers"}}),
    name_of);

INSTANTIATE_TEST_SUITE_P(
    time, WrongSection,
    testing::Values(
        WrongInput{"end_zero", "end = 0.01", "end = 0", {"time: end = 0 is not allowed, it must be > 0"}},
        WrongInput{"end_negative", "end = 0.01", "end = -1", {"time: end = -1 is not allowed, it must be > 0"}},
        WrongInput{"end_infinite", "end = 0.01", "end = inf", {"time: end = inf is not a finite number"}},
        WrongInput{"no_end", "end = 0.01\n", "", {"^case.toml:11: time: ", "end is missing (number [s]): The run ends at this time."}},
        WrongInput{"dt_zero", "dt = 1e-4", "dt = 0", {"time: dt = 0 is not allowed, it must be > 0"}},
        WrongInput{"dt_negative", "dt = 1e-4", "dt = -1e-4", {"time: dt = -0.0001 is not allowed, it must be > 0"}},
        WrongInput{"dt_longer_than_the_run", "dt = 1e-4", "dt = 1", {"time: dt = 1 is longer than the whole run (end = 0.01)"}},
        WrongInput{"dt_absurdly_short", "dt = 1e-4", "dt = 1e-300", {"time: dt = 1e-300 makes 1e+298 steps to end = 0.01, at most 1e+15"}},
        WrongInput{"dt_max_absurdly_short", "dt = 1e-4", "dt_max = 1e-300", {"time: dt_max = 1e-300 makes 1e+298 steps"}},
        WrongInput{
            "cfl_with_dt", "dt = 1e-4", "dt = 1e-4\n@cfl = 0.5", {"time: cfl is for automatic time steps, but dt = 0.0001 fixes them"}},
        WrongInput{"dt_min_with_dt", "dt = 1e-4", "dt = 1e-4\n@dt_min = 0", {"time: dt_min is for automatic time steps"}},
        WrongInput{"cfl_above_one", "dt = 1e-4", "cfl = 1.5", {"time: cfl = 1.5 is not allowed, it must be in the interval (0, 1]"}},
        WrongInput{"cfl_zero", "dt = 1e-4", "cfl = 0", {"time: cfl = 0 is not allowed, it must be in the interval (0, 1]"}},
        WrongInput{"dt_max_below_dt_min", "dt = 1e-4", "dt_max = 1e-6\ndt_min = 1e-5", {"time: dt_max = 1e-06 is below dt_min = 1e-05"}}),
    name_of);

INSTANTIATE_TEST_SUITE_P(
    solver, WrongSection,
    testing::Values(
        WrongInput{"type",
                   "flip = 1",
                   "type = \"implict\"",
                   {"solver: type: \"implict\" is unknown, allowed: \"explicit\" or \"implicit\"", "did you mean \"implicit\"?"}},
        WrongInput{"stress_order",
                   "\"musl\"",
                   "\"muls\"",
                   {"solver: stress_order = \"muls\" is unknown, allowed: \"usl\", \"usf\" or \"musl\"", "did you mean"}},
        WrongInput{"stress_order_upper_case", "\"musl\"", "\"USL\"", {"stress_order = \"USL\" is unknown", "did you mean \"usl\"?"}},
        WrongInput{"shape",
                   "flip = 1",
                   "shape = \"bspline\"",
                   {"solver: shape = \"bspline\" is unknown, allowed: \"linear\", \"bspline2\", \"bspline3\", \"gimp\" or \"cpdi\"",
                    "did you mean \"bspline2\"?"}},
        WrongInput{"quality",
                   "flip = 1",
                   "quality = \"fasst\"",
                   {"solver: quality: \"fasst\" is unknown, allowed: \"robust\", \"accurate\" or \"fast\"", "did you mean \"fast\"?"}},
        WrongInput{"fmpm_order_of_flip", "flip = 1", "fmpm_order = 3", {"solver: fmpm_order is for transfer = \"fmpm\" only"}},
        WrongInput{"fmpm_order_zero",
                   "flip = 1",
                   "transfer = \"fmpm\"\n@fmpm_order = 0",
                   {"solver: fmpm_order = 0 is not allowed, it must be in the interval [1, 20]"}},
        WrongInput{"transfer",
                   "flip = 1",
                   "transfer = \"apci\"",
                   {"solver: transfer = \"apci\" is unknown, allowed: \"flip\", \"pic\", \"apic\", \"tpic\" or \"fmpm\"", "did you mean"}},
        WrongInput{"flip_with_other_transfer",
                   "flip = 1",
                   "transfer = \"apic\"\n@flip = 1",
                   {"solver: flip is the share of FLIP in transfer = \"flip\"; leave it out with the others"}},
        WrongInput{
            "friction_in_one_field", "flip = 1", "friction = 0.1", {"solver: friction is for contact = \"multi_field\" or \"pairs\""}},
        WrongInput{"contact_stiffness_without_pairs",
                   "flip = 1",
                   "contact_stiffness = 2",
                   {"solver: contact_stiffness is for contact = \"pairs\" only"}},
        WrongInput{"contact_stiffness_zero",
                   "flip = 1",
                   "contact = \"pairs\"\n@contact_stiffness = 0",
                   {"solver: contact_stiffness = 0 is not allowed, it must be > 0"}},
        WrongInput{
            "contact",
            "flip = 1",
            "contact = \"pair\"",
            {"solver: contact = \"pair\" is unknown, allowed: \"single_field\", \"multi_field\" or \"pairs\"", "did you mean \"pairs\"?"}},
        WrongInput{"pairs_of_one_body",
                   "flip = 1",
                   "contact = \"pairs\"",
                   {"solver: contact = \"pairs\" is for two or more bodies, and the case has one"}},
        WrongInput{"friction_negative",
                   "flip = 1",
                   "contact = \"multi_field\"\n@friction = -0.1",
                   {"solver: friction = -0.1 is not allowed, it must be >= 0"}},
        WrongInput{"contact_of_one_body",
                   "flip = 1",
                   "contact = \"multi_field\"",
                   {"solver: contact = \"multi_field\" is for two or more bodies, and the case has one"}},
        WrongInput{"flip_above_one", "flip = 1", "flip = 1.01", {"solver: flip = 1.01 is not allowed, it must be in the interval [0, 1]"}},
        WrongInput{"flip_negative", "flip = 1", "flip = -0.1", {"solver: flip = -0.1 is not allowed, it must be in the interval [0, 1]"}},
        WrongInput{"damping_negative", "damping = 0", "damping = -3", {"solver: damping = -3 is not allowed, it must be >= 0"}},
        WrongInput{
            "mass_cutoff_negative", "mass_cutoff = 0", "mass_cutoff = -1", {"solver: mass_cutoff = -1 is not allowed, it must be >= 0"}},
        WrongInput{"mass_cutoff_above_all_mass",
                   "mass_cutoff = 0",
                   "mass_cutoff = 126",
                   {"solver: mass_cutoff = 126 kg is more than all bodies weigh, 125 kg", "the smallest particle has 3.90625 kg"}},
        WrongInput{"mass_cutoff_relative_above_all_mass",
                   "mass_cutoff = 0",
                   "mass_cutoff_relative = 33",
                   {"solver: mass_cutoff_relative = 33 (128.906 kg) is more than all bodies weigh, 125 kg"}},
        WrongInput{"both_cutoffs",
                   "mass_cutoff = 0",
                   "mass_cutoff = 0\n@mass_cutoff_relative = 0.1",
                   {"solver: mass_cutoff and mass_cutoff_relative are both given; give one of them"}}),
    name_of);

INSTANTIATE_TEST_SUITE_P(
    output, WrongSection,
    testing::Values(
        WrongInput{
            "fields_at_after_the_end", "[0.005]", "[0.005, 0.02]", {"output: fields_at: 0.02 s is after the end of the run, 0.01 s"}},
        WrongInput{"fields_at_negative", "[0.005]", "[-1]", {"output: fields_at[0] = -1 is not allowed, it must be >= 0"}},
        WrongInput{"compression_above_9",
                   "precision = \"single\"",
                   "compression = 10",
                   {"output: compression = 10 is not allowed, it must be an integer from 0 to 9"}},
        WrongInput{
            "compression_fraction", "precision = \"single\"", "compression = 1.5", {"output: compression must be an integer, got 1.5"}},
        WrongInput{"history_every_zero",
                   "precision",
                   "history_every = 0\nprecision",
                   {"output: history_every = 0 is not allowed, it must be > 0"}},
        WrongInput{"history_every_absurd",
                   "precision",
                   "history_every = 1e-300\nprecision",
                   {"output: history_every = 1e-300 makes 1e+298 outputs until the end of the run, 0.01 s; at most 1e+08 are possible"}},
        WrongInput{
            "fields_every_absurd", "precision", "fields_every = 1e-20\nprecision", {"output: fields_every = 1e-20 makes 1e+18 outputs"}},
        WrongInput{"format",
                   "[\"vtkhdf\"]",
                   "[\"vtk\"]",
                   {"output: formats: \"vtk\" is unknown, allowed: \"vtkhdf\" or \"vtu\"", "did you mean \"vtu\"?"}},
        WrongInput{"precision",
                   "\"single\"",
                   "\"singel\"",
                   {"output: precision: \"singel\" is unknown, allowed: \"single\" or \"double\"", "did you mean \"single\"?"}},
        WrongInput{"field",
                   "precision",
                   "fields = [\"velocty\"]\nprecision",
                   {"^output: fields: ", "\"velocty\" is unknown, allowed: \"position\"", "did you mean \"velocity\"?"}}),
    name_of);

TEST(ValidCase, the_changed_cases_are_valid_without_the_change) {
  EXPECT_EQ(refusal(k_case), "no exception");
  EXPECT_EQ(refusal(k_case_3d), "no exception");
}

/// Choices that do not go together say what does.
TEST(Combination, is_refused_with_what_fits) {
  const std::string second = R"([[body]]
name = "other"
region = { type = "box", lower = [0.25, 0.1], upper = [0.75, 0.3] }
layout = { type = "per_cell", count = 4 }
material = { type = "neo_hookean", density = 1000, youngs_modulus = 1e5, poissons_ratio = 0.3 }
)";
  std::string without_flip = k_case;
  without_flip.erase(without_flip.find("flip = 1\n"), 9);
  struct Refused {
    std::string text;
    std::vector<std::string> sets;
    std::string message;
  };
  for (const Refused& refused : std::vector<Refused>{
           {k_case, {"solver.shape=bspline2", "output.grid=true"}, "output: grid = true is for solver.shape = \"linear\" only"},
           {k_case,
            {"solver.shape=bspline3", "grid.periodic=[\"x\"]", "grid.cells=[2, 8]"},
            "grid: periodic = [\"x\"] with 2 cells is narrower than the shape functions; give it 3 or more"},
           {k_case + second,
            {"solver.contact=multi_field", "grid.periodic=[\"x\"]"},
            "solver: contact = \"multi_field\" cannot be used with periodic sides"},
           {k_case + second,
            {"solver.contact=multi_field", "solver.shape=bspline2"},
            "solver: contact = \"multi_field\" is for shape = \"linear\""},
           {without_flip + second,
            {"solver.contact=multi_field", "solver.transfer=fmpm"},
            "solver: contact = \"multi_field\" cannot be used with transfer = \"fmpm\""},
           {without_flip,
            {"solver.shape=cpdi", "solver.transfer=apic"},
            "solver: transfer = \"apic\" cannot be used with shape = \"cpdi\""},
           {k_case,
            {"solver.shape=cpdi", "solver.stress_order=usf"},
            "solver: stress_order = \"usf\" cannot be used with shape = \"cpdi\""},
           {k_case,
            {"solver.shape=gimp", "grid.periodic=[\"x\"]", "solver.co_rotating=true"},
            "solver: co_rotating = true cannot be used with periodic sides"},
           {k_case + second,
            {"solver.contact=pairs", "grid.periodic=[\"x\"]"},
            "solver: contact = \"pairs\" cannot be used with periodic sides"},
           {k_case + second,
            {"body.other.formulation=total"},
            "body other: formulation = \"total\" is for cases with one body, or for contact = \"pairs\""},
           {k_case + second,
            {"body.other.formulation=total", "solver.contact=multi_field"},
            "body other: formulation = \"total\" is for cases with one body, or for contact = \"pairs\""}}) {
    EXPECT_THAT(refusal(refused.text, refused.sets), testing::HasSubstr(refused.message));
  }
  EXPECT_EQ(refusal(k_case + second, {"solver.contact=multi_field", "solver.friction=0.3"}), "no exception");
  EXPECT_EQ(refusal(k_case + second, {"solver.contact=pairs", "solver.contact_stiffness=3", "solver.friction=0.3", "solver.shape=bspline2",
                                      "body.other.formulation=total"}),
            "no exception");
}

TEST(Quality, chooses_what_is_not_given) {
  const auto read = [](const std::vector<std::string>& sets) {
    std::string text = k_case;
    const std::string choices = "stress_order = \"musl\"\nflip = 1\n";
    text.erase(text.find(choices), choices.size());
    const std::string step = "dt = ";  // the steps are automatic here
    const std::size_t at = text.find(step);
    if (at != std::string::npos) text.erase(at, text.find('\n', at) + 1 - at);
    Input input = parse_toml(text, "case.toml");
    for (const std::string& set : sets) apply_set(input, set);
    return Case::from_input(input, "case");
  };
  const Case none = read({}), accurate = read({"solver.quality=accurate"}), fast = read({"solver.quality=fast"});
  EXPECT_EQ(none.solver.shape, ShapeKind::gimp);
  for (const Case* one : {&accurate, &fast}) {
    EXPECT_EQ(one->solver.shape, none.solver.shape);
    EXPECT_EQ(one->solver.transfer, none.solver.transfer);
    EXPECT_EQ(one->solver.stress_order, none.solver.stress_order);
  }
  EXPECT_EQ(accurate.solver.precision, "double");
  EXPECT_EQ(accurate.time.cfl, 0.2);
  EXPECT_EQ(read({"solver.quality=robust"}).time.cfl, 0.1);
  EXPECT_EQ(fast.solver.precision, "single");
  EXPECT_EQ(fast.time.cfl, none.time.cfl);
  // What is given counts, and what is written gives the same again.
  EXPECT_EQ(read({"solver.quality=accurate", "time.cfl=0.3"}).time.cfl, 0.3);
  EXPECT_EQ(read({"solver.quality=fast", "solver.precision=double"}).solver.precision, "double");
  EXPECT_EQ(Case::from_input(accurate.to_input(), "again").time.cfl, 0.2);
}

}  // namespace
}  // namespace matpoint::test
