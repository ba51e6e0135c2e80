// Conditions on the nodes: each is a set of (node, direction) with a velocity, constant or tabulated in time.
//
// The explicit solver sets v = value and a = 0 along that direction. The acceleration is what FLIP adds to the particles, so this keeps
// their momentum near a wall; the other form, a = (value - v_old)/dt, gives other numbers than the published ones.
//
// Surfaces that let go (`contact`) act by impulses instead, as bodies do on each other (contact.hpp): what approaches is stopped, and
// slides as Coulomb's law says; v and a change by the same impulse, so momentum balances to round-off.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "case/boundary_spec.hpp"
#include "grid/grid.hpp"

namespace matpoint {

template <int Dim, class R>
class BoundaryConditions {
 public:
  /// Throws InputError for a region that contains no node of the grid.
  BoundaryConditions(const std::vector<BoundarySpec>& specs, const Grid<Dim, R>& grid);

  /// What is fixed at a node, for its tile. Where two conditions fix the same component, the later one holds; surfaces that let go yield
  /// to all that hold for good.
  void append(const Grid<Dim, R>& grid, const Place<Dim>& node, int lane, Tile<Dim, R>& tile) const;

  /// Whether a condition holds nodes in a region, and not those of a side.
  bool is_of_region(int condition) const { return specs_[static_cast<std::size_t>(condition)].region != nullptr; }

  /// Whether a condition makes a side a plane of symmetry.
  bool is_mirror(int condition) const {
    const BoundarySpec& spec = specs_[static_cast<std::size_t>(condition)];
    return !spec.region && spec.kind == BoundaryKind::slip && spec.contact == FaceContact::stick;
  }

  /// The velocity of each condition at time t [s].
  std::vector<PrescribedVelocity> velocities(Real t) const;

  /// Imposes the velocities after the momentum equation, books impulse and work, and takes the damping of the fixed directions out of
  /// the books again. `before`: the velocities a step ago; particles of FLIP take the change along.
  void constrain(const Grid<Dim, R>& grid, Tile<Dim, R>& tile, const NodalDynamics<Dim>& dynamics,
                 const std::vector<PrescribedVelocity>& values, const std::vector<PrescribedVelocity>& before, Real dt,
                 Ledger& ledger) const;

  /// Imposes the velocities on `second` only (USF, second mapping of MUSL).
  void constrain_second(const Grid<Dim, R>& grid, Tile<Dim, R>& tile, const std::vector<PrescribedVelocity>& values) const;

  /// Takes the distance [m] from a side of the grid to the nearest particle around each node into `gaps`, if it is less.
  using GapMeasure = std::function<void(const TileNodes<Dim>& nodes, int axis, bool is_upper, std::vector<Real>& gaps)>;
  /// Measures the gaps between sides that let go and what is on a grid, for the next advance. Threads call `measure` side by side.
  void measure_gaps(const Grid<Dim, R>& grid, const GapMeasure& measure) const;

  /// The condition that holds a component of a node, or a direction with a part along it; -1: none.
  static int condition_of(const Tile<Dim, R>& tile, int lane, int component);

  /// Takes from changes of velocity, one per lane, what the conditions forbid: a surface that lets go holds what it held in the last
  /// advance.
  static void leave_out(const Tile<Dim, R>& tile, Vec<Dim>* changes);

  /// Takes from a node's velocity what would carry it into a surface that lets go, without friction.
  static void keep_out(const Grid<Dim, R>& grid, const Tile<Dim, R>& tile, const std::vector<PrescribedVelocity>& values,
                       std::vector<Vec<Dim>>& velocities);

  /// Sides that hold what is at them across themselves, and do not go away from it at time t [s].
  std::vector<ClosedSide> closed_sides(Real t) const;

  /// Regions that hold what meets them across their surface, with their velocities at time t [s].
  std::vector<Obstacle> obstacles(Real t) const;

  /// Greatest prescribed speed [m/s]: of all times of tables, and of functions at the time t [s].
  Real greatest_speed(Real t) const;

 private:
  std::optional<Vec3> place_in(std::size_t condition, const Grid<Dim, R>& grid, const Place<Dim>& node) const;
  bool has_node(std::size_t condition, const Grid<Dim, R>& grid) const;
  void constrain_normals(Tile<Dim, R>& tile, const NodalDynamics<Dim>& dynamics, Real dt, Ledger& ledger) const;
  void append_contacts(const std::vector<std::pair<std::size_t, Vec3>>& places, int lane, Tile<Dim, R>& tile) const;
  static void touch_surfaces(const Grid<Dim, R>& grid, Tile<Dim, R>& tile, const NodalDynamics<Dim>& dynamics,
                             const std::vector<PrescribedVelocity>& values, Real dt, Ledger& ledger);
  Real greatest_field_speed(const BoundarySpec& spec, const Grid<Dim, R>& grid) const;

  std::vector<BoundarySpec> specs_;
  std::vector<Real> field_speeds_;  ///< The greatest one of each condition's field, and 0 [m/s].
};

}  // namespace matpoint
