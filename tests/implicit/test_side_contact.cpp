// Contact of particles with sides of the grid in the implicit solver: exact tangents, bounces as of a hard face, books that close.
#include <gmock/gmock.h>

#include "implicit/tangent_error.hpp"
#include "support/from_toml.hpp"
#include "support/solver_case.hpp"
#include "support/temporary_folder.hpp"

namespace matpoint::test {
namespace {

/// A block that is thrown at a side along an axis.
std::string thrown_block(int dim, const std::string& side, const std::string& boundary, const char* modulus, const char* dt,
                         const std::string& solver = "") {
  const BoundarySide at = side_of(side);
  std::vector<Real> v(static_cast<std::size_t>(dim), 0), g = v;
  v[static_cast<std::size_t>(at.axis)] = at.is_upper ? 3 : -3;
  g[static_cast<std::size_t>(at.axis)] = at.is_upper ? 9.81 : -9.81;
  const auto all = [&](const char* one) { return dim == 3 ? fmt::format("[{0}, {0}, {0}]", one) : fmt::format("[{0}, {0}]", one); };
  return fmt::format(R"(
dim = {0}
gravity = [{1}]
[grid]
upper = {2}
cell_size = 0.1
[time]
end = 0.25
dt = {3}
[solver]
type = "implicit"
{4}
[[body]]
name = "body"
region = {{ type = "box", lower = {5}, upper = {6} }}
layout = {{ type = "per_cell", count = {7} }}
velocity = {{ type = "uniform", value = [{8}] }}
material = {{ type = "neo_hookean", density = 1000, youngs_modulus = {9}, poissons_ratio = 0.3 }}
[[boundary]]
side = "{10}"
{11}
)",
                     dim, fmt::join(g, ", "), all("1"), dt, solver, all("0.3"), all("0.7"), dim == 3 ? 27 : 16, fmt::join(v, ", "), modulus,
                     side, boundary);
}

constexpr const char* k_no_tension = "kind = \"fixed\"\ncontact = \"no_tension\"";

struct Bounce {
  Real restitution = 0;
  Real gain = 0;     ///< Greatest energy over that at the start, over the kinetic energy at the start.
  Real nearest = 1;  ///< Of a particle to the side [m].
};

Bounce bounce(const std::string& text, const std::string& side) {
  const BoundarySide at = side_of(side);
  const auto axis = static_cast<std::size_t>(at.axis);
  const Real inward = at.is_upper ? -1 : 1;
  Simulation sim(read(text));
  const Real before = sim.initial_energy();
  const Real kinetic = sim.solver().totals(0).kinetic_energy;
  const Real mass = sim.solver().totals(0).mass;
  const Real start = sim.solver().totals(0).momentum[axis];
  Bounce found;
  Real down = 0, up = 0;
  sim.add_callback([&](const Simulation& now) {
    const BodyTotals totals = now.solver().totals(0);
    const Ledger& ledger = now.solver().ledger();
    const Real energy = totals.kinetic_energy + totals.strain_energy + totals.gravitational_energy + ledger.contact_energy;
    found.gain = std::max(found.gain, (energy - before) / kinetic);
    found.nearest = std::min(found.nearest, at.is_upper ? 1 - totals.upper[axis] : totals.lower[axis]);
    const Real v = inward * totals.momentum[axis] / mass;
    down = std::max(down, -v);
    up = std::max(up, v);
    // What the side has given is what the momentum says.
    const Real impulse = now.solver().boundaries()[0].impulse[axis];
    EXPECT_NEAR(impulse + ledger.gravity_impulse[axis], totals.momentum[axis] - start, 1e-9 * mass * 3);
    EXPECT_NEAR(impulse, ledger.boundary_impulse[axis], 1e-9 * mass * 3);
    return true;
  });
  sim.run();
  found.restitution = up / down;
  return found;
}

TEST(SideContact, a_block_comes_back_as_from_a_hard_face) {
  // Finite elements that converge: 0.785 (0.7846 to 0.7854), the rest is left in its waves.
  for (const std::string side : {"bottom", "top", "left", "right"}) {
    const Bounce found = bounce(thrown_block(2, side, k_no_tension, "1e7", "5e-4"), side);
    EXPECT_NEAR(found.restitution, 0.785, 0.01) << side;
    EXPECT_LT(found.gain, 1e-4) << side;
    EXPECT_GT(found.nearest, 0.5 * 0.0125) << side << ": it comes to the side, half a particle before it";
    EXPECT_LT(found.nearest, 0.0125) << side;
  }
}

TEST(SideContact, no_bounce_makes_energy) {
  for (const int dim : {2, 3}) {
    for (const char* E : {"1e5", "1e8"}) {
      for (const std::string boundary :
           {std::string(k_no_tension), std::string("kind = \"slip\"\ncontact = \"no_tension\""),
            std::string("kind = \"fixed\"\ncontact = \"friction\"\nfriction = 0.3\ncontact_by = \"particles\"")}) {
        if (dim == 3 && (boundary == k_no_tension || std::string(E) == "1e8" || boundary.find("slip") != std::string::npos)) continue;
        const std::string side = dim == 3 ? "back" : "bottom";
        EXPECT_LT(bounce(thrown_block(dim, side, boundary, E, "2e-3"), side).gain, 1e-4) << dim << " " << E << boundary;
      }
    }
  }
}

TEST(SideContact, elements_let_go_too) {
  const Bounce found = bounce(thrown_block(2, "bottom", k_no_tension, "1e7", "5e-4", "basis = \"element\"\nelement_order = 1"), "bottom");
  EXPECT_NEAR(found.restitution, 0.785, 0.04);
  EXPECT_LT(found.gain, 1e-4);
}

/// A block that rests at the bottom and is shaken.
template <int Dim>
void check_tangent(const std::string& boundary) {
  Simulation sim(read(thrown_block(Dim, "bottom", boundary, "1e6", "1e-3"),
                      {Dim == 3 ? "body.body.region.lower=[0.3, 0, 0.3]" : "body.body.region.lower=[0.3, 0]"}));
  auto& solver = dynamic_cast<ImplicitSolver<Dim>&>(sim.solver());
  solver.assembly().start();
  StepLoad<Dim> load;
  load.dt = 1e-3;
  load.inertia = {4e6, 4000, 1};
  std::vector<Real> u(solver.space().nodes().size() * Dim);
  for (std::size_t k = 0; k < u.size(); ++k) {
    const Vec<Dim> x = solver.basis().node_position(solver.space().nodes()[k / Dim]);
    u[k] = 1e-3 * std::sin(7.0 * x[0] + 11.0 * x[1] + static_cast<Real>(k % Dim)) - (k % Dim == 1 ? 2e-3 : -1e-3);
  }
  EXPECT_LT(tangent_error<Dim>(solver, load, u), 1e-7) << Dim << boundary;
}

TEST(SideContact, tangents_are_exact) {
  for (const std::string boundary : {std::string(k_no_tension), std::string("kind = \"slip\"\ncontact = \"no_tension\""),
                                     std::string("kind = \"fixed\"\ncontact = \"friction\"\nfriction = 0.3\ncontact_by = \"particles\"")}) {
    check_tangent<2>(boundary);
    check_tangent<3>(boundary);
  }
}

TEST(SideContact, a_belt_takes_a_block_along_and_its_books_close) {
  for (const std::string contact :
       {std::string("contact = \"no_tension\""), std::string("contact = \"friction\"\nfriction = 0.3\ncontact_by = \"particles\"")}) {
    for (const char* poissons_ratio : {"0.3", "0.49"}) {  // without and with volumes by patches
      Simulation sim(read(fmt::format(R"(
gravity = [0, -9.81]
[grid]
upper = [4, 1]
cells = [40, 10]
[time]
end = 0.6
dt = 5e-3
[solver]
type = "implicit"
[[body]]
name = "block"
region = {{ type = "box", lower = [0.5, 0], upper = [0.9, 0.4] }}
layout = {{ type = "per_cell", count = 9 }}
material = {{ type = "neo_hookean", density = 1000, youngs_modulus = 1e6, poissons_ratio = {} }}
[[boundary]]
side = "bottom"
kind = "velocity"
velocity = [0.5, 0]
{}
)",
                                      poissons_ratio, contact)));
      const Real mass = sim.solver().totals(0).mass;
      Real at_start = 0;
      sim.add_callback([&](const Simulation& now) {
        if (now.time() < 0.1) at_start = now.solver().totals(0).momentum[0] / mass;
        return true;
      });
      sim.run();
      const BodyTotals block = sim.solver().totals(0);
      const BoundaryTotals belt = sim.solver().boundaries()[0];
      EXPECT_NEAR(belt.impulse[0], block.momentum[0], 1e-9 * mass) << contact;
      EXPECT_NEAR(block.momentum[0] / mass, 0.5, contact.find("friction") != std::string::npos ? 0.02 : 0.12)
          << contact << ": it swings, glued";
      if (contact.find("friction") != std::string::npos) EXPECT_NEAR(at_start, 0.3 * 9.81 * 0.095, 0.02) << "Coulomb";
      EXPECT_GT(belt.work, block.kinetic_energy);
    }
  }
}

