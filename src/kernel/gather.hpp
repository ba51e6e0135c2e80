// Grid to particles: velocity, velocity gradient, affine velocity, position.
#pragma once

#include "kernel/chunk.hpp"

namespace matpoint {
namespace {

/// The lanes from `lane + n` on of a row of nodes, which go on in the next tile.
template <int n, class R>
MPM_INLINE Pack<R> load_shifted(const R* here, const R* next, int lane) {
  using P = Pack<R>;
  constexpr int w = P::k_width;
  constexpr int whole = n / w * w;
  const auto pack = [&](int first) { return P::load(first < k_lanes<R> ? here + first : next + (first - k_lanes<R>)); };
  if constexpr (n == whole) {
    return pack(lane + n);
  } else {
    return lane + whole + w < k_lanes<R> ? P::load_unaligned(here + lane + n)
                                         : shift_down<n - whole>(pack(lane + whole), pack(lane + whole + w));
  }
}

/// One quantity at the nodes around each lane's cell, as the coefficients of its multilinear polynomial in xi: `Polynomial` below for
/// linear shapes, written out.
template <int Dim, class R>
struct Multilinear {
  using P = Pack<R>;
  P c[1 << Dim];  // bit 0: x, bit 1: y, bit 2: z

  struct Point {
    P x[Dim];
    MPM_INLINE Point(const ShapeLinear<P>*, const P* place) { std::copy_n(place, Dim, x); }
    /// For the slopes of APIC, or of TPIC, which are those of the gradient.
    MPM_INLINE Point affine(const ShapeLinear<P>*, bool) const { return *this; }
  };

