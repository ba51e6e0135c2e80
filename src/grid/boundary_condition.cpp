#include "grid/boundary_condition.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace matpoint {
namespace {

struct Side {
  int axis;
  bool is_upper;
};

Side side_of(const std::string& name) {
  if (name == "left") return {0, false};
  if (name == "right") return {0, true};
  if (name == "bottom") return {1, false};
  if (name == "top") return {1, true};
  return {2, name == "back"};
}

}  // namespace

template <int Dim>
BoundaryConditions<Dim>::BoundaryConditions(const std::vector<BoundarySpec>& specs, const Grid<Dim>& grid) : specs_(specs) {
  std::map<std::pair<Index, int>, int> condition_at;
  for (std::size_t c = 0; c < specs_.size(); ++c) {
    const BoundarySpec& spec = specs_[c];
    const Side side = side_of(spec.side);
    bool is_component[3] = {true, true, true};
    if (spec.kind == BoundaryKind::slip) {
      for (int d = 0; d < Dim; ++d) is_component[d] = d == side.axis;
    } else if (!spec.components.empty()) {
      for (int d = 0; d < Dim; ++d) {
        is_component[d] = std::find(spec.components.begin(), spec.components.end(), std::string(1, "xyz"[d])) != spec.components.end();
      }
    }
    bool has_node = false;
    for (Index node = 0; node < grid.node_count(); ++node) {
      if (spec.region) {
        const Vec<Dim> position = grid.node_position(node);
        Vec3 x{};
        std::copy(position.begin(), position.end(), x.begin());
        if (!spec.region->contains(x)) continue;
      } else {
        const Index i = (node / grid.view().stride[side.axis]) % grid.nodes(side.axis);
        if (i != (side.is_upper ? grid.nodes(side.axis) - 1 : 0)) continue;
      }
      has_node = true;
      for (int d = 0; d < Dim; ++d) {
        if (is_component[d]) condition_at[{node, d}] = static_cast<int>(c);
      }
    }
    if (!has_node) {
      throw InputError("{}boundary {}: its region contains no node of the grid, so it would do nothing; make it at least a cell wide",
                       spec.place.empty() ? "" : spec.place + ": ", c + 1);
    }
  }
  for (const auto& [where, condition] : condition_at) constraints_.push_back({where.first, where.second, condition});
}

template <int Dim>
Vec<Dim> BoundaryConditions<Dim>::velocity(int condition, Real t) const {
  const BoundarySpec& spec = specs_[static_cast<std::size_t>(condition)];
  Vec<Dim> value{};
  if (spec.kind != BoundaryKind::velocity) return value;
  if (spec.times.empty()) {
    std::copy_n(spec.velocity.begin(), Dim, value.begin());
    return value;
  }
  // Linear between the times of the table, constant before the first and after the last.
  const auto after = std::upper_bound(spec.times.begin(), spec.times.end(), t);
  const std::size_t k = static_cast<std::size_t>(after - spec.times.begin());
  const Vec3& upper = spec.velocities[std::min(k, spec.times.size() - 1)];
  const Vec3& lower = spec.velocities[k == 0 ? 0 : k - 1];
  const bool is_between = k > 0 && k < spec.times.size();
  const Real share = is_between ? (t - spec.times[k - 1]) / (spec.times[k] - spec.times[k - 1]) : 0;
  for (std::size_t d = 0; d < Dim; ++d) value[d] = lower[d] + share * (upper[d] - lower[d]);
  return value;
}

template <int Dim>
void BoundaryConditions<Dim>::constrain(Grid<Dim>& grid, const NodalDynamics<Dim>& dynamics, Real t, Real dt, Ledger& ledger) const {
  int condition = -1;
  Vec<Dim> value{};
  for (const Constraint& constraint : constraints_) {
    if (!grid.is_row_active(constraint.node)) continue;
    if (constraint.condition != condition) value = velocity(condition = constraint.condition, t);
    const auto d = static_cast<std::size_t>(constraint.component);
    const Real* const mapped = grid.mapped(constraint.node);
    Real* const motion = grid.motion(constraint.node);
    const Real m = mapped[0];
    const bool is_booked = m > 0 && m >= dynamics.mass_cutoff && !grid.is_periodic_twin(constraint.node);
    if (is_booked) {
      const Real p = mapped[1 + d];
      const Real damping_impulse = dt * dynamics.damping * p;
      ledger.damping_impulse[d] += damping_impulse;
      ledger.damping_dissipation -= damping_impulse * motion[d];
      // FLIP particles miss dt (f + m g); the PIC share is given the momentum of the prescribed velocity instead of the node's own.
      const Real impulse = (1 - dynamics.flip) * (m * value[d] - p) - dt * (mapped[1 + Dim + d] + m * dynamics.gravity[d]);
      ledger.boundary_impulse[d] += impulse;
      ledger.boundary_work += impulse * value[d];
    }
    motion[d] = value[d];
    motion[Dim + d] = 0;
  }
}

template <int Dim>
void BoundaryConditions<Dim>::constrain_velocity(Grid<Dim>& grid, Real t) const {
  int condition = -1;
  Vec<Dim> value{};
  for (const Constraint& constraint : constraints_) {
    if (!grid.is_row_active(constraint.node)) continue;
    if (constraint.condition != condition) value = velocity(condition = constraint.condition, t);
    grid.motion(constraint.node)[constraint.component] = value[static_cast<std::size_t>(constraint.component)];
  }
}

template <int Dim>
Real BoundaryConditions<Dim>::greatest_speed() const {
  Real greatest = 0;
  for (const BoundarySpec& spec : specs_) {
    for (Real v : spec.velocity) greatest = std::max(greatest, std::abs(v));
    for (const Vec3& v : spec.velocities) {
      for (Real component : v) greatest = std::max(greatest, std::abs(component));
    }
  }
  return greatest;
}

template class BoundaryConditions<2>;
template class BoundaryConditions<3>;

}  // namespace matpoint