TEST(SideContact, a_side_that_moves_inwards_is_a_piston) {
  // A side that stayed where the grid ends gave the block in front of it 0.022 to 0.085 m/s, the less the shorter the steps.
  for (const char* dt : {"5e-4", "2e-3", "2e-2"}) {
    Simulation sim(read(fmt::format(R"(
gravity = [0, 0]
[grid]
upper = [2, 1]
cells = [20, 10]
[time]
end = 0.3
dt = {}
[solver]
type = "implicit"
[[body]]
name = "block"
region = {{ type = "box", lower = [0, 0.3], upper = [0.4, 0.7] }}
layout = {{ type = "per_cell", count = 9 }}
material = {{ type = "neo_hookean", density = 1000, youngs_modulus = 1e6, poissons_ratio = 0.3 }}
[[boundary]]
side = "left"
kind = "velocity"
velocity = [0.5, 0]
contact = "no_tension"
)",
                                    dt)));
    sim.run();
    const BodyTotals block = sim.solver().totals(0);
    const BoundaryTotals ram = sim.solver().boundaries()[0];
    const Real v = block.momentum[0] / block.mass;
    EXPECT_GT(v, 0.5) << dt << ": it flies off";
    EXPECT_LT(v, 1.0) << dt << ": with twice the piston's velocity if nothing were left in its waves";
    EXPECT_GT(block.lower[0], 0.5 * 0.3) << dt << ": nothing is behind the piston";
    EXPECT_NEAR(ram.impulse[0], block.momentum[0], 1e-9 * block.mass) << dt;
    EXPECT_LT(std::abs(transfer_loss(sim)), 1e-3 * ram.work) << dt;
  }
}

