// Conditions on the nodes: each is a set of (node, direction) with a velocity, constant or tabulated in time.
//
// The explicit solver sets v = value and a = 0 along that direction. The acceleration is what FLIP adds to the particles, so this keeps
// their momentum near a wall; the other form, a = (value - v_old)/dt, gives other numbers than the published ones.
#pragma once

#include <map>
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
  /// constrained directions out of the books again.
  void constrain(Grid<Dim>& grid, const NodalDynamics<Dim>& dynamics, Real t, Real dt, Ledger& ledger) const;

  /// Imposes the velocities of time t [s] only (USF, second mapping of MUSL).
  void constrain_velocity(Grid<Dim>& grid, Real t) const;

  /// Constrained directions, summed over the nodes.
  Index constrained_count() const { return static_cast<Index>(components_.size() + normals_.size()); }
  /// Greatest prescribed speed [m/s].
  Real greatest_speed() const;

 private:
  /// One component of a node.
  struct Component {
    Index node;
    int component;
    int condition;
  };
  /// A direction of a node that is along no axis: n . v = 0, brought about by moving v along `correction`, which leaves the node's
  /// constrained components alone; correction . n = 1.
  struct Normal {
    Index node;
    Vec<Dim> n;
    Vec<Dim> correction;
  };
  /// What is fixed at one node while the conditions are collected.
  struct NodeDirections {
    int condition_of[Dim];  ///< Per component, or -1.
    std::vector<Vec<Dim>> normals;
  };
  using Directions = std::map<Index, NodeDirections>;

  bool add_nodes(const Grid<Dim>& grid, int condition, Directions& directions) const;
  void add_normals(Index node, NodeDirections& directions);
  Vec<Dim> velocity(int condition, Real t) const;
  void constrain_components(Grid<Dim>& grid, const NodalDynamics<Dim>& dynamics, Real t, Real dt, Ledger& ledger) const;
  void constrain_normals(Grid<Dim>& grid, const NodalDynamics<Dim>& dynamics, Real dt, Ledger& ledger) const;

  std::vector<BoundarySpec> specs_;
  std::vector<Component> components_;
  std::vector<Normal> normals_;
};

}  // namespace matpoint
