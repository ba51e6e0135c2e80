// Cases made in C++ for the tests of the solver: particles and velocities are given point by point, so that nothing depends on the case
// reader, the regions or the layouts.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "case/case.hpp"
#include "case/case_file.hpp"
#include "run/simulation.hpp"

namespace matpoint::test {

constexpr Real k_epsilon = std::numeric_limits<Real>::epsilon();

/// A closed box; the whole space by default.
class TestBox final : public Region {
 public:
  TestBox() = default;
  TestBox(const Vec3& lower, const Vec3& upper) : lower_(lower), upper_(upper) {}
  bool contains(const Vec3& x) const override {
    for (std::size_t d = 0; d < 3; ++d) {
      if (x[d] < lower_[d] || x[d] > upper_[d]) return false;
    }
    return true;
  }
  Vec3 lower() const override { return lower_; }
  Vec3 upper() const override { return upper_; }
  std::optional<Real> measure(int) const override { return {}; }
  Input write(int) const override { return Input::table(); }

 private:
  static constexpr Real k_far = std::numeric_limits<Real>::infinity();
  Vec3 lower_{-k_far, -k_far, -k_far};
  Vec3 upper_{k_far, k_far, k_far};
};

class VelocityFunction final : public VelocityField {
 public:
  using Function = std::function<Vec3(const Vec3&)>;
  explicit VelocityFunction(Function f) : f_(std::move(f)) {}
  Vec3 at(const Vec3& x) const override { return f_(x); }
  Input write(int) const override { return Input::table(); }

