#include "implicit/face_contact.hpp"

#include <algorithm>
#include <cmath>

namespace matpoint {
namespace {

// Of one step: sets that are tried, and changes of a node, after which it stays as it is, so that no two sets alternate for ever.
constexpr int k_sets_max = 10;
constexpr int k_sets_max_friction = 20;
constexpr int k_changes_max = 3;
constexpr int k_slips_max = 3;
constexpr int k_turns_max = 8;
// A reaction that pulls by less than this share of the greatest, and a displacement into the face of less than this [m], are rounding.
constexpr Real k_pull = 1e-10;
constexpr Real k_into = 1e-14;
// A direction that turns by less [1] is the same; it changes the friction along the slip by the square.
constexpr Real k_turn = 1e-5;

template <int Dim>
Real dot(const Vec<Dim>& a, const Vec<Dim>& b) {
  Real sum = 0;
  for (std::size_t d = 0; d < Dim; ++d) sum += a[d] * b[d];
  return sum;
}

template <int Dim>
Real length(const Vec<Dim>& a) {
  return std::sqrt(dot<Dim>(a, a));
}

/// a / |a|, or 0 where |a| is nothing.
template <int Dim>
Vec<Dim> unit(const Vec<Dim>& a, Real nothing) {
  const Real size = length<Dim>(a);
  Vec<Dim> made{};
  for (std::size_t d = 0; d < Dim && size > nothing; ++d) made[d] = a[d] / size;
  return made;
}

/// Place of a node among the active ones; nothing where no particle is near.
template <int Dim>
std::optional<std::size_t> place_of(const StepSpace<Dim>& space, Index slot) {
  const auto found = std::lower_bound(space.slots().begin(), space.slots().end(), slot);
  if (found == space.slots().end() || *found != slot) return std::nullopt;
  return static_cast<std::size_t>(found - space.slots().begin());
}

}  // namespace

template <int Dim>
FaceContacts<Dim>::FaceContacts(const std::vector<BoundarySpec>& specs, const StepSpace<Dim>& space) : conditions_(&space.conditions()) {
  const std::vector<std::string> sides = side_names_of<Dim>();
  for (std::size_t c = 0; c < specs.size(); ++c) {
    if (specs[c].contact == FaceContact::stick || specs[c].touches_by_particles()) continue;
    const bool can_slip = specs[c].contact == FaceContact::friction;
    const auto side = static_cast<std::size_t>(std::find(sides.begin(), sides.end(), specs[c].side) - sides.begin());
    for (const Index node : space.basis().side_nodes(specs[c].side)) {
      // Where another condition holds the node across this side, that one decides.
      if (conditions_->condition(node, static_cast<int>(side / 2)) != static_cast<int>(c)) continue;
      for (std::size_t field = 0; field < space.field_count(); ++field) {
        nodes_.push_back({node, space.slot(field, node), static_cast<int>(c), side / 2, side % 2 == 0 ? 1.0 : -1.0, can_slip,
                          specs[c].friction, can_slip ? State::slips : State::sticks});
      }
    }
  }
  if (!nodes_.empty()) released_.assign(static_cast<std::size_t>(space.slot_count() * Dim), false);
}

template <int Dim>
bool FaceContacts<Dim>::holds_along(const Node& one, std::size_t d) const {
  return d != one.axis && conditions_->condition(one.node, static_cast<int>(d)) == one.condition;
}

template <int Dim>
void FaceContacts<Dim>::mark() {
  std::fill(released_.begin(), released_.end(), false);
  for (const Node& one : nodes_) {
    if (one.state == State::sticks) continue;
    for (std::size_t d = 0; d < Dim; ++d) {
      const bool is_across = d == one.axis && one.state == State::free;
      if (is_across || holds_along(one, d)) released_[static_cast<std::size_t>(one.slot) * Dim + d] = true;
    }
  }
}

template <int Dim>
void FaceContacts<Dim>::start(const StepSpace<Dim>& space) {
  sets_ = 0;
  for (Node& one : nodes_) {
    one.changes = one.slips = one.turns = 0;
    if (place_of(space, one.slot)) continue;
    one.state = one.can_slip ? State::slips : State::sticks;
    one.direction = {};
  }
  mark();
}

template <int Dim>
std::vector<FaceFriction<Dim>> FaceContacts<Dim>::friction(const StepSpace<Dim>& space, const std::vector<Vec<Dim>>& displacements) const {
  std::vector<FaceFriction<Dim>> all;
  for (const Node& one : nodes_) {
    if (one.state != State::slips || one.friction == 0 || length<Dim>(one.direction) == 0) continue;
    const auto place = place_of(space, one.slot);
    if (!place) continue;
    all.resize(space.nodes().size());
    FaceFriction<Dim>& made = all[*place];
    const Vec<Dim>& face = displacements[static_cast<std::size_t>(one.condition)];
    const Real mu = one.friction * one.inward;
    made.axis = static_cast<int>(one.axis);
    for (std::size_t d = 0; d < Dim; ++d) {
      made.share[d] = mu * one.direction[d];
      for (std::size_t e = 0; e < Dim && one.reach > 0; ++e) {
        if (!holds_along(one, d) || !holds_along(one, e)) continue;
        const Real slope = mu * ((d == e ? 1 : 0) - one.direction[d] * one.direction[e]) / one.reach;
        made.slope[d * Dim + e] = slope;
        made.share[d] -= slope * face[e];
      }
    }
  }
  return all;
}

template <int Dim>
typename FaceContacts<Dim>::Answer FaceContacts<Dim>::answer(const Node& one, std::size_t place, const std::vector<Real>& u,
                                                             const std::vector<Real>& residual, const Vec<Dim>& face, Real rounding) const {
  Answer found{one.inward * residual[place * Dim + one.axis], one.inward * (face[one.axis] - u[place * Dim + one.axis]), {}, {}, rounding};
  for (std::size_t d = 0; d < Dim; ++d) {
    if (!holds_along(one, d)) continue;
    found.slip[d] = u[place * Dim + d] - face[d];
    found.resistance[d] = residual[place * Dim + d];
  }
  return found;
}

template <int Dim>
Vec<Dim> FaceContacts<Dim>::sideways(const Node& one, const Vec<Dim>& slip) {
  const Real ahead = dot<Dim>(one.direction, slip);
  Vec<Dim> rest;
  for (std::size_t d = 0; d < Dim; ++d) rest[d] = slip[d] - ahead * one.direction[d];
  return rest;
}

template <int Dim>
bool FaceContacts<Dim>::is_driven(const Node& one, const Answer& found) {
  if (one.state != State::slips || one.friction == 0 || length<Dim>(one.direction) == 0) return false;
  Real against = dot<Dim>(one.direction, found.slip);
  if (one.reach > 0) {
    const Vec<Dim> rest = sideways(one, found.slip);
    against += dot<Dim>(rest, rest) / one.reach;
  }
  return found.pressure * against < 0 && std::abs(against) > k_into && std::abs(found.pressure) > found.rounding;
}

template <int Dim>
bool FaceContacts<Dim>::change(Node& one, const Answer& found) {
  const bool is_free = one.state == State::free;
  const bool must_change = is_free ? found.depth > k_into : found.pressure < -found.rounding;
  if (must_change && one.changes < k_changes_max) {
    ++one.changes;
    one.state = !is_free ? State::free : one.can_slip ? State::slips : State::sticks;
    one.direction = {};
    return true;
  }
  return !is_free && one.can_slip && change_slip(one, found);
}

template <int Dim>
bool FaceContacts<Dim>::change_slip(Node& one, const Answer& found) {
  if (one.friction == 0) return false;
  if (one.state == State::sticks) {
    // The slip will be against what holds it. Not for ever: a node that sticks too hard brings no energy in.
    if (length<Dim>(found.resistance) <= one.friction * std::max(Real{0}, found.pressure) + found.rounding) return false;
    if (one.slips == k_slips_max) return false;
    ++one.slips;
    one.state = State::slips;
    one.direction = unit<Dim>(found.resistance, 0);
    one.reach = 0;
    for (Real& component : one.direction) component = -component;
    return true;
  }
  if (is_driven(one, found)) {
    one.state = State::sticks;
    return true;
  }
  const Vec<Dim> ahead = unit<Dim>(found.slip, k_into);
  const bool is_first = length<Dim>(one.direction) == 0;
  if (is_first && length<Dim>(ahead) == 0) {
    one.state = State::sticks;
    return true;
  }
  if (!is_first) {
    Vec<Dim> turn;
    for (std::size_t d = 0; d < Dim; ++d) turn[d] = ahead[d] - one.direction[d];
    if (Dim == 2 || length<Dim>(ahead) == 0 || length<Dim>(turn) <= k_turn || one.turns == k_turns_max) return false;
    ++one.turns;
  }
  one.direction = ahead;
  one.reach = length<Dim>(found.slip);
  return true;
}

template <int Dim>
bool FaceContacts<Dim>::update(const StepSpace<Dim>& space, const std::vector<Real>& u, const std::vector<Real>& residual,
                               const std::vector<Vec<Dim>>& displacements) {
  ++sets_;
  held_ = slipping_ = unsettled_ = 0;
  Real greatest = 0;
  for (const Real force : residual) greatest = std::max(greatest, std::abs(force));
  bool is_changed = false;
  for (Node& one : nodes_) {
    const auto place = place_of(space, one.slot);
    if (!place) continue;
    if (one.state != State::free) ++held_;
    if (one.state == State::slips) ++slipping_;
    const Answer found = answer(one, *place, u, residual, displacements[static_cast<std::size_t>(one.condition)], k_pull * greatest);
    const bool is_last = sets_ >= (one.can_slip ? k_sets_max_friction : k_sets_max);
    if (!is_last && change(one, found)) {
      is_changed = true;
      continue;
    }
    if (is_last && is_driven(one, found)) {  // The step goes on with the set as it is, but not with friction that works.
      one.state = State::sticks;
      is_changed = true;
      continue;
    }
    Node unlimited = one;
    unlimited.changes = unlimited.slips = unlimited.turns = 0;
    if (change(unlimited, found)) ++unsettled_;
  }
  mark();
  return is_changed;
}

template <int Dim>
std::vector<Real> FaceContacts<Dim>::slip(const StepSpace<Dim>& space, const std::vector<Real>& u,
                                          const std::vector<Vec<Dim>>& displacements) const {
  std::vector<Real> all(u.size(), 0);
  for (const Node& one : nodes_) {
    const auto place = place_of(space, one.slot);
    if (!place || !one.can_slip) continue;
    for (std::size_t d = 0; d < Dim; ++d) {
      const std::size_t k = *place * Dim + d;
      if (holds_along(one, d)) all[k] = u[k] - displacements[static_cast<std::size_t>(one.condition)][d];
    }
  }
  return all;
}

template <int Dim>
void FaceContacts<Dim>::declare_state(matpoint::State& state) {
  const std::size_t count = nodes_.size();
  std::vector<State> states;
  std::vector<Vec<Dim>> directions;
  std::vector<Real> reaches;
  for (const Node& one : nodes_) {
    states.push_back(one.state);
    directions.push_back(one.direction);
    reaches.push_back(one.reach);
  }
  state.add("state", states);
  state.add("direction", directions);
  state.add("reach", reaches);
  if (states.size() != count || directions.size() != count || reaches.size() != count) state.fail("state", "has not one row for each node");
  for (std::size_t k = 0; k < count; ++k) {
    nodes_[k].state = states[k];
    nodes_[k].direction = directions[k];
    nodes_[k].reach = reaches[k];
  }
  if (state.is_loading() && !is_empty()) mark();
}

template class FaceContacts<2>;
template class FaceContacts<3>;

}  // namespace matpoint
