// A body of finite elements in the mesh of the implicit solver (total Lagrangian). Its nodes carry the motion; its Gauss points carry F and
// history, and take part in the sums over a cell exactly as particles do: with A = I + grad_n u, where grad_n is by the positions at the
// start of the step, V0 (tau A^-T) : grad_n equals P : grad_X.
#pragma once

#include "body/point_body.hpp"
#include "mesh/basis.hpp"

namespace matpoint {

template <int Dim>
class FemBody {
 public:
  /// The cells of the undeformed basis that the body's region covers. Throws InputError when the region cuts a cell or covers none.
  FemBody(const BodySpec& spec, const Basis<Dim>& basis);

  /// Gauss points as particles, in the order of the cells; velocities and accelerations are the nodes', interpolated.
  PointBody<Dim>& points() { return points_; }
  const PointBody<Dim>& points() const { return points_; }
  const std::vector<Index>& cells() const { return cells_; }
  const ElementPoint<Dim>& place(std::size_t point) const { return places_[point]; }
  /// How far a Gauss point is from the nearest face of its cell, undeformed [m].
  Real depth(std::size_t point) const { return depths_[point]; }
  /// Length of a cube of the largest cell's volume [m].
  Real cell_length() const { return cell_length_; }
  /// Weight over mass of the body [1]: gravity acts on another density than inertia where a case says so.
  Real weight_ratio() const { return weight_ratio_; }
  /// C_c for particles that recede from the body [1].
  Real receding_correction() const { return receding_correction_; }

  /// Faces of its cells that no cell of a body of elements is behind.
  std::vector<ElementFace> outer_faces(const Basis<Dim>& basis, const std::vector<bool>& is_fem_cell) const;
  bool has_node(Index node) const { return has_node_[static_cast<std::size_t>(node)]; }
  // By node of the mesh, 0 off the body.
  std::vector<Vec<Dim>> displacement;  ///< [m]
  std::vector<Vec<Dim>> velocity;      ///< [m/s]
  std::vector<Vec<Dim>> acceleration;  ///< [m/s^2]

  /// Velocities and accelerations at the Gauss points from those at the nodes.
  void interpolate_motion();
  void declare_state(State& state) {
    state.part("points", points_);
    state.add("displacement", displacement);
    state.add("velocity", velocity);
    state.add("acceleration", acceleration);
    for (const auto* nodal : {&displacement, &velocity, &acceleration}) {
      if (nodal->size() != has_node_.size()) state.fail("displacement", "has not one row for each node of the grid");
    }
    if (points_.count() != static_cast<Index>(places_.size())) state.fail("points", "are not as many as the body has");
  }

  // For output (fem_body_fields.cpp): fields by the body's own nodes.
  const BodyCells& cells_for_output() const { return output_cells_; }
  std::vector<std::string> node_field_names() const;
  /// Throws InputError for a name that is none of these.
  Field node_field(const std::string& name, std::size_t body) const;

 private:
  BodyCells make_cells() const;
  Field extended_to_nodes(const Field& at_points, bool is_bounded = false) const;

  PointBody<Dim> points_;
  std::vector<Index> cells_;
  std::vector<ElementPoint<Dim>> places_;
  std::vector<Real> depths_;
  Real cell_length_ = 0;
  std::vector<bool> has_node_;
  std::vector<Index> nodes_of_body_;  ///< Its nodes in the mesh, ascending.
  std::vector<Vec<Dim>> undeformed_;  ///< Where these were at the start [m].
  std::vector<Index> cell_rows_;      ///< Of each cell, functions() rows of nodes_of_body_.
  BodyCells output_cells_;
  Index functions_;
  std::vector<Index> nodes_;  ///< Of each Gauss point, `functions` numbers.
  std::vector<Real> N_;
  Real weight_ratio_ = 1;
  Real receding_correction_ = 0;
};

}  // namespace matpoint
