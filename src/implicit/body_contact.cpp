#include "implicit/body_contact.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "implicit/pressing.hpp"

namespace matpoint {
namespace {

template <int Dim>
Vec<Dim> minus(Vec<Dim> a, const Vec<Dim>& b) {
  for (std::size_t d = 0; d < Dim; ++d) a[d] -= b[d];
  return a;
}

template <int Dim>
Vec<Dim> scaled(Vec<Dim> a, Real factor) {
  for (Real& x : a) x *= factor;
  return a;
}

template <int Dim>
Real length_of(const Vec<Dim>& a) {
  return std::sqrt(dot(a, a));
}

/// The part of a across the normal.
template <int Dim>
Vec<Dim> along(const Vec<Dim>& a, const Vec<Dim>& normal) {
  return minus<Dim>(a, scaled<Dim>(normal, dot(a, normal)));
}

/// The same, as long as a.
template <int Dim>
Vec<Dim> turned(const Vec<Dim>& a, const Vec<Dim>& normal) {
  const Vec<Dim> flat = along<Dim>(a, normal);
  const Real length = length_of<Dim>(flat);
  return length > 0 ? scaled<Dim>(flat, length_of<Dim>(a) / length) : flat;
}

template <int Dim>
Real distance_squared(const Vec<Dim>& a, const Vec<Dim>& b) {
  const Vec<Dim> r = minus<Dim>(a, b);
  return dot(r, r);
}

}  // namespace

template <int Dim>
BodyContact<Dim>::BodyContact(const Case& problem, const StepSpace<Dim>& space) : space_(space), images_(mirror_images<Dim>(problem)) {
  if (problem.implicit.contact != ImplicitContact::pairs) return;
  friction_ = problem.implicit.friction;
  const std::size_t count = space.sources().size();
  std::vector<Real> spacing, modulus;
  for (const PointSource<Dim>& source : space.sources()) {
    const std::vector<Real>& volumes = source.points->volume0;
    const Real speed = source.points->material().wave_speed(1);
    spacing.push_back(std::pow(*std::max_element(volumes.begin(), volumes.end()), Real{1} / Dim));
    modulus.push_back(source.points->material().density() * speed * speed);
  }
  for (std::size_t a = 0; a < count; ++a) {
    for (std::size_t b = a + 1; b < count; ++b) {
      const PairKernel<Dim> kernel(k_pair_range * std::max(spacing[a], spacing[b]));
      Pair pair{{a, b}, kernel, problem.implicit.contact_stiffness * std::min(modulus[a], modulus[b]), {}, {}, {}};
      for (std::size_t side : {0, 1}) {
        const PointSource<Dim>& source = space.sources()[pair.sources[side]];
        const PointSource<Dim>& other = space.sources()[pair.sources[1 - side]];
        const SurfaceRows rows = other.fem != nullptr ? SurfaceRows::of_elements(other.fem->cell_length())
                                                      : SurfaceRows::of_particles(spacing[pair.sources[1 - side]]);
        Real last = -1;  // most bodies have particles of one volume
        for (std::size_t p = 0; p < source.points->volume0.size(); ++p) {
          std::vector<Real>& all = pair.at_touch[side];
          all.push_back(source.depth(p) == last ? all.back() : kernel.beyond_surface(source.depth(p), rows));
          last = source.depth(p);
        }
      }
      pairs_.push_back(std::move(pair));
    }
  }
}

template <int Dim>
Real BodyContact<Dim>::volume(Index k) const {
  const auto row = static_cast<std::size_t>(space_.particles()[static_cast<std::size_t>(k)]);
  return space_.sources()[space_.source_of(entry_[static_cast<std::size_t>(k)])].points->volume0[row];
}

template <int Dim>
Index BodyContact<Dim>::id(Index k) const {
  const auto row = static_cast<std::size_t>(space_.particles()[static_cast<std::size_t>(k)]);
  return space_.sources()[space_.source_of(entry_[static_cast<std::size_t>(k)])].points->id[row];
}

/// Bodies that are laid on each other touch without a force, as in the explicit solver.
template <int Dim>
void BodyContact<Dim>::lay() {
  constexpr Real k_seen = 0.01;
  for (const ContactPatch<Dim>& patch : patches_) {
    for (std::size_t i = 0; i < patch.points.size(); ++i) {
      const Meeting meeting = meet(patch, i);
      if (meeting.g0 > 0 && meeting.g0 < k_seen)
        pairs_[patch.pair].at_touch[patch.side][static_cast<std::size_t>(id(patch.points[i]))] = meeting.c0;
    }
  }
}

template <int Dim>
std::string BodyContact<Dim>::find_overlap() const {
  // Of g: half a spacing too deep. From there on W pushes ever less, and rows of particles pass through each other.
  constexpr Real k_deep = 0.25;
  for (const ContactPatch<Dim>& patch : patches_) {
    const Pair& pair = pairs_[patch.pair];
    for (std::size_t i = 0; i < patch.points.size(); ++i) {
      const Meeting meeting = meet(patch, i);
      bool is_far = false;
      const Real range = pair.kernel.range();
      for (const Near& near : meeting.near) is_far = is_far || (near.q0 > 0 && distance_squared<Dim>(near.r0, near.r1) > range * range);
      if (!is_far && meeting.g1 <= std::max(k_deep, 1.01 * meeting.g0)) continue;
      const auto name = [&](std::size_t side) { return space_.sources()[pair.sources[side]].points->name(); };
      return fmt::format("{} {} of body \"{}\" at ({:.6g}) would run into body \"{}\", {}",
                         space_.sources()[pair.sources[patch.side]].point_name(), id(patch.points[i]), name(patch.side),
                         fmt::join(x0_[static_cast<std::size_t>(patch.points[i])], ", "), name(1 - patch.side),
                         is_far ? "past more than two points of it" : "half a point's spacing deep");
    }
  }
  return {};
}

template <int Dim>
typename BodyContact<Dim>::Meeting BodyContact<Dim>::meet(const ContactPatch<Dim>& patch, std::size_t point) const {
  Meeting meeting;
  const Pair& pair = pairs_[patch.pair];
  const auto p = static_cast<std::size_t>(patch.points[point]);
  const Real factor = 1 / (pair.kernel.range() * pair.kernel.range());
  Real c1 = 0;
  for (std::size_t k = patch.begin[point]; k < patch.begin[point + 1]; ++k) {
    const auto& candidate = patch.candidates[k];
    const MirrorImage<Dim>& image = images_[candidate.image];
    Near near{candidate.q,
              candidate.entry,
              candidate.image,
              minus<Dim>(x0_[p], image.place(x0_[candidate.q])),
              minus<Dim>(x_[p], image.place(x_[candidate.q])),
              0,
              0};
    near.q0 = 1 - dot(near.r0, near.r0) * factor;
    near.q1 = 1 - dot(near.r1, near.r1) * factor;
    if (near.q0 <= 0 && near.q1 <= 0) continue;
    const Real V = volume(candidate.q);
    if (near.q0 > 0) meeting.c0 += V * pair.kernel.value(near.q0);
    if (near.q1 > 0) c1 += V * pair.kernel.value(near.q1);
    meeting.near.push_back(near);
  }
  if (meeting.near.empty()) return meeting;
  const Real touch = pair.at_touch[patch.side][static_cast<std::size_t>(id(patch.points[point]))];
  meeting.g0 = meeting.c0 - touch;
  meeting.g1 = c1 - touch;
  return meeting;
}

template <int Dim>
typename BodyContact<Dim>::Rub BodyContact<Dim>::rub(const ContactPatch<Dim>& patch, std::size_t point, const Meeting& meeting,
                                                     bool is_dynamic) const {
  Rub rub;
  if (friction_ == 0 || !meeting.presses() || meeting.c0 == 0) return rub;
  const Pair& pair = pairs_[patch.pair];
  const auto p = static_cast<std::size_t>(patch.points[point]);
  Vec<Dim> gradient{};
  Vec<Dim> way = minus<Dim>(x_[p], x0_[p]);
  for (const Near& near : meeting.near) {
    if (near.q0 <= 0) continue;
    const Real V = volume(near.q);
    const Real weight = V * pair.kernel.value(near.q0) / meeting.c0;
    const Vec<Dim> other = images_[near.image].direction(minus<Dim>(x_[near.q], x0_[near.q]));
    for (std::size_t d = 0; d < Dim; ++d) {
      gradient[d] -= V * pair.kernel.slope(near.q0) * near.r0[d];
      way[d] -= weight * other[d];
    }
  }
  rub.reach = length_of<Dim>(gradient);
  if (rub.reach == 0) return rub;
  rub.is_on = true;
  rub.normal = scaled<Dim>(gradient, 1 / rub.reach);
  const Real V = volume(patch.points[point]);
  // As stiff along the surface as across it, where a flat one begins to press.
  const Real w = pair.kernel.over_plane(pair.kernel.range() / (2 * k_pair_range));
  rub.stiffness = pair.stiffness * w * w * V;
  rub.slip = along<Dim>(way, rub.normal);
  rub.pull = rub.slip;
  const auto hold = pair.holds[patch.side].find(id(patch.points[point]));
  if (hold != pair.holds[patch.side].end()) {
    const Vec<Dim> pulled = turned<Dim>(hold->second.pulled, rub.normal);
    for (std::size_t d = 0; d < Dim; ++d) rub.pull[d] += pulled[d];
    // What slips has no friction at the start of the step, but what it has in the mean: a spring that has given way has no force of its
    // own.
    if (!is_dynamic || !hold->second.slips) rub.old_force = scaled<Dim>(pulled, rub.stiffness);
  }
  Real pressed = pressing(meeting.g0, meeting.g1, is_dynamic).value;
  const auto shift = pair.shifts[patch.side].find(id(patch.points[point]));
  if (is_dynamic && shift != pair.shifts[patch.side].end()) pressed = std::max(Real{0}, pressed + 0.5 * shift->second);
  rub.limit = friction_ * V * pair.stiffness * rub.reach * pressed;
  const Real length = length_of<Dim>(rub.pull);
  // Where no way is known yet, what slipped slips on.
  const bool goes_on = is_dynamic && hold != pair.holds[patch.side].end() && hold->second.slips && dot(rub.slip, rub.slip) == 0;
  if (goes_on) rub.limit = 0;
  rub.slips = goes_on || rub.stiffness * length > rub.limit;
  rub.force = scaled<Dim>(rub.pull, !rub.slips ? rub.stiffness : length > 0 ? rub.limit / length : 0);
  return rub;
}

template <int Dim>
void BodyContact<Dim>::work(const ContactPatch<Dim>& patch, bool is_dynamic, Real* residual, Real* K) const {
  const std::size_t size = patch.nodes.size() * Dim;
  std::fill_n(residual, size, 0);
  if (K != nullptr) std::fill_n(K, size * size, 0);
  for (std::size_t point = 0; point < patch.points.size(); ++point) {
    const Meeting meeting = meet(patch, point);
    if (!meeting.presses()) continue;
    press(patch, point, meeting, is_dynamic, residual, K);
  }
}

/// What displacements of the patch's nodes do to the distance of a particle and another one.
template <int Dim>
struct BodyContact<Dim>::Arm {
  const int* local;  ///< Places of the functions among the patch's nodes.
  const Real* N;
  Vec<Dim> sign;  ///< 1 of the particle itself; of the other one -1, and 1 along the axis of an image.
};

template <int Dim>
void BodyContact<Dim>::press(const ContactPatch<Dim>& patch, std::size_t point, const Meeting& meeting, bool is_dynamic, Real* residual,
                             Real* K) const {
  const Pair& pair = pairs_[patch.pair];
  const std::size_t size = patch.nodes.size() * Dim;
  const int functions = space_.functions();
  const Real weight = is_dynamic ? 2 : 1;
  const Pressing pressed = pressing(meeting.g0, meeting.g1, is_dynamic);
  const Real modulus = volume(patch.points[point]) * pair.stiffness;
  const Rub rubbing = rub(patch, point, meeting, is_dynamic);
  // Derivatives of c_p by the nodes: its mean over the step, now, and at the start; and of the way past the other body.
  std::vector<Real> mean(size, 0), now(size, 0), start(size, 0), past(rubbing.is_on ? size : 0, 0);
  const auto add = [&](const Arm& arm, const Vec<Dim>& v, Real factor, std::vector<Real>& row) {
    for (int node = 0; node < functions; ++node) {
      for (std::size_t d = 0; d < Dim; ++d)
        row[static_cast<std::size_t>(arm.local[node]) * Dim + d] += factor * arm.N[node] * arm.sign[d] * v[d];
    }
  };
  Vec<Dim> ones;
  ones.fill(1);
  const Arm self{patch.local.data(), space_.N(patch.points[point]), ones};
  if (rubbing.is_on) add(self, ones, 1, past);
  for (const Near& near : meeting.near) {
    const Real V = volume(near.q);
    const Arm other{patch.local.data() + static_cast<std::size_t>(near.entry) * static_cast<std::size_t>(functions), space_.N(near.q),
                    scaled<Dim>(images_[near.image].direction(ones), -1)};
    const auto of_both = [&](const Vec<Dim>& v, Real factor, std::vector<Real>& row) {
      add(self, v, factor, row);
      add(other, v, factor, row);
    };
    const typename PairKernel<Dim>::Secant secant = is_dynamic ? pair.kernel.secant(near.q0, near.q1) : pair.kernel.tangent(near.q1);
    Vec<Dim> middle;  // twice
    for (std::size_t d = 0; d < Dim; ++d) middle[d] = near.r1[d] + (is_dynamic ? near.r0[d] : near.r1[d]);
    of_both(middle, V * secant.value, mean);
    if (near.q1 > 0) of_both(near.r1, -V * pair.kernel.slope(near.q1), now);
    if (near.q0 > 0 && is_dynamic) of_both(near.r0, -V * pair.kernel.slope(near.q0), start);
    if (rubbing.is_on && near.q0 > 0) add(other, ones, V * pair.kernel.value(near.q0) / meeting.c0, past);
    if (K == nullptr || pressed.value == 0) continue;
    Vec<Dim> h[Dim];
    for (std::size_t i = 0; i < Dim; ++i) {
      for (std::size_t j = 0; j < Dim; ++j)
        h[i][j] = weight * modulus * pressed.value * V *
                  ((i == j ? (is_dynamic ? 1 : 2) * secant.value : 0) + middle[i] * 2 * near.r1[j] * secant.slope);
    }
    for (const Arm* one : {&self, &other}) {
      for (const Arm* two : {&self, &other}) {
        for (int I = 0; I < functions; ++I) {
          for (std::size_t i = 0; i < Dim; ++i) {
            Real* const row = K + (static_cast<std::size_t>(one->local[I]) * Dim + i) * size;
            for (int J = 0; J < functions; ++J) {
              const Real both = one->N[I] * two->N[J] * one->sign[i];
              for (std::size_t j = 0; j < Dim; ++j) row[static_cast<std::size_t>(two->local[J]) * Dim + j] += both * two->sign[j] * h[i][j];
            }
          }
        }
      }
    }
  }
  for (std::size_t k = 0; k < size; ++k) {
    residual[k] += weight * modulus * pressed.value * mean[k];
    if (is_dynamic) residual[k] -= modulus * std::max(Real{0}, meeting.g0) * start[k];
    if (rubbing.is_on) residual[k] += past[k] * (weight * rubbing.force[k % Dim] - (is_dynamic ? rubbing.old_force[k % Dim] : 0));
  }
  if (K == nullptr) return;
  for (std::size_t k = 0; k < size; ++k) {
    const Real of_row = weight * modulus * pressed.slope * mean[k];
    if (of_row == 0) continue;
    for (std::size_t j = 0; j < size; ++j) K[k * size + j] += of_row * now[j];
  }
  if (rubbing.is_on) add_rubbing(rubbing, weight, weight * friction_ * modulus * rubbing.reach * pressed.slope, past, now, K);
}

/// Where the spring holds, its stiffness; where it slips, its force turns with the slip and follows the normal force.
template <int Dim>
void BodyContact<Dim>::add_rubbing(const Rub& rubbing, Real weight, Real limit_slope, const std::vector<Real>& past,
                                   const std::vector<Real>& now, Real* K) const {
  const std::size_t size = past.size();
  const Real length = length_of<Dim>(rubbing.pull);
  const Vec<Dim> ahead = length > 0 ? scaled<Dim>(rubbing.pull, 1 / length) : Vec<Dim>{};
  const Real stiffness = weight * (!rubbing.slips ? rubbing.stiffness : length > 0 ? rubbing.limit / length : 0);
  for (std::size_t k = 0; k < size; ++k) {
    if (past[k] == 0) continue;
    const std::size_t i = k % Dim;
    Vec<Dim> row;
    for (std::size_t j = 0; j < Dim; ++j) {
      row[j] = (i == j ? 1 : 0) - rubbing.normal[i] * rubbing.normal[j];
      if (rubbing.slips) row[j] -= ahead[i] * ahead[j];
      row[j] *= stiffness * past[k];
    }
    const Real by_pressure = rubbing.slips && rubbing.limit > 0 ? limit_slope * past[k] * ahead[i] : 0;
    for (std::size_t j = 0; j < size; ++j) K[k * size + j] += row[j % Dim] * past[j] + by_pressure * now[j];
  }
}

template <int Dim>
void BodyContact<Dim>::balance(const std::vector<Real>& way) {
  for (Pair& pair : pairs_) pair.shifts = {};
  if (friction_ == 0 || !is_near() || way.empty()) return;
  move(way);
  for (const ContactPatch<Dim>& patch : patches_) {
    Pair& pair = pairs_[patch.pair];
    for (std::size_t point = 0; point < patch.points.size(); ++point) {
      const Meeting meeting = meet(patch, point);
      if (meeting.g0 <= 0) continue;
      Real change = 0;
      for (const Near& near : meeting.near) {
        if (near.q0 > 0) change -= volume(near.q) * pair.kernel.slope(near.q0) * dot(near.r0, minus<Dim>(near.r1, near.r0));
      }
      pair.shifts[patch.side][id(patch.points[point])] = change;
    }
  }
}

template <int Dim>
std::vector<std::array<std::size_t, 2>> BodyContact<Dim>::pairs() const {
  std::vector<std::array<std::size_t, 2>> all;
  for (const Pair& pair : pairs_) all.push_back(pair.sources);
  return all;
}

template <int Dim>
std::vector<std::vector<Real>> BodyContact<Dim>::pair_forces(bool is_dynamic) const {
  std::vector<std::vector<Real>> forces(pairs_.size(), std::vector<Real>(space_.nodes().size() * Dim, 0));
  std::vector<Real> residual;
  for (const ContactPatch<Dim>& patch : patches_) {
    residual.resize(patch.nodes.size() * Dim);
    work(patch, is_dynamic, residual.data(), nullptr);
    const auto first = static_cast<Index>(pairs_[patch.pair].sources[0]);
    for (std::size_t k = 0; k < residual.size(); ++k) {
      const auto node = static_cast<std::size_t>(patch.nodes[k / Dim]);
      if (space_.slots()[node] / space_.basis().node_count() == first) forces[patch.pair][node * Dim + k % Dim] -= residual[k];
    }
  }
  return forces;
}

template <int Dim>
Real BodyContact<Dim>::work_at_start() const {
  Real sum = 0;
  for (const ContactPatch<Dim>& patch : patches_) {
    for (std::size_t point = 0; point < patch.points.size(); ++point) {
      const Meeting meeting = meet(patch, point);
      if (meeting.g0 > 0) {
        const Pair& pair = pairs_[patch.pair];
        Real way = 0;
        for (const Near& near : meeting.near) {
          if (near.q0 > 0) way -= volume(near.q) * pair.kernel.slope(near.q0) * dot(near.r0, minus<Dim>(near.r1, near.r0));
        }
        sum += 0.5 * volume(patch.points[point]) * pair.stiffness * meeting.g0 * way;
      }
      const Rub rubbing = rub(patch, point, meeting, true);
      if (rubbing.is_on) sum += 0.5 * dot(rubbing.old_force, rubbing.slip);
    }
  }
  return sum;
}

template <int Dim>
bool BodyContact<Dim>::has_pressed() const {
  for (const ContactPatch<Dim>& patch : patches_) {
    for (std::size_t point = 0; point < patch.points.size(); ++point) {
      if (meet(patch, point).presses()) return true;
    }
  }
  return false;
}

template <int Dim>
Real BodyContact<Dim>::commit(bool is_dynamic) {
  Real taken = 0;
  std::vector<std::array<std::map<Index, Hold<Dim>>, 2>> holds(pairs_.size());
  for (const Pair& pair : pairs_) {
    for (const auto& side : pair.holds) {
      for (const auto& [id, hold] : side) taken += hold.energy;
    }
  }
  for (const ContactPatch<Dim>& patch : patches_) {
    for (std::size_t point = 0; point < patch.points.size(); ++point) {
      const Meeting meeting = meet(patch, point);
      const Rub rubbing = rub(patch, point, meeting, is_dynamic);
      if (!rubbing.is_on) continue;
      const Vec<Dim> pulled = scaled<Dim>(rubbing.force, 1 / rubbing.stiffness);
      const Real energy = 0.5 * rubbing.stiffness * dot(pulled, pulled);
      taken += dot(rubbing.force, rubbing.slip) - energy;
      holds[patch.pair][patch.side][id(patch.points[point])] = {pulled, energy, rubbing.slips};
    }
  }
  for (std::size_t p = 0; p < pairs_.size(); ++p) pairs_[p].holds = std::move(holds[p]);
  measure_energy();
  return taken;
}

template <int Dim>
void BodyContact<Dim>::measure_energy() {
  energy_ = 0;
  for (const Pair& pair : pairs_) {
    for (const auto& side : pair.holds) {
      for (const auto& [id, hold] : side) energy_ += hold.energy;
    }
  }
  for (const ContactPatch<Dim>& patch : patches_) {
    for (std::size_t point = 0; point < patch.points.size(); ++point) {
      const Real g = std::max(Real{0}, meet(patch, point).g1);
      energy_ += 0.5 * volume(patch.points[point]) * pairs_[patch.pair].stiffness * g * g;
    }
  }
}

template <int Dim>
void BodyContact<Dim>::declare_state(State& state) {
  for (Pair& pair : pairs_) {
    const auto name = [&](std::size_t side) { return space_.sources()[pair.sources[side]].points->name(); };
    for (std::size_t side : {0, 1}) {
      state.in(name(side) + "|" + name(1 - side), [&] {
        const std::size_t count = pair.at_touch[side].size();
        state.add("at_touch", pair.at_touch[side]);
        if (pair.at_touch[side].size() != count) state.fail("at_touch", fmt::format("has not {} numbers", count));
        state.rows("holds", pair.holds[side]);
      });
    }
  }
  state.add("is_first", is_first_);
}

template class BodyContact<2>;
template class BodyContact<3>;

}  // namespace matpoint
