// A constitutive law over the lanes of a chunk: the law's own text, with packs as its scalar.
#pragma once

#include "kernel/kernel.hpp"
#include "kernel/simd.hpp"
#include "material/law.hpp"

namespace matpoint {
namespace {

/// The law's stress, what it dissipates (a rate [W/m^3]; of a law with a state, of the step [J/m^3]), and its history in and out: on all
/// lanes of a pack at once, or, for a law that branches, one lane after the other.
template <class Law, class R, bool is_plane, class History>
MPM_INLINE Mat3<Pack<R>, is_plane> evaluate(const Law& law, const Kinematics<Mat3<Pack<R>, is_plane>>& k, const History& old_history,
                                            History& new_history, Pack<R>& dissipated) {
  if constexpr (!k_is_scalar_only<Law>) {
    if constexpr (requires { law.dissipation_rate(k); }) dissipated = law.dissipation_rate(k);
    return kirchhoff_stress_of(law, k, old_history, new_history, dissipated);
  } else {
    using M = Mat3<Real, is_plane>;
    using ScalarHistory = typename LawHistory<Law, Real, is_plane>::Type;
    constexpr int history_count = k_history_size<Law, is_plane>;
    Mat3<Pack<R>, is_plane> tau = Mat3<Pack<R>, is_plane>::zero();
    alignas(sizeof(Pack<R>)) R history[history_count + 1][Pack<R>::k_width] = {};
    for (int i = 0; i < Pack<R>::k_width; ++i) {
      Kinematics<M> one{M::identity(), M::zero(), k.dt, M::zero()};
      for (int e = 0; e < M::k_size; ++e) {
        if constexpr (k_has_state<Law>) one.g.entries[e] = static_cast<Real>(k.g.entries[e].v[i]);
        one.F.entries[e] = static_cast<Real>(k.F.entries[e].v[i]);
        one.L.entries[e] = static_cast<Real>(k.L.entries[e].v[i]);
      }
      ScalarHistory before{}, after{};
      for (int h = 0; h < history_count; ++h) {
        reinterpret_cast<Real*>(&before)[h] = static_cast<Real>(reinterpret_cast<const Pack<R>*>(&old_history)[h].v[i]);
      }
      Real lost = 0;
      const M stress = kirchhoff_stress_of(law, one, before, after, lost);
      dissipated.v[i] = static_cast<R>(lost);
      for (int e = 0; e < M::k_size; ++e) tau.entries[e].v[i] = static_cast<R>(stress.entries[e]);
      for (int h = 0; h < history_count; ++h) history[h][i] = static_cast<R>(reinterpret_cast<Real*>(&after)[h]);
      if constexpr (requires { law.dissipation_rate(one); }) dissipated.v[i] = static_cast<R>(law.dissipation_rate(one));
    }
    if constexpr (history_count > 0) __builtin_memcpy(&new_history, history, sizeof new_history);
    return tau;
  }
}

/// Whether det F is positive and finite.
template <class R>
MPM_INLINE Mask<R> is_admissible(Pack<R> J) {
  return (J > Pack<R>(0)) & (J < Pack<R>(sizeof(R) == 8 ? 1e300 : 1e30));
}

/// Looks through the cells from `lane` on for the first slot whose det F is not admissible.
template <int Dim, class R>
void find_bad_slot(LawChunk<Dim, R>& chunk, int lane) {
  using P = Pack<R>;
  constexpr int L = k_lanes<R>;
  const P counts = P::load(chunk.counts + lane);
  for (int k = 0; k < chunk.slots_in_use[lane / P::k_width]; ++k) {
    if (chunk.bad_slot >= 0 && chunk.bad_slot <= k) return;
    auto F = Mat3<P, Dim == 2>::identity();
    for (int r = 0; r < Dim; ++r) {
      for (int c = 0; c < Dim; ++c) F(r, c) = P::load(chunk.slots[k] + (SlotLayout<Dim>::F + r * Dim + c) * L + lane);
    }
    if (Dim == 2 && chunk.layout->hoop >= 0) F(2, 2) = P::load(chunk.slots[k] + chunk.layout->hoop * L + lane);
    const Mask<R> is_bad = (counts > P(static_cast<double>(k))) & ~is_admissible(determinant(F));
    for (int i = P::k_width - 1; i >= 0; --i) {
      if (!is_bad.v[i]) continue;
      chunk.bad_slot = k;
      chunk.bad_lane = lane + i;
    }
  }
}

/// With a stretch around an axis, or without: then the compiler knows that it is 1, which saves a law up to a fifth of its work.
template <class Law, int Dim, class R, bool has_hoop>
__attribute__((flatten)) void update_law_with(const void* law_pointer, LawChunk<Dim, R>& chunk) {
  using P = Pack<R>;
  using M = Mat3<P, Dim == 2>;
  using History = typename LawHistory<Law, P, Dim == 2>::Type;
  constexpr int L = k_lanes<R>;
  const Law law = *static_cast<const Law*>(law_pointer);
  const SlotLayout<Dim> at = *chunk.layout;
  const R* const L_grad = chunk.L;
  const P dt = P(chunk.dt);
  const P zero = P(0);
  Real dissipated = 0;
  for (int lane = 0; lane < L; lane += P::k_width) {
    const P counts = P::load(chunk.counts + lane);
    P J_min = P::load(chunk.J_min + lane);
    P J_max = P::load(chunk.J_max + lane);
    P wave_modulus = k_has_wave_modulus<Law> ? P::load(chunk.wave_modulus + lane) : zero;
    P dissipated_sum = zero;
    Mask<R> are_good = zero <= zero;
    const int slot_count = chunk.slots_in_use[lane / P::k_width];
    P slots_below = zero;
    for (int k = 0; k < slot_count; ++k, slots_below += P(1)) {
      R* const slot = chunk.slots[k] + lane;
      const Mask<R> live = counts > slots_below;
      Kinematics<M> kinematics{M::identity(), M::zero(), chunk.dt, M::zero()};
      // Empty lanes hold the identity or what a particle has left there, and their L is zero.
      for (int r = 0; r < Dim; ++r) {
        for (int c = 0; c < Dim; ++c) {
          kinematics.F(r, c) = P::load(slot + (at.F + r * Dim + c) * L);
          if (L_grad != nullptr) kinematics.L(r, c) = P::load(L_grad + (k * Dim * Dim + r * Dim + c) * L + lane);
          if (k_has_state<Law>) kinematics.g(r, c) = dt * kinematics.L(r, c);
        }
      }
      if constexpr (has_hoop) {
        kinematics.F(2, 2) = P::load(slot + at.hoop * L);
        if (L_grad != nullptr) kinematics.L(2, 2) = P::load(chunk.L_hoop + k * L + lane);
        if (k_has_state<Law>) kinematics.g(2, 2) = dt * kinematics.L(2, 2);
      }
      if (k_is_fluid<Law> && at.u < 0) {
        // A fluid forgets its shape, and F would not: its entries grow without bound in a flow, until det F is what rounding leaves of
        // their products. So F = s I, and s follows J' = J tr L exactly for a constant L: J stays positive, and comes back when the flow
        // does.
        P trace = kinematics.L(0, 0);
        constexpr int directions = has_hoop ? 3 : Dim;
        for (int d = 1; d < directions; ++d) trace += kinematics.L(d, d);
        P s = kinematics.F(0, 0);
        if (L_grad != nullptr) {
          s *= exp(trace * P(chunk.dt / directions));
          s.store(slot + at.F * L);
          if constexpr (has_hoop) s.store(slot + at.hoop * L);
          for (int d = 1; d < Dim; ++d) s.store(slot + (at.F + d * Dim + d) * L);
        }
        kinematics.F = M::identity();
        for (int d = 0; d < directions; ++d) kinematics.F(d, d) = s;
      } else if (L_grad != nullptr) {
        const M& F = kinematics.F;
        M F_new = F;
        for (int r = 0; r < Dim; ++r) {
          for (int c = 0; c < Dim; ++c) {
            P change = kinematics.L(r, 0) * F(0, c);
            for (int e = 1; e < Dim; ++e) change += kinematics.L(r, e) * F(e, c);
            F_new(r, c) = F(r, c) + dt * change;
          }
        }
        if constexpr (has_hoop) {
          F_new(2, 2) = F(2, 2) + dt * (kinematics.L(2, 2) * F(2, 2));
          F_new(2, 2).store(slot + at.hoop * L);
        }
        kinematics.F = F_new;
        for (int r = 0; r < Dim; ++r) {
          for (int c = 0; c < Dim; ++c) kinematics.F(r, c).store(slot + (at.F + r * Dim + c) * L);
        }
      }
      const P J = select(live, determinant(kinematics.F), P(1));
      J_min = min(J_min, J);
      J_max = max(J_max, J);
      are_good = are_good & is_admissible(J);
      History old_history{};
      History new_history{};
      constexpr int history_count = std::is_empty_v<History> ? 0 : static_cast<int>(sizeof(History) / sizeof(P));
      if constexpr (history_count > 0) {
        for (int h = 0; h < history_count; ++h) reinterpret_cast<P*>(&old_history)[h] = P::load(slot + (at.history + h) * L);
      }
      P lost = zero;
      M tau;
      if (k_has_state<Law> && L_grad == nullptr) {
        if constexpr (k_has_state<Law>) {
          tau = law.stress_of(kinematics.F, old_history);
          new_history = old_history;
        }
      } else {
        tau = evaluate(law, kinematics, old_history, new_history, lost);
      }
      if constexpr (k_has_wave_modulus<Law>)
        wave_modulus = max(wave_modulus, select(live, law.wave_modulus(kinematics.F, new_history), zero));
      if (history_count > 0 && !(k_has_state<Law> && L_grad == nullptr)) {
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
      if constexpr (k_has_dissipation<Law> || k_has_state<Law>) {
        const P volume = at.volume >= 0 ? P::load(slot + at.volume * L) : P(static_cast<double>(chunk.uniform_volume));
        dissipated_sum += select(live, lost * volume, zero);
      }
    }
    J_min.store(chunk.J_min + lane);
    J_max.store(chunk.J_max + lane);
    if (k_has_wave_modulus<Law>) wave_modulus.store(chunk.wave_modulus + lane);
    if (!all_of(zero <= zero, are_good)) [[unlikely]]
      find_bad_slot(chunk, lane);
    for (int i = 0; i < P::k_width; ++i) dissipated += static_cast<Real>(dissipated_sum.v[i]);
  }
  chunk.dissipated = k_has_state<Law> ? dissipated : dissipated * chunk.dt;
}

template <class Law, int Dim, class R>
void update_law(const void* law_pointer, LawChunk<Dim, R>& chunk) {
  if constexpr (Dim == 2) {
    if (chunk.layout->hoop >= 0) return update_law_with<Law, Dim, R, true>(law_pointer, chunk);
  }
  update_law_with<Law, Dim, R, false>(law_pointer, chunk);
}

}  // namespace
}  // namespace matpoint
