// What the correction of fluids (explicit/fluid_correction.cpp) does to the particles.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "body/particle_body.hpp"

namespace matpoint {
namespace {

// A particle is moved by at most this share of a cell at once.
constexpr Real k_shift_max = 0.1;

}  // namespace

template <int Dim, class R>
template <class Shape>
Real ParticleBody<Dim, R>::correct_with(CorrectionPass pass, const Correction<Dim>& correction) {
  constexpr int n = Shape::k_nodes;
  constexpr int L = k_lanes<R>;
  const SlotLayout<Dim>& at = blocks_->layout();
  const Real density = material_->density();
  std::vector<Real> work(blocks_->bands().size(), 0);
  for_each_band([&](std::size_t b) {
    Band& band = blocks_->bands()[b];
    blocks_->list_blocks(band);
    for (Block<Dim, R>* const block : band.blocks) {
      for (int k = 0; k < block->slot_count; ++k) {
        for (int lane = 0; lane < L; ++lane) {
          if (k >= block->count(lane)) continue;
          R* const fields = block->slot(k) + lane;
          const Particle p{fields, L, {}};
          const auto weights = weights_of<Shape>(*block, lane, fields, L);
          const R volume = static_cast<R>(volume0(p) * J(p));
          const R m = static_cast<R>(volume0(p) * density);
          R grid_velocity[Dim] = {}, rest[Dim] = {}, slope[Dim] = {}, slope_of_J[Dim] = {}, mean_of_J = 0;
          bool is_at_obstacle = false;
          const auto each_node = [&](auto&& f) {
            for (int row = 0; row < grid_.row_count(); ++row) {
              R N[n], dN[Dim][n];
              weights.of_row(row, N, dN);
              for (int i = 0; i < n; ++i) f(block->tiles[row][(lane + i) / L]->values, (lane + i) % L, N[i], dN, i);
            }
          };
          if (pass == CorrectionPass::spread) {
            each_node([&](NodeValues<Dim, R>& nodes, int node, R N, const auto&, int) {
              nodes.force[0][node] += N * volume;
              if (!is_fluid()) return;
              nodes.mass[node] += N * m;
              nodes.force[1][node] += N * m * static_cast<R>(J(p));
              for (int d = 0; d < Dim; ++d) nodes.momentum[d][node] += N * m * fields[(at.v + d) * L];
            });
            continue;
          }
          each_node([&](const NodeValues<Dim, R>& nodes, int node, R N, const auto& dN, int i) {
            for (int d = 0; d < Dim; ++d) {
              grid_velocity[d] += N * nodes.velocity[d][node];
              rest[d] += N * nodes.second[d][node];
              slope[d] += dN[d][i] * nodes.moved_mass[node];
              slope_of_J[d] += dN[d][i] * nodes.force[1][node];
            }
            mean_of_J += N * nodes.force[1][node];
            is_at_obstacle = is_at_obstacle || (nodes.moved_mass[node] < 0 && N > 0);
          });
          if (pass == CorrectionPass::residual) {
            each_node([&](NodeValues<Dim, R>& nodes, int node, R N, const auto&, int) {
              for (int d = 0; d < Dim; ++d) nodes.momentum[d][node] += N * m * (fields[(at.v + d) * L] - grid_velocity[d]);
            });
            continue;
          }
          R change_of_J = static_cast<R>(correction.relaxation) * (mean_of_J - static_cast<R>(J(p)));
          for (int d = 0; d < Dim; ++d) {
            R& v = fields[(at.v + d) * L];
            v -= static_cast<R>(correction.share) * (v - grid_velocity[d] - rest[d]);
            if (is_at_obstacle) continue;
            // Within its cell: then nothing has to be sorted, and no side is passed.
            const auto s = static_cast<std::size_t>(d);
            const Real h = grid_.cell_size(d);
            const Real wanted = -correction.shift[s] * static_cast<Real>(slope[d]) / (h * h);
            R& x = fields[(at.x + d) * L];
            const R moved =
                std::clamp(static_cast<R>(x + std::clamp(wanted, -k_shift_max, k_shift_max)), k_off_line<R>, R(1) - k_off_line<R>);
            work[b] -= static_cast<Real>(m) * correction.gravity[s] * static_cast<Real>(moved - x) * h;
            change_of_J += (moved - x) * slope_of_J[d];
            x = moved;
          }
          if (is_at_obstacle) continue;
          // J belongs to the place, so that the field of pressure stays where it is.
          const R s = static_cast<R>(std::pow(J(p) + static_cast<Real>(change_of_J), 1.0 / Dim));
          for (int d = 0; d < Dim; ++d) fields[(at.F + d * Dim + d) * L] = s;
        }
      }
    }
  });
  return std::accumulate(work.begin(), work.end(), Real{0});
}

template <int Dim, class R>
Real ParticleBody<Dim, R>::correct(CorrectionPass pass, const Correction<Dim>& correction) {
  switch (scheme_.shape) {
    case ShapeKind::linear: return correct_with<ShapeLinear<R>>(pass, correction);
    case ShapeKind::bspline2: return correct_with<ShapeBSpline2<R>>(pass, correction);
    case ShapeKind::bspline3: return correct_with<ShapeBSpline3<R>>(pass, correction);
    case ShapeKind::gimp: return correct_with<ShapeGimp<R>>(pass, correction);
    case ShapeKind::cpdi: return correct_with<ShapeConvected<R>>(pass, correction);
  }
  return 0;
}

template <int Dim, class R>
template <class Shape>
std::vector<Real> ParticleBody<Dim, R>::node_lengths_with(int d) const {
  // By as many midpoints as the body has particles: what these sum up to beside a wall, where they are as even as they can be, must not
  // count as an overfill.
  const int points = std::max(1, static_cast<int>(std::lround(0.5 / reach_)));
  std::vector<Real> lengths(static_cast<std::size_t>(grid_.nodes(d)), 0);
  for (int cell = 0; cell < grid_.cells(d); ++cell) {
    const Shape shape = shape_at<Shape>(cell, d);
    for (int point = 0; point < points; ++point) {
      R N[Shape::k_nodes], dN[Shape::k_nodes];
      shape.weights(static_cast<R>((point + 0.5) / points), N, dN);
      for (int i = 0; i < Shape::k_nodes; ++i)
        lengths[static_cast<std::size_t>(cell + i)] += static_cast<Real>(N[i]) * grid_.cell_size(d) / points;
    }
  }
  return lengths;
}

template <int Dim, class R>
std::vector<Real> ParticleBody<Dim, R>::node_lengths(int d) const {
  switch (scheme_.shape) {
    case ShapeKind::bspline2: return node_lengths_with<ShapeBSpline2<R>>(d);
    case ShapeKind::bspline3: return node_lengths_with<ShapeBSpline3<R>>(d);
    case ShapeKind::gimp: return node_lengths_with<ShapeGimp<R>>(d);
    default: return node_lengths_with<ShapeLinear<R>>(d);
  }
}

#define MATPOINT_INSTANTIATE(Dim, R)                                                          \
  template Real ParticleBody<Dim, R>::correct(CorrectionPass pass, const Correction<Dim>& c); \
  template std::vector<Real> ParticleBody<Dim, R>::node_lengths(int d) const;
MATPOINT_INSTANTIATE(2, double)
MATPOINT_INSTANTIATE(3, double)
MATPOINT_INSTANTIATE(2, float)
MATPOINT_INSTANTIATE(3, float)
#undef MATPOINT_INSTANTIATE

}  // namespace matpoint
