// Sparse linear systems behind one small interface: the direct solvers of SuiteSparse where the build has them, Eigen's otherwise, and
// preconditioned Krylov methods.
#pragma once

#include <Eigen/SparseCore>
#include <memory>
#include <string>
#include <vector>

#include "case/linear_solver_names.hpp"
#include "core/types.hpp"

namespace matpoint {

using SparseMatrix = Eigen::SparseMatrix<Real>;
using Vector = Eigen::VectorXd;

enum class Symmetry { general, symmetric };

class LinearSolver {
 public:
  virtual ~LinearSolver() = default;

  /// The method of the last factorisation, e.g. "umfpack".
  virtual std::string name() const = 0;
  /// Looks at the places of the entries: once for all matrices with the same places.
  virtual void analyze(const SparseMatrix& K) = 0;
  /// Prepares for K, which must live until the last solve. False when the matrix is singular (or, for a symmetric method, not definite).
  virtual bool factorize(const SparseMatrix& K, Symmetry symmetry) = 0;
  /// K x = b; `x` holds a guess, which iterative methods start from. False when no solution was found.
  virtual bool solve(const Vector& b, Vector& x) = 0;
  /// The least pivot of the last factorisation over the greatest: an estimate of 1 over the condition number; 0 where it is not known.
  virtual Real pivot_ratio() { return 0; }
};

/// "auto": a Cholesky factorisation where the matrix is symmetric and definite, else an LU factorisation. `tolerance`: relative residual of
/// the iterative methods.
std::unique_ptr<LinearSolver> make_linear_solver(const std::string& name, Real tolerance);

}  // namespace matpoint