  /// `field(row, tile)`: the quantity in the block's tile (0) and in the next one (1); lanes from `lane` on.
  template <class Field, class Shape>
  MPM_INLINE void load(Field&& field, const Shape*, int lane) {
    P at[1 << Dim];
    for (int row = 0; row < rows_of<Dim>(1); ++row) {
      at[2 * row] = load_shifted<0>(field(row, 0), field(row, 1), lane);
      at[2 * row + 1] = load_shifted<1>(field(row, 0), field(row, 1), lane);
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
  MPM_INLINE P value(const Point& at) const {
    const P* const x = at.x;
    if constexpr (Dim == 2) {
      return c[0] + x[0] * c[1] + x[1] * (c[2] + x[0] * c[3]);
    } else {
      const P low = c[0] + x[0] * c[1] + x[1] * (c[2] + x[0] * c[3]);
      const P high = c[4] + x[0] * c[5] + x[1] * (c[6] + x[0] * c[7]);
      return low + x[2] * high;
    }
  }
  /// Derivatives in xi, and the value.
  MPM_INLINE P gradient(const Point& at, P* d) const {
    const P* const x = at.x;
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

/// One quantity at the nodes around each lane's cell, as the coefficients of its polynomial of degree k_nodes - 1 in each direction.
template <int Dim, class R, class Shape>
struct Polynomial {
  using P = Pack<R>;
  static constexpr int n = Shape::k_nodes;
  static constexpr int k_layers = Dim == 2 ? 1 : n;
  P c[k_layers][n][n];  // z, y, x

  struct Point {
    P x[Dim];
    P square_slope[Dim];  ///< What the term q^2 rises by.
    MPM_INLINE Point(const Shape*, const P* place) {
      for (int d = 0; d < Dim; ++d) {
        x[d] = place[d];
        square_slope[d] = place[d] + place[d];
      }
    }
    MPM_INLINE Point affine(const Shape* shapes, bool is_full) const {
      Point point = *this;
      for (int d = 0; d < Dim && !is_full; ++d) point.square_slope[d] = shapes[d].affine_slope(x[d]);
      return point;
    }
  };

  template <class Field>
  MPM_INLINE void load(Field&& field, const Shape* shapes, int lane) {
    for (int k = 0; k < k_layers; ++k) {
      for (int j = 0; j < n; ++j) {
        const R* const here = field(k * n + j, 0);
        const R* const next = field(k * n + j, 1);
        P at[n];
        at[0] = load_shifted<0>(here, next, lane);
        at[1] = load_shifted<1>(here, next, lane);
        if constexpr (n > 2) at[2] = load_shifted<2>(here, next, lane);
        shapes[0].to_polynomial(at, c[k][j]);
      }
      for (int i = 0; i < n; ++i) {
        P at[n], out[n];
        for (int j = 0; j < n; ++j) at[j] = c[k][j][i];
        shapes[1].to_polynomial(at, out);
        for (int j = 0; j < n; ++j) c[k][j][i] = out[j];
      }
    }
    if constexpr (Dim == 3) {
      for (int j = 0; j < n; ++j) {
        for (int i = 0; i < n; ++i) {
          P at[n], out[n];
          for (int k = 0; k < n; ++k) at[k] = c[k][j][i];
          shapes[2].to_polynomial(at, out);
          for (int k = 0; k < n; ++k) c[k][j][i] = out[k];
        }
      }
    }
  }
  MPM_INLINE static P along(const P* a, P q) {
    if constexpr (n == 2)
      return a[0] + q * a[1];
    else
      return a[0] + q * (a[1] + q * a[2]);
  }
  MPM_INLINE static P slope(const P* a, P square_slope) {
    if constexpr (n == 2)
      return a[1];
    else
      return a[1] + square_slope * a[2];
  }
  MPM_INLINE P value(const Point& at) const {
    const P* const x = at.x;
    P in_z[n];
    for (int k = 0; k < k_layers; ++k) {
      P in_y[n];
      for (int j = 0; j < n; ++j) in_y[j] = along(c[k][j], x[0]);
      in_z[k] = along(in_y, x[1]);
    }
    if constexpr (Dim == 3)
      return along(in_z, x[2]);
    else
      return in_z[0];
  }
  /// Slopes in xi, and the value.
  MPM_INLINE P gradient(const Point& at, P* d) const {
    const P* const x = at.x;
    const P* const square_slope = at.square_slope;
    P value_z[n], x_z[n], y_z[n];
    for (int k = 0; k < k_layers; ++k) {
      P value_y[n], x_y[n];
      for (int j = 0; j < n; ++j) {
        value_y[j] = along(c[k][j], x[0]);
        x_y[j] = slope(c[k][j], square_slope[0]);
      }
      value_z[k] = along(value_y, x[1]);
      x_z[k] = along(x_y, x[1]);
      y_z[k] = slope(value_y, square_slope[1]);
    }
    if constexpr (Dim == 3) {
      d[0] = along(x_z, x[2]);
      d[1] = along(y_z, x[2]);
      d[2] = slope(value_z, square_slope[2]);
      return along(value_z, x[2]);
    } else {
      d[0] = x_z[0];
      d[1] = y_z[0];
      return value_z[0];
    }
  }
};

/// One quantity at the nodes around each lane's cell, for any shape: sums over the nodes, a direction at a time.
template <int Dim, class R, class Shape>
struct NodalValues {
  using P = Pack<R>;
  static constexpr int n = Shape::k_nodes;
  static constexpr int k_layers = Dim == 2 ? 1 : n;
  P at[k_layers][n][n];  // z, y, x

  struct Point {
    P x[Dim];
    P N[Dim][n];
    P slope[Dim][n];
    MPM_INLINE Point(const Shape* shapes, const P* place) {
      for (int d = 0; d < Dim; ++d) {
        x[d] = place[d];
        shapes[d].weights(x[d], N[d], slope[d]);
      }
    }
    MPM_INLINE Point affine(const Shape* shapes, bool is_full) const {
      Point point = *this;
      for (int d = 0; d < Dim && !is_full; ++d) affine_weights(shapes[d], x[d], N[d], point.slope[d]);
      return point;
    }
  };

  template <class Field>
  MPM_INLINE void load(Field&& field, const Shape*, int lane) {
    const R* rows[k_layers * n][2];
    for (int row = 0; row < k_layers * n; ++row) {
      for (int next = 0; next < 2; ++next) rows[row][next] = field(row, next);
    }
    load_rows(rows, lane);
  }
  // Not inlined: 64 numbers are in memory anyway, and there would be a copy for each sweep.
  __attribute__((noinline)) void load_rows(const R* const (*rows)[2], int lane) {
    static_assert(n == 4);
    for (int row = 0; row < k_layers * n; ++row) {
      P* const to = at[row / n][row % n];
      to[0] = load_shifted<0>(rows[row][0], rows[row][1], lane);
      to[1] = load_shifted<1>(rows[row][0], rows[row][1], lane);
      to[2] = load_shifted<2>(rows[row][0], rows[row][1], lane);
      to[3] = load_shifted<3>(rows[row][0], rows[row][1], lane);
    }
  }
  MPM_INLINE static P sum(const P* w, const P* a) {
    P total = w[0] * a[0];
    for (int i = 1; i < n; ++i) total += w[i] * a[i];
    return total;
  }
  __attribute__((noinline)) P value(const Point& p) const {
    P in_z[k_layers];
    for (int k = 0; k < k_layers; ++k) {
      P in_y[n];
      for (int j = 0; j < n; ++j) in_y[j] = sum(p.N[0], at[k][j]);
      in_z[k] = sum(p.N[1], in_y);
    }
    if constexpr (Dim == 3)
      return sum(p.N[2], in_z);
    else
      return in_z[0];
  }
  __attribute__((noinline)) P gradient(const Point& p, P* d) const {
    P value_z[k_layers], x_z[k_layers], y_z[k_layers];
    for (int k = 0; k < k_layers; ++k) {
      P value_y[n], x_y[n];
      for (int j = 0; j < n; ++j) {
        value_y[j] = sum(p.N[0], at[k][j]);
        x_y[j] = sum(p.slope[0], at[k][j]);
      }
      value_z[k] = sum(p.N[1], value_y);
      x_z[k] = sum(p.N[1], x_y);
      y_z[k] = sum(p.slope[1], value_y);
    }
    if constexpr (Dim == 3) {
      d[0] = sum(p.N[2], x_z);
      d[1] = sum(p.N[2], y_z);
      d[2] = sum(p.slope[2], value_z);
      return sum(p.N[2], value_z);
    } else {
      d[0] = x_z[0];
      d[1] = y_z[0];
      return value_z[0];
    }
  }
};

/// One quantity at the nodes around each lane's cell, for convected domains: from the values at a domain's corners.
template <int Dim, class R>
struct CornerValues : NodalValues<Dim, R, ShapeConvected<Pack<R>>> {
  using P = Pack<R>;
  using Hats = ShapeConvected<P>;
  static constexpr int n = Hats::k_nodes;
  static constexpr int k_layers = Dim == 2 ? 1 : n;

  struct Point {
    ConvectedDomain<Dim, P> domain;
    /// For the slopes of TPIC, which are those of the gradient.
    MPM_INLINE const Point& affine(const Hats*, bool) const { return *this; }
  };

  __attribute__((noinline)) P at_corner(const P* x) const {
    P total = P(0);
    for (int k = 0; k < k_layers; ++k) {
      P in_y = P(0);
      for (int j = 0; j < n; ++j) {
        P in_x = Hats::hat(x[0], 0) * this->at[k][j][0];
        for (int i = 1; i < n; ++i) in_x += Hats::hat(x[0], i) * this->at[k][j][i];
        in_y += Hats::hat(x[1], j) * in_x;
      }
      if constexpr (Dim == 3)
        total += Hats::hat(x[2], k) * in_y;
      else
        total = in_y;
    }
    return total;
  }
  MPM_INLINE P value(const Point& p) const {
    P sum = P(0);
    for (const auto& corner : p.domain.corner) sum += at_corner(corner);
    return sum * P(1.0 / ConvectedDomain<Dim, P>::k_corners);
  }
  /// Derivatives in xi, and the value.
  MPM_INLINE P gradient(const Point& p, P* d) const {
    using Domain = ConvectedDomain<Dim, P>;
    P sum = P(0);
    P along_edge[Dim];
    for (int k = 0; k < Dim; ++k) along_edge[k] = P(0);
    for (int c = 0; c < Domain::k_corners; ++c) {
      const P v = at_corner(p.domain.corner[c]);
      sum += v;
      for (int k = 0; k < Dim; ++k) along_edge[k] = Domain::is_upper(c, k) ? along_edge[k] + v : along_edge[k] - v;
    }
    for (int e = 0; e < Dim; ++e) {
      d[e] = along_edge[0] * p.domain.inverse[0][e];
      for (int k = 1; k < Dim; ++k) d[e] += along_edge[k] * p.domain.inverse[k][e];
      d[e] *= P(1.0 / Domain::k_corners);
    }
    return sum * P(1.0 / Domain::k_corners);
  }
};

template <SweepVariant V, int Dim, class R, class Shape = typename Variant<V>::template Shape<Pack<R>>>
using WideInterpolantOf = std::conditional_t<Variant<V>::is_convected, CornerValues<Dim, R>, NodalValues<Dim, R, Shape>>;

template <SweepVariant V, int Dim, class R, class Shape = typename Variant<V>::template Shape<Pack<R>>>
using InterpolantOf = std::conditional_t<Variant<V>::is_linear, Multilinear<Dim, R>,
                                         std::conditional_t<Variant<V>::is_wide, WideInterpolantOf<V, Dim, R>, Polynomial<Dim, R, Shape>>>;

/// Where the particles of a slot are for an interpolant; x: their places in the cells.
template <SweepVariant V, int Dim, class R, class Shape>
MPM_INLINE typename InterpolantOf<V, Dim, R>::Point point_of(const SweepContext<Dim, R>& context, const Shape* shapes, const R* slot,
                                                             const Pack<R>* x) {
  if constexpr (Variant<V>::is_convected)
    return {domain_of(context, shapes, slot, x)};
  else
    return {shapes, x};
}

/// Velocity, velocity gradient and position of the particles from the grid (docs/theory.md, step 4), and their masses. Empty lanes are
/// kept at rest inside the cell: whatever stands there must stay finite, for it is summed with a mass of zero.
template <Sweep S, SweepVariant V, int Dim, class R>
MPM_INLINE void gather(SweepContext<Dim, R>& context, SweepChunk<Dim, R>& chunk, ChunkBuffers<Dim, R>& buffers, FetchAhead& ahead,
                       int lane) {
  using P = Pack<R>;
  using Stage = Stages<S>;
  using Shape = typename Variant<V>::template Shape<P>;
  using Interpolant = InterpolantOf<V, Dim, R>;
  constexpr int L = k_lanes<R>;
  const SlotLayout<Dim>& at = context.layout;
  const bool keeps_place = !Variant<V>::is_plain && at.u >= 0;
  const P dt = P(context.dt);
  const P flip = P(static_cast<double>(context.flip));
  const P pic = P(1 - static_cast<double>(context.flip));
  const P zero = P(0);
  const P one = P(1);
  P inverse_h[Dim], dt_over_h[Dim];
  Shape shapes[Dim];
  for (int d = 0; d < Dim; ++d) {
    inverse_h[d] = P(static_cast<double>(context.inverse_cell_size[d]));
    dt_over_h[d] = P(context.dt * static_cast<double>(context.inverse_cell_size[d]));
    if constexpr (!Variant<V>::is_linear) shapes[d] = shape_of<V>(context, chunk, d, lane);
  }
  const P counts = P::load(chunk.counts + lane);
  Interpolant velocity[Dim], second[Dim];
  for (int d = 0; d < Dim; ++d) {
    velocity[d].load([&](int row, int next) { return chunk.nodes[row][next]->velocity[d]; }, shapes, lane);
    second[d].load([&](int row, int next) { return chunk.nodes[row][next]->second[d]; }, shapes, lane);
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
    const typename Interpolant::Point point = point_of<V>(context, shapes, slot, x);
    Mask<R> is_inside = live;
    for (int d = 0; d < Dim; ++d) {
      P grid_velocity;
      if constexpr (Stage::gathers_gradient) {
        P gradient[Dim];
        const P value = (Stage::is_gradient_of_second ? second : velocity)[d].gradient(point, gradient);
        for (int c = 0; c < Dim; ++c) select(live, gradient[c] * inverse_h[c], zero).store(buffers.L_grad[k][d * Dim + c] + lane);
        if constexpr (Dim == 2 && !Variant<V>::is_plain) {
          if (d == 0 && at.hoop >= 0)
            select(live, value * inverse_radius(context, chunk, lane, x[0]), zero).store(buffers.L_hoop[k] + lane);
        }
        grid_velocity = Stage::is_gradient_of_second ? velocity[d].value(point) : value;
      } else {
        grid_velocity = velocity[d].value(point);
      }
      if constexpr (Stage::gathers_velocity) {
        const P v = P::load(slot + (at.v + d) * L);
        const P new_v = select(live, flip * (v + dt * second[d].value(point)) + pic * grid_velocity, zero);
        new_v.store(slot + (at.v + d) * L);
        speed_max[d] = max(speed_max[d], abs(new_v));
        if constexpr (!Variant<V>::is_plain) {
          if (at.C >= 0) {
            P gradient[Dim];
            velocity[d].gradient(point.affine(shapes, context.is_affine_full), gradient);
            for (int c = 0; c < Dim; ++c) select(live, gradient[c] * inverse_h[c], zero).store(slot + (at.C + d * Dim + c) * L);
          }
        }
      }
      if constexpr (Stage::moves) {
        if (keeps_place) {
          const P u = P::load(slot + (at.u + d) * L);
          select(live, u + dt * grid_velocity, zero).store(slot + (at.u + d) * L);
        } else {
          const P moved = select(live, x[d] + dt_over_h[d] * grid_velocity, P(0.5));
          const Mask<R> stays = (moved >= zero) & (moved < one);
          const P off_line = min(max(moved, P(k_off_line<R>)), P(1 - k_off_line<R>));
          select(stays, off_line, moved).store(slot + (at.x + d) * L);
          is_inside = is_inside & stays;
        }
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

/// `second` at the particles, for the refining sweep.
template <SweepVariant V, int Dim, class R>
MPM_INLINE void gather_second(const SweepContext<Dim, R>& context, const SweepChunk<Dim, R>& chunk, ChunkBuffers<Dim, R>& buffers,
                              int lane) {
  using P = Pack<R>;
  using Interpolant = InterpolantOf<V, Dim, R>;
  typename Variant<V>::template Shape<P> shapes[Dim];
  for (int d = 0; d < Dim && !Variant<V>::is_linear; ++d) shapes[d] = shape_of<V>(context, chunk, d, lane);
  const P counts = P::load(chunk.counts + lane);
  for (int d = 0; d < Dim; ++d) {
    Interpolant second;
    second.load([&](int row, int next) { return chunk.nodes[row][next]->second[d]; }, shapes, lane);
    for (int k = 0; k < chunk.slots_in_use[lane / P::k_width]; ++k) {
      P x[Dim];
      for (int e = 0; e < Dim; ++e) x[e] = P::load(chunk.slots[k] + lane + (context.layout.x + e) * k_lanes<R>);
      const Mask<R> live = counts > P(static_cast<double>(k));
      select(live, second.value(point_of<V>(context, shapes, chunk.slots[k] + lane, x)), P(0)).store(buffers.L_grad[k][d] + lane);
    }
  }
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

}  // namespace
}  // namespace matpoint
