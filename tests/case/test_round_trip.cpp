// What is written reads back as the same: cases with their defaults, and values of every kind bit for bit.
#include <bit>

#include "case/wrong_input.hpp"

namespace matpoint::test {
namespace {

std::string resolved(const Case& problem) { return write_toml(problem.to_input()); }
Case read(const std::string& text) { return Case::from_input(parse_toml(text, "case.toml"), "case"); }

TEST(RoundTrip, every_shipped_case_is_valid_and_resolves_to_itself) {
  ASSERT_GE(shipped_cases().size(), 7u);
  for (const auto& [name, text] : shipped_cases()) {
    const std::string once = resolved(load_case(name));
    EXPECT_EQ(resolved(read(once)), once) << name;
  }
}

TEST(RoundTrip, implicit_cases_resolve_to_themselves) {
  const std::string text = R"(
gravity = [0, -9.81]
[grid]
upper = [1, 1]
cells = [8, 8]
[time]
end = 1
dt = 0.1
[solver]
type = "implicit"
[[body]]
name = "block"
region = { type = "box", lower = [0.25, 0], upper = [0.5, 0.25] }
layout = { type = "per_cell", count = 4 }
material = { type = "neo_hookean", density = 1000, youngs_modulus = 1e5, poissons_ratio = 0.3 }
[[body]]
name = "other"
region = { type = "box", lower = [0.25, 0.5], upper = [0.5, 0.75] }
layout = { type = "per_cell", count = 4 }
material = { type = "neo_hookean", density = 1000, youngs_modulus = 1e5, poissons_ratio = 0.49 }
[[boundary]]
side = "bottom"
kind = "fixed"
)";
  const std::vector<std::vector<std::string>> kinds = {{},
                                                       {"solver.basis=element"},
                                                       {"solver.basis=element", "solver.element_order=1"},
                                                       {"solver.surface_penalty=10"},
                                                       {"solver.mode=static"},
                                                       {"solver.contact=pairs", "solver.friction=0.3"},
                                                       {"solver.basis=element", "grid.ring={inner_radius = 0.1, outer_radius = 0.9}",
                                                        "boundary.1.kind=velocity",
                                                        "boundary.1.velocity={type = \"linear\", gradient = [[1, 0], [0, 1]]}"}};
  for (const std::vector<std::string>& sets : kinds) {
    Input input = parse_toml(text, "case.toml");
    for (const std::string& set : sets) apply_set(input, set);
    const std::string once = resolved(Case::from_input(input, "case"));
    EXPECT_EQ(resolved(read(once)), once) << fmt::format("{}", fmt::join(sets, " "));
  }
}

TEST(RoundTrip, a_case_with_one_of_everything_resolves_to_itself) {
  const std::string text = R"(
gravity = [0, -9.81]
[grid]
lower = [-1, -1]
upper = [1, 1]
cell_size = 0.125
periodic = ["x"]
particles_outside = "remove"
[time]
end = 1
dt_max = 1e-3
[solver]
stress_order = "usf"
mass_cutoff_relative = 0.01
[output]
fields = ["velocity", "J"]
formats = ["vtu", "vtkhdf"]
fields_at = 0.5
precision = "double"
[[body]]
name = "a \"quoted\" name"
region = { type = "difference", of = [{ type = "union", of = [{ type = "disk", center = [0, 0], radius = 0.3 },
  { type = "polygon", vertices = [[0, 0], [0.5, 0], [0.5, 0.5]] }] }, { type = "half_space", point = [0, 0], normal = [0, 1] }] }
layout = { type = "per_cell", count = [2, 3] }
velocity = { type = "linear", gradient = [[1, 2], [3, 4]], center = [0.1, 0.2] }
material = { type = "newtonian_fluid", density = 1000, pressure_scale = 1e5 }
[[body]]
name = "wheel"
region = { type = "disk", center = [0, 0], radius = 0.3 }
layout = { type = "polar", rings = 3, sectors = 8 }
velocity = { type = "rotating", center = [0, 0], angular_velocity = 2 }
material = { type = "st_venant_kirchhoff", density = 1000, youngs_modulus = 1e5, poissons_ratio = -0.3 }
[[boundary]]
side = "bottom"
[[boundary]]
side = "top"
kind = "fixed"
components = ["y"]
[[boundary]]
region = { type = "box", lower = [0, 0], upper = [0.5, 0.5] }
kind = "velocity"
times = [0, 1]
velocities = [[0, 0], [1, 0]]
[[boundary]]
region = { type = "disk", center = [0, 0], radius = 0.5 }
kind = "velocity"
velocity = [0, 1]
[[boundary]]
side = "top"
kind = "velocity"
components = ["x"]
velocity = [1, 0.5]
times = [0, 2]
factors = [1, 0.5]
[[probe]]
name = "p"
body = "wheel"
nearest = [0, 0]
)";
  const std::string once = resolved(read(text));
  EXPECT_EQ(resolved(read(once)), once);
  for (const char* part : {"cells = [16, 16]", "cfl = 0.4", "flip = 1.0", "gamma = 7.0", "lower = [-1.0, -1.0]", "sectors = 8"}) {
    EXPECT_THAT(once, testing::HasSubstr(part));
  }
  EXPECT_THAT(once, testing::Not(testing::HasSubstr("mass_cutoff = ")));
}

