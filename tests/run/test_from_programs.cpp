// What programs can do to a simulation beside what a case file says: assign fields, body forces, boundary values and laws as functions.
#include <gtest/gtest.h>

#include <cmath>

#include "material/function_material.hpp"
#include "run/simulation.hpp"
#include "support/from_toml.hpp"
#include "support/solver_case.hpp"

namespace matpoint::test {
namespace {

struct Variant {
  int dim;
  std::string precision;
  StressOrder order;
};

/// Two jittered blocks that fly apart, in a box.
Case blocks(const Variant& variant) {
  const Real depth = variant.dim == 3 ? 1 : 0;
  Case problem = make_case(variant.dim, {}, {1, 1, depth}, std::vector<int>(static_cast<std::size_t>(variant.dim), 8));
  problem.grid.cell_size.assign(static_cast<std::size_t>(variant.dim), 0.125);
  problem.solver.precision = variant.precision;
  problem.solver.stress_order = variant.order;
  problem.solver.mass_cutoff_relative = 1e-3;  // USL on linear shapes
  problem.time.dt = 1e-3;
  const Seeds seeds = jittered(lattice(variant.dim, {0.25, 0.25, 0.25}, {0.75, 0.75, 0.75}, {8, 8, 8}), variant.dim, 0.01);
  problem.bodies.push_back(make_body("block", seeds, neo_hookean(1e5, 0.3, 1000), [](const Vec3& x) {
    return Vec3{0.5 * (x[0] - 0.5), 0.3 - 0.2 * x[1], 0};
  }));
  return problem;
}

Real tolerance(const Variant& variant) { return variant.precision == "double" ? 1e-12 : 2e-5; }

void expect_near(const std::vector<Real>& a, const std::vector<Real>& b, Real bound) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) ASSERT_NEAR(a[i], b[i], bound) << i;
}

class FromPrograms : public testing::TestWithParam<Variant> {};

INSTANTIATE_TEST_SUITE_P(All, FromPrograms,
                         testing::Values(Variant{2, "double", StressOrder::usl}, Variant{2, "double", StressOrder::usf},
                                         Variant{2, "single", StressOrder::musl}, Variant{3, "double", StressOrder::musl},
                                         Variant{3, "single", StressOrder::usl}),
                         [](const auto& variant) {
                           const char* order = variant.param.order == StressOrder::usl   ? "usl"
                                               : variant.param.order == StressOrder::usf ? "usf"
                                                                                         : "musl";
                           return fmt::format("dim_{}_{}_{}", variant.param.dim, variant.param.precision, order);
                         });

TEST_P(FromPrograms, assigning_what_was_read_changes_nothing) {
  Simulation touched(blocks(GetParam())), alone(blocks(GetParam()));
  for (int k = 0; k < 6; ++k) {
    touched.step();
    alone.step();
    for (const char* name : {"velocity", "deformation_gradient", "position"}) {
      touched.set_field(0, name, touched.solver().field(0, name).values);
    }
  }
  // Sums over the particles of a cell come in another order, for the assigned positions put them there anew.
  for (const char* name : {"position", "velocity", "deformation_gradient"}) {
    expect_near(touched.solver().field(0, name).values, alone.solver().field(0, name).values, tolerance(GetParam()));
  }
  EXPECT_NEAR(touched.initial_energy(), alone.initial_energy(), 1e-6 * alone.initial_energy());
}

TEST_P(FromPrograms, fields_taken_together_are_those_taken_alone) {
  Simulation simulation(blocks(GetParam()));
  for (int k = 0; k < 4; ++k) simulation.step();
  const Solver& solver = simulation.solver();
  const std::vector<std::string> names = solver.field_names(0);
  std::vector<Field> together;
  solver.take_fields(0, names, 3, together);
  ASSERT_EQ(together.size(), names.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    const Field alone = solver.field(0, names[i]);
    EXPECT_EQ(together[i].name, names[i]);
    EXPECT_EQ(together[i].unit, alone.unit);
    const bool is_vector = names[i] == "position" || names[i] == "velocity";
    EXPECT_EQ(together[i].components, is_vector ? 3 : alone.components);
    const auto padded = static_cast<std::size_t>(together[i].components);
    const auto components = static_cast<std::size_t>(alone.components);
    ASSERT_EQ(together[i].values.size() / padded, alone.values.size() / components);
    for (std::size_t k = 0; k < together[i].values.size(); ++k) {
      const std::size_t c = k % padded;
      ASSERT_EQ(together[i].values[k], c < components ? alone.values[k / padded * components + c] : 0) << names[i] << " " << k;
    }
  }
  const Real* const memory = together[0].values.data();
  solver.take_fields(0, names, 3, together);
  EXPECT_EQ(together[0].values.data(), memory);
}

