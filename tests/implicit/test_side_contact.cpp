// Contact of particles with sides of the grid in the implicit solver: exact tangents, bounces as of a hard face, books that close.
#include <gmock/gmock.h>

#include "implicit/tangent_error.hpp"
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
