// Wrong [[boundary]] and [[probe]] entries.
#include "case/wrong_input.hpp"

namespace matpoint::test {
namespace {

class WrongBoundary : public testing::TestWithParam<WrongInput> {};
TEST_P(WrongBoundary, is_refused_in_words) { expect_refused(k_case, GetParam()); }

const std::string k_side = "side = \"bottom\"\nkind = \"slip\"";
const std::string k_at = "^case.toml:33: boundary 1: ";
const std::string k_disk = "{ type = \"disk\", center = [0.5, 0.1], radius = 0.2 }";
const std::string k_union = "{ type = \"union\", of = [" + k_disk + ", " + k_disk + "] }";

WrongInput boundary(const std::string& name, const std::string& to, std::vector<std::string> parts) {
  return {name, k_side, to, std::move(parts)};
}

INSTANTIATE_TEST_SUITE_P(
    boundary, WrongBoundary,
    testing::Values(
        boundary("neither_side_nor_region", "kind = \"slip\"",
                 {k_at, "side is missing: give side = one of \"left\", \"right\", \"bottom\" or \"top\", or region = { type = ... }"}),
        boundary("side_and_region", "side = \"bottom\"\nregion = " + k_disk, {k_at, "side and region are both given; give one of them"}),
        boundary("unknown_side", "side = \"botom\"",
                 {"boundary 1: side: \"botom\" is unknown, allowed: \"left\"", "did you mean \"bottom\"?"}),
        boundary("side_of_3d", "side = \"front\"",
                 {"boundary 1: side: \"front\" is unknown, allowed: \"left\", \"right\", \"bottom\" or \"top\""}),
        boundary("side_number", "side = 1", {"boundary 1: side must be a string, got 1"}),
        boundary("unknown_kind", "side = \"bottom\"\n@kind = \"fix\"",
                 {"boundary 1: kind = \"fix\" is unknown, allowed: \"fixed\", \"slip\", \"velocity\" or \"traction\"",
                  "did you mean \"fixed\"?"}),
        boundary("unknown_component", "side = \"bottom\"\nkind = \"fixed\"\n@components = [\"X1\"]",
                 {"components: \"X1\" is unknown, allowed: \"x\" or \"y\""}),
        boundary("component_of_3d", "side = \"bottom\"\nkind = \"fixed\"\n@components = [\"z\"]",
                 {"components: \"z\" is unknown, allowed: \"x\" or \"y\""}),
        boundary("no_component", "side = \"bottom\"\nkind = \"fixed\"\n@components = []",
                 {"components = [] holds nothing; leave it out to hold all"}),
        boundary("slip_with_components", "side = \"bottom\"\nkind = \"slip\"\n@components = [\"x\"]",
                 {"kind = \"slip\" fixes the direction normal to the side or region and takes no components; use kind = \"fixed\""}),
        boundary("friction_of_slip", "side = \"bottom\"\nkind = \"slip\"\n@contact = \"friction\"\nfriction = 0.1",
                 {"contact = \"friction\" is for kind = \"fixed\" or \"velocity\""}),
        boundary("friction_without_coefficient", "side = \"bottom\"\nkind = \"fixed\"\n@contact = \"friction\"",
                 {"contact = \"friction\" needs friction, Coulomb's coefficient"}),
        boundary("friction_without_contact", "side = \"bottom\"\nkind = \"fixed\"\n@friction = 0.1",
                 {"friction is for contact = \"friction\" only"}),
        boundary("negative_friction", "side = \"bottom\"\nkind = \"fixed\"\ncontact = \"friction\"\n@friction = -0.1",
                 {"friction = -0.1 is not allowed, it must be >= 0"}),
        boundary("contact_unknown", "side = \"bottom\"\nkind = \"fixed\"\n@contact = \"frition\"",
                 {"contact = \"frition\" is unknown, allowed: \"stick\", \"no_tension\" or \"friction\"", "did you mean \"friction\"?"}),
        boundary("contact_of_components", "side = \"bottom\"\nkind = \"fixed\"\ncomponents = [\"x\"]\n@contact = \"no_tension\"",
                 {"contact = \"no_tension\" needs all components"}),
        boundary("contact_on_a_union", "kind = \"fixed\"\n@contact = \"no_tension\"\nregion = " + k_union,
                 {"contact = \"no_tension\" needs a region with one surface"}),
        boundary("slip_on_a_union", "region = " + k_union,
                 {"kind = \"slip\" needs a region with one surface", "give each part its own boundary"}),
        boundary("region_of_3d", "region = { type = \"sphere\", center = [0, 0, 0], radius = 1 }",
                 {"boundary 1: region: a sphere exists in 3D only"}),
        boundary("region_without_nodes", "region = { type = \"disk\", center = [0.125, 0.03], radius = 0.01 }\nkind = \"fixed\"",
                 {k_at, "its region contains no node of the grid, so it would do nothing; make it at least a cell wide"}),
        boundary(
            "velocity_without_value", "side = \"bottom\"\nkind = \"velocity\"",
            {k_at,
             "kind = \"velocity\" needs velocity = [...] or { type = ... }, with times = [...] and factors = [...] where it changes in "
             "time, or a table: times = [...] with velocities = [[...], ...]"}),
        boundary("velocity_and_table", "side = \"bottom\"\nkind = \"velocity\"\nvelocity = [0, 1]\ntimes = [0]\nvelocities = [[0, 0]]",
                 {k_at, "needs velocity = [...] or { type = ... }"}),
        boundary("velocity_factors_and_table",
                 "side = \"bottom\"\nkind = \"velocity\"\nvelocity = [0, 1]\ntimes = [0]\nvelocities = [[0, 0]]\nfactors = [1]",
                 {k_at, "needs velocity = [...] or { type = ... }"}),
        boundary("factors_alone", "side = \"bottom\"\nkind = \"velocity\"\ntimes = [0]\nfactors = [1]",
                 {k_at, "needs velocity = [...] or { type = ... }"}),
        boundary("factors_without_times", "side = \"bottom\"\nkind = \"velocity\"\nvelocity = [0, 1]\nfactors = [1]",
                 {k_at, "with times = [...] and factors = [...]"}),
        boundary("factors_lengths", "side = \"bottom\"\nkind = \"velocity\"\nvelocity = [0, 1]\ntimes = [0, 1]\n@factors = [1]",
                 {"times has 2 entries and factors 1; they must match"}),
        boundary("factors_for_fixed", "side = \"bottom\"\nkind = \"fixed\"\n@factors = [0]", {"factors is for kind = \"velocity\" only"}),
        boundary("velocity_type", "side = \"bottom\"\nkind = \"velocity\"\n@velocity = { type = \"rotatin\", center = [0, 0] }",
                 {"velocity type = \"rotatin\" is unknown", "did you mean \"rotating\"?"}),
        boundary("times_alone", "side = \"bottom\"\nkind = \"velocity\"\ntimes = [0, 1]",
                 {k_at, "times = [...] with velocities = [[...], ...]"}),
        boundary("velocities_alone", "side = \"bottom\"\nkind = \"velocity\"\nvelocities = [[0, 0]]",
                 {k_at, "times = [...] with velocities"}),
        boundary("velocity_components", "side = \"bottom\"\nkind = \"velocity\"\n@velocity = [1]",
                 {"velocity has 1 numbers; the case has dim = 2, so it must have 2"}),
        boundary("velocities_components", "side = \"bottom\"\nkind = \"velocity\"\ntimes = [0]\n@velocities = [[1, 2, 3]]",
                 {"velocities[0] = [1, 2, 3] has 3 numbers"}),
        boundary("table_lengths", "side = \"bottom\"\nkind = \"velocity\"\ntimes = [0, 1]\n@velocities = [[0, 0]]",
                 {"times has 2 entries and velocities 1; they must match"}),
        boundary("unsorted_times", "side = \"bottom\"\nkind = \"velocity\"\n@times = [0, 2, 1]\nvelocities = [[0, 0], [0, 0], [0, 0]]",
                 {"times[2] = 1 must be greater than times[1] = 2"}),
        boundary("doubled_times", "side = \"bottom\"\nkind = \"velocity\"\n@times = [0, 0]\nvelocities = [[0, 0], [0, 0]]",
                 {"times[1] = 0 must be greater than times[0] = 0"}),
        boundary("velocity_for_slip", "side = \"bottom\"\nkind = \"slip\"\n@velocity = [0, 0]",
                 {"velocity is for kind = \"velocity\" only"}),
        boundary("velocity_without_a_kind", "side = \"bottom\"\n@velocity = [0, 0]", {"velocity is for kind = \"velocity\" only"}),
        boundary("times_for_fixed", "side = \"bottom\"\nkind = \"fixed\"\n@times = [0]", {"times is for kind = \"velocity\" only"}),
        WrongInput{"periodic_side",
                   "periodic = []",
                   "periodic = [\"y\"]",
                   {"^case.toml:33: boundary 1: ", "side = \"bottom\" is periodic (grid.periodic has \"y\"), so it has no boundary"}}),
    name_of);

const std::string k_probe = "name = \"tip\"\nbody = \"block\"\nparticle = 0";
WrongInput probe(const std::string& name, const std::string& to, std::vector<std::string> parts) {
  return {name, k_probe, to, std::move(parts)};
}

INSTANTIATE_TEST_SUITE_P(
    probe, WrongBoundary,
    testing::Values(
        probe("no_name", "body = \"block\"\nparticle = 0", {"^case.toml:37: probe 1: ", "name is missing (string)"}),
        probe("no_body", "name = \"tip\"\nparticle = 0",
              {"^case.toml:37: probe \"tip\": ", "body is missing (string): The particle's body."}),
        probe("unknown_body", "name = \"tip\"\nbody = \"blok\"\nparticle = 0",
              {"^case.toml:37: probe \"tip\": ", "body = \"blok\" is unknown, allowed: \"block\"", "did you mean \"block\"?"}),
        probe("unknown_particle", "name = \"tip\"\nbody = \"block\"\nparticle = 32",
              {"^case.toml:37: probe \"tip\": ", "particle = 32 does not exist, body \"block\" has particles 0 to 31"}),
        probe("negative_particle", "name = \"tip\"\nbody = \"block\"\n@particle = -1", {"particle = -1 is not allowed, it must be >= 0"}),
        probe("particle_and_nearest", "name = \"tip\"\nbody = \"block\"\nparticle = 0\nnearest = [0, 0]",
              {"^case.toml:37: probe \"tip\": ", "particle and nearest are both given; give one of them"}),
        probe("neither_particle_nor_nearest", "name = \"tip\"\nbody = \"block\"",
              {"^case.toml:37: probe \"tip\": ", "which particle? Give particle = its id, or nearest = [x, y] of a point"}),
        probe("nearest_components", "name = \"tip\"\nbody = \"block\"\n@nearest = [1]",
              {"nearest = [1] has 1 numbers; the case has dim = 2"}),
        probe("name_with_slash", "name = \"a/b\"\nbody = \"block\"\nparticle = 0",
              {"^case.toml:37: probe \"a/b\": ", "its results cannot be named so"}),
        WrongInput{"two_probes_of_a_name", "", "\n@[[probe]]\n" + k_probe + "\n", {"two probes have the name \"tip\"; give each its own"}}),
    name_of);

}  // namespace
}  // namespace matpoint::test
