// The particles of one body that are near another one, and what they do to each other (pair_contact.hpp). Private to pair_contact.cpp.
#pragma once

#include <algorithm>
#include <cmath>

#include "core/parallel.hpp"
#include "explicit/pair_contact.hpp"
#include "geometry/point_cells.hpp"

namespace matpoint {
namespace pair_detail {

// Of the dashpots of particles that rub, over the root of a particle's mass times the stiffness of its contact. Without them flat bodies
// ring against each other for ever: where their pressure swings to nothing and back they slip at less than Coulomb's force.
constexpr Real k_damping = 1;

// Particles per piece of work.
constexpr std::size_t k_piece = 64;

template <int Dim>
Real squared(const Vec<Dim>& a) {
  Real sum = 0;
  for (const Real x : a) sum += x * x;
  return sum;
}

template <int Dim>
Vec<Dim> scaled(Vec<Dim> a, Real factor) {
  for (Real& x : a) x *= factor;
  return a;
}

/// The part of a across the normal.
template <int Dim>
Vec<Dim> along(Vec<Dim> a, const Vec<Dim>& normal) {
  const Real across = dot(a, normal);
  for (std::size_t d = 0; d < Dim; ++d) a[d] -= across * normal[d];
  return a;
}

/// A neighbour of the other body, or the image of one.
struct Near {
  std::uint32_t point;
  std::uint32_t image;  ///< 0: itself.
  Real q;               ///< 1 - d^2 / R^2
};

}  // namespace pair_detail

/// What is known of a body's particles.
template <int Dim>
struct PairContact<Dim>::Points {
  const Body<Dim>* body;
  Real density;               ///< [kg/m^3]
  Real modulus;               ///< rho c^2 [Pa]
  std::vector<Real> volumes;  ///< In the reference configuration, by id [m^dim].
  Real spacing = 0;           ///< The largest [m].
  Forces forces;
  /// Where a particle was when it was last near another body, by id.
  struct Place {
    Index update = -2;  ///< In which update.
    Vec<Dim> x{};       ///< [m]
    Vec<Dim> way{};     ///< In the step before it [m].
    void declare_state(State& state) {
      state.add("update", update);
      state.add("position", x);
    }
  };
  std::vector<Place> places;
  Index number = 0;  ///< Of this update.

  /// What the particle has really moved since the last update. Its own velocity is another one: under FLIP it keeps what the grid does not
  /// move it by, and springs that followed it would work without end.
  Vec<Dim> way_of(const MovingPoint<Dim>& point, Real dt) {
    Place& place = places[static_cast<std::size_t>(point.id)];
    if (place.update == number) return place.way;
    for (std::size_t d = 0; d < Dim; ++d) place.way[d] = place.update == number - 1 ? point.x[d] - place.x[d] : point.v[d] * dt;
    place.x = point.x;
    place.update = number;
    return place.way;
  }

  void declare_state(State& state) {
    state.add("update", number);
    state.rows("places", places);
    state.add("ids", forces.ids);
    std::vector<Vec<Dim>> values(forces.ids.size());
    if (!state.is_loading()) {
      for (std::size_t k = 0; k < values.size(); ++k)
        std::copy_n(forces.values.begin() + static_cast<std::ptrdiff_t>(forces.ids[k] * Dim), Dim, values[k].begin());
    }
    state.add("forces", values);
    state.add("box_lower", forces.box.lower);
    state.add("box_upper", forces.box.upper);
    if (!state.is_loading()) return;
    if (values.size() != forces.ids.size()) state.fail("forces", "has not one row for each id");
    if (places.size() != (places.empty() ? 0 : volumes.size())) state.fail("places", "has not one row for each particle");
    std::fill(forces.values.begin(), forces.values.end(), 0);
    for (std::size_t k = 0; k < values.size(); ++k) {
      check_id(state, forces.ids[k]);
      std::copy_n(values[k].begin(), Dim, forces.values.begin() + static_cast<std::ptrdiff_t>(forces.ids[k] * Dim));
    }
  }
  void check_id(const State& state, Index id) const {
    if (id < 0 || id >= static_cast<Index>(volumes.size())) state.fail("ids", fmt::format("has {}, which no particle has", id));
  }

