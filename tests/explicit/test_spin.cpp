// The frame that turns with a body: a free body that turns goes on turning.
#include "case/case_file.hpp"
#include "run/simulation.hpp"
#include "support/solver_case.hpp"

namespace matpoint::test {
namespace {

struct Turning {
  const char* name;
  int dim;
  const char* shape;
  const char* precision;
};

std::string text_of(const Turning& one, const std::string& solver) {
  const bool is_3d = one.dim == 3;
  return fmt::format(R"(
dim = {}
[grid]
lower = [{}]
upper = [{}]
cell_size = 0.1
[time]
end = 2
[solver]
shape = "{}"
precision = "{}"
{}
[[body]]
name = "bar"
region = {{ type = "box", lower = [{}], upper = [{}] }}
layout = {{ type = "per_cell", count = {} }}
velocity = {{ type = "rotating", center = [{}], {} }}
material = {{ type = "neo_hookean", density = 1000, youngs_modulus = 1e6, poissons_ratio = 0.3 }}
)",
                     one.dim, is_3d ? "0, 0, 0" : "0, 0", is_3d ? "1.2, 1.2, 1.2" : "1.2, 1.2", one.shape, one.precision, solver,
                     is_3d ? "0.3, 0.4, 0.4" : "0.3, 0.4", is_3d ? "0.9, 0.8, 0.8" : "0.9, 0.8", is_3d ? 8 : 4,
                     is_3d ? "0.6, 0.6, 0.6" : "0.6, 0.6", is_3d ? "angular_velocity = [1, 2, 4]" : "angular_velocity = 6.283");
}

/// About the center of the bar [N m s].
Vec3 angular_momentum(const Simulation& sim, int dim) {
  const std::vector<Real> x = sim.solver().field(0, "position").values, v = sim.solver().field(0, "velocity").values,
                          m = sim.solver().field(0, "mass").values;
  Vec3 sum{};
  for (std::size_t p = 0; p < m.size(); ++p) {
    Vec3 r{}, u{};
    for (std::size_t d = 0; d < static_cast<std::size_t>(dim); ++d) {
      r[d] = x[p * static_cast<std::size_t>(dim) + d] - 0.6;
      u[d] = v[p * static_cast<std::size_t>(dim) + d];
    }
    const Vec3 turn = cross(r, u);
    for (std::size_t d = 0; d < 3; ++d) sum[d] += m[p] * turn[d];
  }
  return sum;
}

Real relative_change(const Turning& one, const std::string& solver) {
  Simulation sim(Case::from_input(parse_toml(text_of(one, solver), "bar"), "bar"));
  const Vec3 start = angular_momentum(sim, one.dim);
  sim.run();
  Vec3 change = angular_momentum(sim, one.dim);
  for (std::size_t d = 0; d < 3; ++d) change[d] -= start[d];
  return std::sqrt(dot(change, change) / dot(start, start));
}

class Spin : public testing::TestWithParam<Turning> {};

TEST_P(Spin, goes_on_with_the_frame_and_not_without) {
  const Real with = relative_change(GetParam(), "");
  EXPECT_LT(with, GetParam().dim == 2 ? 0.01 : 0.02);
  EXPECT_GT(relative_change(GetParam(), "co_rotating = false"), 4 * with);
}

INSTANTIATE_TEST_SUITE_P(All, Spin,
                         testing::Values(Turning{"gimp_2d", 2, "gimp", "double"}, Turning{"bspline2_2d", 2, "bspline2", "double"},
                                         Turning{"cpdi_2d", 2, "cpdi", "double"}, Turning{"gimp_2d_single", 2, "gimp", "single"},
                                         Turning{"gimp_3d", 3, "gimp", "double"}),
                         [](const auto& info) { return info.param.name; });

/// One particle of mass has no inertia, and a row of them none about itself.
TEST(SpinOf, a_particle_or_a_row_of_them_stays_finite) {
  for (const auto& [upper, divisions] : {std::pair("0.65, 0.65, 0.65", "[1, 1, 1]"), std::pair("0.9, 0.65, 0.65", "[6, 1, 1]")}) {
    Simulation sim(Case::from_input(parse_toml(fmt::format(R"(
dim = 3
[grid]
upper = [1, 1, 1]
cell_size = 0.1
[time]
end = 0.02
[[body]]
name = "few"
region = {{ type = "box", lower = [0.6, 0.6, 0.6], upper = [{}] }}
layout = {{ type = "lattice", divisions = {} }}
velocity = {{ type = "rotating", center = [0.6, 0.6, 0.6], angular_velocity = [3, 2, 1] }}
material = {{ type = "neo_hookean", density = 1000, youngs_modulus = 1e5, poissons_ratio = 0.3 }}
)",
                                                           upper, divisions),
                                               "few"),
                                    "few"));
    const Vec3 start = sim.solver().totals(0).momentum;
    sim.run();
    const Vec3 end = sim.solver().totals(0).momentum;
    for (std::size_t d = 0; d < 3; ++d) EXPECT_NEAR(end[d], start[d], 1e-12 * std::sqrt(dot(start, start))) << upper;
  }
}