/// A block that lies on a side, under its weight towards it.
std::string lying_block(int dim, const std::string& side, const std::string& boundary, const std::string& more = "") {
  const BoundarySide at = side_of(side);
  const auto axis = static_cast<std::size_t>(at.axis);
  std::vector<Real> g(static_cast<std::size_t>(dim), 0), lower(g.size(), 0.3), upper(g.size(), 0.7);
  g[axis] = at.is_upper ? 10 : -10;
  (at.is_upper ? upper : lower)[axis] = at.is_upper ? 1 : 0;
  return fmt::format(R"(
dim = {}
gravity = [{}]
[grid]
upper = [{}]
cell_size = 0.1
[time]
end = 1
dt = 0.25
[solver]
type = "implicit"
mode = "static"
{}
[[body]]
name = "body"
region = {{ type = "box", lower = [{}], upper = [{}] }}
layout = {{ type = "per_cell", count = {} }}
material = {{ type = "neo_hookean", density = 1000, youngs_modulus = 1e6, poissons_ratio = 0 }}
[[boundary]]
name = "floor"
side = "{}"
{}
)",
                     dim, fmt::join(g, ", "), fmt::join(std::vector<Real>(g.size(), 1), ", "), more, fmt::join(lower, ", "),
                     fmt::join(upper, ", "), dim == 3 ? 8 : 16, side, boundary);
}

