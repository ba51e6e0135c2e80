// Keeps fluids evenly filled and free of motion that the grid does not see.
//
// The integrals of MPM know where a fluid's particles are only as sums over the nodes, and its J knows only what the grid's velocity has
// done to them. So particles may come to lie closer than their volumes allow, in places that the grid does not resolve, and a fluid that
// has sloshed for long fills less space than it should (Baumgarten & Kamrin 2023). And FLIP gives the grid's changes of velocity to the
// particles, never the velocity itself: what the nodes average out stays on the particles for good.
//
// Both are mended now and then, whenever the fluid has moved by a part of a cell, and not in every step: then a stiffer fluid, which
// takes more steps for the same flow, is not damped more.
//
// - Positions move down the slope of the overfill e_i = max(0, sum_p N_i V_p / V_i - 1), by -beta a h^2 sum_i e_i grad N_i (the
//   delta-correction of Baumgarten & Kamrin 2023, with their rate by displacement). J goes with the slope of its mean at the nodes, so that
//   the pressure stays in its place, and loses the share 1 - exp(-a / 5) of what it has beyond that mean: particles that have met come from
//   different pasts, and their pressures would scatter (as by the density diffusion of SPH, Antuono et al. 2010).
// - Velocities lose the share 1 - exp(-a) of (1 - P)^2 v, where P v maps to the nodes and back: what two terms of FMPM's series do not
//   give back (Nairn & Hammerquist 2021, whose periodic FMPM this is, spread out evenly). Momentum is kept.
//
// a is the way in cells that the fluid has gone since the last time, by its velocity beside that of its centre of mass.
#pragma once

#include <functional>

#include <memory>

#include "body/body.hpp"
#include "grid/boundary_condition.hpp"

namespace matpoint {

template <int Dim, class R>
class FluidCorrection {
 public:
  /// The bodies share the grid. Everything must outlive this.
  FluidCorrection(bool has_filter, Grid<Dim, R>& grid, const BoundaryConditions<Dim, R>& conditions,
                  const std::vector<std::unique_ptr<Body<Dim>>>& bodies);

  /// Of what is rigid: the signed distance of a place from its surface, for tools, which take up space, too.
  void set_rigid(std::function<Real(const Vec3& x)> distance) { rigid_distance_ = std::move(distance); }
  /// Whether the fluids have moved far enough by a step of dt [s].
  bool is_due(Real dt);
  /// Corrects. The nodes hold nothing of use afterwards.
  void apply(const Vec3& gravity, Ledger& ledger);
  void declare_state(State& state) {
    state.add("way", way_);
    state.add("elapsed", elapsed_);
  }

 private:
  template <class F>
  void for_each_tile(F&& f);
  void measure_nodes();

  bool has_filter_;
  Grid<Dim, R>& grid_;
  const BoundaryConditions<Dim, R>& conditions_;
  std::vector<Body<Dim>*> fluids_;
  std::vector<Body<Dim>*> fillers_;                    ///< All whose particles take up space.
  std::function<Real(const Vec3& x)> rigid_distance_;  ///< Empty without tools.
  std::vector<Real> lengths_[Dim];                     ///< Integrals of the functions along each direction [m].
  Real cell_size_ = 0;                                 ///< The smallest [m].
  Real way_ = 0;                                       ///< An upper bound of what the fluids have moved since the last correction [m].
  Real elapsed_ = 0;                                   ///< [s]
};

}  // namespace matpoint
