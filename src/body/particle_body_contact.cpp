// Where a body of particles ends, for contact: sums over the particles around some nodes.
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

template std::vector<NodeSurface<2>> ParticleBody<2, double>::surfaces(const TileNodes<2>&) const;
template void ParticleBody<2, double>::measure_gaps(const TileNodes<2>&, int, bool, std::vector<Real>&) const;
template std::vector<NodeSurface<3>> ParticleBody<3, double>::surfaces(const TileNodes<3>&) const;
template void ParticleBody<3, double>::measure_gaps(const TileNodes<3>&, int, bool, std::vector<Real>&) const;
template std::vector<NodeSurface<2>> ParticleBody<2, float>::surfaces(const TileNodes<2>&) const;
template void ParticleBody<2, float>::measure_gaps(const TileNodes<2>&, int, bool, std::vector<Real>&) const;
template std::vector<NodeSurface<3>> ParticleBody<3, float>::surfaces(const TileNodes<3>&) const;
template void ParticleBody<3, float>::measure_gaps(const TileNodes<3>&, int, bool, std::vector<Real>&) const;

}  // namespace matpoint
