// Which methods for linear systems this program has: what a case may name, so that reading one needs no linear algebra.
#pragma once

#include <string>
#include <vector>

namespace matpoint {

/// Names of the methods in this build, "auto" first.
const std::vector<std::string>& linear_solver_names();
/// What a build must have for a method that this one has not, e.g. "SuiteSparse"; empty for other names.
std::string missing_package(const std::string& linear_solver);
/// Whether a method factorises the matrices of large 3D problems, too, whose memory grows with the 4/3rd power of the unknowns.
bool factorizes_large(const std::string& linear_solver);
/// Whether a method is one of PETSc's, which read its options.
bool is_of_petsc(const std::string& linear_solver);

}  // namespace matpoint
