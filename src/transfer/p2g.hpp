// Particles to grid: m_i += N_i m_p, (mv)_i += N_i m_p v_p, f_i -= V0_p tau_p grad N_i (tau = J sigma, so V0 tau = V sigma).
//
// Each batch is worked in two short loops: one makes a record per particle, the next adds it to the nodes, weighted. Made and added in one
// loop, the scalar stores of a record would still be in flight when the vector loads of the additions want them.
#pragma once

#include "core/multiversion.hpp"
#include "transfer/views.hpp"

namespace matpoint {

/// What a P2G pass maps.
enum class Map { momentum, momentum_and_force };

template <int Dim, class Shape, Map What>
struct P2G {
  /// Adds the particles order[begin..end) to grid.mapped.
  MPM_MULTIVERSION static void run(const GridView<Dim>& grid, const ParticleView<Dim>& particles, const std::uint32_t* order, Index begin,
                                   Index end);
};

template <int Dim, class Shape, Map What>
MPM_MULTIVERSION void P2G<Dim, Shape, What>::run(const GridView<Dim>& grid, const ParticleView<Dim>& particles,
                                                 const std::uint32_t* order, Index begin, Index end) {
  constexpr int k_batch = 32;
  constexpr int W = k_mapped_width;
  constexpr int S = Shape::k_support;
  constexpr bool has_force = What == Map::momentum_and_force;
  constexpr int k_rows = has_force ? 1 + Dim : 1;
  // rows[p][0]: what N_i weighs; rows[p][1 + d]: what dN_i/dx_d weighs.
  alignas(64) Real rows[k_batch][k_rows][W] = {};
  Index base[k_batch];
  Real w[k_batch][Dim][S];
  Real dw[k_batch][Dim][S];

  for (Index first = begin; first < end; first += k_batch) {
    const int count = static_cast<int>(end - first < k_batch ? end - first : k_batch);
    for (int n = 0; n < count; ++n) {
      const std::uint32_t p = order[first + n];
      Index node = 0;
      for (int d = 0; d < Dim; ++d) {
        Real xi;
        node += grid.stride[d] * locate_in_cell<Dim>(grid, d, particles.x[d][p], xi);
        Shape::weights(xi, grid.inverse_cell_size[d], w[n][d], dw[n][d]);
      }
      base[n] = node * W;
      const Real m = particles.mass[p];
      rows[n][0][0] = m;
      for (int d = 0; d < Dim; ++d) rows[n][0][1 + d] = m * particles.v[d][p];
      if constexpr (has_force) {
        const Real minus_volume = -particles.volume0[p];
        for (int d = 0; d < Dim; ++d) {
          for (int c = 0; c < Dim; ++c) rows[n][1 + d][1 + Dim + c] = minus_volume * particles.tau[stress_index(c, d)][p];
        }
      }
    }
    for (int n = 0; n < count; ++n) {
      const auto& row = rows[n];
      Real* const corner = grid.mapped + base[n];
      for (int k = 0; k < (Dim == 3 ? S : 1); ++k) {
        const Real wz = Dim == 3 ? w[n][Dim - 1][k] : 1;
        for (int j = 0; j < S; ++j) {
          const Real wyz = w[n][1][j] * wz;
          Real* const line = corner + W * (j * grid.stride[1] + (Dim == 3 ? k * grid.stride[Dim - 1] : 0));
          for (int i = 0; i < S; ++i) {
            Real* const node = line + W * i;
            const Real N = w[n][0][i] * wyz;
            if constexpr (!has_force) {
              for (int c = 0; c < W; ++c) node[c] += N * row[0][c];
            } else {
              const Real dNx = dw[n][0][i] * wyz;
              const Real dNy = w[n][0][i] * dw[n][1][j] * wz;
              if constexpr (Dim == 2) {
                for (int c = 0; c < W; ++c) node[c] += N * row[0][c] + dNx * row[1][c] + dNy * row[2][c];
              } else {
                const Real dNz = w[n][0][i] * w[n][1][j] * dw[n][Dim - 1][k];
                for (int c = 0; c < W; ++c) node[c] += N * row[0][c] + dNx * row[1][c] + dNy * row[2][c] + dNz * row[Dim][c];
              }
            }
          }
        }
      }
    }
  }
}

}  // namespace matpoint
