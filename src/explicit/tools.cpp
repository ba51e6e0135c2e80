#include "explicit/tools.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/parallel.hpp"

namespace matpoint {
namespace {

/// Of the longest step for which a linear spring is stable. Measured: blocks that bounce at a hundredth to a third of their wave speed come
/// back with 0.96 to 1.00 of their energy at 0.6, and at most 3 % more of it while they touch.
constexpr Real k_step_share = 0.5;
/// Of the dashpots beside the springs, over the root of stiffness times mass, as for springs between bodies (pair_participant.hpp). What
/// rests on a tool would ring ever louder: the stress follows velocities that are mapped twice, and the overlaps those that move the
/// particles. With 0 a block of 90 kg under a load makes 4.6 J in 3 s, with 0.4 0.15, with 1 0.04; one that bounces keeps 0.92 to 0.96 of
/// its energy for 0.96 to 0.98.
constexpr Real k_damping = 1;
/// Of what would stop a particle in one step: what sticks gives way by next to nothing.
constexpr Real k_stopping = 0.5;

Vec3 difference(const Vec3& a, const Vec3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

template <int Dim>
Vec3 widened(const Vec<Dim>& a) {
  Vec3 b{};
  std::copy(a.begin(), a.end(), b.begin());
  return b;
}

}  // namespace

template <int Dim>
Real Tools<Dim>::Touched::reach(std::size_t tool, Index id) const {
  const auto& all = laid[tool];
  const auto own = std::lower_bound(all.begin(), all.end(), std::make_pair(id, Real{0}));
  return own != all.end() && own->first == id ? own->second : half[static_cast<std::size_t>(id)];
}

template <int Dim>
Real Tools<Dim>::Touched::last_overlap(std::size_t tool, Index id, Real overlap) const {
  const auto& all = last_touches[tool];
  const auto own = std::lower_bound(all.begin(), all.end(), id, [](const Touch& touch, Index of) { return touch.id < of; });
  return own != all.end() && own->id == id ? own->overlap : overlap;
}

template <int Dim>
Tools<Dim>::Tools(const Case& problem, std::vector<const Body<Dim>*> bodies) {
  std::copy_n(problem.grid.lower.begin(), Dim, grid_.lower.begin());
  std::copy_n(problem.grid.upper.begin(), Dim, grid_.upper.begin());
  for (const ToolSpec& spec : problem.tools) {
    tools_.push_back({spec.name, spec.shape, RigidMotion(spec, Dim), spec.friction, spec.stiffness, {}, {}, 0, 0, {}, {}});
    totals_.push_back({spec.name, {}, {}, 0});
  }
  half_min_ = std::numeric_limits<Real>::infinity();
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const Material& material = *problem.bodies[b].material;
    const Real speed = material.wave_speed(1);
    Touched touched;
    touched.body = bodies[b];
    touched.modulus = material.density() * speed * speed;
    touched.mass = bodies[b]->field("mass", b).values;
    const std::vector<Real> positions = bodies[b]->field("position", b).values;
    for (std::size_t p = 0; p < touched.mass.size(); ++p) {
      const Real volume = touched.mass[p] / material.density();
      touched.volume.push_back(volume);
      // Around an axis a ring ends where its section does.
      const Real section = problem.grid.is_axisymmetric ? volume / (2 * std::numbers::pi * positions[Dim * p]) : volume;
      touched.half.push_back(0.5 * std::pow(section, Real{1} / Dim));
      half_min_ = std::min(half_min_, touched.half.back());
      for (const Tool& tool : tools_)
        k_over_m_ = std::max(k_over_m_, tool.stiffness * touched.modulus / (material.density() * 4 * std::pow(touched.half.back(), 2)));
    }
    touched.laid.resize(tools_.size());
    for (std::size_t t = 0; t < tools_.size(); ++t) {
      for (std::size_t p = 0; p < touched.mass.size(); ++p) {
        Vec3 x{};
        std::copy_n(positions.begin() + static_cast<std::ptrdiff_t>(Dim * p), Dim, x.begin());
        const Real distance = tools_[t].shape->surface_near(x, Dim)->distance;
        if (distance > touched.half[p]) continue;
        if (distance <= 0) {
          const std::string& place = problem.tools[t].place;
          throw InputError("{}{}tool \"{}\": particle {} of body \"{}\" at ({:.6g}) is in it; move it, or cut it out of the body's region",
                           place, place.empty() ? "" : ": ", tools_[t].name, p, bodies[b]->name(),
                           fmt::join(x.begin(), x.begin() + Dim, ", "));
        }
        touched.laid[t].emplace_back(static_cast<Index>(p), distance);
      }
    }
    touched.forces.clear(touched.mass.size());
    touched.last_forces.clear(touched.mass.size());
    touched.places.resize(touched.mass.size());
    touched.last_places.resize(touched.mass.size());
    touched.touches.resize(tools_.size());
    touched.last_touches.resize(tools_.size());
    touched_.push_back(std::move(touched));
  }
}

template <int Dim>
void Tools<Dim>::advance(Real t, Real dt, const Vec3& gravity) {
  for (Tool& tool : tools_) {
    const Vec3 before = tool.motion.pivot();
    tool.motion.advance(t, dt, tool.force, tool.torque, gravity);
    tool.way = difference(tool.motion.pivot(), before);
    for (std::size_t d = 0; d < 3; ++d) tool.turn[d] = dt * tool.motion.angular_velocity()[d];
    if (!tool.motion.is_free() || gap_of<Dim>(box_of(tool, 0), grid_) <= 0) continue;
    const Vec3 x = tool.motion.center();
    throw SolverError(
        "t = {:.8g} s: tool \"{}\", which moves freely, has left the grid; its centre is at ({:.6g}); sides of the grid do not hold tools: "
        "hold it (held, hinge), end the run before, or enlarge the grid",
        t + dt, tool.name, fmt::join(x.begin(), x.begin() + Dim, ", "));
  }
}

/// A box around a tool where it is now, and so much more.
template <int Dim>
Extent<Dim> Tools<Dim>::box_of(const Tool& tool, Real margin) const {
  constexpr Real k_far = std::numeric_limits<Real>::infinity();
  const Vec3 lower = tool.shape->lower(), upper = tool.shape->upper();
  Extent<Dim> box;
  box.lower.fill(-k_far);
  box.upper.fill(k_far);
  Vec3 middle{}, half{};
  for (std::size_t d = 0; d < Dim; ++d) {
    middle[d] = 0.5 * (lower[d] + upper[d]);
    half[d] = 0.5 * (upper[d] - lower[d]);
    if (!std::isfinite(middle[d]) || !std::isfinite(half[d])) return box;
  }
  const Vec3 from_pivot = tool.motion.turned(difference(middle, tool.motion.at_start(tool.motion.pivot())));
  for (std::size_t d = 0; d < Dim; ++d) {
    Real reach = margin;
    for (std::size_t e = 0; e < Dim; ++e) {
      Vec3 side{};
      side[e] = half[e];
      reach += std::abs(tool.motion.turned(side)[d]);
    }
    const Real place = tool.motion.pivot()[d] + from_pivot[d];
    box.lower[d] = place - reach;
    box.upper[d] = place + reach;
  }
  return box;
}

template <int Dim>
void Tools<Dim>::touch(std::size_t number, Touched& body, Real dt) {
  Tool& tool = tools_[number];
  const Real margin = *std::max_element(body.half.begin(), body.half.end());
  const Extent<Dim> box = box_of(tool, margin);
  if (gap_of<Dim>(box, body.body->extent()) > 0) return;
  const std::vector<MovingPoint<Dim>> points = body.body->particles_in(box, nullptr);
  struct Push {
    Real overlap = 0;
    Real k = 0;
    Vec3 force{};  ///< On the particle.
  };
  std::vector<Push> pushes(points.size());
  constexpr std::size_t k_piece = 256;
  const std::size_t pieces = (points.size() + k_piece - 1) / k_piece;
  parallel_for(static_cast<Index>(pieces), static_cast<Index>(points.size()) * 4, [&](Index piece) {
    const std::size_t begin = static_cast<std::size_t>(piece) * k_piece, end = std::min(points.size(), begin + k_piece);
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3 x = widened<Dim>(points[i].x);
      const NearSurface near = *tool.shape->surface_near(tool.motion.at_start(x), Dim);
      const auto id = static_cast<std::size_t>(points[i].id);
      const Real overlap = body.reach(number, points[i].id) - near.distance;
      if (!(overlap > 0)) continue;
      Push& push = pushes[i];
      push.overlap = overlap;
      push.k = tool.stiffness * body.modulus * body.volume[id] / (4 * body.half[id] * body.half[id]);
      const Vec3 normal = tool.motion.turned(near.normal);
      Real pressing = push.k * overlap;
      if (dt > 0) {
        const Real rate = (overlap - body.last_overlap(number, points[i].id, overlap)) / dt;
        pressing = std::max(Real{0}, pressing + k_damping * std::sqrt(push.k * body.mass[id]) * rate);
      }
      for (std::size_t d = 0; d < 3; ++d) push.force[d] = pressing * normal[d];
      if (tool.friction == 0 || dt == 0) continue;
      Vec3 slip = difference(widened<Dim>(points[i].v), tool.motion.velocity_of(x));
      const Real across = dot(slip, normal);
      for (std::size_t d = 0; d < 3; ++d) slip[d] -= across * normal[d];
      const Real speed = std::sqrt(dot(slip, slip));
      if (speed == 0) continue;
      const Real rubbing = std::min(tool.friction * pressing, k_stopping * body.mass[id] * speed / dt);
      for (std::size_t d = 0; d < 3; ++d) push.force[d] -= rubbing * slip[d] / speed;
    }
  });
  ParticleForces<Dim>& forces = body.forces;
  for (std::size_t i = 0; i < points.size(); ++i) {
    body.places[static_cast<std::size_t>(points[i].id)] = {number_, points[i].x};
    const Push& push = pushes[i];
    if (push.overlap == 0) continue;
    const auto id = static_cast<std::size_t>(points[i].id);
    body.touches[number].push_back({points[i].id, push.overlap});
    tool.overlap = std::max(tool.overlap, push.overlap / body.half[id]);
    tool.k_sum += push.k;
    energy_ += 0.5 * push.k * push.overlap * push.overlap;
    const Vec3 torque = cross(difference(widened<Dim>(points[i].x), tool.motion.pivot()), push.force);
    for (std::size_t d = 0; d < 3; ++d) {
      tool.force[d] -= push.force[d];
      tool.torque[d] -= torque[d];
    }
    forces.ids.push_back(points[i].id);
    for (std::size_t d = 0; d < Dim; ++d) {
      forces.values[id * Dim + d] += push.force[d];
      forces.box.lower[d] = std::min(forces.box.lower[d], points[i].x[d]);
      forces.box.upper[d] = std::max(forces.box.upper[d], points[i].x[d]);
    }
  }
}