TEST(RoundTrip, a_3d_case_resolves_to_itself) {
  const std::string once = resolved(read(k_case_3d));
  EXPECT_EQ(resolved(read(once)), once);
  EXPECT_THAT(once, testing::HasSubstr("gravity = [0.0, 0.0, 0.0]"));
}

TEST(RoundTrip, places_do_not_matter_to_values) { EXPECT_EQ(resolved(read(k_case)), resolved(read("# a comment\n\n" + k_case))); }

TEST(RoundTrip, numbers_keep_their_bits) {
  std::vector<Real> numbers = {0.0,
                               -0.0,
                               0.1,
                               1.0 / 3,
                               1e22,
                               1e21,
                               123456789012345680.0,
                               5e-324,
                               2.2250738585072014e-308,
                               1.7976931348623157e308,
                               -1e-5,
                               1e5,
                               9007199254740993.0,
                               0x1.fffffffffffffp-3,
                               std::numeric_limits<Real>::infinity(),
                               -std::numeric_limits<Real>::infinity()};
  std::uint64_t state = 1;
  for (int k = 0; k < 10000; ++k) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    const Real number = std::bit_cast<Real>(state);
    if (std::isfinite(number)) numbers.push_back(number);
  }
  Input table = Input::table();
  Input& array = table.set("numbers", Input::array());
  for (const Real number : numbers) array.items().push_back(Input::real(number));
  const Input back = parse_toml(write_toml(table), "numbers.toml");
  const std::vector<Input>& items = back.find("numbers")->items();
  ASSERT_EQ(items.size(), numbers.size());
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    ASSERT_EQ(items[k].kind(), Input::Kind::real) << numbers[k];
    ASSERT_EQ(std::bit_cast<std::uint64_t>(items[k].as_real()), std::bit_cast<std::uint64_t>(numbers[k])) << numbers[k];
  }
}

