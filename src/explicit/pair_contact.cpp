#include "explicit/pair_contact.hpp"

#include <algorithm>
#include <cmath>

#include "core/parallel.hpp"
#include "geometry/point_cells.hpp"

namespace matpoint {
namespace {

// Of the dashpots of particles that rub, over the root of a particle's mass times the stiffness of its contact. Without them flat bodies
// ring against each other for ever: where their pressure swings to nothing and back they slip at less than Coulomb's force.
constexpr Real k_damping = 1;

// Of the longest step for which a linear spring is stable. Springs that only push make energy in long steps: a stack of three blocks at
// rest gains 5.7 % of its energy in 5 s at half of it, 1 % at a quarter, nothing at an eighth; where bodies rub, dashpots do away with it
// up to 0.4.
constexpr Real k_step_share = 0.3;

// Particles per piece of work.
constexpr std::size_t k_piece = 64;

template <int Dim>
Real squared(const Vec<Dim>& a) {
  Real sum = 0;
  for (const Real x : a) sum += x * x;
  return sum;
}

template <int Dim>
Real dot(const Vec<Dim>& a, const Vec<Dim>& b) {
  Real sum = 0;
  for (std::size_t d = 0; d < Dim; ++d) sum += a[d] * b[d];
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
  const Real across = dot<Dim>(a, normal);
  for (std::size_t d = 0; d < Dim; ++d) a[d] -= across * normal[d];
  return a;
}

/// A neighbour of the other body, or the image of one.
struct Near {
  std::uint32_t point;
  std::uint32_t image;  ///< 0: itself.
  Real q;               ///< 1 - d^2 / R^2
};

}  // namespace

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
    for (const Index id : forces.ids) std::fill_n(forces.values.begin() + static_cast<std::ptrdiff_t>(id * Dim), Dim, 0);
    forces.ids.clear();
    forces.box.lower.fill(std::numeric_limits<Real>::infinity());
    forces.box.upper.fill(-std::numeric_limits<Real>::infinity());
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
  std::vector<std::vector<Near>> near;  ///< Of each piece, one particle after the other.
  std::vector<std::size_t> begin;       ///< Of a particle's neighbours in those of its piece.
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
    parallel_for(static_cast<Index>((n + k_piece - 1) / k_piece), static_cast<Index>(n), [&](Index piece) {
      const auto first = static_cast<std::size_t>(piece) * k_piece;
      for (std::size_t i = first; i < std::min(first + k_piece, n); ++i) f(i);
    });
  }
  template <class F>
  void for_each_near(std::size_t i, F&& f) const {
    const std::vector<Near>& all = near[i / k_piece];
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
    near.resize((n + k_piece - 1) / k_piece);
    begin.resize(n);
    end.resize(n);
    const Real factor = 1 / (kernel.range() * kernel.range());
    for_each([&](std::size_t i) {
      std::vector<Near>& all = near[i / k_piece];
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
      const Real normal_force = std::sqrt(squared<Dim>(own_force[i]));
      if (normal_force == 0) return;
      Hold& hold = holds[i];
      hold.id = points[i].id;
      const auto old = std::lower_bound(held.begin(), held.end(), hold.id, [](const Hold& one, Index id) { return one.id < id; });
      if (old != held.end() && old->id == hold.id) hold.pulled = old->pulled;
      // The spring turns with the surface and keeps its length.
      const Vec<Dim> normal = scaled<Dim>(own_force[i], 1 / normal_force);
      const Real before = std::sqrt(squared<Dim>(hold.pulled));
      hold.pulled = along<Dim>(hold.pulled, normal);
      const Real turned = std::sqrt(squared<Dim>(hold.pulled));
      if (turned > 0) hold.pulled = scaled<Dim>(hold.pulled, before / turned);
      const Real k = stiffness * w * w * volume[i];
      const Real damping = k_damping * std::sqrt(stiffness * volume[i] * of.density * volume[i]) * w;
      const Vec<Dim> past = way_past(other, i);
      const Real rate = dt > 0 ? 1 / dt : 0;  // 0: the update after particles were set or removed
      const Real parting = dot<Dim>(past, normal) * rate;
      // Dashpots push only.
      const Real damped = std::max(-normal_force, -damping * parting);
      const Vec<Dim> sliding = along<Dim>(past, normal);
      for (std::size_t d = 0; d < Dim; ++d) hold.pulled[d] += sliding[d];
      const Real length = std::sqrt(squared<Dim>(hold.pulled));
      const Real greatest = coefficient * (normal_force + damped);
      if (k * length > greatest) {
        // All that the spring loses: it also gives way where the normal force falls.
        slip_work[i] = 0.5 * (k * length * length - greatest * greatest / k);
        hold.pulled = scaled<Dim>(hold.pulled, greatest / (k * length));
      }
      hold.energy = 0.5 * k * squared<Dim>(hold.pulled);
      Vec<Dim> pull;
      for (std::size_t d = 0; d < Dim; ++d) pull[d] = k * hold.pulled[d] + damping * rate * sliding[d];
      const Real size = std::sqrt(squared<Dim>(pull));
      if (size > greatest) pull = scaled<Dim>(pull, greatest / size);
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

template <int Dim>
PairContact<Dim>::~PairContact() = default;

template <int Dim>
PairContact<Dim>::PairContact(const Case& problem, std::vector<const Body<Dim>*> bodies)
    : images_(mirror_images<Dim>(problem)), friction_(problem.solver.friction) {
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const Material& material = *problem.bodies[b].material;
    const Real speed = material.wave_speed(1);
    Points points;
    points.body = bodies[b];
    points.density = material.density();
    points.modulus = material.density() * speed * speed;
    points.volumes = bodies[b]->field("mass", b).values;
    for (Real& volume : points.volumes) volume /= points.density;
    points.spacing = std::pow(*std::max_element(points.volumes.begin(), points.volumes.end()), Real{1} / Dim);
    points.forces.values.assign(points.volumes.size() * Dim, 0);
    if (friction_ > 0) points.places.resize(points.volumes.size());
    points_.push_back(std::move(points));
  }
  stable_dt_ = std::numeric_limits<Real>::infinity();
  for (std::size_t a = 0; a < points_.size(); ++a) {
    for (std::size_t b = a + 1; b < points_.size(); ++b) {
      const PairKernel<Dim> kernel(k_pair_range * std::max(points_[a].spacing, points_[b].spacing));
      const Real stiffness = problem.solver.contact_stiffness * std::min(points_[a].modulus, points_[b].modulus);
      Pair pair{{a, b}, kernel, stiffness, {}, {}};
      for (std::size_t s : {0, 1}) {
        // Most bodies have particles of one volume.
        Real last = 0;
        for (const Real volume : points_[pair.bodies[s]].volumes) {
          const Real half = 0.5 * std::pow(volume, Real{1} / Dim);
          const Real rows = points_[pair.bodies[1 - s]].spacing;
          pair.at_touch[s].push_back(volume == last ? pair.at_touch[s].back() : kernel.beyond_surface(half, rows));
          last = volume;
        }
      }
      pairs_.push_back(std::move(pair));
      // Layers of particles against each other have omega^2 = 2 K w^2 (1 / rho_a + 1 / rho_b), w the change of c per distance; half as
      // much again for the layers behind them and for c's curvature.
      const Real w = kernel.over_plane(0);
      const Real omega = std::sqrt(3 * stiffness * w * w * (1 / points_[a].density + 1 / points_[b].density));
      stable_dt_ = std::min(stable_dt_, k_step_share * 2 / omega);
    }
  }
}

template <int Dim>
void PairContact<Dim>::declare_state(State& state) {
  state.parts("body", points_);
  state.parts("pair", pairs_);
  state.add("is_first", is_first_);
  state.add("free_way", free_way_);
  if (!state.is_loading()) return;
  for (const Pair& pair : pairs_) {
    for (std::size_t s : {0, 1}) {
      for (const Index id : pair.candidates[s]) points_[pair.bodies[s]].check_id(state, id);
    }
  }
}

template <int Dim>
const typename PairContact<Dim>::Forces& PairContact<Dim>::forces(std::size_t body) const {
  return points_[body].forces;
}

template <int Dim>
void PairContact<Dim>::forget_places() {
  free_way_ = 0;
  for (Points& points : points_) ++points.number;
}

template <int Dim>
void PairContact<Dim>::update(Real dt) {
  // Two bodies move towards each other with the sum of their speeds. Particles move with the grid's velocities and not with their own;
  // the range of W, which is more than twice the distance of particles that touch, leaves room for that.
  Real speed = 0;
  for (const Points& points : points_) speed = std::max(speed, points.body->greatest_speed());
  free_way_ -= 2 * speed * dt;
  if (!(free_way_ > 0)) search();
  energy_ = 0;
  dissipated_ = 0;
  for (Points& points : points_) points.start_update();
  for (Pair& pair : pairs_) {
    if (pair.is_near)
      meet(pair, dt);
    else
      let_go(pair, {});
  }
  is_first_ = false;
  // A particle may touch two bodies.
  for (Points& points : points_) {
    std::vector<Index>& ids = points.forces.ids;
    std::sort(ids.begin(), ids.end());
    ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  }
}

/// Up to this distance particles are candidates: half a range more, which they may move before the next search [m].
template <int Dim>
Real PairContact<Dim>::reach_of(const Pair& pair) {
  return 1.5 * pair.kernel.range();
}

/// Which bodies are near each other, and where.
template <int Dim>
void PairContact<Dim>::search() {
  std::vector<Extent<Dim>> extents;
  for (const Points& points : points_) extents.push_back(points.body->extent());
  free_way_ = std::numeric_limits<Real>::infinity();
  for (Pair& pair : pairs_) {
    const Extent<Dim>& a = extents[pair.bodies[0]];
    const Extent<Dim>& b = extents[pair.bodies[1]];
    const Real reach = reach_of(pair);
    const Real gap = gap_of<Dim>(a, b);
    pair.is_near = gap < reach;
    pair.is_searched = false;
    free_way_ = std::min(free_way_, pair.is_near ? reach - pair.kernel.range() : gap - pair.kernel.range());
    for (std::size_t d = 0; d < Dim; ++d) {
      pair.box.lower[d] = std::max(a.lower[d], b.lower[d]) - reach;
      pair.box.upper[d] = std::min(a.upper[d], b.upper[d]) + reach;
    }
  }
}

template <int Dim>
void PairContact<Dim>::meet(Pair& pair, Real dt) {
  Participant sides[2] = {{points_[pair.bodies[0]], images_, pair, 0}, {points_[pair.bodies[1]], images_, pair, 1}};
  for (std::size_t s = 0; s < 2 && !pair.is_searched; ++s) pair.candidates[s] = sides[s].ids_within(reach_of(pair), sides[1 - s]);
  pair.is_searched = true;
  if (sides[0].count() == 0 || sides[1].count() == 0) {
    let_go(pair, {});
    return;
  }
  for (Participant& side : sides) side.sort();
  for (int s : {0, 1}) sides[s].find_near(sides[1 - s]);
  for (int s : {0, 1}) sides[s].press(sides[1 - s]);
  if (is_first_) {
    lay(pair, sides);
    for (int s : {0, 1}) sides[s].press(sides[1 - s]);
  }
  for (int s : {0, 1}) sides[s].push(sides[1 - s]);
  if (friction_ > 0) rub(pair, sides, dt);
  for (const Participant& side : sides) {
    for (const Real energy : side.energy) energy_ += energy;
    add_forces(side);
  }
}

/// Bodies that are laid on each other touch without a force: their lattices, which c sees to a thousandth, may not lift them.
template <int Dim>
void PairContact<Dim>::lay(Pair& pair, const Participant (&sides)[2]) {
  constexpr Real k_seen = 0.01;
  for (std::size_t s : {0, 1}) {
    for (std::size_t i = 0; i < sides[s].count(); ++i) {
      Real& at_touch = pair.at_touch[s][static_cast<std::size_t>(sides[s].points[i].id)];
      const Real c = sides[s].c[i];
      if (c > at_touch && c < at_touch + k_seen) at_touch = c;
    }
  }
}

template <int Dim>
void PairContact<Dim>::rub(Pair& pair, Participant (&sides)[2], Real dt) {
  for (Participant& side : sides) {
    for (const MovingPoint<Dim>& point : side.points) side.ways.push_back(side.of.way_of(point, dt));
  }
  for (int s : {0, 1}) sides[s].rub(sides[1 - s], pair.holds[s], friction_, dt);
  for (int s : {0, 1}) sides[s].take_friction(sides[1 - s]);
  std::array<std::vector<Hold>, 2> holds;
  for (std::size_t s : {0, 1}) {
    for (const Real work : sides[s].slip_work) dissipated_ += work;
    for (const Hold& hold : sides[s].holds) {
      if (hold.id < 0) continue;
      holds[s].push_back(hold);
      energy_ += hold.energy;
    }
    std::sort(holds[s].begin(), holds[s].end(), [](const Hold& one, const Hold& other) { return one.id < other.id; });
  }
  let_go(pair, std::move(holds));
}

/// The springs of particles that no longer touch lose what they have stored.
template <int Dim>
void PairContact<Dim>::let_go(Pair& pair, std::array<std::vector<Hold>, 2> holds) {
  for (std::size_t s : {0, 1}) {
    auto next = holds[s].begin();
    for (const Hold& hold : pair.holds[s]) {
      while (next != holds[s].end() && next->id < hold.id) ++next;
      if (next == holds[s].end() || next->id != hold.id) dissipated_ += hold.energy;
    }
  }
  pair.holds = std::move(holds);
}

template <int Dim>
void PairContact<Dim>::add_forces(const Participant& side) {
  Forces& forces = side.of.forces;
  for (std::size_t d = 0; d < Dim; ++d) {
    forces.box.lower[d] = std::min(forces.box.lower[d], side.box.lower[d]);
    forces.box.upper[d] = std::max(forces.box.upper[d], side.box.upper[d]);
  }
  for (std::size_t i = 0; i < side.count(); ++i) {
    if (squared<Dim>(side.force[i]) == 0) continue;
    const Index id = side.points[i].id;
    forces.ids.push_back(id);
    for (std::size_t d = 0; d < Dim; ++d) forces.values[static_cast<std::size_t>(id) * Dim + d] += side.force[i][d];
  }
}

template class PairContact<2>;
template class PairContact<3>;

}  // namespace matpoint