TEST(StaticSideContact, a_block_lies_on_a_side_with_its_weight) {
  for (const int dim : {2, 3}) {
    for (const std::string side : {"bottom", "top", "left", "right", "front", "back"}) {
      if (dim == 2 && (side == "front" || side == "back")) continue;
      for (const std::string solver : {"", "basis = \"element\"\nelement_order = 1"}) {
        for (const std::string boundary :
             {"kind = \"fixed\"\ncontact = \"no_tension\"", "kind = \"fixed\"\ncontact = \"friction\"\nfriction = 0.3"}) {
          const std::string name = fmt::format("{}d {} {} {}", dim, side, solver, boundary);
          Simulation sim(read(lying_block(dim, side, boundary, solver)));
          sim.run();
          const auto axis = static_cast<std::size_t>(side_of(side).axis);
          const Real up = side_of(side).is_upper ? -1 : 1;
          const Real weight = 10 * sim.solver().totals(0).mass;
          const Vec3 force = sim.solver().boundaries()[0].force;
          for (std::size_t d = 0; d < static_cast<std::size_t>(dim); ++d)
            EXPECT_NEAR(force[d], d == axis ? up * weight : 0, 1e-8 * weight) << name;
          // In each row of cells the mean stress is the weight above; the force of the side enters over the first two.
          const std::vector<Real> x = sim.solver().field(0, "position").values, stress = sim.solver().field(0, "stress").values;
          const auto n = static_cast<std::size_t>(dim);
          for (int row = 1; row < 7; ++row) {
            Real sum = 0;
            int count = 0;
            for (std::size_t p = 0; n * p < x.size(); ++p) {
              const Real height = up > 0 ? x[n * p + axis] : 1 - x[n * p + axis];
              if (height < 0.1 * row || height > 0.1 * (row + 1)) continue;
              sum += stress[6 * p + axis];
              ++count;
            }
            EXPECT_NEAR(sum / count, -1e4 * (0.65 - 0.1 * row), (row == 1 ? 0.08 : row == 2 ? 0.03 : 0.01) * 7e3) << name << row;
          }
        }
      }
    }
  }
}

TEST(StaticSideContact, a_round_body_lies_on_a_side_whatever_the_cells) {
  // Its particles have not quite the size of their places, so that the lowest are a little nearer to the side, or farther, than half of it.
  for (const char* cell_size : {"0.1", "0.05", "0.04", "0.025"}) {
    Simulation sim(read(lying_block(2, "bottom", "kind = \"fixed\"\ncontact = \"friction\"\nfriction = 0.3"),
                        {fmt::format("grid.cell_size={}", cell_size),
                         "body.body.region={ type = \"disk\", center = [0.5, 0.2], radius = 0.2 }", "time.dt=0.5"}));
    sim.run();
    const Real weight = 10 * sim.solver().totals(0).mass;
    EXPECT_NEAR(sim.solver().boundaries()[0].force[1], weight, 1e-8 * weight) << cell_size;
    EXPECT_NEAR(sim.solver().boundaries()[0].force[0], 0, 1e-8 * weight) << cell_size;
  }
}

TEST(StaticSideContact, what_is_lifted_off_leaves_the_side_without_a_pull) {
  // The top is held and rises: the floor carries less and less, and then nothing.
  const std::string top =
      "[[boundary]]\nname = \"hook\"\nregion = { type = \"box\", lower = [0, 0.39], upper = [1, 1] }\nkind = \"velocity\"\nvelocity = [0, "
      "2e-3]\n";
  Simulation sim(
      read(lying_block(2, "bottom", "kind = \"fixed\"\ncontact = \"no_tension\"", "basis = \"element\"\nelement_order = 1") + top));
  const Real weight = 10 * sim.solver().totals(0).mass;
  std::vector<Real> carried;
  sim.add_callback([&](const Simulation& now) {
    if (now.step_count() == 0) return true;
    const Real load = now.time() * weight;  // statics bring it on
    const std::vector<BoundaryTotals> boundaries = now.solver().boundaries();
    EXPECT_NEAR(boundaries[0].force[1] + boundaries[1].force[1], load, 1e-8 * weight);
    EXPECT_GE(boundaries[0].force[1], -1e-9 * weight);
    carried.push_back(boundaries[0].force[1] / weight);
    return true;
  });
  sim.run();
  EXPECT_NEAR(carried.back(), 0, 1e-9) << "the block hangs";
  EXPECT_GT(sim.solver().totals(0).lower[1], 0.0125) << "clear of the floor";
}

