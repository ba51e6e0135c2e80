// Where a body of particles ends, for contact: sums over the particles around some nodes.
#include "body/particle_body.hpp"
#include "kernel/shape.hpp"

namespace matpoint {

template <int Dim, class R>
template <class Shape>
void ParticleBody<Dim, R>::add_surfaces(const TileNodes<Dim>& nodes, std::vector<NodeSurface<Dim>>& sums, std::vector<Real>& masses) const {
  constexpr int n = Shape::k_nodes;
  constexpr int L = k_lanes<R>;
  const SlotLayout<Dim>& at = blocks_->layout();
  // The rows of cells that have the row of nodes, and along x the blocks before the tile and at it.
  for (int row = 0; row < rows_of<Dim>(n - 1); ++row) {
    const int index[3] = {0, row % n, row / n};
    for (const int before : {L, 0}) {
      Place<Dim> first = nodes.first;
      first[0] -= before;
      bool exists = first[0] >= 0 && first[0] < grid_.cells(0);
      for (int d = 1; d < Dim; ++d) {
        int& cell = first[static_cast<std::size_t>(d)];
        cell -= index[d];
        exists = exists && cell >= 0 && cell < grid_.cells(d);
      }
      const Block<Dim, R>* const block = exists ? blocks_->find(first) : nullptr;
      if (block == nullptr) continue;
      for (std::size_t i = 0; i < nodes.lanes.size(); ++i) {
        for (int local = 0; local < n; ++local) {
          const int lane = nodes.lanes[i] + before - local;  // of the cell
          if (lane < 0 || lane >= L) continue;
          Shape shapes[Dim];
          for (int d = 0; d < Dim; ++d) {
            const int cell = first[static_cast<std::size_t>(d)] + (d == 0 ? lane : 0);
            shapes[d] = shape_at<Shape>(cell, d);
          }
          for (int k = 0; k < block->count(lane); ++k) {
            const R* const fields = block->slot(k, at.field_count) + lane;
            const Particle p{fields, L, blocks_->position(*block, fields, lane)};
            R w[Dim][n], dw[Dim][n];
            for (int d = 0; d < Dim; ++d) shapes[d].weights(fields[(at.x + d) * L], w[d], dw[d]);
            const Real volume = J(p) * volume0(p);
            Real N_m = volume0(p) * material_->density();
            for (int d = 0; d < Dim; ++d) {
              const int j = d == 0 ? local : index[d];
              Real dN = volume / grid_.cell_size(d);
              for (int e = 0; e < Dim; ++e) dN *= static_cast<Real>(e == d ? dw[e][j] : w[e][e == 0 ? local : index[e]]);
              sums[i].outward[static_cast<std::size_t>(d)] += dN;
              N_m *= static_cast<Real>(w[d][j]);
            }
            masses[i] += N_m;
            for (std::size_t d = 0; d < Dim; ++d) sums[i].centroid[d] += N_m * p.position[d];
          }
        }
      }
    }
  }
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
template std::vector<NodeSurface<3>> ParticleBody<3, double>::surfaces(const TileNodes<3>&) const;
template std::vector<NodeSurface<2>> ParticleBody<2, float>::surfaces(const TileNodes<2>&) const;
template std::vector<NodeSurface<3>> ParticleBody<3, float>::surfaces(const TileNodes<3>&) const;

}  // namespace matpoint
