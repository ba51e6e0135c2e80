// What the loops of a sweep share: its stages, and the buffers through which they hand over gradients, stresses and masses.
#pragma once

#include <algorithm>
#include <type_traits>

#include "kernel/domain.hpp"
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
  static constexpr bool has_law = S == Sweep::start || S == Sweep::force || gathers_gradient;
  static constexpr bool maps_momentum = S != Sweep::usf_stress && S != Sweep::force;
  static constexpr bool maps_mass = maps_momentum && S != Sweep::musl_velocity && S != Sweep::refine;
  static constexpr bool maps_force = has_law;
};

/// What a variant of the sweeps has.
template <SweepVariant V>
struct Variant {
  static constexpr bool is_plain = V == SweepVariant::linear_plain;
  static constexpr bool is_bspline2 = V == SweepVariant::bspline2;
  static constexpr bool is_convected = V == SweepVariant::cpdi;
  static constexpr bool is_wide = V == SweepVariant::bspline3 || V == SweepVariant::gimp || is_convected;
  static constexpr bool is_linear = !is_bspline2 && !is_wide;
  template <class T>
  using WideShape =
      std::conditional_t<is_convected, ShapeConvected<T>, std::conditional_t<V == SweepVariant::gimp, ShapeGimp<T>, ShapeBSpline3<T>>>;
  template <class T>
  using Shape = std::conditional_t<is_linear, ShapeLinear<T>, std::conditional_t<is_bspline2, ShapeBSpline2<T>, WideShape<T>>>;
  static constexpr int k_nodes = Shape<double>::k_nodes;
};

/// The shape functions of the cells from `lane` on, in one direction.
template <SweepVariant V, int Dim, class R>
MPM_INLINE typename Variant<V>::template Shape<Pack<R>> shape_of(const SweepContext<Dim, R>& context, const SweepChunk<Dim, R>& chunk,
                                                                 int d, int lane) {
  using P = Pack<R>;
  P before = P(2);
  P after = P(2);
  for (int i = 0; i < P::k_width && !context.is_periodic[d]; ++i) {
    const int cell = chunk.cell[d] + (d == 0 ? lane + i : 0);
    const int last = context.cells[d] - 1;
    if (cell < 2) before.v[i] = static_cast<R>(cell);
    // Lanes beyond the grid hold nothing, but must stay finite.
    if (cell > last - 2) after.v[i] = static_cast<R>(std::max(last - cell, 0));
  }
  return {before, after, P(static_cast<double>(context.reach[d]))};
}

/// 1 / r [1/m] of particles at the places x in the cells from `lane` on, where r is the distance from the axis.
template <int Dim, class R>
MPM_INLINE Pack<R> inverse_radius(const SweepContext<Dim, R>& context, const SweepChunk<Dim, R>& chunk, int lane, Pack<R> x) {
  using P = Pack<R>;
  P cell;
  for (int i = 0; i < P::k_width; ++i) cell.v[i] = static_cast<R>(chunk.cell[0] + lane + i) - context.axis;
  // A particle that has just passed the axis has no mass here, but must stay finite.
  return P(static_cast<double>(context.inverse_cell_size[0])) / max(cell + x, P(static_cast<double>(k_off_line<R>)));
}

/// The convected domains of the particles of a slot, at the places x in their cells; in the reference configuration they keep their shape.
template <int Dim, class R>
MPM_INLINE ConvectedDomain<Dim, Pack<R>> domain_of(const SweepContext<Dim, R>& context, const ShapeConvected<Pack<R>>* shapes,
                                                   const R* slot, const Pack<R>* x) {
  using P = Pack<R>;
  const SlotLayout<Dim>& at = context.layout;
  P edges[Dim][Dim];
  for (int d = 0; d < Dim; ++d) {
    for (int k = 0; k < Dim; ++k) {
      const P F = at.u >= 0 ? P(d == k ? 1 : 0) : P::load(slot + (at.F + d * Dim + k) * k_lanes<R>);
      // From cell sides along k to cell sides along d.
      edges[d][k] = F * P(static_cast<double>(context.reach[k] * context.inverse_cell_size[d] / context.inverse_cell_size[k]));
    }
  }
  return {shapes, x, edges};
}

template <int Dim, class R>
struct alignas(64) ChunkBuffers {
  static constexpr int L = k_lanes<R>;
  R L_hoop[k_chunk_slots][L];             ///< v_r / r, of axisymmetric bodies.
  R L_grad[k_chunk_slots][Dim * Dim][L];  ///< The refining sweep has a velocity [m/s] in the first Dim fields.
  R tau[k_chunk_slots][k_stress_size<Dim>][L];
  R P_stress[k_chunk_slots][Dim * Dim][L];  ///< First Piola-Kirchhoff stress [Pa], of bodies with displacements.
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

}  // namespace
}  // namespace matpoint
