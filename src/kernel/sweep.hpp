// The sweep over a block's particles: grid to particles, stress, particles to grid, in short loops over the slots of a block. The loops
// hand over velocity gradients and stresses through small buffers that stay in the first-level cache.
#pragma once

#include "kernel/kernel.hpp"
#include "kernel/simd.hpp"

namespace matpoint {
namespace {

/// Which stages a sweep has.
template <Sweep S>
struct Stages {
  static constexpr bool gathers_velocity = S == Sweep::usl || S == Sweep::musl_velocity || S == Sweep::usf_velocity;
  static constexpr bool gathers_gradient = S == Sweep::usl || S == Sweep::musl_gradient || S == Sweep::usf_stress;
  static constexpr bool moves = S == Sweep::usl || S == Sweep::musl_gradient || S == Sweep::usf_velocity;
  static constexpr bool gathers = gathers_velocity || gathers_gradient || moves;
  /// The gradient is taken of `second` where that holds a velocity.
  static constexpr bool is_gradient_of_second = S == Sweep::musl_gradient || S == Sweep::usf_stress;
  static constexpr bool has_law = S == Sweep::start || gathers_gradient;
  static constexpr bool maps_mass = S != Sweep::musl_velocity && S != Sweep::usf_stress;
  static constexpr bool maps_momentum = S != Sweep::usf_stress;
  static constexpr bool maps_force = has_law;
};

/// One quantity at the nodes around each lane's cell, as the coefficients of its multilinear polynomial in xi.
template <int Dim, class R>
struct Multilinear {
  using P = Pack<R>;
  P c[1 << Dim];  // bit 0: x, bit 1: y, bit 2: z

  /// `field(row, tile)`: the quantity in the block's tile (0) and in the next one (1); lanes from `lane` on.
  template <class Field>
  MPM_INLINE void load(Field&& field, int lane) {
    P at[1 << Dim];
    for (int row = 0; row < k_rows<Dim>; ++row) {
      const R* const here = field(row, 0);
      at[2 * row] = P::load(here + lane);
      // The last node of the last lanes is the next tile's first.
      at[2 * row + 1] =
          lane + P::k_width < k_lanes<R> ? P::load_unaligned(here + lane + 1) : shift_down(at[2 * row], P::load(field(row, 1)));
    }
    if constexpr (Dim == 2) {
      c[0] = at[0];
      c[1] = at[1] - at[0];
      c[2] = at[2] - at[0];
      c[3] = (at[3] - at[2]) - (at[1] - at[0]);
    } else {
      const P x00 = at[1] - at[0], x10 = at[3] - at[2], x01 = at[5] - at[4], x11 = at[7] - at[6];
      c[0] = at[0];
      c[1] = x00;
      c[2] = at[2] - at[0];
      c[3] = x10 - x00;
      c[4] = at[4] - at[0];
      c[5] = x01 - x00;
      c[6] = (at[6] - at[4]) - (at[2] - at[0]);
      c[7] = (x11 - x01) - (x10 - x00);
    }
  }
  MPM_INLINE P value(const P* x) const {
    if constexpr (Dim == 2) {
      return c[0] + x[0] * c[1] + x[1] * (c[2] + x[0] * c[3]);
    } else {
      const P low = c[0] + x[0] * c[1] + x[1] * (c[2] + x[0] * c[3]);
      const P high = c[4] + x[0] * c[5] + x[1] * (c[6] + x[0] * c[7]);
      return low + x[2] * high;
    }
  }
  /// Derivatives in xi, and the value.
  MPM_INLINE P gradient(const P* x, P* d) const {
    if constexpr (Dim == 2) {
      d[0] = c[1] + x[1] * c[3];
      d[1] = c[2] + x[0] * c[3];
      return c[0] + x[0] * c[1] + x[1] * d[1];
    } else {
      const P cx = c[1] + x[2] * c[5];
      const P cy = c[2] + x[2] * c[6];
      const P cxy = c[3] + x[2] * c[7];
      d[0] = cx + x[1] * cxy;
      d[1] = cy + x[0] * cxy;
      d[2] = c[4] + x[0] * c[5] + x[1] * (c[6] + x[0] * c[7]);
      return c[0] + x[2] * c[4] + x[0] * cx + x[1] * d[1];
    }
  }
};

template <int Dim, class R>
struct alignas(64) ChunkBuffers {
  static constexpr int L = k_lanes<R>;
  R L_grad[k_chunk_slots][Dim * Dim][L];
  R tau[k_chunk_slots][k_stress_size<Dim>][L];
  R mass[k_chunk_slots][L];
};

/// Fetches what comes soon into the cache, a line with every slot of every loop: a core can wait for some twenty lines at once, and drops
/// what a burst asks for beyond that.
class FetchAhead {
 public:
  FetchAhead(const FetchRun* runs, int count) : run_(runs), runs_end_(runs + count) {}

