// The unknowns of one implicit step and what stays as it is while Newton's method runs: which cells are active, how their nodes are
// numbered, which components are prescribed, and the basis at the particles.
#pragma once

#include <cmath>
#include <string_view>

#include "body/fem_body.hpp"
#include "body/point_body.hpp"
#include "case/boundary_spec.hpp"
#include "mesh/basis.hpp"

namespace matpoint {

/// Sides and regions of the background at which components are prescribed.
template <int Dim>
class NodeConditions {
 public:
  NodeConditions(const std::vector<BoundarySpec>& specs, const Basis<Dim>& basis);

  /// The condition on a component of a node, or -1.
  int condition(Index node, int component) const { return conditions_[static_cast<std::size_t>(node * Dim + component)]; }
  /// Whether the node counts as outside of the body for the soft stiffness: on the boundary, and on no side that the body grows out of.
  bool is_free_boundary(Index node) const { return is_free_boundary_[static_cast<std::size_t>(node)]; }
  /// Displacements that the conditions prescribe from time t to t + dt: their velocities integrated by Simpson's rule [m]; 0 of those that
  /// are by place.
  std::vector<Vec<Dim>> displacements(Real t, Real dt) const;
  /// Of what a condition prescribes by place, that of a node at x: along its way, by the rule of Runge and Kutta [m].
  Vec<Dim> displacement_by_place(int condition, const Vec<Dim>& x, Real t, Real dt) const;
  bool is_by_place(int condition) const { return specs_[static_cast<std::size_t>(condition)].velocity_field != nullptr; }
  std::vector<Vec<Dim>> velocities(Real t) const;

  /// Faces at sides from which particles may recede (receding_correction), with C_c and the condition whose velocity they have.
  struct RecedingSide {
    ElementFace face;
    Real correction;
    int condition;
  };
  const std::vector<RecedingSide>& receding_sides() const { return receding_sides_; }

 private:
  std::vector<BoundarySpec> specs_;
  std::vector<int> conditions_;
  std::vector<bool> is_free_boundary_;
  std::vector<RecedingSide> receding_sides_;
};

/// A body of the implicit solver as its equations see it: points that carry stress and mass.
template <int Dim>
struct PointSource {
  PointBody<Dim>* points = nullptr;
  FemBody<Dim>* fem = nullptr;  ///< Whose Gauss points they are; null for particles.
  bool has_fbar = false;        ///< Its volume change goes by patches (volume_patches.hpp).

  std::string_view point_name() const { return fem != nullptr ? "Gauss point" : "particle"; }
  /// How far behind the surface a point is that is next to it, undeformed [m].
  Real depth(std::size_t row) const { return fem != nullptr ? fem->depth(row) : 0.5 * std::pow(points->volume0[row], Real{1} / Dim); }
};

template <int Dim>
class StepSpace {
 public:
  /// All must outlive it. Throws InputError for a cell of two bodies of elements, and, where they share a field, for particles in such a
  /// cell.
  StepSpace(const Basis<Dim>& basis, const NodeConditions<Dim>& conditions, std::vector<PointSource<Dim>> sources,
            std::vector<Real> soft_stiffness, bool has_own_fields = false);

  /// Finds everything anew for the particles as they are. Throws SolverError for a particle outside of the background.
  void update(Real t);
  /// Components that are no longer prescribed although a condition is on them, by slot and component: numbers the unknowns anew where that
  /// changes anything.
  void release(const std::vector<bool>& released);

  const Basis<Dim>& basis() const { return basis_; }
  const NodeConditions<Dim>& conditions() const { return conditions_; }
  int functions() const { return functions_; }

  /// Fields of displacements: one that all bodies share, or one for each body.
  std::size_t field_count() const { return has_own_fields_ ? sources_.size() : 1; }
  std::size_t field_of(std::size_t source) const { return has_own_fields_ ? source : 0; }
  /// What a node of a field is known by from step to step.
  Index slot(std::size_t field, Index node) const { return static_cast<Index>(field) * basis_.node_count() + node; }
  Index slot_count() const { return static_cast<Index>(field_count()) * basis_.node_count(); }

