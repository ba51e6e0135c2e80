#include "run/make_solver.hpp"

#include <new>

#include "core/error.hpp"
#include "explicit/explicit_solver.hpp"
#include "implicit/implicit_solver.hpp"

namespace matpoint {

std::unique_ptr<Solver> make_solver(const Case& problem) {
  try {
    return problem.is_implicit() ? make_implicit_solver(problem) : make_explicit_solver(problem);
  } catch (const std::bad_alloc&) {
    throw InputError("the case does not fit into this machine's memory; `matpoint check` says how many particles and nodes it has");
  }
}

}  // namespace matpoint
