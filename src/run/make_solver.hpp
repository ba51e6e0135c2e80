// From a case to the solver that it asks for.
#pragma once

#include <memory>

#include "case/case.hpp"
#include "solver/solver.hpp"

namespace matpoint {

/// Makes the bodies' particles, checks that they fit the grid, and returns a solver ready for its first step. Throws InputError.
std::unique_ptr<Solver> make_solver(const Case& problem);

}  // namespace matpoint
