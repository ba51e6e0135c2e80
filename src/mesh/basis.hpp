// What the implicit solver needs of its background: functions on cells, whether 9-node elements or B-splines. A cell has a fixed number of
// functions; "node" is a function's number, also where it is the control point of a spline.
#pragma once

#include <memory>

#include "case/grid_spec.hpp"
#include "mesh/mesh.hpp"

namespace matpoint {

/// A place in a cell with a weight [m^dim]: the volume that it stands for.
template <int Dim>
struct QuadraturePoint {
  ElementPoint<Dim> point;
  Real weight;
};

template <int Dim>
class Basis {
 public:
  virtual ~Basis() = default;

  virtual int functions_per_cell() const = 0;
  virtual Index node_count() const = 0;
  virtual Index cell_count() const = 0;
  virtual const Index* cell_nodes(Index cell) const = 0;
  virtual Vec<Dim> node_position(Index node) const = 0;
  /// Whether a node's value is the field's value at its position.
  virtual bool is_interpolating() const = 0;

  /// The cell with x and the place in it; nothing outside. Cells are half open, a point on a face (but for rounding)
  /// belongs to the one above it.
  virtual std::optional<ElementPoint<Dim>> locate(const Vec<Dim>& x) const = 0;
  /// The same from a cell near it, on a background that may have been moved; barred cells are not entered (Mesh::locate).
  virtual std::optional<ElementPoint<Dim>> locate_from(const Vec<Dim>& x, Index cell, const std::vector<bool>& is_barred) const = 0;
  /// Position of a place in a cell [m].
  virtual Vec<Dim> position(const ElementPoint<Dim>& point) const = 0;
  /// Moves the nodes [m]; for elements only.
  virtual void set_nodes(std::vector<Vec<Dim>> nodes) = 0;
  /// The cell behind a face, or -1.
  virtual Index neighbour(Index cell, int axis, bool is_upper) const = 0;
  /// Functions [1] and their gradients [1/m], functions_per_cell() and Dim times as many; the Jacobian of the cell.
  virtual Real evaluate(const ElementPoint<Dim>& point, Real* N, Real* gradients) const = 0;

  /// Cells at a side ("left", ...), with their faces there. Throws InputError for another name.
  virtual const std::vector<ElementFace>& side_faces(const std::string& side) const = 0;
  /// Nodes whose functions do not vanish on a side.
  virtual std::vector<Index> side_nodes(const std::string& side) const = 0;

  /// 3^Dim Gauss points, exact for products of two gradients of these functions on boxes.
  std::vector<QuadraturePoint<Dim>> quadrature(Index cell) const;
  /// Of a cell, between the middles of opposite faces [m].
  Real shortest_side(Index cell) const;
  /// Of all cells [m].
  Real shortest_side() const;
};

template <int Dim>
std::vector<std::string> side_names_of();

/// Lagrange elements on boxes that may be graded, halved and mapped to a quadrilateral or a ring: grid.grading, grid.refinements,
/// grid.corners, grid.ring.
template <int Dim>
std::unique_ptr<Basis<Dim>> make_element_basis(const GridSpec& grid, int order);

/// Quadratic B-splines with clamped ends on equal cells, which may be halved: n + 2 functions for n cells in each direction.
template <int Dim>
std::unique_ptr<Basis<Dim>> make_spline_basis(const GridSpec& grid);

}  // namespace matpoint
