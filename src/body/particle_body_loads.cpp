// Loads on some particles of a body: what they ask for, and what they do to the nodes.
#include <type_traits>

#include "body/particle_body.hpp"
#include "kernel/shape.hpp"

namespace matpoint {

template <int Dim, class R>
void ParticleBody<Dim, R>::take_points(const std::vector<std::int32_t>& places, std::vector<LoadedPoint<Dim>>& points) const {
  for (LoadedPoint<Dim>& point : points) point.is_there = false;
  const std::vector<Band>& bands = blocks_->bands();
  const SlotLayout<Dim>& at = blocks_->layout();
  parallel_for(static_cast<Index>(bands.size()), blocks_->count(), [&](Index b) {
    blocks_->for_each(bands[static_cast<std::size_t>(b)], [&](const R* fields, const Vec3& cell_place) {
      const std::int32_t place = places[static_cast<std::size_t>(id_from_bits(fields[at.id * k_lanes<R>]))];
      if (place < 0) return;
      LoadedPoint<Dim>& point = points[static_cast<std::size_t>(place)];
      point.is_there = true;
      const Vec3 x = position_of(fields, k_lanes<R>, cell_place);
      std::copy_n(x.begin(), Dim, point.x.begin());
      for (std::size_t k = 0; k < Dim * Dim; ++k) point.F[k] = static_cast<Real>(fields[(at.F + static_cast<int>(k)) * k_lanes<R>]);
      if (at.hoop >= 0) point.F33 = static_cast<Real>(fields[at.hoop * k_lanes<R>]);
    });
  });
}

namespace {

/// Whether functions are polynomials in a cell, which say themselves what they are beside a particle; means over its domain do so to first
/// order.
template <class Shape, class R>
constexpr bool k_is_polynomial = !std::is_same_v<Shape, ShapeGimp<R>> && !std::is_same_v<Shape, ShapeConvected<R>>;

}  // namespace

template <int Dim, class R>
template <class Shape>
void ParticleBody<Dim, R>::add_loads_with(const std::vector<std::int32_t>& places, const std::vector<std::size_t>& first,
                                          const std::vector<PointForce<Dim>>& forces) {
  constexpr int n = Shape::k_nodes;
  constexpr int L = k_lanes<R>;
  const SlotLayout<Dim>& at = blocks_->layout();
  const auto add = [&](const Block<Dim, R>& block, int k, int lane) {
    const R* const fields = block.slot(k) + lane;
    const std::int32_t place = places[static_cast<std::size_t>(id_from_bits(fields[at.id * L]))];
    if (place < 0) return;
    const auto point = static_cast<std::size_t>(place);
    for (std::size_t f = first[point]; f < first[point + 1]; ++f) {
      R arm[Dim];  // in cell sides; where functions are those of the reference, as it is there
      for (std::size_t d = 0; d < Dim; ++d) {
        Real x = at.u >= 0 ? forces[f].arm[d] : 0;
        for (std::size_t e = 0; e < Dim && at.u < 0; ++e)
          x += static_cast<Real>(fields[(at.F + static_cast<int>(d * Dim + e)) * L]) * forces[f].arm[e];
        arm[d] = static_cast<R>(x / grid_.cell_size(static_cast<int>(d)));
      }
      const auto weights = weights_of<Shape>(block, lane, fields, L, k_is_polynomial<Shape, R> ? arm : nullptr);
      for (int row = 0; row < grid_.row_count(); ++row) {
        R N[n], dN[Dim][n];
        weights.of_row(row, N, dN);
        for (int i = 0; i < n; ++i) {
          for (int d = 0; d < Dim && !k_is_polynomial<Shape, R>; ++d) N[i] += arm[d] * dN[d][i];
          NodeValues<Dim, R>& nodes = block.tiles[row][(lane + i) / L]->values;
          for (int d = 0; d < Dim; ++d)
            nodes.force[d][(lane + i) % L] += N[i] * static_cast<R>(forces[f].force[static_cast<std::size_t>(d)]);
        }
      }
    }
  };
  for_each_band([&](std::size_t b) {
    for (const auto& row : blocks_->bands()[b].rows) {
      for (const Block<Dim, R>* block : row.blocks) {
        if (block == nullptr) continue;
        for (int k = 0; k < block->slot_count; ++k) {
          for (int lane = 0; lane < L; ++lane) {
            if (k < block->count(lane)) add(*block, k, lane);
          }
        }
      }
    }
  });
}

template <int Dim, class R>
void ParticleBody<Dim, R>::add_loads(const std::vector<std::int32_t>& places, const std::vector<std::size_t>& first,
                                     const std::vector<PointForce<Dim>>& forces) {
  switch (scheme_.shape) {
    case ShapeKind::linear: return add_loads_with<ShapeLinear<R>>(places, first, forces);
    case ShapeKind::bspline2: return add_loads_with<ShapeBSpline2<R>>(places, first, forces);
    case ShapeKind::bspline3: return add_loads_with<ShapeBSpline3<R>>(places, first, forces);
    case ShapeKind::gimp: return add_loads_with<ShapeGimp<R>>(places, first, forces);
    case ShapeKind::cpdi: return add_loads_with<ShapeConvected<R>>(places, first, forces);
  }
}

template void ParticleBody<2, double>::take_points(const std::vector<std::int32_t>&, std::vector<LoadedPoint<2>>&) const;
template void ParticleBody<3, double>::take_points(const std::vector<std::int32_t>&, std::vector<LoadedPoint<3>>&) const;
template void ParticleBody<2, float>::take_points(const std::vector<std::int32_t>&, std::vector<LoadedPoint<2>>&) const;
template void ParticleBody<3, float>::take_points(const std::vector<std::int32_t>&, std::vector<LoadedPoint<3>>&) const;
template void ParticleBody<2, double>::add_loads(const std::vector<std::int32_t>&, const std::vector<std::size_t>&,
                                                 const std::vector<PointForce<2>>&);
template void ParticleBody<3, double>::add_loads(const std::vector<std::int32_t>&, const std::vector<std::size_t>&,
                                                 const std::vector<PointForce<3>>&);
template void ParticleBody<2, float>::add_loads(const std::vector<std::int32_t>&, const std::vector<std::size_t>&,
                                                const std::vector<PointForce<2>>&);
template void ParticleBody<3, float>::add_loads(const std::vector<std::int32_t>&, const std::vector<std::size_t>&,
                                                const std::vector<PointForce<3>>&);

}  // namespace matpoint