// Friction takes what is left of the tools' work when the overlaps and the particles have had their shares. The particles' own velocities
// do not say what it takes: under FLIP they keep what the grid does not move them by.
template <int Dim>
Real Tools<Dim>::work_on(const Touched& body) const {
  std::vector<Index> ids = body.forces.ids;
  ids.insert(ids.end(), body.last_forces.ids.begin(), body.last_forces.ids.end());
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  Real work = 0;
  for (const Index one : ids) {
    const auto id = static_cast<std::size_t>(one);
    const auto &now = body.places[id], &last = body.last_places[id];
    if (now.update != number_ || last.update != number_ - 1) continue;
    for (std::size_t d = 0; d < Dim; ++d)
      work += 0.5 * (body.forces.values[id * Dim + d] + body.last_forces.values[id * Dim + d]) * (now.x[d] - last.x[d]);
  }
  return work;
}

template <int Dim>
void Tools<Dim>::update(Real dt, Real since, Ledger& ledger) {
  std::vector<std::pair<Vec3, Vec3>> before;
  for (Tool& tool : tools_) {
    before.emplace_back(tool.force, tool.torque);
    tool.force = tool.torque = {};
    tool.overlap = tool.k_sum = 0;
  }
  const Real stored = energy_;
  energy_ = 0;
  last_dt_ = dt;
  ++number_;
  for (Touched& body : touched_) {
    std::swap(body.forces, body.last_forces);
    std::swap(body.places, body.last_places);
    body.forces.clear(body.mass.size());
    if (since > 0) std::swap(body.touches, body.last_touches);
    for (std::size_t t = 0; t < tools_.size(); ++t) {
      body.touches[t].clear();
      touch(t, body, dt);
      std::sort(body.touches[t].begin(), body.touches[t].end(), [](const auto& one, const auto& other) { return one.id < other.id; });
    }
    // A particle may touch two tools.
    std::vector<Index>& ids = body.forces.ids;
    std::sort(ids.begin(), ids.end());
    ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  }
  Real all = 0;
  for (std::size_t t = 0; t < tools_.size(); ++t) {
    const Tool& tool = tools_[t];
    BoundaryTotals& totals = totals_[t];
    Real work = 0;
    for (std::size_t d = 0; d < 3; ++d) {
      totals.force[d] = -tool.force[d];
      if (since == 0) continue;
      const Real impulse = -since * before[t].first[d];
      totals.impulse[d] += impulse;
      ledger.boundary_impulse[d] += impulse;
      work -= 0.5 * ((before[t].first[d] + tool.force[d]) * tool.way[d] + (before[t].second[d] + tool.torque[d]) * tool.turn[d]);
    }
    totals.work += work;
    ledger.boundary_work += work;
    all += work;
  }
  if (since == 0) return;
  for (const Touched& body : touched_) all -= work_on(body);
  ledger.contact_dissipation += all - (energy_ - stored);
}

