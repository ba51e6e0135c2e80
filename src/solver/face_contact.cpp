#include "solver/face_contact.hpp"

#include <algorithm>
#include <cmath>

namespace matpoint {
namespace {

// Of one step: sets that are tried, and changes of a node, after which it stays as it is, so that no two sets alternate for ever.
constexpr int k_sets_max = 10;
constexpr int k_changes_max = 3;
// A reaction that pulls by less than this share of the greatest, and a displacement into the face of less than this [m], are rounding.
constexpr Real k_pull = 1e-10;
constexpr Real k_into = 1e-14;

}  // namespace

template <int Dim>
FaceContacts<Dim>::FaceContacts(const std::vector<BoundarySpec>& specs, const Basis<Dim>& basis, const NodeConditions<Dim>& conditions)
    : conditions_(conditions) {
  const std::vector<std::string> sides = side_names_of<Dim>();
  for (std::size_t c = 0; c < specs.size(); ++c) {
    if (specs[c].contact == FaceContact::stick) continue;
    const auto side = static_cast<std::size_t>(std::find(sides.begin(), sides.end(), specs[c].side) - sides.begin());
    for (const Index node : basis.side_nodes(specs[c].side)) {
      // Where another condition holds the node across this side, that one decides.
      if (conditions_.condition(node, static_cast<int>(side / 2)) != static_cast<int>(c)) continue;
      nodes_.push_back({node, static_cast<int>(c), side / 2, side % 2 == 0 ? 1.0 : -1.0});
    }
  }
  if (!nodes_.empty()) released_.assign(static_cast<std::size_t>(basis.node_count() * Dim), false);
}

template <int Dim>
void FaceContacts<Dim>::mark() {
  std::fill(released_.begin(), released_.end(), false);
  for (const Node& one : nodes_) {
    for (int d = 0; d < Dim && one.is_free; ++d) {
      if (conditions_.condition(one.node, d) == one.condition) released_[static_cast<std::size_t>(one.node * Dim + d)] = true;
    }
  }
}

template <int Dim>
void FaceContacts<Dim>::start(const StepSpace<Dim>& space) {
  sets_ = 0;
  for (Node& one : nodes_) {
    one.changes = 0;
    if (!std::binary_search(space.nodes().begin(), space.nodes().end(), one.node)) one.is_free = false;
  }
  mark();
}

template <int Dim>
bool FaceContacts<Dim>::update(const StepSpace<Dim>& space, const std::vector<Real>& u, const std::vector<Real>& residual,
                               const std::vector<Vec<Dim>>& displacements) {
  ++sets_;
  held_ = 0;
  Real greatest = 0;
  for (const Real force : residual) greatest = std::max(greatest, std::abs(force));
  bool is_changed = false;
  for (Node& one : nodes_) {
    const auto found = std::lower_bound(space.nodes().begin(), space.nodes().end(), one.node);
    if (found == space.nodes().end() || *found != one.node) continue;
    const auto place = static_cast<std::size_t>(found - space.nodes().begin()) * Dim + one.axis;
    if (!one.is_free) ++held_;
    const bool must_change = one.is_free
                                 ? (u[place] - displacements[static_cast<std::size_t>(one.condition)][one.axis]) * one.inward < -k_into
                                 : residual[place] * one.inward < -k_pull * greatest;
    if (!must_change || one.changes >= k_changes_max) continue;
    one.is_free = !one.is_free;
    ++one.changes;
    is_changed = true;
  }
  mark();
  return is_changed && sets_ < k_sets_max;
}

template class FaceContacts<2>;
template class FaceContacts<3>;

}  // namespace matpoint
