// What a case asks for and probably does not want: found before the run, each in one sentence with the setting that would do.
#pragma once

#include "case/case.hpp"
#include "solver/solver.hpp"

namespace matpoint {

/// Of the explicit solver; none for the implicit one, which has its own warnings. `solver` is as it was made, before its first step.
std::vector<std::string> risks_of(const Case& problem, const Solver& solver);

}  // namespace matpoint
