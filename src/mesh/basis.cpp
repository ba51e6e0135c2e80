#include "mesh/basis.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>

#include "core/error.hpp"

namespace matpoint {
namespace {

// --- Lagrange elements -----------------------------------------------------------------------------------------------

template <int Dim>
class ElementBasis final : public Basis<Dim> {
 public:
  ElementBasis(std::array<std::vector<Real>, Dim> lines, int order, const GridSpec& grid)
      : lines_(std::move(lines)), mesh_(tensor_mesh<Dim>(lines_, order)), is_mapped_(grid.is_mapped()) {
    if (!is_mapped_) return;
    std::vector<Vec<Dim>> nodes = mesh_.nodes();
    for (Vec<Dim>& x : nodes) {
      Vec3 place{};
      std::copy(x.begin(), x.end(), place.begin());
      place = grid.mapped(place);
      std::copy_n(place.begin(), Dim, x.begin());
    }
    mesh_.set_nodes(std::move(nodes));
  }

  int functions_per_cell() const override { return mesh_.nodes_per_element(); }
  Index node_count() const override { return mesh_.node_count(); }
  Index cell_count() const override { return mesh_.element_count(); }
  const Index* cell_nodes(Index cell) const override { return mesh_.element(cell); }
  Vec<Dim> node_position(Index node) const override { return mesh_.nodes()[static_cast<std::size_t>(node)]; }
  bool is_interpolating() const override { return true; }

  std::optional<ElementPoint<Dim>> locate(const Vec<Dim>& x) const override {
    if (is_mapped_) return mesh_.locate(x);
    // The boxes are as they were made, so that bisection and a division do what Newton's method would.
    ElementPoint<Dim> point;
    for (std::size_t d = Dim; d-- > 0;) {
      const std::vector<Real>& line = lines_[d];
      if (!(x[d] >= line.front() && x[d] <= line.back())) return std::nullopt;
      const auto cells = static_cast<Index>(line.size()) - 1;
      Index cell = std::min<Index>(std::upper_bound(line.begin(), line.end(), x[d]) - line.begin() - 1, cells - 1);
      // On the upper face but for rounding: as Mesh::locate has it.
      const Real end = line[static_cast<std::size_t>(cell) + 1];
      if (cell < cells - 1 && end - x[d] <= 0.5 * k_on_face * (end - line[static_cast<std::size_t>(cell)])) ++cell;
      const Real low = line[static_cast<std::size_t>(cell)];
      const Real high = line[static_cast<std::size_t>(cell) + 1];
      point.element = point.element * cells + cell;
      point.xi[d] = 2 * (x[d] - low) / (high - low) - 1;
    }
    return point;
  }
  std::optional<ElementPoint<Dim>> locate_from(const Vec<Dim>& x, Index cell, const std::vector<bool>& is_barred) const override {
    return mesh_.locate(x, cell, &is_barred);
  }
  Vec<Dim> position(const ElementPoint<Dim>& point) const override { return mesh_.position(point); }
  void set_nodes(std::vector<Vec<Dim>> nodes) override { mesh_.set_nodes(std::move(nodes)); }
  Index neighbour(Index cell, int axis, bool is_upper) const override { return mesh_.neighbour(cell, axis, is_upper); }
  Real evaluate(const ElementPoint<Dim>& point, Real* N, Real* gradients) const override { return mesh_.evaluate(point, N, gradients); }

  const std::vector<ElementFace>& side_faces(const std::string& side) const override { return mesh_.parts().at(side); }
  std::vector<Index> side_nodes(const std::string& side) const override {
    std::vector<Index> nodes;
    for (const ElementFace& face : mesh_.parts().at(side)) {
      const std::vector<Index> some = mesh_.face_nodes(face);
      nodes.insert(nodes.end(), some.begin(), some.end());
    }
    std::sort(nodes.begin(), nodes.end());
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    return nodes;
  }