  void start_update() {
    ++number;
    forces.clear(volumes.size());
  }
};

/// Two bodies.
template <int Dim>
struct PairContact<Dim>::Pair {
  std::array<std::size_t, 2> bodies;
  PairKernel<Dim> kernel;
  Real stiffness;                             ///< K [Pa]
  std::array<std::vector<Real>, 2> at_touch;  ///< c0 of each particle, by id [1].
  std::array<std::vector<Hold>, 2> holds;     ///< Ascending ids.
  // Of the last search.
  bool is_near = false;
  bool is_searched = false;                        ///< Candidates are known.
  Extent<Dim> box{};                               ///< Around what may touch before the next search [m].
  std::array<std::vector<Index>, 2> candidates{};  ///< Ids of the particles that were in it.
  void declare_state(State& state) {
    for (std::size_t s : {0, 1}) {
      state.in(s == 0 ? "first" : "second", [&] {
        const std::size_t count = at_touch[s].size();
        state.add("at_touch", at_touch[s]);
        if (at_touch[s].size() != count) state.fail("at_touch", fmt::format("has {} numbers, not {}", at_touch[s].size(), count));
        state.rows("holds", holds[s]);
        state.add("candidates", candidates[s]);
      });
    }
    state.add("is_near", is_near);
    state.add("is_searched", is_searched);
    state.add("box_lower", box.lower);
    state.add("box_upper", box.upper);
  }
};

/// The particles of one body that are near another one.
template <int Dim>
struct PairContact<Dim>::Participant {
  Points& of;
  const std::vector<MirrorImage<Dim>>& images;
  const PairKernel<Dim>& kernel;
  const std::vector<Real>& at_touch;
  Real stiffness;   ///< K [Pa]
  Extent<Dim> box;  ///< Around what may touch [m].
  Cells<Dim> cells;
  std::vector<MovingPoint<Dim>> points;
  std::vector<Vec<Dim>> ways;  ///< Since the last update, where bodies rub [m].
  std::vector<Index> keys;     ///< Of the cells; ascending.
  std::vector<Real> volume;
  std::vector<std::vector<pair_detail::Near>> near;  ///< Of each piece, one particle after the other.
  std::vector<std::size_t> begin;                    ///< Of a particle's neighbours in those of its piece.
  std::vector<std::size_t> end;
  std::vector<Real> c;
  std::vector<Real> pressure;  ///< K <c - c0> [Pa]
  std::vector<Real> energy;    ///< [J]
  std::vector<Vec<Dim>> force;
  std::vector<Vec<Dim>> own_force;  ///< The share of `force` from the particle's own part of Phi.
  std::vector<Vec<Dim>> friction;
  std::vector<Hold> holds;
  std::vector<Real> slip_work;  ///< [J]

  Participant(Points& body, const std::vector<MirrorImage<Dim>>& all_images, const Pair& pair, std::size_t side)
      : of(body),
        images(all_images),
        kernel(pair.kernel),
        at_touch(pair.at_touch[side]),
        stiffness(pair.stiffness),
        box(pair.box),
        cells(pair.box, pair.kernel.range()),
        points(body.body->particles_in(pair.box, pair.is_searched ? &pair.candidates[side] : nullptr)) {}

  std::size_t count() const { return points.size(); }

  template <class F>
  void for_each(F&& f) const {
    const std::size_t n = count();
    parallel_for(static_cast<Index>((n + pair_detail::k_piece - 1) / pair_detail::k_piece), static_cast<Index>(n), [&](Index piece) {
      const auto first = static_cast<std::size_t>(piece) * pair_detail::k_piece;
      for (std::size_t i = first; i < std::min(first + pair_detail::k_piece, n); ++i) f(i);
    });
  }
  template <class F>
  void for_each_near(std::size_t i, F&& f) const {
    const std::vector<pair_detail::Near>& all = near[i / pair_detail::k_piece];
    for (std::size_t k = begin[i]; k < end[i]; ++k) f(all[k].point, all[k].q, images[all[k].image]);
  }

  /// Sorts the particles by cells, and by their ids in each.
  void sort() {
    struct Place {
      Index key;
      Index id;
      std::size_t point;
    };
    std::vector<Place> order;
    order.reserve(count());
    for (std::size_t i = 0; i < count(); ++i) order.push_back({cells.key_of(cells.cell_of(points[i].x)), points[i].id, i});
    std::sort(order.begin(), order.end(), [](const Place& a, const Place& b) { return a.key != b.key ? a.key < b.key : a.id < b.id; });
    std::vector<MovingPoint<Dim>> sorted;
    sorted.reserve(count());
    for (const Place& place : order) {
      keys.push_back(place.key);
      sorted.push_back(points[place.point]);
      volume.push_back(of.volumes[static_cast<std::size_t>(place.id)]);
    }
    points = std::move(sorted);
  }

