// Wrong [[body]] entries: regions, layouts, velocities, materials, and what only the whole case or the particles show.
#include <unistd.h>

#include "case/wrong_input.hpp"

namespace matpoint::test {
namespace {

const std::string k_box = "{ type = \"box\", lower = [0.25, 0.5], upper = [0.75, 0.75] }";
const std::string k_layout = "{ type = \"per_cell\", count = 4 }";
const std::string k_velocity = "{ type = \"uniform\", value = [0, 0] }";
const std::string k_material = "{ type = \"neo_hookean\", density = 1000, youngs_modulus = 1e5, poissons_ratio = 0.3 }";

WrongInput region(const std::string& name, const std::string& to, std::vector<std::string> parts) {
  return {name, k_box, to, std::move(parts)};
}
WrongInput layout(const std::string& name, const std::string& to, std::vector<std::string> parts) {
  return {name, k_layout, to, std::move(parts)};
}
WrongInput velocity(const std::string& name, const std::string& to, std::vector<std::string> parts) {
  return {name, k_velocity, to, std::move(parts)};
}
WrongInput material(const std::string& name, const std::string& from, const std::string& to, std::vector<std::string> parts) {
  return {name, from, to, std::move(parts)};
}
std::string fluid(const std::string& values) { return "{ type = \"newtonian_fluid\", " + values + " }"; }

class WrongBody : public testing::TestWithParam<WrongInput> {};
TEST_P(WrongBody, is_refused_in_words) { expect_refused(k_case, GetParam()); }

const std::string k_another_body =
    "[[body]]\nname = \"block\"\nregion = " + k_box + "\nlayout = " + k_layout + "\nmaterial = " + k_material + "\n";

INSTANTIATE_TEST_SUITE_P(
    body, WrongBody,
    testing::Values(
        WrongInput{"no_name", "name = \"block\"\n", "", {"^case.toml:26: body 1: ", "name is missing (string): Names the body"}},
        WrongInput{"empty_name", "name = \"block\"", "name = \"\"", {"body \"\": name is empty; bodies are told apart by their names"}},
        WrongInput{"name_with_slash",
                   "name = \"block\"",
                   "name = \"a/b\"",
                   {"^case.toml:26: body \"a/b\": ", "its results cannot be named so; allowed: 1 to 100 letters, digits"}},
        WrongInput{
            "name_that_climbs", "name = \"block\"", "name = \"../block\"", {"^case.toml:26: body \"../block\": ", "cannot be named so"}},
        WrongInput{"name_with_line_break", "name = \"block\"", "name = \"a\\nb\"", {"^case.toml:26: body \"a?b\": ", "cannot be named so"}},
        WrongInput{"hidden_name", "name = \"block\"", "name = \".block\"", {"^case.toml:26: ", "cannot be named so", "not a . first"}},
        WrongInput{"name_of_the_grid",
                   "[[body]]\nname = \"block\"",
                   "grid = true\n@[[body]]\nname = \"grid\"",
                   {"body \"grid\": its files would have the names of the grid's; rename the body"}},
        WrongInput{"two_of_one_name", "", "\n@" + k_another_body, {"two bodies have the name \"block\"; give each its own"}},
        WrongInput{
            "no_region", "region = " + k_box + "\n", "", {"^case.toml:26: body \"block\": ", "region is missing (table with a type)"}},
        WrongInput{
            "no_layout", "layout = " + k_layout + "\n", "", {"^case.toml:26: body \"block\": ", "layout is missing (table with a type)"}},
        WrongInput{"no_material",
                   "material = " + k_material + "\n",
                   "",
                   {"^case.toml:26: body \"block\": ", "material is missing (table with a type, or a name)"}},
        WrongInput{
            "outside_the_grid",
            "upper = [0.75, 0.75]",
            "upper = [0.75, 1.5]",
            {"^case.toml:26: body \"block\": ", "particle ", "is outside the grid [0, 0] to [1, 1]; move the body or enlarge the grid"}},
        WrongInput{"far_outside_the_grid",
                   k_box,
                   "{ type = \"box\", lower = [1e17, 0], upper = [1.0000000000001e17, 1] }",
                   {"^case.toml:26: body \"block\": ", "its region is too far away from the grid; move it"}},
        WrongInput{"no_particle",
                   k_box,
                   "{ type = \"box\", lower = [0.26, 0.51], upper = [0.27, 0.52] }",
                   {"^case.toml:26: body \"block\": ", "no particle lies in its region; make the region larger or the layout finer"}}),
    name_of);

INSTANTIATE_TEST_SUITE_P(
    regions, WrongBody,
    testing::Values(
        region("unknown_type", "{ type = \"bxo\", lower = [0, 0] }",
               {"body \"block\": region type = \"bxo\" is unknown, allowed: \"box\", \"disk\", \"sphere\"", "did you mean \"box\"?"}),
        region("no_type", "{ lower = [0, 0], upper = [1, 1] }", {"region has no type, allowed: \"box\", "}),
        region("type_number", "{ type = 1 }", {"region type must be a string, got 1"}),
        region("not_a_table", "\"box\"", {"region must be a table { type = ... }, got \"box\""}),
        region("sphere_in_2d", "{ type = \"sphere\", center = [0.5, 0.5, 0.5], radius = 0.1 }",
               {"a sphere exists in 3D only, use type = \"disk\"; this case has dim = 2"}),
        region("box_components", "{ type = \"box\", lower = [0, 0, 0], upper = [1, 1, 1] }",
               {"region: lower = [0, 0, 0] has 3 numbers", "dim = 2"}),
        region("box_upper_below_lower", "{ type = \"box\", lower = [0.5, 0.5], upper = [0.75, 0.25] }",
               {"region: upper[1] = 0.25 must be greater than lower[1] = 0.5"}),
        region("box_no_upper", "{ type = \"box\", lower = [0, 0] }", {"region: upper is missing (dim numbers [m])"}),
        region("box_beyond_numbers", "{ type = \"box\", lower = [0, 0], upper = [1e200, 1e200] }",
               {"region: its area of inf m^2 is beyond the range of numbers; lengths are in m"}),
        region("disk_negative_radius", "{ type = \"disk\", center = [0.5, 0.5], radius = -0.1 }",
               {"region: radius = -0.1 is not allowed, it must be > 0"}),
        region("disk_zero_radius", "{ type = \"disk\", center = [0.5, 0.5], radius = 0 }",
               {"region: radius = 0 is not allowed, it must be > 0"}),
        region("disk_no_center", "{ type = \"disk\", radius = 0.1 }", {"region: center is missing (dim numbers [m])"}),
        region("unbounded", "{ type = \"half_space\", point = [0, 0.5], normal = [0, 1] }",
               {"^case.toml:26: body \"block\": ", "its region is unbounded, so it cannot be filled with particles", "\"difference\""}),
        region("half_space_no_normal", "{ type = \"half_space\", point = [0, 0], normal = [0, 0] }",
               {"region: normal = [0, 0] must not be zero, it gives the direction out of the half-space"}),
        region("polygon_two_points", "{ type = \"polygon\", vertices = [[0, 0], [1, 1]] }",
               {"region: vertices has 2 points, a polygon needs at least 3"}),
        region("polygon_on_a_line", "{ type = \"polygon\", vertices = [[0, 0], [0.5, 0.5], [1, 1]] }",
               {"region: the polygon's area is zero, its vertices lie on a line"}),
        region("polygon_crosses_itself", "{ type = \"polygon\", vertices = [[0, 0], [1, 1], [1, 0], [0, 1]] }",
               {"the polygon crosses or touches itself: the edge from vertices[0] to vertices[1] meets the edge from vertices[2] to "
                "vertices[3]"}),
        region("polygon_doubled_vertex", "{ type = \"polygon\", vertices = [[0, 0], [1, 0], [1, 0], [0, 1]] }",
               {"vertices[1] and vertices[2] are the same point [1, 0]; leave one out"}),
        region("polygon_closed_by_hand", "{ type = \"polygon\", vertices = [[0, 0], [1, 0], [0, 1], [0, 0]] }",
               {"vertices[3] and vertices[0] are the same point [0, 0]", "the last vertex is joined to the first"}),
        region("polygon_folds_back", "{ type = \"polygon\", vertices = [[0, 0], [1, 0], [0.5, 0], [0.5, 1]] }",
               {"the polygon folds back on itself at vertices[1] = [1, 0]"}),
        region("union_of_one", "{ type = \"union\", of = [" + k_box + "] }", {"region: of has 1 regions, a union needs at least 2"}),
        region("union_of_none", "{ type = \"union\", of = 3 }", {"region: of must be an array of regions, got 3 (an integer)"}),
        region("union_with_a_wrong_part", "{ type = \"union\", of = [" + k_box + ", { type = \"disc\" }] }",
               {"region: of[1] type = \"disc\" is unknown", "did you mean \"disk\"?"}),
        region("difference_of_one", "{ type = \"difference\", of = [" + k_box + "] }",
               {"region: of has 1 regions, a difference needs at least 2"}),
        region("difference_of_itself", "{ type = \"difference\", of = [" + k_box + ", " + k_box + "] }",
               {"^case.toml:26: body \"block\": ", "no particle lies in its region"})),
    name_of);

INSTANTIATE_TEST_SUITE_P(
    layouts, WrongBody,
    testing::Values(
        layout("unknown_type", "{ type = \"percell\", count = 4 }",
               {"layout type = \"percell\" is unknown, allowed: \"per_cell\", \"lattice\", \"polar\", \"points\", \"layered_disk\" or "
                "\"layered_beam\"",
                "did you mean \"per_cell\"?"}),
        layout(
            "count_not_square", "{ type = \"per_cell\", count = 5 }",
            {"layout: count = 5 is no square number, so it cannot be spread evenly; the nearest is 4, or give one number per direction"}),
        layout("count_next_to_the_largest", "{ type = \"per_cell\", count = 2147483647 }",
               {"count = 2147483647 is no square number", "2147488281"}),
        layout("count_zero", "{ type = \"per_cell\", count = 0 }", {"layout: count = 0 is not allowed, it must be >= 1"}),
        layout("count_components", "{ type = \"per_cell\", count = [2, 2, 2] }",
               {"layout: count = [2, 2, 2] has 3 numbers; give one, or one per direction (2)"}),
        layout("count_string", "{ type = \"per_cell\", count = \"4\" }", {"layout: count must be an array of integers, got \"4\""}),
        layout("per_cell_absurdly_fine", "{ type = \"per_cell\", count = [100000, 100000] }",
               {"^case.toml:26: body \"block\": ", "its layout would try ",
                " places for particles, at most 4e+09 are possible; take a coarser layout"}),
        layout("lattice_absurdly_fine", "{ type = \"lattice\", divisions = 1000000 }",
               {"^case.toml:26: body \"block\": ", "its layout would try 1e+12 places for particles"}),
        layout("lattice_points", "{ type = \"lattice\", divisions = 4, points = 3 }",
               {"layout: points = 3 is not allowed, it must be in the interval [1, 2]"}),
        layout("lattice_no_divisions", "{ type = \"lattice\" }",
               {"layout: divisions is missing (integer, or one per direction): Boxes along each side"}),
        layout("points_with_a_region", "{ type = \"points\", positions = [[0.5, 0.5]], volumes = 1 }",
               {"^case.toml:28: body \"block\": ", "layout type = \"points\" says where the particles are; leave the region out"}),
        layout("points_without_one", "{ type = \"points\", positions = [], volumes = 1 }", {"layout: positions is empty"}),
        layout("points_with_other_volumes", "{ type = \"points\", positions = [[0.5, 0.5], [0.6, 0.5], [0.7, 0.5]], volumes = [1, 2] }",
               {"layout: volumes has 2 numbers for 3 positions; give one for all, or one for each"}),
        layout("points_without_volume", "{ type = \"points\", positions = [[0.5, 0.5]], volumes = 0 }",
               {"layout: volumes = 0 is not allowed, it must be > 0"}),
        layout("polar_in_a_box", "{ type = \"polar\", rings = 3 }",
               {"^case.toml:26: body \"block\": ", "layout type = \"polar\" fills disks only; use \"lattice\" or \"per_cell\""}),
        layout("polar_sectors", "{ type = \"polar\", rings = 3, sectors = 2 }",
               {"layout: sectors = 2 is not allowed, it must be in the interval [3, 1000000]"}),
        WrongInput{"polar_absurdly_fine",
                   "region = " + k_box + "\nlayout = " + k_layout,
                   "region = { type = \"disk\", center = [0.5, 0.5], radius = 0.1 }\nlayout = { type = \"polar\", rings = 100000 }",
                   {"^case.toml:26: body \"block\": ", "its layout would try 3.14e+10 places for particles"}}),
    name_of);

INSTANTIATE_TEST_SUITE_P(
    velocities, WrongBody,
    testing::Values(
        velocity("unknown_type", "{ type = \"unifrom\", value = [0, 0] }",
                 {"velocity type = \"unifrom\" is unknown, allowed: \"uniform\", \"linear\", \"rotating\" or \"sine\"",
                  "did you mean \"uniform\"?"}),
        velocity("plain_word", "\"fast\"", {"velocity must be a table { type = ... }, got \"fast\""}),
        velocity("plain_vector_of_another_dimension", "[1, 0, 0]", {"velocity: value = [1, 0, 0] has 3 numbers", "it must have 2"}),
        velocity("uniform_components", "{ type = \"uniform\", value = [0, 0, 1] }", {"velocity: value = [0, 0, 1] has 3 numbers"}),
        velocity("linear_rows", "{ type = \"linear\", gradient = [[1, 0]] }",
                 {"velocity: gradient has 1 rows; the case has dim = 2, so it must have 2"}),
        velocity("linear_columns", "{ type = \"linear\", gradient = [[1, 0], [1]] }", {"velocity: gradient[1] = [1] has 1 numbers"}),
        velocity("rotating_vector_in_2d", "{ type = \"rotating\", center = [0, 0], angular_velocity = [0, 0, 1] }",
                 {"velocity: angular_velocity must be a number, got [0, 0, 1]"}),
        velocity("rotating_no_center", "{ type = \"rotating\", angular_velocity = 1 }", {"velocity: center is missing (dim numbers [m])"})),
    name_of);

INSTANTIATE_TEST_SUITE_P(
    materials, WrongBody,
    testing::Values(
        material("unknown_type", "neo_hookean", "neohookean",
                 {"material type = \"neohookean\" is unknown, allowed: ", "did you mean \"neo_hookean\"?"}),
        material("density_zero", "density = 1000", "density = 0", {"body \"block\": material: density = 0 is not allowed, it must be > 0"}),
        material("density_negative", "density = 1000", "density = -1000", {"material: density = -1000 is not allowed, it must be > 0"}),
        material("density_nan", "density = 1000", "density = nan", {"material: density = nan is not a finite number"}),
        material("density_infinite", "density = 1000", "density = inf", {"material: density = inf is not a finite number"}),
        material("density_missing", "density = 1000, ", "", {"material: density is missing (number [kg/m^3]): Mass per reference volume."}),
        material("incompressible", "poissons_ratio = 0.3", "poissons_ratio = 0.5",
                 {"material: poissons_ratio = 0.5 is not allowed, it must be in the open interval (-1, 0.5)"}),
        material("poissons_ratio_minus_one", "poissons_ratio = 0.3", "poissons_ratio = -1", {"poissons_ratio = -1 is not allowed"}),
        material("modulus_negative", "youngs_modulus = 1e5", "youngs_modulus = -1e5",
                 {"material: youngs_modulus = -100000 is not allowed, it must be > 0"}),
        material("letter_for_a_name", "youngs_modulus = 1e5", "E = 1e5",
                 {"material: unknown key \"E\"", "known keys: \"type\", \"density\""}),
        material("fluid_scale", k_material, fluid("density = 1000, pressure_scale = 0"),
                 {"material: pressure_scale = 0 is not allowed, it must be > 0"}),
        material("fluid_viscosity", k_material, fluid("density = 1000, pressure_scale = 1e4, viscosity = -1"),
                 {"material: viscosity = -1 is not allowed, it must be >= 0"}),
        material("fluid_gamma", k_material, fluid("density = 1000, pressure_scale = 1e4, gamma = 0.5"),
                 {"material: gamma = 0.5 is not allowed, it must be in the interval [1, 50]"}),
        material("fluid_with_a_modulus", k_material, fluid("density = 1000, youngs_modulus = 1e4"),
                 {"material: unknown key \"youngs_modulus\""})),
    name_of);

class WrongBody3d : public testing::TestWithParam<WrongInput> {};
TEST_P(WrongBody3d, is_refused_in_words) { expect_refused(k_case_3d, GetParam()); }

const std::string k_box_3d = "{ type = \"box\", lower = [0.25, 0.25, 0.5], upper = [0.75, 0.75, 0.75] }";

INSTANTIATE_TEST_SUITE_P(
    body, WrongBody3d,
    testing::Values(
        WrongInput{"disk",
                   k_box_3d,
                   "{ type = \"disk\", center = [0.5, 0.5], radius = 0.1 }",
                   {"a disk exists in 2D only, use type = \"sphere\"; this case has dim = 3"}},
        WrongInput{
            "polygon", k_box_3d, "{ type = \"polygon\", vertices = [[0, 0], [1, 0], [0, 1]] }", {"a polygon exists in 2D only", "dim = 3"}},
        WrongInput{"box_components",
                   k_box_3d,
                   "{ type = \"box\", lower = [0, 0], upper = [1, 1] }",
                   {"region: lower = [0, 0] has 2 numbers; the case has dim = 3, so it must have 3"}},
        WrongInput{"count_not_a_cube", "count = 8", "count = 9", {"layout: count = 9 is no cube number", "the nearest is 8"}},
        WrongInput{"polar",
                   "{ type = \"per_cell\", count = 8 }",
                   "{ type = \"polar\", rings = 2 }",
                   {"^case.toml:10: body \"block\": ", "layout type = \"polar\" fills disks only"}},
        WrongInput{"rotating_number",
                   "name = \"block\"",
                   "name = \"block\"\n@velocity = { type = \"rotating\", center = [0, 0, 0], angular_velocity = 1 }",
                   {"velocity: angular_velocity must be an array of 3 numbers, got 1"}},
        WrongInput{"grid_components", "cells = [4, 4, 4]", "cells = [4, 4]", {"cells = [4, 4] has 2 numbers; the case has dim = 3"}},
        WrongInput{"periodic",
                   "cells = [4, 4, 4]",
                   "cells = [4, 4, 4]\n@periodic = [\"w\"]",
                   {"periodic: \"w\" is unknown, allowed: \"x\", \"y\" or \"z\""}}),
    name_of);

TEST(WrongCase, more_particles_than_memory_are_refused_at_once) {
  if (static_cast<Real>(sysconf(_SC_PHYS_PAGES)) * static_cast<Real>(sysconf(_SC_PAGESIZE)) > 3e11) GTEST_SKIP() << "they might fit";
  std::string text = k_case;
  text.replace(text.find(k_layout), k_layout.size(), "{ type = \"lattice\", divisions = [50000, 70000] }");
  EXPECT_THAT(refusal(text), testing::AllOf(testing::StartsWith("case.toml:26: body \"block\": its layout makes about 3.5e+09 particles"),
                                            testing::HasSubstr("do not fit into this machine's memory of ")));
}

TEST(WrongCase, without_a_body_is_refused_with_what_one_needs) {
  const std::string head = "[grid]\nupper = [1, 1]\ncells = [2, 2]\n[time]\nend = 1\n";
  EXPECT_EQ(refusal(head), "case.toml: body is missing (array of tables): A body of particles.");
  EXPECT_EQ(refusal("body = []\n" + head), "the case has no body; add [[body]] with name, region, layout and material");
}

}  // namespace
}  // namespace matpoint::test
