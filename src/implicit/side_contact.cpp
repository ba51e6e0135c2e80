#include "implicit/side_contact.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "geometry/pair_kernel.hpp"

namespace matpoint {
namespace {

// K in moduli of the body.
constexpr Real k_stiffness = 10;
// Of d_p: as good as on the side.
constexpr Real k_least = 1e-6;
// The same: gaps that are none, for statics have no way to close one. A round body's particles have not quite the size of their places.
constexpr Real k_beside = 0.05;
// The same: a depth that is none, and yet presses.
constexpr Real k_touching = 1e-9;

}  // namespace

template <int Dim>
SideContact<Dim>::SideContact(const Case& problem, const StepSpace<Dim>& space)
    : space_(space), is_static_(problem.implicit.mode == ImplicitMode::quasi_static) {
  for (std::size_t c = 0; c < problem.boundaries.size(); ++c) {
    const BoundarySpec& spec = problem.boundaries[c];
    if (!spec.touches_by_particles()) continue;
    const BoundarySide grid_side = side_of(spec.side);
    Side side{};
    side.axis = static_cast<std::size_t>(grid_side.axis);
    side.inward = grid_side.is_upper ? -1 : 1;
    side.place = grid_side.is_upper ? problem.grid.upper[side.axis] : problem.grid.lower[side.axis];
    side.condition = static_cast<int>(c);
    if (spec.kind != BoundaryKind::slip)
      side.friction = spec.contact == FaceContact::friction ? spec.friction : std::numeric_limits<Real>::infinity();
    side.holds.resize(space.sources().size());
    side.laid.resize(space.sources().size());
    sides_.push_back(std::move(side));
  }
  for (const PointSource<Dim>& source : space.sources()) {
    const Material& material = source.points->material();
    const Real speed = material.wave_speed(1);
    modulus_.push_back(k_stiffness * material.density() * speed * speed);
  }
  displacements_.resize(problem.boundaries.size());
  slope_ = PairKernel<Dim>(k_pair_range).over_plane(0.5);
}

template <int Dim>
bool SideContact<Dim>::has_friction() const {
  return std::any_of(sides_.begin(), sides_.end(), [](const Side& side) { return side.friction > 0 && !std::isinf(side.friction); });
}

template <int Dim>
void SideContact<Dim>::start() {
  is_near_ = false;
  if (sides_.empty()) return;
  for (Side& side : sides_) side.shifts.clear();
  // What is farther does not come so far in a step that can be trusted.
  const Real reach = 3 * space_.basis().shortest_side();
  near_.assign(space_.cells().size(), {});
  for (std::size_t c = 0; c < near_.size(); ++c) {
    const PointBody<Dim>& body = *space_.sources()[space_.source_of(c)].points;
    for (std::size_t s = 0; s < sides_.size(); ++s) {
      bool is_near = false;
      for (Index k = space_.cell_begin(c); k < space_.cell_end(c) && !is_near; ++k) {
        const auto p = static_cast<std::size_t>(space_.particles()[static_cast<std::size_t>(k)]);
        is_near = sides_[s].inward * (body.position[p][sides_[s].axis] - sides_[s].place) < reach;
      }
      if (!is_near) continue;
      near_[c].push_back(s);
      is_near_ = true;
    }
  }
  lay();
}

/// What lies at a side at first touches it without a force, and so does what was put where no step brings it.
template <int Dim>
void SideContact<Dim>::lay() {
  for (std::size_t c = 0; c < near_.size(); ++c) {
    const std::size_t source = space_.source_of(c);
    const PointBody<Dim>& body = *space_.sources()[source].points;
    for (const std::size_t s : near_[c]) {
      for (Index k = space_.cell_begin(c); k < space_.cell_end(c); ++k) {
        const Touch one = touch(sides_[s], c, k, displacements_[static_cast<std::size_t>(sides_[s].condition)], false);
        const auto p = static_cast<std::size_t>(space_.particles()[static_cast<std::size_t>(k)]);
        if (one.g0 > 0 && one.depth - one.g0 < k_least * one.depth) {
          throw InputError(
              "body \"{}\": particle {} at ({:.6g}) lies on a side with contact, and has no room to press; move it inwards by half a "
              "spacing, "
              "or use contact_by = \"nodes\"",
              body.name(), body.id[p], fmt::join(body.position[p], ", "));
        }
        const Real nearest = !is_first_ ? k_through : is_static_ ? -k_beside : 0;
        if (one.g0 > nearest * one.depth) sides_[s].laid[source][body.id[p]] = one.depth - one.g0;
      }
    }
  }
  is_first_ = false;
}

template <int Dim>
Vec<Dim> SideContact<Dim>::displacement(std::size_t cell, Index k, const std::vector<Real>& u) const {
  Vec<Dim> du{};
  const int* const nodes = space_.cell_nodes(cell);
  for (int node = 0; node < space_.functions(); ++node) {
    for (std::size_t d = 0; d < Dim; ++d) du[d] += space_.N(k)[node] * u[static_cast<std::size_t>(nodes[node]) * Dim + d];
  }
  return du;
}

template <int Dim>
typename SideContact<Dim>::Touch SideContact<Dim>::touch(const Side& side, std::size_t cell, Index k, const Vec<Dim>& du,
                                                         bool is_dynamic) const {
  const std::size_t source = space_.source_of(cell);
  const PointBody<Dim>& body = *space_.sources()[source].points;
  const auto p = static_cast<std::size_t>(space_.particles()[static_cast<std::size_t>(k)]);
  const Vec<Dim>& face = displacements_[static_cast<std::size_t>(side.condition)];
  const Real spacing = std::pow(body.volume0[p], Real{1} / Dim);
  Touch touch;
  const auto laid = side.laid[source].find(body.id[p]);
  touch.depth = laid != side.laid[source].end() ? laid->second : space_.sources()[source].depth(p);
  touch.g0 = touch.depth - side.inward * (body.position[p][side.axis] - side.place);
  touch.g1 = touch.g0 - side.inward * (du[side.axis] - face[side.axis]);
  // Without inertia a body that lies on a side has nothing else to hold it in the first iteration.
  if (is_static_ && std::abs(touch.g1) < k_touching * touch.depth) touch.g1 = k_touching * touch.depth;
  if (!touch.presses()) return touch;
  const Real w = slope_ / spacing;
  touch.stiffness = body.volume0[p] * modulus_[source] * w * w;
  touch.start = pressing_up_to(touch.depth, 0, touch.g0, false).value;
  const Pressing pressed = pressing_up_to(touch.depth, touch.g0, touch.g1, is_dynamic);
  touch.pressed = pressed.value;
  touch.slope = pressed.slope;
  if (side.friction > 0) rub(side, cell, k, du, is_dynamic, touch);
  return touch;
}

template <int Dim>
void SideContact<Dim>::rub(const Side& side, std::size_t cell, Index k, const Vec<Dim>& du, bool is_dynamic, Touch& touch) const {
  const std::size_t source = space_.source_of(cell);
  const auto p = static_cast<std::size_t>(space_.particles()[static_cast<std::size_t>(k)]);
  const Vec<Dim>& face = displacements_[static_cast<std::size_t>(side.condition)];
  for (std::size_t d = 0; d < Dim; ++d) touch.slip[d] = d == side.axis ? 0 : du[d] - face[d];
  touch.pull = touch.slip;
  bool goes_on = false;
  const auto hold = side.holds[source].find(space_.sources()[source].points->id[p]);
  if (hold != side.holds[source].end()) {
    // As between bodies: what slips has its friction in the mean only, and where no way is known yet, it slips on.
    const bool slipped = is_dynamic && hold->second.slips;
    goes_on = slipped && dot(touch.slip, touch.slip) == 0;
    for (std::size_t d = 0; d < Dim; ++d) {
      touch.pull[d] += hold->second.pulled[d];
      if (!slipped) touch.old_force[d] = touch.stiffness * hold->second.pulled[d];
    }
  }
  const Real shift = is_dynamic && !side.shifts.empty() ? side.shifts[static_cast<std::size_t>(k)].pressed : 0;
  const Real normal = touch.stiffness * std::max(Real{0}, touch.pressed + 0.5 * shift);
  touch.limit = goes_on || normal == 0 ? 0 : side.friction * normal;
  touch.slips = goes_on || touch.stiffness * std::sqrt(dot(touch.pull, touch.pull)) > touch.limit;
  for (std::size_t d = 0; d < Dim; ++d) touch.force[d] = touch.stiffness * touch.share() * touch.pull[d];
}

template <int Dim>
Real SideContact<Dim>::Touch::share() const {
  if (!slips) return 1;
  const Real length = std::sqrt(dot(pull, pull));
  return length > 0 ? limit / (stiffness * length) : 0;
}

template <int Dim>
std::array<Vec<Dim>, Dim> SideContact<Dim>::tangent(const Side& side, const Touch& touch, Real weight) {
  std::array<Vec<Dim>, Dim> h{};
  h[side.axis][side.axis] = weight * touch.stiffness * touch.slope;
  if (side.friction == 0) return h;
  const Real length = std::sqrt(dot(touch.pull, touch.pull));
  const bool turns = touch.slips && length > 0;
  const bool follows_pressure = turns && touch.limit > 0 && !std::isinf(side.friction);
  for (std::size_t i = 0; i < Dim; ++i) {
    if (i == side.axis) continue;
    const Real ahead = turns ? touch.pull[i] / length : 0;
    for (std::size_t j = 0; j < Dim; ++j) {
      if (j == side.axis) continue;
      h[i][j] = weight * touch.stiffness * touch.share() * ((i == j ? 1 : 0) - (turns ? ahead * touch.pull[j] / length : 0));
    }
    if (follows_pressure) h[i][side.axis] = -weight * side.friction * touch.stiffness * touch.slope * side.inward * ahead;
  }
  return h;
}

template <int Dim>
void SideContact<Dim>::work(std::size_t cell, const std::vector<Real>& u, bool is_dynamic, Real* residual, Real* K) const {
  const Real weight = is_dynamic ? 2 : 1;
  for (const std::size_t s : near_[cell]) {
    const Side& side = sides_[s];
    for (Index k = space_.cell_begin(cell); k < space_.cell_end(cell); ++k) {
      const Touch one = touch(side, cell, k, displacement(cell, k, u), is_dynamic);
      if (!one.presses()) continue;
      Vec<Dim> force{};  // that holds against the side's: a residual
      force[side.axis] = -side.inward * one.stiffness * (weight * one.pressed - (is_dynamic ? one.start : 0));
      for (std::size_t d = 0; d < Dim; ++d) force[d] += weight * one.force[d] - (is_dynamic ? one.old_force[d] : 0);
      const Real* const N = space_.N(k);
      for (int node = 0; node < space_.functions(); ++node) {
        for (std::size_t d = 0; d < Dim; ++d) residual[static_cast<std::size_t>(node) * Dim + d] += N[node] * force[d];
      }
      if (K == nullptr) continue;
      const std::array<Vec<Dim>, Dim> h = tangent(side, one, weight);
      const auto functions = static_cast<std::size_t>(space_.functions());
      for (std::size_t I = 0; I < functions; ++I) {
        for (std::size_t i = 0; i < Dim; ++i) {
          Real* const row = K + (I * Dim + i) * functions * Dim;
          for (std::size_t J = 0; J < functions; ++J) {
            for (std::size_t j = 0; j < Dim; ++j) row[J * Dim + j] += N[I] * N[J] * h[i][j];
          }
        }
      }
    }
  }
}

template <int Dim>
template <class F>
void SideContact<Dim>::for_each_touch(const std::vector<Real>& u, bool is_dynamic, F&& f) const {
  for (std::size_t cell = 0; cell < near_.size() && is_near_; ++cell) {
    for (const std::size_t s : near_[cell]) {
      for (Index k = space_.cell_begin(cell); k < space_.cell_end(cell); ++k) {
        const Vec<Dim> du = displacement(cell, k, u);
        const Touch one = touch(sides_[s], cell, k, du, is_dynamic);
        if (one.presses()) f(s, cell, k, one, du);
      }
    }
  }
}

template <int Dim>
void SideContact<Dim>::balance(const std::vector<Real>& way) {
  for (Side& side : sides_) side.shifts.clear();
  if (!is_near_ || way.empty()) return;
  std::vector<std::vector<Shift>> shifts(sides_.size(), std::vector<Shift>(space_.particles().size()));
  for_each_touch(std::vector<Real>(way.size(), 0), true, [&](std::size_t s, std::size_t cell, Index k, const Touch& one, const Vec<Dim>&) {
    const Side& side = sides_[s];
    const Vec<Dim> du = displacement(cell, k, way);
    Shift& shift = shifts[s][static_cast<std::size_t>(k)];
    // The mean over a step that is nothing has half the slope.
    shift.pressed = -2 * one.slope * side.inward * du[side.axis];
    const std::array<Vec<Dim>, Dim> h = tangent(side, one, 2);
    for (std::size_t d = 0; d < Dim; ++d) shift.force[d] = 2 * (one.old_force[d] - one.force[d]) - dot(h[d], du);
  });
  for (std::size_t s = 0; s < sides_.size(); ++s) sides_[s].shifts = std::move(shifts[s]);
}

template <int Dim>
std::string SideContact<Dim>::find_overlap(const std::vector<Real>& u) const {
  std::string found;
  for_each_touch(u, false, [&](std::size_t s, std::size_t cell, Index k, const Touch& one, const Vec<Dim>&) {
    if (!found.empty() || one.g1 < k_through * one.depth) return;
    const PointSource<Dim>& source = space_.sources()[space_.source_of(cell)];
    const PointBody<Dim>& body = *source.points;
    const auto p = static_cast<std::size_t>(space_.particles()[static_cast<std::size_t>(k)]);
    found = fmt::format("{} {} of body \"{}\" at ({:.6g}) would come through the {} side across {}", source.point_name(), body.id[p],
                        body.name(), fmt::join(body.position[p], ", "), sides_[s].inward > 0 ? "lower" : "upper", "xyz"[sides_[s].axis]);
  });
  return found;
}

template <int Dim>
bool SideContact<Dim>::has_pressed(const std::vector<Real>& u) const {
  bool has_pressed = false;
  for_each_touch(u, true, [&](std::size_t, std::size_t, Index, const Touch&, const Vec<Dim>&) { has_pressed = true; });
  return has_pressed;
}

template <int Dim>
Real SideContact<Dim>::work_at_start(const std::vector<Real>& u) const {
  Real sum = 0;
  for_each_touch(u, true, [&](std::size_t s, std::size_t, Index, const Touch& one, const Vec<Dim>& du) {
    sum -= 0.5 * sides_[s].inward * one.stiffness * one.start * du[sides_[s].axis];
    sum += 0.5 * dot(one.old_force, du);
  });
  return sum;
}

template <int Dim>
std::vector<typename SideContact<Dim>::Action> SideContact<Dim>::actions(const std::vector<Real>& u, bool is_dynamic) const {
  std::vector<Action> all;
  for (const Side& side : sides_) {
    all.push_back({side.condition, {}, {}, 0, 0});
    for (const auto& source : side.holds) {
      for (const auto& [id, hold] : source) all.back().slip_work += hold.energy;
    }
  }
  for_each_touch(u, is_dynamic, [&](std::size_t s, std::size_t, Index k, const Touch& one, const Vec<Dim>&) {
    const Side& side = sides_[s];
    Action& action = all[s];
    const Vec<Dim>& face = displacements_[static_cast<std::size_t>(side.condition)];
    const Shift shift = is_dynamic && !side.shifts.empty() ? side.shifts[static_cast<std::size_t>(k)] : Shift{};
    for (std::size_t d = 0; d < Dim; ++d) {
      const Real push = d == side.axis ? side.inward * one.stiffness : 0;
      const Real placed = push * one.start - one.old_force[d];
      const Real mean = push * one.pressed - one.force[d];
      const Real start = placed + shift.force[d];
      const Real end = is_dynamic ? 2 * mean - placed : mean;
      action.start[d] += start;
      action.end[d] += end;
      action.work += mean * face[d];  // what the shift of the start does is in reset_loss
    }
    action.slip_work += dot(one.force, one.slip);
    if (side.friction > 0) action.slip_work -= 0.5 * dot(one.force, one.force) / one.stiffness;
  });
  return all;
}

template <int Dim>
std::vector<typename SideContact<Dim>::Support> SideContact<Dim>::supports() const {
  std::vector<Support> all;
  for (std::size_t cell = 0; cell < near_.size(); ++cell) {
    const PointBody<Dim>& body = *space_.sources()[space_.source_of(cell)].points;
    for (const std::size_t s : near_[cell]) {
      for (Index k = space_.cell_begin(cell); k < space_.cell_end(cell); ++k) {
        const Touch one = touch(sides_[s], cell, k, displacements_[static_cast<std::size_t>(sides_[s].condition)], false);
        const auto p = static_cast<std::size_t>(space_.particles()[static_cast<std::size_t>(k)]);
        if (one.presses()) all.push_back({cell, body.position[p], sides_[s].axis, sides_[s].friction > 0});
      }
    }
  }
  return all;
}

template <int Dim>
void SideContact<Dim>::commit(const std::vector<Real>& u, bool is_dynamic) {
  std::vector<std::vector<std::map<Index, Hold<Dim>>>> holds(sides_.size(),
                                                             std::vector<std::map<Index, Hold<Dim>>>(space_.sources().size()));
  for_each_touch(u, is_dynamic, [&](std::size_t s, std::size_t cell, Index k, const Touch& one, const Vec<Dim>&) {
    const std::size_t source = space_.source_of(cell);
    const auto p = static_cast<std::size_t>(space_.particles()[static_cast<std::size_t>(k)]);
    if (sides_[s].friction == 0) return;
    Hold<Dim> hold;
    for (std::size_t d = 0; d < Dim; ++d) hold.pulled[d] = one.force[d] / one.stiffness;
    hold.energy = 0.5 * one.stiffness * dot(hold.pulled, hold.pulled);
    hold.slips = one.slips;
    holds[s][source][space_.sources()[source].points->id[p]] = hold;
  });
  for (std::size_t s = 0; s < sides_.size(); ++s) sides_[s].holds = std::move(holds[s]);
  measure_energy(u);
  for (Side& side : sides_) side.place += displacements_[static_cast<std::size_t>(side.condition)][side.axis];
}

template <int Dim>
void SideContact<Dim>::measure_energy(const std::vector<Real>& u) {
  energy_ = 0;
  for (const Side& side : sides_) {
    for (const auto& source : side.holds) {
      for (const auto& [id, hold] : source) energy_ += hold.energy;
    }
  }
  for_each_touch(u, false, [&](std::size_t, std::size_t, Index, const Touch& one, const Vec<Dim>&) {
    const Real g = std::max(Real{0}, one.g1);
    energy_ += 0.5 * one.stiffness * one.depth * g * g / (one.depth - g);
  });
}

template <int Dim>
void SideContact<Dim>::declare_state(State& state) {
  for (std::size_t s = 0; s < sides_.size(); ++s) {
    Side& side = sides_[s];
    state.in(std::to_string(s), [&] {
      state.add("place", side.place);
      for (std::size_t source = 0; source < side.holds.size(); ++source) {
        state.in(space_.sources()[source].points->name(), [&] {
          state.rows("holds", side.holds[source]);
          state.rows("laid", side.laid[source]);
        });
      }
    });
  }
  state.add("is_first", is_first_);
}

template class SideContact<2>;
template class SideContact<3>;

}  // namespace matpoint
