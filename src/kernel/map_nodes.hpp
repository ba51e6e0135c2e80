// Particles to grid for any shape: node by node, with what a particle may have beside mass, velocity and stress: an affine velocity, a
// body force, and stress and place in the reference configuration.
#pragma once

#include "kernel/chunk.hpp"

namespace matpoint {
namespace {

/// Weights of the particles of a chunk, and their derivatives in xi.
template <int Dim, class R, int n>
struct alignas(64) Weights {
  R N[k_chunk_slots][Dim][n][k_lanes<R>];
  R dN[k_chunk_slots][Dim][n][k_lanes<R>];
};

template <SweepVariant V, int Dim, class R, int n>
MPM_INLINE void compute_weights(const SweepContext<Dim, R>& context, const SweepChunk<Dim, R>& chunk, Weights<Dim, R, n>& weights,
                                int lane) {
  using P = Pack<R>;
  for (int d = 0; d < Dim; ++d) {
    const auto shape = shape_of<V>(context, chunk, d, lane);
    for (int k = 0; k < chunk.slots_in_use[lane / P::k_width]; ++k) {
      P N[n], dN[n];
      shape.weights(P::load(chunk.slots[k] + lane + (context.layout.x + d) * k_lanes<R>), N, dN);
      for (int i = 0; i < n; ++i) {
        N[i].store(weights.N[k][d][i] + lane);
        dN[i].store(weights.dN[k][d][i] + lane);
      }
    }
  }
}

/// Sums for the nodes of a row around each lane's cell, for all lanes of a block.
template <class R, int n>
struct NodeSums {
  static constexpr int k_parts = k_lanes<R> / Pack<R>::k_width;
  Pack<R> at[n][k_parts];

  /// Node i belongs i lanes further, the last of them to the next tile.
  MPM_INLINE void add_to(R* here, R* next) const {
    using P = Pack<R>;
    constexpr int k_packs_beyond = (n - 2) / P::k_width + 1;
    for (int part = 0; part < k_parts + k_packs_beyond; ++part) {
      R* const to = part < k_parts ? here + part * P::k_width : next + (part - k_parts) * P::k_width;
      P sum = P::load(to);
      add_node<0>(sum, part);
      sum.store(to);
    }
  }

