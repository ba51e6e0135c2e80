#include "explicit/node_contact.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/parallel.hpp"
#include "grid/boundary_condition.hpp"

namespace matpoint {
namespace {

/// Of more than two bodies at a node, one impulse may undo another; so often are the pairs gone through.
constexpr int k_rounds = 8;

/// Bodies touch when their centroids are closer than this, in cell sides.
constexpr Real k_touching = 0.775;

/// The cosine of the widest angle between the normal and the line of the centroids: bodies beside each other do not touch along a normal of
/// their upper sides. Within `k_inside` cell sides of each other they do in any direction, for then that line means nothing.
constexpr Real k_aligned = 0.5;
constexpr Real k_inside = 0.2;

template <int Dim, class R>
bool is_active(const NodeValues<Dim, R>& nodes, int lane, Real cutoff) {
  return nodes.moved_mass[lane] > 0 && nodes.moved_mass[lane] >= cutoff;
}

/// What holds a node holds it against contact, too: takes back the part of a change that a condition forbids.
template <int Dim, class R>
void keep_conditions(const Grid<Dim, R>& grid, const Tile<Dim, R>& tile, const std::vector<Vec<Dim>>& before,
                     std::vector<Vec<Dim>>& after) {
  for (const FixedComponent& fixed : tile.components) {
    const auto lane = static_cast<std::size_t>(fixed.lane);
    after[lane][static_cast<std::size_t>(fixed.component)] = before[lane][static_cast<std::size_t>(fixed.component)];
  }
  for (const FixedNormal<Dim>& fixed : tile.normals) {
    const auto lane = static_cast<std::size_t>(fixed.lane);
    const Real changed = dot(fixed.n, after[lane]) - dot(fixed.n, before[lane]);
    for (std::size_t d = 0; d < Dim; ++d) after[lane][d] -= changed * fixed.correction[d];
  }
  BoundaryConditions<Dim, R>::keep_out(grid, tile, grid.boundary_velocities(), after);
}

}  // namespace

template <int Dim, class R>
void Contact<Dim, R>::apply(Real mass_cutoff, Real dt, Ledger& ledger) {
  const std::vector<std::vector<Shared>> all = find_shared();
  std::vector<Ledger> books(all.size());
  pressed_.assign(all.size(), {});
  Index work_size = 0;
  for (const auto& band : all) work_size += static_cast<Index>(band.size()) * k_lanes<R>;
  parallel_for(static_cast<Index>(all.size()), work_size, [&](Index b) {
    const auto band = static_cast<std::size_t>(b);
    for (const Shared& one : all[band]) work(one, band, mass_cutoff, dt, books[band]);
  });
  // In the order of the bands: the same bits for any number of threads.
  for (const Ledger& book : books) {
    ledger.contact_dissipation += book.contact_dissipation;
    ledger.add_boundaries(book);
  }
}

/// Per band of the grid.
template <int Dim, class R>
std::vector<std::vector<typename Contact<Dim, R>::Shared>> Contact<Dim, R>::find_shared() const {
  std::vector<std::vector<Shared>> all(static_cast<std::size_t>(grids_[0]->band_count()));
  for (std::size_t a = 0; a + 1 < grids_.size(); ++a) {
    for (std::size_t band = 0; band < all.size(); ++band) {
      for (Tile<Dim, R>* tile : grids_[a]->tiles(band)) {
        Shared shared{{a}, {tile}};
        for (std::size_t b = a + 1; b < grids_.size(); ++b) {
          if (Tile<Dim, R>* const other = grids_[b]->find(tile->first)) {
            shared.bodies.push_back(b);
            shared.tiles.push_back(other);
          }
        }
        if (shared.bodies.size() == 1) continue;
        bool is_known = false;  // from a body before
        for (std::size_t before = 0; before < a && !is_known; ++before) is_known = grids_[before]->find(tile->first) != nullptr;
        if (!is_known) all[band].push_back(std::move(shared));
      }
    }
  }
  return all;
}

template <int Dim, class R>
void Contact<Dim, R>::work(const Shared& shared, std::size_t band, Real mass_cutoff, Real dt, Ledger& ledger) {
  const std::size_t count = shared.bodies.size();
  std::vector<Velocities> before(count);
  for (std::size_t k = 0; k < count; ++k) {
    grids_[shared.bodies[k]]->prepare(*shared.tiles[k], band);
    const NodeValues<Dim, R>& nodes = shared.tiles[k]->values;
    before[k].resize(k_lanes<R>);
    for (std::size_t lane = 0; lane < k_lanes<R>; ++lane) {
      for (std::size_t d = 0; d < Dim; ++d) before[k][lane][d] = nodes.velocity[d][lane];
    }
  }
  bool is_changed = false;
  std::vector<Velocities> after = before;
  for (int round = 0; round < (count == 2 ? 1 : k_rounds); ++round) {
    bool is_changed_now = false;
    for (std::size_t a = 0; a < count; ++a) {
      for (std::size_t b = a + 1; b < count; ++b)
        is_changed_now = collide(shared, a, b, mass_cutoff, after, pressed_[band]) || is_changed_now;
    }
    if (!is_changed_now) break;
    is_changed = true;
  }
  if (!is_changed) return;
  for (std::size_t k = 0; k < count; ++k) {
    const Velocities wanted = after[k];
    keep_conditions<Dim>(*grids_[0], *shared.tiles[k], before[k], after[k]);
    NodeValues<Dim, R>& nodes = shared.tiles[k]->values;
    for (std::size_t lane = 0; lane < k_lanes<R>; ++lane) {
      const Vec<Dim>& old = before[k][lane];
      const Vec<Dim>& now = after[k][lane];
      if (now == old && wanted[lane] == old) continue;
      for (std::size_t d = 0; d < Dim; ++d) {
        // The work of each force is its impulse times the mean of the velocities at the step's start and end, as for surfaces.
        const Real start = old[d] - dt * nodes.second[d][lane];
        ledger.contact_dissipation -= 0.5 * nodes.moved_mass[lane] * (wanted[lane][d] - old[d]) * (start + now[d]);
        nodes.velocity[d][lane] = static_cast<R>(now[d]);
        nodes.second[d][lane] += static_cast<R>((now[d] - old[d]) / dt);
        const Real impulse = nodes.moved_mass[lane] * (now[d] - wanted[lane][d]);
        if (impulse == 0) continue;
        const int condition = BoundaryConditions<Dim, R>::condition_of(*shared.tiles[k], static_cast<int>(lane), static_cast<int>(d));
        ledger.press(condition, d, impulse, impulse * now[d]);
      }
    }
  }
}

template <int Dim, class R>
bool Contact<Dim, R>::touch(const NodeSurface<Dim>& a, const NodeSurface<Dim>& b, const Vec<Dim>& n) const {
  Real distance = 0;  // along n
  Real apart = 0;     // in any direction, squared
  Real side = 0;      // of a cell along n, squared
  for (std::size_t d = 0; d < Dim; ++d) {
    const Real along = n[d] * grids_[0]->cell_size(static_cast<int>(d));
    const Real between = b.centroid[d] - a.centroid[d];
    distance += n[d] * between;
    apart += between * between;
    side += along * along;
  }
  if (distance * std::abs(distance) >= k_touching * k_touching * side) return false;
  return distance * std::abs(distance) >= k_aligned * k_aligned * apart || apart < k_inside * k_inside * side;
}

namespace {

/// From a to b, of length 1; 0 where neither body has a surface. The longer of the bodies' sums, or the mean of two that are about as long
/// as each other: a mirror image of a case has the mirror image of its normals.
template <int Dim>
Vec<Dim> longer(const NodeSurface<Dim>& a, const NodeSurface<Dim>& b) {
  constexpr Real k_equal = 0.03;  // of the sum of the lengths
  const Real size_a = std::sqrt(dot(a.outward, a.outward));
  const Real size_b = std::sqrt(dot(b.outward, b.outward));
  const Real tie = k_equal * (size_a + size_b);
  Vec<Dim> n{};
  for (std::size_t d = 0; d < Dim; ++d) {
    if (size_a >= size_b - tie) n[d] += a.outward[d];
    if (size_b >= size_a - tie) n[d] -= b.outward[d];
  }
  const Real size = std::sqrt(dot(n, n));
  for (std::size_t d = 0; d < Dim && size > 0; ++d) n[d] /= size;
  return n;
}

}  // namespace

/// From a to b, of length 1; 0 where neither body has a surface. Of the directions that both bodies' shapes at the node suggest, the one
/// along which their particles are farthest apart: the first that is as good as any other, so a mirror image of a case has the mirror
/// image of its normals, and the order of the bodies changes nothing. Particles of a fluid lie in no order, and one of them would decide:
/// there sums do.
template <int Dim, class R>
std::vector<Vec<Dim>> Contact<Dim, R>::normals(const Body<Dim>& body_a, const Body<Dim>& body_b, const TileNodes<Dim>& at,
                                               const std::vector<NodeSurface<Dim>>& a, const std::vector<NodeSurface<Dim>>& b) const {
  constexpr Real k_farther = 1e-9;  // cell sides
  std::vector<Vec<Dim>> normals(at.lanes.size());
  if (body_a.is_fluid() || body_b.is_fluid()) {
    for (std::size_t i = 0; i < normals.size(); ++i) normals[i] = longer(a[i], b[i]);
    return normals;
  }
  std::vector<NodeReach<Dim>> reach_a(at.lanes.size()), reach_b(at.lanes.size());
  for (std::size_t i = 0; i < at.lanes.size(); ++i) {
    std::array<Vec<Dim>, NodeReach<Dim>::k_directions> along;
    for (std::size_t d = 0; d < Dim; ++d) {
      const Real of_a = a[i].outward[d];
      const Real of_b = -b[i].outward[d];
      along[0][d] = of_a + of_b;
      along[1][d] = of_a;
      along[2][d] = of_b;
      along[3][d] = b[i].centroid[d] - a[i].centroid[d];
      // What both agree on: at the corners of blocks with flush sides each leans its own way.
      along[4][d] = of_a * of_b <= 0 ? 0 : std::abs(of_a) < std::abs(of_b) ? of_a : of_b;
    }
    for (std::size_t c = 0; c < along.size(); ++c) {
      const Real size = std::sqrt(dot(along[c], along[c]));
      for (std::size_t d = 0; d < Dim && size > 0; ++d) {
        reach_a[i].along[c][d] = along[c][d] / size;
        reach_b[i].along[c][d] = -along[c][d] / size;
      }
    }
    reach_a[i].farthest.fill(-std::numeric_limits<Real>::infinity());
    reach_b[i].farthest.fill(-std::numeric_limits<Real>::infinity());
  }
  body_a.measure_reach(at, reach_a);
  body_b.measure_reach(at, reach_b);
  for (std::size_t i = 0; i < normals.size(); ++i) {
    Real widest = -std::numeric_limits<Real>::infinity();
    for (std::size_t c = 0; c < NodeReach<Dim>::k_directions; ++c) {
      const Real gap = -reach_a[i].farthest[c] - reach_b[i].farthest[c];
      if (dot(reach_a[i].along[c], reach_a[i].along[c]) == 0 || gap <= widest) continue;
      widest = gap + k_farther * grids_[0]->cell_size(0);
      normals[i] = reach_a[i].along[c];
    }
  }
  return normals;
}

/// A side with kind = "slip" is a plane of symmetry: with what is beyond it surfaces are at right angles to it, and centroids on it.
template <int Dim, class R>
void Contact<Dim, R>::mirror(const Tile<Dim, R>& tile, const TileNodes<Dim>& nodes, std::vector<NodeSurface<Dim>>& surfaces) const {
  for (const FixedComponent& fixed : tile.components) {
    if (!conditions_.is_mirror(fixed.condition)) continue;
    const auto d = static_cast<std::size_t>(fixed.component);
    for (std::size_t i = 0; i < nodes.lanes.size(); ++i) {
      if (nodes.lanes[i] != fixed.lane) continue;
      surfaces[i].outward[d] = 0;
      Place<Dim> node = tile.first;
      node[0] += fixed.lane;
      surfaces[i].centroid[d] = grids_[0]->node_position(node)[d];
    }
  }
}

/// Two bodies at the nodes of a tile. Returns whether anything changed.
template <int Dim, class R>
bool Contact<Dim, R>::collide(const Shared& shared, std::size_t a, std::size_t b, Real mass_cutoff, std::vector<Velocities>& velocities,
                              std::vector<Pressed>& pressed) const {
  const NodeValues<Dim, R>& nodes_a = shared.tiles[a]->values;
  const NodeValues<Dim, R>& nodes_b = shared.tiles[b]->values;
  TileNodes<Dim> at{shared.tiles[a]->first, {}};
  for (int lane = 0; lane < k_lanes<R>; ++lane) {
    if (is_active(nodes_a, lane, mass_cutoff) && is_active(nodes_b, lane, mass_cutoff)) at.lanes.push_back(lane);
  }
  if (at.lanes.empty()) return false;
  std::vector<NodeSurface<Dim>> surfaces_a = bodies_[shared.bodies[a]]->surfaces(at);
  std::vector<NodeSurface<Dim>> surfaces_b = bodies_[shared.bodies[b]]->surfaces(at);
  mirror(*shared.tiles[a], at, surfaces_a);
  mirror(*shared.tiles[a], at, surfaces_b);
  const Body<Dim>& body_a = *bodies_[shared.bodies[a]];
  const Body<Dim>& body_b = *bodies_[shared.bodies[b]];
  const std::vector<Vec<Dim>> all = normals(body_a, body_b, at, surfaces_a, surfaces_b);
  bool is_changed = false;
  for (std::size_t i = 0; i < at.lanes.size(); ++i) {
    const int lane = at.lanes[i];
    Vec<Dim>& v_a = velocities[a][static_cast<std::size_t>(lane)];
    Vec<Dim>& v_b = velocities[b][static_cast<std::size_t>(lane)];
    Vec<Dim> sliding;
    const Vec<Dim>& n = all[i];
    if (dot(n, n) == 0) continue;
    const Real approach = dot(v_a, n) - dot(v_b, n);
    if (approach <= 0 || !touch(surfaces_a[i], surfaces_b[i], n)) continue;
    for (std::size_t d = 0; d < Dim; ++d) sliding[d] = v_a[d] - v_b[d] - approach * n[d];
    const Real speed = std::sqrt(dot(sliding, sliding));
    const Real stopped = speed > 0 ? std::min(Real{1}, friction_ * approach / speed) : 0;
    const Real m_a = nodes_a.moved_mass[lane];
    const Real m_b = nodes_b.moved_mass[lane];
    for (std::size_t d = 0; d < Dim; ++d) {
      const Real relative = approach * n[d] + stopped * sliding[d];
      v_a[d] -= m_b / (m_a + m_b) * relative;
      v_b[d] += m_a / (m_a + m_b) * relative;
    }
    // Against a fluid, whose velocities at its surface are its own, it makes a floating block sink by 6 % more.
    if (!body_a.is_fluid() && !body_b.is_fluid())
      pressed.push_back({shared.tiles[a]->first, lane, shared.bodies[a], shared.bodies[b], n, stopped == 1});
    is_changed = true;
  }
  return is_changed;
}

template <int Dim, class R>
void Contact<Dim, R>::apply_second() {
  Index work_size = 0;
  for (const auto& band : pressed_) work_size += static_cast<Index>(band.size());
  parallel_for(static_cast<Index>(pressed_.size()), work_size, [&](Index band) {
    for (const Pressed& one : pressed_[static_cast<std::size_t>(band)]) {
      // Particles may have left the tile since.
      Tile<Dim, R>* const tiles[2] = {grids_[one.a]->find(one.tile), grids_[one.b]->find(one.tile)};
      if (tiles[0] == nullptr || tiles[1] == nullptr) continue;
      grids_[one.a]->prepare(*tiles[0], static_cast<std::size_t>(band));
      grids_[one.b]->prepare(*tiles[1], static_cast<std::size_t>(band));
      const Real m_a = tiles[0]->values.moved_mass[one.lane];
      const Real m_b = tiles[1]->values.moved_mass[one.lane];
      if (!(m_a > 0 && m_b > 0)) continue;
      Vec<Dim> relative;
      for (std::size_t d = 0; d < Dim; ++d) relative[d] = tiles[0]->values.second[d][one.lane] - tiles[1]->values.second[d][one.lane];
      const Real across = dot(relative, one.n);
      for (std::size_t d = 0; d < Dim; ++d) {
        const Real change = one.sticks ? relative[d] : across * one.n[d];
        tiles[0]->values.second[d][one.lane] -= static_cast<R>(m_b / (m_a + m_b) * change);
        tiles[1]->values.second[d][one.lane] += static_cast<R>(m_a / (m_a + m_b) * change);
      }
    }
  });
}

template <int Dim, class R>
void Contact<Dim, R>::declare_state(State& state) {
  std::vector<Index> counts;
  std::vector<Pressed> all;
  for (const std::vector<Pressed>& band : pressed_) {
    counts.push_back(static_cast<Index>(band.size()));
    all.insert(all.end(), band.begin(), band.end());
  }
  state.add("count_per_band", counts);
  state.rows("pressed", all);
  if (!state.is_loading()) return;
  pressed_.clear();
  auto next = all.begin();
  for (const Index count : counts) {
    if (count < 0 || count > all.end() - next) state.fail("count_per_band", "has not as many as there are rows");
    pressed_.emplace_back(next, next + count);
    next += count;
  }
  for (const Pressed& one : all) {
    if (one.lane < 0 || one.lane >= k_lanes<R> || std::max(one.a, one.b) >= grids_.size()) state.fail("pressed", "names no node");
  }
}

template class Contact<2, double>;
template class Contact<3, double>;
template class Contact<2, float>;
template class Contact<3, float>;

}  // namespace matpoint
