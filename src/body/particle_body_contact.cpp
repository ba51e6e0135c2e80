// What contact asks of a body of particles: where it ends, in sums over the particles around some nodes; and forces on some particles.
#include <algorithm>
#include <cmath>

#include "body/particle_body.hpp"
#include "kernel/shape.hpp"

namespace matpoint {

template <int Dim, class R>
template <class F>
void ParticleBody<Dim, R>::for_each_cell_around(const TileNodes<Dim>& nodes, F&& f) const {
  const int n = grid_.span() + 1;
  constexpr int L = k_lanes<R>;
  // The rows of cells that have the row of nodes, and along x the blocks before the tile and at it.
  for (int row = 0; row < grid_.row_count(); ++row) {
    for (const int before : {L, 0}) {
      std::array<int, 3> index{0, row % n, row / n};
      Place<Dim> first = nodes.first;
      first[0] -= before;
      bool exists = first[0] >= 0 && first[0] < grid_.cells(0);
      for (std::size_t d = 1; d < Dim; ++d) {
        first[d] -= index[d];
        exists = exists && first[d] >= 0 && first[d] < grid_.cells(static_cast<int>(d));
      }
      const Block<Dim, R>* const block = exists ? blocks_->find(first) : nullptr;
      if (block == nullptr) continue;
      for (std::size_t i = 0; i < nodes.lanes.size(); ++i) {
        for (index[0] = 0; index[0] < n; ++index[0]) {
          const int lane = nodes.lanes[i] + before - index[0];  // of the cell
          if (lane >= 0 && lane < L) f(i, index, *block, lane);
        }
      }
    }
  }
}

template <int Dim, class R>
template <class Shape>
void ParticleBody<Dim, R>::add_surfaces(const TileNodes<Dim>& nodes, std::vector<NodeSurface<Dim>>& sums, std::vector<Real>& masses) const {
  constexpr int n = Shape::k_nodes;
  constexpr int L = k_lanes<R>;
  const SlotLayout<Dim>& at = blocks_->layout();
  for_each_cell_around(nodes, [&](std::size_t i, const std::array<int, 3>& index, const Block<Dim, R>& block, int lane) {
    Shape shapes[Dim];
    for (int d = 0; d < Dim; ++d) shapes[d] = shape_at<Shape>(block.first[static_cast<std::size_t>(d)] + (d == 0 ? lane : 0), d);
    for (int k = 0; k < block.count(lane); ++k) {
      const R* const fields = block.slot(k) + lane;
      const Particle p{fields, L, blocks_->position(block, fields, lane)};
      R w[Dim][n], dw[Dim][n];
      for (int d = 0; d < Dim; ++d) shapes[d].weights(fields[(at.x + d) * L], w[d], dw[d]);
      const Real volume = J(p) * volume0(p);
      Real N_m = volume0(p) * material_->density();
      for (std::size_t d = 0; d < Dim; ++d) {
        Real dN = volume / grid_.cell_size(static_cast<int>(d));
        for (std::size_t e = 0; e < Dim; ++e) dN *= static_cast<Real>(e == d ? dw[e][index[e]] : w[e][index[e]]);
        sums[i].outward[d] += dN;
        N_m *= static_cast<Real>(w[d][index[d]]);
      }
      masses[i] += N_m;
      for (std::size_t d = 0; d < Dim; ++d) sums[i].centroid[d] += N_m * p.position[d];
    }
  });
}

template <int Dim, class R>
void ParticleBody<Dim, R>::measure_gaps(const TileNodes<Dim>& nodes, int axis, bool is_upper, std::vector<Real>& gaps) const {
  const auto d = static_cast<std::size_t>(axis);
  for_each_cell_around(nodes, [&](std::size_t i, const std::array<int, 3>&, const Block<Dim, R>& block, int lane) {
    for (int k = 0; k < block.count(lane); ++k) {
      const R* const fields = block.slot(k) + lane;
      const Particle p{fields, k_lanes<R>, blocks_->position(block, fields, lane)};
      const Real distance = is_upper ? grid_.upper(axis) - p.position[d] : p.position[d] - grid_.lower(axis);
      gaps[i] = std::min(gaps[i], distance - reach_ * grid_.cell_size(axis) * std::pow(J(p), Real{1} / Dim));
    }
  });
}

template <int Dim, class R>
std::vector<NodeSurface<Dim>> ParticleBody<Dim, R>::surfaces(const TileNodes<Dim>& nodes) const {
  std::vector<NodeSurface<Dim>> sums(nodes.lanes.size());
  std::vector<Real> masses(nodes.lanes.size(), 0);
  if (scheme_.shape == ShapeKind::linear)
    add_surfaces<ShapeLinear<R>>(nodes, sums, masses);
  else
    add_surfaces<ShapeBSpline2<R>>(nodes, sums, masses);
  for (std::size_t i = 0; i < sums.size(); ++i) {
    for (Real& x : sums[i].centroid) x /= masses[i];
  }
  return sums;
}

template <int Dim, class R>
void ParticleBody<Dim, R>::measure_reach(const TileNodes<Dim>& nodes, std::vector<NodeReach<Dim>>& reach) const {
  for_each_cell_around(nodes, [&](std::size_t i, const std::array<int, 3>&, const Block<Dim, R>& block, int lane) {
    for (int k = 0; k < block.count(lane); ++k) {
      const Vec3 x = blocks_->position(block, block.slot(k) + lane, lane);
      for (std::size_t c = 0; c < NodeReach<Dim>::k_directions; ++c) {
        Real along = 0;
        for (std::size_t d = 0; d < Dim; ++d) along += x[d] * reach[i].along[c][d];
        reach[i].farthest[c] = std::max(reach[i].farthest[c], along);
      }
    }
  });
}

template <int Dim, class R>
template <class F>
void ParticleBody<Dim, R>::for_each_place_near(const Band& band, const Extent<Dim>& box, F&& f) const {
  const bool is_total = blocks_->layout().u >= 0;
  for (const auto& row : band.rows) {
    for (const Block<Dim, R>* block : row.blocks) {
      if (block == nullptr) continue;
      bool is_near = true;
      for (int d = 0; d < Dim; ++d) {
        const auto s = static_cast<std::size_t>(d);
        const Real h = grid_.cell_size(d);
        const Real lower = grid_.lower(d) + (block->first[s] - 1) * h;
        const Real upper = grid_.lower(d) + (block->first[s] + (d == 0 ? k_lanes<R> : 1) + 1) * h;
        is_near = is_near && lower <= box.upper[s] && upper >= box.lower[s];
      }
      if (!is_near && !is_total) continue;
      for (int k = 0; k < block->slot_count; ++k) {
        for (int lane = 0; lane < k_lanes<R>; ++lane) {
          if (k < block->count(lane)) f(*block, k, lane);
        }
      }
    }
  }
}

template <int Dim, class R>
Extent<Dim> ParticleBody<Dim, R>::extent() const {
  const std::vector<Band>& bands = blocks_->bands();
  constexpr Real k_far = std::numeric_limits<Real>::infinity();
  Extent<Dim> none;
  none.lower.fill(k_far);
  none.upper.fill(-k_far);
  std::vector<Extent<Dim>> parts(bands.size(), none);
  parallel_for(static_cast<Index>(bands.size()), blocks_->count(), [&](Index b) {
    Extent<Dim>& part = parts[static_cast<std::size_t>(b)];
    const Band& band = bands[static_cast<std::size_t>(b)];
    const auto include = [&](std::size_t d, Real lower, Real upper) {
      part.lower[d] = std::min(part.lower[d], lower);
      part.upper[d] = std::max(part.upper[d], upper);
    };
    if (blocks_->layout().u >= 0) {
      blocks_->for_each(band, [&](const R* fields, const Vec3& place) {
        const Vec3 x = position_of(fields, k_lanes<R>, place);
        for (std::size_t d = 0; d < Dim; ++d) include(d, x[d], x[d]);
      });
      return;
    }
    for (const auto& row : band.rows) {
      for (const Block<Dim, R>* block : row.blocks) {
        for (int lane = 0; block != nullptr && lane < k_lanes<R>; ++lane) {
          for (int d = 0; d < Dim && block->count(lane) > 0; ++d) {
            const int cell = block->first[static_cast<std::size_t>(d)] + (d == 0 ? lane : 0);
            const Real h = grid_.cell_size(d);
            include(static_cast<std::size_t>(d), grid_.lower(d) + cell * h, grid_.lower(d) + (cell + 1) * h);
          }
        }
      }
    }
  });
  for (const Extent<Dim>& part : parts) {
    for (std::size_t d = 0; d < Dim; ++d) {
      none.lower[d] = std::min(none.lower[d], part.lower[d]);
      none.upper[d] = std::max(none.upper[d], part.upper[d]);
    }
  }
  return none;
}

template <int Dim, class R>
auto ParticleBody<Dim, R>::seats() const -> const std::vector<Seat>& {
  if (!seats_.empty()) return seats_;
  seats_.resize(static_cast<std::size_t>(id_count_));
  const SlotLayout<Dim>& at = blocks_->layout();
  for (const Band& band : blocks_->bands()) {
    for_each_place_near(band, {}, [&](const Block<Dim, R>& block, int k, int lane) {
      const R* const fields = block.slot(k) + lane;
      seats_[static_cast<std::size_t>(id_from_bits(fields[at.id * k_lanes<R>]))] = {&block, k, lane};
    });
  }
  return seats_;
}

template <int Dim, class R>
std::vector<MovingPoint<Dim>> ParticleBody<Dim, R>::particles_in(const Extent<Dim>& box, const std::vector<Index>* candidates) const {
  const SlotLayout<Dim>& at = blocks_->layout();
  const auto push_if_in = [&](const Block<Dim, R>& block, int k, int lane, std::vector<MovingPoint<Dim>>& points) {
    const R* const fields = block.slot(k) + lane;
    const Vec3 x = position_of(fields, k_lanes<R>, blocks_->position(block, fields, lane));
    MovingPoint<Dim> point;
    bool is_in = true;
    for (std::size_t d = 0; d < Dim; ++d) {
      is_in = is_in && x[d] >= box.lower[d] && x[d] <= box.upper[d];
      point.x[d] = x[d];
      point.v[d] = static_cast<Real>(fields[(at.v + static_cast<int>(d)) * k_lanes<R>]);
    }
    if (!is_in) return;
    point.id = id_from_bits(fields[at.id * k_lanes<R>]);
    if (candidates == nullptr || std::binary_search(candidates->begin(), candidates->end(), point.id)) points.push_back(point);
  };
  std::vector<MovingPoint<Dim>> all;
  if (candidates != nullptr && at.u >= 0) {
    for (const Index id : *candidates) {
      const Seat& seat = seats()[static_cast<std::size_t>(id)];
      push_if_in(*seat.block, seat.slot, seat.lane, all);
    }
    return all;
  }
  const std::vector<Band>& bands = blocks_->bands();
  std::vector<std::vector<MovingPoint<Dim>>> parts(bands.size());
  parallel_for(static_cast<Index>(bands.size()), blocks_->count(), [&](Index b) {
    const auto part = static_cast<std::size_t>(b);
    for_each_place_near(bands[part], box, [&](const Block<Dim, R>& block, int k, int lane) { push_if_in(block, k, lane, parts[part]); });
  });
  for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

template <int Dim, class R>
template <class Shape>
void ParticleBody<Dim, R>::add_force_with(const Block<Dim, R>& block, int lane, const R* fields, const Real* force) {
  constexpr int n = Shape::k_nodes;
  constexpr int L = k_lanes<R>;
  const auto weights = weights_of<Shape>(block, lane, fields, L);
  for (int row = 0; row < grid_.row_count(); ++row) {
    R N[n], dN[Dim][n];
    weights.of_row(row, N, dN);
    for (int i = 0; i < n; ++i) {
      NodeValues<Dim, R>& nodes = block.tiles[row][(lane + i) / L]->values;
      for (int d = 0; d < Dim; ++d) nodes.force[d][(lane + i) % L] += N[i] * static_cast<R>(force[d]);
    }
  }
}

template <int Dim, class R>
template <class Shape>
void ParticleBody<Dim, R>::add_forces_with(const std::vector<Real>& values, const std::vector<Index>& ids, const Extent<Dim>& box) {
  const SlotLayout<Dim>& at = blocks_->layout();
  const auto add = [&](const Block<Dim, R>& block, int k, int lane) {
    const R* const fields = block.slot(k) + lane;
    const Real* const force = &values[static_cast<std::size_t>(id_from_bits(fields[at.id * k_lanes<R>])) * Dim];
    if (std::any_of(force, force + Dim, [](Real f) { return f != 0; })) add_force_with<Shape>(block, lane, fields, force);
  };
  if (at.u < 0) {
    for_each_band([&](std::size_t b) { for_each_place_near(blocks_->bands()[b], box, add); });
    return;
  }
  for (const Index id : ids) {
    const Seat& seat = seats()[static_cast<std::size_t>(id)];
    add(*seat.block, seat.slot, seat.lane);
  }
}

template <int Dim, class R>
void ParticleBody<Dim, R>::add_forces(const std::vector<Real>& values, const std::vector<Index>& ids, const Extent<Dim>& box) {
  switch (scheme_.shape) {
    case ShapeKind::linear: return add_forces_with<ShapeLinear<R>>(values, ids, box);
    case ShapeKind::bspline2: return add_forces_with<ShapeBSpline2<R>>(values, ids, box);
    case ShapeKind::bspline3: return add_forces_with<ShapeBSpline3<R>>(values, ids, box);
    case ShapeKind::gimp: return add_forces_with<ShapeGimp<R>>(values, ids, box);
    case ShapeKind::cpdi: return add_forces_with<ShapeConvected<R>>(values, ids, box);
  }
}

template <int Dim, class R>
Real ParticleBody<Dim, R>::greatest_speed() const {
  Real sum = 0;
  for (const Real speed : speed_max_) sum += speed * speed;
  return std::sqrt(sum);
}

template void ParticleBody<2, double>::add_forces(const std::vector<Real>&, const std::vector<Index>&, const Extent<2>&);
template Extent<2> ParticleBody<2, double>::extent() const;
template std::vector<MovingPoint<2>> ParticleBody<2, double>::particles_in(const Extent<2>&, const std::vector<Index>*) const;
template void ParticleBody<3, double>::add_forces(const std::vector<Real>&, const std::vector<Index>&, const Extent<3>&);
template Extent<3> ParticleBody<3, double>::extent() const;
template std::vector<MovingPoint<3>> ParticleBody<3, double>::particles_in(const Extent<3>&, const std::vector<Index>*) const;
template void ParticleBody<2, float>::add_forces(const std::vector<Real>&, const std::vector<Index>&, const Extent<2>&);
template Extent<2> ParticleBody<2, float>::extent() const;
template std::vector<MovingPoint<2>> ParticleBody<2, float>::particles_in(const Extent<2>&, const std::vector<Index>*) const;
template void ParticleBody<3, float>::add_forces(const std::vector<Real>&, const std::vector<Index>&, const Extent<3>&);
template Extent<3> ParticleBody<3, float>::extent() const;
template std::vector<MovingPoint<3>> ParticleBody<3, float>::particles_in(const Extent<3>&, const std::vector<Index>*) const;
template Real ParticleBody<2, double>::greatest_speed() const;
template Real ParticleBody<3, double>::greatest_speed() const;
template Real ParticleBody<2, float>::greatest_speed() const;
template Real ParticleBody<3, float>::greatest_speed() const;
template std::vector<NodeSurface<2>> ParticleBody<2, double>::surfaces(const TileNodes<2>&) const;
template void ParticleBody<2, double>::measure_reach(const TileNodes<2>&, std::vector<NodeReach<2>>&) const;
template void ParticleBody<2, double>::measure_gaps(const TileNodes<2>&, int, bool, std::vector<Real>&) const;
template std::vector<NodeSurface<3>> ParticleBody<3, double>::surfaces(const TileNodes<3>&) const;
template void ParticleBody<3, double>::measure_reach(const TileNodes<3>&, std::vector<NodeReach<3>>&) const;
template void ParticleBody<3, double>::measure_gaps(const TileNodes<3>&, int, bool, std::vector<Real>&) const;
template std::vector<NodeSurface<2>> ParticleBody<2, float>::surfaces(const TileNodes<2>&) const;
template void ParticleBody<2, float>::measure_reach(const TileNodes<2>&, std::vector<NodeReach<2>>&) const;
template void ParticleBody<2, float>::measure_gaps(const TileNodes<2>&, int, bool, std::vector<Real>&) const;
template std::vector<NodeSurface<3>> ParticleBody<3, float>::surfaces(const TileNodes<3>&) const;
template void ParticleBody<3, float>::measure_reach(const TileNodes<3>&, std::vector<NodeReach<3>>&) const;
template void ParticleBody<3, float>::measure_gaps(const TileNodes<3>&, int, bool, std::vector<Real>&) const;

}  // namespace matpoint