  /// Ascending ids of those that are nearer to the other side than `reach`, or little farther.
  std::vector<Index> ids_within(Real reach, const Participant& other) const {
    const Cells<Dim> wide(box, reach);
    std::vector<Index> filled;
    for (const MovingPoint<Dim>& point : other.points) filled.push_back(wide.key_of(wide.cell_of(point.x)));
    std::sort(filled.begin(), filled.end());
    filled.erase(std::unique(filled.begin(), filled.end()), filled.end());
    std::vector<Index> ids;
    for (const MovingPoint<Dim>& point : points) {
      bool is_near = false;
      wide.for_each_row_near(point.x, [&](Index first, Index last) {
        const auto at = std::lower_bound(filled.begin(), filled.end(), first);
        is_near = is_near || (at != filled.end() && *at <= last);
      });
      if (is_near) ids.push_back(point.id);
    }
    std::sort(ids.begin(), ids.end());
    return ids;
  }

  void find_near(const Participant& other) {
    const std::size_t n = count();
    near.resize((n + pair_detail::k_piece - 1) / pair_detail::k_piece);
    begin.resize(n);
    end.resize(n);
    const Real factor = 1 / (kernel.range() * kernel.range());
    for_each([&](std::size_t i) {
      std::vector<pair_detail::Near>& all = near[i / pair_detail::k_piece];
      begin[i] = all.size();
      other.cells.for_each_row_near(points[i].x, [&](Index first, Index last) {
        auto j = static_cast<std::size_t>(std::lower_bound(other.keys.begin(), other.keys.end(), first) - other.keys.begin());
        for (; j < other.keys.size() && other.keys[j] <= last; ++j) {
          // An image is never nearer than what it is the image of.
          for (std::size_t image = 0; image < images.size(); ++image) {
            const Vec<Dim> x = images[image].place(other.points[j].x);
            Real d2 = 0;
            for (std::size_t d = 0; d < Dim; ++d) d2 += (points[i].x[d] - x[d]) * (points[i].x[d] - x[d]);
            const Real q = 1 - d2 * factor;
            if (q > 0)
              all.push_back({static_cast<std::uint32_t>(j), static_cast<std::uint32_t>(image), q});
            else if (image == 0)
              break;
          }
        }
      });
      end[i] = all.size();
    });
  }

  /// c and the pressure.
  void press(const Participant& other) {
    c.resize(count());
    pressure.resize(count());
    energy.resize(count());
    for_each([&](std::size_t i) {
      Real sum = 0;
      for_each_near(i, [&](std::size_t j, Real q, const MirrorImage<Dim>&) { sum += other.volume[j] * kernel.value(q); });
      c[i] = sum;
      pressure[i] = 0;
      energy[i] = 0;
      if (sum == 0) return;
      const Real over = sum - at_touch[static_cast<std::size_t>(points[i].id)];
      if (over <= 0) return;
      pressure[i] = stiffness * over;
      energy[i] = 0.5 * volume[i] * stiffness * over * over;
    });
  }

  void push(const Participant& other) {
    force.resize(count());
    own_force.resize(count());
    for_each([&](std::size_t i) {
      Vec<Dim> all{};
      Vec<Dim> own{};
      for_each_near(i, [&](std::size_t j, Real q, const MirrorImage<Dim>& image) {
        const Real both = pressure[i] + other.pressure[j];
        if (both == 0) return;
        const Real factor = volume[i] * other.volume[j] * kernel.slope(q);
        const Vec<Dim> x = image.place(other.points[j].x);
        for (std::size_t d = 0; d < Dim; ++d) {
          const Real away = factor * (points[i].x[d] - x[d]);
          all[d] += both * away;
          own[d] += pressure[i] * away;
        }
      });
      force[i] = all;
      own_force[i] = own;
    });
  }

