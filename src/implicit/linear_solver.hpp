// Sparse linear systems behind one small interface: the direct solvers of SuiteSparse where the build has them, Eigen's otherwise, and
// preconditioned Krylov methods; those of PETSc in a build with it.
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

/// Where the unknowns are: what a method goes by that makes coarser systems.
struct UnknownPlaces {
  int dim = 0;                  ///< Components of a node; 0: nothing is known.
  std::vector<int> unknowns;    ///< By node and component, ascending: the unknown, or -1 where the component is prescribed.
  std::vector<Real> positions;  ///< `dim` numbers per node [m].
};

class LinearSolver {
 public:
  virtual ~LinearSolver() = default;

  /// The method of the last factorisation, e.g. "umfpack".
  virtual std::string name() const = 0;
  /// Before analyze(), for methods with needs_places().
  virtual void place(UnknownPlaces) {}
  virtual bool needs_places() const { return false; }
  /// Looks at the places of the entries: once for all matrices with the same places.
  virtual void analyze(const SparseMatrix& K) = 0;
  /// Prepares for K, which must live until the last solve. False when the matrix is singular (or, for a symmetric method, not definite).
  virtual bool factorize(const SparseMatrix& K, Symmetry symmetry) = 0;
  /// K x = b; `x` holds a guess, which iterative methods start from. False when no solution was found.
  virtual bool solve(const Vector& b, Vector& x) = 0;
  /// The least pivot of the last factorisation over the greatest: an estimate of 1 over the condition number; 0 where it is not known.
  virtual Real pivot_ratio() { return 0; }
  /// Of the last solve by an iterative method; 0 of a direct one.
  virtual int iterations() const { return 0; }
};

/// Whether x solves K x = b, to far less than a factorisation reaches: a nearly singular matrix is found by what it yields.
bool is_solved(const SparseMatrix& K, const Vector& b, const Vector& x);

/// "auto": a Cholesky factorisation where the matrix is symmetric and definite, else an LU factorisation. `tolerance`: relative residual of
/// the iterative methods. `petsc_options`: for the methods of PETSc (petsc_solver.hpp).
std::unique_ptr<LinearSolver> make_linear_solver(const std::string& name, Real tolerance, const std::string& petsc_options = "");

/// Ranks that share the linear solves; 1 where mpirun has started none, and in a build without MPI.
int linear_solver_ranks();
/// To be called first thing in a program: on a rank that mpirun has started beside the first one, works on its linear systems until it ends
/// (petsc_solver.hpp), and returns true.
bool works_for_first_rank();

}  // namespace matpoint
