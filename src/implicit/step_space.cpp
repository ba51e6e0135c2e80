#include "implicit/step_space.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/error.hpp"
#include "core/parallel.hpp"

namespace matpoint {
namespace {

/// Local functions of a cell on one of its faces; those in the middle of it when `is_middle`.
std::vector<int> face_functions(int dim, int functions, int axis, bool is_upper, bool is_middle) {
  const int per_axis = functions == 1 << dim ? 2 : 3;
  std::vector<int> found;
  for (int local = 0; local < functions; ++local) {
    bool is_on = true;
    for (int d = 0, rest = local; d < dim; ++d, rest /= per_axis) {
      const int place = rest % per_axis;
      if (d == axis) is_on = is_on && place == (is_upper ? per_axis - 1 : 0);
      if (d != axis && is_middle && per_axis == 3) is_on = is_on && place == 1;
    }
    if (is_on) found.push_back(local);
  }
  return found;
}

}  // namespace

template <int Dim>
NodeConditions<Dim>::NodeConditions(const std::vector<BoundarySpec>& specs, const Basis<Dim>& basis) : specs_(specs) {
  conditions_.assign(static_cast<std::size_t>(basis.node_count() * Dim), -1);
  is_free_boundary_.assign(static_cast<std::size_t>(basis.node_count()), false);
  const std::vector<std::string> sides = side_names_of<Dim>();
  std::vector<bool> is_attached(sides.size(), false);
  for (std::size_t c = 0; c < specs_.size(); ++c) {
    const BoundarySpec& spec = specs_[c];
    if (spec.kind == BoundaryKind::traction) continue;
    if (spec.touches_by_particles()) continue;
    std::vector<Index> nodes;
    int axis = -1;
    if (spec.region) {
      const Real cell_size = basis.shortest_side();
      for (Index n = 0; n < basis.node_count(); ++n) {
        Vec3 x{};
        const Vec<Dim> position = basis.node_position(n);
        std::copy(position.begin(), position.end(), x.begin());
        if (spec.region->reaches(x, node_tolerance(x, cell_size))) nodes.push_back(n);
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
        for (const ElementFace& face : basis.side_faces(spec.side))
          receding_sides_.push_back({face, spec.receding_correction, static_cast<int>(c)});
      }
    }
    for (int d = 0; d < Dim; ++d) {
      const bool is_named = spec.components.empty() ||
                            std::find(spec.components.begin(), spec.components.end(), std::string(1, "xyz"[d])) != spec.components.end();
      if (spec.kind == BoundaryKind::slip ? d != axis : !is_named) continue;
      for (const Index n : nodes) {
        int& condition = conditions_[static_cast<std::size_t>(n * Dim + d)];
        // A side that lets go yields to the others in a corner, in any order: what they hold must stay held when it does.
        const bool yields = spec.contact != FaceContact::stick && condition >= 0 &&
                            specs_[static_cast<std::size_t>(condition)].contact == FaceContact::stick;
        if (!yields) condition = static_cast<int>(c);
      }
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
    const Vec3 v = velocity_at(spec, t).everywhere;
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
Vec<Dim> NodeConditions<Dim>::displacement_by_place(int condition, const Vec<Dim>& x, Real t, Real dt) const {
  constexpr int k_parts = 4;  // a turn by .1 in a step is then right to 1e-9 of it
  const BoundarySpec& spec = specs_[static_cast<std::size_t>(condition)];
  const Real part = dt / k_parts;
  Vec<Dim> at = x;
  for (int k = 0; k < k_parts; ++k) {
    const Real start = t + k * part;
    const auto slope = [&](const Vec<Dim>& before, Real share) {
      Vec<Dim> place = at;
      for (std::size_t d = 0; d < Dim; ++d) place[d] += share * part * before[d];
      return velocity_at(spec, start + share * part).at(place);
    };
    const Vec<Dim> first = slope({}, 0), second = slope(first, 0.5), third = slope(second, 0.5), last = slope(third, 1);
    for (std::size_t d = 0; d < Dim; ++d) at[d] += part / 6 * (first[d] + 2 * second[d] + 2 * third[d] + last[d]);
  }
  for (std::size_t d = 0; d < Dim; ++d) at[d] -= x[d];
  return at;
}

template <int Dim>
StepSpace<Dim>::StepSpace(const Basis<Dim>& basis, const NodeConditions<Dim>& conditions, std::vector<PointSource<Dim>> sources,
                          std::vector<Real> soft_stiffness, bool has_own_fields)
    : basis_(basis),
      conditions_(conditions),
      sources_(std::move(sources)),
      soft_stiffness_(std::move(soft_stiffness)),
      has_own_fields_(has_own_fields),
      functions_(basis.functions_per_cell()) {
  const auto is_fem_body = [](const PointSource<Dim>& source) { return source.fem != nullptr; };
  moves_basis_ = !has_own_fields_ && std::any_of(sources_.begin(), sources_.end(), is_fem_body) &&
                 !std::all_of(sources_.begin(), sources_.end(), is_fem_body);
  mark_fem_cells();
  find_receding_faces();
  points_.resize(sources_.size());
}

template <int Dim>
void StepSpace<Dim>::mark_fem_cells() {
  is_fem_cell_.assign(static_cast<std::size_t>(basis_.cell_count()), false);
  is_fem_node_.assign(static_cast<std::size_t>(basis_.node_count()), false);
  is_border_cell_.assign(static_cast<std::size_t>(basis_.cell_count()), false);
  for (Index cell = 0; cell < basis_.cell_count(); ++cell) {
    for (int side = 0; side < 2 * Dim; ++side)
      if (basis_.neighbour(cell, side / 2, side % 2 == 1) < 0) is_border_cell_[static_cast<std::size_t>(cell)] = true;
  }
  for (const PointSource<Dim>& source : sources_) {
    if (source.fem == nullptr) continue;
    for (const Index cell : source.fem->cells()) {
      if (is_fem_cell_[static_cast<std::size_t>(cell)]) {
        throw InputError("body \"{}\": the cell around ({:.6g}) belongs to another body of elements, too; let their regions touch only",
                         source.points->name(), fmt::join(basis_.position({cell, {}}), ", "));
      }
      is_fem_cell_[static_cast<std::size_t>(cell)] = true;
      for (int i = 0; i < functions_; ++i) is_fem_node_[static_cast<std::size_t>(basis_.cell_nodes(cell)[i])] = true;
    }
  }
}

template <int Dim>
void StepSpace<Dim>::find_receding_faces() {
  const auto add = [&](RecedingFace face) {
    if (receding_faces_.empty()) receding_faces_.resize(static_cast<std::size_t>(basis_.cell_count()));
    for (const int local : face_functions(Dim, functions_, face.face.axis, face.face.is_upper, true))
      face.nodes.push_back(basis_.cell_nodes(face.face.element)[local]);
    receding_faces_[static_cast<std::size_t>(face.face.element)].push_back(std::move(face));
  };
  for (const auto& side : conditions_.receding_sides()) add({side.face, side.correction, side.condition, 0, {}});
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    const FemBody<Dim>* const fem = sources_[s].fem;
    if (fem == nullptr || fem->receding_correction() == 0) continue;
    for (const Index cell : fem->cells()) {
      for (int side = 0; side < 2 * Dim; ++side) {
        const Index other = basis_.neighbour(cell, side / 2, side % 2 == 1);
        if (other < 0 || is_fem_cell_[static_cast<std::size_t>(other)]) continue;
        add({{other, side / 2, side % 2 == 0}, fem->receding_correction(), -1, s, {}});
      }
    }
  }
}

template <int Dim>
void StepSpace<Dim>::update(Real t) {
  locate();
  evaluate();
  correct_receding(t);
}

template <int Dim>
std::optional<ElementPoint<Dim>> StepSpace<Dim>::find(std::size_t source, std::size_t row) const {
  const Vec<Dim>& x = sources_[source].points->position[row];
  // One that moves is searched from the last place.
  if (!moves_basis_ || !has_places_) return basis_.locate(x);
  return basis_.locate_from(x, points_[source][row].element, is_fem_cell_);
}

template <int Dim>
Vec<Dim> StepSpace<Dim>::place(std::size_t active_node) const {
  const Index node = nodes_[active_node];
  Vec<Dim> x = basis_.node_position(node);
  for (std::size_t s = 0; s < sources_.size() && !moves_basis_; ++s) {
    if (sources_[s].fem == nullptr || !is_of(s, active_node) || !sources_[s].fem->has_node(node)) continue;
    for (std::size_t d = 0; d < Dim; ++d) x[d] += sources_[s].fem->displacement[static_cast<std::size_t>(node)][d];
    break;
  }
  return x;
}

template <int Dim>
void StepSpace<Dim>::forget(std::size_t source, const std::vector<Index>& rows) {
  std::vector<ElementPoint<Dim>> kept;
  std::size_t next = 0;
  for (std::size_t p = 0; p < points_[source].size(); ++p) {
    if (next < rows.size() && rows[next] == static_cast<Index>(p))
      ++next;
    else
      kept.push_back(points_[source][p]);
  }
  points_[source] = std::move(kept);
}

template <int Dim>
void StepSpace<Dim>::locate() {
  // Places by cell, and in it by body: particles of one body and cell are worked together.
  const std::size_t bodies = sources_.size();
  std::vector<Index> counts(static_cast<std::size_t>(basis_.cell_count()) * bodies, 0);
  const auto entry_of = [&](const ElementPoint<Dim>& place, std::size_t s) { return static_cast<std::size_t>(place.element) * bodies + s; };
  std::size_t n = 0;
  penetrated_count_ = 0;
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    const PointBody<Dim>& body = *sources_[s].points;
    const auto count = static_cast<std::size_t>(body.count());
    n += count;
    std::vector<ElementPoint<Dim>> places(count);
    for (std::size_t p = 0; p < count; ++p) {
      if (sources_[s].fem != nullptr) {
        places[p] = sources_[s].fem->place(p);
      } else {
        const auto found = find(s, p);
        if (!found) throw SolverError("particle {} of body \"{}\" is outside of the grid", body.id[p], body.name());
        places[p] = *found;
        if (!has_own_fields_ && is_fem_cell_[static_cast<std::size_t>(found->element)]) {
          throw InputError("body \"{}\": particle {} at ({:.6g}) is inside of a body of elements; move one of them", body.name(),
                           body.id[p], fmt::join(body.position[p], ", "));
        }
        constexpr Real k_beyond = 1.0001;
        for (const Real xi : found->xi) penetrated_count_ += std::abs(xi) > k_beyond ? 1 : 0;
      }
      ++counts[entry_of(places[p], s)];
    }
    points_[s] = std::move(places);
  }
  has_places_ = true;
  std::vector<Index> cells;
  std::vector<std::size_t> cell_source;
  std::vector<Index> next(counts.size());
  cell_begin_.clear();
  Index sum = 0;
  for (std::size_t entry = 0; entry < counts.size(); ++entry) {
    next[entry] = sum;
    if (counts[entry] == 0) continue;
    cells.push_back(static_cast<Index>(entry / bodies));
    cell_begin_.push_back(sum);
    cell_source.push_back(entry % bodies);
    sum += counts[entry];
  }
  cell_begin_.push_back(sum);
  particles_.resize(n);
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    for (std::size_t p = 0; p < points_[s].size(); ++p)
      particles_[static_cast<std::size_t>(next[entry_of(points_[s][p], s)]++)] = static_cast<Index>(p);
  }
  if (cells == cells_ && cell_source == cell_source_) return;
  cells_ = std::move(cells);
  cell_source_ = std::move(cell_source);
  number_nodes();
  set_soft_factors();
  ++pattern_;
}

template <int Dim>
void StepSpace<Dim>::release(const std::vector<bool>& released) {
  if (released == released_) return;
  released_ = released;
  number_nodes();
  ++pattern_;
}

template <int Dim>
void StepSpace<Dim>::number_nodes() {
  std::vector<int> place(static_cast<std::size_t>(slot_count()), -1);
  const auto slot_at = [&](std::size_t c, int i) {
    return static_cast<std::size_t>(slot(field_of(cell_source_[c]), basis_.cell_nodes(cells_[c])[i]));
  };
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    for (int i = 0; i < functions_; ++i) place[slot_at(c, i)] = 0;
  }
  nodes_.clear();
  slots_.clear();
  unknowns_.clear();
  unknown_count_ = 0;
  for (std::size_t n = 0; n < place.size(); ++n) {
    if (place[n] < 0) continue;
    place[n] = static_cast<int>(nodes_.size());
    slots_.push_back(static_cast<Index>(n));
    nodes_.push_back(static_cast<Index>(n) % basis_.node_count());
    for (int d = 0; d < Dim; ++d) {
      const bool is_free =
          conditions_.condition(nodes_.back(), d) < 0 || (!released_.empty() && released_[n * Dim + static_cast<std::size_t>(d)]);
      unknowns_.push_back(is_free ? unknown_count_++ : -1);
    }
  }
  cell_nodes_.clear();
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    for (int i = 0; i < functions_; ++i) cell_nodes_.push_back(place[slot_at(c, i)]);
  }
}

