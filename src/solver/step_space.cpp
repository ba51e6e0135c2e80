#include "solver/step_space.hpp"

#include <algorithm>
#include <numeric>

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "grid/boundary_condition.hpp"

namespace matpoint {

template <int Dim>
NodeConditions<Dim>::NodeConditions(const std::vector<BoundarySpec>& specs, const Basis<Dim>& basis) : specs_(specs) {
  conditions_.assign(static_cast<std::size_t>(basis.node_count() * Dim), -1);
  is_free_boundary_.assign(static_cast<std::size_t>(basis.node_count()), false);
  const std::vector<std::string> sides = side_names_of<Dim>();
  std::vector<bool> is_attached(sides.size(), false);
  for (std::size_t c = 0; c < specs_.size(); ++c) {
    const BoundarySpec& spec = specs_[c];
    std::vector<Index> nodes;
    int axis = -1;
    if (spec.region) {
      for (Index n = 0; n < basis.node_count(); ++n) {
        Vec3 x{};
        const Vec<Dim> position = basis.node_position(n);
        std::copy(position.begin(), position.end(), x.begin());
        if (spec.region->contains(x)) nodes.push_back(n);
      }
      if (nodes.empty()) {
        throw InputError("{}boundary {}: its region contains no node of the grid, so it would do nothing; make it at least a cell wide",
                         spec.place.empty() ? "" : spec.place + ": ", c + 1);
      }
    } else {
      nodes = basis.side_nodes(spec.side);
      const auto number = static_cast<std::size_t>(std::find(sides.begin(), sides.end(), spec.side) - sides.begin());
      axis = static_cast<int>(number / 2);
      if (spec.is_attached) is_attached[number] = true;
      if (spec.receding_correction > 0) {
        RecedingSide side{std::vector<bool>(static_cast<std::size_t>(basis.cell_count()), false), axis, number % 2 == 1,
                          spec.receding_correction, static_cast<int>(c)};
        for (const ElementFace& face : basis.side_faces(spec.side)) side.is_first_row[static_cast<std::size_t>(face.element)] = true;
        receding_sides_.push_back(std::move(side));
      }
    }
    for (int d = 0; d < Dim; ++d) {
      const bool is_named = spec.components.empty() ||
                            std::find(spec.components.begin(), spec.components.end(), std::string(1, "xyz"[d])) != spec.components.end();
      if (spec.kind == BoundaryKind::slip ? d != axis : !is_named) continue;
      for (const Index n : nodes) conditions_[static_cast<std::size_t>(n * Dim + d)] = static_cast<int>(c);
    }
  }
  for (std::size_t s = 0; s < sides.size(); ++s) {
    if (is_attached[s]) continue;
    for (const Index n : basis.side_nodes(sides[s])) is_free_boundary_[static_cast<std::size_t>(n)] = true;
  }
}

template <int Dim>
std::vector<Vec<Dim>> NodeConditions<Dim>::velocities(Real t) const {
  std::vector<Vec<Dim>> all;
  for (const BoundarySpec& spec : specs_) {
    const Vec3 v = velocity_at(spec, t);
    all.emplace_back();
    std::copy_n(v.begin(), Dim, all.back().begin());
  }
  return all;
}

template <int Dim>
std::vector<Vec<Dim>> NodeConditions<Dim>::displacements(Real t, Real dt) const {
  const std::vector<Vec<Dim>> start = velocities(t);
  const std::vector<Vec<Dim>> middle = velocities(t + 0.5 * dt);
  std::vector<Vec<Dim>> all = velocities(t + dt);
  for (std::size_t c = 0; c < all.size(); ++c) {
    for (std::size_t d = 0; d < Dim; ++d) all[c][d] = dt / 6 * (start[c][d] + 4 * middle[c][d] + all[c][d]);
  }
  return all;
}

template <int Dim>
StepSpace<Dim>::StepSpace(const Basis<Dim>& basis, const NodeConditions<Dim>& conditions, std::vector<Real> soft_stiffness)
    : basis_(basis), conditions_(conditions), soft_stiffness_(std::move(soft_stiffness)), functions_(basis.functions_per_cell()) {}

template <int Dim>
void StepSpace<Dim>::update(const PointBody<Dim>& body, Real t) {
  locate(body);
  evaluate(body, t);
}

template <int Dim>
void StepSpace<Dim>::locate(const PointBody<Dim>& body) {
  const auto n = static_cast<std::size_t>(body.count());
  points_.resize(n);
  std::vector<Index> counts(static_cast<std::size_t>(basis_.cell_count()) + 1, 0);
  for (std::size_t p = 0; p < n; ++p) {
    const auto found = basis_.locate(body.position[p]);
    if (!found) throw SolverError("particle {} of body \"{}\" is outside of the grid", body.id[p], body.name());
    points_[p] = *found;
    ++counts[static_cast<std::size_t>(found->element)];
  }
  std::vector<Index> cells;
  std::vector<Index> next(counts.size());
  cell_begin_.clear();
  Index sum = 0;
  for (std::size_t c = 0; c + 1 < counts.size(); ++c) {
    next[c] = sum;
    if (counts[c] == 0) continue;
    cells.push_back(static_cast<Index>(c));
    cell_begin_.push_back(sum);
    sum += counts[c];
  }
  cell_begin_.push_back(sum);
  particles_.resize(n);
  for (std::size_t p = 0; p < n; ++p)
    particles_[static_cast<std::size_t>(next[static_cast<std::size_t>(points_[p].element)]++)] = static_cast<Index>(p);
  if (cells == cells_) return;
  cells_ = std::move(cells);
  number_nodes();
  set_soft_factors();
  ++pattern_;
}

template <int Dim>
void StepSpace<Dim>::number_nodes() {
  std::vector<int> place(static_cast<std::size_t>(basis_.node_count()), -1);
  for (const Index cell : cells_) {
    for (int i = 0; i < functions_; ++i) place[static_cast<std::size_t>(basis_.cell_nodes(cell)[i])] = 0;
  }
  nodes_.clear();
  unknowns_.clear();
  unknown_count_ = 0;
  for (std::size_t n = 0; n < place.size(); ++n) {
    if (place[n] < 0) continue;
    place[n] = static_cast<int>(nodes_.size());
    nodes_.push_back(static_cast<Index>(n));
    for (int d = 0; d < Dim; ++d) unknowns_.push_back(conditions_.condition(static_cast<Index>(n), d) < 0 ? unknown_count_++ : -1);
  }
  cell_nodes_.clear();
  for (const Index cell : cells_) {
    for (int i = 0; i < functions_; ++i) cell_nodes_.push_back(place[static_cast<std::size_t>(basis_.cell_nodes(cell)[i])]);
  }
}

/// C of each cell (eq. 26): C_1 where fewer than 5 of 9 nodes are inside the body, C_2 where not all are. A node is inside when all its
/// cells hold particles and it is on no free side of the background.
template <int Dim>
void StepSpace<Dim>::set_soft_factors() {
  std::vector<bool> is_active(static_cast<std::size_t>(basis_.cell_count()), false);
  for (const Index cell : cells_) is_active[static_cast<std::size_t>(cell)] = true;
  std::vector<bool> is_outer(static_cast<std::size_t>(basis_.node_count()), false);
  for (Index cell = 0; cell < basis_.cell_count(); ++cell) {
    if (is_active[static_cast<std::size_t>(cell)]) continue;
    for (int i = 0; i < functions_; ++i) is_outer[static_cast<std::size_t>(basis_.cell_nodes(cell)[i])] = true;
  }
  soft_factors_.clear();
  for (const Index cell : cells_) {
    int inner = 0;
    for (int i = 0; i < functions_; ++i) {
      const Index node = basis_.cell_nodes(cell)[i];
      if (!is_outer[static_cast<std::size_t>(node)] && !conditions_.is_free_boundary(node)) ++inner;
    }
    soft_factors_.push_back(inner == functions_ ? 0 : 9 * inner < 5 * functions_ ? soft_stiffness_[0] : soft_stiffness_[1]);
  }
}

template <int Dim>
void StepSpace<Dim>::evaluate(const PointBody<Dim>& body, Real t) {
  const auto n = static_cast<Index>(particles_.size());
  const Index width = functions_ * Dim;
  N_.resize(static_cast<std::size_t>(n * functions_));
  gradients_.resize(static_cast<std::size_t>(n * width));
  constexpr Index k_piece = 256;
  parallel_for((n + k_piece - 1) / k_piece, n, [&](Index piece) {
    for (Index k = piece * k_piece; k < std::min(n, (piece + 1) * k_piece); ++k) {
      const auto p = static_cast<std::size_t>(particles_[static_cast<std::size_t>(k)]);
      basis_.evaluate(points_[p], N_.data() + k * functions_, gradients_.data() + k * width);
    }
  });
  // Receding particles: the displacement of the side's row of nodes is replaced, in part, by the one with which the field has no slope
  // across the side: u_side <- (1 - C_c) u_side + C_c (4/3 u_middle - 1/3 u_far) (eq. 47 with its two indices in their right places).
  corrected_.assign(static_cast<std::size_t>(n), -1);
  corrected_gradients_.clear();
  const std::vector<Vec<Dim>> velocities = conditions_.velocities(t);
  const int per_axis = functions_ == 1 << Dim ? 2 : 3;
  for (const auto& side : conditions_.receding_sides()) {
    const auto axis = static_cast<std::size_t>(side.axis);
    const Real wall = velocities[static_cast<std::size_t>(side.condition)][axis];
    for (Index k = 0; k < n; ++k) {
      const auto p = static_cast<std::size_t>(particles_[static_cast<std::size_t>(k)]);
      if (!side.is_first_row[static_cast<std::size_t>(points_[p].element)]) continue;
      const Real away = body.velocity[p][axis] - wall;
      if (!(side.is_upper ? away < 0 : away > 0)) continue;
      Index& row = corrected_[static_cast<std::size_t>(k)];
      if (row < 0) {
        row = static_cast<Index>(corrected_gradients_.size()) / width;
        corrected_gradients_.insert(corrected_gradients_.end(), gradients(k), gradients(k) + width);
      }
      Real* const g = corrected_gradients_.data() + row * width;
      const int stride = whole_power(per_axis, side.axis);
      for (int local = 0; local < functions_; ++local) {
        const int place = local / stride % per_axis;
        if (place != (side.is_upper ? per_axis - 1 : 0)) continue;
        const int inward = side.is_upper ? -stride : stride;
        for (int d = 0; d < Dim; ++d) {
          const Real taken = side.correction * g[local * Dim + d];
          g[local * Dim + d] -= taken;
          if (per_axis == 2) {
            g[(local + inward) * Dim + d] += taken;
          } else {
            g[(local + inward) * Dim + d] += 4.0 / 3 * taken;
            g[(local + 2 * inward) * Dim + d] -= 1.0 / 3 * taken;
          }
        }
      }
    }
  }
  receding_count_ = static_cast<Index>(corrected_gradients_.size()) / width;
}

template class NodeConditions<2>;
template class NodeConditions<3>;
template class StepSpace<2>;
template class StepSpace<3>;

}  // namespace matpoint