  /// The force of friction on each particle that presses, by its own share. `held`: ascending ids.
  void rub(const Participant& other, const std::vector<Hold>& held, Real coefficient, Real dt) {
    // As stiff along the surface as across it, where a flat one begins to press.
    const Real w = kernel.over_plane(kernel.range() / (2 * k_pair_range));
    friction.assign(count(), {});
    holds.assign(count(), {-1, {}, 0});
    slip_work.assign(count(), 0);
    for_each([&](std::size_t i) {
      const Real normal_force = std::sqrt(pair_detail::squared<Dim>(own_force[i]));
      if (normal_force == 0) return;
      Hold& hold = holds[i];
      hold.id = points[i].id;
      const auto old = std::lower_bound(held.begin(), held.end(), hold.id, [](const Hold& one, Index id) { return one.id < id; });
      if (old != held.end() && old->id == hold.id) hold.pulled = old->pulled;
      // The spring turns with the surface and keeps its length.
      const Vec<Dim> normal = pair_detail::scaled<Dim>(own_force[i], 1 / normal_force);
      const Real before = std::sqrt(pair_detail::squared<Dim>(hold.pulled));
      hold.pulled = pair_detail::along<Dim>(hold.pulled, normal);
      const Real turned = std::sqrt(pair_detail::squared<Dim>(hold.pulled));
      if (turned > 0) hold.pulled = pair_detail::scaled<Dim>(hold.pulled, before / turned);
      const Real k = stiffness * w * w * volume[i];
      const Real damping = pair_detail::k_damping * std::sqrt(stiffness * volume[i] * of.density * volume[i]) * w;
      const Vec<Dim> past = way_past(other, i);
      const Real rate = dt > 0 ? 1 / dt : 0;  // 0: the update after particles were set or removed
      const Real parting = dot(past, normal) * rate;
      // Dashpots push only.
      const Real damped = std::max(-normal_force, -damping * parting);
      const Vec<Dim> sliding = pair_detail::along<Dim>(past, normal);
      for (std::size_t d = 0; d < Dim; ++d) hold.pulled[d] += sliding[d];
      const Real length = std::sqrt(pair_detail::squared<Dim>(hold.pulled));
      const Real greatest = coefficient * (normal_force + damped);
      if (k * length > greatest) {
        // All that the spring loses: it also gives way where the normal force falls.
        slip_work[i] = 0.5 * (k * length * length - greatest * greatest / k);
        hold.pulled = pair_detail::scaled<Dim>(hold.pulled, greatest / (k * length));
      }
      hold.energy = 0.5 * k * pair_detail::squared<Dim>(hold.pulled);
      Vec<Dim> pull;
      for (std::size_t d = 0; d < Dim; ++d) pull[d] = k * hold.pulled[d] + damping * rate * sliding[d];
      const Real size = std::sqrt(pair_detail::squared<Dim>(pull));
      if (size > greatest) pull = pair_detail::scaled<Dim>(pull, greatest / size);
      for (std::size_t d = 0; d < Dim; ++d) {
        slip_work[i] += (pull[d] - k * hold.pulled[d]) * sliding[d];
        friction[i][d] = damped * normal[d] - pull[d];
      }
      slip_work[i] -= damped * parting * dt;
    });
  }

  /// Way of a particle since the last update against the mean of its neighbours [m].
  Vec<Dim> way_past(const Participant& other, std::size_t i) const {
    Vec<Dim> past = ways[i];
    for_each_near(i, [&](std::size_t j, Real q, const MirrorImage<Dim>& image) {
      const Real weight = other.volume[j] * kernel.value(q) / c[i];
      const Vec<Dim> u = image.direction(other.ways[j]);
      for (std::size_t d = 0; d < Dim; ++d) past[d] -= weight * u[d];
    });
    return past;
  }

  /// What the friction of the other side's particles takes here.
  void take_friction(const Participant& other) {
    for_each([&](std::size_t i) {
      for_each_near(i, [&](std::size_t j, Real q, const MirrorImage<Dim>& image) {
        if (other.pressure[j] == 0) return;
        const Real weight = volume[i] * kernel.value(q) / other.c[j];
        const Vec<Dim> rubbing = image.direction(other.friction[j]);
        for (std::size_t d = 0; d < Dim; ++d) force[i][d] -= weight * rubbing[d];
      });
      for (std::size_t d = 0; d < Dim; ++d) force[i][d] += friction[i][d];
    });
  }
};

}  // namespace matpoint
