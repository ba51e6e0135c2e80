// A sparse linear system in PETSc, by rows over the ranks of an MPI communicator. Every function is for all of its ranks at once, and takes
// turns with other threads of the process.
#pragma once

#include <petscksp.h>

#include <string>
#include <vector>

#include "core/types.hpp"

namespace matpoint {

/// PETSc, and MPI under it, from the first call to the end of the program. Throws SolverError.
void start_petsc();

/// Throws SolverError with PETSc's words for a code that is none of success.
void require_petsc(PetscErrorCode code);

/// An object of PETSc, destroyed by its own function.
template <class Handle, PetscErrorCode (*destroy)(Handle*)>
class Owned {
 public:
  Owned() = default;
  Owned(const Owned&) = delete;
  Owned& operator=(const Owned&) = delete;
  ~Owned() { destroy(&handle_); }
  Handle get() const { return handle_; }
  /// For a function that makes one, in the place of what was there.
  Handle* renew() {
    destroy(&handle_);
    handle_ = nullptr;
    return &handle_;
  }

 private:
  Handle handle_ = nullptr;
};

enum class PetscMethod : int {
  gamg,  ///< Conjugate gradients (flexible GMRES where the matrix is not symmetric or not definite) with algebraic multigrid.
  mumps  ///< A factorisation.
};

/// One rank's rows, as PETSc takes them.
struct SystemRows {
  PetscInt all = 0;                  ///< Rows of all ranks.
  PetscInt block = 1;                ///< Rows of a node, which stay together.
  std::vector<PetscInt> begin;       ///< Of each row's entries, and one more.
  std::vector<PetscInt> columns;     ///< Ascending in each row.
  std::vector<PetscScalar> values;   ///< Of the entries.
  std::vector<PetscReal> positions;  ///< `block` numbers per node [m]; empty: unknown.
  std::vector<PetscScalar> scales;   ///< The unknowns of the system are the true ones over these.
  PetscInt count() const { return static_cast<PetscInt>(begin.size()) - 1; }
};

class PetscSystem {
 public:
  /// `options`: PETSc's own, which go before ours. Throws InputError for options that PETSc cannot read.
  PetscSystem(MPI_Comm comm, PetscMethod method, Real tolerance, const std::string& options);
  ~PetscSystem();
  PetscSystem(const PetscSystem&) = delete;
  PetscSystem& operator=(const PetscSystem&) = delete;

  /// With the rows, which must live until the last solve. False when the matrix is singular.
  bool set_up(const SystemRows& rows, bool is_symmetric);
  /// Of this rank's rows. False when no solution was found.
  bool solve(const std::vector<PetscScalar>& right, std::vector<PetscScalar>& result);
  /// Of the last solve.
  int iterations() const { return iterations_; }
  /// Throws InputError for options that no solve so far has used.
  void refuse_unused_options() const;

 private:
  /// A way to precondition by multigrid; for factorisations the only one.
  struct Smoother {
    std::string options;
    int iterations_max;
  };
  bool set_up_krylov(KSPType type, const Smoother& smoother);
  KSPConvergedReason solve_krylov(::Vec b, ::Vec x);
  void set_rigid_motions(const SystemRows& rows);

  MPI_Comm comm_;
  PetscMethod method_;
  Real tolerance_;
  std::vector<std::string> asked_;   ///< The names of the given options.
  std::vector<Smoother> smoothers_;  ///< In the order in which they are tried.
  bool is_symmetric_ = false;
  PetscInt block_ = 1;
  PetscInt all_ = 0;
  int iterations_ = 0;
  Owned<PetscOptions, PetscOptionsDestroy> options_;
  Owned<Mat, MatDestroy> matrix_;
  Owned<KSP, KSPDestroy> krylov_;
};

}  // namespace matpoint
