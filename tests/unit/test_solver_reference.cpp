// The solver against a second, plain implementation (support/reference_mpm.hpp): state and books after a few hundred steps.
#include "support/reference_mpm.hpp"
#include "support/solver_case.hpp"

namespace matpoint::test {
namespace {

/// Everything that decides a comparison; both implementations are set up from it.
struct Comparison {
  std::string name;
  StressOrder order = StressOrder::usl;
  bool is_fluid = false;
  Real flip = 1;
  Real damping = 0;
  Real mass_cutoff = 1e-10;
  Real wall_speed = 0;  ///< The left side moves in x with wall_speed * (1 + t / T).
};

constexpr Real k_E = 1e4;
constexpr Real k_nu = 0.3;
constexpr Real k_kappa = 2e3;
constexpr Real k_viscosity = 8;
constexpr Real k_density = 900;
constexpr Real k_dt = 5e-4;
constexpr int k_steps = 300;
const Vec3 k_lower{-0.4, 0.2, 0};
const Vec3 k_upper{1.4, 1.45, 0};
constexpr int k_cells[2] = {6, 5};
const Vec3 k_gravity{0.4, -3, 0};

Vec3 start_velocity(const Vec3& x) { return {0.3 - 0.5 * x[1] + 0.1 * x[0], -0.2 + 0.4 * x[0], 0}; }
Seeds start_seeds() { return jittered(lattice(2, {-0.35, 0.25, 0}, {0.75, 1.05, 0}, {11, 8, 1}), 2, 0.012); }

Case solver_case(const Comparison& c) {
  Case problem = make_case(2, k_lower, k_upper, {k_cells[0], k_cells[1]});
  problem.gravity = k_gravity;
  auto law = c.is_fluid ? newtonian_fluid(k_kappa, k_viscosity, k_density) : neo_hookean(k_E, k_nu, k_density);
  problem.bodies.push_back(make_body("block", start_seeds(), law, start_velocity));
  problem.boundaries.push_back(make_side("bottom", BoundaryKind::fixed));
  problem.boundaries.push_back(make_side("right", BoundaryKind::slip));
  BoundarySpec wall = make_side("left", BoundaryKind::velocity, {"x"});
  wall.times = {0, k_dt * k_steps};
  wall.velocities = {{c.wall_speed, 0, 0}, {2 * c.wall_speed, 0, 0}};
  problem.boundaries.push_back(wall);
  problem.solver.stress_order = c.order;
  problem.solver.flip = c.flip;
  problem.solver.damping = c.damping;
  problem.solver.mass_cutoff = c.mass_cutoff;
  problem.time.dt = k_dt;
  problem.time.end = k_dt * k_steps;
  return problem;
}

ReferenceMpm reference(const Comparison& c) {
  ReferenceMpm mpm;
  mpm.order = c.order;
  for (std::size_t d = 0; d < 2; ++d) {
    mpm.lower[d] = k_lower[d];
    mpm.cells[d] = k_cells[d];
    mpm.h[d] = (k_upper[d] - k_lower[d]) / k_cells[d];
    mpm.gravity[d] = k_gravity[d];
  }
  mpm.damping = c.damping;
  mpm.flip = c.flip;
  mpm.mass_cutoff = c.mass_cutoff;
  mpm.laws.push_back(c.is_fluid ? reference_newtonian_fluid(k_kappa, 7, k_viscosity) : reference_neo_hookean(k_E, k_nu));
  const Seeds seeds = start_seeds();
  for (std::size_t p = 0; p < seeds.position.size(); ++p) {
    ReferenceParticle particle;
    const Vec3 v = start_velocity(seeds.position[p]);
    for (std::size_t d = 0; d < 2; ++d) {
      particle.x[d] = seeds.position[p][d];
      particle.v[d] = v[d];
    }
    particle.V0 = seeds.volume[p];
    particle.mass = k_density * seeds.volume[p];
    mpm.particles.push_back(particle);
  }
  const auto rest = [](Real) { return Real{0}; };
  const int nx = k_cells[0] + 1;
  for (int i = 0; i < nx; ++i) {
    mpm.constraints.push_back({i, 0, rest});
    mpm.constraints.push_back({i, 1, rest});
  }
  const auto wall = [=](Real t) { return c.wall_speed * (1 + t / (k_dt * k_steps)); };
  for (int j = 0; j <= k_cells[1]; ++j) {
    mpm.constraints.push_back({j * nx + nx - 1, 0, rest});
    mpm.constraints.push_back({j * nx, 0, wall});
  }
  return mpm;
}

class SolverAgainstReference : public testing::TestWithParam<Comparison> {};

TEST_P(SolverAgainstReference, same_state_and_books) {
  const Comparison& c = GetParam();
  Simulation sim(solver_case(c));
  ReferenceMpm mpm = reference(c);
  for (int n = 0; n < k_steps; ++n) {
    sim.step();
    mpm.step(n * k_dt, k_dt);
  }
  std::vector<Real> x, v, F, sigma;
  for (const ReferenceParticle& p : mpm.particles) {
    x.insert(x.end(), p.x, p.x + 2);
    v.insert(v.end(), p.v, p.v + 2);
    F.insert(F.end(), {p.F[0][0], p.F[0][1], 0, p.F[1][0], p.F[1][1], 0, 0, 0, 1});
    sigma.insert(sigma.end(), {p.sigma[0][0], p.sigma[1][1], p.sigma[0][1]});
  }
  std::vector<Real> solver_sigma;
  const Field stress = sim.solver().field(0, "stress");
  for (std::size_t p = 0; p < static_cast<std::size_t>(stress.count()); ++p) {
    const Real* s = &stress.values[p * static_cast<std::size_t>(stress.components)];
    solver_sigma.insert(solver_sigma.end(), {s[0], s[1], s[3]});
  }
  // Round-off of 300 steps, each about 10 eps of the quantity's size, that the elastic motion passes on without amplifying: 1e-12.
  EXPECT_LT(greatest_difference(sim.solver().field(0, "position").values, x), 1e-12);
  EXPECT_LT(greatest_difference(sim.solver().field(0, "velocity").values, v), 1e-12 * std::max(1.0, greatest_magnitude(v)));
  EXPECT_LT(greatest_difference(sim.solver().field(0, "deformation_gradient").values, F), 1e-12 * greatest_magnitude(F));
  // Stress is stiffness times strain: the strain's error comes out multiplied by the stiffness.
  EXPECT_LT(greatest_difference(solver_sigma, sigma), 1e-12 * (c.is_fluid ? 7 * k_kappa + k_viscosity / k_dt : k_E));
  EXPECT_GT(greatest_magnitude(sigma), 100) << "the comparison is only worth something with stresses in it";

  const Ledger& ledger = sim.solver().ledger();
  EXPECT_NEAR(ledger.damping_dissipation, mpm.damping_dissipation, 1e-12 * std::max(1.0, mpm.damping_dissipation));
  EXPECT_NEAR(ledger.viscous_dissipation, mpm.viscous_dissipation, 1e-12 * std::max(1.0, mpm.viscous_dissipation));
  if (c.damping > 0) {
    EXPECT_GT(mpm.damping_dissipation, 1);
  }
  if (c.is_fluid) {
    EXPECT_GT(mpm.viscous_dissipation, 0.1);
  }
}

std::vector<Comparison> comparisons() {
  std::vector<Comparison> all;
  for (const StressOrder order : {StressOrder::usl, StressOrder::usf, StressOrder::musl}) {
    const std::string name = order_name(order);
    all.push_back({name + "_solid", order, false, 1, 0, 1e-10, 0});
    all.push_back({name + "_solid_damped_blend_moving_wall", order, false, 0.97, 4, 1e-10, 0.2});
    all.push_back({name + "_fluid", order, true, 1, 0, 1e-10, 0});
    all.push_back({name + "_fluid_damped_cutoff", order, true, 0.99, 2, 0.9, 0.1});  // 0.9 kg: a tenth of a particle
  }
  return all;
}

INSTANTIATE_TEST_SUITE_P(all, SolverAgainstReference, testing::ValuesIn(comparisons()),
                         [](const auto& parameter) { return parameter.param.name; });

}  // namespace
}  // namespace matpoint::test
