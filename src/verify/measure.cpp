#include "verify/measure.hpp"

#include <algorithm>
#include <cmath>

namespace matpoint {

Case case_from_text(const std::string& name, const std::string& text, const Sets& sets) {
  Input input = parse_toml(text, name);
  for (const std::string& set : sets) apply_set(input, set);
  const Input* const solver = input.find("solver");
  const auto has = [&](const char* key) { return solver != nullptr && solver->find(key) != nullptr; };
  const bool is_implicit = has("type") && solver->find("type")->text() == "\"implicit\"";
  // Most of these problems are about linear shapes; those that name none were measured with them. And all are about the schemes as they
  // were published.
  if (!is_implicit && !has("quality")) {
    if (!has("shape")) apply_set(input, "solver.shape=linear");
    for (const char* key : {"co_rotating", "fluid_correction"}) {
      if (!has(key)) apply_set(input, fmt::format("solver.{}=false", key));
    }
  }
  return Case::from_input(input, name);
}

Real energy(const Simulation& sim) {
  Real sum = 0;
  for (std::size_t b = 0; b < sim.solver().body_count(); ++b) {
    const BodyTotals totals = sim.solver().totals(b);
    sum += totals.kinetic_energy + totals.strain_energy + totals.gravitational_energy;
  }
  return sum;
}

Real kinetic_energy(const Simulation& sim) {
  Real sum = 0;
  for (std::size_t b = 0; b < sim.solver().body_count(); ++b) sum += sim.solver().totals(b).kinetic_energy;
  return sum;
}

Vec3 momentum(const Simulation& sim) {
  Vec3 sum{};
  for (std::size_t b = 0; b < sim.solver().body_count(); ++b) {
    const BodyTotals totals = sim.solver().totals(b);
    for (std::size_t d = 0; d < 3; ++d) sum[d] += totals.momentum[d];
  }
  return sum;
}

Real transfer_loss(const Simulation& sim) { return sim.initial_energy() - energy(sim) - sim.solver().ledger().energy_spent(); }

Real momentum_remainder(const Simulation& sim) {
  const Ledger& ledger = sim.solver().ledger();
  const Vec3 now = momentum(sim);
  Real worst = 0;
  for (std::size_t d = 0; d < 3; ++d) {
    const Real expected = sim.initial_momentum()[d] + ledger.gravity_impulse[d] + ledger.boundary_impulse[d] + ledger.damping_impulse[d] +
                          ledger.body_force_impulse[d] + ledger.cutoff_impulse[d] - ledger.removed_momentum[d];
    worst = std::max(worst, std::abs(now[d] - expected));
  }
  return worst;
}

std::vector<Real> component(const Simulation& sim, std::size_t body, const std::string& name, std::size_t c) {
  const Field field = sim.solver().field(body, name);
  std::vector<Real> values(static_cast<std::size_t>(field.count()));
  for (std::size_t p = 0; p < values.size(); ++p) values[p] = field.values[p * static_cast<std::size_t>(field.components) + c];
  return values;
}

void every(Simulation& sim, Index steps, Observer f) {
  sim.add_callback([=](const Simulation& s) {
    if (s.step_count() > 0 && s.step_count() % steps == 0) f(s);
    return true;
  });
}

void at(Simulation& sim, Real t, Observer f) {
  const Index step = std::llround(t / *sim.problem().time.dt);
  sim.add_callback([=](const Simulation& s) {
    if (s.step_count() == step) f(s);
    return true;
  });
}

Index steps_in(const Simulation& sim, Real t) { return std::max<Index>(1, std::llround(t / *sim.problem().time.dt)); }

}  // namespace matpoint
