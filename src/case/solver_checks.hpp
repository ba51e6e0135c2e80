// Which solver a case asks for, and what the two can and cannot do with the rest of it.
#pragma once

#include "case/case.hpp"

namespace matpoint {

/// Declares [solver], whose keys depend on its type.
void declare_solver(ParameterTable<Case>& table);
/// Linear shape functions for a case that names none and asks for what only these do.
void choose_shape(Case& problem, const Input& input);
/// What the chosen solver can and cannot do with the rest of the case. Throws InputError.
void check_for_solver(const Case& problem, const Input& input);

}  // namespace matpoint