TEST(StaticSideContact, what_is_pushed_slides_with_coulombs_friction) {
  for (const int dim : {2, 3}) {
    const std::string glued = fmt::format(
        "[[boundary]]\nname = \"press\"\nregion = {{ type = \"box\", lower = [{0}], upper = [{1}] }}\nkind = \"velocity\"\nvelocity = "
        "[{2}]\n",
        dim == 2 ? "0, 0.39" : "0, 0.39, 0", dim == 2 ? "1, 1" : "1, 1, 1", dim == 2 ? "0.02, -0.01" : "0.02, -0.01, 0");
    Simulation sim(read(
        lying_block(dim, "bottom", "kind = \"fixed\"\ncontact = \"friction\"\nfriction = 0.3", "basis = \"element\"\nelement_order = 1") +
            glued,
        {"time.dt=0.05", "solver.linear_solver=auto"}));
    Real last = 0;
    sim.add_callback([&](const Simulation& now) {
      const Vec3 force = now.solver().boundaries()[0].force;
      EXPECT_LE(std::abs(force[0]), 0.3 * force[1] * (1 + 1e-9) + 1e-9);
      last = force[1] > 0 ? -force[0] / force[1] : 0;
      return true;
    });
    sim.run();
    EXPECT_NEAR(last, 0.3, 0.3e-3) << dim << "d: all of it slips";
  }
}

TEST(StaticSideContact, what_nothing_holds_is_refused_with_what_would) {
  const std::string no_tension = "kind = \"slip\"\ncontact = \"no_tension\"";
  EXPECT_NE(complaint_of([&] { Simulation(read(lying_block(2, "bottom", no_tension))); }).find("free to move along x"), std::string::npos);
  const std::string above = complaint_of([&] {
    Simulation(read(lying_block(2, "bottom", "kind = \"fixed\"\ncontact = \"no_tension\""), {"body.body.region.lower=[0.3, 0.1]"}));
  });
  EXPECT_NE(above.find("a side that lets go holds what lies on it, half a particle's spacing away"), std::string::npos) << above;
  EXPECT_NE(
      complaint_of([&] {
        Simulation(read(lying_block(2, "bottom", "kind = \"fixed\"\ncontact = \"friction\"\nfriction = 0.3\ncontact_by = \"nodes\"")));
      }).find("contact_by = \"nodes\" is for mode = \"dynamic\" only"),
      std::string::npos);
  // Pulled away from a floor that lets go it has no place to stay.
  Simulation sim(read(lying_block(2, "bottom", "kind = \"fixed\"\ncontact = \"no_tension\""), {"gravity=[0, 10]"}));
  EXPECT_THROW(sim.run(), SolverError);
}

TEST(SideContact, a_particle_on_the_side_is_refused_by_name) {
  const std::string text = R"(
[grid]
upper = [1, 1]
cells = [4, 4]
[time]
end = 1
dt = 0.1
[solver]
type = "implicit"
[[body]]
name = "grains"
layout = { type = "points", positions = [[0.5, 0.0], [0.6, 0.1]], volumes = 0.01 }
material = { type = "neo_hookean", density = 1000, youngs_modulus = 1e6, poissons_ratio = 0.3 }
[[boundary]]
side = "bottom"
kind = "fixed"
contact = "no_tension"
)";
  EXPECT_THAT(message_of<InputError>([&] { Simulation sim(read(text)); }),
              testing::AllOf(testing::HasSubstr("body \"grains\": particle 0 at (0.5, 0) lies on a side with contact"),
                             testing::HasSubstr("contact_by = \"nodes\"")));
  Simulation by_nodes(read(text + "contact_by = \"nodes\"\n"));
}

}  // namespace
}  // namespace matpoint::test
