// Which methods for linear systems this program has: what a case may name, so that reading one needs no linear algebra.
#pragma once

#include <string>
#include <vector>

namespace matpoint {

/// Names of the methods in this build, "auto" first.
const std::vector<std::string>& linear_solver_names();
/// Names that another build has.
const std::vector<std::string>& missing_linear_solver_names();

}  // namespace matpoint
