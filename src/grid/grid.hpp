// The background grid: scratch space of one step, sparse. Nothing on it outlives the step (decision 4 of docs/architecture.md).
//
// Nodes come in tiles, runs of `k_lanes` nodes along x; a tile exists while a particle may touch it, so memory and time follow the
// material and not the box. Cells along the last axis are cut into bands, by the grid and never by the number of threads. A band owns its
// rows of cells and the nodes at their lower side, so work on it touches its own tiles and the first rows of the next band's: all even
// bands can be worked side by side, then all odd ones, and every node gets its sums in one order.
//
// Cell i of a direction has the nodes i, ..., i + span. Those of linear shapes are its corners; those of B-splines are control points,
// which stand at the Greville abscissae; those of GIMP and CPDI are corners from the one before the cell to the one after it, so the first
// and the last node of a direction lie outside of the grid, and particles never reach them.
#pragma once

#include <unordered_map>
#include <vector>

#include "case/boundary_spec.hpp"
#include "case/grid_spec.hpp"
#include "core/arena.hpp"
#include "core/state.hpp"
#include "geometry/region.hpp"
#include "kernel/kernel.hpp"
#include "solver/ledger.hpp"
#include "solver/report.hpp"

namespace matpoint {

template <int Dim, class R>
class BoundaryConditions;

/// Whole cells or nodes: one number per direction.
template <int Dim>
using Place = std::array<int, Dim>;

/// Some nodes of a tile of the grid.
template <int Dim>
struct TileNodes {
  std::array<int, Dim> first{};  ///< The first node of the tile.
  std::vector<int> lanes;        ///< The nodes, by their place in the tile.
};

/// A side of the grid that lets nothing through.
struct ClosedSide {
  int axis = 0;
  bool is_upper = false;
  PrescribedVelocity velocity;
  int condition = -1;
};

/// A region that lets nothing in.
struct Obstacle {
  const Region* region = nullptr;
  PrescribedVelocity velocity;
  int condition = -1;
};

/// A fixed component of a node in a tile.
struct FixedComponent {
  int lane;
  int component;
  int condition;
};
/// A direction of a node that is along no axis: n . v = 0, brought about by moving v along `correction`, which leaves the node's fixed
/// components alone; correction . n = 1.
template <int Dim>
struct FixedNormal {
  int lane;
  Vec<Dim> n;
  Vec<Dim> correction;
  int condition;
};

/// A node of a rigid surface that lets go: the velocity v of what touches it, beside the surface's own V, obeys (v - V) . n >= 0, and the
/// surface holds along itself with at most `friction` times the impulse along n.
template <int Dim>
struct SurfaceContact {
  int lane;
  int condition;                   ///< That says how fast the surface moves.
  Vec<Dim> n;                      ///< Out of the surface.
  Vec<Dim> correction;             ///< As in FixedNormal.
  std::array<bool, Dim> is_fixed;  ///< Components that other conditions hold.
  Real friction;                   ///< [1]; infinite: whatever presses sticks.
  Real gap = 0;                    ///< Between a side of the grid and the nearest particle around the node [m]; of a region 0.
  bool presses = false;            ///< In the last advance.
  bool sticks = false;             ///< And does not slide.
};

template <int Dim, class R>
struct Tile {
  NodeValues<Dim, R> values{};
  Place<Dim> first{};  ///< The first node.
  Index key = 0;
  Index pass = 0;           ///< The last pass over the nodes that has worked it.
  int user_count = 0;       ///< Blocks that touch it.
  bool has_images = false;  ///< Of some nodes, at periodic sides.
  std::vector<FixedComponent> components;
  std::vector<FixedNormal<Dim>> normals;
  std::vector<SurfaceContact<Dim>> contacts;
  alignas(64) R booked[k_lanes<R>];  ///< 0 for the far image of a node at a periodic side, which is left out of all sums.
};

template <int Dim, class R>
class Grid {
 public:
  using TileType = Tile<Dim, R>;

  Grid(const GridSpec& spec, ShapeKind shape);
  ~Grid();

  /// Conditions for tiles that are made from now on; they must outlive the grid. To be called before any tile exists.
  void set_boundary_conditions(const BoundaryConditions<Dim, R>* conditions) { conditions_ = conditions; }

  /// A body force per mass [m/s^2] at all nodes, Dim numbers each, x fastest; must outlive the grid.
  void set_body_force(const std::vector<Real>* values) { body_force_ = values; }

  /// Whether the velocity that a pass has advanced is left in `second`, too, for refining.
  void set_refined(bool is_refined) { is_refined_ = is_refined; }

  /// Gives the far images of nodes at periodic sides what these nodes have, for they are one. Dim numbers each.
  void copy_periodic(std::vector<Real>& values) const;

  GridGeometry geometry() const;
  Real lower(int d) const { return lower_[d]; }
  Real upper(int d) const { return upper_[d]; }
  Real cell_size(int d) const { return cell_size_[d]; }
  int cells(int d) const { return cells_[d]; }
  int nodes(int d) const { return cells_[d] + span_; }
  int span() const { return span_; }
  /// The node on a side of the grid, along its axis.
  int side_node(int d, bool is_upper) const {
    const int outside = has_domains(shape_) ? 1 : 0;
    return is_upper ? nodes(d) - 1 - outside : outside;
  }
  /// Rows of nodes around a cell.
  int row_count() const { return rows_of<Dim>(span_); }
  bool is_periodic(int d) const { return is_periodic_[d]; }
  bool has_periodic() const { return has_periodic_; }
  /// Of a periodic direction: the last nodes are images of the first ones, as many as the shape functions span, and the other way round.
  /// The other one of the two along axis d; -1 for a node that has none.
  int image_of(int node, int d) const {
    if (!is_periodic_[d]) return -1;
    return node < span_ ? node + cells_[d] : node >= cells_[d] && node < nodes(d) ? node - cells_[d] : -1;
  }
  Index node_count() const;
  Vec<Dim> node_position(const Place<Dim>& node) const;
  /// Of all nodes, Dim numbers each, in the order of their numbers (x fastest).
  std::vector<Real> node_positions() const;