 private:
  Function f_;
};

/// Of the first array that two states do not have in common, bit by bit; empty if there is none.
inline std::string difference_of(const StateTable& a, const StateTable& b) {
  for (const StateTable* one : {&a, &b}) {
    const StateTable& other = one == &a ? b : a;
    for (const auto& [name, array] : *one) {
      if (other.count(name) == 0) return name + " is not in both";
    }
  }
  for (const auto& [name, array] : a) {
    const bool is_same = std::visit(
        [&](const auto& values) {
          using Values = std::decay_t<decltype(values)>;
          const auto* const others = std::get_if<Values>(&b.at(name));
          return others != nullptr && values.size() == others->size() &&
                 std::memcmp(values.data(), others->data(), values.size() * sizeof(values[0])) == 0;
        },
        array);
    if (!is_same) return name;
  }
  return {};
}

/// A case from its text and changes to it, as with --set.
inline Case read(const std::string& text, const std::vector<std::string>& sets = {}) {
  Input input = parse_toml(text, "case.toml");
  for (const std::string& set : sets) apply_set(input, set);
  return Case::from_input(input, "case");
}

/// A number that a solver tells about its last step; nan if there is none of that name.
inline Real number_of(const Solver& solver, const std::string& name) {
  for (const StepNumber& number : solver.step_numbers()) {
    if (number.name == name) return number.value;
  }
  return std::numeric_limits<Real>::quiet_NaN();
}

/// count[0] x count[1] (x count[2]) particles in the middles of equal boxes.
inline Seeds lattice(int dim, const Vec3& lower, const Vec3& upper, const std::array<int, 3>& count) {
  Seeds seeds;
  Vec3 size{};
  Real volume = 1;
  for (std::size_t d = 0; d < static_cast<std::size_t>(dim); ++d) {
    size[d] = (upper[d] - lower[d]) / count[d];
    volume *= size[d];
  }
  for (int i = 0; i < count[0]; ++i) {
    for (int j = 0; j < count[1]; ++j) {
      for (int k = 0; k < (dim == 3 ? count[2] : 1); ++k) {
        seeds.position.push_back(
            {lower[0] + (i + 0.5) * size[0], lower[1] + (j + 0.5) * size[1], dim == 3 ? lower[2] + (k + 0.5) * size[2] : 0});
        seeds.volume.push_back(volume);
      }
    }
  }
  return seeds;
}

/// The same particles, each moved a little in its own direction: no symmetry and no rows left. `amount` [m].
inline Seeds jittered(Seeds seeds, int dim, Real amount) {
  for (std::size_t p = 0; p < seeds.position.size(); ++p) {
    for (std::size_t d = 0; d < static_cast<std::size_t>(dim); ++d) {
      seeds.position[p][d] += amount * std::sin(12.9898 * static_cast<Real>(p) + 78.233 * static_cast<Real>(d));
    }
  }
  return seeds;
}

using Values = std::vector<std::pair<std::string, Real>>;

inline std::shared_ptr<Material> material(const std::string& type, const Values& values) {
  Input table = Input::table();
  table.set("type", Input::string(type));
  for (const auto& [name, value] : values) table.set(name, Input::real(value));
  return material_registry().read(table, {2, "test"}, "material");
}

inline std::shared_ptr<Material> neo_hookean(Real youngs_modulus, Real poissons_ratio, Real density) {
  return material("neo_hookean", {{"youngs_modulus", youngs_modulus}, {"poissons_ratio", poissons_ratio}, {"density", density}});
}

inline std::shared_ptr<Material> st_venant_kirchhoff(Real youngs_modulus, Real poissons_ratio, Real density) {
  return material("st_venant_kirchhoff", {{"youngs_modulus", youngs_modulus}, {"poissons_ratio", poissons_ratio}, {"density", density}});
}

inline std::shared_ptr<Material> newtonian_fluid(Real pressure_scale, Real viscosity, Real density) {
  return material("newtonian_fluid", {{"pressure_scale", pressure_scale}, {"viscosity", viscosity}, {"density", density}, {"gamma", 7}});
}

inline Case make_case(int dim, const Vec3& lower, const Vec3& upper, const std::vector<int>& cells) {
  Case problem;
  problem.name = "test";
  problem.dim = dim;
  problem.grid.lower = lower;
  problem.grid.upper = upper;
  problem.grid.cells = cells;
  problem.time.end = 1;
  problem.solver.shape = ShapeKind::linear;
  return problem;
}

inline BodySpec make_body(const std::string& name, Seeds seeds, std::shared_ptr<Material> law, VelocityFunction::Function velocity = {}) {
  BodySpec body;
  body.name = name;
  body.region = std::make_shared<TestBox>();
  body.layout = points_layout(std::move(seeds.position), std::move(seeds.volume));
  if (velocity) body.velocity = std::make_shared<VelocityFunction>(std::move(velocity));
  body.material = std::move(law);
  return body;
}

inline BoundarySpec make_side(const std::string& side, BoundaryKind kind, std::vector<std::string> components = {}) {
  BoundarySpec boundary;
  boundary.side = side;
  boundary.kind = kind;
  boundary.components = std::move(components);
  return boundary;
}

inline std::string order_name(StressOrder order) { return order == StressOrder::usl ? "usl" : order == StressOrder::usf ? "usf" : "musl"; }

/// Sum of momentum, mass and energy over all bodies.
struct Sums {
  Real mass = 0;
  Vec3 momentum{};
  Real kinetic_energy = 0;
  Real energy = 0;
};

inline Sums sums_of(const Solver& solver) {
  Sums sums;
  for (std::size_t b = 0; b < solver.body_count(); ++b) {
    const BodyTotals totals = solver.totals(b);
    sums.mass += totals.mass;
    for (std::size_t d = 0; d < 3; ++d) sums.momentum[d] += totals.momentum[d];
    sums.kinetic_energy += totals.kinetic_energy;
    sums.energy += totals.kinetic_energy + totals.strain_energy + totals.gravitational_energy;
  }
  return sums;
}

/// With what contact stores.
inline Real whole_energy(const Solver& solver) { return sums_of(solver).energy + solver.ledger().contact_energy; }

/// Sum of m |v|: what round-off in momentum is measured by.
inline Real momentum_scale(const Solver& solver) {
  Real scale = 0;
  for (std::size_t b = 0; b < solver.body_count(); ++b) {
    const Field mass = solver.field(b, "mass");
    const Field velocity = solver.field(b, "velocity");
    const auto components = static_cast<std::size_t>(velocity.components);
    for (std::size_t k = 0; k < velocity.values.size(); ++k) scale += mass.values[k / components] * std::abs(velocity.values[k]);
  }
  return scale;
}

/// The largest absolute difference of two arrays of one length.
inline Real greatest_difference(const std::vector<Real>& a, const std::vector<Real>& b) {
  EXPECT_EQ(a.size(), b.size());
  Real greatest = 0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    // A nan differs from everything, and std::max would swallow it.
    if (!(std::abs(a[i] - b[i]) <= greatest))
      greatest = std::isnan(a[i] - b[i]) ? std::numeric_limits<Real>::infinity() : std::abs(a[i] - b[i]);
  }
  return greatest;
}

inline Real greatest_magnitude(const std::vector<Real>& a) { return greatest_difference(a, std::vector<Real>(a.size(), 0)); }

/// E0 - E - dissipated + work of the boundaries - energy of removed particles: what the transfers lost (+) or made (-) [J].
inline Real transfer_loss(const Simulation& sim) {
  return sim.initial_energy() - sums_of(sim.solver()).energy - sim.solver().ledger().energy_spent();
}

/// P - P0 - all booked impulses + removed momentum, the component of greatest magnitude [N s].
inline Real momentum_remainder(const Simulation& sim) {
  const Ledger& ledger = sim.solver().ledger();
  const Vec3 momentum = sums_of(sim.solver()).momentum;
  Real worst = 0;
  for (std::size_t d = 0; d < 3; ++d) {
    const Real expected = sim.initial_momentum()[d] + ledger.gravity_impulse[d] + ledger.boundary_impulse[d] + ledger.damping_impulse[d] +
                          ledger.body_force_impulse[d] + ledger.cutoff_impulse[d] - ledger.removed_momentum[d];
    worst = std::max(worst, std::abs(momentum[d] - expected));
  }
  return worst;
}

}  // namespace matpoint::test
