// Conditions on the nodes: each is a set of (node, direction) with a velocity, constant or tabulated in time.
//
// The explicit solver sets v = value and a = 0 along that direction. The acceleration is what FLIP adds to the particles, so this keeps
// their momentum near a wall; the other form, a = (value - v_old)/dt, gives other numbers than the published ones.
#pragma once

#include <optional>
#include <vector>

#include "grid/grid.hpp"

namespace matpoint {

/// The velocity that a condition prescribes at time t [m/s]; 0 unless kind = "velocity".
Vec3 velocity_at(const BoundarySpec& spec, Real t);

template <int Dim, class R>
class BoundaryConditions {
 public:
  /// Throws InputError for a region that contains no node of the grid.
  BoundaryConditions(const std::vector<BoundarySpec>& specs, const Grid<Dim, R>& grid);

  /// What is fixed at a node, for its tile. Where two conditions fix the same component, the later one holds.
  void append(const Grid<Dim, R>& grid, const Place<Dim>& node, int lane, std::vector<FixedComponent>& components,
              std::vector<FixedNormal<Dim>>& normals) const;

  /// The velocity of each condition at time t [s].
  std::vector<Vec<Dim>> velocities(Real t) const;

  /// Imposes the velocities after the momentum equation, books impulse and work, and takes the damping of the fixed directions out of
  /// the books again.
  void constrain(Tile<Dim, R>& tile, const NodalDynamics<Dim>& dynamics, const std::vector<Vec<Dim>>& values, Real dt,
                 Ledger& ledger) const;

  /// Imposes the velocities on `second` only (USF, second mapping of MUSL).
  void constrain_second(Tile<Dim, R>& tile, const std::vector<Vec<Dim>>& values) const;

  /// Greatest prescribed speed [m/s]: of all times of tables, and of functions at the time t [s].
  Real greatest_speed(Real t) const;

 private:
  std::optional<Vec3> place_in(std::size_t condition, const Grid<Dim, R>& grid, const Place<Dim>& node) const;
  bool has_node(std::size_t condition, const Grid<Dim, R>& grid) const;
  void constrain_normals(Tile<Dim, R>& tile, const NodalDynamics<Dim>& dynamics, Real dt, Ledger& ledger) const;

  std::vector<BoundarySpec> specs_;
};

}  // namespace matpoint