TEST(RoundTrip, integers_booleans_strings_and_keys_come_back) {
  const std::vector<std::string> strings = {"",
                                            "plain",
                                            "two words",
                                            "a \"quote\"",
                                            "back\\slash",
                                            "line\nbreak\ttab\r",
                                            std::string("nul\0nul", 7),
                                            "\x01\x1f\x7f",
                                            "µ ≤ €",
                                            "# no comment",
                                            "[no.section]",
                                            "'single'",
                                            "\"\"\"",
                                            "\\u0041"};
  Input table = Input::table();
  Input& array = table.set("strings", Input::array());
  for (const std::string& text : strings) array.items().push_back(Input::string(text));
  table.set("least", Input::integer(std::numeric_limits<Index>::min()));
  table.set("greatest", Input::integer(std::numeric_limits<Index>::max()));
  table.set("yes", Input::boolean(true));
  table.set("a key.with \"quotes\"", Input::boolean(false));
  table.set("", Input::integer(7));
  Input& inner = table.set("section with space", Input::table());
  inner.set("empty", Input::array());
  inner.set("type", Input::string("box"));
  const Input back = parse_toml(write_toml(table), "values.toml");
  for (std::size_t k = 0; k < strings.size(); ++k) EXPECT_EQ(back.find("strings")->items()[k].as_string(), strings[k]);
  EXPECT_EQ(back.find("least")->as_integer(), std::numeric_limits<Index>::min());
  EXPECT_EQ(back.find("greatest")->as_integer(), std::numeric_limits<Index>::max());
  EXPECT_TRUE(back.find("yes")->as_boolean());
  EXPECT_FALSE(back.find("a key.with \"quotes\"")->as_boolean());
  EXPECT_EQ(back.find("")->as_integer(), 7);
  EXPECT_TRUE(back.find("section with space")->find("empty")->items().empty());
  EXPECT_EQ(back.find("section with space")->find("type")->as_string(), "box");
}

TEST(RoundTrip, bytes_that_are_no_characters_are_replaced_because_toml_cannot_hold_them) {
  Input table = Input::table();
  table.set("command", Input::string("run \xff.toml"));
  EXPECT_EQ(parse_toml(write_toml(table), "values.toml").find("command")->as_string(), "run \xef\xbf\xbd.toml");
}

TEST(Values, integers_stand_for_reals_and_whole_reals_for_integers) {
  const auto with = [](const std::string& set) {
    Input input = parse_toml(k_case, "case.toml");
    apply_set(input, set);
    return Case::from_input(input, "case");
  };
  EXPECT_EQ(with("solver.damping=3").solver.damping, 3);
  EXPECT_EQ(with("gravity=[1, 2]").gravity, (Vec3{1, 2, 0}));
  EXPECT_EQ(with("grid.cells=[1e3, 2.0]").grid.cells, (std::vector<int>{1000, 2}));
  EXPECT_EQ(with("probe.tip.particle=1e6").probes[0].particle, 1000000);
  EXPECT_EQ(with("output.fields_at=0.01").output.fields_at, std::vector<Real>{0.01});
}

TEST(Values, cells_and_cell_size_describe_the_same_grid) {
  const auto grid = [](const std::string& line) {
    Input input = parse_toml(k_case, "case.toml");
    input.find("grid")->entries().erase(input.find("grid")->entries().begin() + 2);
    apply_set(input, line);
    return Case::from_input(input, "case").grid;
  };
  EXPECT_EQ(grid("grid.cell_size=0.1").cells, (std::vector<int>{10, 10}));
  EXPECT_EQ(grid("grid.cell_size=[0.1, 0.5]").cells, (std::vector<int>{10, 2}));
  EXPECT_EQ(grid("grid.cells=[10, 2]").cell_size, (std::vector<Real>{0.1, 0.5}));
}

TEST(NearestName, is_offered_for_typing_errors_only) {
  EXPECT_EQ(nearest_name("dampping", {"flip", "damping"}), "damping");
  EXPECT_EQ(nearest_name("Flip", {"flip", "damping"}), "flip");
  EXPECT_EQ(nearest_name("", {"dt", "flip"}), "");
  EXPECT_EQ(nearest_name(std::string(100, 'x'), {"flip"}), "");
}

TEST(Printable, is_one_line_and_never_cut_within_a_character) {
  EXPECT_EQ(printable("a\nb\x7f"), "a?b?");
  EXPECT_EQ(printable("abc", 3), "abc");
  EXPECT_EQ(printable("abcd", 3), "abc...");
  EXPECT_EQ(printable("ab€", 4), "ab...");
  EXPECT_EQ(printable("ab€", 5), "ab€");
}

}  // namespace
}  // namespace matpoint::test
