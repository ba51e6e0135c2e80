// A mesh of quadrilaterals with 4 or 9 nodes, or hexahedra with 8 or 27: tensor products of Lagrange functions with nodes at -1, (0,) 1.
#pragma once

#include <map>
#include <optional>

#include "core/types.hpp"

namespace matpoint {

/// Values and derivatives of the order + 1 Lagrange functions of one direction at xi in [-1, 1].
struct Lagrange {
  Lagrange() = default;
  Lagrange(int order, Real xi);
  Real N[3];
  Real dN[3];
};

/// base^exponent
constexpr int whole_power(int base, int exponent) { return exponent == 0 ? 1 : base * whole_power(base, exponent - 1); }

/// A face of an element: where the local coordinate `axis` is 1 (upper) or -1.
struct ElementFace {
  Index element;
  int axis;
  bool is_upper;
};

/// A place in an element: local coordinates in [-1, 1].
template <int Dim>
struct ElementPoint {
  Index element = 0;
  Vec<Dim> xi{};
};

/// How near to a face a place is on it, in local coordinates: beyond rounding, and far below anything that can be seen.
constexpr Real k_on_face = 1e-10;

template <int Dim>
class Mesh {
 public:
  /// `elements`: (order + 1)^Dim node numbers each, the first local direction fastest. `parts`: faces of the boundary by name. Throws
  /// InputError for node numbers that do not exist and for elements that are turned inside out.
  Mesh(int order, std::vector<Vec<Dim>> nodes, std::vector<Index> elements, std::map<std::string, std::vector<ElementFace>> parts);

  int order() const { return order_; }
  int nodes_per_element() const { return nodes_per_element_; }
  Index node_count() const { return static_cast<Index>(nodes_.size()); }
  Index element_count() const { return static_cast<Index>(elements_.size()) / nodes_per_element_; }
  const Index* element(Index e) const { return elements_.data() + e * nodes_per_element_; }
  const std::vector<Vec<Dim>>& nodes() const { return nodes_; }
  const std::map<std::string, std::vector<ElementFace>>& parts() const { return parts_; }
  /// The nodes of a face, in the order of the element's.
  std::vector<Index> face_nodes(const ElementFace& face) const;
  /// Nodes of the boundary, whether or not a part names their faces.
  std::vector<Index> boundary_nodes() const;

  /// The element behind the face, or -1.
  Index neighbour(Index e, int axis, bool is_upper) const {
    return neighbours_[static_cast<std::size_t>(e * 2 * Dim + 2 * axis + (is_upper ? 1 : 0))];
  }

  /// Moves the nodes, in the order of their numbers.
  void set_nodes(std::vector<Vec<Dim>> nodes);

  /// Shape functions and their derivatives by position [1/m], nodes_per_element() and Dim times as many; the Jacobian's determinant.
  Real evaluate(const ElementPoint<Dim>& point, Real* N, Real* gradients) const;
  /// Position of a place in an element [m].
  Vec<Dim> position(const ElementPoint<Dim>& point) const;

  /// The element that holds x, by Newton's method on the inverse map from `guess` and hops to the neighbour on the side on which the local
  /// coordinates leave [-1, 1]; nothing when the way ends at the boundary. Elements may be deformed.
  /// With `is_barred`, by element, the way does not go into such elements: it ends before them, with local coordinates beyond +-1.
  /// A place that is on a face but for rounding (k_on_face of the local coordinates) belongs to the element with the greater number, in a
  /// tensor mesh the upper one: which of two cells particles on a line of symmetry are in must not be left to rounding.
  std::optional<ElementPoint<Dim>> locate(const Vec<Dim>& x, Index guess, const std::vector<bool>* is_barred = nullptr) const;
  /// The same without a guess.
  std::optional<ElementPoint<Dim>> locate(const Vec<Dim>& x) const;

 private:
  void find_neighbours();
  Index owner_of(const ElementPoint<Dim>& point, const std::vector<bool>* is_barred) const;
  void fill_bins();

  int order_;
  int nodes_per_element_;
  std::vector<Vec<Dim>> nodes_;
  std::vector<Index> elements_;
  std::map<std::string, std::vector<ElementFace>> parts_;
  std::vector<Index> neighbours_;  ///< 2 Dim per element: behind the lower and upper face of each local direction, or -1.
  // Elements whose bounding boxes touch a bin; bins are equal boxes, about one per element.
  Vec<Dim> bin_lower_{};
  Vec<Dim> bin_size_{};
  std::array<int, Dim> bin_count_{};
  std::vector<std::vector<Index>> bins_;
};

/// A mesh of boxes between the coordinates `lines` [m], ascending in each direction, elements and nodes numbered with x fastest. Its parts
/// are left, right, bottom, top (and front, back).
template <int Dim>
Mesh<Dim> tensor_mesh(const std::array<std::vector<Real>, Dim>& lines, int order);

/// The coordinates with those of the middles between.
std::vector<Real> halved(const std::vector<Real>& line);

/// Coordinates of `cells` intervals from lower to upper, each `ratio` times as long as the one before it, halved `refinements` times.
std::vector<Real> graded_line(Real lower, Real upper, int cells, Real ratio, int refinements);

}  // namespace matpoint
