// Particles to grid with linear shapes and nothing but mass, momentum and stress: the fastest of the mappings.
#pragma once

#include "kernel/chunk.hpp"

namespace matpoint {
namespace {

/// Sums for the nodes at the left and at the right end of each lane's cell, for all lanes of a block.
template <class R>
struct EndSums {
  static constexpr int k_parts = k_lanes<R> / Pack<R>::k_width;
  Pack<R> left[k_parts];
  Pack<R> right[k_parts];

  MPM_INLINE void set(int part, Pack<R> at_left, Pack<R> at_right) {
    left[part] = at_left;
    right[part] = at_right;
  }
  /// Adds them to the nodes: the right ones belong one lane further, the last of them to the next tile. Whole packs are read and
  /// written throughout: a pack that is read across two shorter writes would have to wait for both to reach the cache.
  MPM_INLINE void add_to(R* here, R* next) const {
    using P = Pack<R>;
    for (int part = 0; part < k_parts; ++part) {
      R* const at = here + part * P::k_width;
      (P::load(at) + (left[part] + shift_up(part > 0 ? right[part - 1] : P(0), right[part]))).store(at);
    }
    (P::load(next) + shift_up(right[k_parts - 1], P(0))).store(next);
  }
};

/// Rows of nodes whose sums fit into the registers together.
template <int Dim>
constexpr int k_rows_at_once = Dim == 2 ? 2 : 1;

/// m_i += N_i m_p, p_i += N_i m_p v_p for some rows of nodes.
template <Sweep S, int Dim, class R, int first_row>
MPM_INLINE void map_mass_and_momentum(const SweepContext<Dim, R>& context, SweepChunk<Dim, R>& chunk, const ChunkBuffers<Dim, R>& buffers,
                                      FetchAhead& ahead) {
  using P = Pack<R>;
  constexpr int L = k_lanes<R>;
  constexpr int rows = k_rows_at_once<Dim>;
  const SlotLayout<Dim>& at = context.layout;
  const P one = P(1);
  EndSums<R> mass[rows];
  EndSums<R> momentum[rows][Dim];
  for (int part = 0; part < EndSums<R>::k_parts; ++part) {
    const int lane = part * P::k_width;
    P m_sum[rows][2], p_sum[rows][2][Dim];
    for (int r = 0; r < rows; ++r) {
      for (int i = 0; i < 2; ++i) {
        m_sum[r][i] = P(0);
        for (int d = 0; d < Dim; ++d) p_sum[r][i][d] = P(0);
      }
    }
    for (int k = 0; k < chunk.slots_in_use[part]; ++k) {
      const R* const slot = chunk.slots[k] + lane;
      ahead.next();
      const P m = P::load(buffers.mass[k] + lane);
      const P x = P::load(slot + at.x * L);
      const P y = P::load(slot + (at.x + 1) * L);
      P v[Dim];
      for (int d = 0; d < Dim; ++d) v[d] = P::load(slot + (at.v + d) * L);
      for (int r = 0; r < rows; ++r) {
        const int row = first_row + r;
        P wm = m * (row % 2 == 0 ? one - y : y);
        if constexpr (Dim == 3) {
          const P z = P::load(slot + (at.x + 2) * L);
          wm *= row / 2 == 0 ? one - z : z;
        }
        for (int i = 0; i < 2; ++i) {
          const P N_m = wm * (i == 0 ? one - x : x);
          if constexpr (Stages<S>::maps_mass) m_sum[r][i] += N_m;
          for (int d = 0; d < Dim; ++d) p_sum[r][i][d] += N_m * v[d];
        }
      }
    }
    for (int r = 0; r < rows; ++r) {
      mass[r].set(part, m_sum[r][0], m_sum[r][1]);
      for (int d = 0; d < Dim; ++d) momentum[r][d].set(part, p_sum[r][0][d], p_sum[r][1][d]);
    }
  }
  for (int r = 0; r < rows; ++r) {
    NodeValues<Dim, R>&here = *chunk.nodes[first_row + r][0], &next = *chunk.nodes[first_row + r][1];
    if constexpr (Stages<S>::maps_mass) mass[r].add_to(here.mass, next.mass);
    for (int d = 0; d < Dim; ++d) momentum[r][d].add_to(here.momentum[d], next.momentum[d]);
  }
}

/// Components of the force whose sums fit into the registers together.
template <int Dim>
constexpr int k_components_at_once = Dim == 2 ? 2 : 1;

/// f_i -= V0 tau grad N_i, for some components. The derivative of N_i along an axis is, but for its sign, the same at both ends of an edge
/// of the cell. So each edge sums once what its two nodes then take with opposite signs: 4 sums per component instead of 8 in 2D, 12
/// instead of 24 in 3D.
template <int Dim, class R, int first_component>
MPM_INLINE void map_force(const SweepContext<Dim, R>& context, SweepChunk<Dim, R>& chunk, const ChunkBuffers<Dim, R>& buffers,
                          FetchAhead& ahead) {
  using P = Pack<R>;
  constexpr int L = k_lanes<R>;
  constexpr int edges = rows_of<Dim>(1);  // along each axis
  constexpr int components = k_components_at_once<Dim>;
  const SlotLayout<Dim>& at = context.layout;
  const P one = P(1);
  EndSums<R> force[rows_of<Dim>(1)][components];
  for (int part = 0; part < EndSums<R>::k_parts; ++part) {
    const int lane = part * P::k_width;
    // Edges along x are numbered by their row (bit 0: y, bit 1: z), those along y by x and z, those along z by x and y.
    P sum[components][Dim][edges];
    for (int c = 0; c < components; ++c) {
      for (int d = 0; d < Dim; ++d) {
        for (int e = 0; e < edges; ++e) sum[c][d][e] = P(0);
      }
    }
    for (int k = 0; k < chunk.slots_in_use[part]; ++k) {
      const R* const slot = chunk.slots[k] + lane;
      ahead.next();
      const P m = P::load(buffers.mass[k] + lane);
      P w[Dim][2];
      for (int d = 0; d < Dim; ++d) {
        w[d][1] = P::load(slot + (at.x + d) * L);
        w[d][0] = one - w[d][1];
      }
      for (int c = 0; c < components; ++c) {
        for (int d = 0; d < Dim; ++d) {
          const P t = m * P::load(buffers.tau[k][stress_index(first_component + c, d)] + lane);
          const int low = d == 0 ? 1 : 0;  // the axes across the edge
          for (int i = 0; i < 2; ++i) {
            if constexpr (Dim == 2) {
              sum[c][d][i] += w[low][i] * t;
            } else {
              const int high = d == 2 ? 1 : 2;
              const P t_high = w[high][i] * t;
              sum[c][d][2 * i] += w[low][0] * t_high;
              sum[c][d][2 * i + 1] += w[low][1] * t_high;
            }
          }
        }
      }
    }
    // The sums have the mass where the formula has the volume, and derivatives in xi.
    for (int c = 0; c < components; ++c) {
      for (int d = 0; d < Dim; ++d) {
        const P scale = P(static_cast<double>(context.inverse_cell_size[d]) / static_cast<double>(context.density));
        for (int e = 0; e < edges; ++e) sum[c][d][e] *= scale;
      }
      for (int row = 0; row < rows_of<Dim>(1); ++row) {
        const int j = row % 2;
        const int k = row / 2;
        P left = sum[c][0][row];
        P right = -sum[c][0][row];
        for (int i = 0; i < 2; ++i) {
          P& end = i == 0 ? left : right;
          const P along_y = sum[c][1][i + 2 * k];
          end = j == 0 ? end + along_y : end - along_y;
          if constexpr (Dim == 3) {
            const P along_z = sum[c][2][i + 2 * j];
            end = k == 0 ? end + along_z : end - along_z;
          }
        }
        force[row][c].set(part, left, right);
      }
    }
  }
  for (int row = 0; row < rows_of<Dim>(1); ++row) {
    NodeValues<Dim, R>&here = *chunk.nodes[row][0], &next = *chunk.nodes[row][1];
    for (int c = 0; c < components; ++c) force[row][c].add_to(here.force[first_component + c], next.force[first_component + c]);
  }
}

template <Sweep S, int Dim, class R, int first_row = 0>
MPM_INLINE void map_all_rows(const SweepContext<Dim, R>& context, SweepChunk<Dim, R>& chunk, const ChunkBuffers<Dim, R>& buffers,
                             FetchAhead& ahead) {
  if constexpr (first_row < rows_of<Dim>(1)) {
    map_mass_and_momentum<S, Dim, R, first_row>(context, chunk, buffers, ahead);
    map_all_rows<S, Dim, R, first_row + k_rows_at_once<Dim>>(context, chunk, buffers, ahead);
  }
}

template <int Dim, class R, int first_component = 0>
MPM_INLINE void map_all_components(const SweepContext<Dim, R>& context, SweepChunk<Dim, R>& chunk, const ChunkBuffers<Dim, R>& buffers,
                                   FetchAhead& ahead) {
  if constexpr (first_component < Dim) {
    map_force<Dim, R, first_component>(context, chunk, buffers, ahead);
    map_all_components<Dim, R, first_component + k_components_at_once<Dim>>(context, chunk, buffers, ahead);
  }
}

}  // namespace
}  // namespace matpoint
