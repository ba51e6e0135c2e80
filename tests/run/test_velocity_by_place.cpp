// Velocities that a boundary prescribes by place: rotating, stretching ones, in both solvers.
#include <cmath>

#include "support/solver_case.hpp"

namespace matpoint::test {
namespace {

/// A block in the middle of a grid around the origin.
std::string block(int dim, const std::string& solver, const std::string& boundary, const std::string& time = "end = 0.5\ndt = 0.01") {
  const bool is_3d = dim == 3;
  return fmt::format(R"(
dim = {}
[grid]
lower = {}
upper = {}
cells = {}
[time]
{}
[solver]
{}
[[body]]
name = "block"
region = {{ type = "box", lower = {}, upper = {} }}
layout = {{ type = "per_cell", count = {} }}
material = {{ type = "neo_hookean", density = 1000, youngs_modulus = 1e4, poissons_ratio = 0.3 }}
[[boundary]]
name = "held"
kind = "velocity"
{}
)",
                     dim, is_3d ? "[-1, -1, -1]" : "[-1, -1]", is_3d ? "[1, 1, 1]" : "[1, 1]", is_3d ? "[8, 8, 8]" : "[16, 16]", time,
                     solver, is_3d ? "[-0.25, -0.5, -0.25]" : "[-0.25, -0.5]", is_3d ? "[0.25, 0.5, 0.25]" : "[0.25, 0.5]", is_3d ? 8 : 4,
                     boundary);
}
std::string everywhere(int dim) {
  return dim == 3 ? "region = { type = \"box\", lower = [-1, -1, -1], upper = [1, 1, 1] }\n"
                  : "region = { type = \"box\", lower = [-1, -1], upper = [1, 1] }\n";
}

/// Greatest distance of particles from where a turn by `angle` about `axis` through `center` takes them [m].
Real stray(const Simulation& sim, const std::vector<Real>& start, const Vec3& axis, const Vec3& center, Real angle) {
  const auto dim = static_cast<std::size_t>(sim.solver().dim());
  const std::vector<Real> now = sim.solver().field(0, "position").values;
  Real greatest = 0;
  for (std::size_t p = 0; p < now.size(); p += dim) {
    Vec3 r{};
    for (std::size_t d = 0; d < dim; ++d) r[d] = start[p + d] - center[d];
    const Vec3 across = cross(axis, r);
    const Real along = dot(axis, r);
    for (std::size_t d = 0; d < dim; ++d) {
      const Real turned = r[d] * std::cos(angle) + across[d] * std::sin(angle) + axis[d] * along * (1 - std::cos(angle));
      greatest = std::max(greatest, std::abs(now[p + d] - center[d] - turned));
    }
  }
  return greatest;
}

const std::string k_turning = "velocity = { type = \"rotating\", center = [0.1, 0], angular_velocity = 0.8 }";
const std::string k_turning_3d = "velocity = { type = \"rotating\", center = [0.1, 0, 0], angular_velocity = [0.48, 0, 0.64] }";

TEST(VelocityByPlace, a_body_that_it_holds_turns_rigidly) {
  for (const int dim : {2, 3}) {
    for (const char* order : {"usl", "usf", "musl"}) {
      Simulation sim(read(block(dim, fmt::format("stress_order = \"{}\"\nshape = \"gimp\"\ntransfer = \"flip\"", order),
                                everywhere(dim) + (dim == 3 ? k_turning_3d : k_turning), "end = 0.5\ndt = 0.001"),
                          {fmt::format("body.block.velocity={}", dim == 3 ? k_turning_3d.substr(11) : k_turning.substr(11))}));
      const std::vector<Real> start = sim.solver().field(0, "position").values;
      sim.run();
      const Vec3 axis = dim == 3 ? Vec3{0.6, 0, 0.8} : Vec3{0, 0, 1};
      // Along tangents of w dt a particle goes outwards by (w dt)^2/2 of its distance in each of 500 steps: 1.6e-4, and 3.2e-4 of the area.
      EXPECT_LT(stray(sim, start, axis, {0.1, 0, 0}, 0.4), 3e-4) << dim << order;
      EXPECT_GT(stray(sim, start, axis, {0.1, 0, 0}, 0), 0.15) << "it has turned";
      for (const Real J : sim.solver().field(0, "J").values) EXPECT_NEAR(J, 1, 1e-3);
      EXPECT_LT(momentum_remainder(sim), 500 * 100 * k_epsilon * 500);
    }
  }
}

TEST(VelocityByPlace, in_the_implicit_solver_a_turn_is_exact_and_makes_no_stress) {
  for (const int dim : {2, 3}) {
    for (const char* body : {"particles", "elements"}) {
      for (const char* mode : {"static", "dynamic"}) {
        std::vector<std::string> sets = {"time.end=1.25", "time.dt=0.125"};  // a radian
        std::string text = block(dim, fmt::format("type = \"implicit\"\nmode = \"{}\"\nbasis = \"element\"\nelement_order = 1", mode),
                                 everywhere(dim) + (dim == 3 ? k_turning_3d : k_turning));
        if (std::string(body) == "elements") {
          const auto layout = text.find("layout");
          text.replace(layout, text.find('\n', layout) - layout, "method = \"elements\"");
        }
        Simulation sim(read(text, sets));
        const bool is_elements = std::string(body) == "elements";
        const auto positions = [&] {
          return (is_elements ? sim.solver().node_field(0, "position") : sim.solver().field(0, "position")).values;
        };
        const std::vector<Real> start = positions();
        sim.run();
        const std::vector<Real> now = positions();
        const Vec3 axis = dim == 3 ? Vec3{0.6, 0, 0.8} : Vec3{0, 0, 1};
        Real greatest = 0;
        const auto n = static_cast<std::size_t>(dim);
        for (std::size_t p = 0; p < now.size(); p += n) {
          Vec3 r{}, x{};
          for (std::size_t d = 0; d < n; ++d) {
            r[d] = start[p + d] - (d == 0 ? 0.1 : 0);
            x[d] = now[p + d] - (d == 0 ? 0.1 : 0);
          }
          const Vec3 across = cross(axis, r);
          for (std::size_t d = 0; d < n; ++d) {
            const Real turned = r[d] * std::cos(1.0) + across[d] * std::sin(1.0) + axis[d] * dot(axis, r) * (1 - std::cos(1.0));
            greatest = std::max(greatest, std::abs(x[d] - turned));
          }
        }
        EXPECT_LT(greatest, 1e-8) << dim << body << mode;
        for (const Real stress : sim.solver().field(0, "stress").values) EXPECT_NEAR(stress, 0, 1e-5 * 1e4) << dim << body << mode;
      }
    }
  }
}

TEST(VelocityByPlace, the_same_everywhere_is_a_plain_one_to_the_last_bit) {
  const std::string half = "region = { type = \"box\", lower = [-1, -1], upper = [1, 0] }\n";
  for (const char* solver : {"shape = \"gimp\"", "shape = \"linear\"\ntransfer = \"flip\"\nprecision = \"single\"",
                             "type = \"implicit\"\nbasis = \"element\"\nelement_order = 1"}) {
    const auto end = [&](const std::string& velocity) {
      Simulation sim(read(block(2, solver, half + velocity, "end = 0.05\ndt = 0.005")));
      sim.run();
      return sim.solver().field(0, "position").values;
    };
    const std::vector<Real> plain = end("velocity = [0.3, -0.1]\n");
    if (std::string(solver).find("implicit") == std::string::npos) {
      EXPECT_EQ(end("velocity = { type = \"uniform\", value = [0.3, -0.1] }\n"), plain) << solver;
    }
    const std::vector<Real> by_place = end("velocity = { type = \"linear\", value = [0.3, -0.1], gradient = [[0, 0], [0, 0]] }\n");
    const std::vector<Real> by_factors = end("velocity = [0.15, -0.05]\ntimes = [0, 1]\nfactors = [2, 2]\n");
    for (std::size_t k = 0; k < plain.size(); ++k) {
      EXPECT_NEAR(by_place[k], plain[k], 1e-14) << solver;
      EXPECT_NEAR(by_factors[k], plain[k], 1e-14) << solver;
    }
  }
}

TEST(VelocityByPlace, factors_are_those_of_a_table_of_velocities) {
  const std::string half = "region = { type = \"box\", lower = [-1, -1], upper = [1, 0] }\n";
  for (const char* solver : {"shape = \"gimp\"\ntransfer = \"flip\"", "type = \"implicit\"\nbasis = \"element\"\nelement_order = 1"}) {
    const auto end = [&](const std::string& velocity) {
      Simulation sim(read(block(2, solver, half + velocity, "end = 0.1\ndt = 0.005")));
      sim.run();
      return sim.solver().field(0, "position").values;
    };
    const std::vector<Real> table = end("times = [0.02, 0.05, 0.08]\nvelocities = [[0, 0], [0.6, -0.2], [0.3, -0.1]]\n");
    const std::vector<Real> factors = end("velocity = [0.3, -0.1]\ntimes = [0.02, 0.05, 0.08]\nfactors = [0, 2, 1]\n");
    const std::vector<Real> places = end(
        "velocity = { type = \"linear\", value = [0.3, -0.1], gradient = [[0, 0], [0, 0]] }\ntimes = [0.02, 0.05, 0.08]\nfactors = [0, 2, "
        "1]\n");
    for (std::size_t k = 0; k < table.size(); ++k) {
      EXPECT_NEAR(factors[k], table[k], 1e-14) << solver;
      EXPECT_NEAR(places[k], table[k], 1e-12) << solver;  // what is linear in time both rules integrate exactly
    }
  }
}

TEST(VelocityByPlace, a_belt_that_stretches_drags_a_block_as_fast_as_it_is_there) {
  // Friction enough to stick, and a block that is short beside the way to where the belt rests.
  const auto speed = [&](const std::string& velocity, const std::string& contact) {
    Simulation sim(
        read(fmt::format(R"(
gravity = [0, -9.81]
[grid]
upper = [2, 0.4]
cells = [80, 16]
[time]
end = 0.5
[[body]]
name = "block"
region = {{ type = "box", lower = [1.15, 0], upper = [1.25, 0.1] }}
layout = {{ type = "per_cell", count = 4 }}
material = {{ type = "neo_hookean", density = 1000, youngs_modulus = 1e6, poissons_ratio = 0.3 }}
[[boundary]]
{}
kind = "velocity"
{}
{}
)",
                         contact == "region" ? "region = { type = \"box\", lower = [0, -1], upper = [2, 0] }" : "side = \"bottom\"",
                         contact == "stick" ? "" : "contact = \"friction\"\nfriction = 1", velocity)));
    const Real start = sim.solver().totals(0).center_of_mass[0];
    sim.run();
    return (sim.solver().totals(0).center_of_mass[0] - start) / sim.time();
  };
  for (const char* contact : {"friction", "region", "stick"}) {
    const Real alike = speed("velocity = [0.012, 0]", contact);
    const Real by_place = speed("velocity = { type = \"linear\", gradient = [[0.01, 0], [0, 0]] }", contact);
    EXPECT_NEAR(alike, 0.012, 0.001) << contact;
    EXPECT_NEAR(by_place, alike, 0.02 * alike) << contact;
  }
}

