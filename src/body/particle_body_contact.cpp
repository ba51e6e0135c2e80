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
      const R* const fields = block.slot(k, at.field_count) + lane;
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
      const R* const fields = block.slot(k, blocks_->layout().field_count) + lane;
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
template <class Shape>
void ParticleBody<Dim, R>::add_forces_with(const std::vector<Real>& values) {
  constexpr int n = Shape::k_nodes;
  constexpr int L = k_lanes<R>;
  const SlotLayout<Dim>& at = blocks_->layout();
  const auto add = [&](const Block<Dim, R>& block, int lane, const R* fields, const Real* force) {
    R w[Dim][n], dw[Dim][n];
    for (int d = 0; d < Dim; ++d) {
      const int cell = block.first[static_cast<std::size_t>(d)] + (d == 0 ? lane : 0);
      const Shape shape = shape_at<Shape>(cell, d);
      shape.weights(fields[(at.x + d) * L], w[d], dw[d]);
    }
    for (int row = 0; row < grid_.row_count(); ++row) {
      for (int i = 0; i < n; ++i) {
        R N = w[0][i] * w[1][row % n];
        if constexpr (Dim == 3) N *= w[2][row / n];
        NodeValues<Dim, R>& nodes = block.tiles[row][(lane + i) / L]->values;
        for (int d = 0; d < Dim; ++d) nodes.force[d][(lane + i) % L] += N * static_cast<R>(force[d]);
      }
    }
  };
  for_each_band([&](std::size_t b) {
    blocks_->list_blocks(blocks_->bands()[b]);
    for (const Block<Dim, R>* block : blocks_->bands()[b].blocks) {
      for (int k = 0; k < block->slot_count; ++k) {
        const R* const slot = block->slot(k, at.field_count);
        for (int lane = 0; lane < L; ++lane) {
          if (k >= block->count(lane)) continue;
          const Real* const force = &values[static_cast<std::size_t>(id_from_bits(slot[at.id * L + lane])) * Dim];
          if (std::any_of(force, force + Dim, [](Real f) { return f != 0; })) add(*block, lane, slot + lane, force);
        }
      }
    }
  });
}

template <int Dim, class R>
void ParticleBody<Dim, R>::add_forces(const std::vector<Real>& values) {
  switch (scheme_.shape) {
    case ShapeKind::linear: return add_forces_with<ShapeLinear<R>>(values);
    case ShapeKind::bspline2: return add_forces_with<ShapeBSpline2<R>>(values);
    case ShapeKind::bspline3: return add_forces_with<ShapeBSpline3<R>>(values);
    case ShapeKind::gimp: return add_forces_with<ShapeGimp<R>>(values);
  }
}

template <int Dim, class R>
Real ParticleBody<Dim, R>::greatest_speed() const {
  Real sum = 0;
  for (const Real speed : speed_max_) sum += speed * speed;
  return std::sqrt(sum);
}

template void ParticleBody<2, double>::add_forces(const std::vector<Real>&);
template void ParticleBody<3, double>::add_forces(const std::vector<Real>&);
template void ParticleBody<2, float>::add_forces(const std::vector<Real>&);
template void ParticleBody<3, float>::add_forces(const std::vector<Real>&);
template Real ParticleBody<2, double>::greatest_speed() const;
template Real ParticleBody<3, double>::greatest_speed() const;
template Real ParticleBody<2, float>::greatest_speed() const;
template Real ParticleBody<3, float>::greatest_speed() const;
template std::vector<NodeSurface<2>> ParticleBody<2, double>::surfaces(const TileNodes<2>&) const;
template void ParticleBody<2, double>::measure_gaps(const TileNodes<2>&, int, bool, std::vector<Real>&) const;
template std::vector<NodeSurface<3>> ParticleBody<3, double>::surfaces(const TileNodes<3>&) const;
template void ParticleBody<3, double>::measure_gaps(const TileNodes<3>&, int, bool, std::vector<Real>&) const;
template std::vector<NodeSurface<2>> ParticleBody<2, float>::surfaces(const TileNodes<2>&) const;
template void ParticleBody<2, float>::measure_gaps(const TileNodes<2>&, int, bool, std::vector<Real>&) const;
template std::vector<NodeSurface<3>> ParticleBody<3, float>::surfaces(const TileNodes<3>&) const;
template void ParticleBody<3, float>::measure_gaps(const TileNodes<3>&, int, bool, std::vector<Real>&) const;

}  // namespace matpoint
