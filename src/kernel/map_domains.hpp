// Particles to grid for convected domains, whose weights are no products of one per direction.
#pragma once

#include "kernel/map_nodes.hpp"

namespace matpoint {
namespace {

template <int Dim, class R>
struct alignas(64) Domains {
  ConvectedDomain<Dim, Pack<R>> at[k_chunk_slots][k_lanes<R> / Pack<R>::k_width];
};

/// m_i += N_i m_p, p_i += N_i m_p (v_p + C_p (x_i - x_p)), f_i += N_i m_p b_p - V0 S grad N_i for a row of nodes, as in map_nodes.hpp.
template <Sweep S, int Dim, class R>
MPM_INLINE void map_row_of_domains(const SweepContext<Dim, R>& context, SweepChunk<Dim, R>& chunk, const ChunkBuffers<Dim, R>& buffers,
                                   const Domains<Dim, R>& domains, FetchAhead& ahead, int row) {
  using P = Pack<R>;
  using Domain = ConvectedDomain<Dim, P>;
  constexpr int L = k_lanes<R>;
  constexpr int n = Domain::k_nodes;
  const SlotLayout<Dim>& at = context.layout;
  const int node[3] = {0, row % n, row / n};
  const bool has_affine = S != Sweep::refine && (at.C >= 0 || context.has_spin);
  P h[Dim], scale[Dim];
  for (int d = 0; d < Dim; ++d) {
    h[d] = P(1 / static_cast<double>(context.inverse_cell_size[d]));
    // The sums have the mass where the formula has the volume, and derivatives in xi.
    scale[d] = P(static_cast<double>(context.inverse_cell_size[d]) / static_cast<double>(context.density));
  }
  NodeSums<R, n> mass, momentum[Dim], force[Dim];
  for (int part = 0; part < NodeSums<R, n>::k_parts; ++part) {
    const int lane = part * P::k_width;
    for (int i = 0; i < n; ++i) {
      mass.at[i][part] = P(0);
      for (int d = 0; d < Dim; ++d) momentum[d].at[i][part] = force[d].at[i][part] = P(0);
    }
    for (int k = 0; k < chunk.slots_in_use[part]; ++k) {
      const R* const slot = chunk.slots[k] + lane;
      const Domain& domain = domains.at[k][part];
      ahead.next();
      const P m = P::load(buffers.mass[k] + lane);
      P N_m[n], dN_m[Dim][n];
      domain.weights_of_row(node, N_m, dN_m);
      for (int i = 0; i < n; ++i) {
        N_m[i] *= m;
        for (int d = 0; d < Dim; ++d) dN_m[d][i] *= m * scale[d];
        if constexpr (Stages<S>::maps_mass) mass.at[i][part] += N_m[i];
      }
      for (int d = 0; Stages<S>::maps_momentum && d < Dim; ++d) {
        P v = P::load(S == Sweep::refine ? buffers.L_grad[k][d] + lane : slot + (at.v + d) * L);
        const P slope = has_affine ? affine_of(context, slot, d, 0) : P(0);
        for (int c = 0; has_affine && c < Dim; ++c)
          v += affine_of(context, slot, d, c) * (ShapeConvected<P>::place(node[c]) - domain.centre(c)) * h[c];
        for (int i = 0; i < n; ++i) {
          momentum[d].at[i][part] += N_m[i] * v;
          if (has_affine) v += slope * h[0];
        }
      }
      for (int c = 0; Stages<S>::maps_force && c < Dim; ++c) {
        for (int d = 0; d < Dim; ++d) {
          const P stress = P::load(at.u >= 0 ? buffers.P_stress[k][c * Dim + d] + lane : buffers.tau[k][stress_index(c, d)] + lane);
          for (int i = 0; i < n; ++i) force[c].at[i][part] -= dN_m[d][i] * stress;
        }
        if (at.b < 0) continue;
        for (int i = 0; i < n; ++i) force[c].at[i][part] += N_m[i] * P::load(slot + (at.b + c) * L);
      }
    }
  }
  NodeValues<Dim, R>&here = *chunk.nodes[row][0], &next = *chunk.nodes[row][1];
  if constexpr (Stages<S>::maps_mass) mass.add_to(here.mass, next.mass);
  for (int d = 0; d < Dim; ++d) {
    if constexpr (Stages<S>::maps_momentum) momentum[d].add_to(here.momentum[d], next.momentum[d]);
    if constexpr (Stages<S>::maps_force) force[d].add_to(here.force[d], next.force[d]);
  }
}

template <Sweep S, int Dim, class R>
MPM_INLINE void map_domains(const SweepContext<Dim, R>& context, SweepChunk<Dim, R>& chunk, const ChunkBuffers<Dim, R>& buffers,
                            FetchAhead& ahead) {
  using P = Pack<R>;
  Domains<Dim, R> domains;
  for (int part = 0; part < NodeSums<R, 2>::k_parts; ++part) {
    const int lane = part * P::k_width;
    ShapeConvected<P> shapes[Dim];
    for (int d = 0; d < Dim; ++d) shapes[d] = shape_of<SweepVariant::cpdi>(context, chunk, d, lane);
    for (int k = 0; k < chunk.slots_in_use[part]; ++k) {
      P x[Dim];
      for (int d = 0; d < Dim; ++d) x[d] = P::load(chunk.slots[k] + lane + (context.layout.x + d) * k_lanes<R>);
      domains.at[k][part] = domain_of(context, shapes, chunk.slots[k] + lane, x);
    }
  }
  for (int row = 0; row < rows_of<Dim>(ConvectedDomain<Dim, P>::k_nodes - 1); ++row)
    map_row_of_domains<S>(context, chunk, buffers, domains, ahead, row);
}

}  // namespace
}  // namespace matpoint
