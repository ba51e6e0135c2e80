// A slip side is a plane of symmetry for every contact method: a half, or a quarter, moves as the whole.
#include "case/case_file.hpp"
#include "run/simulation.hpp"
#include "support/solver_case.hpp"

namespace matpoint::test {
namespace {

/// Momenta of the first body over that at the start, in steps.
std::vector<Real> momenta(int dim, const std::string& contact, Real friction, bool is_part, bool is_mirrored) {
  const bool is_3d = dim == 3;
  const auto region = [&](Real x, Real radius) {
    const char* const ball = is_3d ? "sphere" : "disk";
    const char* const rest = is_3d ? ", 0, 0" : ", 0";
    std::string text = fmt::format("{{ type = \"{}\", center = [{}{}], radius = {} }}", ball, x, rest, radius);
    // Always a difference, so that particles have one volume in both.
    const char* const sign = is_mirrored ? "-" : "";
    if (!is_part)
      return fmt::format("{{ type = \"difference\", of = [{}, {{ type = \"{}\", center = [9, 9{}], radius = 1 }}] }}", text, ball,
                         is_3d ? ", 9" : "");
    std::string cuts = fmt::format(", {{ type = \"half_space\", point = [0{}], normal = [0, {}1{}] }}", rest, sign, is_3d ? ", 0" : "");
    if (is_3d) cuts += fmt::format(", {{ type = \"half_space\", point = [0, 0, 0], normal = [0, 0, {}1] }}", sign);
    return fmt::format("{{ type = \"difference\", of = [{}{}] }}", text, cuts);
  };
  const Real lower = is_part && !is_mirrored ? 0 : -0.3, upper = is_part && is_mirrored ? 0 : 0.3;
  std::string text = fmt::format(R"(
dim = {}
[grid]
lower = [0, {}]
upper = [1, {}]
cell_size = {}
[time]
dt = 4e-4
end = 0.2
[solver]
shape = "linear"
contact = "{}"
{}
)",
                                 dim, is_3d ? fmt::format("{}, {}", lower, lower) : fmt::format("{}", lower),
                                 is_3d ? fmt::format("{}, {}", upper, upper) : fmt::format("{}", upper), is_3d ? 0.1 : 0.05, contact,
                                 friction > 0 ? fmt::format("friction = {}", friction) : "");
  for (const auto& [name, x, radius, v] : {std::tuple("a", 0.3, 0.2, 0.5), std::tuple("b", 0.74, 0.21, -0.5)}) {
    text += fmt::format(R"([[body]]
name = "{}"
region = {}
layout = {{ type = "per_cell", count = {} }}
velocity = {{ type = "uniform", value = [{}, 0{}] }}
material = {{ type = "neo_hookean", density = 1000, youngs_modulus = 1e4, poissons_ratio = 0.3 }}
)",
                        name, region(x, radius), is_3d ? 8 : 4, v, is_3d ? ", 0" : "");
  }
  if (is_part) {
    text += fmt::format("[[boundary]]\nside = \"{}\"\nkind = \"slip\"\n", is_mirrored ? "top" : "bottom");
    if (is_3d) text += fmt::format("[[boundary]]\nside = \"{}\"\nkind = \"slip\"\n", is_mirrored ? "back" : "front");
    // In 2D top and bottom are the sides across y; in 3D those across y are bottom and top, too, and front and back across z.
  }
  Simulation sim(Case::from_input(parse_toml(text, "half"), "half"));
  const Real start = sim.solver().totals(0).momentum[0];
  std::vector<Real> all;
  sim.add_callback([&](const Simulation& now) {
    all.push_back(now.solver().totals(0).momentum[0] / start);
    return true;
  });
  sim.run();
  return all;
}

TEST(HalfModels, move_as_the_whole_with_every_contact_method) {
  for (const int dim : {2, 3}) {
    for (const char* contact : {"single_field", "multi_field", "pairs"}) {
      for (const Real friction : {0.0, 0.3}) {
        if (std::string(contact) == "single_field" && friction > 0) continue;
        const std::vector<Real> whole = momenta(dim, contact, friction, false, false);
        for (const bool is_mirrored : {false, true}) {
          const std::vector<Real> part = momenta(dim, contact, friction, true, is_mirrored);
          ASSERT_EQ(part.size(), whole.size());
          Real greatest = 0;
          for (std::size_t k = 0; k < part.size(); ++k) greatest = std::max(greatest, std::abs(part[k] - whole[k]));
          EXPECT_LE(greatest, std::string(contact) == "pairs" ? 1e-6 : 1e-9) << dim << contact << friction << is_mirrored;
        }
        EXPECT_LT(whole.back(), 0.9) << "they should have met";
      }
    }
  }
}

}  // namespace
}  // namespace matpoint::test
