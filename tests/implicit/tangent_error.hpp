// How exact the matrix of the implicit solver is.
#pragma once

#include "implicit/implicit_solver.hpp"

namespace matpoint::test {

/// The largest entry of the matrix's error against central differences, over the largest entry.
template <int Dim>
Real tangent_error(ImplicitSolver<Dim>& solver, const StepLoad<Dim>& load, const std::vector<Real>& u) {
  Assembly<Dim>& assembly = solver.assembly();
  const StepSpace<Dim>& space = solver.space();
  std::vector<Real> residual, up, down;
  Lift lift;
  assembly.residual_and_matrix(u, load, residual, lift);
  const Eigen::MatrixXd matrix = assembly.matrix();
  const Real step = 1e-7;
  Real worst = 0;
  for (std::size_t k = 0; k < u.size(); ++k) {
    const int column = space.unknown(static_cast<Index>(k / Dim), static_cast<int>(k % Dim));
    if (column < 0) continue;
    std::vector<Real> moved = u;
    moved[k] = u[k] + step;
    assembly.residual(moved, load, up);
    moved[k] = u[k] - step;
    assembly.residual(moved, load, down);
    for (std::size_t i = 0; i < u.size(); ++i) {
      const int row = space.unknown(static_cast<Index>(i / Dim), static_cast<int>(i % Dim));
      if (row >= 0) worst = std::max(worst, std::abs(matrix(row, column) - (up[i] - down[i]) / (2 * step)));
    }
  }
  return worst / matrix.cwiseAbs().maxCoeff();
}

}  // namespace matpoint::test
