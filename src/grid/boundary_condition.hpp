// Conditions on the nodes: each is a set of (node, direction) with a velocity, constant or tabulated in time.
//
// The explicit solver sets v = value and a = 0 on that component. The acceleration is what FLIP adds to the particles, so this keeps their
// momentum near a wall; the other form, a = (value - v_old)/dt, gives other numbers than the published ones.
#pragma once

#include <vector>

#include "grid/grid.hpp"

namespace matpoint {

template <int Dim>
class BoundaryConditions {
 public:
  /// Finds the nodes of all conditions. Where two of them fix the same component of a node, the later one holds.
  /// Throws InputError for a region that contains no node.
  BoundaryConditions(const std::vector<BoundarySpec>& specs, const Grid<Dim>& grid);

  /// Imposes the velocities of time t [s] after the momentum equation, books impulse and work, and takes the damping of the
  /// constrained components out of the books again.
  void constrain(Grid<Dim>& grid, const NodalDynamics<Dim>& dynamics, Real t, Real dt, Ledger& ledger) const;

  /// Imposes the velocities of time t [s] only (USF, second mapping of MUSL).
  void constrain_velocity(Grid<Dim>& grid, Real t) const;

  Index constrained_count() const { return static_cast<Index>(constraints_.size()); }
  /// Greatest prescribed speed [m/s].
  Real greatest_speed() const;

 private:
  struct Constraint {
    Index node;
    int component;
    int condition;
  };
  Vec<Dim> velocity(int condition, Real t) const;

  std::vector<BoundarySpec> specs_;
  std::vector<Constraint> constraints_;
};

}  // namespace matpoint
