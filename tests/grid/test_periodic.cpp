// Periodic sides: whatever the shape, the transfer and the order, nothing in a case sees where they are.
#include "support/solver_case.hpp"

namespace matpoint::test {
namespace {

const StressOrder k_orders[] = {StressOrder::usl, StressOrder::usf, StressOrder::musl};

struct PeriodicCase {
  int dim = 2;
  StressOrder order = StressOrder::musl;
  ShapeKind shape = ShapeKind::linear;
  Transfer transfer = Transfer::flip;
  std::string name() const {
    return fmt::format("{}d {} shape {} transfer {}", dim, order_name(order), static_cast<int>(shape), static_cast<int>(transfer));
  }
};
std::vector<PeriodicCase> periodic_cases() {
  std::vector<PeriodicCase> all;
  for (const int dim : {2, 3}) {
    for (const StressOrder order : k_orders) {
      for (const ShapeKind shape : {ShapeKind::linear, ShapeKind::bspline2, ShapeKind::bspline3, ShapeKind::gimp, ShapeKind::cpdi}) {
        for (const Transfer transfer : {Transfer::flip, Transfer::apic, Transfer::tpic, Transfer::fmpm}) {
          if (shape == ShapeKind::cpdi && (transfer == Transfer::apic || order == StressOrder::usf)) continue;
          // In 3D the shapes' and transfers' kernels are the same texts.
          if (dim == 3 && order != StressOrder::musl && transfer != Transfer::flip) continue;
          all.push_back({dim, order, shape, transfer});
        }
      }
    }
  }
  return all;
}

/// Particles that have been carried by `shift` in a periodic box of side 1.
Seeds shifted(Seeds seeds, int dim, const Vec3& shift) {
  for (Vec3& x : seeds.position) {
    for (std::size_t d = 0; d < static_cast<std::size_t>(dim); ++d) {
      x[d] += shift[d];
      x[d] -= std::floor(x[d]);
    }
  }
  return seeds;
}

/// Runs the two, of which the second is shifted; compares what has happened to their bodies. Their positions may differ by `bound`.
void expect_alike(Simulation& inside, Simulation& across, const Vec3& shift, Real bound, const std::string& name) {
  inside.run();
  across.run();
  ASSERT_EQ(inside.step_count(), across.step_count()) << name;
  const auto dim = static_cast<std::size_t>(inside.problem().dim);
  for (std::size_t body = 0; body < inside.solver().body_count(); ++body) {
    const std::vector<Real> a = inside.solver().field(body, "position").values;
    const std::vector<Real> b = across.solver().field(body, "position").values;
    Real worst = 0;
    for (std::size_t k = 0; k < a.size(); ++k) {
      const Real difference = b[k] - a[k] - shift[k % dim];
      worst = std::max(worst, std::abs(difference - std::round(difference)));
      EXPECT_GE(b[k], 0);
      EXPECT_LE(b[k], 1);
    }
    EXPECT_LT(worst, bound) << name;
    EXPECT_LT(greatest_difference(inside.solver().field(body, "velocity").values, across.solver().field(body, "velocity").values),
              10 * bound)
        << name;
  }
}

/// A spinning, vibrating block, shifted by `shift`, in a fully periodic box of side 1.
Case periodic_case(const PeriodicCase& of, const Vec3& shift) {
  const int dim = of.dim;
  Case problem = make_case(dim, {0, 0, 0}, {1, 1, dim == 3 ? 1.0 : 0.0}, {8, 8, 8});
  problem.grid.cells.resize(static_cast<std::size_t>(dim));
  problem.grid.periodic = {"x", "y"};
  if (dim == 3) problem.grid.periodic.push_back("z");
  problem.solver.stress_order = of.order;
  problem.solver.shape = of.shape;
  problem.solver.transfer = of.transfer;
  problem.solver.damping = 0.5;
  if (of.transfer == Transfer::flip) problem.solver.flip = 0.98;
  const Seeds seeds = shifted(jittered(lattice(dim, {0.3, 0.3, 0.3}, {0.7, 0.7, 0.7}, {7, 7, 7}), dim, 0.01), dim, shift);
  const auto offset = [=](Real x, std::size_t d) { return x - 0.5 - shift[d] - std::round(x - 0.5 - shift[d]); };
  problem.bodies.push_back(make_body("block", seeds, neo_hookean(1e3, 0.3, 1000), [=](const Vec3& x) {
    return Vec3{0.8 - offset(x[1], 1), 0.6 + offset(x[0], 0), dim == 3 ? 0.4 + 0.3 * offset(x[0], 0) : 0};
  }));
  problem.time.dt = 2e-3;
  problem.time.end = 0.4;
  return problem;
}

TEST(Periodic, body_across_a_periodic_side_moves_as_the_same_body_elsewhere) {
  for (const PeriodicCase& of : periodic_cases()) {
    Simulation inside(periodic_case(of, {0, 0, 0}));
    const Vec3 shift{0.5, 0.5, of.dim == 3 ? 0.5 : 0};  // four cells: on the corner at the start
    Simulation across(periodic_case(of, shift));
    // Coordinates of another size round differently: 200 steps of some eps.
    expect_alike(inside, across, shift, 200 * 100 * k_epsilon, of.name());
    EXPECT_NEAR(inside.solver().ledger().damping_dissipation, across.solver().ledger().damping_dissipation,
                1e-11 * inside.solver().ledger().damping_dissipation);
    EXPECT_LT(momentum_remainder(across), 200 * 10 * k_epsilon * momentum_scale(across.solver())) << of.name();
  }
}

TEST(Periodic, body_on_a_floor_that_lets_go_does_not_see_periodic_sides) {
  for (const PeriodicCase& of : periodic_cases()) {
    if (of.dim == 3 && of.order != StressOrder::musl) continue;
    const auto make = [&](const Vec3& shift) {
      Case problem = periodic_case(of, shift);
      problem.gravity = {1, -5, 0};
      problem.bodies.clear();
      const Seeds low = jittered(lattice(of.dim, {0.3, 0.02, 0.3}, {0.7, 0.42, 0.7}, {7, 7, 7}), of.dim, 0.01);
      problem.bodies.push_back(make_body("block", shifted(low, of.dim, shift), neo_hookean(1e4, 0.3, 1000), [](const Vec3& x) {
        return Vec3{0.8, -0.6 + 0.5 * x[1], 0};
      }));
      problem.grid.periodic = {"x"};
      if (of.dim == 3) problem.grid.periodic.push_back("z");
      BoundarySpec floor = make_side("bottom", BoundaryKind::fixed);
      floor.contact = FaceContact::friction;
      floor.friction = 0.3;
      // A pillar that stands in the way, with an image where it is cut by a side.
      BoundarySpec pillar;
      const Real left = 0.8125 + shift[0] - std::floor(0.8125 + shift[0]);
      pillar.region = std::make_shared<TestBox>(Vec3{left, -1, -9}, Vec3{left + 0.125, 0.3, 9});
      pillar.kind = BoundaryKind::fixed;
      problem.boundaries = {floor, pillar};
      return problem;
    };
    const Vec3 shift{0.25, 0, of.dim == 3 ? 0.375 : 0};
    Simulation inside(make({0, 0, 0}));
    Simulation across(make(shift));
    // What touches a surface magnifies rounding.
    expect_alike(inside, across, shift, 1e-9, of.name());
    EXPECT_NEAR(inside.solver().boundaries()[0].impulse[1], across.solver().boundaries()[0].impulse[1], 1e-9) << of.name();
    EXPECT_GT(inside.solver().boundaries()[0].impulse[1], 1) << "it should have fallen on the floor, " << of.name();
  }
}

TEST(Periodic, corrected_fluid_does_not_see_periodic_sides) {
  for (const int dim : {2, 3}) {
    for (const ShapeKind shape : {ShapeKind::bspline2, ShapeKind::bspline3, ShapeKind::gimp}) {
      const auto make = [&](const Vec3& shift) {
        Case problem = periodic_case({dim, StressOrder::musl, shape, Transfer::flip}, shift);
        problem.bodies.clear();
        problem.solver.flip = 1;
        problem.solver.damping = 0;
        problem.solver.fluid_correction = true;
        const Seeds seeds = shifted(jittered(lattice(dim, {0, 0, 0}, {1, 0.5, 1}, {16, 8, dim == 3 ? 8 : 1}), dim, 0.01), dim, shift);
        problem.bodies.push_back(make_body("water", seeds, newtonian_fluid(1e3, 0.01, 1000), [=](const Vec3& x) {
          return Vec3{1 + 0.5 * std::sin(2 * M_PI * (x[0] - shift[0])), 0.5 * std::cos(2 * M_PI * (x[1] - shift[1])), 0};
        }));
        return problem;
      };
      const Vec3 shift{0.375, 0.25, dim == 3 ? 0.125 : 0};
      Simulation inside(make({0, 0, 0}));
      Simulation across(make(shift));
      expect_alike(inside, across, shift, 1e-9, fmt::format("{}d shape {}", dim, static_cast<int>(shape)));
      EXPECT_GT(inside.solver().ledger().filter_dissipation, 0) << "it should have been corrected";
      EXPECT_NEAR(inside.solver().ledger().filter_dissipation, across.solver().ledger().filter_dissipation,
                  1e-9 * inside.solver().ledger().filter_dissipation);
    }
  }
}

TEST(Periodic, a_narrow_period_is_two_periods_side_by_side) {
  for (const PeriodicCase& of : periodic_cases()) {
    if (of.dim == 3) continue;
    const auto make = [&](int periods) {
      Case problem = make_case(2, {0, 0, 0}, {0.375 * periods, 1, 0}, {3 * periods, 8});
      problem.grid.periodic = {"x"};
      problem.gravity = {0.5, -2, 0};
      problem.solver.stress_order = of.order;
      problem.solver.shape = of.shape;
      problem.solver.transfer = of.transfer;
      const Seeds one = jittered(lattice(2, {0.02, 0.01, 0}, {0.355, 0.6, 0}, {6, 10, 1}), 2, 0.01);
      Seeds all = one;
      for (int period = 1; period < periods; ++period) {
        for (std::size_t p = 0; p < one.position.size(); ++p) {
          all.position.push_back({one.position[p][0] + 0.375, one.position[p][1], 0});
          all.volume.push_back(one.volume[p]);
        }
      }
      problem.bodies.push_back(make_body("layer", all, neo_hookean(1e3, 0.3, 1000), [](const Vec3& x) { return Vec3{x[1], 0, 0}; }));
      problem.boundaries = {make_side("bottom", BoundaryKind::fixed)};
      problem.time.dt = 2e-3;
      problem.time.end = 0.4;
      return problem;
    };
    Simulation one(make(1));
    Simulation two(make(2));
    one.run();
    two.run();
    std::vector<Real> first = two.solver().field(0, "velocity").values;
    const std::vector<Real> second(first.begin() + static_cast<std::ptrdiff_t>(first.size() / 2), first.end());
    first.resize(first.size() / 2);
    EXPECT_LT(greatest_difference(first, second), 1e-10) << of.name();
    EXPECT_LT(greatest_difference(one.solver().field(0, "velocity").values, first), 1e-10) << of.name();
    EXPECT_NEAR(2 * one.solver().boundaries()[0].impulse[0], two.solver().boundaries()[0].impulse[0], 1e-9) << of.name();
  }
}

}  // namespace
}  // namespace matpoint::test