  /// Rows of cells in a band.
  int band_rows() const { return band_rows_; }
  int band_count() const { return static_cast<int>(bands_.size()); }
  /// The band of a cell that is at `row` along the last axis.
  int band_of(int row) const { return row / band_rows_; }

  /// The tile with the node, made if need be, with one user more; `node[0]` is a multiple of `k_lanes`. Only the threads that work
  /// the node's band, or the band before it while that is idle, may call this.
  TileType* acquire(const Place<Dim>& node);
  void release(TileType* tile);
  /// The tile with the node, or null.
  TileType* find(const Place<Dim>& node) const;
  /// The tiles of a band of nodes, in the order in which they were made.
  const std::vector<TileType*>& tiles(std::size_t band) const { return bands_[band].tiles; }

  /// Adds what periodic sides share; call after all bodies are mapped.
  enum class Fold { all, momentum, force };
  void fold_periodic(Fold what);
  /// Starts a pass over the nodes. A tile is worked when a sweep first needs it (`prepare`), while it is in the cache, and at the
  /// latest by `finish_pass`. `t`: time of the boundary values [s]; `dt` is for NodePass::advance.
  enum class NodePass {
    advance,        ///< The momentum equation and the boundary conditions; clears what the next mapping sums.
    advance_keep,   ///< The same without clearing the mass, which a second mapping needs.
    velocity,       ///< p/m with boundary values into `second`; clears mass, momentum and force.
    velocity_keep,  ///< The same without clearing.
    refine          ///< FMPM: takes p/m from `second`, and adds what is left to the velocity; clears the momentum.
  };
  void start_pass(NodePass pass, const KernelTable<Dim, R>& kernels, const NodalDynamics<Dim>& dynamics, Real t, Real dt);
  /// Threads: as acquire; `band` is the one that the calling thread works.
  void prepare(TileType& tile, std::size_t band) {
    if (tile.pass != pass_count_) work_tile(tile, band);
  }
  /// Of each condition, in the pass under way.
  const std::vector<PrescribedVelocity>& boundary_velocities() const { return boundary_velocities_; }
  /// Works the tiles that no sweep needed, and books the pass.
  void finish_pass(Ledger& ledger);
  /// Clears everything that is summed.
  void clear();
  /// Without tiles. No block may have any.
  void remove_tiles();
  /// What is mapped, for the next step finds it on the nodes. Loading: when all bodies have their blocks again.
  void declare_state(State& state);

  /// Nodal mass and velocity of the last step, x fastest; 0 where no tile is.
  std::vector<Field> fields() const;
  Index tile_count() const;
  Index memory() const;

 private:
  struct Band {
    std::vector<TileType*> tiles;  ///< In the order in which they were made.
    std::unordered_map<Index, TileType*> by_key;
    std::vector<TileType*> unused;
  };

  Index key_of(const Place<Dim>& node) const;
  int band_of_node_row(int row) const { return std::min(row / band_rows_, band_count() - 1); }
  void set_up(TileType& tile, const Place<Dim>& node) const;
  /// The first nodes of the tiles in which the images of a tile's nodes along axis d lie.
  std::vector<Place<Dim>> image_tiles(const Place<Dim>& first, int d) const;
  TileType* make_tile(Band& band, const Place<Dim>& node);
  template <class F>
  void for_each_band(F&& f);
  void work_tile(TileType& tile, std::size_t band);
  /// Calls f(lane, node number) for the nodes of a tile that are in the grid.
  template <class F>
  void for_each_node(const TileType& tile, F&& f) const;
  void refine(TileType& tile, Ledger& books) const;
  void add_body_force(TileType& tile) const;
  void book_body_force(const TileType& tile, Ledger& books) const;

  Real lower_[Dim];
  Real upper_[Dim];
  Real cell_size_[Dim];
  int cells_[Dim];
  bool is_periodic_[Dim];
  bool has_periodic_ = false;
  ShapeKind shape_;
  int span_;
  int band_rows_ = 1;
  Arena tiles_;
  std::vector<Band> bands_;
  const BoundaryConditions<Dim, R>* conditions_ = nullptr;
  const std::vector<Real>* body_force_ = nullptr;
  bool is_refined_ = false;

  // The pass over the nodes that is under way, and its books, one per band.
  NodePass pass_ = NodePass::advance;
  Index pass_count_ = 0;
  const KernelTable<Dim, R>* kernels_ = nullptr;
  NodalDynamics<Dim> dynamics_;
  Real dt_ = 0;
  std::vector<PrescribedVelocity> boundary_velocities_;
  std::vector<PrescribedVelocity> boundary_velocities_before_;  ///< A step ago.
  std::vector<NodalSums<Dim>> sums_;
  std::vector<Ledger> books_;
};

}  // namespace matpoint