/// C of each cell (eq. 26): C_1 where fewer than 5 of 9 nodes are inside the body, C_2 where not all are. A node is inside when all its
/// cells hold particles and it is on no free side of the background.
template <int Dim>
void StepSpace<Dim>::set_soft_factors() {
  const auto cell_count = static_cast<std::size_t>(basis_.cell_count());
  std::vector<bool> is_active(cell_count * field_count(), false);
  for (std::size_t c = 0; c < cells_.size(); ++c)
    is_active[field_of(cell_source_[c]) * cell_count + static_cast<std::size_t>(cells_[c])] = true;
  std::vector<bool> is_outer(static_cast<std::size_t>(slot_count()), false);
  for (std::size_t f = 0; f < field_count(); ++f) {
    for (Index cell = 0; cell < basis_.cell_count(); ++cell) {
      if (is_active[f * cell_count + static_cast<std::size_t>(cell)]) continue;
      for (int i = 0; i < functions_; ++i) is_outer[static_cast<std::size_t>(slot(f, basis_.cell_nodes(cell)[i]))] = true;
    }
  }
  soft_factors_.clear();
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    const Index cell = cells_[c];
    if (is_again(c)) {  // once for each cell
      soft_factors_.push_back(0);
      continue;
    }
    int inner = 0;
    for (int i = 0; i < functions_; ++i) {
      const Index node = basis_.cell_nodes(cell)[i];
      if (!is_outer[static_cast<std::size_t>(slot(field_of(cell_source_[c]), node))] && !conditions_.is_free_boundary(node) &&
          (has_own_fields_ || !is_fem_node(node)))
        ++inner;
    }
    if (is_fem(c)) inner = functions_;
    soft_factors_.push_back(inner == functions_ ? 0 : 9 * inner < 5 * functions_ ? soft_stiffness_[0] : soft_stiffness_[1]);
  }
}

