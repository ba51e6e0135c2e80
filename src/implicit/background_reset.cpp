#include "implicit/background_reset.hpp"

#include "core/error.hpp"

namespace matpoint {

template <int Dim>
void add_symmetric_gradient_stiffness(const Basis<Dim>& basis, Index cell, Real factor, Real* K) {
  const int functions = basis.functions_per_cell();
  std::vector<Real> N(static_cast<std::size_t>(functions));
  std::vector<Real> g(N.size() * Dim);
  for (const QuadraturePoint<Dim>& point : basis.quadrature(cell)) {
    basis.evaluate(point.point, N.data(), g.data());
    const Real weight = factor * point.weight;
    for (int I = 0; I < functions; ++I) {
      for (int J = 0; J < functions; ++J) {
        Real product = 0;
        for (int d = 0; d < Dim; ++d) product += g[static_cast<std::size_t>(I * Dim + d)] * g[static_cast<std::size_t>(J * Dim + d)];
        for (int i = 0; i < Dim; ++i) {
          Real* const row = K + static_cast<std::size_t>((I * Dim + i) * functions * Dim + J * Dim);
          row[i] += weight * product;
          for (int k = 0; k < Dim; ++k)
            row[k] += weight * g[static_cast<std::size_t>(I * Dim + k)] * g[static_cast<std::size_t>(J * Dim + i)];
        }
      }
    }
  }
}

template <int Dim>
BackgroundReset<Dim>::BackgroundReset(const Basis<Dim>& basis, const NodeConditions<Dim>& conditions, const StepSpace<Dim>& space) {
  const auto n = static_cast<std::size_t>(basis.node_count());
  for (std::size_t node = 0; node < n; ++node) X_.push_back(basis.node_position(static_cast<Index>(node)));
  unknowns_.assign(n * Dim, -1);
  const auto functions = static_cast<std::size_t>(basis.functions_per_cell());
  const std::size_t width = functions * Dim;
  for (Index cell = 0; cell < basis.cell_count(); ++cell) {
    if (space.is_fem_cell()[static_cast<std::size_t>(cell)]) continue;
    for (std::size_t k = 0; k < functions; ++k) {
      const Index node = basis.cell_nodes(cell)[k];
      for (int d = 0; d < Dim; ++d) {
        if (!space.is_fem_node(node) && conditions.condition(node, d) < 0) unknowns_[static_cast<std::size_t>(node * Dim + d)] = 0;
      }
    }
  }
  for (int& unknown : unknowns_) {
    if (unknown == 0) unknown = unknown_count_++;
  }
  if (unknown_count_ == 0) return;
  std::vector<Eigen::Triplet<Real>> inner;
  std::vector<Eigen::Triplet<Real>> outer;
  std::vector<Real> K(width * width);
  for (Index cell = 0; cell < basis.cell_count(); ++cell) {
    if (space.is_fem_cell()[static_cast<std::size_t>(cell)]) continue;
    std::fill(K.begin(), K.end(), 0);
    add_symmetric_gradient_stiffness<Dim>(basis, cell, 1, K.data());
    const auto number = [&](std::size_t local) {
      return static_cast<std::size_t>(basis.cell_nodes(cell)[local / Dim]) * Dim + local % Dim;
    };
    for (std::size_t row = 0; row < width; ++row) {
      const int r = unknowns_[number(row)];
      if (r < 0) continue;
      for (std::size_t column = 0; column < width; ++column) {
        const int c = unknowns_[number(column)];
        if (c >= 0)
          inner.emplace_back(r, c, K[row * width + column]);
        else
          outer.emplace_back(r, static_cast<int>(number(column)), K[row * width + column]);
      }
    }
  }
  SparseMatrix stiffness(unknown_count_, unknown_count_);
  stiffness.setFromTriplets(inner.begin(), inner.end());
  coupling_.resize(unknown_count_, static_cast<Eigen::Index>(n * Dim));
  coupling_.setFromTriplets(outer.begin(), outer.end());
  factorization_.compute(stiffness);
  if (factorization_.info() != Eigen::Success)
    throw InputError("the background around the bodies of elements is held by nothing; fix a side of the grid");
}

template <int Dim>
std::vector<Vec<Dim>> BackgroundReset<Dim>::positions(const std::vector<PointSource<Dim>>& sources) const {
  Vector given = Vector::Zero(static_cast<Eigen::Index>(X_.size() * Dim));
  for (const PointSource<Dim>& source : sources) {
    if (source.fem == nullptr) continue;
    for (std::size_t node = 0; node < X_.size(); ++node) {
      if (!source.fem->has_node(static_cast<Index>(node))) continue;
      for (std::size_t d = 0; d < Dim; ++d) given[static_cast<Eigen::Index>(node * Dim + d)] = source.fem->displacement[node][d];
    }
  }
  Vector free = Vector::Zero(unknown_count_);
  if (unknown_count_ > 0) free = factorization_.solve(Vector(-(coupling_ * given)));
  std::vector<Vec<Dim>> moved = X_;
  for (std::size_t k = 0; k < unknowns_.size(); ++k)
    moved[k / Dim][k % Dim] += unknowns_[k] >= 0 ? free[unknowns_[k]] : given[static_cast<Eigen::Index>(k)];
  return moved;
}

template void add_symmetric_gradient_stiffness<2>(const Basis<2>&, Index, Real, Real*);
template void add_symmetric_gradient_stiffness<3>(const Basis<3>&, Index, Real, Real*);
template class BackgroundReset<2>;
template class BackgroundReset<3>;

}  // namespace matpoint