// Fields take the stress from the kernel of the law, a slot at a time; here it is evaluated particle by particle.
TEST_P(FromPrograms, stresses_are_those_of_the_law_at_the_deformation) {
  const Case problem = blocks(GetParam());
  Simulation simulation(problem);
  for (int k = 0; k < 20; ++k) simulation.step();
  const std::vector<Real> F = simulation.solver().field(0, "deformation_gradient").values;
  const std::vector<Real> J = simulation.solver().field(0, "J").values;
  const std::vector<Real> stress = simulation.solver().field(0, "stress").values;
  for (std::size_t p = 0; p < J.size(); ++p) {
    Material::Matrix one;
    std::copy_n(F.begin() + static_cast<std::ptrdiff_t>(9 * p), 9, one.begin());
    const Material::Matrix tau = problem.bodies[0].material->kirchhoff_stress(one);
    const Real expected[6] = {tau[0], tau[4], tau[8], tau[1], tau[5], tau[2]};
    for (std::size_t s = 0; s < 6; ++s) ASSERT_NEAR(stress[6 * p + s], expected[s] / J[p], 1e5 * tolerance(GetParam())) << p << " " << s;
  }
}

TEST_P(FromPrograms, assigned_positions_are_found_in_their_new_cells) {
  Simulation simulation(blocks(GetParam()));
  simulation.step();
  std::vector<Real> target = simulation.solver().field(0, "position").values;
  for (std::size_t i = 0; i < target.size(); ++i) target[i] = 0.5 + 0.49 * std::sin(static_cast<Real>(i));
  target[0] = 1;  // on the far side
  simulation.set_field(0, "position", target);
  // One on a line of the grid is kept off it by a billionth (in single precision a millionth) of a cell.
  target[0] -= simulation.solver().grid().cell_size[0] * (GetParam().precision == std::string("double") ? 1e-9 : 1e-6);
  expect_near(simulation.solver().field(0, "position").values, target, tolerance(GetParam()));
  const std::vector<Real> ids = simulation.solver().field(0, "id").values;
  for (std::size_t p = 0; p < ids.size(); ++p) EXPECT_EQ(ids[p], static_cast<Real>(p));
  const Real mass = simulation.solver().totals(0).mass;
  simulation.step();
  Real nodal = 0;
  const std::vector<Field> fields = simulation.solver().grid_fields();
  for (const Real m : fields[0].values) nodal += m;
  EXPECT_NEAR(nodal, mass, tolerance(GetParam()) * mass);
}

TEST_P(FromPrograms, stable_step_follows_assigned_speed_and_compression) {
  Simulation simulation(blocks(GetParam()));
  const Real before = simulation.solver().stable_dt();
  std::vector<Real> v = simulation.solver().field(0, "velocity").values;
  for (Real& component : v) component = 100;
  simulation.set_field(0, "velocity", v);
  EXPECT_LT(simulation.solver().stable_dt(), 0.2 * before);
  for (Real& component : v) component = 0;
  simulation.set_field(0, "velocity", v);
  const Real at_rest = simulation.solver().stable_dt();
  std::vector<Real> F = simulation.solver().field(0, "deformation_gradient").values;
  for (std::size_t i = 0; i < F.size(); i += 9) F[i] = 0.2;
  simulation.set_field(0, "deformation_gradient", F);
  EXPECT_LT(simulation.solver().stable_dt(), at_rest);
}

TEST_P(FromPrograms, uniform_body_force_is_gravity_and_is_booked) {
  Case heavy = blocks(GetParam()), forced = blocks(GetParam());
  heavy.gravity = {0, -9.81, 0};
  const auto dim = static_cast<std::size_t>(GetParam().dim);
  forced.body_force = std::make_shared<BodyForce>();
  forced.body_force->is_constant = true;
  forced.body_force->at = [dim](Real, const std::vector<Real>&, std::vector<Real>& values) {
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = i % dim == 1 ? -9.81 : 0;
  };
  Simulation a(heavy), b(forced);
  for (int k = 0; k < 10; ++k) {
    a.step();
    b.step();
  }
  expect_near(a.solver().field(0, "velocity").values, b.solver().field(0, "velocity").values, 10 * tolerance(GetParam()));
  const Real weight = 9.81 * b.solver().totals(0).mass * 0.01;
  EXPECT_NEAR(b.solver().ledger().body_force_impulse[1], -weight, tolerance(GetParam()) * weight);
  // A uniform force works on the whole momentum, which it changes evenly.
  Real work = 0;
  for (int k = 0; k < 10; ++k) work += -9.81 * 1e-3 * (b.initial_momentum()[1] - weight * (k + 0.5) / 10);
  EXPECT_NEAR(b.solver().ledger().body_force_work, work, 10 * tolerance(GetParam()) * std::abs(work));
}