/// Gradients by the places at the start of the step from those by the undeformed ones.
template <int Dim>
void StepSpace<Dim>::pull_forward(const Real* F, Real* gradients) const {
  using Matrix = Eigen::Matrix<Real, Dim, Dim, Eigen::RowMajor>;
  const Matrix back = Eigen::Map<const Matrix>(F).inverse().transpose();
  for (int node = 0; node < functions_; ++node) {
    Eigen::Map<Eigen::Matrix<Real, Dim, 1>> g(gradients + node * Dim);
    g = (back * g).eval();
  }
}

template <int Dim>
void StepSpace<Dim>::evaluate() {
  const auto n = static_cast<Index>(particles_.size());
  const Index width = functions_ * Dim;
  N_.resize(static_cast<std::size_t>(n * functions_));
  gradients_.resize(static_cast<std::size_t>(n * width));
  parallel_for(static_cast<Index>(cells_.size()), n, [&](Index cell) {
    const auto c = static_cast<std::size_t>(cell);
    for (Index k = cell_begin_[c]; k < cell_begin_[c + 1]; ++k) {
      const auto p = static_cast<std::size_t>(particles_[static_cast<std::size_t>(k)]);
      basis_.evaluate(points_[cell_source_[c]][p], N_.data() + k * functions_, gradients_.data() + k * width);
      // The basis has not moved with the body: from grad_X N to F^-T grad_X N.
      if (!moves_basis_ && is_fem(c))
        pull_forward(sources_[cell_source_[c]].points->F.data() + p * Dim * Dim, gradients_.data() + k * width);
    }
  });
}