 private:
  std::array<std::vector<Real>, Dim> lines_;
  Mesh<Dim> mesh_;
  bool is_mapped_;  ///< Whether its cells are no boxes.
};

// --- B-splines -------------------------------------------------------------------------------------------------------

/// The three quadratic B-splines of one direction in cell `cell` of `cells`, at q in [0, 1]; knots are clamped at both ends.
struct Spline {
  Spline(Index cell, Index cells, Real q) {
    const Real p = 1 - q;
    const Real first = cell == 0 ? 1 : 0.5;
    const Real last = cell == cells - 1 ? 1 : 0.5;
    N[0] = first * p * p;
    N[2] = last * q * q;
    N[1] = 1 - N[0] - N[2];
    dN[0] = -2 * first * p;
    dN[2] = 2 * last * q;
    dN[1] = -dN[0] - dN[2];
  }
  Real N[3];
  Real dN[3];
};

template <int Dim>
class SplineBasis final : public Basis<Dim> {
 public:
  explicit SplineBasis(const GridSpec& grid) {
    Index cell_count = 1;
    for (std::size_t d = 0; d < Dim; ++d) {
      lower_[d] = grid.lower[d];
      upper_[d] = grid.upper[d];
      cells_[d] = static_cast<Index>(grid.cells[d]) << grid.refinements;
      cell_size_[d] = (grid.upper[d] - grid.lower[d]) / static_cast<Real>(cells_[d]);
      cell_count *= cells_[d];
    }
    nodes_of_cells_.reserve(static_cast<std::size_t>(cell_count) * k_functions);
    for (Index c = 0; c < cell_count; ++c) {
      const std::array<Index, Dim> cell = places(c);
      for (int local = 0; local < k_functions; ++local) {
        Index number = 0;
        for (std::size_t d = Dim; d-- > 0;) number = number * (cells_[d] + 2) + cell[d] + place_of(local, static_cast<int>(d));
        nodes_of_cells_.push_back(number);
      }
      for (std::size_t d = 0; d < Dim; ++d) {
        const int axis = static_cast<int>(d);
        if (cell[d] == 0) faces_[side_names_of<Dim>()[2 * d]].push_back({c, axis, false});
        if (cell[d] == cells_[d] - 1) faces_[side_names_of<Dim>()[2 * d + 1]].push_back({c, axis, true});
      }
    }
  }

  int functions_per_cell() const override { return k_functions; }
  Index node_count() const override {
    Index count = 1;
    for (const Index n : cells_) count *= n + 2;
    return count;
  }
  Index cell_count() const override { return static_cast<Index>(nodes_of_cells_.size()) / k_functions; }
  const Index* cell_nodes(Index cell) const override { return nodes_of_cells_.data() + cell * k_functions; }
  /// The Greville abscissae, with which a linear field is reproduced: ends and middles of cells.
  Vec<Dim> node_position(Index node) const override {
    Vec<Dim> x;
    for (std::size_t d = 0; d < Dim; ++d) {
      const Index i = node % (cells_[d] + 2);
      node /= cells_[d] + 2;
      x[d] = i == 0 ? lower_[d] : i == cells_[d] + 1 ? upper_[d] : lower_[d] + (static_cast<Real>(i) - 0.5) * cell_size_[d];
    }
    return x;
  }
  bool is_interpolating() const override { return false; }

  std::optional<ElementPoint<Dim>> locate(const Vec<Dim>& x) const override {
    ElementPoint<Dim> point;
    for (std::size_t d = Dim; d-- > 0;) {
      if (!(x[d] >= lower_[d] && x[d] <= upper_[d])) return std::nullopt;
      const Real place = (x[d] - lower_[d]) / cell_size_[d];
      const Index cell = std::min(static_cast<Index>(place), cells_[d] - 1);
      point.element = point.element * cells_[d] + cell;
      point.xi[d] = 2 * (place - static_cast<Real>(cell)) - 1;
    }
    return point;
  }

  std::optional<ElementPoint<Dim>> locate_from(const Vec<Dim>& x, Index, const std::vector<bool>&) const override { return locate(x); }
  Vec<Dim> position(const ElementPoint<Dim>& point) const override {
    const std::array<Index, Dim> cell = places(point.element);
    Vec<Dim> x;
    for (std::size_t d = 0; d < Dim; ++d) x[d] = lower_[d] + (static_cast<Real>(cell[d]) + 0.5 * (point.xi[d] + 1)) * cell_size_[d];
    return x;
  }
  void set_nodes(std::vector<Vec<Dim>>) override { throw std::logic_error("control points of splines stay where they are"); }
  Index neighbour(Index cell, int axis, bool is_upper) const override {
    std::array<Index, Dim> place = places(cell);
    place[static_cast<std::size_t>(axis)] += is_upper ? 1 : -1;
    Index number = 0;
    for (std::size_t d = Dim; d-- > 0;) {
      if (place[d] < 0 || place[d] >= cells_[d]) return -1;
      number = number * cells_[d] + place[d];
    }
    return number;
  }

  Real evaluate(const ElementPoint<Dim>& point, Real* N, Real* gradients) const override {
    const std::array<Index, Dim> cell = places(point.element);
    Real values[Dim][3];
    Real derivatives[Dim][3];
    Real jacobian = 1;
    for (std::size_t d = 0; d < Dim; ++d) {
      const Spline spline(cell[d], cells_[d], 0.5 * (point.xi[d] + 1));
      for (int k = 0; k < 3; ++k) {
        values[d][k] = spline.N[k];
        derivatives[d][k] = spline.dN[k] / cell_size_[d];
      }
      jacobian *= 0.5 * cell_size_[d];
    }
    for (int local = 0; local < k_functions; ++local) {
      N[local] = 1;
      for (int d = 0; d < Dim; ++d) {
        N[local] *= values[d][place_of(local, d)];
        Real derivative = 1;
        for (int e = 0; e < Dim; ++e) derivative *= d == e ? derivatives[e][place_of(local, e)] : values[e][place_of(local, e)];
        gradients[local * Dim + d] = derivative;
      }
    }
    return jacobian;
  }