/// A stiff slab on a side that holds it, or two that stick to each other, set vibrating.
std::string vibrating(bool is_glued, const std::string& solver) {
  const auto body = [](const char* name, const char* lower, const char* upper, const char* velocity) {
    return fmt::format(R"([[body]]
name = "{}"
region = {{ type = "box", lower = {}, upper = {} }}
layout = {{ type = "per_cell", count = 4 }}
velocity = {{ type = "uniform", value = {} }}
material = {{ type = "neo_hookean", density = 1000, youngs_modulus = 1e8, poissons_ratio = 0.3 }}
)",
                       name, lower, upper, velocity);
  };
  const std::string top = "[grid]\nupper = [2, 1]\ncell_size = 0.1\n[time]\nend = 0.4\n[solver]\n" + solver + "\n";
  if (is_glued) return top + body("a", "[0.6, 0.3]", "[0.9, 0.7]", "[0, 0.3]") + body("b", "[0.9, 0.3]", "[1.3, 0.7]", "[0, -0.3]");
  return top + body("slab", "[0, 0.3]", "[0.2, 0.7]", "[0, 0.5]") + "[[boundary]]\nside = \"left\"\nkind = \"fixed\"\n";
}

TEST(SpinOf, what_is_held_vibrates_as_without_a_frame) {
  for (const bool is_glued : {false, true}) {
    for (const char* shape : {"gimp", "bspline2"}) {
      Real greatest[2] = {};
      for (const bool is_on : {false, true}) {
        const std::string solver = fmt::format("shape = \"{}\"\nco_rotating = {}", shape, is_on);
        Simulation sim(Case::from_input(parse_toml(vibrating(is_glued, solver), "slab"), "slab"));
        Real start = 0;
        sim.add_callback([&](const Simulation& now) {
          Real energy = 0;
          for (std::size_t b = 0; b < now.solver().body_count(); ++b)
            energy += now.solver().totals(b).kinetic_energy + now.solver().totals(b).strain_energy;
          if (start == 0) start = energy;
          greatest[is_on ? 1 : 0] = std::max(greatest[is_on ? 1 : 0], energy / start);
          return true;
        });
        sim.run();
      }
      EXPECT_LT(greatest[0], 1.1) << shape;
      EXPECT_NEAR(greatest[1], greatest[0], 1e-9) << shape << (is_glued ? ", glued" : ", clamped");
    }
  }
}

TEST(SpinOf, an_affine_transfer_is_refused) {
  const Turning one{"", 2, "gimp", "double"};
  EXPECT_THROW(Case::from_input(parse_toml(text_of(one, "co_rotating = true\ntransfer = \"apic\""), "bar"), "bar"), InputError);
}

}  // namespace
}  // namespace matpoint::test