  // Active cells, ascending, and their particles. A cell in which several bodies have particles comes once for each of them.
  const std::vector<Index>& cells() const { return cells_; }
  Index cell_begin(std::size_t c) const { return cell_begin_[c]; }  ///< First of the cell's places in `particles`.
  Index cell_end(std::size_t c) const { return cell_begin_[c + 1]; }
  const std::vector<Index>& particles() const { return particles_; }  ///< Rows of the cell's source, cell by cell.
  std::size_t source_of(std::size_t c) const { return cell_source_[c]; }
  /// Whether the entry before is of the same cell and field, with the particles of another body.
  bool is_again(std::size_t c) const { return !has_own_fields_ && c > 0 && cells_[c] == cells_[c - 1]; }
  const std::vector<PointSource<Dim>>& sources() const { return sources_; }
  /// Calls f(source, row, place) for all points.
  template <class F>
  void for_each_point(F&& f) const {
    for (std::size_t c = 0; c < cells_.size(); ++c) {
      for (Index k = cell_begin_[c]; k < cell_begin_[c + 1]; ++k)
        f(cell_source_[c], static_cast<std::size_t>(particles_[static_cast<std::size_t>(k)]), static_cast<std::size_t>(k));
    }
  }
  const std::vector<bool>& is_fem_cell() const { return is_fem_cell_; }
  /// Whether the cell is one of a body of elements, among the active ones.
  bool is_fem(std::size_t c) const { return sources_[cell_source_[c]].fem != nullptr; }
  /// Whether an active node is one of the body's field.
  bool is_of(std::size_t source, std::size_t active_node) const {
    return slots_[active_node] / basis_.node_count() == static_cast<Index>(field_of(source));
  }
  /// Whether the basis goes with the bodies of elements, since particles share their nodes. Otherwise it stays undeformed, and bodies of
  /// elements move away from it.
  bool moves_basis() const { return moves_basis_; }
  /// Where an active node is at the start of the step [m].
  Vec<Dim> place(std::size_t active_node) const;
  bool is_fem_node(Index node) const { return is_fem_node_[static_cast<std::size_t>(node)]; }
  /// A particle's place in the background as it is now; nothing outside.
  std::optional<ElementPoint<Dim>> find(std::size_t source, std::size_t row) const;
  /// Where it was found last.
  const ElementPoint<Dim>& point(std::size_t source, std::size_t row) const { return points_[source][row]; }
  /// Whether a particle can leave in a step that takes it to the next cell at most: its cell is at the border of the background.
  bool is_at_border(std::size_t source, std::size_t row) const {
    return is_border_cell_[static_cast<std::size_t>(points_[source][row].element)];
  }
  /// Forgets the places of particles that are removed, by their rows, ascending.
  void forget(std::size_t source, const std::vector<Index>& rows);
  /// Particles beyond the face of a body of elements.
  Index penetrated_count() const { return penetrated_count_; }
  Real soft_factor(std::size_t c) const { return soft_factors_[c]; }  ///< C [1]

  // The basis at the particles, in the order of `particles`.
  const Real* N(Index k) const { return N_.data() + k * functions_; }
  const Real* gradients(Index k) const { return gradients_.data() + k * functions_ * Dim; }
  /// With which the displacement gradient is made: those of receding particles are corrected (eq. 47).
  const Real* trial_gradients(Index k) const {
    const Index corrected = corrected_[static_cast<std::size_t>(k)];
    return corrected < 0 ? gradients(k) : corrected_gradients_.data() + corrected * functions_ * Dim;
  }
  Index receding_count() const { return receding_count_; }

  // Active nodes, field by field and ascending in each, and unknowns.
  const std::vector<Index>& nodes() const { return nodes_; }  ///< Of the background.
  const std::vector<Index>& slots() const { return slots_; }  ///< Ascending.
  /// Place of a cell's node among the active ones.
  const int* cell_nodes(std::size_t c) const { return cell_nodes_.data() + c * static_cast<std::size_t>(functions_); }
  /// Number of the unknown, or -1 where the component is prescribed.
  int unknown(Index active_node, int component) const { return unknowns_[static_cast<std::size_t>(active_node * Dim + component)]; }
  int unknown_count() const { return unknown_count_; }
  /// Changes when cells, nodes or unknowns do.
  Index pattern() const { return pattern_; }
  /// In which cells particles were found last, for the next search begins there, and what is released. After the bodies.
  void declare_state(State& state);

 private:
  /// A face of a cell from which particles may recede.
  struct RecedingFace {
    ElementFace face;
    Real correction;  ///< C_c [1]
    int condition;    ///< Whose velocity it has; -1: the body of elements' behind it.
    std::size_t source;
    std::vector<Index> nodes;  ///< In the middle of the face, whose mean velocity is the face's.
  };
  void mark_fem_cells();
  void find_receding_faces();
  void locate();
  void number_nodes();
  void set_soft_factors();
  void evaluate();
  void pull_forward(const Real* F, Real* gradients) const;
  void correct_receding(Real t);
  /// The face's velocity [m/s] and the direction away from it.
  std::pair<Vec<Dim>, Vec<Dim>> motion_of(const RecedingFace& face, const std::vector<Vec<Dim>>& velocities) const;

  const Basis<Dim>& basis_;
  const NodeConditions<Dim>& conditions_;
  std::vector<PointSource<Dim>> sources_;
  std::vector<Real> soft_stiffness_;
  bool has_own_fields_;
  bool moves_basis_;
  int functions_;
  std::vector<bool> is_fem_cell_;
  std::vector<bool> is_fem_node_;
  std::vector<bool> is_border_cell_;
  std::vector<std::vector<RecedingFace>> receding_faces_;  ///< By cell; empty without any.

  std::vector<std::vector<ElementPoint<Dim>>> points_;  ///< By source and row.
  bool has_places_ = false;
  Index penetrated_count_ = 0;
  std::vector<std::size_t> cell_source_;
  std::vector<Index> particles_;
  std::vector<Index> cells_;
  std::vector<Index> cell_begin_;
  std::vector<Real> soft_factors_;
  std::vector<Real> N_;
  std::vector<Real> gradients_;
  std::vector<Index> corrected_;
  std::vector<Real> corrected_gradients_;
  Index receding_count_ = 0;
  std::vector<Index> nodes_;
  std::vector<Index> slots_;
  std::vector<int> cell_nodes_;
  std::vector<int> unknowns_;
  int unknown_count_ = 0;
  std::vector<bool> released_;  ///< By slot and component; empty: none.
  Index pattern_ = 0;
};

}  // namespace matpoint