template <int Dim>
std::pair<Vec<Dim>, Vec<Dim>> StepSpace<Dim>::motion_of(const RecedingFace& face, const std::vector<Vec<Dim>>& velocities) const {
  const int axis = face.face.axis;
  Vec<Dim> away{};
  away[static_cast<std::size_t>(axis)] = face.face.is_upper ? -1 : 1;
  if (face.condition >= 0) return {velocities[static_cast<std::size_t>(face.condition)], away};
  Vec<Dim> velocity{};
  for (const Index node : face.nodes) {
    for (std::size_t d = 0; d < Dim; ++d)
      velocity[d] += sources_[face.source].fem->velocity[static_cast<std::size_t>(node)][d] / static_cast<Real>(face.nodes.size());
  }
  if constexpr (Dim == 2) {
    // Lower faces by the vertical velocity, as the paper has it; others by the normal of the deformed face.
    if (axis == 1 && !face.face.is_upper) return {velocity, away};
    const std::vector<int> on_face = face_functions(Dim, functions_, axis, face.face.is_upper, false);
    const Index* const nodes = basis_.cell_nodes(face.face.element);
    const Vec<Dim> first = basis_.node_position(nodes[on_face.front()]);
    const Vec<Dim> last = basis_.node_position(nodes[on_face.back()]);
    Vec<Dim> normal{first[1] - last[1], last[0] - first[0]};
    const Real length = std::hypot(normal[0], normal[1]);
    const Real sign = normal[0] * away[0] + normal[1] * away[1] < 0 ? -1 : 1;
    for (Real& component : normal) component *= sign / length;
    return {velocity, normal};
  }
  return {velocity, away};
}