  MPM_INLINE void next() {
    if (line_ == end_) [[unlikely]] {
      if (run_ == runs_end_) return;
      line_ = run_->begin;
      end_ = run_->end;
      ++run_;
    }
    __builtin_prefetch(line_, 1);
    line_ += 64;
  }
  void rest() {
    while (line_ != end_ || run_ != runs_end_) next();
  }

 private:
  const FetchRun* run_;
  const FetchRun* runs_end_;
  const char* line_ = nullptr;
  const char* end_ = nullptr;
};

/// Velocity, velocity gradient and position of the particles from the grid (docs/theory.md, step 4).
template <Sweep S, int Dim, class R>
MPM_INLINE void gather(SweepContext<Dim, R>& context, SweepChunk<Dim, R>& chunk, ChunkBuffers<Dim, R>& buffers, FetchAhead& ahead,
                       int lane) {
  using P = Pack<R>;
  using Stage = Stages<S>;
  constexpr int L = k_lanes<R>;
  const SlotLayout at = context.layout;
  const P dt = P(context.dt);
  const P flip = P(static_cast<double>(context.flip));
  const P pic = P(1 - static_cast<double>(context.flip));
  const P zero = P(0);
  const P one = P(1);
  P inverse_h[Dim], dt_over_h[Dim];
  for (int d = 0; d < Dim; ++d) {
    inverse_h[d] = P(static_cast<double>(context.inverse_cell_size[d]));
    dt_over_h[d] = P(context.dt * static_cast<double>(context.inverse_cell_size[d]));
  }
  const P counts = P::load(chunk.counts + lane);
  Multilinear<Dim, R> velocity[Dim], second[Dim];
  for (int d = 0; d < Dim; ++d) {
    velocity[d].load([&](int row, int next) { return chunk.nodes[row][next]->velocity[d]; }, lane);
    second[d].load([&](int row, int next) { return chunk.nodes[row][next]->second[d]; }, lane);
  }
  P speed_max[Dim];
  for (int d = 0; d < Dim; ++d) speed_max[d] = P::load(context.speed_max[d] + lane);
  const int slot_count = slots_in_use(counts, chunk.slot_count);
  for (int k = 0; k < slot_count; ++k) {
    R* const slot = chunk.slots[k] + lane;
    ahead.next();
    const Mask<R> live = counts > P(static_cast<double>(k));
    P x[Dim];
    for (int d = 0; d < Dim; ++d) x[d] = P::load(slot + (at.x + d) * L);
    P moved[Dim];
    Mask<R> is_inside = live;
    for (int d = 0; d < Dim; ++d) {
      P grid_velocity;
      if constexpr (Stage::gathers_gradient) {
        P gradient[Dim];
        const P value = (Stage::is_gradient_of_second ? second : velocity)[d].gradient(x, gradient);
        for (int c = 0; c < Dim; ++c) select(live, gradient[c] * inverse_h[c], zero).store(buffers.L_grad[k][d * Dim + c] + lane);
        grid_velocity = Stage::is_gradient_of_second ? velocity[d].value(x) : value;
      } else {
        grid_velocity = velocity[d].value(x);
      }
      if constexpr (Stage::gathers_velocity) {
        const P v = P::load(slot + (at.v + d) * L);
        const P new_v = select(live, flip * (v + dt * second[d].value(x)) + pic * grid_velocity, zero);
        new_v.store(slot + (at.v + d) * L);
        speed_max[d] = max(speed_max[d], abs(new_v));
      }
      if constexpr (Stage::moves) {
        moved[d] = select(live, x[d] + dt_over_h[d] * grid_velocity, P(0.5));
        moved[d].store(slot + (at.x + d) * L);
        is_inside = is_inside & (moved[d] >= zero) & (moved[d] < one);
      }
    }
    if constexpr (Stage::moves) {
      const Mask<R> has_left = live & ~is_inside;
      if (any(has_left)) [[unlikely]] {
        for (int i = 0; i < P::k_width; ++i) {
          if (has_left.v[i]) {
            Mover<R>& mover = chunk.movers[chunk.mover_count++];
            mover.slot = k;
            mover.lane = lane + i;
          }
        }
      }
    }
  }
  for (int d = 0; d < Dim; ++d) speed_max[d].store(context.speed_max[d] + lane);
}

/// The mass of each particle that stays in its cell, 0 for empty lanes; stresses become V0 tau / h of the direction they act along.
/// The entry (c, d) of the scaled stress is stored at scaled_index(c, d): c is the force's component, d the derivative's direction.
template <int Dim>
constexpr int scaled_index(int c, int d) {
  return c * Dim + d;
}

template <int Dim, class R>
struct alignas(64) MapBuffers {
  static constexpr int L = k_lanes<R>;
  R stress[k_chunk_slots][Dim * Dim][L];
};

template <Sweep S, int Dim, class R>
MPM_INLINE void prepare_map(const SweepContext<Dim, R>& context, const SweepChunk<Dim, R>& chunk, ChunkBuffers<Dim, R>& buffers,
                            MapBuffers<Dim, R>& map, FetchAhead& ahead, int lane) {
  using P = Pack<R>;
  constexpr int L = k_lanes<R>;
  const SlotLayout at = context.layout;
  const P zero = P(0);
  const P one = P(1);
  const P counts = P::load(chunk.counts + lane);
  const int slot_count = slots_in_use(counts, chunk.slot_count);
  for (int k = 0; k < slot_count; ++k) {
    const R* const slot = chunk.slots[k] + lane;
    ahead.next();
    Mask<R> stays = counts > P(static_cast<double>(k));
    if constexpr (Stages<S>::moves) {
      for (int d = 0; d < Dim; ++d) {
        const P x = P::load(slot + (at.x + d) * L);
        stays = stays & (x >= zero) & (x < one);
      }
    }
    const P volume = select(stays, at.volume >= 0 ? P::load(slot + at.volume * L) : P(static_cast<double>(context.uniform_volume)), zero);
    (volume * P(static_cast<double>(context.density))).store(buffers.mass[k] + lane);
    if constexpr (Stages<S>::maps_force) {
      for (int d = 0; d < Dim; ++d) {
        const P scale = volume * P(static_cast<double>(context.inverse_cell_size[d]));
        for (int c = 0; c < Dim; ++c) {
          // A particle that left, or whose state is bad, must not spoil its neighbours: its stress counts as zero, whatever it is.
          const P tau = select(stays, P::load(buffers.tau[k][stress_index(c, d)] + lane), zero);
          (scale * tau).store(map.stress[k][scaled_index<Dim>(c, d)] + lane);
        }
      }
    }
  }
}

/// Sums for the nodes at the left and at the right end of each lane's cell, for all lanes of a block.
template <class R>
struct NodeSums {
  static constexpr int k_parts = k_lanes<R> / Pack<R>::k_width;
  Pack<R> left[k_parts];
  Pack<R> right[k_parts];

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

/// m_i += N_i m_p, p_i += N_i m_p v_p for one row of nodes.
template <Sweep S, int Dim, class R, int row>
MPM_INLINE void map_mass_and_momentum(const SweepContext<Dim, R>& context, SweepChunk<Dim, R>& chunk, const ChunkBuffers<Dim, R>& buffers,
                                      FetchAhead& ahead) {
  using P = Pack<R>;
  constexpr int L = k_lanes<R>;
  const SlotLayout at = context.layout;
  const P one = P(1);
  NodeSums<R> mass;
  NodeSums<R> momentum[Dim];
  for (int part = 0; part < NodeSums<R>::k_parts; ++part) {
    const int lane = part * P::k_width;
    const int slot_count = slots_in_use(P::load(chunk.counts + lane), chunk.slot_count);
    P m_left = P(0), m_right = P(0);
    P p_left[Dim], p_right[Dim];
    for (int d = 0; d < Dim; ++d) p_left[d] = p_right[d] = P(0);
    for (int k = 0; k < slot_count; ++k) {
      const R* const slot = chunk.slots[k] + lane;
      if (part == 0) ahead.next();
      const P x = P::load(slot + at.x * L);
      const P y = P::load(slot + (at.x + 1) * L);
      P w = row % 2 == 0 ? one - y : y;
      if constexpr (Dim == 3) {
        const P z = P::load(slot + (at.x + 2) * L);
        w *= row / 2 == 0 ? one - z : z;
      }
      const P wm = w * P::load(buffers.mass[k] + lane);
      const P m1 = wm * x;
      const P m0 = wm * (one - x);
      if constexpr (Stages<S>::maps_mass) {
        m_left += m0;
        m_right += m1;
      }
      for (int d = 0; d < Dim; ++d) {
        const P v = P::load(slot + (at.v + d) * L);
        p_left[d] += m0 * v;
        p_right[d] += m1 * v;
      }
    }
    mass.left[part] = m_left;
    mass.right[part] = m_right;
    for (int d = 0; d < Dim; ++d) {
      momentum[d].left[part] = p_left[d];
      momentum[d].right[part] = p_right[d];
    }
  }
  NodeValues<Dim, R>&here = *chunk.nodes[row][0], &next = *chunk.nodes[row][1];
  if constexpr (Stages<S>::maps_mass) mass.add_to(here.mass, next.mass);
  for (int d = 0; d < Dim; ++d) momentum[d].add_to(here.momentum[d], next.momentum[d]);
}

/// f_i -= V0 tau grad N_i for one row of nodes.
template <int Dim, class R, int row>
MPM_INLINE void map_force(const SweepContext<Dim, R>& context, SweepChunk<Dim, R>& chunk, const MapBuffers<Dim, R>& map,
                          FetchAhead& ahead) {
  using P = Pack<R>;
  constexpr int L = k_lanes<R>;
  constexpr double sign_y = row % 2 == 0 ? -1 : 1;
  constexpr double sign_z = row / 2 == 0 ? -1 : 1;
  const SlotLayout at = context.layout;
  const P one = P(1);
  NodeSums<R> force[Dim];
  for (int part = 0; part < NodeSums<R>::k_parts; ++part) {
    const int lane = part * P::k_width;
    const int slot_count = slots_in_use(P::load(chunk.counts + lane), chunk.slot_count);
    P left[Dim], right[Dim];
    for (int d = 0; d < Dim; ++d) left[d] = right[d] = P(0);
    for (int k = 0; k < slot_count; ++k) {
      const R* const slot = chunk.slots[k] + lane;
      if (part == 0) ahead.next();
      const P x = P::load(slot + at.x * L);
      const P y = P::load(slot + (at.x + 1) * L);
      const P wy = row % 2 == 0 ? one - y : y;
      P wz = one;
      if constexpr (Dim == 3) {
        const P z = P::load(slot + (at.x + 2) * L);
        wz = row / 2 == 0 ? one - z : z;
      }
      const P wyz = Dim == 3 ? wy * wz : wy;
      for (int c = 0; c < Dim; ++c) {
        const P along_x = wyz * P::load(map.stress[k][scaled_index<Dim>(c, 0)] + lane);
        P across = P(sign_y) * P::load(map.stress[k][scaled_index<Dim>(c, 1)] + lane);
        if constexpr (Dim == 3) across = across * wz + P(sign_z) * (wy * P::load(map.stress[k][scaled_index<Dim>(c, 2)] + lane));
        left[c] += along_x - (one - x) * across;
        right[c] -= along_x + x * across;
      }
    }
    for (int d = 0; d < Dim; ++d) {
      force[d].left[part] = left[d];
      force[d].right[part] = right[d];
    }
  }
  NodeValues<Dim, R>&here = *chunk.nodes[row][0], &next = *chunk.nodes[row][1];
  for (int d = 0; d < Dim; ++d) force[d].add_to(here.force[d], next.force[d]);
}

template <Sweep S, int Dim, class R, int row = 0>
MPM_INLINE void map_rows(const SweepContext<Dim, R>& context, SweepChunk<Dim, R>& chunk, const ChunkBuffers<Dim, R>& buffers,
                         const MapBuffers<Dim, R>& map, FetchAhead& ahead) {
  if constexpr (row < k_rows<Dim>) {
    if constexpr (Stages<S>::maps_momentum) map_mass_and_momentum<S, Dim, R, row>(context, chunk, buffers, ahead);
    if constexpr (Stages<S>::maps_force) map_force<Dim, R, row>(context, chunk, map, ahead);
    map_rows<S, Dim, R, row + 1>(context, chunk, buffers, map, ahead);
  }
}

template <Sweep S, int Dim, class R>
MPM_INLINE void update_stress(SweepContext<Dim, R>& context, SweepChunk<Dim, R>& chunk, ChunkBuffers<Dim, R>& buffers) {
  constexpr int L = k_lanes<R>;
  const SlotLayout at = context.layout;
  if (S == Sweep::start && at.tau >= 0) {
    // A law that depends on the rate has left its stress: there is no rate to compute it from.
    for (int k = 0; k < chunk.slot_count; ++k) {
      __builtin_memcpy(buffers.tau[k], chunk.slots[k] + at.tau * L, sizeof buffers.tau[k]);
    }
    return;
  }
  LawChunk<R> law;
  law.slot_count = chunk.slot_count;
  law.slots = chunk.slots;
  law.counts = chunk.counts;
  law.layout = at;
  law.uniform_volume = context.uniform_volume;
  law.dt = context.dt;
  law.updates_F = S != Sweep::start;
  law.L = &buffers.L_grad[0][0][0];
  law.tau = &buffers.tau[0][0][0];
  law.J_min = context.J_min;
  law.J_max = context.J_max;
  context.law_kernel(context.law, law);
  context.dissipated += law.dissipated;
  chunk.bad_slot = law.bad_slot;
  chunk.bad_lane = law.bad_lane;
}

template <Sweep S, int Dim, class R>
__attribute__((flatten)) void sweep_chunk(SweepContext<Dim, R>& context, SweepChunk<Dim, R>& chunk) {
  using P = Pack<R>;
  ChunkBuffers<Dim, R> buffers;
  MapBuffers<Dim, R> map;
  FetchAhead ahead(chunk.fetch, chunk.fetch_count);
  chunk.mover_count = 0;
  chunk.bad_slot = -1;
  if constexpr (Stages<S>::gathers) {
    for (int lane = 0; lane < k_lanes<R>; lane += P::k_width) gather<S>(context, chunk, buffers, ahead, lane);
  }
  if constexpr (Stages<S>::has_law) update_stress<S>(context, chunk, buffers);
  for (int lane = 0; lane < k_lanes<R>; lane += P::k_width) prepare_map<S>(context, chunk, buffers, map, ahead, lane);
  map_rows<S, Dim, R>(context, chunk, buffers, map, ahead);
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
