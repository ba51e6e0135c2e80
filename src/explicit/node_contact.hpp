// Contact between bodies that have velocity fields of their own.
//
// With one field for all, bodies stick together as soon as they share a node, up to two cells before they touch. Here each body has its
// own grid of the same nodes (Bardenhagen, Guilkey, Roessig, Brackbill, Witzel & Foster 2001). Where two of them have mass at a node, and
// the bodies touch and approach, equal and opposite impulses take the approach away, and friction some of the sliding. So momentum is kept
// exactly, and the nodes' kinetic energy never grows.
//
//     normal    n, one for both bodies: of what they suggest (g_a, -g_b, their sum, what both agree on, c) the direction along which the
//               particles around the node are farthest apart; g_a = sum of V_p grad N_i over the particles of a points out of it. With
//               a fluid the longer of g_a and -g_b
//     touching  n . c < 0.775 h and n . c >= |c| / 2, with c the line from the centroid of a's mass at the node to that of b's
//     impulse   J_n = m_a m_b / (m_a + m_b) (v_a - v_b) . n, if that is positive; |J_t| <= mu J_n, and no more than stops the sliding
//
// Why 0.775 h: two bodies that fill their sides of a plane are 2/3 h apart at a node on the plane, 0.76 h at one that is half a cell away,
// and h at the farthest that both reach (linear shapes). Tried instead: how far the particles nearest to the other body reach along n. The
// time of contact of two disks was as good, but the impact cost 8 % of their energy with 3016 particles each instead of 3 %.
#pragma once

#include "body/body.hpp"
#include "grid/boundary_condition.hpp"
#include "grid/grid.hpp"

namespace matpoint {

template <int Dim, class R>
class Contact {
 public:
  /// One grid per body, in the same order; both must outlive this. friction: Coulomb's coefficient [1].
  Contact(std::vector<Grid<Dim, R>*> grids, std::vector<const Body<Dim>*> bodies, const BoundaryConditions<Dim, R>& conditions,
          Real friction)
      : grids_(std::move(grids)), bodies_(std::move(bodies)), conditions_(conditions), friction_(friction) {}

  /// Changes the nodes' velocities and accelerations; to be called after Grid::start_pass(advance), before any sweep. Books what the
  /// impulses take of the kinetic energy, and what walls give back.
  void apply(Real mass_cutoff, Real dt, Ledger& ledger);
  /// MUSL's second velocities: what has pressed in the last apply() has one velocity across the contact, and along it if it stuck. By what
  /// the nodes did when they moved, as at surfaces: keeping these velocities from approaching instead would turn half of their noise into
  /// strain. To be called after Grid::start_pass(velocity).
  void apply_second();
  void declare_state(State& state);

 private:
  /// A tile that several bodies have, in the order of the bodies.
  struct Shared {
    std::vector<std::size_t> bodies;
    std::vector<Tile<Dim, R>*> tiles;
  };
  /// Two bodies at a node that pressed in the last step.
  struct Pressed {
    Place<Dim> tile{};
    int lane = 0;
    std::size_t a = 0;
    std::size_t b = 0;
    Vec<Dim> n{};
    bool sticks = false;
    void declare_state(State& state) {
      state.add("tile", tile);
      state.add("lane", lane);
      state.add("first", a);
      state.add("second", b);
      state.add("normal", n);
      state.add("sticks", sticks);
    }
  };
  /// Velocities of a tile's nodes.
  using Velocities = std::vector<Vec<Dim>>;

  std::vector<std::vector<Shared>> find_shared() const;
  void work(const Shared& shared, std::size_t band, Real mass_cutoff, Real dt, Ledger& ledger);
  bool collide(const Shared& shared, std::size_t a, std::size_t b, Real mass_cutoff, std::vector<Velocities>& velocities,
               std::vector<Pressed>& pressed) const;
  void mirror(const Tile<Dim, R>& tile, const TileNodes<Dim>& nodes, std::vector<NodeSurface<Dim>>& surfaces) const;
  std::vector<Vec<Dim>> normals(const Body<Dim>& body_a, const Body<Dim>& body_b, const TileNodes<Dim>& at,
                                const std::vector<NodeSurface<Dim>>& a, const std::vector<NodeSurface<Dim>>& b) const;
  bool touch(const NodeSurface<Dim>& a, const NodeSurface<Dim>& b, const Vec<Dim>& n) const;

  std::vector<Grid<Dim, R>*> grids_;
  std::vector<const Body<Dim>*> bodies_;
  const BoundaryConditions<Dim, R>& conditions_;
  Real friction_;
  std::vector<std::vector<Pressed>> pressed_;  ///< Per band of the grid.
};

}  // namespace matpoint
