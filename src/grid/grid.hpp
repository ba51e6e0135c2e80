// The background grid: scratch space of one step. Nothing on it outlives the step (decision 4 of docs/architecture.md).
#pragma once

#include <vector>

#include "case/case.hpp"
#include "solver/solver.hpp"
#include "transfer/views.hpp"

namespace matpoint {

/// Parameters of the momentum equation on the nodes.
template <int Dim>
struct NodalDynamics {
  Vec<Dim> gravity{};   ///< [m/s^2]
  Real damping = 0;     ///< alpha in f_d = alpha m v [1/s]; Li et al. (2018)
  Real mass_cutoff = 0; ///< Nodes with less mass [kg] do not move.
  Real flip = 1;        ///< The particles' FLIP share, for the books of impulse.
};

template <int Dim>
class Grid {
 public:
  explicit Grid(const GridSpec& spec);

  const GridView<Dim>& view() const { return view_; }
  GridGeometry geometry() const;
  Index node_count() const { return node_count_; }
  Index memory() const { return static_cast<Index>((mapped_.size() + motion_.size()) * sizeof(Real)); }
  /// Bands are rows (2D) or planes (3D) of cells along the last axis: the pieces that P2G works in parallel.
  int band_count() const { return view_.cells[Dim - 1]; }
  /// The band of a particle at coordinate x [m] along the last axis.
  int band_of(Real x) const {
    Real xi;
    return locate_in_cell<Dim>(view_, Dim - 1, x, xi);
  }
  Vec<Dim> node_position(Index node) const;
  /// Number of nodes in each direction.
  int nodes(int d) const { return view_.cells[d] + 1; }

  /// Clears the rows of nodes that the bands marked as occupied touch; the others are not visited in this step.
  void clear(const std::vector<char>& is_band_occupied);

  /// Adds what periodic sides share; call after all bodies are mapped.
  void fold_periodic();

  /// v = p/m without forces (for the velocities of USF and the second mapping of MUSL).
  void compute_velocity(const NodalDynamics<Dim>& dynamics);

  /// a = (f - alpha p)/m + g, v = p/m + a dt. Books damping and what nodes under the cutoff do not pass on.
  void advance_velocity(const NodalDynamics<Dim>& dynamics, Real dt, Ledger& ledger);

  Real* mapped(Index node) { return mapped_.data() + node * k_mapped_width; }
  const Real* mapped(Index node) const { return mapped_.data() + node * k_mapped_width; }
  Real* motion(Index node) { return motion_.data() + node * k_motion_width<Dim>; }
  const Real* motion(Index node) const { return motion_.data() + node * k_motion_width<Dim>; }
  /// The far image of a node on a periodic side: it moves like its twin, and is left out of all sums.
  bool is_periodic_twin(Index node) const;
  bool is_row_active(Index node) const { return is_row_active_[static_cast<std::size_t>(node / row_size_)] != 0; }

 private:
  template <class F>
  void for_each_active_row(F&& f);

  GridView<Dim> view_{};
  Index node_count_ = 0;
  Index row_size_ = 0;
  Index row_count_ = 0;
  std::vector<Real> mapped_;
  std::vector<Real> motion_;
  std::vector<char> is_row_active_;
  bool has_periodic_ = false;
};

}  // namespace matpoint
