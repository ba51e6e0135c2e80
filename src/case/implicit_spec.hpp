// The section [solver] of a case with type = "implicit".
#pragma once

#include "core/parameters.hpp"

namespace matpoint {

enum class BasisKind { bspline, element };
enum class ImplicitMode { dynamic, quasi_static };
enum class InitialAcceleration { consistent, zero };
enum class StepHalving { inversion, residual };
/// How bodies of particles meet: in one field of displacements, or each in its own, by forces between pairs of particles.
enum class ImplicitContact { single_field, pairs };

struct ImplicitSpec {
  std::string type = "implicit";
  ImplicitMode mode = ImplicitMode::dynamic;
  BasisKind basis = BasisKind::bspline;
  int element_order = 2;
  Real beta = 0.3;
  Real gamma = 0.5;
  InitialAcceleration initial_acceleration = InitialAcceleration::consistent;
  std::vector<Real> soft_stiffness = {1e-6, 1e-10};  ///< C_1, C_2 [1]
  ImplicitContact contact = ImplicitContact::single_field;
  Real friction = 0;           ///< Between bodies in fields of their own [1].
  Real contact_stiffness = 1;  ///< Over the modulus of the softer body [1].
  Real surface_penalty = 0;    ///< gamma of implicit/surface_faces.hpp, on splines [1].
  Real increment_tolerance = 1e-9;
  Real increment_absolute = 1e-13;
  Real residual_tolerance = 1e-14;
  Real residual_absolute = 0;
  int iterations_max = 20;
  int step_cuts_max = 8;
  StepHalving halving = StepHalving::inversion;
  std::string linear_solver = "auto";
  Real linear_tolerance = 1e-10;
  std::string petsc;  ///< Options of its methods.
  static void declare(ParameterTable<ImplicitSpec>& table);
};

/// What goes beyond single values. Throws InputError.
void check_implicit(ImplicitSpec& solver, const Input& input, const ReadContext& context);

}  // namespace matpoint
