#include "grid/boundary_condition.hpp"

#include <algorithm>
#include <cmath>

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

template <int Dim>
Real dot(const Vec<Dim>& a, const Vec<Dim>& b) {
  Real sum = 0;
  for (std::size_t d = 0; d < Dim; ++d) sum += a[d] * b[d];
  return sum;
}

}  // namespace

template <int Dim>
BoundaryConditions<Dim>::BoundaryConditions(const std::vector<BoundarySpec>& specs, const Grid<Dim>& grid) : specs_(specs) {
  Directions directions;
  for (std::size_t c = 0; c < specs_.size(); ++c) {
    if (!add_nodes(grid, static_cast<int>(c), directions)) {
      const BoundarySpec& spec = specs_[c];
      throw InputError("{}boundary {}: its region contains no node of the grid, so it would do nothing; make it at least a cell wide",
                       spec.place.empty() ? "" : spec.place + ": ", c + 1);
    }
  }
  for (auto& [node, fixed] : directions) {
    for (int d = 0; d < Dim; ++d) {
      if (fixed.condition_of[d] >= 0) components_.push_back({node, d, fixed.condition_of[d]});
    }
    add_normals(node, fixed);
  }
}

template <int Dim>
bool BoundaryConditions<Dim>::add_nodes(const Grid<Dim>& grid, int condition, Directions& directions) const {
  const BoundarySpec& spec = specs_[static_cast<std::size_t>(condition)];
  const Side side = side_of(spec.side);
  bool has_node = false;
  for (Index node = 0; node < grid.node_count(); ++node) {
    const Vec<Dim> position = grid.node_position(node);
    Vec3 x{};
    std::copy(position.begin(), position.end(), x.begin());
    if (spec.region) {
      if (!spec.region->contains(x)) continue;
    } else {
      const Index i = (node / grid.view().stride[side.axis]) % grid.nodes(side.axis);
      if (i != (side.is_upper ? grid.nodes(side.axis) - 1 : 0)) continue;
    }
    has_node = true;
    const auto [entry, is_new] = directions.try_emplace(node);
    NodeDirections& fixed = entry->second;
    if (is_new) std::fill_n(fixed.condition_of, Dim, -1);
    if (spec.kind != BoundaryKind::slip) {
      for (int d = 0; d < Dim; ++d) {
        const bool is_held = spec.components.empty() ||
                             std::find(spec.components.begin(), spec.components.end(), std::string(1, "xyz"[d])) != spec.components.end();
        if (is_held) fixed.condition_of[d] = condition;
      }
    } else if (spec.region == nullptr) {
      fixed.condition_of[side.axis] = condition;
    } else {
      for (const Vec3& normal : spec.region->normals(x, Dim)) {
        int axis = -1;
        for (int d = 0; d < Dim; ++d) {
          if (std::abs(normal[static_cast<std::size_t>(d)]) > 1 - 1e-12) axis = d;
        }
        Vec<Dim> n;
        std::copy_n(normal.begin(), Dim, n.begin());
        if (axis >= 0) fixed.condition_of[axis] = condition;
        else if (dot<Dim>(n, n) > 0) fixed.normals.push_back(n);
      }
    }
  }
  return has_node;
}

