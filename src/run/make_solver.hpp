// From a case to the solver that it asks for.
#pragma once

#include <memory>

#include "case/case.hpp"
#include "solver/solver.hpp"

namespace matpoint {

/// Makes the bodies' particles, checks that they fit the grid, and returns a solver ready for its first step. Throws InputError.
std::unique_ptr<Solver> make_solver(const Case& problem);

/// To be called by a program before it runs a case: on a rank that mpirun has started beside the first one, works on that one's linear
/// systems until it ends, and returns true: the rank has nothing else to do.
bool has_worked_for_first_rank();

}  // namespace matpoint
