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
  R mass[k_chunk_slots][L];  ///< [kg] of the particles that are in their cell; 0 for those that left it, and for empty lanes.
};

/// Fetches what comes soon into the cache, two lines with every slot of every loop: a core can wait for some twenty lines at once, and
/// drops what a burst asks for beyond that.
class FetchAhead {
 public:
  FetchAhead(const FetchRun* runs, int count) : run_(runs), runs_end_(runs + count) {}

  MPM_INLINE void next() {
    if (line_ >= end_) [[unlikely]] {
      if (run_ == runs_end_) return;
      line_ = run_->begin;
      end_ = run_->end;
      ++run_;
    }
    __builtin_prefetch(line_, 1);
    __builtin_prefetch(line_ + 64, 1);
    line_ += 128;
  }
  void rest() {
    while (line_ < end_ || run_ != runs_end_) next();
  }

 private:
  const FetchRun* run_;
  const FetchRun* runs_end_;
  const char* line_ = nullptr;
  const char* end_ = nullptr;
};

template <int Dim, class R>
MPM_INLINE Pack<R> mass_of(const SweepContext<Dim, R>& context, const R* slot) {
  if (context.layout.volume < 0) return Pack<R>(static_cast<double>(context.uniform_volume * context.density));
  return Pack<R>::load(slot + context.layout.volume * k_lanes<R>) * Pack<R>(static_cast<double>(context.density));
}

/// Velocity, velocity gradient and position of the particles from the grid (docs/theory.md, step 4), and their masses. Empty lanes are
/// kept at rest inside the cell: whatever stands there must stay finite, for it is summed with a mass of zero.
template <Sweep S, int Dim, class R>
MPM_INLINE void gather(SweepContext<Dim, R>& context, SweepChunk<Dim, R>& chunk, ChunkBuffers<Dim, R>& buffers, FetchAhead& ahead,
                       int lane) {
  using P = Pack<R>;
  using Stage = Stages<S>;
  constexpr int L = k_lanes<R>;
  const SlotLayout<Dim>& at = context.layout;
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
  const int slot_count = chunk.slots_in_use[lane / P::k_width];
  P slots_below = zero;
  for (int k = 0; k < slot_count; ++k, slots_below += one) {
    R* const slot = chunk.slots[k] + lane;
    ahead.next();
    const Mask<R> live = counts > slots_below;
    P x[Dim];
    for (int d = 0; d < Dim; ++d) x[d] = P::load(slot + (at.x + d) * L);
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
        const P moved = select(live, x[d] + dt_over_h[d] * grid_velocity, P(0.5));
        moved.store(slot + (at.x + d) * L);
        is_inside = is_inside & (moved >= zero) & (moved < one);
      }
    }
    select(is_inside, mass_of(context, slot), zero).store(buffers.mass[k] + lane);
    if constexpr (Stage::moves) {
      if (!all_of(live, is_inside)) [[unlikely]] {
        const Mask<R> has_left = live & ~is_inside;
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

/// The masses alone, for the sweeps that gather nothing.
template <int Dim, class R>
MPM_INLINE void load_masses(const SweepContext<Dim, R>& context, const SweepChunk<Dim, R>& chunk, ChunkBuffers<Dim, R>& buffers, int lane) {
  using P = Pack<R>;
  const P counts = P::load(chunk.counts + lane);
  for (int k = 0; k < chunk.slots_in_use[lane / P::k_width]; ++k) {
    const Mask<R> live = counts > P(static_cast<double>(k));
    select(live, mass_of(context, chunk.slots[k] + lane), P(0)).store(buffers.mass[k] + lane);
  }
}

/// Sums for the nodes at the left and at the right end of each lane's cell, for all lanes of a block.
template <class R>
struct NodeSums {
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
  NodeSums<R> mass[rows];
  NodeSums<R> momentum[rows][Dim];
  for (int part = 0; part < NodeSums<R>::k_parts; ++part) {
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
  constexpr int edges = k_rows<Dim>;  // along each axis
  constexpr int components = k_components_at_once<Dim>;
  const SlotLayout<Dim>& at = context.layout;
  const P one = P(1);
  NodeSums<R> force[k_rows<Dim>][components];
  for (int part = 0; part < NodeSums<R>::k_parts; ++part) {
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
      for (int row = 0; row < k_rows<Dim>; ++row) {
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
  for (int row = 0; row < k_rows<Dim>; ++row) {
    NodeValues<Dim, R>&here = *chunk.nodes[row][0], &next = *chunk.nodes[row][1];
    for (int c = 0; c < components; ++c) force[row][c].add_to(here.force[first_component + c], next.force[first_component + c]);
  }
}

template <Sweep S, int Dim, class R, int first_row = 0>
MPM_INLINE void map_all_rows(const SweepContext<Dim, R>& context, SweepChunk<Dim, R>& chunk, const ChunkBuffers<Dim, R>& buffers,
                             FetchAhead& ahead) {
  if constexpr (first_row < k_rows<Dim>) {
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

template <Sweep S, int Dim, class R>
MPM_INLINE void update_stress(SweepContext<Dim, R>& context, SweepChunk<Dim, R>& chunk, ChunkBuffers<Dim, R>& buffers) {
  constexpr int L = k_lanes<R>;
  const SlotLayout<Dim>& at = context.layout;
  if (S == Sweep::start && at.tau >= 0) {
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
  law.L = S == Sweep::start ? nullptr : &buffers.L_grad[0][0][0];
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
  FetchAhead ahead(chunk.fetch, chunk.fetch_count);
  chunk.mover_count = 0;
  chunk.bad_slot = -1;
  for (int lane = 0; lane < k_lanes<R>; lane += P::k_width) {
    chunk.slots_in_use[lane / P::k_width] = slots_in_use(P::load(chunk.counts + lane), chunk.slot_count);
    if constexpr (Stages<S>::gathers)
      gather<S>(context, chunk, buffers, ahead, lane);
    else
      load_masses(context, chunk, buffers, lane);
  }
  if constexpr (Stages<S>::has_law) update_stress<S>(context, chunk, buffers);
  if constexpr (Stages<S>::maps_momentum) map_all_rows<S, Dim, R>(context, chunk, buffers, ahead);
  if constexpr (Stages<S>::maps_force) map_all_components<Dim, R>(context, chunk, buffers, ahead);
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
