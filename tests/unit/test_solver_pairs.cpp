// Contact between bodies by forces between pairs of particles.
#include "core/parallel.hpp"
#include "solver/pair_contact.hpp"
#include "support/solver_case.hpp"

namespace matpoint::test {
namespace {

constexpr Real k_spacing = 1.0 / 24;

/// A box of 2 x 1 (x 0.5) m with cells of 1/12 m.
Case pairs_case(int dim, Real friction) {
  Case problem = make_case(dim, {0, 0, 0}, {2, 1, dim == 3 ? 0.5 : 0.0}, {24, 12, 6});
  problem.grid.cells.resize(static_cast<std::size_t>(dim));
  problem.solver.contact = ContactMethod::pairs;
  problem.solver.friction = friction;
  problem.time.dt = 1e-3;
  return problem;
}

BodySpec block(int dim, const std::string& name, const Vec3& lower, const Vec3& upper, const Vec3& velocity,
               Formulation formulation = Formulation::updated) {
  const std::array<int, 3> count{static_cast<int>(std::lround((upper[0] - lower[0]) / k_spacing)),
                                 static_cast<int>(std::lround((upper[1] - lower[1]) / k_spacing)), 6};
  BodySpec body = make_body(name, lattice(dim, lower, upper, count), neo_hookean(1e5, 0.3, 1000), [=](const Vec3&) { return velocity; });
  body.formulation = formulation;
  return body;
}

/// A block on the way to two others.
Case three_blocks(int dim, Real friction, Formulation formulation = Formulation::updated) {
  Case problem = pairs_case(dim, friction);
  problem.bodies.push_back(block(dim, "left", {0.3, 0.3, 0.1}, {0.8, 0.8, 0.35}, {0.5, 0.1, 0}, formulation));
  problem.bodies.push_back(block(dim, "right low", {0.85, 0.3, 0.1}, {1.35, 0.55, 0.35}, {-0.5, 0, 0}, formulation));
  problem.bodies.push_back(block(dim, "right high", {0.85, 0.55, 0.1}, {1.35, 0.8, 0.35}, {-0.5, -0.1, 0}));
  problem.time.end = 0.3;
  return problem;
}

Real whole_energy(const Simulation& sim) { return sums_of(sim.solver()).energy + sim.solver().ledger().contact_energy; }

template <int Dim>
void expect_kernel_is_consistent() {
  const PairKernel<Dim> kernel(2.5);
  // Midpoint sums over half a space, in cells of a tenth: the functions have three continuous derivatives at their ends.
  const Real h = 0.1;
  for (const Real z : {0.0, 0.5, 1.3}) {
    Real beyond = 0;
    Real over = 0;
    for (int i = -30; i < 30; ++i) {
      for (int j = Dim == 3 ? -30 : 0; j < (Dim == 3 ? 30 : 1); ++j) {
        const Real along2 = std::pow((i + 0.5) * h, 2) + (Dim == 3 ? std::pow((j + 0.5) * h, 2) : 0);
        const auto W = [&](Real across) { return kernel.value(std::max(0.0, 1 - (across * across + along2) / 6.25)); };
        over += W(z) * std::pow(h, Dim - 1);
        for (int k = 0; k < 30; ++k) beyond += W(z + (k + 0.5) * h) * std::pow(h, Dim);
      }
    }
    EXPECT_NEAR(kernel.over_plane(z), over, 1e-5) << Dim << " " << z;
    EXPECT_NEAR(kernel.beyond_plane(z), beyond, 1e-3) << Dim << " " << z;
  }
  EXPECT_NEAR(kernel.beyond_plane(0), 0.5, 1e-8);
  EXPECT_EQ(kernel.beyond_plane(2.5), 0);
  const auto W = [&](Real d) { return kernel.value(1 - d * d / 6.25); };
  EXPECT_NEAR(kernel.slope(1 - 1 / 6.25), -(W(1 + 1e-5) - W(1 - 1e-5)) / 2e-5, 1e-9);
}

TEST(PairKernel, is_consistent_with_its_integrals) {
  expect_kernel_is_consistent<2>();
  expect_kernel_is_consistent<3>();
}

/// Energy that two particles of volume V store at the distance d, by hand.
Real energy_of_two(int dim, Real volume, Real d, Real modulus) {
  const Real spacing = std::pow(volume, 1.0 / dim);
  const Real q = 1 - d * d / (6.25 * spacing * spacing);
  Real over = 0;
  if (dim == 2) {
    const PairKernel<2> kernel(2.5 * spacing);
    over = volume * kernel.value(q) - kernel.beyond_plane(0.5 * spacing);
  } else {
    const PairKernel<3> kernel(2.5 * spacing);
    over = volume * kernel.value(q) - kernel.beyond_plane(0.5 * spacing);
  }
  return over > 0 ? volume * modulus * over * over : 0;
}

TEST(PairContact, two_particles_push_by_the_derivative_of_what_they_store) {
  for (const int dim : {2, 3}) {
    // Particles as wide as a cell.
    const Real spacing = 1.0 / 12;
    const Real volume = std::pow(spacing, dim);
    const Real d = 0.2 * spacing;
    const std::shared_ptr<Material> soft = neo_hookean(1e5, 0.3, 1000);
    const auto problem_at = [&](Real distance) {
      Case problem = pairs_case(dim, 0);
      problem.solver.contact_stiffness = 2;
      problem.solver.mass_cutoff = 0;
      for (const Real x : {1.0, 1 + distance}) {
        Seeds seeds{{Vec3{x, 0.5, dim == 3 ? 0.25 : 0}}, {volume}};
        problem.bodies.push_back(make_body(x == 1 ? "one" : "other", seeds, x == 1 ? soft : neo_hookean(2e5, 0.3, 1000)));
      }
      return problem;
    };
    // Of the softer one.
    const Real modulus = 2 * 1000 * std::pow(soft->wave_speed(1), 2);
    Simulation sim(problem_at(d));
    EXPECT_NEAR(sim.solver().ledger().contact_energy, energy_of_two(dim, volume, d, modulus), 1e-12 * modulus * volume);
    EXPECT_GT(sim.solver().ledger().contact_energy, 0);
    EXPECT_NEAR(sim.initial_energy(), sim.solver().ledger().contact_energy, 1e-12 * modulus * volume);
    const Real e = 1e-6 * spacing;
    const Real force = -(energy_of_two(dim, volume, d + e, modulus) - energy_of_two(dim, volume, d - e, modulus)) / (2 * e);
    sim.step();
    EXPECT_NEAR(sim.solver().totals(1).momentum[0], force * 1e-3, 1e-6 * force * 1e-3);
    EXPECT_NEAR(sim.solver().totals(0).momentum[0], -force * 1e-3, 1e-6 * force * 1e-3);
    EXPECT_NEAR(sim.solver().totals(0).momentum[1], 0, 1e-15);
    // Two lone particles are less than a surface: they touch later.
    EXPECT_EQ(Simulation(problem_at(spacing)).solver().ledger().contact_energy, 0);
  }
}

TEST(PairContact, flat_surfaces_press_when_they_touch) {
  for (const int dim : {2, 3}) {
    for (const Real shift : {0.0, 0.3 * k_spacing}) {
      const auto energy_at = [&](Real gap) {
        Case problem = pairs_case(dim, 0);
        problem.bodies.push_back(block(dim, "low", {0.5, 0.25, 0.1}, {1, 0.5, 0.35}, {}));
        problem.bodies.push_back(block(dim, "high", {0.5 + shift, 0.5 + gap, 0.1}, {1 + shift, 0.75 + gap, 0.35}, {}));
        return Simulation(problem).solver().ledger().contact_energy / (dim == 3 ? 0.25 : 1) / 0.5;
      };
      // Over K s: nothing a tenth of a spacing before they touch, and a good part of (gap / s)^2 / 2 when they overlap.
      const Real K_s = 1e5 * 0.7 / (1.3 * 0.4) * k_spacing;
      EXPECT_EQ(energy_at(0.1 * k_spacing), 0) << dim;
      EXPECT_GT(energy_at(-0.5 * k_spacing) / K_s, 0.04) << dim;
      EXPECT_LT(energy_at(-0.5 * k_spacing) / K_s, 0.08) << dim;
    }
  }
}

TEST(PairContact, three_bodies_keep_momentum_and_never_gain_energy) {
  for (const int dim : {2, 3}) {
    for (const Real friction : {0.0, 0.4}) {
      for (const Formulation formulation : {Formulation::updated, Formulation::total}) {
        Simulation sim(three_blocks(dim, friction, formulation));
        const Real scale = momentum_scale(sim.solver());
        Real greatest = 0;
        Real greatest_stored = 0;
        sim.add_callback([&](const Simulation& now) {
          greatest = std::max(greatest, whole_energy(now));
          greatest_stored = std::max(greatest_stored, now.solver().ledger().contact_energy);
          return true;
        });
        sim.run();
        // Round-off of a few eps of the momentum per step.
        EXPECT_LT(momentum_remainder(sim), 300 * 10 * k_epsilon * scale) << dim << " " << friction;
        EXPECT_LT(greatest, sim.initial_energy() * (1 + 1e-9)) << dim << " " << friction;
        EXPECT_GT(greatest_stored, 0.01 * sim.initial_energy()) << "the bodies should have collided";
        if (friction == 0)
          EXPECT_EQ(sim.solver().ledger().contact_dissipation, 0);
        else
          EXPECT_GT(sim.solver().ledger().contact_dissipation, 0);
      }
    }
  }
}

TEST(PairContact, the_books_of_energy_close_as_steps_shrink) {
  // What neither the bodies nor the ledger have is the loss of the transfers; contact should add little to it.
  for (const StressOrder order : {StressOrder::usl, StressOrder::usf, StressOrder::musl}) {
    Case problem = three_blocks(2, 0, Formulation::total);
    problem.solver.stress_order = order;
    problem.time.dt = 2.5e-4;
    Simulation sim(problem);
    sim.run();
    EXPECT_LT(std::abs(transfer_loss(sim)), 0.02 * sim.initial_energy()) << order_name(order);
  }
}

TEST(PairContact, bodies_apart_move_freely) {
  for (const auto& [gap, speed] : {std::pair<Real, Real>{1.0 / 12, 0.01}, {0.1 * k_spacing, -0.5}}) {
    Case problem = pairs_case(2, 0.5);
    problem.bodies.push_back(block(2, "left", {0.3, 0.3, 0}, {0.8, 0.8, 0}, {speed, 0, 0}));
    problem.bodies.push_back(block(2, "right", {0.8 + gap, 0.3, 0}, {1.3 + gap, 0.8, 0}, {}));
    problem.solver.mass_cutoff = 0;
    problem.time.end = 0.05;
    Simulation sim(problem);
    sim.run();
    EXPECT_EQ(sim.solver().ledger().contact_energy, 0);
    EXPECT_EQ(sim.solver().totals(1).momentum[0], 0);
    EXPECT_NEAR(sim.solver().totals(0).momentum[0], 250 * speed, 1e-10);
  }
}

TEST(PairContact, friction_acts_by_coulombs_law) {
  // A block falls on a wider one, both free, and slides along x: the impulses along are mu times those across.
  for (const Formulation formulation : {Formulation::updated, Formulation::total}) {
    Real along[2], across[2];
    for (const int k : {0, 1}) {
      Case problem = pairs_case(2, 0.2 * k);
      problem.bodies.push_back(block(2, "low", {0.1, 0.1, 0}, {1.9, 0.5, 0}, {}, formulation));
      problem.bodies.push_back(block(2, "high", {0.5, 0.51, 0}, {1.5, 0.9, 0}, {0.3, -0.1, 0}, formulation));
      problem.time.end = 0.25;
      Simulation sim(problem);
      sim.run();
      along[k] = sim.solver().totals(0).momentum[0];
      across[k] = -sim.solver().totals(0).momentum[1];
    }
    EXPECT_GT(across[0], 20) << "the block should have fallen on the other";
    EXPECT_NEAR(along[0], 0, 0.01 * across[0]) << "without friction";
    EXPECT_NEAR(along[1] / across[1], 0.2, 0.02);
  }
}

TEST(PairContact, total_and_updated_bodies_collide_alike) {
  Real speed[2], spent[2];
  for (const int k : {0, 1}) {
    Simulation sim(three_blocks(2, 0.2, k == 0 ? Formulation::updated : Formulation::total));
    sim.run();
    speed[k] = sim.solver().totals(0).momentum[0] / sim.solver().totals(0).mass;
    spent[k] = sim.solver().ledger().contact_dissipation / sim.initial_energy();
  }
  EXPECT_NEAR(speed[0], speed[1], 0.02 * 0.5);
  EXPECT_NEAR(spent[0], spent[1], 0.02);
}

TEST(PairContact, any_number_of_threads_gives_the_same_bits) {
  const auto state_with = [](int threads) {
    set_thread_count(threads);
    Case problem = three_blocks(3, 0.3, Formulation::total);
    problem.time.end = 0.1;
    Simulation sim(problem);
    sim.run();
    std::vector<Real> state = {sim.solver().ledger().contact_energy, sim.solver().ledger().contact_dissipation};
    for (std::size_t b = 0; b < 3; ++b) {
      const std::vector<Real> v = sim.solver().field(b, "velocity").values;
      state.insert(state.end(), v.begin(), v.end());
    }
    return state;
  };
  const std::vector<Real> one = state_with(1);
  EXPECT_TRUE(state_with(2) == one);
  EXPECT_TRUE(state_with(3) == one);
  set_thread_count(0);
}

TEST(PairContact, mirrored_bodies_stay_mirrored) {
  for (const Formulation formulation : {Formulation::updated, Formulation::total}) {
    Case problem = pairs_case(2, 0.3);
    problem.bodies.push_back(block(2, "left", {0.45, 0.25, 0}, {0.95, 0.75, 0}, {0.4, 0, 0}, formulation));
    problem.bodies.push_back(block(2, "right", {1.05, 0.25, 0}, {1.55, 0.75, 0}, {-0.4, 0, 0}, formulation));
    problem.time.end = 0.3;
    Simulation sim(problem);
    sim.run();
    const BodyTotals left = sim.solver().totals(0);
    const BodyTotals right = sim.solver().totals(1);
    EXPECT_LT(left.momentum[0], -10) << "they should have parted";
    EXPECT_NEAR(left.momentum[0], -right.momentum[0], 1e-8);
    EXPECT_NEAR(left.momentum[1], 0, 1e-8);
    EXPECT_NEAR(left.center_of_mass[0] + right.center_of_mass[0], 2, 1e-9);
  }
}

TEST(PairContact, a_body_on_a_rough_slope_stays_where_it_is) {
  // tan of the slope is 0.2, the coefficient 0.4: what holds is a spring, so nothing creeps.
  Case problem = pairs_case(2, 0.4);
  problem.gravity = {0.4, -2, 0};
  problem.boundaries.push_back(make_side("bottom", BoundaryKind::fixed));
  problem.bodies.push_back(block(2, "low", {0, 0, 0}, {2, 0.25, 0}, {}, Formulation::total));
  problem.bodies.push_back(block(2, "high", {0.5, 0.25, 0}, {1, 0.5, 0}, {}, Formulation::total));
  problem.time.end = 1;
  Simulation sim(problem);
  const Real start = sim.solver().totals(1).center_of_mass[0];
  Real farthest = 0;
  sim.add_callback([&](const Simulation& now) {
    farthest = std::max(farthest, now.solver().totals(1).center_of_mass[0] - start);
    return true;
  });
  sim.run();
  // It would slide 0.2 m without friction; weight along over the springs' stiffness is a thousandth of a spacing.
  EXPECT_LT(farthest, 0.2 * k_spacing);
}

TEST(PairContact, a_stiffer_contact_needs_shorter_steps) {
  Case problem = three_blocks(2, 0);
  problem.solver.contact_stiffness = 400;
  const Real stiff = Simulation(problem).solver().stable_dt();
  problem.solver.contact_stiffness = 1600;
  EXPECT_NEAR(Simulation(problem).solver().stable_dt(), stiff / 2, 1e-12);
}

TEST(PairContact, removed_particles_take_their_part_of_the_energy) {
  Case problem = pairs_case(2, 0);
  problem.bodies.push_back(block(2, "left", {1, 0.3, 0}, {1.49, 0.8, 0}, {1, 0, 0}));
  problem.bodies.push_back(block(2, "right", {1.5, 0.3, 0}, {2, 0.8, 0}, {1, 0, 0}));
  problem.grid.particles_outside = OutsidePolicy::remove;
  problem.time.end = 0.6;
  Simulation sim(problem);
  sim.run();
  EXPECT_GT(sim.solver().ledger().removed_count, 100);
  EXPECT_LT(std::abs(transfer_loss(sim)), 0.02 * sim.initial_energy());
  EXPECT_LT(momentum_remainder(sim), 1e-9);
}

}  // namespace
}  // namespace matpoint::test
