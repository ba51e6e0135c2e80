// What every combination of stress order, shape function, transfer and contact keeps in 2D and 3D: mass, momentum, rigid motion, symmetry,
// and the bits for any number of threads.
#include "core/parallel.hpp"
#include "kernel/sweep.hpp"
#include "support/solver_case.hpp"

namespace matpoint::test {
namespace {

struct Combination {
  StressOrder order;
  int dim;
  ShapeKind shape = ShapeKind::linear;
  Transfer transfer = Transfer::flip;
  ContactMethod contact = ContactMethod::single_field;
  Formulation formulation = Formulation::updated;

  std::string name() const {
    const std::string contacts[] = {"", "_contact", "_pairs"};
    const std::string transfers[] = {"", "_pic", "_apic", "_tpic", "_fmpm"};
    return order_name(order) + std::to_string(dim) + "d" +
           std::vector<std::string>{"", "_bspline2", "_bspline3", "_gimp", "_cpdi"}[static_cast<std::size_t>(shape)] +
           transfers[static_cast<int>(transfer)] + contacts[static_cast<int>(contact)] +
           (formulation == Formulation::total ? "_total" : "");
  }
};

class SolverInvariants : public testing::TestWithParam<Combination> {
 protected:
  StressOrder order() const { return GetParam().order; }
  int dim() const { return GetParam().dim; }
  /// Empty grid of a 2 x 1 (x 1) box with cubic cells, no gravity, no cutoff.
  Case empty_case(int cells_across) const {
    Case problem = make_case(dim(), {0, 0, 0}, {2, 1, dim() == 3 ? 1.0 : 0.0}, {2 * cells_across, cells_across, cells_across});
    problem.grid.cells.resize(static_cast<std::size_t>(dim()));
    problem.solver.stress_order = order();
    problem.solver.shape = GetParam().shape;
    problem.solver.transfer = GetParam().transfer;
    problem.solver.contact = GetParam().contact;
    problem.solver.friction = 0.3;
    problem.solver.mass_cutoff = 0;
    return problem;
  }
  Simulation simulation(Case problem) const {
    for (BodySpec& body : problem.bodies) body.formulation = GetParam().formulation;
    return Simulation(problem);
  }
};

/// For some of the combinations: how a step is dealt to threads depends on neither the transfer nor the number of nodes.
class SolverThreads : public SolverInvariants {};

/// Two blocks on the way to each other, off-centre in y and z so that they spin after the impact.
Case colliding_blocks(Case problem) {
  const int dim = problem.dim;
  const Seeds left = jittered(lattice(dim, {0.3, 0.25, 0.3}, {0.9, 0.65, 0.7}, {9, 6, 6}), dim, 0.01);
  const Seeds right = jittered(lattice(dim, {0.95, 0.4, 0.35}, {1.5, 0.8, 0.7}, {8, 6, 5}), dim, 0.01);
  problem.bodies.push_back(make_body("left", left, neo_hookean(1e4, 0.3, 1000), [=](const Vec3&) {
    return Vec3{0.5, 0.1, dim == 3 ? -0.05 : 0};
  }));
  problem.bodies.push_back(make_body("right", right, st_venant_kirchhoff(2e4, 0.2, 700), [](const Vec3&) { return Vec3{-0.4, 0, 0}; }));
  // USL takes L from velocities of nodes with hardly any mass, of which 3D has more; a step this small keeps them harmless until after the
  // impact.
  const bool is_delicate = dim == 3 && problem.solver.stress_order == StressOrder::usl && problem.solver.mass_cutoff == 0;
  problem.time.dt = is_delicate ? 2e-4 : 2e-3;
  problem.time.end = is_delicate ? 0.2 : 0.4;
  return problem;
}

TEST_P(SolverInvariants, mass_of_every_particle_never_changes) {
  Simulation sim = simulation(colliding_blocks(empty_case(6)));
  const std::vector<Real> before = sim.solver().field(0, "mass").values;
  const Real total = sums_of(sim.solver()).mass;
  sim.run();
  EXPECT_EQ(sim.solver().field(0, "mass").values, before);
  // The sum is taken in the order of memory, which sorting changes: round-off of a sum of n terms, n eps at most.
  EXPECT_NEAR(sums_of(sim.solver()).mass, total, 700 * k_epsilon * total);
}

TEST_P(SolverInvariants, momentum_is_kept_to_round_off_without_cutoff) {
  Simulation sim = simulation(colliding_blocks(empty_case(6)));
  const Real scale = momentum_scale(sim.solver());
  const Real strain_energy_before = sim.solver().totals(0).strain_energy;
  sim.run();
  EXPECT_GT(sim.solver().totals(0).strain_energy, strain_energy_before + 1e-3) << "the blocks should have collided";
  // Each step adds round-off of a few eps of the mapped momentum and of dt times the internal forces, which is of the same size.
  EXPECT_LT(momentum_remainder(sim), static_cast<Real>(sim.step_count()) * 10 * k_epsilon * scale);
  EXPECT_EQ(sim.solver().ledger().cutoff_impulse, Vec3{});
}

TEST_P(SolverInvariants, momentum_changes_exactly_by_the_booked_cutoff_impulse) {
  for (const Real flip : {1.0, 0.95}) {
    Case problem = colliding_blocks(empty_case(6));
    problem.solver.mass_cutoff = 0.3;  // a good part of a particle: many nodes fall under it
    problem.solver.flip = flip;
    Simulation sim = simulation(problem);
    const Real scale = momentum_scale(sim.solver());
    sim.run();
    const Vec3 lost = sim.solver().ledger().cutoff_impulse;
    EXPECT_GT(std::abs(lost[0]) + std::abs(lost[1]), 1e-6 * scale) << "the cutoff should have held something back";
    EXPECT_LT(momentum_remainder(sim), static_cast<Real>(sim.step_count()) * 10 * k_epsilon * scale);
  }
}

TEST_P(SolverInvariants, rigid_translation_leaves_F_at_I_and_stress_at_zero) {
  Case problem = empty_case(6);
  const Seeds seeds = jittered(lattice(dim(), {0.2, 0.2, 0.2}, {0.7, 0.6, 0.6}, {7, 6, 6}), dim(), 0.01);
  const Vec3 velocity{2, 0.3, dim() == 3 ? 0.4 : 0};
  problem.bodies.push_back(make_body("block", seeds, neo_hookean(1e4, 0.3, 1000), [=](const Vec3&) { return velocity; }));
  problem.time.dt = 2e-3;
  problem.time.end = 0.4;  // five cells far
  Simulation sim = simulation(problem);
  const std::vector<Real> start = sim.solver().field(0, "position").values;
  sim.run();
  const std::vector<Real> F = sim.solver().field(0, "deformation_gradient").values;
  std::vector<Real> identity;
  for (std::size_t k = 0; k < F.size(); ++k) identity.push_back(k % 9 % 4 == 0 ? 1 : 0);
  // L is a difference of equal nodal velocities over h: eps v / h dt per step, 200 steps, allowed 100 times.
  const Real bound = 100 * 200 * k_epsilon * 2 * 6 * 2e-3;
  EXPECT_LT(greatest_difference(F, identity), bound);
  EXPECT_LT(greatest_magnitude(sim.solver().field(0, "stress").values), 3e4 * bound);
  const std::vector<Real> end = sim.solver().field(0, "position").values;
  for (std::size_t k = 0; k < end.size(); ++k) {
    ASSERT_NEAR(end[k] - start[k], velocity[k % static_cast<std::size_t>(dim())] * 0.4, 200 * 10 * k_epsilon);
  }
}

TEST_P(SolverInvariants, mirror_symmetric_input_stays_mirror_symmetric) {
  Case problem = empty_case(5);
  problem.gravity = {0, -1, 0};
  problem.solver.damping = 0.5;
  problem.boundaries.push_back(make_side("bottom", BoundaryKind::slip));
  const Seeds left = jittered(lattice(dim(), {0.4, 0.05, 0.3}, {0.95, 0.6, 0.7}, {8, 8, 5}), dim(), 0.01);
  Seeds right = left;
  for (Vec3& x : right.position) x[0] = 2 - x[0];
  problem.bodies.push_back(make_body("left", left, neo_hookean(5e3, 0.3, 1000), [](const Vec3& x) { return Vec3{0.5, 0.2 * x[0], 0}; }));
  problem.bodies.push_back(make_body("right", right, neo_hookean(5e3, 0.3, 1000), [](const Vec3& x) {
    return Vec3{-0.5, 0.2 * (2 - x[0]), 0};
  }));
  problem.time.dt = 2e-3;
  problem.time.end = 0.4;
  Simulation sim = simulation(problem);
  sim.run();
  EXPECT_GT(sim.solver().totals(0).strain_energy, 0.1) << "the blocks should have collided";
  const auto components = static_cast<std::size_t>(dim());
  for (const char* name : {"position", "velocity"}) {
    const Real mirror = name[0] == 'p' ? 2 : 0;
    std::vector<Real> mirrored = sim.solver().field(1, name).values;
    for (std::size_t k = 0; k < mirrored.size(); k += components) mirrored[k] = mirror - mirrored[k];
    // Sums are taken in another order on the other side: round-off, 200 steps of about 10 eps, and a factor 10 for its growth.
    EXPECT_LT(greatest_difference(sim.solver().field(0, name).values, mirrored), 200 * 100 * k_epsilon) << name;
  }
}

TEST_P(SolverInvariants, grid_totals_are_particle_totals) {
  Simulation sim = simulation(colliding_blocks(empty_case(6)));
  const Sums before = sums_of(sim.solver());
  sim.step();
  const std::vector<Field> fields = sim.solver().grid_fields();
  ASSERT_EQ(fields[0].name, "mass");
  ASSERT_EQ(fields[1].name, "velocity");
  Real mass = 0;
  Vec3 momentum{};
  const auto components = static_cast<std::size_t>(fields[1].components);
  for (std::size_t n = 0; n < fields[0].values.size(); ++n) {
    mass += fields[0].values[n];
    for (std::size_t d = 0; d < components; ++d) momentum[d] += fields[0].values[n] * fields[1].values[n * components + d];
  }
  EXPECT_NEAR(mass, before.mass, 700 * k_epsilon * before.mass);
  for (std::size_t d = 0; d < 3; ++d) EXPECT_NEAR(momentum[d], before.momentum[d], 700 * k_epsilon * momentum_scale(sim.solver()));
}

TEST_P(SolverThreads, same_bits_for_1_2_and_3_threads) {
  const auto state_with = [&](int threads) {
    set_thread_count(threads);
    Case problem = empty_case(12);
    problem.gravity = {0.1, -2, 0};
    problem.solver.damping = 0.3;
    problem.solver.flip = 0.99;
    problem.boundaries.push_back(make_side("bottom", BoundaryKind::slip));
    // More than k_parallel_threshold particles in each body, so that threads are really used.
    const std::array<int, 3> count = dim() == 3 ? std::array{18, 12, 12} : std::array{60, 40, 1};
    const Seeds left = jittered(lattice(dim(), {0.2, 0.02, 0.2}, {0.95, 0.6, 0.7}, count), dim(), 0.004);
    const Seeds right = jittered(lattice(dim(), {1.0, 0.1, 0.2}, {1.7, 0.7, 0.7}, count), dim(), 0.004);
    problem.bodies.push_back(make_body("left", left, neo_hookean(1e4, 0.3, 1000), [](const Vec3&) { return Vec3{1, 0, 0}; }));
    problem.bodies.push_back(make_body("right", right, newtonian_fluid(1e3, 0.5, 1000), [](const Vec3&) { return Vec3{-1, 0, 0}; }));
    problem.time.end = 0.03;
    problem.time.cfl = 0.1;
    Simulation sim = simulation(problem);  // automatic time step
    sim.run();
    std::vector<Real> state{sim.time(), sim.last_dt(), static_cast<Real>(sim.step_count())};
    for (std::size_t b = 0; b < 2; ++b) {
      for (const char* name : {"position", "velocity", "stress", "deformation_gradient"}) {
        const std::vector<Real> values = sim.solver().field(b, name).values;
        state.insert(state.end(), values.begin(), values.end());
      }
      const BodyTotals totals = sim.solver().totals(b);
      state.insert(state.end(), {totals.kinetic_energy, totals.strain_energy, totals.momentum[0], totals.momentum[1]});
    }
    const Ledger& ledger = sim.solver().ledger();
    state.insert(state.end(),
                 {ledger.damping_dissipation, ledger.viscous_dissipation, ledger.boundary_impulse[1], ledger.cutoff_impulse[0]});
    return state;
  };
  const std::vector<Real> one = state_with(1);
  EXPECT_GT(one[2], 10) << "a run of a few steps would not show much";
  EXPECT_TRUE(state_with(2) == one);
  EXPECT_TRUE(state_with(3) == one);
  set_thread_count(0);
}

TEST_P(SolverInvariants, a_saved_state_goes_on_with_the_same_bits) {
  for (const char* precision : {"double", "single"}) {
    Case problem = colliding_blocks(empty_case(8));
    for (BodySpec& body : problem.bodies) body.formulation = GetParam().formulation;
    problem.solver.precision = precision;
    problem.gravity = {0, -3, 0};
    if (dim() == 3 && GetParam().transfer == Transfer::apic) problem.time.dt = 2e-4;  // light nodes again
    set_thread_count(1);
    Simulation whole(problem);
    StateTable saved;
    // Each combination is saved after another number of steps.
    const Index when = 35 + static_cast<Index>(std::hash<std::string>{}(GetParam().name()) % 20);
    for (Index k = 0; k < 100; ++k) {
      if (k == when) saved = whole.save_state();
      whole.step();
    }
    set_thread_count(3);
    Simulation second(problem);
    second.load_state(saved);
    EXPECT_EQ(second.time(), std::get<std::vector<double>>(saved.at("simulation/time"))[0]);
    while (second.step_count() < 100) second.step();
    set_thread_count(0);
    EXPECT_EQ(difference_of(whole.save_state(), second.save_state()), "");
  }
}

std::vector<Combination> combinations() {
  std::vector<Combination> all;
  for (const StressOrder order : {StressOrder::usl, StressOrder::usf, StressOrder::musl}) {
    for (const int dim : {2, 3}) {
      for (const Transfer transfer : {Transfer::flip, Transfer::pic, Transfer::apic, Transfer::tpic, Transfer::fmpm}) {
        // One text for both dimensions; 3D costs most of the time, and pic and tpic have no path of their own there.
        if (dim == 3 && (transfer == Transfer::pic || transfer == Transfer::tpic)) continue;
        all.push_back({order, dim, ShapeKind::linear, transfer});
        all.push_back({order, dim, ShapeKind::bspline2, transfer});
        // The stress orders differ in their sweeps, not in their shapes.
        const bool is_dear = dim == 3 && order != StressOrder::musl;
        if (!is_dear) all.push_back({order, dim, ShapeKind::bspline3, transfer});
        if (!is_dear) all.push_back({order, dim, ShapeKind::gimp, transfer});
        const bool fits_cpdi = order != StressOrder::usf && transfer != Transfer::apic;
        if (!is_dear && fits_cpdi) all.push_back({order, dim, ShapeKind::cpdi, transfer});
        if (transfer != Transfer::fmpm) all.push_back({order, dim, ShapeKind::linear, transfer, ContactMethod::multi_field});
        // Pairs of particles know nothing of shapes and transfers but the way to the grid.
        if (dim == 3 && (order != StressOrder::musl || transfer != Transfer::flip)) continue;
        for (const ShapeKind shape : {ShapeKind::linear, ShapeKind::bspline2}) {
          all.push_back({order, dim, shape, transfer, ContactMethod::pairs});
          if (transfer == Transfer::flip) all.push_back({order, dim, shape, transfer, ContactMethod::pairs, Formulation::total});
        }
      }
    }
  }
  return all;
}

std::vector<Combination> combinations_for_threads() {
  std::vector<Combination> some;
  for (const Combination& c : combinations()) {
    if (c.transfer == Transfer::flip || (c.transfer == Transfer::fmpm && c.shape == ShapeKind::bspline2)) some.push_back(c);
  }
  return some;
}

INSTANTIATE_TEST_SUITE_P(all, SolverThreads, testing::ValuesIn(combinations_for_threads()),
                         [](const auto& parameter) { return parameter.param.name(); });

INSTANTIATE_TEST_SUITE_P(all, SolverInvariants, testing::ValuesIn(combinations()),
                         [](const auto& parameter) { return parameter.param.name(); });

}  // namespace
}  // namespace matpoint::test