TEST_P(FromPrograms, law_given_as_a_function_is_the_same_law) {
  Case core = blocks(GetParam());
  core.boundaries.push_back(make_side("bottom", BoundaryKind::fixed));
  Case function = core;
  const auto law = core.bodies[0].material;
  function.bodies[0].material = std::make_shared<FunctionMaterial>(
      "test",
      [law](const MaterialPoints& points) {
        for (Index p = 0; p < points.count; ++p) {
          Material::Matrix F;
          std::copy_n(points.F + 9 * p, 9, F.begin());
          const Material::Matrix tau = law->kirchhoff_stress(F);
          std::copy_n(tau.begin(), 9, points.tau + 9 * p);
          points.history[p] += 1;
        }
      },
      1000, 13, 0, 1);
  Simulation a(core), b(function);
  for (int k = 0; k < 10; ++k) {
    a.step();
    b.step();
  }
  expect_near(a.solver().field(0, "velocity").values, b.solver().field(0, "velocity").values, 10 * tolerance(GetParam()));
  const std::vector<Real> stress = a.solver().field(0, "stress").values;
  expect_near(stress, b.solver().field(0, "stress").values, 1e5 * tolerance(GetParam()));
}

TEST(FromProgramsAlone, what_a_function_throws_ends_the_step_and_there_is_no_next_one) {
  Case problem = blocks({2, "double", StressOrder::usl});
  bool fails = false;
  problem.bodies[0].material = std::make_shared<FunctionMaterial>(
      "test",
      [&fails](const MaterialPoints& points) {
        if (fails) throw std::domain_error("told by the law");
        std::fill_n(points.tau, 9 * points.count, Real{0});
      },
      1000, 10, 0, 0);
  Simulation simulation(problem);
  simulation.step();
  fails = true;
  EXPECT_THROW(simulation.step(), std::domain_error);
  const std::vector<Real> x = simulation.solver().field(0, "position").values;
  EXPECT_TRUE(std::all_of(x.begin(), x.end(), [](Real value) { return value > 0.2; }));
  fails = false;
  EXPECT_THROW(simulation.step(), SolverError);
  EXPECT_THROW(simulation.set_field(0, "position", x), SolverError);
  fails = true;
  EXPECT_THROW(Simulation{problem}, std::domain_error);
}

TEST(FromProgramsAlone, boundary_velocity_given_as_a_function_is_the_table) {
  Case table = blocks({2, "double", StressOrder::musl});
  BoundarySpec wall = make_side("bottom", BoundaryKind::velocity);
  wall.times = {0, 1};
  wall.velocities = {{0, 0, 0}, {0.5, 2, 0}};
  table.bodies[0] = make_body("block", lattice(2, {0.25, 0, 0}, {0.75, 0.5, 0}, {8, 8, 1}), neo_hookean(1e5, 0.3, 1000));
  Case function = table;
  table.boundaries.push_back(wall);
  BoundarySpec moving = make_side("bottom", BoundaryKind::velocity);
  moving.velocity_history = std::make_shared<VelocityHistory>();
  moving.velocity_history->at = [](Real t) { return Vec3{0.5 * t, 2 * t, 0}; };
  function.boundaries.push_back(moving);
  Simulation a(table), b(function);
  for (int k = 0; k < 20; ++k) {
    a.step();
    b.step();
  }
  EXPECT_GT(a.solver().ledger().boundary_work, 0);
  expect_near(a.solver().field(0, "velocity").values, b.solver().field(0, "velocity").values, 1e-13);
}

TEST(FromProgramsAlone, wrong_values_are_refused_and_change_nothing) {
  Simulation simulation(blocks({2, "double", StressOrder::usl}));
  const auto complaint = [&](const std::string& name, std::vector<Real> values) {
    return complaint_of([&] { simulation.set_field(0, name, values); });
  };
  const std::vector<Real> x = simulation.solver().field(0, "position").values;
  EXPECT_NE(complaint("position", {1, 2}).find("needs 2 numbers for each of its 64 particles, got 2 numbers"), std::string::npos);
  std::vector<Real> wrong = x;
  wrong[5] = std::numeric_limits<Real>::quiet_NaN();
  EXPECT_NE(complaint("position", wrong).find("particle row 2 is not finite"), std::string::npos);
  wrong[5] = 1.5;
  EXPECT_NE(complaint("position", wrong).find("particle row 2 is outside of the grid: y = 1.5, allowed: 0 to 1"), std::string::npos);
  EXPECT_NE(complaint("pressure", {}).find("assign stress, which the material is brought to, or deformation_gradient"), std::string::npos);
  EXPECT_NE(complaint("velocty", {}).find("did you mean \"velocity\""), std::string::npos);
  std::vector<Real> F = simulation.solver().field(0, "deformation_gradient").values;
  F[9] = -1;
  EXPECT_NE(complaint("deformation_gradient", F).find("particle row 1 has the determinant -1"), std::string::npos);
  EXPECT_EQ(simulation.solver().field(0, "position").values, x);
  EXPECT_THROW(FunctionMaterial("law", {}, 0, 1, 0, 0), InputError);
  EXPECT_THROW(FunctionMaterial("law", {}, 1, 0, 0, 0), InputError);
}

}  // namespace
}  // namespace matpoint::test
