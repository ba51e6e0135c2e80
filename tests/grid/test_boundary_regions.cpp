// Conditions on nodes in regions, through the solver: oblique and round slip surfaces, obstacles, which condition wins, and the books.
//
// A slip surface takes momentum along its normal only. So the momentum of a body along an inclined plane grows by gravity alone, whatever
// happens at the plane, and the sliding block is an exact solution of the discrete equations, to round-off.
#include "support/from_toml.hpp"
#include "support/solver_case.hpp"

namespace matpoint::test {
namespace {

const StressOrder k_orders[] = {StressOrder::usl, StressOrder::usf, StressOrder::musl};

Real dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

BoundarySpec in_region(const std::string& text, int dim, BoundaryKind kind, std::vector<std::string> components = {}) {
  BoundarySpec boundary;
  boundary.region = region(text, dim);
  boundary.kind = kind;
  boundary.components = std::move(components);
  return boundary;
}
std::string half_space(const Vec3& point, const Vec3& normal, int dim) {
  const auto numbers = [&](const Vec3& a) { return fmt::format("[{}]", fmt::join(a.begin(), a.begin() + dim, ", ")); };
  return fmt::format("{{ type = 'half_space', point = {}, normal = {} }}", numbers(point), numbers(normal));
}

/// A node of the grid with what the last step left on it.
struct Node {
  Vec3 x{};
  Vec3 v{};
  Real mass = 0;
};
std::vector<Node> nodes_of(const Simulation& sim) {
  const GridGeometry geometry = sim.solver().grid();
  const std::vector<Field> fields = sim.solver().grid_fields();
  const auto dim = static_cast<std::size_t>(sim.solver().dim());
  std::vector<Node> nodes(fields[0].values.size());
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    std::size_t rest = n;
    for (std::size_t d = 0; d < dim; ++d) {
      const auto count = static_cast<std::size_t>(geometry.nodes[d]);
      nodes[n].x[d] = geometry.lower[d] + static_cast<Real>(rest % count) * geometry.cell_size[d];
      nodes[n].v[d] = fields[1].values[n * dim + d];
      rest /= count;
    }
    nodes[n].mass = fields[0].values[n];
  }
  return nodes;
}

/// An inclined plane through the origin at 30 degrees: its normal, and directions along it.
struct Incline {
  explicit Incline(int dimension) : dim(dimension) {
    // In 3D turned about the vertical axis as well, so that no component of the normal is zero.
    const Real turn = dim == 3 ? 0.4 : 0;
    normal = {std::sin(slope) * std::cos(turn), std::cos(slope), std::sin(slope) * std::sin(turn)};
    down = {std::cos(slope) * std::cos(turn), -std::sin(slope), std::cos(slope) * std::sin(turn)};
    across = {-std::sin(turn), 0, std::cos(turn)};
  }
  int dim;
  Real slope = std::acos(-1.0) / 6;
  Vec3 normal{}, down{}, across{};
};

/// A block on the incline, its lower face in the plane; the grid's axes know nothing of the plane.
Case sliding_block(const Incline& incline, StressOrder order) {
  const int dim = incline.dim;
  Case problem = make_case(dim, {-0.5, -1, dim == 3 ? -0.8 : 0}, {1.5, 1, dim == 3 ? 0.8 : 0}, {20, 20, 16});
  problem.grid.cells.resize(static_cast<std::size_t>(dim));
  problem.gravity = {0, -10, 0};
  problem.solver.stress_order = order;
  problem.solver.mass_cutoff = 0;
  Seeds seeds = lattice(dim, {-0.2, 0, -0.2}, {0.2, 0.3, 0.2}, {8, 6, 8});
  for (Vec3& x : seeds.position) {
    const Vec3 local = x;
    for (std::size_t d = 0; d < 3; ++d) x[d] = local[0] * incline.down[d] + local[1] * incline.normal[d] + local[2] * incline.across[d];
    if (dim == 2) x[2] = 0;
  }
  problem.bodies.push_back(make_body("block", seeds, neo_hookean(1e5, 0.3, 1000)));
  problem.boundaries = {in_region(half_space({0, 0, 0}, incline.normal, dim), dim, BoundaryKind::slip)};
  problem.time.dt = 5e-4;
  problem.time.end = 0.12;
  return problem;
}

TEST(InclinedPlane, block_slides_by_g_sin_a_t_squared_over_2) {
  for (const int dim : {2, 3}) {
    const Incline incline(dim);
    for (const StressOrder order : k_orders) {
      Case problem = sliding_block(incline, order);
      if (dim == 3) problem.time.end = 0.04;
      Simulation sim(problem);
      const Vec3 start = sim.solver().totals(0).center_of_mass;
      sim.run();
      const BodyTotals totals = sim.solver().totals(0);
      const Vec3 moved{totals.center_of_mass[0] - start[0], totals.center_of_mass[1] - start[1], totals.center_of_mass[2] - start[2]};
      const Real t = sim.time();
      const auto steps = static_cast<Real>(sim.step_count());
      const Real g_along = 10 * std::sin(incline.slope);
      // Momentum grows by m g sin a dt per step and moves the body in the same step: s = g sin a t^2/2 (1 + 1/n). Round-off: some eps of
      // the forces in the block, which exceed its weight by a factor of 10 at most, per step.
      EXPECT_NEAR(dot(totals.momentum, incline.down), totals.mass * g_along * t, steps * 100 * k_epsilon * totals.mass * 10 * t);
      EXPECT_NEAR(dot(moved, incline.down), g_along * t * t / 2 * (1 + 1 / steps), steps * 100 * k_epsilon);
      EXPECT_NEAR(dot(moved, incline.across), 0, steps * 100 * k_epsilon);
      // Across the plane it rests: without the plane it would have fallen 0.06 m; here it settles by less than a fifth of a cell. The run
      // in 3D is shorter than the block needs to settle.
      if (dim == 2) {
        EXPECT_LT(std::abs(dot(moved, incline.normal)), 0.02) << order_name(order);
      }
      EXPECT_LT(momentum_remainder(sim), steps * 100 * k_epsilon * totals.mass * 10 * t);
      EXPECT_NEAR(sim.solver().ledger().boundary_work, 0, 1e-12) << "the plane is at rest";
    }
  }
}

TEST(InclinedPlane, damping_and_pic_act_along_the_plane_as_in_free_space) {
  for (const int dim : {2, 3}) {
    const Incline incline(dim);
    for (const StressOrder order : k_orders) {
      Case problem = sliding_block(incline, order);
      problem.solver.damping = 3;
      problem.solver.flip = 0.9;
      problem.time.end = dim == 3 ? 0.02 : 0.12;
      Simulation sim(problem);
      sim.run();
      const BodyTotals totals = sim.solver().totals(0);
      const auto steps = static_cast<Real>(sim.step_count());
      // p <- p + dt (m g sin a - alpha p)
      Real expected = 0;
      for (Index n = 0; n < sim.step_count(); ++n) expected += 5e-4 * (totals.mass * 10 * std::sin(incline.slope) - 3 * expected);
      const Real bound = steps * 100 * k_epsilon * totals.mass * 10 * sim.time();
      EXPECT_NEAR(dot(totals.momentum, incline.down), expected, bound);
      EXPECT_LT(momentum_remainder(sim), bound);
      // The damping of the motion along the plane is booked as such, and what the plane gives is along its normal.
      const Ledger& ledger = sim.solver().ledger();
      EXPECT_NEAR(dot(ledger.boundary_impulse, incline.down), 0, bound);
      EXPECT_NEAR(dot(ledger.damping_impulse, incline.down), expected - totals.mass * 10 * std::sin(incline.slope) * sim.time(), bound);
      EXPECT_GT(dot(ledger.boundary_impulse, incline.normal),
                (dim == 2 ? 0.5 : 0.1) * totals.mass * 10 * std::cos(incline.slope) * sim.time());
    }
  }
}

TEST(InclinedPlane, nodes_behind_it_have_no_normal_velocity_and_keep_the_tangential_one) {
  for (const int dim : {2, 3}) {
    const Incline incline(dim);
    for (const StressOrder order : k_orders) {
      Case problem = sliding_block(incline, order);
      const Vec3 v0{0.7, -0.4, dim == 3 ? 0.2 : 0};
      problem.bodies[0].velocity = std::make_shared<VelocityFunction>([=](const Vec3&) { return v0; });
      problem.gravity = {};
      Simulation sim(problem);
      sim.step();
      int behind = 0, before = 0;
      for (const Node& node : nodes_of(sim)) {
        if (!(node.mass > 0)) continue;
        // One step without stress: v0 everywhere before the plane acts. The second mapping of MUSL mixes particles that the plane has
        // slowed down and others, but only in the direction of the normal. USF computes a stress first, after the plane has acted.
        if (order != StressOrder::usf) {
          EXPECT_NEAR(dot(node.v, incline.down), dot(v0, incline.down), 100 * k_epsilon);
        }
        if (dot(node.x, incline.normal) <= 0) {
          EXPECT_NEAR(dot(node.v, incline.normal), 0, 10 * k_epsilon);
          ++behind;
        } else if (order == StressOrder::usl) {
          EXPECT_NEAR(dot(node.v, incline.normal), dot(v0, incline.normal), 100 * k_epsilon);
          ++before;
        }
      }
      EXPECT_GT(behind, 4);
      EXPECT_GT(before, order == StressOrder::usl ? 4 : -1);
    }
  }
}

TEST(InclinedPlane, meeting_a_side_leaves_both_satisfied_and_the_books_closed) {
  for (const int dim : {2, 3}) {
    const Incline incline(dim);
    for (const StressOrder order : k_orders) {
      for (const bool is_side_last : {false, true}) {
        // The block slides down the plane onto the bottom of the grid.
        Case problem = sliding_block(incline, order);
        problem.grid.lower[1] = -0.1;
        problem.grid.upper[1] = 0.9;
        problem.grid.cells[1] = 10;
        problem.grid.particles_outside = OutsidePolicy::remove;
        problem.boundaries.push_back(make_side("bottom", BoundaryKind::slip));
        if (!is_side_last) std::swap(problem.boundaries[0], problem.boundaries[1]);
        problem.solver.damping = 2;
        problem.solver.flip = 0.95;
        problem.time.end = dim == 3 ? 0.02 : 0.12;
        Simulation sim(problem);
        int shared = 0;
        sim.add_callback([&](const Simulation& s) {
          if (s.step_count() % 20 != 1) return true;
          for (const Node& node : nodes_of(s)) {
            const bool is_bottom = std::abs(node.x[1] + 0.1) < 1e-9;
            const bool is_behind = dot(node.x, incline.normal) <= 0;
            if (!(node.mass > 0)) continue;
            EXPECT_LE(is_bottom ? std::abs(node.v[1]) : 0, 0);
            EXPECT_LT(is_behind ? std::abs(dot(node.v, incline.normal)) : 0, 100 * k_epsilon);
            if (is_bottom && is_behind) ++shared;
          }
          return true;
        });
        sim.run();
        EXPECT_GT(shared, 3);
        const BodyTotals totals = sim.solver().totals(0);
        EXPECT_LT(momentum_remainder(sim), static_cast<Real>(sim.step_count()) * 100 * k_epsilon * totals.mass * 10 * sim.time());
      }
    }
  }
}

TEST(InclinedPlane, nodes_that_cannot_move_are_not_damped) {
  // One particle in the lowest row of cells, all of space behind a plane at 30 degrees. The nodes on the bottom are held in both
  // directions; those above slip along the plane.
  Case problem = make_case(2, {0, 0, 0}, {1, 1, 0}, {2, 2});
  Seeds seeds;
  seeds.position = {{0.3, 0.1, 0}};
  seeds.volume = {0.01};
  const Vec3 v0{1, -2, 0};
  problem.bodies.push_back(make_body("one", seeds, neo_hookean(1, 0, 100), [=](const Vec3&) { return v0; }));
  const Incline incline(2);
  problem.boundaries = {in_region(half_space({0, 100, 0}, incline.normal, 2), 2, BoundaryKind::slip),
                        make_side("bottom", BoundaryKind::slip)};
  problem.solver.damping = 5;
  problem.solver.mass_cutoff = 0;
  problem.solver.stress_order = StressOrder::usl;
  problem.time.dt = 1e-3;
  Simulation sim(problem);
  sim.step();
  const Real mass_above = 0.1 / 0.5;  // N of the upper nodes sums to y/h; the particle has 1 kg
  const Real v_along = dot(v0, incline.down);
  const Ledger& ledger = sim.solver().ledger();
  const Real impulse = -1e-3 * 5 * mass_above * v_along;
  for (std::size_t d = 0; d < 2; ++d) EXPECT_NEAR(ledger.damping_impulse[d], impulse * incline.down[d], 100 * k_epsilon);
  EXPECT_NEAR(ledger.damping_dissipation, 1e-3 * 5 * mass_above * v_along * v_along * (1 - 1e-3 * 5), 100 * k_epsilon);
  EXPECT_LT(momentum_remainder(sim), 100 * k_epsilon);
}

TEST(InclinedPlane, meeting_a_moving_side_takes_work_from_it) {
  // The bottom moves to the right and up, the plane leads its nodes along: they can only move where both allow it. One node, held in y
  // at speed w, slips along the plane: v = (-w n_y/n_x, w). Without stress the plane pushes a resting particle by I c, c = (1/n_x, 0).
  Case problem = make_case(2, {0, 0, 0}, {1, 1, 0}, {2, 2});
  Seeds seeds;
  seeds.position = {{0.3, 0, 0}};  // on the bottom: the nodes above get nothing
  seeds.volume = {0.01};
  problem.bodies.push_back(make_body("one", seeds, neo_hookean(1, 0, 100)));
  const Incline incline(2);
  BoundarySpec moving = make_side("bottom", BoundaryKind::velocity, {"y"});
  moving.velocity = {0, 0.25};
  problem.boundaries = {in_region(half_space({0, 100, 0}, incline.normal, 2), 2, BoundaryKind::slip), moving};
  problem.solver.mass_cutoff = 0;
  problem.solver.flip = 0;
  problem.solver.stress_order = StressOrder::usl;
  problem.time.dt = 1e-3;
  Simulation sim(problem);
  sim.step();
  const Vec3 v{-0.25 * incline.normal[1] / incline.normal[0], 0.25, 0};
  const BodyTotals totals = sim.solver().totals(0);
  const Real bound = 2e-9 * 0.5;  // the nodes above get a billionth, for no particle is on a line of the grid
  for (std::size_t d = 0; d < 2; ++d) {
    EXPECT_NEAR(totals.momentum[d], v[d], bound);
    EXPECT_NEAR(sim.solver().ledger().boundary_impulse[d], v[d], bound);
  }
  // An impulse works with the velocity of the boundary, which is that of the node: here p . v with p = m v.
  EXPECT_NEAR(sim.solver().ledger().boundary_work, v[0] * v[0] + v[1] * v[1], bound);
}

TEST(RoundObstacle, takes_the_radial_velocity_of_its_nodes_and_nothing_else) {
  for (const int dim : {2, 3}) {
    Case problem = make_case(dim, {0, 0, 0}, {1, 1, dim == 3 ? 1.0 : 0.0}, {10, 10, 10});
    problem.grid.cells.resize(static_cast<std::size_t>(dim));
    const Vec3 v0{0.3, -0.5, dim == 3 ? 0.2 : 0};
    problem.bodies.push_back(make_body("all", lattice(dim, {0.05, 0.05, 0.05}, {0.95, 0.95, 0.95}, {20, 20, 20}),
                                       neo_hookean(1e3, 0.3, 1000), [=](const Vec3&) { return v0; }));
    const Vec3 center{0.5, 0.5, dim == 3 ? 0.5 : 0};
    problem.boundaries = {in_region(
        dim == 2 ? "{ type = 'disk', center = [0.5, 0.5], radius = 0.25 }" : "{ type = 'sphere', center = [0.5, 0.5, 0.5], radius = 0.25 }",
        dim, BoundaryKind::slip)};
    problem.solver.stress_order = StressOrder::usl;
    problem.time.dt = 1e-4;
    Simulation sim(problem);
    sim.step();
    int inside = 0, outside = 0;
    for (const Node& node : nodes_of(sim)) {
      if (!(node.mass > 0)) continue;
      Vec3 r{node.x[0] - center[0], node.x[1] - center[1], node.x[2] - center[2]};
      const Real distance = std::sqrt(dot(r, r));
      Vec3 expected = v0;
      if (distance < 1e-9) {
        expected = {};  // the center has no direction: it rests
      } else if (distance <= 0.25) {
        const Real v_r = dot(v0, r) / distance;
        for (std::size_t d = 0; d < 3; ++d) expected[d] = v0[d] - v_r * r[d] / distance;
      }
      for (std::size_t d = 0; d < 3; ++d)
        EXPECT_NEAR(node.v[d], expected[d], 100 * k_epsilon) << node.x[0] << " " << node.x[1] << " " << node.x[2];
      ++(distance <= 0.25 ? inside : outside);
    }
    EXPECT_EQ(inside, dim == 2 ? 21 : 81);  // lattice points with i^2 + j^2 (+ k^2) <= 6.25
    EXPECT_GT(outside, 50);
  }
}

TEST(RoundObstacle, books_close_while_a_block_is_pushed_around_it) {
  for (const StressOrder order : k_orders) {
    Case problem = make_case(2, {0, 0, 0}, {2, 1, 0}, {30, 15});
    problem.bodies.push_back(
        make_body("block", lattice(2, {0.3, 0.45, 0}, {0.7, 0.85, 0}, {12, 12, 1}), neo_hookean(2e3, 0.3, 1000), [](const Vec3&) {
          return Vec3{0.6, 0, 0};
        }));
    problem.boundaries = {in_region("{ type = 'disk', center = [1.0, 0.4], radius = 0.2 }", 2, BoundaryKind::slip)};
    problem.solver.stress_order = order;
    problem.solver.mass_cutoff_relative = 1e-3;  // USL on linear shapes
    problem.solver.damping = 0.2;
    problem.solver.flip = 0.98;
    problem.time.dt = 2e-3;
    problem.time.end = 0.9;
    Simulation sim(problem);
    sim.run();
    const BodyTotals totals = sim.solver().totals(0);
    EXPECT_GT(totals.momentum[1], 0.05 * totals.mass * 0.6) << "hit above the middle, it should be thrown up";
    EXPECT_LT(momentum_remainder(sim), 450 * 100 * k_epsilon * totals.mass * 0.6);
    EXPECT_NEAR(sim.solver().ledger().boundary_work, 0, 450 * 100 * k_epsilon * totals.mass * 0.6) << "it rests";
  }
}

/// Velocity of the nodes after one step of a body that fills the unit square (8 x 8 cells) and moves with v0.
std::vector<Node> nodes_under(const std::vector<BoundarySpec>& boundaries, const Vec3& v0) {
  Case problem = make_case(2, {0, 0, 0}, {1, 1, 0}, {8, 8});
  problem.bodies.push_back(
      make_body("all", lattice(2, {0, 0, 0}, {1, 1, 0}, {16, 16, 1}), neo_hookean(1e3, 0.3, 1000), [=](const Vec3&) { return v0; }));
  problem.boundaries = boundaries;
  problem.grid.particles_outside = OutsidePolicy::remove;
  problem.solver.stress_order = StressOrder::usl;
  problem.time.dt = 1e-4;
  Simulation sim(problem);
  sim.step();
  return nodes_of(sim);
}
Vec3 velocity_at(const std::vector<Node>& nodes, Real x, Real y) {
  for (const Node& node : nodes) {
    if (std::abs(node.x[0] - x) + std::abs(node.x[1] - y) < 1e-9) return node.v;
  }
  ADD_FAILURE() << "no node at " << x << " " << y;
  return {};
}
void expect_velocity(const Vec3& v, Real x, Real y) {
  EXPECT_NEAR(v[0], x, 100 * k_epsilon);
  EXPECT_NEAR(v[1], y, 100 * k_epsilon);
}

TEST(BoxObstacle, holds_the_normal_of_its_nearest_face_and_both_at_corners) {
  const std::vector<Node> nodes =
      nodes_under({in_region("{ type = 'box', lower = [0.25, 0.25], upper = [0.75, 0.875] }", 2, BoundaryKind::slip)}, {0.3, -0.5, 0});
  expect_velocity(velocity_at(nodes, 0.25, 0.5), 0, -0.5);    // left face
  expect_velocity(velocity_at(nodes, 0.75, 0.625), 0, -0.5);  // right
  expect_velocity(velocity_at(nodes, 0.5, 0.25), 0.3, 0);     // lower
  expect_velocity(velocity_at(nodes, 0.5, 0.875), 0.3, 0);    // upper
  for (const Real x : {0.25, 0.75}) {
    for (const Real y : {0.25, 0.875}) expect_velocity(velocity_at(nodes, x, y), 0, 0);
  }
  expect_velocity(velocity_at(nodes, 0.375, 0.375), 0, 0);   // inside, equally near to two faces
  expect_velocity(velocity_at(nodes, 0.375, 0.5), 0, -0.5);  // inside, nearest to the left face
  expect_velocity(velocity_at(nodes, 0.125, 0.5), 0.3, -0.5);
  expect_velocity(velocity_at(nodes, 0.5, 0.125), 0.3, -0.5);
}

TEST(Conditions, later_ones_win_per_component) {
  const Vec3 v0{0.3, -0.5, 0};
  BoundarySpec moving = in_region("{ type = 'box', lower = [0.25, 0.25], upper = [0.5, 0.5] }", 2, BoundaryKind::velocity);
  moving.velocity = {2, 3};
  const BoundarySpec wall = in_region("{ type = 'box', lower = [0.375, 0.25], upper = [0.75, 0.5] }", 2, BoundaryKind::fixed, {"x"});
  const std::vector<Node> wall_last = nodes_under({moving, wall}, v0);
  expect_velocity(velocity_at(wall_last, 0.25, 0.375), 2, 3);
  expect_velocity(velocity_at(wall_last, 0.375, 0.375), 0, 3);  // x is the wall's, y stays with the moving box
  expect_velocity(velocity_at(wall_last, 0.625, 0.375), 0, -0.5);
  const std::vector<Node> moving_last = nodes_under({wall, moving}, v0);
  expect_velocity(velocity_at(moving_last, 0.375, 0.375), 2, 3);
  // A slip side takes its normal component only.
  BoundarySpec all = in_region("{ type = 'box', lower = [0, 0], upper = [1, 1] }", 2, BoundaryKind::velocity);
  all.velocity = {2, 3};
  expect_velocity(velocity_at(nodes_under({all, make_side("left", BoundaryKind::slip)}, v0), 0, 0.5), 0, 3);
  expect_velocity(velocity_at(nodes_under({make_side("left", BoundaryKind::slip), all}, v0), 0, 0.5), 2, 3);
}

TEST(Conditions, two_oblique_planes_hold_a_node_and_equal_ones_count_once) {
  const std::string a = half_space({0, 0.5, 0}, {1, 2, 0}, 2), b = half_space({0, 0.5, 0}, {-1, 3, 0}, 2);
  const Vec3 v0{0.3, -0.5, 0};
  expect_velocity(velocity_at(nodes_under({in_region(a, 2, BoundaryKind::slip), in_region(b, 2, BoundaryKind::slip)}, v0), 0.125, 0.125), 0,
                  0);
  const std::vector<Node> twice = nodes_under({in_region(a, 2, BoundaryKind::slip), in_region(a, 2, BoundaryKind::slip)}, v0);
  const std::vector<Node> once = nodes_under({in_region(a, 2, BoundaryKind::slip)}, v0);
  for (std::size_t n = 0; n < once.size(); ++n) {
    for (std::size_t d = 0; d < 2; ++d) EXPECT_NEAR(twice[n].v[d], once[n].v[d], 10 * k_epsilon);
  }
  // v - (n . v) n with n = (1, 2)/sqrt 5: n . v = -0.7/sqrt 5
  expect_velocity(velocity_at(once, 0.125, 0.125), 0.3 + 0.14, -0.5 + 0.28);
}

TEST(Conditions, velocity_table_of_a_region_is_constant_outside_and_linear_between_its_times) {
  const auto table = [](Real t, Real first, Real middle, Real last) {
    if (t <= 0.1) return first;
    if (t >= 0.4) return last;
    return t < 0.2 ? first + (middle - first) * (t - 0.1) / 0.1 : middle + (last - middle) * (t - 0.2) / 0.2;
  };
  for (const StressOrder order : k_orders) {
    Case problem = make_case(2, {0, 0, 0}, {2, 2, 0}, {8, 8});
    problem.bodies.push_back(make_body("block", lattice(2, {0.5, 0.5, 0}, {1.5, 1.5, 0}, {8, 8, 1}), neo_hookean(10, 0.3, 1000)));
    BoundarySpec driven = in_region("{ type = 'disk', center = [1, 1], radius = 0.3 }", 2, BoundaryKind::velocity);
    driven.times = {0.1, 0.2, 0.4};
    driven.velocities = {{0.1, 0, 0}, {-0.2, 0.3, 0}, {0.2, 0.1, 0}};
    problem.boundaries = {driven};
    problem.solver.stress_order = order;
    problem.time.dt = 0.0125;
    problem.time.end = 0.5;
    Simulation sim(problem);
    sim.add_callback([&](const Simulation& s) {
      if (s.step_count() == 0) return true;
      for (const Node& node : nodes_of(s)) {
        if (std::hypot(node.x[0] - 1, node.x[1] - 1) > 0.3) continue;
        EXPECT_NEAR(node.v[0], table(s.time(), 0.1, -0.2, 0.2), 1e-14) << order_name(order) << " t = " << s.time();
        EXPECT_NEAR(node.v[1], table(s.time(), 0, 0.3, 0.1), 1e-14);
      }
      return true;
    });
    sim.run();
    EXPECT_LT(momentum_remainder(sim), 40 * 100 * k_epsilon * 1000 * 0.3);
  }
}

TEST(Conditions, speed_of_a_wall_limits_the_stable_step) {
  Case problem = make_case(2, {0, 0, 0}, {1, 1, 0}, {8, 8});
  problem.bodies.push_back(make_body("all", lattice(2, {0, 0, 0}, {1, 1, 0}, {16, 16, 1}), neo_hookean(10, 0.3, 1000)));
  BoundarySpec wall = make_side("left", BoundaryKind::velocity);
  wall.times = {0, 1};
  wall.velocities = {{0, 0, 0}, {0, -500, 0}};
  problem.boundaries = {wall};
  EXPECT_DOUBLE_EQ(Simulation(problem).solver().stable_dt(), 0.125 / 500);
}

TEST(Barrier, in_3d_stops_a_block_with_its_fixed_nodes) {
  Case problem = make_case(3, {0, 0, 0}, {2, 0.6, 0.6}, {20, 6, 6});
  problem.bodies.push_back(
      make_body("block", lattice(3, {0.3, 0.2, 0.2}, {0.7, 0.4, 0.4}, {8, 4, 4}), neo_hookean(2e3, 0.3, 1000), [](const Vec3&) {
        return Vec3{0.5, 0, 0};
      }));
  problem.boundaries = {in_region("{ type = 'box', lower = [0.99, -1.0, -1.0], upper = [1.31, 2.0, 2.0] }", 3, BoundaryKind::fixed)};
  problem.time.dt = 4e-3;
  problem.time.end = 1.6;
  Simulation sim(problem);
  Real farthest = 0;
  sim.add_callback([&](const Simulation& s) {
    farthest = std::max(farthest, s.solver().totals(0).upper[0]);
    return true;
  });
  sim.run();
  EXPECT_GT(farthest, 0.9) << "it should have come to the barrier's first cell";
  EXPECT_LT(farthest, 1.0) << "nodes at rest from x = 1 on cannot be passed";
  EXPECT_LT(sim.solver().totals(0).momentum[0], 0) << "it should have rebounded";
  EXPECT_LT(momentum_remainder(sim), 400 * 10 * k_epsilon * sim.solver().totals(0).mass * 0.5);
}

}  // namespace
}  // namespace matpoint::test