template <int Dim>
Real Tools<Dim>::distance(const Vec3& x) const {
  Real least = std::numeric_limits<Real>::infinity();
  for (const Tool& tool : tools_) least = std::min(least, tool.shape->surface_near(tool.motion.at_start(x), Dim)->distance);
  return least;
}

template <int Dim>
Real Tools<Dim>::stable_dt() const {
  Real dt = k_step_share * 2 / std::sqrt(k_over_m_);
  for (const Tool& tool : tools_) {
    dt = std::min(dt, tool.motion.stable_dt());
    if (tool.motion.is_free() && tool.k_sum > 0) dt = std::min(dt, k_step_share * 2 * std::sqrt(tool.motion.mass() / tool.k_sum));
    const Vec3 v = tool.motion.velocity();
    Real speed = std::sqrt(dot(v, v));
    const Extent<Dim> box = box_of(tool, 0);
    Real reach = 0;
    for (std::size_t d = 0; d < Dim && std::isfinite(box.upper[d]); ++d)
      reach = std::max({reach, box.upper[d] - tool.motion.pivot()[d], tool.motion.pivot()[d] - box.lower[d]});
    const Vec3 w = tool.motion.angular_velocity();
    speed += reach * std::sqrt(dot(w, w));
    if (speed > 0) dt = std::min(dt, half_min_ / speed);
  }
  return dt;
}

