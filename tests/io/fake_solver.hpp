// A solver without physics, for the tests of what only looks at a solver: particles move as x = X + V t, and every field is a formula.
#pragma once

#include <algorithm>
#include <numeric>

#include "solver/solver.hpp"

namespace matpoint::test {

class FakeSolver : public Solver {
 public:
  struct FakeBody {
    std::string name;
    std::vector<Index> ids;
    Vec3 velocity{};
  };

  /// Two bodies, "left" with 6 and "right" with 3 particles, on a grid of 4 x 3 (x 2) nodes.
  explicit FakeSolver(int dimension = 2) : dim_(dimension) {
    bodies = {{"left", std::vector<Index>(6), {1, 0.5, 0}}, {"right", std::vector<Index>(3), {-1, 0, 0}}};
    for (FakeBody& body : bodies) std::iota(body.ids.begin(), body.ids.end(), 0);
    geometry.lower = {-1, 2, dim_ == 3 ? 5.0 : 0.0};
    geometry.cell_size = {0.5, 0.25, dim_ == 3 ? 2.0 : 0.0};
    geometry.nodes = {4, 3, dim_ == 3 ? 2 : 1};
  }

  Vec3 position(std::size_t body, Index id) const {
    const FakeBody& b = bodies[body];
    const Vec3 start{0.1 * static_cast<Real>(id), static_cast<Real>(body), dim_ == 3 ? 0.01 * static_cast<Real>(id) : 0};
    return {start[0] + b.velocity[0] * time, start[1] + b.velocity[1] * time, start[2] + b.velocity[2] * time};
  }
  void remove(std::size_t body, Index id) {
    auto& ids = bodies[body].ids;
    ids.erase(std::find(ids.begin(), ids.end(), id));
  }

  int dim() const override { return dim_; }
  const GridGeometry& grid() const override { return geometry; }
  void step(Real t, Real dt) override { time = t + dt; }
  Real stable_dt() const override { return 1; }
  const std::vector<Escape>& escapes() const override { return escapes_; }
  void remove_escaped() override {}
  void declare_state(State&) override {}
  std::size_t body_count() const override { return bodies.size(); }
  const std::string& body_name(std::size_t body) const override { return bodies[body].name; }
  Index particle_count(std::size_t body) const override { return static_cast<Index>(bodies[body].ids.size()); }
  std::vector<std::string> field_names(std::size_t) const override {
    return {"position", "velocity", "stress", "deformation_gradient", "J", "id"};
  }
  void take_fields(std::size_t body, const std::vector<std::string>& names, int vector_size, std::vector<Field>& fields) const override {
    fields.clear();
    for (const std::string& name : names) fields.push_back(field_of(body, name, vector_size));
  }
  void set_field(std::size_t, const std::string&, const std::vector<Real>&) override {}
  std::vector<Field> grid_fields() const override {
    Field mass{"mass", "kg", 1, {}};
    Field velocity{"velocity", "m/s", dim_, {}};
    for (Index node = 0; node < node_count(); ++node) {
      mass.values.push_back(static_cast<Real>(node) + time);
      for (int d = 0; d < dim_; ++d) velocity.values.push_back(static_cast<Real>(10 * node + d));
    }
    return {mass, velocity};
  }
  BodyTotals totals(std::size_t body) const override {
    BodyTotals totals;
    totals.particle_count = particle_count(body);
    if (totals.particle_count == 0) return totals;
    totals.mass = 2 * static_cast<Real>(totals.particle_count);
    totals.lower = position(body, bodies[body].ids.front());
    totals.upper = position(body, bodies[body].ids.back());
    for (std::size_t d = 0; d < 3; ++d) {
      totals.momentum[d] = totals.mass * bodies[body].velocity[d];
      totals.kinetic_energy += totals.mass * bodies[body].velocity[d] * bodies[body].velocity[d] / 2;
      totals.center_of_mass[d] = (totals.lower[d] + totals.upper[d]) / 2;
    }
    totals.strain_energy = 0.25;
    totals.gravitational_energy = -0.125;
    totals.von_mises_max = 100 * static_cast<Real>(body + 1);
    totals.J_min = 0.9 - 0.1 * static_cast<Real>(body);
    totals.J_max = 1.1 + 0.1 * static_cast<Real>(body);
    return totals;
  }
  const Ledger& ledger() const override { return books; }
  const Profile& profile() const override { return profile_; }
  Index node_count() const override { return static_cast<Index>(geometry.nodes[0]) * geometry.nodes[1] * geometry.nodes[2]; }
  Index memory() const override { return 0; }
  Occupancy occupancy() const override { return {}; }

  std::vector<FakeBody> bodies;
  GridGeometry geometry;
  Ledger books;
  Real time = 0;

 private:
  Field field_of(std::size_t body, const std::string& name, int vector_size) const {
    Field field{name, name == "stress" ? "Pa" : "1", 1, {}};
    if (name == "position" || name == "velocity") field.components = vector_size;
    for (const Index id : bodies[body].ids) {
      const Vec3 x = position(body, id);
      const Vec3& v = bodies[body].velocity;
      const auto i = static_cast<Real>(id);
      std::vector<Real> values;
      if (name == "position")
        values.assign(x.begin(), x.begin() + vector_size);
      else if (name == "velocity")
        values.assign(v.begin(), v.begin() + vector_size);
      else if (name == "stress")
        values = {i + 0.1, i + 0.2, i + 0.3, i + 0.4, dim_ == 3 ? i + 0.5 : 0, dim_ == 3 ? i + 0.6 : 0};
      else if (name == "deformation_gradient")
        values = {1, i, 0, 0, 1, 0, 0, 0, 1};
      else if (name == "J")
        values = {1 + time};
      else
        values = {i};
      field.components = static_cast<int>(values.size());
      field.values.insert(field.values.end(), values.begin(), values.end());
    }
    return field;
  }
  int dim_;
  Profile profile_;
  std::vector<Escape> escapes_;
};

}  // namespace matpoint::test
