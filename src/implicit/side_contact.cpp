#include "implicit/side_contact.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "geometry/pair_kernel.hpp"
#include "implicit/pressing.hpp"

namespace matpoint {
namespace {

// K in moduli of the body.
constexpr Real k_stiffness = 10;

}  // namespace

template <int Dim>
SideContact<Dim>::SideContact(const Case& problem, const StepSpace<Dim>& space) : space_(space) {
  for (std::size_t c = 0; c < problem.boundaries.size(); ++c) {
    const BoundarySpec& spec = problem.boundaries[c];
    if (!getenv("MP_SIDES") || spec.contact == FaceContact::stick || spec.region) continue;
    const BoundarySide side = side_of(spec.side);
    const auto axis = static_cast<std::size_t>(side.axis);
    const Real friction = spec.kind == BoundaryKind::slip           ? 0
                          : spec.contact == FaceContact::no_tension ? std::numeric_limits<Real>::infinity()
                                                                    : spec.friction;
    sides_.push_back({axis,
                      side.is_upper ? -1.0 : 1.0,
                      side.is_upper ? problem.grid.upper[axis] : problem.grid.lower[axis],
                      static_cast<int>(c),
                      friction,
                      {},
                      {}});
    sides_.back().holds.resize(space.sources().size());
  }
  for (const PointSource<Dim>& source : space.sources()) {
    const Material& material = source.points->material();
    modulus_.push_back(k_stiffness * material.density() * material.wave_speed(1) * material.wave_speed(1));
  }
  displacements_.resize(problem.boundaries.size());
}

template <int Dim>
void SideContact<Dim>::start() {
  for (Side& side : sides_) side.shifts.clear();
  is_near_ = false;
  if (is_empty()) return;
  near_.assign(space_.cells().size(), {});
  for (std::size_t c = 0; c < near_.size(); ++c) {
    // A particle goes on with the functions of its cell; what is two cells away does not come in a step.
    for (std::size_t s = 0; s < sides_.size(); ++s) {
      Index cell = space_.cells()[c];
      for (int k = 0; k < 3 && cell >= 0; ++k)
        cell = space_.basis().neighbour(cell, static_cast<int>(sides_[s].axis), sides_[s].inward < 0);
      if (cell < 0) near_[c].push_back(s), is_near_ = true;
    }
  }
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
  touch.depth = 0.5 * spacing;
  touch.g0 = 0.5 * spacing - side.inward * (body.position[p][side.axis] - side.place);
  touch.g1 = touch.g0 - side.inward * (du[side.axis] - face[side.axis]);
  if (!touch.presses()) return touch;
  const PairKernel<Dim> kernel(k_pair_range * spacing);
  const Real w = kernel.over_plane(0.5 * spacing);
  touch.stiffness = body.volume0[p] * modulus_[source] * w * w;
  const Pressing pressed = pressing_up_to(touch.depth, touch.g0, touch.g1, is_dynamic);
  touch.pressed = pressed.value;
  touch.slope = pressed.slope;
  if (side.friction == 0) return touch;
  for (std::size_t d = 0; d < Dim; ++d) touch.slip[d] = d == side.axis ? 0 : du[d] - face[d];
  touch.pull = touch.slip;
  const auto hold = side.holds[source].find(body.id[p]);
  if (hold != side.holds[source].end()) {
    for (std::size_t d = 0; d < Dim; ++d) {
      touch.pull[d] += hold->second.pulled[d];
      if (!is_dynamic || !hold->second.slips) touch.old_force[d] = touch.stiffness * hold->second.pulled[d];
    }
  }
  const Real shift = is_dynamic && !side.shifts.empty() ? side.shifts[static_cast<std::size_t>(k)] : 0;
  const Real normal = std::max(Real{0}, touch.pressed + 0.5 * shift);
  touch.limit = std::isinf(side.friction) ? (touch.pressed > 0 ? side.friction : 0) : side.friction * touch.stiffness * normal;
  const Real length = std::sqrt(dot(touch.pull, touch.pull));
  // Where no way is known yet, what slipped slips on.
  const bool goes_on = is_dynamic && hold != side.holds[source].end() && hold->second.slips && dot(touch.slip, touch.slip) == 0;
  if (goes_on) touch.limit = 0;
  touch.slips = goes_on || touch.stiffness * length > touch.limit;
  for (std::size_t d = 0; d < Dim; ++d)
    touch.force[d] = touch.pull[d] * (!touch.slips ? touch.stiffness : length > 0 ? touch.limit / length : 0);
  return touch;
}

template <int Dim>
void SideContact<Dim>::work(std::size_t cell, const std::vector<Real>& u, bool is_dynamic, Real* residual, Real* K) const {
  if (is_empty()) return;
  const int functions = space_.functions();
  const std::size_t width = static_cast<std::size_t>(functions) * Dim;
  const Real weight = is_dynamic ? 2 : 1;
  for (const std::size_t s : near_[cell]) {
    const Side& side = sides_[s];
    for (Index k = space_.cell_begin(cell); k < space_.cell_end(cell); ++k) {
      const Touch one = touch(side, cell, k, displacement(cell, k, u), is_dynamic);
      if (!one.presses()) continue;
      const Real* const N = space_.N(k);
      Vec<Dim> force{};  // -dPhi/dx and friction, against which the residual is
      force[side.axis] = -side.inward * one.stiffness * (weight * one.pressed - (is_dynamic ? one.pressed_at_start() : 0));
      for (std::size_t d = 0; d < Dim; ++d) force[d] += weight * one.force[d] - (is_dynamic ? one.old_force[d] : 0);
      for (int node = 0; node < functions; ++node) {
        for (std::size_t d = 0; d < Dim; ++d) residual[static_cast<std::size_t>(node) * Dim + d] += N[node] * force[d];
      }
      if (K == nullptr) continue;
      Real h[Dim][Dim] = {};
      h[side.axis][side.axis] = weight * one.stiffness * one.slope;
      if (side.friction > 0) {
        const Real length = std::sqrt(dot(one.pull, one.pull));
        const Real stiffness = weight * (!one.slips ? one.stiffness : length > 0 ? one.limit / length : 0);
        for (std::size_t i = 0; i < Dim; ++i) {
          if (i == side.axis) continue;
          const Real ahead = one.slips && length > 0 ? one.pull[i] / length : 0;
          for (std::size_t j = 0; j < Dim; ++j) {
            if (j != side.axis) h[i][j] += stiffness * ((i == j ? 1 : 0) - (one.slips && length > 0 ? ahead * one.pull[j] / length : 0));
          }
          if (one.slips && one.limit > 0 && !std::isinf(side.friction))
            h[i][side.axis] -= weight * side.friction * one.stiffness * one.slope * side.inward * ahead;
        }
      }
      for (int I = 0; I < functions; ++I) {
        for (std::size_t i = 0; i < Dim; ++i) {
          Real* const row = K + (static_cast<std::size_t>(I) * Dim + i) * width;
          for (int J = 0; J < functions; ++J) {
            for (std::size_t j = 0; j < Dim; ++j) row[static_cast<std::size_t>(J) * Dim + j] += N[I] * N[J] * h[i][j];
          }
        }
      }
    }
  }
}

template <int Dim>
template <class F>
void SideContact<Dim>::for_each_touch(const std::vector<Real>& u, bool is_dynamic, F&& f) const {
  for (std::size_t cell = 0; cell < near_.size() && !is_empty(); ++cell) {
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
  std::vector<std::vector<Real>> shifts(sides_.size(), std::vector<Real>(space_.particles().size(), 0));
  for_each_touch(std::vector<Real>(way.size(), 0), true, [&](std::size_t s, std::size_t cell, Index k, const Touch& one, const Vec<Dim>&) {
    // The mean over a step that is nothing has half the slope.
    shifts[s][static_cast<std::size_t>(k)] = -2 * one.slope * sides_[s].inward * displacement(cell, k, way)[sides_[s].axis];
  });
  for (std::size_t s = 0; s < sides_.size(); ++s) sides_[s].shifts = std::move(shifts[s]);
}

template <int Dim>
std::string SideContact<Dim>::find_overlap(const std::vector<Real>& u) const {
  std::string found;
  for_each_touch(u, false, [&](std::size_t s, std::size_t cell, Index k, const Touch& one, const Vec<Dim>&) {
    const PointBody<Dim>& body = *space_.sources()[space_.source_of(cell)].points;
    const auto p = static_cast<std::size_t>(space_.particles()[static_cast<std::size_t>(k)]);
    if (!found.empty() || one.g1 < 0.99 * one.depth) return;
    found = fmt::format("particle {} of body \"{}\" at ({:.6g}) would come through side {} of the grid", body.id[p], body.name(),
                        fmt::join(body.position[p], ", "), sides_[s].axis);
  });
  return found;
}

template <int Dim>
Real SideContact<Dim>::work_at_start(const std::vector<Real>& u) const {
  Real sum = 0;
  for_each_touch(u, true, [&](std::size_t s, std::size_t, Index, const Touch& one, const Vec<Dim>& du) {
    sum -= 0.5 * sides_[s].inward * one.stiffness * one.pressed_at_start() * du[sides_[s].axis];
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
  for_each_touch(u, is_dynamic, [&](std::size_t s, std::size_t, Index, const Touch& one, const Vec<Dim>&) {
    const Side& side = sides_[s];
    Action& action = all[s];
    const Vec<Dim>& face = displacements_[static_cast<std::size_t>(side.condition)];
    Vec<Dim> mean{}, start{};
    mean[side.axis] = side.inward * one.stiffness * one.pressed;
    start[side.axis] = side.inward * one.stiffness * one.pressed_at_start();
    for (std::size_t d = 0; d < Dim; ++d) {
      mean[d] -= one.force[d];
      start[d] -= one.old_force[d];
      action.mean[d] += mean[d];
      action.end[d] += is_dynamic ? 2 * mean[d] - start[d] : mean[d];
      action.work += mean[d] * face[d];
    }
    action.slip_work += dot(one.force, one.slip);
    if (side.friction > 0) action.slip_work -= 0.5 * dot(one.force, one.force) / one.stiffness;
  });
  return all;
}

template <int Dim>
void SideContact<Dim>::commit(const std::vector<Real>& u, bool is_dynamic) {
  energy_ = 0;
  std::vector<std::vector<std::map<Index, Hold>>> holds(sides_.size(), std::vector<std::map<Index, Hold>>(space_.sources().size()));
  for_each_touch(u, is_dynamic, [&](std::size_t s, std::size_t cell, Index k, const Touch& one, const Vec<Dim>&) {
    const PointBody<Dim>& body = *space_.sources()[space_.source_of(cell)].points;
    const auto p = static_cast<std::size_t>(space_.particles()[static_cast<std::size_t>(k)]);
    const Real g = std::max(Real{0}, one.g1);
    energy_ += 0.5 * one.stiffness * one.depth * g * g / (one.depth - g);
    if (sides_[s].friction == 0 || one.stiffness == 0) return;
    Hold hold;
    for (std::size_t d = 0; d < Dim; ++d) hold.pulled[d] = one.force[d] / one.stiffness;
    hold.slips = one.slips;
    hold.energy = 0.5 * one.stiffness * dot(hold.pulled, hold.pulled);
    energy_ += hold.energy;
    holds[s][space_.source_of(cell)][body.id[p]] = hold;
  });
  for (std::size_t s = 0; s < sides_.size(); ++s) sides_[s].holds = std::move(holds[s]);
}

template class SideContact<2>;
template class SideContact<3>;

}  // namespace matpoint
