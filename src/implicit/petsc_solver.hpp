// Linear systems by PETSc, in programs that are built with it (-DMATPOINT_MPI=ON): algebraic multigrid for what a factorisation has no
// memory for, and MUMPS. The files petsc_* are all that know PETSc and MPI.
//
// Started by mpirun on several ranks, the first one runs the simulation and makes the matrices; the others do nothing but their share of
// each linear solve, which is where large implicit problems spend their time.
#pragma once

#include "implicit/linear_solver.hpp"

namespace matpoint {

/// "gamg" or "mumps". `options`: PETSc's own, as on a command line ("-ksp_monitor -mg_levels_ksp_max_it 3"); they go before ours. Throws
/// InputError for options that PETSc cannot read or, after the first solve, that nothing has used.
std::unique_ptr<LinearSolver> make_petsc_solver(const std::string& name, Real tolerance, const std::string& options);

/// Ranks that share the solves: 1 before join_petsc_ranks().
int petsc_rank_count();
/// To be called first thing: where mpirun has started several ranks, starts MPI, and on all ranks but the first works for that one, until
/// it ends. Returns whether this was such a rank, which then has nothing more to do.
bool join_petsc_ranks();

}  // namespace matpoint
