// A constitutive law over the lanes of a chunk: the law's own text, with packs as its scalar.
#pragma once

#include "kernel/kernel.hpp"
#include "kernel/simd.hpp"
#include "material/laws.hpp"

namespace matpoint {
namespace {

template <class Law, int Dim, class R>
__attribute__((flatten)) void update_law(const void* law_pointer, LawChunk<R>& chunk) {
  using P = Pack<R>;
  using M = Mat3<P, Dim == 2>;
  using History = typename LawHistory<Law, P>::Type;
  constexpr int L = k_lanes<R>;
  const Law law = *static_cast<const Law*>(law_pointer);
  const SlotLayout at = chunk.layout;
  const P zero = P(0);
  Real dissipated = 0;
  for (int lane = 0; lane < L; lane += P::k_width) {
    const P counts = P::load(chunk.counts + lane);
    P J_min = P::load(chunk.J_min + lane);
    P J_max = P::load(chunk.J_max + lane);
    P power_sum = zero;
    for (int k = 0; k < chunk.slot_count; ++k) {
      R* const slot = chunk.slots[k] + lane;
      const Mask<R> live = counts > P(static_cast<double>(k));
      Kinematics<M> kinematics{M::identity(), M::zero(), chunk.dt};
      for (int r = 0; r < Dim; ++r) {
        for (int c = 0; c < Dim; ++c) {
          kinematics.F(r, c) = select(live, P::load(slot + (at.F + r * Dim + c) * L), P(r == c ? 1 : 0));
          if (chunk.updates_F) kinematics.L(r, c) = P::load(chunk.L + (k * Dim * Dim + r * Dim + c) * L + lane);
        }
      }
      if (chunk.updates_F) {
        // L is zero in empty lanes, so their F stays the identity.
        const M& F = kinematics.F;
        M F_new = F;
        for (int r = 0; r < Dim; ++r) {
          for (int c = 0; c < Dim; ++c) {
            P change = kinematics.L(r, 0) * F(0, c);
            for (int e = 1; e < Dim; ++e) change += kinematics.L(r, e) * F(e, c);
            F_new(r, c) = F(r, c) + P(chunk.dt) * change;
          }
        }
        kinematics.F = F_new;
        for (int r = 0; r < Dim; ++r) {
          for (int c = 0; c < Dim; ++c) kinematics.F(r, c).store(slot + (at.F + r * Dim + c) * L);
        }
      }
      const P J = determinant(kinematics.F);
      J_min = min(J_min, J);
      J_max = max(J_max, J);
      const Mask<R> is_bad = ~((J > zero) & (J < P(sizeof(R) == 8 ? 1e300 : 1e30)));
      if (any(is_bad)) [[unlikely]] {
        for (int i = 0; i < P::k_width; ++i) {
          const bool is_first = chunk.bad_slot < 0 || k < chunk.bad_slot;
          if (is_bad.v[i] && is_first) {
            chunk.bad_slot = k;
            chunk.bad_lane = lane + i;
          }
        }
      }
      History old_history{};
      History new_history{};
      constexpr int history_count = std::is_empty_v<History> ? 0 : static_cast<int>(sizeof(History) / sizeof(P));
      if constexpr (history_count > 0) {
        for (int h = 0; h < history_count; ++h) reinterpret_cast<P*>(&old_history)[h] = P::load(slot + (at.history + h) * L);
      }
      const M tau = kirchhoff_stress_of(law, kinematics, old_history, new_history);
      if constexpr (history_count > 0) {
        for (int h = 0; h < history_count; ++h) reinterpret_cast<P*>(&new_history)[h].store(slot + (at.history + h) * L);
      }
      R* const out = chunk.tau + k * k_stress_size<Dim> * L + lane;
      for (int d = 0; d < 3; ++d) tau(d, d).store(out + d * L);
      tau(0, 1).store(out + 3 * L);
      if constexpr (Dim == 3) {
        tau(1, 2).store(out + 4 * L);
        tau(0, 2).store(out + 5 * L);
      }
      if (at.tau >= 0) {
        for (int s = 0; s < k_stress_size<Dim>; ++s) P::load(out + s * L).store(slot + (at.tau + s) * L);
      }
      if constexpr (requires { law.dissipation_rate(kinematics); }) {
        const P volume = at.volume >= 0 ? P::load(slot + at.volume * L) : P(static_cast<double>(chunk.uniform_volume));
        power_sum += select(live, law.dissipation_rate(kinematics) * volume, zero);
      }
    }
    J_min.store(chunk.J_min + lane);
    J_max.store(chunk.J_max + lane);
    for (int i = 0; i < P::k_width; ++i) dissipated += static_cast<Real>(power_sum.v[i]);
  }
  chunk.dissipated = dissipated * chunk.dt;
}

template <int Dim, class R, class... Laws>
struct LawKernels {
  static constexpr LawKernel<R> all[] = {&update_law<Laws, Dim, R>...};
};
template <int Dim, class R, class... Laws>
constexpr const LawKernel<R>* law_kernels_of(std::tuple<Laws...>*) {
  return LawKernels<Dim, R, Laws...>::all;
}

}  // namespace
}  // namespace matpoint