TEST(VelocityByPlace, a_side_puts_particles_back_with_the_velocity_that_it_has_there) {
  for (const auto& [slope, is_closed] : {std::pair(0.5, true), std::pair(-0.5, false)}) {
    Simulation sim(read(fmt::format(R"(
[grid]
upper = [1, 1]
cells = [10, 10]
particles_outside = "stop"
[time]
end = 0.1
dt = 0.1
[[body]]
name = "one"
layout = {{ type = "points", positions = [[0.55, 0.19]], volumes = [0.01] }}
velocity = [0, -3]
material = {{ type = "neo_hookean", density = 100, youngs_modulus = 1e-3, poissons_ratio = 0 }}
[[boundary]]
side = "bottom"
kind = "velocity"
components = ["y"]
velocity = {{ type = "linear", gradient = [[0, 0], [{}, 0]] }}
)",
                                    slope)));
    if (!is_closed) {
      EXPECT_EQ(sim.run(), RunEnd::particle_left) << "the side goes away from it";
      continue;
    }
    sim.run();
    EXPECT_EQ(sim.solver().ledger().returned_count, 1);
    EXPECT_NEAR(sim.solver().totals(0).momentum[1], 0.5 * 0.55, 1e-9);
  }
}

TEST(VelocityByPlace, its_greatest_speed_limits_the_stable_step) {
  const auto stable = [](const std::string& velocity) {
    return Simulation(read(block(2, "shape = \"gimp\"", everywhere(2) + velocity))).solver().stable_dt();
  };
  // At the corners of the grid: sqrt(1.1^2 + 1) m from the center.
  EXPECT_NEAR(stable("velocity = { type = \"rotating\", center = [0.1, 0], angular_velocity = 500 }\n"), 0.125 / (500 * std::sqrt(2.21)),
              1e-12);
  EXPECT_NEAR(stable("velocity = { type = \"sine\", value = [0, 500], wave_vector = [3, 0] }\n"), 0.125 / 500, 1e-12);
  EXPECT_NEAR(stable("velocity = { type = \"rotating\", center = [0.1, 0], angular_velocity = 500 }\ntimes = [0, 1]\nfactors = [0, -2]\n"),
              0.125 / (1000 * std::sqrt(2.21)), 1e-12);
}

}  // namespace
}  // namespace matpoint::test
