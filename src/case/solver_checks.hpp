// Which solver a case asks for, and what the two can and cannot do with the rest of it.
#pragma once

#include "case/case.hpp"

namespace matpoint {

/// Declares [solver], whose keys depend on its type.
void declare_solver(ParameterTable<Case>& table);
/// What a case leaves open and what depends on the rest of it: linear shape functions for what only these do, and whether bodies turn
/// rigidly and fluids are corrected.
void choose_scheme(Case& problem, const Input& input);
/// What the chosen solver can and cannot do with the rest of the case. Throws InputError.
void check_for_solver(const Case& problem, const Input& input);

}  // namespace matpoint
