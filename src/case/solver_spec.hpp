// The section [solver] of a case with type = "explicit".
#pragma once

#include <optional>

#include "core/parameters.hpp"
#include "kernel/shape_kind.hpp"

namespace matpoint {

enum class StressOrder { usl, usf, musl };
/// How velocities go from the grid to the particles and back.
enum class Transfer { flip, pic, apic, tpic, fmpm };
/// How bodies meet: in one velocity field, or each with its own, and impulses at the nodes or forces between pairs of particles.
enum class ContactMethod { single_field, multi_field, pairs };

struct SolverSpec {
  std::string type = "explicit";
  StressOrder stress_order = StressOrder::musl;
  ShapeKind shape = ShapeKind::bspline2;
  Transfer transfer = Transfer::flip;
  ContactMethod contact = ContactMethod::single_field;
  Real friction = 0;           ///< Between bodies with velocity fields of their own [1].
  Real contact_stiffness = 1;  ///< Of contact = "pairs": over the modulus of the softer body [1].
  Real flip = 1;
  /// Bodies are mapped in the frame that turns with them, and fluids kept evenly filled and free of what the grid does not see. Chosen by
  /// choose_scheme where they are not given.
  std::optional<bool> co_rotating;
  std::optional<bool> fluid_correction;
  int fmpm_order = 2;  ///< Of transfer = "fmpm": terms of the series for the inverse of the mass matrix.
  Real damping = 0;
  Real mass_cutoff_relative = 0;
  std::optional<Real> mass_cutoff;
  std::string mass_cutoff_place;  ///< Where either of the two stands in the case file, for messages.
  std::string precision = "double";
  std::optional<Real> quality_cfl;  ///< What quality chose; choose_scheme then shortens the steps.
  static void declare(ParameterTable<SolverSpec>& table);
};

/// What goes beyond single values. Throws InputError.
void check_solver(SolverSpec& solver, const Input& input, const ReadContext& context);

}  // namespace matpoint