 private:
  MPM_INLINE Pack<R> part_of(int i, int part) const { return part >= 0 && part < k_parts ? at[i][part] : Pack<R>(0); }
  template <int i>
  MPM_INLINE void add_node(Pack<R>& sum, int part) const {
    if constexpr (i < n) {
      constexpr int whole = i / Pack<R>::k_width;
      constexpr int rest = i % Pack<R>::k_width;
      if constexpr (rest == 0)
        sum += part_of(i, part - whole);
      else
        sum += shift_up<rest>(part_of(i, part - whole - 1), part_of(i, part - whole));
      add_node<i + 1>(sum, part);
    }
  }
};

/// Component (d, c) of the affine part of the velocity, of bodies that have one: each particle its own, or all the same.
template <int Dim, class R>
MPM_INLINE Pack<R> affine_of(const SweepContext<Dim, R>& context, const R* slot, int d, int c) {
  if (context.layout.C >= 0) return Pack<R>::load(slot + (context.layout.C + d * Dim + c) * k_lanes<R>);
  return Pack<R>(static_cast<double>(context.spin[d][c]));
}

/// m_i += N_i m_p, p_i += N_i m_p (v_p + C_p (x_i - x_p)) for a row of nodes.
template <Sweep S, SweepVariant V, int Dim, class R, int n>
MPM_INLINE void map_row_momentum(const SweepContext<Dim, R>& context, SweepChunk<Dim, R>& chunk, const ChunkBuffers<Dim, R>& buffers,
                                 const Weights<Dim, R, n>& weights, FetchAhead& ahead, int row) {
  using P = Pack<R>;
  constexpr int L = k_lanes<R>;
  const SlotLayout<Dim>& at = context.layout;
  const int node[3] = {0, row % n, row / n};
  const bool has_affine = S != Sweep::refine && (at.C >= 0 || context.has_spin);
  NodeSums<R, n> mass;
  NodeSums<R, n> momentum[Dim];
  for (int part = 0; part < NodeSums<R, n>::k_parts; ++part) {
    const int lane = part * P::k_width;
    P m_sum[n], p_sum[Dim][n], place[Dim]{}, step[n]{};
    typename Variant<V>::template Shape<P> shapes[Dim]{};
    for (int i = 0; i < n; ++i) {
      m_sum[i] = P(0);
      for (int d = 0; d < Dim; ++d) p_sum[d][i] = P(0);
    }
    if (has_affine) {
      for (int d = 0; d < Dim; ++d) {
        shapes[d] = shape_of<V>(context, chunk, d, lane);
        place[d] = shapes[d].place(node[d]);
        if (d > 0) continue;
        for (int i = 1; i < n; ++i) step[i] = (shapes[0].place(i) - place[0]) * P(1 / static_cast<double>(context.inverse_cell_size[0]));
      }
    }
    for (int k = 0; k < chunk.slots_in_use[part]; ++k) {
      const R* const slot = chunk.slots[k] + lane;
      ahead.next();
      P wm = P::load(buffers.mass[k] + lane) * P::load(weights.N[k][1][node[1]] + lane);
      if constexpr (Dim == 3) wm *= P::load(weights.N[k][2][node[2]] + lane);
      P N_m[n];
      for (int i = 0; i < n; ++i) {
        N_m[i] = wm * P::load(weights.N[k][0][i] + lane);
        if constexpr (Stages<S>::maps_mass) m_sum[i] += N_m[i];
      }
      P away[Dim];  // from the particle to the first node of the row
      if (has_affine) {
        for (int d = 0; d < Dim; ++d)
          away[d] =
              (place[d] - shapes[d].centre(P::load(slot + (at.x + d) * L))) * P(1 / static_cast<double>(context.inverse_cell_size[d]));
      }
      for (int d = 0; d < Dim; ++d) {
        P v = P::load(S == Sweep::refine ? buffers.L_grad[k][d] + lane : slot + (at.v + d) * L);
        if (has_affine) {
          P C[Dim];
          for (int c = 0; c < Dim; ++c) {
            C[c] = affine_of(context, slot, d, c);
            v += C[c] * away[c];
          }
          p_sum[d][0] += N_m[0] * v;
          for (int i = 1; i < n; ++i) p_sum[d][i] += N_m[i] * (v + C[0] * step[i]);
        } else {
          for (int i = 0; i < n; ++i) p_sum[d][i] += N_m[i] * v;
        }
      }
    }
    for (int i = 0; i < n; ++i) {
      mass.at[i][part] = m_sum[i];
      for (int d = 0; d < Dim; ++d) momentum[d].at[i][part] = p_sum[d][i];
    }
  }
  NodeValues<Dim, R>&here = *chunk.nodes[row][0], &next = *chunk.nodes[row][1];
  if constexpr (Stages<S>::maps_mass) mass.add_to(here.mass, next.mass);
  for (int d = 0; d < Dim; ++d) momentum[d].add_to(here.momentum[d], next.momentum[d]);
}

/// f_i += N_i m_p b_p - V0 S grad N_i for a row of nodes, and - V0 tau_hoop N_i / r along the radius, which does the work of v_r / r. S is
/// the Kirchhoff stress, or, of bodies with displacements, the first Piola-Kirchhoff stress with gradients in the reference configuration.
template <int Dim, class R, int n>
MPM_INLINE void map_row_force(const SweepContext<Dim, R>& context, SweepChunk<Dim, R>& chunk, const ChunkBuffers<Dim, R>& buffers,
                              const Weights<Dim, R, n>& weights, FetchAhead& ahead, int row) {
  using P = Pack<R>;
  constexpr int L = k_lanes<R>;
  const SlotLayout<Dim>& at = context.layout;
  const int j = row % n;
  const int l = row / n;
  // The sums have the mass where the formula has the volume, and derivatives in xi.
  P scale[Dim];
  for (int d = 0; d < Dim; ++d) scale[d] = P(static_cast<double>(context.inverse_cell_size[d]) / static_cast<double>(context.density));
  const P inverse_density = P(1 / static_cast<double>(context.density));
  NodeSums<R, n> force[Dim];
  for (int part = 0; part < NodeSums<R, n>::k_parts; ++part) {
    const int lane = part * P::k_width;
    P sum[Dim][n];
    for (int c = 0; c < Dim; ++c) {
      for (int i = 0; i < n; ++i) sum[c][i] = P(0);
    }
    for (int k = 0; k < chunk.slots_in_use[part]; ++k) {
      ahead.next();
      const P m = P::load(buffers.mass[k] + lane);
      // Weights across the row: of the slope in x, and the slopes in y and z, with what all their products have in common.
      P along_x = m * P::load(weights.N[k][1][j] + lane);
      P along_y = m * P::load(weights.dN[k][1][j] + lane);
      P along_z = P(0);
      if constexpr (Dim == 3) {
        along_z = along_x * P::load(weights.dN[k][2][l] + lane) * scale[2];
        along_x *= P::load(weights.N[k][2][l] + lane);
        along_y *= P::load(weights.N[k][2][l] + lane);
      }
      const P N_m = along_x;
      along_x *= scale[0];
      along_y *= scale[1];
      P N[n], dN[n];
      for (int i = 0; i < n; ++i) {
        N[i] = P::load(weights.N[k][0][i] + lane);
        dN[i] = P::load(weights.dN[k][0][i] + lane);
      }
      for (int c = 0; c < Dim; ++c) {
        const auto stress = [&](int d) {
          return P::load(at.u >= 0 ? buffers.P_stress[k][c * Dim + d] + lane : buffers.tau[k][stress_index(c, d)] + lane);
        };
        const P t_x = along_x * stress(0);
        P t = along_y * stress(1);
        if constexpr (Dim == 3) t += along_z * stress(2);
        if (Dim == 2 && c == 0 && at.hoop >= 0) {
          const P x = P::load(chunk.slots[k] + lane + at.x * L);
          t += N_m * P::load(buffers.tau[k][2] + lane) * (inverse_radius(context, chunk, lane, x) * inverse_density);
        }
        if (at.b >= 0) t -= N_m * P::load(chunk.slots[k] + lane + (at.b + c) * L);
        for (int i = 0; i < n; ++i) sum[c][i] -= dN[i] * t_x + N[i] * t;
      }
    }
    for (int c = 0; c < Dim; ++c) {
      for (int i = 0; i < n; ++i) force[c].at[i][part] = sum[c][i];
    }
  }
  NodeValues<Dim, R>&here = *chunk.nodes[row][0], &next = *chunk.nodes[row][1];
  for (int c = 0; c < Dim; ++c) force[c].add_to(here.force[c], next.force[c]);
}

template <Sweep S, SweepVariant V, int Dim, class R>
MPM_INLINE void map_nodes(const SweepContext<Dim, R>& context, SweepChunk<Dim, R>& chunk, const ChunkBuffers<Dim, R>& buffers,
                          FetchAhead& ahead) {
  constexpr int n = Variant<V>::k_nodes;
  Weights<Dim, R, n> weights;
  for (int lane = 0; lane < k_lanes<R>; lane += Pack<R>::k_width) compute_weights<V>(context, chunk, weights, lane);
  for (int row = 0; row < rows_of<Dim>(n - 1); ++row) {
    if constexpr (Stages<S>::maps_momentum) map_row_momentum<S, V>(context, chunk, buffers, weights, ahead, row);
    if constexpr (Stages<S>::maps_force) map_row_force(context, chunk, buffers, weights, ahead, row);
  }
}

}  // namespace
}  // namespace matpoint
