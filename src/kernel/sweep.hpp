// The sweep over a block's particles: grid to particles, stress, particles to grid, in short loops over the slots of a block. The loops
// hand over velocity gradients and stresses through small buffers that stay in the first-level cache.
#pragma once

#include "core/tensor.hpp"
#include "kernel/gather.hpp"
#include "kernel/map_domains.hpp"
#include "kernel/map_linear.hpp"
#include "kernel/map_nodes.hpp"

namespace matpoint {
namespace {

/// F^-T of the particles of a slot, from `lane` on.
template <int Dim, class R>
MPM_INLINE Mat3<Pack<R>, Dim == 2> inverse_transpose(const SlotLayout<Dim>& at, const R* slot) {
  using P = Pack<R>;
  auto F = Mat3<P, Dim == 2>::identity();
  for (int r = 0; r < Dim; ++r) {
    for (int c = 0; c < Dim; ++c) F(r, c) = P::load(slot + (at.F + r * Dim + c) * k_lanes<R>);
  }
  auto G = cofactor(F);
  const P inverse_J = P(1) / determinant(F);
  for (P& entry : G.entries) entry *= inverse_J;
  return G;
}

/// In place: dv/dX = dF/dt to L = dF/dt F^-1, of which the law makes F + dt dF/dt again.
template <int Dim, class R>
MPM_INLINE void to_velocity_gradient(const SweepContext<Dim, R>& context, const SweepChunk<Dim, R>& chunk, ChunkBuffers<Dim, R>& buffers,
                                     int k, int lane) {
  using P = Pack<R>;
  const auto G = inverse_transpose<Dim, R>(context.layout, chunk.slots[k] + lane);
  P rate[Dim * Dim];
  for (int e = 0; e < Dim * Dim; ++e) rate[e] = P::load(buffers.L_grad[k][e] + lane);
  for (int r = 0; r < Dim; ++r) {
    for (int c = 0; c < Dim; ++c) {
      P sum = rate[r * Dim] * G(c, 0);
      for (int e = 1; e < Dim; ++e) sum += rate[r * Dim + e] * G(c, e);
      sum.store(buffers.L_grad[k][r * Dim + c] + lane);
    }
  }
}

/// P = tau F^-T.
template <int Dim, class R>
MPM_INLINE void to_first_piola_kirchhoff(const SweepContext<Dim, R>& context, const SweepChunk<Dim, R>& chunk,
                                         ChunkBuffers<Dim, R>& buffers, int k, int lane) {
  using P = Pack<R>;
  const auto G = inverse_transpose<Dim, R>(context.layout, chunk.slots[k] + lane);
  for (int r = 0; r < Dim; ++r) {
    for (int c = 0; c < Dim; ++c) {
      P sum = P::load(buffers.tau[k][stress_index(r, 0)] + lane) * G(0, c);
      for (int e = 1; e < Dim; ++e) sum += P::load(buffers.tau[k][stress_index(r, e)] + lane) * G(e, c);
      sum.store(buffers.P_stress[k][r * Dim + c] + lane);
    }
  }
}

/// F-bar, or mean dilatation, as a rate (Hughes 1980; de Souza Neto et al. 1996; Zhao, Jiang & Choo 2023 for MPM): the volumetric part of L
/// is replaced by its mean over the particles of a cell, weighted by their masses,
///
///     L' = L + (tr_m - tr L) I / dim,
///
/// with dim = 3 around an axis.
///
/// The forces are those that do the same work: with the spherical part of the stress replaced by the mean of V0 tr tau / dim. So energy
/// balances as without. Cells with more particles than a chunk has slots form several such groups.
///
/// `diagonal(k, d)`: where component (d, d) of the slot k is, that around the axis included.
template <int Dim, class R, class Diagonal>
MPM_INLINE void average_spherical_part(const SweepContext<Dim, R>& context, const SweepChunk<Dim, R>& chunk, Diagonal&& diagonal) {
  using P = Pack<R>;
  const int directions = context.layout.hoop >= 0 ? 3 : Dim;
  for (int lane = 0; lane < k_lanes<R>; lane += P::k_width) {
    const P counts = P::load(chunk.counts + lane);
    const auto spherical = [&](int k) {
      P trace = P::load(diagonal(k, 0) + lane);
      for (int d = 1; d < directions; ++d) trace += P::load(diagonal(k, d) + lane);
      return trace * P(1.0 / directions);
    };
    P sum = P(0);
    P weight = P(1e-30);
    for (int k = 0; k < chunk.slots_in_use[lane / P::k_width]; ++k) {
      const Mask<R> live = counts > P(static_cast<double>(k));
      const P m = select(live, mass_of(context, chunk.slots[k] + lane), P(0));
      sum += m * select(live, spherical(k), P(0));
      weight += m;
    }
    const P mean = sum / weight;
    for (int k = 0; k < chunk.slots_in_use[lane / P::k_width]; ++k) {
      const Mask<R> live = counts > P(static_cast<double>(k));
      const P change = select(live, mean - spherical(k), P(0));
      for (int d = 0; d < directions; ++d) (P::load(diagonal(k, d) + lane) + change).store(diagonal(k, d) + lane);
    }
  }
}

template <int Dim, class R>
__attribute__((noinline)) void average_gradients(const SweepContext<Dim, R>& context, const SweepChunk<Dim, R>& chunk,
                                                 ChunkBuffers<Dim, R>& buffers) {
  average_spherical_part(context, chunk, [&](int k, int d) { return d == Dim ? buffers.L_hoop[k] : buffers.L_grad[k][d * Dim + d]; });
}
template <int Dim, class R>
__attribute__((noinline)) void average_stresses(const SweepContext<Dim, R>& context, const SweepChunk<Dim, R>& chunk,
                                                ChunkBuffers<Dim, R>& buffers) {
  average_spherical_part(context, chunk, [&](int k, int d) { return buffers.tau[k][d]; });
}

template <class R, int Dim, class F>
MPM_INLINE void for_each_pack(const SweepChunk<Dim, R>& chunk, F&& f) {
  for (int lane = 0; lane < k_lanes<R>; lane += Pack<R>::k_width) {
    for (int k = 0; k < chunk.slots_in_use[lane / Pack<R>::k_width]; ++k) f(k, lane);
  }
}

template <Sweep S, int Dim, class R>
MPM_INLINE void update_stress(SweepContext<Dim, R>& context, SweepChunk<Dim, R>& chunk, ChunkBuffers<Dim, R>& buffers) {
  constexpr int L = k_lanes<R>;
  const SlotLayout<Dim>& at = context.layout;
  if (!Stages<S>::gathers_gradient && at.tau >= 0) {
    // A law that depends on the rate has left its stress: there is no rate to compute it from.
    for (int k = 0; k < chunk.slot_count; ++k) {
      __builtin_memcpy(buffers.tau[k], chunk.slots[k] + at.tau * L, sizeof buffers.tau[k]);
    }
    return;
  }
  LawChunk<Dim, R> law;
  law.slots = chunk.slots;
  law.counts = chunk.counts;
  law.slots_in_use = chunk.slots_in_use;
  law.layout = &at;
  law.uniform_volume = context.uniform_volume;
  law.dt = context.dt;
  law.L = Stages<S>::gathers_gradient ? &buffers.L_grad[0][0][0] : nullptr;
  law.L_hoop = Stages<S>::gathers_gradient ? &buffers.L_hoop[0][0] : nullptr;
  law.tau = &buffers.tau[0][0][0];
  law.J_min = context.J_min;
  law.J_max = context.J_max;
  law.wave_modulus = context.wave_modulus;
  context.law_kernel(context.law, law);
  context.dissipated += law.dissipated;
  chunk.bad_slot = law.bad_slot;
  chunk.bad_lane = law.bad_lane;
}

template <Sweep S, SweepVariant V, int Dim, class R>
__attribute__((flatten)) void sweep_chunk(SweepContext<Dim, R>& context, SweepChunk<Dim, R>& chunk) {
  using P = Pack<R>;
  ChunkBuffers<Dim, R> buffers;
  FetchAhead ahead(chunk.fetch, chunk.fetch_count);
  chunk.mover_count = 0;
  chunk.bad_slot = -1;
  for (int lane = 0; lane < k_lanes<R>; lane += P::k_width) {
    chunk.slots_in_use[lane / P::k_width] = slots_in_use(P::load(chunk.counts + lane), chunk.slot_count);
    if constexpr (Stages<S>::gathers)
      gather<S, V>(context, chunk, buffers, ahead, lane);
    else
      load_masses(context, chunk, buffers, lane);
    if constexpr (S == Sweep::refine) gather_second<V>(context, chunk, buffers, lane);
  }
  const bool is_reference = !Variant<V>::is_plain && context.layout.u >= 0;
  if constexpr (Stages<S>::has_law) {
    if (is_reference && Stages<S>::gathers_gradient)
      for_each_pack<R>(chunk, [&](int k, int lane) { to_velocity_gradient(context, chunk, buffers, k, lane); });
    if (context.has_fbar && Stages<S>::gathers_gradient) average_gradients(context, chunk, buffers);
    update_stress<S>(context, chunk, buffers);
    if (context.has_fbar) average_stresses(context, chunk, buffers);
    if (is_reference) for_each_pack<R>(chunk, [&](int k, int lane) { to_first_piola_kirchhoff(context, chunk, buffers, k, lane); });
  }
  if constexpr (Variant<V>::is_plain && S != Sweep::refine) {
    if constexpr (Stages<S>::maps_momentum) map_all_rows<S, Dim, R>(context, chunk, buffers, ahead);
    if constexpr (Stages<S>::maps_force) map_all_components<Dim, R>(context, chunk, buffers, ahead);
  } else if constexpr (Variant<V>::is_convected) {
    map_domains<S>(context, chunk, buffers, ahead);
  } else {
    map_nodes<S, V>(context, chunk, buffers, ahead);
  }
  ahead.rest();
  if constexpr (Stages<S>::moves && Stages<S>::has_law) {
    for (int m = 0; m < chunk.mover_count; ++m) {
      Mover<R>& mover = chunk.movers[m];
      for (int s = 0; s < k_stress_size<Dim>; ++s) mover.tau[s] = buffers.tau[mover.slot][s][mover.lane];
    }
  }
}

}  // namespace
}  // namespace matpoint