template <int Dim>
void BoundaryConditions<Dim>::add_normals(Index node, NodeDirections& directions) {
  // Later conditions win: each direction keeps of itself what the components and the later directions leave free.
  std::vector<Vec<Dim>> taken;
  for (int d = 0; d < Dim; ++d) {
    if (directions.condition_of[d] < 0) continue;
    Vec<Dim> axis{};
    axis[static_cast<std::size_t>(d)] = 1;
    taken.push_back(axis);
  }
  for (auto n = directions.normals.rbegin(); n != directions.normals.rend(); ++n) {
    Vec<Dim> free = *n;
    for (const Vec<Dim>& other : taken) {
      const Real share = dot<Dim>(free, other);
      for (std::size_t d = 0; d < Dim; ++d) free[d] -= share * other[d];
    }
    const Real left = dot<Dim>(free, free);  // equals free . n
    constexpr Real k_parallel = 1e-12;       // of the square: within 1e-6 rad the direction is taken already
    if (left < k_parallel) continue;
    Vec<Dim> unit;
    Vec<Dim> correction;
    for (std::size_t d = 0; d < Dim; ++d) {
      unit[d] = free[d] / std::sqrt(left);
      correction[d] = free[d] / left;
    }
    taken.push_back(unit);
    normals_.push_back({node, *n, correction});
  }
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
  constrain_components(grid, dynamics, t, dt, ledger);
  constrain_normals(grid, dynamics, dt, ledger);
}

template <int Dim>
void BoundaryConditions<Dim>::constrain_components(Grid<Dim>& grid, const NodalDynamics<Dim>& dynamics, Real t, Real dt,
                                                   Ledger& ledger) const {
  int condition = -1;
  Vec<Dim> value{};
  for (const Component& constraint : components_) {
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
void BoundaryConditions<Dim>::constrain_normals(Grid<Dim>& grid, const NodalDynamics<Dim>& dynamics, Real dt, Ledger& ledger) const {
  for (const Normal& constraint : normals_) {
    if (!grid.is_row_active(constraint.node)) continue;
    const Real* const mapped = grid.mapped(constraint.node);
    Real* const motion = grid.motion(constraint.node);
    const Real m = mapped[0];
    Real v_n = 0;
    Real a_n = 0;
    Real p_c = 0;
    Real c_c = 0;
    for (std::size_t d = 0; d < Dim; ++d) {
      v_n += constraint.n[d] * motion[d];
      a_n += constraint.n[d] * motion[Dim + d];
      p_c += constraint.correction[d] * mapped[1 + d];
      c_c += constraint.correction[d] * constraint.correction[d];
    }
    for (std::size_t d = 0; d < Dim; ++d) {
      motion[d] -= v_n * constraint.correction[d];
      motion[Dim + d] -= a_n * constraint.correction[d];
    }
    if (m > 0 && m >= dynamics.mass_cutoff && !grid.is_periodic_twin(constraint.node)) {
      // Along c only: the damping of what other conditions hold has been taken out of the books with them.
      const Real damping_impulse = dt * dynamics.damping * p_c;
      ledger.damping_dissipation -= damping_impulse * v_n;
      // What the particles get less of: m a dt by FLIP, m v by PIC. The surface is at rest, but a moving side drives its nodes along it.
      const Real impulse = -m * (dynamics.flip * dt * a_n + (1 - dynamics.flip) * v_n) - damping_impulse / c_c;
      for (std::size_t d = 0; d < Dim; ++d) {
        ledger.damping_impulse[d] += damping_impulse / c_c * constraint.correction[d];
        ledger.boundary_impulse[d] += impulse * constraint.correction[d];
        ledger.boundary_work += impulse * constraint.correction[d] * motion[d];
      }
    }
  }
}

template <int Dim>
void BoundaryConditions<Dim>::constrain_velocity(Grid<Dim>& grid, Real t) const {
  int condition = -1;
  Vec<Dim> value{};
  for (const Component& constraint : components_) {
    if (!grid.is_row_active(constraint.node)) continue;
    if (constraint.condition != condition) value = velocity(condition = constraint.condition, t);
    grid.motion(constraint.node)[constraint.component] = value[static_cast<std::size_t>(constraint.component)];
  }
  for (const Normal& constraint : normals_) {
    if (!grid.is_row_active(constraint.node)) continue;
    Real* const motion = grid.motion(constraint.node);
    Real v_n = 0;
    for (std::size_t d = 0; d < Dim; ++d) v_n += constraint.n[d] * motion[d];
    for (std::size_t d = 0; d < Dim; ++d) motion[d] -= v_n * constraint.correction[d];
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
