#include "grid/boundary_condition.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/parallel.hpp"

namespace matpoint {
namespace {

template <int Dim>
Vec3 widened(const Vec<Dim>& a) {
  Vec3 x{};
  std::copy(a.begin(), a.end(), x.begin());
  return x;
}

/// The axis that a unit vector is along, or -1.
template <int Dim>
int axis_of(const Vec3& n) {
  for (int d = 0; d < Dim; ++d) {
    if (std::abs(n[static_cast<std::size_t>(d)]) > 1 - 1e-12) return d;
  }
  return -1;
}

/// Later conditions win: each direction keeps of itself what the fixed components and the later directions leave free.
template <int Dim>
void append_normals(const std::vector<std::pair<int, Vec<Dim>>>& normals, const int* condition_of, int lane,
                    std::vector<FixedNormal<Dim>>& out) {
  std::vector<Vec<Dim>> taken;
  for (int d = 0; d < Dim; ++d) {
    if (condition_of[d] < 0) continue;
    Vec<Dim> axis{};
    axis[static_cast<std::size_t>(d)] = 1;
    taken.push_back(axis);
  }
  for (auto one = normals.rbegin(); one != normals.rend(); ++one) {
    const auto& [condition, n] = *one;
    Vec<Dim> free = n;
    for (const Vec<Dim>& other : taken) {
      const Real share = dot(free, other);
      for (std::size_t d = 0; d < Dim; ++d) free[d] -= share * other[d];
    }
    const Real left = dot(free, free);  // equals free . n
    constexpr Real k_parallel = 1e-12;  // of the square: within 1e-6 rad the direction is taken already
    if (left < k_parallel) continue;
    FixedNormal<Dim> fixed{lane, n, {}, condition};
    Vec<Dim> unit;
    for (std::size_t d = 0; d < Dim; ++d) {
      unit[d] = free[d] / std::sqrt(left);
      fixed.correction[d] = free[d] / left;
    }
    taken.push_back(unit);
    out.push_back(fixed);
  }
}

/// The velocity that a condition prescribes at a node of a tile.
template <int Dim, class R>
Vec<Dim> prescribed(const std::vector<PrescribedVelocity>& values, int condition, const Grid<Dim, R>& grid, const Tile<Dim, R>& tile,
                    int lane) {
  const PrescribedVelocity& value = values[static_cast<std::size_t>(condition)];
  Place<Dim> node = tile.first;
  node[0] += lane;
  return value.at(value.field == nullptr ? Vec<Dim>{} : grid.node_position(node));
}

/// The velocity v - V of a node beside that of a surface, and its part along n.
template <int Dim, class Velocity>
std::pair<Vec<Dim>, Real> relative(const SurfaceContact<Dim>& contact, const Vec<Dim>& surface, const Velocity& v) {
  Vec<Dim> w;
  for (std::size_t d = 0; d < Dim; ++d) w[d] = v(d) - surface[d];
  return {w, dot(w, contact.n)};
}

/// What of the velocity w, whose part along n is w_n, a surface may take by friction.
template <int Dim>
Vec<Dim> sliding(const SurfaceContact<Dim>& contact, const Vec<Dim>& w, Real w_n) {
  Vec<Dim> along;
  for (std::size_t d = 0; d < Dim; ++d) along[d] = contact.is_fixed[d] ? 0 : w[d] - w_n * contact.correction[d];
  return along;
}

/// A node beyond periodic sides in the directions whose bits are set, and itself in the others; nothing where it has no image there.
template <int Dim, class R>
std::optional<Place<Dim>> image_of(const Grid<Dim, R>& grid, Place<Dim> node, int directions) {
  for (int d = 0; d < Dim; ++d) {
    if ((directions >> d & 1) == 0) continue;
    int& i = node[static_cast<std::size_t>(d)];
    i = grid.image_of(i, d);
    if (i < 0) return std::nullopt;
  }
  return node;
}

}  // namespace

template <int Dim, class R>
BoundaryConditions<Dim, R>::BoundaryConditions(const std::vector<BoundarySpec>& specs, const Grid<Dim, R>& grid) : specs_(specs) {
  for (std::size_t c = 0; c < specs_.size(); ++c) {
    field_speeds_.push_back(specs_[c].velocity_field ? greatest_field_speed(specs_[c], grid) : 0);
    if (has_node(c, grid)) continue;
    throw InputError("{}boundary {}: its region contains no node of the grid, so it would do nothing; make it at least a cell wide",
                     specs_[c].place.empty() ? "" : specs_[c].place + ": ", c + 1);
  }
}

/// Where a condition holds at a node: the node's place, or that of its image beyond a periodic side, for they are one.
template <int Dim, class R>
std::optional<Vec3> BoundaryConditions<Dim, R>::place_in(std::size_t condition, const Grid<Dim, R>& grid, const Place<Dim>& node) const {
  const BoundarySpec& spec = specs_[condition];
  for (int images = 0; images < 1 << Dim; ++images) {
    const std::optional<Place<Dim>> found = image_of<Dim, R>(grid, node, images);
    if (!found) continue;
    const Place<Dim>& image = *found;
    const Vec3 x = widened<Dim>(grid.node_position(image));
    if (spec.region) {
      Real cell_size = grid.cell_size(0);
      for (int d = 1; d < Dim; ++d) cell_size = std::min(cell_size, grid.cell_size(d));
      if (spec.region->reaches(x, node_tolerance(x, cell_size))) return x;
    } else {
      const BoundarySide side = side_of(spec.side);
      if (image[static_cast<std::size_t>(side.axis)] == grid.side_node(side.axis, side.is_upper)) return x;
    }
  }
  return std::nullopt;
}

template <int Dim, class R>
bool BoundaryConditions<Dim, R>::has_node(std::size_t condition, const Grid<Dim, R>& grid) const {
  const BoundarySpec& spec = specs_[condition];
  if (!spec.region) return true;
  const Vec3 lower = spec.region->lower();
  const Vec3 upper = spec.region->upper();
  Place<Dim> first{};
  Place<Dim> last{};
  for (int d = 0; d < Dim; ++d) {
    const auto s = static_cast<std::size_t>(d);
    const auto node_at = [&](Real x) {
      return static_cast<int>(std::clamp((x - grid.lower(d)) / grid.cell_size(d), Real{-1}, static_cast<Real>(grid.nodes(d))));
    };
    first[s] = std::max(0, node_at(lower[s]) - 1);
    last[s] = std::min(grid.nodes(d) - 1, node_at(upper[s]) + grid.span());
    if (last[s] < first[s]) return false;
  }
  Place<Dim> node = first;
  while (true) {
    if (place_in(condition, grid, node)) return true;
    std::size_t d = 0;
    while (d < Dim && node[d] == last[d]) {
      node[d] = first[d];
      ++d;
    }
    if (d == Dim) return false;
    ++node[d];
  }
}

template <int Dim, class R>
void BoundaryConditions<Dim, R>::append(const Grid<Dim, R>& grid, const Place<Dim>& node, int lane, Tile<Dim, R>& tile) const {
  int condition_of[Dim];
  std::fill_n(condition_of, Dim, -1);
  std::vector<std::pair<int, Vec<Dim>>> oblique;
  std::vector<std::pair<std::size_t, Vec3>> surfaces;
  for (std::size_t c = 0; c < specs_.size(); ++c) {
    const std::optional<Vec3> place = place_in(c, grid, node);
    if (!place) continue;
    const BoundarySpec& spec = specs_[c];
    const int condition = static_cast<int>(c);
    if (spec.contact != FaceContact::stick) {
      surfaces.emplace_back(c, *place);
    } else if (spec.kind != BoundaryKind::slip) {
      for (int d = 0; d < Dim; ++d) {
        const bool is_held = spec.components.empty() ||
                             std::find(spec.components.begin(), spec.components.end(), std::string(1, "xyz"[d])) != spec.components.end();
        if (is_held) condition_of[d] = condition;
      }
    } else if (spec.region == nullptr) {
      condition_of[side_of(spec.side).axis] = condition;
    } else {
      for (const Vec3& normal : spec.region->normals(*place, Dim)) {
        const int axis = axis_of<Dim>(normal);
        Vec<Dim> n;
        std::copy_n(normal.begin(), Dim, n.begin());
        if (axis >= 0)
          condition_of[axis] = condition;
        else if (dot(n, n) > 0)
          oblique.emplace_back(condition, n);
      }
    }
  }
  for (int d = 0; d < Dim; ++d) {
    if (condition_of[d] >= 0) tile.components.push_back({lane, d, condition_of[d]});
  }
  append_normals<Dim>(oblique, condition_of, lane, tile.normals);
  append_contacts(surfaces, lane, tile);
}

/// `places`: conditions with contact, and where they hold at the node.
template <int Dim, class R>
void BoundaryConditions<Dim, R>::append_contacts(const std::vector<std::pair<std::size_t, Vec3>>& places, int lane,
                                                 Tile<Dim, R>& tile) const {
  for (const auto& [c, place] : places) {
    const BoundarySpec& spec = specs_[c];
    std::vector<Vec3> normals;
    if (spec.region) {
      normals = spec.region->normals(place, Dim);
    } else {
      const BoundarySide side = side_of(spec.side);
      normals.emplace_back();
      normals[0][static_cast<std::size_t>(side.axis)] = side.is_upper ? -1 : 1;
    }
    for (const Vec3& normal : normals) {
      SurfaceContact<Dim> contact{lane, static_cast<int>(c), {}, {}, {}, 0};
      std::copy_n(normal.begin(), Dim, contact.n.begin());
      for (const FixedComponent& fixed : tile.components) {
        if (fixed.lane == lane) contact.is_fixed[static_cast<std::size_t>(fixed.component)] = true;
      }
      Real left = 0;
      for (std::size_t d = 0; d < Dim; ++d) left += contact.is_fixed[d] ? 0 : contact.n[d] * contact.n[d];
      constexpr Real k_parallel = 1e-12;  // of the square, as in append_normals
      if (left < k_parallel) continue;
      for (std::size_t d = 0; d < Dim; ++d) contact.correction[d] = contact.is_fixed[d] ? 0 : contact.n[d] / left;
      contact.friction = spec.contact == FaceContact::friction ? spec.friction
                         : spec.kind == BoundaryKind::slip     ? 0
                                                               : std::numeric_limits<Real>::infinity();
      tile.contacts.push_back(contact);
    }
  }
}

template <int Dim, class R>
std::vector<PrescribedVelocity> BoundaryConditions<Dim, R>::velocities(Real t) const {
  std::vector<PrescribedVelocity> all;
  for (const BoundarySpec& spec : specs_) all.push_back(velocity_at(spec, t));
  return all;
}

template <int Dim, class R>
std::vector<ClosedSide> BoundaryConditions<Dim, R>::closed_sides(Real t) const {
  std::vector<ClosedSide> closed;
  for (const BoundarySpec& spec : specs_) {
    if (spec.region || spec.kind == BoundaryKind::traction) continue;
    const BoundarySide side = side_of(spec.side);
    const std::string component(1, "xyz"[side.axis]);
    const bool holds_across = spec.kind == BoundaryKind::slip || spec.components.empty() ||
                              std::find(spec.components.begin(), spec.components.end(), component) != spec.components.end();
    const PrescribedVelocity velocity = velocity_at(spec, t);
    // By place, it may go away from some particles and not from others: they see when they are there.
    const Real across = velocity.everywhere[static_cast<std::size_t>(side.axis)];
    if (holds_across && (side.is_upper ? across <= 0 : across >= 0))
      closed.push_back({side.axis, side.is_upper, velocity, static_cast<int>(&spec - specs_.data())});
  }
  return closed;
}

template <int Dim, class R>
std::vector<Obstacle> BoundaryConditions<Dim, R>::obstacles(Real t) const {
  std::vector<Obstacle> all;
  for (const BoundarySpec& spec : specs_) {
    // A velocity that is prescribed in a region belongs to what is in it, not to a wall.
    const bool is_wall = spec.contact != FaceContact::stick || spec.kind == BoundaryKind::slip ||
                         (spec.kind == BoundaryKind::fixed && spec.components.empty());
    if (spec.region && is_wall) all.push_back({spec.region.get(), velocity_at(spec, t), static_cast<int>(&spec - specs_.data())});
  }
  return all;
}

template <int Dim, class R>
void BoundaryConditions<Dim, R>::constrain(const Grid<Dim, R>& grid, Tile<Dim, R>& tile, const NodalDynamics<Dim>& dynamics,
                                           const std::vector<PrescribedVelocity>& values, const std::vector<PrescribedVelocity>& before,
                                           Real dt, Ledger& ledger) const {
  NodeValues<Dim, R>& nodes = tile.values;
  for (const FixedComponent& fixed : tile.components) {
    const auto d = static_cast<std::size_t>(fixed.component);
    const Real value = prescribed(values, fixed.condition, grid, tile, fixed.lane)[d];
    const Real change = value - prescribed(before, fixed.condition, grid, tile, fixed.lane)[d];
    const Real m = nodes.mass[fixed.lane];
    if (m > 0 && m >= dynamics.mass_cutoff && tile.booked[fixed.lane] > 0) {
      const Real p = nodes.momentum[d][fixed.lane];
      const Real damping_impulse = dt * dynamics.damping * p;
      ledger.damping_impulse[d] += damping_impulse;
      ledger.damping_dissipation -= damping_impulse * nodes.velocity[d][fixed.lane];
      // FLIP particles have the change of the prescribed velocity in place of dt (f + m g); the PIC share is given the momentum of the
      // prescribed velocity instead of the node's own.
      const Real impulse =
          (1 - dynamics.flip) * (m * value - p) + dynamics.flip * m * change - dt * (nodes.force[d][fixed.lane] + m * dynamics.gravity[d]);
      ledger.press(fixed.condition, d, impulse, impulse * value);
    }
    nodes.velocity[d][fixed.lane] = static_cast<R>(value);
    nodes.second[d][fixed.lane] = static_cast<R>(change / dt);
  }
  constrain_normals(tile, dynamics, dt, ledger);
  touch_surfaces(grid, tile, dynamics, values, dt, ledger);
}

template <int Dim, class R>
void BoundaryConditions<Dim, R>::touch_surfaces(const Grid<Dim, R>& grid, Tile<Dim, R>& tile, const NodalDynamics<Dim>& dynamics,
                                                const std::vector<PrescribedVelocity>& values, Real dt, Ledger& ledger) {
  if (tile.contacts.empty()) return;
  NodeValues<Dim, R>& nodes = tile.values;
  Vec<Dim> impulses[k_lanes<R>]{};  // of all surfaces
  Vec<Dim> starts[k_lanes<R>];      // velocities at the start of the step
  for (int lane = 0; lane < k_lanes<R>; ++lane) {
    for (std::size_t d = 0; d < Dim; ++d)
      starts[lane][d] = nodes.moved_mass[lane] > 0 ? nodes.momentum[d][lane] / nodes.moved_mass[lane] : 0;
  }
  for (SurfaceContact<Dim>& contact : tile.contacts) {
    const Vec<Dim> surface = prescribed(values, contact.condition, grid, tile, contact.lane);
    // What was held at the end of the last step is held at the start of this one; the mapped velocities of the particles, which do not
    // move by them, would make a block at rest work against its floor.
    if (contact.presses) {
      Vec<Dim>& start = starts[contact.lane];
      const auto [w, w_n] = relative<Dim>(contact, surface, [&](std::size_t d) { return start[d]; });
      for (std::size_t d = 0; d < Dim; ++d) start[d] -= w_n * contact.correction[d];
    }
    contact.presses = contact.sticks = false;
    if (contact.gap > 0) continue;
    const Real m = nodes.moved_mass[contact.lane];
    if (m <= 0 || m < dynamics.mass_cutoff) continue;
    const auto [w, w_n] =
        relative<Dim>(contact, surface, [&](std::size_t d) { return static_cast<Real>(nodes.velocity[d][contact.lane]); });
    if (w_n >= 0) continue;
    const Vec<Dim> along = sliding<Dim>(contact, w, w_n);
    const Real speed = std::sqrt(dot(along, along));
    contact.presses = true;
    contact.sticks = contact.friction * -w_n >= speed;
    const Real stopped = contact.sticks ? 1 : contact.friction * -w_n / speed;
    for (std::size_t d = 0; d < Dim; ++d) {
      const Real old = nodes.velocity[d][contact.lane];
      const Real change = -w_n * contact.correction[d] - stopped * along[d];
      nodes.velocity[d][contact.lane] = static_cast<R>(old + change);
      nodes.second[d][contact.lane] += static_cast<R>(change / dt);
      if (tile.booked[contact.lane] == 0) continue;
      const Real impulse = m * change;
      const Real work = impulse * surface[d];
      ledger.press(contact.condition, d, impulse, work);
      ledger.contact_dissipation += work;
      impulses[contact.lane][d] += impulse;
    }
  }
  // All forces of a step act together, from the node's velocity at its start to that at its end: the work of each is its impulse times the
  // mean of the two. With the velocity that the others alone would have left, a body at rest would seem to be stopped in every step.
  for (int lane = 0; lane < k_lanes<R>; ++lane) {
    for (std::size_t d = 0; d < Dim; ++d) {
      if (impulses[lane][d] == 0) continue;
      ledger.contact_dissipation -= 0.5 * impulses[lane][d] * (starts[lane][d] + nodes.velocity[d][lane]);
    }
  }
}

template <int Dim, class R>
void BoundaryConditions<Dim, R>::measure_gaps(const Grid<Dim, R>& grid, const GapMeasure& measure) const {
  for (std::size_t c = 0; c < specs_.size(); ++c) {
    if (specs_[c].contact == FaceContact::stick || specs_[c].region) continue;
    const BoundarySide side = side_of(specs_[c].side);
    parallel_for(grid.band_count(), grid.tile_count() * k_lanes<R>, [&](Index band) {
      for (Tile<Dim, R>* tile : grid.tiles(static_cast<std::size_t>(band))) {
        TileNodes<Dim> nodes{tile->first, {}};
        for (const SurfaceContact<Dim>& contact : tile->contacts) {
          if (contact.condition == static_cast<int>(c)) nodes.lanes.push_back(contact.lane);
        }
        if (nodes.lanes.empty()) continue;
        std::vector<Real> gaps(nodes.lanes.size(), std::numeric_limits<Real>::infinity());
        measure(nodes, side.axis, side.is_upper, gaps);
        for (std::size_t k = 0; k < gaps.size() && grid.has_periodic(); ++k) {
          Place<Dim> node = tile->first;
          node[0] += nodes.lanes[k];
          for (int images = 1; images < 1 << Dim; ++images) {
            const std::optional<Place<Dim>> image = image_of<Dim, R>(grid, node, images);
            if (!image) continue;
            TileNodes<Dim> there{*image, {(*image)[0] % k_lanes<R>}};
            there.first[0] -= there.lanes[0];
            std::vector<Real> gap{gaps[k]};
            measure(there, side.axis, side.is_upper, gap);
            gaps[k] = gap[0];
          }
        }
        std::size_t i = 0;
        for (SurfaceContact<Dim>& contact : tile->contacts) {
          if (contact.condition == static_cast<int>(c)) contact.gap = gaps[i++];
        }
      }
    });
  }
}

template <int Dim, class R>
int BoundaryConditions<Dim, R>::condition_of(const Tile<Dim, R>& tile, int lane, int component) {
  for (const FixedComponent& fixed : tile.components) {
    if (fixed.lane == lane && fixed.component == component) return fixed.condition;
  }
  for (const FixedNormal<Dim>& fixed : tile.normals) {
    if (fixed.lane == lane && fixed.correction[static_cast<std::size_t>(component)] != 0) return fixed.condition;
  }
  for (const SurfaceContact<Dim>& contact : tile.contacts) {
    if (contact.lane == lane) return contact.condition;
  }
  return -1;
}

template <int Dim, class R>
void BoundaryConditions<Dim, R>::leave_out(const Tile<Dim, R>& tile, Vec<Dim>* changes) {
  for (const FixedComponent& fixed : tile.components) changes[fixed.lane][static_cast<std::size_t>(fixed.component)] = 0;
  for (const FixedNormal<Dim>& fixed : tile.normals) {
    const Real along = dot(fixed.n, changes[fixed.lane]);
    for (std::size_t d = 0; d < Dim; ++d) changes[fixed.lane][d] -= along * fixed.correction[d];
  }
  for (const SurfaceContact<Dim>& contact : tile.contacts) {
    if (!contact.presses) continue;
    Vec<Dim>& change = changes[contact.lane];
    const Real w_n = dot(contact.n, change);
    const Vec<Dim> along = sliding<Dim>(contact, change, w_n);
    for (std::size_t d = 0; d < Dim; ++d) change[d] -= w_n * contact.correction[d] + (contact.sticks ? along[d] : 0);
  }
}

template <int Dim, class R>
void BoundaryConditions<Dim, R>::keep_out(const Grid<Dim, R>& grid, const Tile<Dim, R>& tile, const std::vector<PrescribedVelocity>& values,
                                          std::vector<Vec<Dim>>& velocities) {
  for (const SurfaceContact<Dim>& contact : tile.contacts) {
    if (contact.gap > 0) continue;
    Vec<Dim>& v = velocities[static_cast<std::size_t>(contact.lane)];
    const Vec<Dim> surface = prescribed(values, contact.condition, grid, tile, contact.lane);
    const Real w_n = relative<Dim>(contact, surface, [&](std::size_t d) { return v[d]; }).second;
    for (std::size_t d = 0; d < Dim && w_n < 0; ++d) v[d] -= w_n * contact.correction[d];
  }
}

template <int Dim, class R>
void BoundaryConditions<Dim, R>::constrain_normals(Tile<Dim, R>& tile, const NodalDynamics<Dim>& dynamics, Real dt, Ledger& ledger) const {
  NodeValues<Dim, R>& nodes = tile.values;
  for (const FixedNormal<Dim>& fixed : tile.normals) {
    const Real m = nodes.mass[fixed.lane];
    Real v_n = 0;
    Real a_n = 0;
    Real p_c = 0;
    Real c_c = 0;
    for (std::size_t d = 0; d < Dim; ++d) {
      v_n += fixed.n[d] * nodes.velocity[d][fixed.lane];
      a_n += fixed.n[d] * nodes.second[d][fixed.lane];
      p_c += fixed.correction[d] * nodes.momentum[d][fixed.lane];
      c_c += fixed.correction[d] * fixed.correction[d];
    }
    for (std::size_t d = 0; d < Dim; ++d) {
      nodes.velocity[d][fixed.lane] -= static_cast<R>(v_n * fixed.correction[d]);
      nodes.second[d][fixed.lane] -= static_cast<R>(a_n * fixed.correction[d]);
    }
    if (m > 0 && m >= dynamics.mass_cutoff && tile.booked[fixed.lane] > 0) {
      // Along c only: the damping of what other conditions hold has been taken out of the books with them.
      const Real damping_impulse = dt * dynamics.damping * p_c;
      ledger.damping_dissipation -= damping_impulse * v_n;
      // What the particles get less of: m a dt by FLIP, m v by PIC. The surface is at rest, but a moving side drives its nodes along it.
      const Real impulse = -m * (dynamics.flip * dt * a_n + (1 - dynamics.flip) * v_n) - damping_impulse / c_c;
      for (std::size_t d = 0; d < Dim; ++d) {
        ledger.damping_impulse[d] += damping_impulse / c_c * fixed.correction[d];
        const Real along = impulse * fixed.correction[d];
        ledger.press(fixed.condition, d, along, along * nodes.velocity[d][fixed.lane]);
      }
    }
  }
}

template <int Dim, class R>
void BoundaryConditions<Dim, R>::constrain_second(const Grid<Dim, R>& grid, Tile<Dim, R>& tile,
                                                  const std::vector<PrescribedVelocity>& values) const {
  NodeValues<Dim, R>& nodes = tile.values;
  for (const FixedComponent& fixed : tile.components) {
    const auto d = static_cast<std::size_t>(fixed.component);
    nodes.second[d][fixed.lane] = static_cast<R>(prescribed(values, fixed.condition, grid, tile, fixed.lane)[d]);
  }
  for (const FixedNormal<Dim>& fixed : tile.normals) {
    Real v_n = 0;
    for (std::size_t d = 0; d < Dim; ++d) v_n += fixed.n[d] * nodes.second[d][fixed.lane];
    for (std::size_t d = 0; d < Dim; ++d) nodes.second[d][fixed.lane] -= static_cast<R>(v_n * fixed.correction[d]);
  }
  for (const SurfaceContact<Dim>& contact : tile.contacts) {
    const Vec<Dim> surface = prescribed(values, contact.condition, grid, tile, contact.lane);
    const auto [w, w_n] = relative<Dim>(contact, surface, [&](std::size_t d) { return static_cast<Real>(nodes.second[d][contact.lane]); });
    // By what the node did when it moved, not by the sign of w_n: of its noise, half would be taken, and the rest would strain the body.
    if (!contact.presses) continue;
    const Vec<Dim> along = sliding<Dim>(contact, w, w_n);
    for (std::size_t d = 0; d < Dim; ++d)
      nodes.second[d][contact.lane] -= static_cast<R>(w_n * contact.correction[d] + (contact.sticks ? along[d] : 0));
  }
}

template <int Dim, class R>
Real BoundaryConditions<Dim, R>::greatest_speed(Real t) const {
  Real greatest = 0;
  for (const BoundarySpec& spec : specs_) {
    if (spec.velocity_history) {
      for (Real v : spec.velocity_history->at(t)) greatest = std::max(greatest, std::abs(v));
    }
    Real factor = spec.factors.empty() ? 1 : 0;
    for (const Real one : spec.factors) factor = std::max(factor, std::abs(one));
    greatest = std::max(greatest, factor * field_speeds_[static_cast<std::size_t>(&spec - specs_.data())]);
    for (Real v : spec.velocity) greatest = std::max(greatest, factor * std::abs(v));
    for (const Vec3& v : spec.velocities) {
      for (Real component : v) greatest = std::max(greatest, std::abs(component));
    }
  }
  return greatest;
}

/// In the box around the region or the side, as far as it is in the grid.
template <int Dim, class R>
Real BoundaryConditions<Dim, R>::greatest_field_speed(const BoundarySpec& spec, const Grid<Dim, R>& grid) const {
  Vec3 lower{}, upper{};
  for (std::size_t d = 0; d < Dim; ++d) {
    lower[d] = grid.lower(static_cast<int>(d));
    upper[d] = grid.upper(static_cast<int>(d));
    if (!spec.region) continue;
    lower[d] = std::clamp(spec.region->lower()[d], lower[d], upper[d]);
    upper[d] = std::clamp(spec.region->upper()[d], lower[d], upper[d]);
  }
  if (!spec.region) {
    const BoundarySide side = side_of(spec.side);
    const auto d = static_cast<std::size_t>(side.axis);
    (side.is_upper ? lower : upper)[d] = side.is_upper ? upper[d] : lower[d];
  }
  return spec.velocity_field->greatest_speed(lower, upper);
}

template class BoundaryConditions<2, double>;
template class BoundaryConditions<3, double>;
template class BoundaryConditions<2, float>;
template class BoundaryConditions<3, float>;

}  // namespace matpoint