template <int Dim>
std::vector<StepNumber> Tools<Dim>::numbers() const {
  std::vector<StepNumber> all;
  for (const Tool& tool : tools_) {
    const auto vector = [&](const std::string& name, const std::string& unit, const Vec3& value) {
      for (std::size_t d = 0; d < Dim; ++d) all.push_back({fmt::format("{}.{}_{}", tool.name, name, "xyz"[d]), unit, value[d]});
    };
    const auto turning = [&](const std::string& name, const std::string& unit, const Vec3& value) {
      if (Dim == 2)
        all.push_back({fmt::format("{}.{}", tool.name, name), unit, value[2]});
      else
        vector(name, unit, value);
    };
    vector("position", "m", tool.motion.center());
    turning("turn", "rad", tool.motion.turn());
    vector("velocity", "m/s", tool.motion.velocity_of(tool.motion.center()));
    turning("angular_velocity", "rad/s", tool.motion.angular_velocity());
    turning("torque", "N m", tool.torque);
    all.push_back({tool.name + ".kinetic_energy", "J", tool.motion.kinetic_energy()});
    all.push_back({tool.name + ".overlap", "1", tool.overlap});
  }
  return all;
}

template <int Dim>
void Tools<Dim>::declare_state(State& state) {
  for (std::size_t t = 0; t < tools_.size(); ++t) {
    state.in(tools_[t].name, [&] {
      state.part("motion", tools_[t].motion);
      state.part("totals", totals_[t]);
    });
  }
  for (Touched& body : touched_) {
    for (std::size_t t = 0; t < tools_.size(); ++t)
      state.in(tools_[t].name, [&] { state.rows("touches_of_" + body.body->name(), body.last_touches[t]); });
  }
  state.add("last_dt", last_dt_);
  if (!state.is_loading()) return;
  // The forces follow from the places.
  std::vector<BoundaryTotals> totals = totals_;
  Ledger none;
  update(last_dt_, 0, none);
  totals_ = std::move(totals);
}

template class Tools<2>;
template class Tools<3>;

}  // namespace matpoint
