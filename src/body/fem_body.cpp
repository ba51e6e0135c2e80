#include "body/fem_body.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace matpoint {
namespace {

/// Where in a cell its region is asked for, so that a cell that the region cuts is found: a little inside of the corners, and between.
constexpr Real k_probes[3] = {-0.999, 0, 0.999};

/// Along the cell's own directions.
template <int Dim>
Real depth_in_cell(const Basis<Dim>& basis, const ElementPoint<Dim>& point) {
  const Vec<Dim> x = basis.position(point);
  Real depth = std::numeric_limits<Real>::infinity();
  for (std::size_t d = 0; d < Dim; ++d) {
    for (const Real end : {-1, 1}) {
      ElementPoint<Dim> face = point;
      face.xi[d] = end;
      const Vec<Dim> y = basis.position(face);
      Real squared = 0;
      for (std::size_t e = 0; e < Dim; ++e) squared += (y[e] - x[e]) * (y[e] - x[e]);
      depth = std::min(depth, std::sqrt(squared));
    }
  }
  return depth;
}

}  // namespace

template <int Dim>
FemBody<Dim>::FemBody(const BodySpec& spec, const Basis<Dim>& basis)
    : points_(spec),
      functions_(basis.functions_per_cell()),
      weight_ratio_(spec.weight_density.value_or(spec.material->density()) / spec.material->density()),
      receding_correction_(spec.receding_correction) {
  const auto n = static_cast<std::size_t>(basis.node_count());
  displacement.assign(n, {});
  velocity.assign(n, {});
  acceleration.assign(n, {});
  has_node_.assign(n, false);
  std::vector<Real> N(static_cast<std::size_t>(functions_));
  std::vector<Real> gradients(N.size() * Dim);
  for (Index cell = 0; cell < basis.cell_count(); ++cell) {
    int inside = 0;
    for (int k = 0; k < whole_power(3, Dim); ++k) {
      ElementPoint<Dim> probe{cell, {}};
      for (int d = 0, rest = k; d < Dim; ++d, rest /= 3) probe.xi[static_cast<std::size_t>(d)] = k_probes[rest % 3];
      Vec3 x{};
      const Vec<Dim> position = basis.position(probe);
      std::copy(position.begin(), position.end(), x.begin());
      inside += spec.region->contains(x) ? 1 : 0;
    }
    if (inside == 0) continue;
    if (inside < whole_power(3, Dim)) {
      const Vec<Dim> middle = basis.position({cell, {}});
      throw InputError(
          "{}: its region cuts the cell around ({:.6g}), but a body of finite elements consists of whole cells; let its sides lie on lines "
          "of the grid",
          place_of(spec), fmt::join(middle, ", "));
    }
    cells_.push_back(cell);
    Real volume = 0;
    for (const QuadraturePoint<Dim>& point : basis.quadrature(cell)) {
      places_.push_back(point.point);
      basis.evaluate(point.point, N.data(), gradients.data());
      N_.insert(N_.end(), N.begin(), N.end());
      nodes_.insert(nodes_.end(), basis.cell_nodes(cell), basis.cell_nodes(cell) + functions_);
      points_.add_point(basis.position(point.point), point.weight);
      depths_.push_back(depth_in_cell(basis, point.point));
      volume += point.weight;
    }
    cell_length_ = std::max(cell_length_, std::pow(volume, Real{1} / Dim));
    for (Index k = 0; k < functions_; ++k) has_node_[static_cast<std::size_t>(basis.cell_nodes(cell)[k])] = true;
  }
  points_.start_with(spec);
  if (cells_.empty()) throw InputError("{}: its region contains no cell of the grid; make it larger or the cells smaller", place_of(spec));
  std::vector<Index> row_of_node(n, -1);
  for (std::size_t node = 0; node < n; ++node) {
    if (!has_node_[node]) continue;
    row_of_node[node] = static_cast<Index>(nodes_of_body_.size());
    nodes_of_body_.push_back(static_cast<Index>(node));
    undeformed_.push_back(basis.node_position(static_cast<Index>(node)));
  }
  for (const Index cell : cells_) {
    for (Index k = 0; k < functions_; ++k) cell_rows_.push_back(row_of_node[static_cast<std::size_t>(basis.cell_nodes(cell)[k])]);
  }
  output_cells_ = make_cells();
  if (spec.velocity) {
    for (std::size_t node = 0; node < n; ++node) {
      if (!has_node_[node]) continue;
      Vec3 x{};
      const Vec<Dim> position = basis.node_position(static_cast<Index>(node));
      std::copy(position.begin(), position.end(), x.begin());
      const Vec3 v = spec.velocity->at(x);
      std::copy_n(v.begin(), Dim, velocity[node].begin());
    }
  }
  interpolate_motion();
}

template <int Dim>
std::vector<ElementFace> FemBody<Dim>::outer_faces(const Basis<Dim>& basis, const std::vector<bool>& is_fem_cell) const {
  std::vector<ElementFace> faces;
  for (const Index cell : cells_) {
    for (int side = 0; side < 2 * Dim; ++side) {
      const Index other = basis.neighbour(cell, side / 2, side % 2 == 1);
      if (other < 0 || !is_fem_cell[static_cast<std::size_t>(other)]) faces.push_back({cell, side / 2, side % 2 == 1});
    }
  }
  return faces;
}

template <int Dim>
void FemBody<Dim>::interpolate_motion() {
  for (std::size_t p = 0; p < places_.size(); ++p) {
    Vec<Dim> v{};
    Vec<Dim> a{};
    for (std::size_t k = 0; k < static_cast<std::size_t>(functions_); ++k) {
      const std::size_t i = p * static_cast<std::size_t>(functions_) + k;
      const auto node = static_cast<std::size_t>(nodes_[i]);
      for (std::size_t d = 0; d < Dim; ++d) {
        v[d] += N_[i] * velocity[node][d];
        a[d] += N_[i] * acceleration[node][d];
      }
    }
    points_.velocity[p] = v;
    points_.acceleration[p] = a;
  }
}

template FemBody<2>::FemBody(const BodySpec&, const Basis<2>&);
template FemBody<3>::FemBody(const BodySpec&, const Basis<3>&);
template std::vector<ElementFace> FemBody<2>::outer_faces(const Basis<2>&, const std::vector<bool>&) const;
template std::vector<ElementFace> FemBody<3>::outer_faces(const Basis<3>&, const std::vector<bool>&) const;
template void FemBody<2>::interpolate_motion();
template void FemBody<3>::interpolate_motion();

}  // namespace matpoint
