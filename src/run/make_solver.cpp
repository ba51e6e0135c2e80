#include "run/make_solver.hpp"

#include <new>

#include "case/linear_solver_names.hpp"
#include "core/error.hpp"
#include "explicit/explicit_solver.hpp"
#include "implicit/implicit_solver.hpp"

namespace matpoint {
namespace {

/// What several ranks can share is the linear solves of PETSc.
void check_ranks(const Case& problem) {
  const int ranks = linear_solver_ranks();
  if (ranks == 1) return;
  if (!problem.is_implicit())
    throw InputError("mpirun has started {} ranks, and the explicit solver runs in one process, on threads: start it without mpirun",
                     ranks);
  const std::string& method = problem.implicit.linear_solver;
  if (method != "auto" && !is_of_petsc(method))
    throw InputError("mpirun has started {} ranks, and linear_solver = \"{}\" works on one: use \"auto\", \"gamg\" or \"mumps\"", ranks,
                     method);
}

}  // namespace

std::unique_ptr<Solver> make_solver(const Case& problem) {
  check_ranks(problem);
  try {
    return problem.is_implicit() ? make_implicit_solver(problem) : make_explicit_solver(problem);
  } catch (const std::bad_alloc&) {
    throw InputError("the case does not fit into this machine's memory; `matpoint check` says how many particles and nodes it has");
  }
}

bool has_worked_for_first_rank() { return works_for_first_rank(); }

}  // namespace matpoint