/// Receding particles: the displacement of the face's row of nodes is replaced, in part, by the one with which the field has no slope
/// across the face: u_face <- (1 - C_c) u_face + C_c (4/3 u_middle - 1/3 u_far) (eq. 47 with its two indices in their right places).
template <int Dim>
void StepSpace<Dim>::correct_receding(Real t) {
  corrected_.assign(particles_.size(), -1);
  corrected_gradients_.clear();
  receding_count_ = 0;
  if (receding_faces_.empty()) return;
  const Index width = functions_ * Dim;
  const int per_axis = functions_ == 1 << Dim ? 2 : 3;
  const std::vector<Vec<Dim>> velocities = conditions_.velocities(t);
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    if (is_fem(c)) continue;
    for (const RecedingFace& face : receding_faces_[static_cast<std::size_t>(cells_[c])]) {
      const auto [wall, away] = motion_of(face, velocities);
      const std::vector<int> on_face = face_functions(Dim, functions_, face.face.axis, face.face.is_upper, false);
      const int stride = whole_power(per_axis, face.face.axis);
      const int inward = face.face.is_upper ? -stride : stride;
      for (Index k = cell_begin_[c]; k < cell_begin_[c + 1]; ++k) {
        const auto p = static_cast<std::size_t>(particles_[static_cast<std::size_t>(k)]);
        Real speed = 0;
        for (std::size_t d = 0; d < Dim; ++d) speed += (sources_[cell_source_[c]].points->velocity[p][d] - wall[d]) * away[d];
        if (!(speed > 0)) continue;
        Index& row = corrected_[static_cast<std::size_t>(k)];
        if (row < 0) {
          row = static_cast<Index>(corrected_gradients_.size()) / width;
          corrected_gradients_.insert(corrected_gradients_.end(), gradients(k), gradients(k) + width);
        }
        Real* const g = corrected_gradients_.data() + row * width;
        for (const int local : on_face) {
          for (int d = 0; d < Dim; ++d) {
            const Real taken = face.correction * g[local * Dim + d];
            g[local * Dim + d] -= taken;
            g[(local + inward) * Dim + d] += (per_axis == 2 ? 1.0 : 4.0 / 3) * taken;
            if (per_axis == 3) g[(local + 2 * inward) * Dim + d] -= 1.0 / 3 * taken;
          }
        }
      }
    }
  }
  receding_count_ = static_cast<Index>(corrected_gradients_.size()) / width;
}

template <int Dim>
void StepSpace<Dim>::declare_state(State& state) {
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    state.in(sources_[s].points->name(), [&] {
      std::vector<Index> elements;
      for (const ElementPoint<Dim>& point : points_[s]) elements.push_back(point.element);
      state.add("cell", elements);
      if (!state.is_loading()) return;
      if (elements.size() != static_cast<std::size_t>(sources_[s].points->count()))
        state.fail("cell", "has not one number for each particle");
      points_[s].clear();
      for (std::size_t p = 0; p < elements.size(); ++p) {
        if (elements[p] < 0 || elements[p] >= basis_.cell_count()) state.fail("cell", "has a cell that the grid does not have");
        points_[s].push_back({elements[p], {}});
      }
    });
  }
  if (!state.is_changed()) state.add("released", released_);
  if (!released_.empty() && released_.size() != static_cast<std::size_t>(slot_count() * Dim))
    state.fail("released", "has not one number for each node's component");
  if (!state.is_loading()) return;
  has_places_ = true;
  cells_.clear();  // so that the nodes are numbered anew
}

template class NodeConditions<2>;
template class NodeConditions<3>;
template class StepSpace<2>;
template class StepSpace<3>;

}  // namespace matpoint
