// The momentum equation on a tile of nodes.
#pragma once

#include "kernel/kernel.hpp"
#include "kernel/simd.hpp"

namespace matpoint {
namespace {

/// Nodes that have mass and are not under the cutoff move.
template <class R>
MPM_INLINE Mask<R> is_active(Pack<R> m, Real cutoff) {
  return (m > Pack<R>(0)) & (m >= Pack<R>(cutoff));
}

/// a = (f - alpha p)/m + g, v = p/m + a dt; books damping and what nodes under the cutoff do not pass on. `booked` is 1, or 0 for the
/// far image of a node on a periodic side.
template <int Dim, class R>
__attribute__((flatten)) void advance_nodes(NodeValues<Dim, R>& nodes, const NodalDynamics<Dim>& dynamics, Real dt, const R* booked,
                                            NodalSums<Dim>& sums) {
  using P = Pack<R>;
  const P zero = P(0);
  for (int lane = 0; lane < k_lanes<R>; lane += P::k_width) {
    const P m = P::load(nodes.mass + lane);
    m.store(nodes.moved_mass + lane);
    const Mask<R> active = is_active(m, dynamics.mass_cutoff);
    const P inverse_m = select(active, P(1) / select(active, m, P(1)), zero);
    for (int d = 0; d < Dim; ++d) {
      const P p = P::load(nodes.momentum[d] + lane);
      const P f = P::load(nodes.force[d] + lane);
      const P g = P(dynamics.gravity[static_cast<std::size_t>(d)]);
      const P a = select(active, (f - P(dynamics.damping) * p) * inverse_m + g, zero);
      const P v = p * inverse_m + a * P(dt);
      a.store(nodes.second[d] + lane);
      v.store(nodes.velocity[d] + lane);
      if (dynamics.damping > 0) {
        const P impulse = select(active, P(dt * dynamics.damping) * p * P::load(booked + lane), zero);
        const P work = impulse * v;
        for (int i = 0; i < P::k_width; ++i) {
          sums.damping_impulse[static_cast<std::size_t>(d)] -= static_cast<Real>(impulse.v[i]);
          sums.damping_dissipation += static_cast<Real>(work.v[i]);
        }
      }
      // A particle exactly above the neighbouring node gives this one a force, but no mass.
      if (any(~active & ((m > zero) | (abs(f) > zero)))) {
        // The FLIP share would have gained a dt, the PIC share loses the node's momentum, too.
        const P lost = select(active, zero, (P(dt) * (f + m * g) + P(1 - dynamics.flip) * p) * P::load(booked + lane));
        for (int i = 0; i < P::k_width; ++i) sums.cutoff_impulse[static_cast<std::size_t>(d)] -= static_cast<Real>(lost.v[i]);
      }
    }
  }
}

/// v = p/m without forces, into `second`: the velocities of USF's first and MUSL's second mapping.
template <int Dim, class R>
__attribute__((flatten)) void map_node_velocity(NodeValues<Dim, R>& nodes, const NodalDynamics<Dim>& dynamics) {
  using P = Pack<R>;
  for (int lane = 0; lane < k_lanes<R>; lane += P::k_width) {
    const P m = P::load(nodes.mass + lane);
    const Mask<R> active = is_active(m, dynamics.mass_cutoff);
    const P inverse_m = select(active, P(1) / select(active, m, P(1)), P(0));
    for (int d = 0; d < Dim; ++d) (P::load(nodes.momentum[d] + lane) * inverse_m).store(nodes.second[d] + lane);
  }
}

template <int Dim, class R>
void clear_nodes(NodeValues<Dim, R>& nodes, bool keeps_mass) {
  using P = Pack<R>;
  const P zero = P(0);
  for (int lane = 0; lane < k_lanes<R>; lane += P::k_width) {
    if (!keeps_mass) zero.store(nodes.mass + lane);
    for (int d = 0; d < Dim; ++d) {
      zero.store(nodes.momentum[d] + lane);
      zero.store(nodes.force[d] + lane);
    }
  }
}

}  // namespace
}  // namespace matpoint