  const std::vector<ElementFace>& side_faces(const std::string& side) const override { return faces_.at(side); }
  std::vector<Index> side_nodes(const std::string& side) const override {
    std::vector<Index> nodes;
    for (const ElementFace& face : faces_.at(side)) {
      for (int local = 0; local < k_functions; ++local) {
        if (place_of(local, face.axis) == (face.is_upper ? 2 : 0)) nodes.push_back(cell_nodes(face.element)[local]);
      }
    }
    std::sort(nodes.begin(), nodes.end());
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    return nodes;
  }

 private:
  static constexpr int k_functions = whole_power(3, Dim);
  static int place_of(int local, int d) { return local / whole_power(3, d) % 3; }
  std::array<Index, Dim> places(Index cell) const {
    std::array<Index, Dim> all;
    for (std::size_t d = 0; d < Dim; ++d) {
      all[d] = cell % cells_[d];
      cell /= cells_[d];
    }
    return all;
  }

  Vec<Dim> lower_;
  Vec<Dim> upper_;
  Vec<Dim> cell_size_;
  std::array<Index, Dim> cells_;
  std::vector<Index> nodes_of_cells_;
  std::map<std::string, std::vector<ElementFace>> faces_;
};

}  // namespace

template <int Dim>
std::vector<std::string> side_names_of() {
  std::vector<std::string> names = {"left", "right", "bottom", "top"};
  if (Dim == 3) names.insert(names.end(), {"front", "back"});
  return names;
}

template <int Dim>
std::vector<QuadraturePoint<Dim>> Basis<Dim>::quadrature(Index cell) const {
  const Real place[3] = {-std::sqrt(0.6), 0, std::sqrt(0.6)};
  const Real weight[3] = {5.0 / 9, 8.0 / 9, 5.0 / 9};
  std::vector<Real> N(static_cast<std::size_t>(functions_per_cell()));
  std::vector<Real> gradients(N.size() * Dim);
  std::vector<QuadraturePoint<Dim>> points;
  for (int k = 0; k < whole_power(3, Dim); ++k) {
    QuadraturePoint<Dim> one{{cell, {}}, 1};
    int rest = k;
    for (std::size_t d = 0; d < Dim; ++d) {
      one.point.xi[d] = place[rest % 3];
      one.weight *= weight[rest % 3];
      rest /= 3;
    }
    one.weight *= evaluate(one.point, N.data(), gradients.data());
    points.push_back(one);
  }
  return points;
}

template <int Dim>
Real Basis<Dim>::shortest_side(Index cell) const {
  Real shortest = std::numeric_limits<Real>::infinity();
  for (std::size_t d = 0; d < Dim; ++d) {
    ElementPoint<Dim> point{cell, {}};
    point.xi[d] = -1;
    const Vec<Dim> from = position(point);
    point.xi[d] = 1;
    const Vec<Dim> to = position(point);
    Vec<Dim> side;
    for (std::size_t e = 0; e < Dim; ++e) side[e] = to[e] - from[e];
    shortest = std::min(shortest, std::sqrt(dot(side, side)));
  }
  return shortest;
}

template <int Dim>
Real Basis<Dim>::shortest_side() const {
  Real shortest = std::numeric_limits<Real>::infinity();
  for (Index cell = 0; cell < cell_count(); ++cell) shortest = std::min(shortest, shortest_side(cell));
  return shortest;
}

template <int Dim>
std::unique_ptr<Basis<Dim>> make_element_basis(const GridSpec& grid, int order) {
  std::array<std::vector<Real>, Dim> lines;
  for (std::size_t d = 0; d < Dim; ++d) {
    lines[d] = grid.lines[d].empty()
                   ? graded_line(grid.lower[d], grid.upper[d], grid.cells[d], grid.grading.empty() ? 1 : grid.grading[d], 0)
                   : grid.lines[d];
    for (int r = 0; r < grid.refinements; ++r) lines[d] = halved(lines[d]);
  }
  return std::make_unique<ElementBasis<Dim>>(std::move(lines), order, grid);
}

template <int Dim>
std::unique_ptr<Basis<Dim>> make_spline_basis(const GridSpec& grid) {
  return std::make_unique<SplineBasis<Dim>>(grid);
}

template class Basis<2>;
template class Basis<3>;
template std::vector<std::string> side_names_of<2>();
template std::vector<std::string> side_names_of<3>();
template std::unique_ptr<Basis<2>> make_element_basis<2>(const GridSpec&, int);
template std::unique_ptr<Basis<3>> make_element_basis<3>(const GridSpec&, int);
template std::unique_ptr<Basis<2>> make_spline_basis<2>(const GridSpec&);
template std::unique_ptr<Basis<3>> make_spline_basis<3>(const GridSpec&);

}  // namespace matpoint
