#include "explicit/fluid_correction.hpp"

#include <algorithm>
#include <cmath>

#include "core/parallel.hpp"

namespace matpoint {
namespace {

// Fluids are corrected when the fastest particle has gone so far, in cells; this sets the cost, not the strength.
constexpr Real k_way = 0.5;
// Of the overfill's slope, per cell of way. Measured on water that sloshes for 20 s, at five resolutions and steps: with 0.1 its center is
// 3 to 5 % too low, with 0.25 to 0.35 within 2.5 % of the right place. (Up to 1 at once is stable for quadratic B-splines.)
constexpr Real k_shift = 0.3;
// Of the share of J that goes to the mean around it. With none the mean pressure of such water is wrong by up to 9 %, with this by 3 to 5
// %.
constexpr Real k_relaxation = 0.2;
// Nodes nearer to a tool, in cells, move nothing: a particle that were shifted into it would be thrown back.
constexpr Real k_beside = 1;
// The way is that of particles somewhat faster than the root mean square.
constexpr Real k_fast = 1.5;

}  // namespace

template <int Dim, class R>
FluidCorrection<Dim, R>::FluidCorrection(bool has_filter, Grid<Dim, R>& grid, const BoundaryConditions<Dim, R>& conditions,
                                         const std::vector<std::unique_ptr<Body<Dim>>>& bodies)
    : has_filter_(has_filter), grid_(grid), conditions_(conditions), cell_size_(grid.cell_size(0)) {
  for (const auto& body : bodies) {
    if (body->is_fluid()) fluids_.push_back(body.get());
    if (body->fills_space()) fillers_.push_back(body.get());
  }
  for (int d = 0; d < Dim; ++d) {
    cell_size_ = std::min(cell_size_, grid.cell_size(d));
    if (fluids_.empty()) continue;
    lengths_[d] = fluids_.front()->node_lengths(d);
    for (int node = 0; node < grid.span(); ++node) {
      const int image = grid.image_of(node, d);
      if (image < 0) continue;
      Real& near = lengths_[d][static_cast<std::size_t>(node)];
      Real& far = lengths_[d][static_cast<std::size_t>(image)];
      near = far = near + far;
    }
  }
}

template <int Dim, class R>
bool FluidCorrection<Dim, R>::is_due(Real dt) {
  Real speed = 0;
  for (const Body<Dim>* fluid : fluids_) speed = std::max(speed, fluid->greatest_speed());
  way_ += speed * dt;
  elapsed_ += dt;
  return way_ > k_way * cell_size_;
}

template <int Dim, class R>
template <class F>
void FluidCorrection<Dim, R>::for_each_tile(F&& f) {
  parallel_for(grid_.band_count(), grid_.tile_count() * k_lanes<R>, [&](Index b) {
    for (Tile<Dim, R>* tile : grid_.tiles(static_cast<std::size_t>(b))) f(*tile);
  });
}

/// From sums to velocities, and from volumes to the overfill.
template <int Dim, class R>
void FluidCorrection<Dim, R>::measure_nodes() {
  for_each_tile([&](Tile<Dim, R>& tile) {
    NodeValues<Dim, R>& nodes = tile.values;
    for (int lane = 0; lane < k_lanes<R>; ++lane) {
      for (int d = 0; d < Dim; ++d) {
        nodes.velocity[d][lane] = nodes.mass[lane] > 0 ? nodes.momentum[d][lane] / nodes.mass[lane] : R(0);
        nodes.momentum[d][lane] = 0;
        nodes.second[d][lane] = 0;
      }
      nodes.force[1][lane] = nodes.mass[lane] > 0 ? nodes.force[1][lane] / nodes.mass[lane] : R(1);
      Real volume = 1;
      bool is_in_grid = true;
      for (int d = 0; d < Dim && is_in_grid; ++d) {
        const int node = tile.first[static_cast<std::size_t>(d)] + (d == 0 ? lane : 0);
        is_in_grid = node < grid_.nodes(d);
        if (is_in_grid) volume *= lengths_[d][static_cast<std::size_t>(node)];
      }
      // A node outside the grid has no function inside.
      const Real fill = is_in_grid && volume > 0 ? static_cast<Real>(nodes.force[0][lane]) / volume : 0;
      nodes.moved_mass[lane] = static_cast<R>(std::max(Real{0}, fill - 1));
    }
    // Beside an obstacle a part of the space is not there, so nothing is moved.
    const auto mark = [&](int lane) { nodes.moved_mass[lane] = -1; };
    for (int lane = 0; lane < k_lanes<R> && rigid_distance_; ++lane) {
      Place<Dim> node = tile.first;
      node[0] += lane;
      Vec3 x{};
      const Vec<Dim> place = grid_.node_position(node);
      std::copy(place.begin(), place.end(), x.begin());
      if (nodes.mass[lane] > 0 && rigid_distance_(x) < k_beside * cell_size_) mark(lane);
    }
    for (const FixedComponent& one : tile.components) {
      if (conditions_.is_of_region(one.condition)) mark(one.lane);
    }
    for (const FixedNormal<Dim>& one : tile.normals) mark(one.lane);
    for (const SurfaceContact<Dim>& one : tile.contacts) {
      if (conditions_.is_of_region(one.condition)) mark(one.lane);
    }
  });
}

template <int Dim, class R>
void FluidCorrection<Dim, R>::apply(const Vec3& gravity, Ledger& ledger) {
  Real mass = 0, kinetic = 0, stored = 0, viscosity = 0;
  Vec3 momentum{};
  for (const Body<Dim>* fluid : fluids_) {
    const BodyTotals totals = fluid->totals(gravity);
    mass += totals.mass;
    kinetic += totals.kinetic_energy;
    stored += totals.strain_energy;
    viscosity += totals.mass * fluid->kinematic_viscosity();
    for (std::size_t d = 0; d < 3; ++d) momentum[d] += totals.momentum[d];
  }
  viscosity /= mass;
  const Real relative = std::max(Real{0}, kinetic - dot(momentum, momentum) / (2 * mass));
  const Real speed = k_fast * std::sqrt(2 * relative / mass);
  const Real way = speed * elapsed_ / cell_size_;
  // Where a cell is viscous, what the grid does not see dies by itself; the filter would add to the viscosity near walls.
  const Real reynolds = speed * cell_size_;
  const Real inviscid = reynolds > 0 ? reynolds / (reynolds + viscosity) : 0;
  way_ = elapsed_ = 0;
  Correction<Dim> correction;
  correction.share = has_filter_ ? -std::expm1(-way * inviscid) : 0;
  for (int d = 0; d < Dim; ++d) correction.shift[static_cast<std::size_t>(d)] = k_shift * way * grid_.cell_size(d) * grid_.cell_size(d);
  correction.gravity = gravity;
  correction.relaxation = -std::expm1(-k_relaxation * way);
  grid_.clear();
  for (Body<Dim>* body : fillers_) body->correct(CorrectionPass::spread, correction);
  grid_.fold_periodic(Grid<Dim, R>::Fold::all);
  measure_nodes();
  for (Body<Dim>* fluid : fluids_) fluid->correct(CorrectionPass::residual, correction);
  grid_.fold_periodic(Grid<Dim, R>::Fold::momentum);
  for_each_tile([](Tile<Dim, R>& tile) {
    NodeValues<Dim, R>& nodes = tile.values;
    for (int lane = 0; lane < k_lanes<R>; ++lane) {
      for (int d = 0; d < Dim && nodes.mass[lane] > 0; ++d) nodes.second[d][lane] = nodes.momentum[d][lane] / nodes.mass[lane];
    }
  });
  Real lost = kinetic + stored;
  for (Body<Dim>* fluid : fluids_) {
    ledger.shift_work += fluid->correct(CorrectionPass::apply, correction);
    const BodyTotals totals = fluid->totals(gravity);
    lost -= totals.kinetic_energy + totals.strain_energy;
  }
  ledger.filter_dissipation += lost;
}

template class FluidCorrection<2, double>;
template class FluidCorrection<3, double>;
template class FluidCorrection<2, float>;
template class FluidCorrection<3, float>;

}  // namespace matpoint
