#include "explicit/pair_contact.hpp"

#include <algorithm>
#include <cmath>

#include "explicit/pair_participant.hpp"

namespace matpoint {
namespace {

// Of the longest step for which a linear spring is stable. Springs that only push make energy in long steps: a stack of three blocks at
// rest gains 5.7 % of its energy in 5 s at half of it, 1 % at a quarter, nothing at an eighth; where bodies rub, dashpots do away with it
// up to 0.4.
constexpr Real k_step_share = 0.3;

}  // namespace

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
          const SurfaceRows rows = SurfaceRows::of_particles(points_[pair.bodies[1 - s]].spacing);
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
    if (pair_detail::squared<Dim>(side.force[i]) == 0) continue;
    const Index id = side.points[i].id;
    forces.ids.push_back(id);
    for (std::size_t d = 0; d < Dim; ++d) forces.values[static_cast<std::size_t>(id) * Dim + d] += side.force[i][d];
  }
}

template class PairContact<2>;
template class PairContact<3>;

}  // namespace matpoint
