#include "case/implicit_spec.hpp"

#include <algorithm>

#include "case/case_reading.hpp"
#include "case/linear_solver_names.hpp"

namespace matpoint {

void check_implicit(ImplicitSpec& solver, const Input& input, const ReadContext& context) {
  if (solver.soft_stiffness.size() != 2) {
    fail_input(at_key(input, "soft_stiffness"), context,
               fmt::format("soft_stiffness has {} numbers, it must have 2: C_1 of cells with few inner nodes and C_2 of the others",
                           solver.soft_stiffness.size()));
  }
  if (2 * solver.beta < solver.gamma) {
    fail_input(at_key(input, "beta"), context,
               fmt::format("beta = {} is below gamma / 2 = {}: Newmark's method would be stable for short steps only", solver.beta,
                           solver.gamma / 2));
  }
  if (is_given(input, "element_order") && solver.basis != BasisKind::element)
    fail_input(at_key(input, "element_order"), context, "element_order is for basis = \"element\" only");
  if (solver.surface_penalty > 0 && solver.basis == BasisKind::element) {
    fail_input(at_key(input, "surface_penalty"), context,
               fmt::format("surface_penalty = {} is for basis = \"bspline\" only: elements have no smooth second derivatives",
                           solver.surface_penalty));
  }
  if (solver.contact == ImplicitContact::single_field) {
    for (const char* key : {"friction", "contact_stiffness"}) {
      if (is_given(input, key))
        fail_input(at_key(input, key), context, fmt::format("{} is for contact = \"pairs\": in one field bodies stick", key));
    }
  }
  if (solver.friction > 0 && (solver.linear_solver == "ldlt" || solver.linear_solver == "cholmod" || solver.linear_solver == "cg")) {
    fail_input(at_key(input, "linear_solver"), context,
               fmt::format("friction makes the matrix unsymmetric, and linear_solver = \"{}\" is for symmetric ones; use \"auto\"",
                           solver.linear_solver));
  }
  if (const std::string missing = missing_package(solver.linear_solver); !missing.empty()) {
    fail_input(at_key(input, "linear_solver"), context,
               fmt::format("linear_solver = \"{}\" is not in this program, which was built without {}{}; it has {}", solver.linear_solver,
                           missing, missing == "PETSc" ? " (-DMATPOINT_MPI=ON builds it in)" : "", list_names(linear_solver_names())));
  }
  check_words({solver.linear_solver}, "linear_solver", linear_solver_names(), input, context);
  if (!solver.petsc.empty() && !is_of_petsc(solver.linear_solver)) {
    fail_input(at_key(input, "petsc"), context,
               fmt::format("petsc holds options for linear_solver = \"gamg\" or \"mumps\", and it is \"{}\"", solver.linear_solver));
  }
}

void ImplicitSpec::declare(ParameterTable<ImplicitSpec>& table) {
  table.optional("type", "1", &ImplicitSpec::type, any_number(), "\"implicit\".");
  table.choice("mode", &ImplicitSpec::mode, {{"dynamic", ImplicitMode::dynamic}, {"static", ImplicitMode::quasi_static}},
               "dynamic: Newmark's method in time; static: no inertia, time is the load parameter and dt the load step.");
  table.choice("basis", &ImplicitSpec::basis, {{"bspline", BasisKind::bspline}, {"element", BasisKind::element}},
               "Functions of the background: quadratic B-splines on equal cells, or Lagrange elements.");
  table.custom(
      {"element_order", "1", "integer", "2", "in the interval [1, 2]",
       "Of basis = \"element\": 1 for corner nodes only, 2 for 9-node (27-node) elements.", false},
      [](ImplicitSpec& solver, const Input& input, const ReadContext& context) {
        read_value(input, context, "element_order", between_closed(1, 2), solver.element_order);
      },
      [](const ImplicitSpec& solver, int) -> std::optional<Input> {
        if (solver.basis != BasisKind::element) return std::nullopt;
        return Input::integer(solver.element_order);
      });
  table.optional("beta", "1", &ImplicitSpec::beta, between_closed(0.25, 1),
                 "Newmark's beta. 0.25 conserves best, but lets velocities that the grid cannot see grow; 0.3 bounds them.");
  table.optional("gamma", "1", &ImplicitSpec::gamma, between_closed(0.5, 1), "Newmark's gamma; above 0.5 it damps, and is first order.");
  table.choice("initial_acceleration", &ImplicitSpec::initial_acceleration,
               {{"consistent", InitialAcceleration::consistent}, {"zero", InitialAcceleration::zero}},
               "Accelerations before the first step: from the forces, or none.");
  table.choice("contact", &ImplicitSpec::contact, {{"single_field", ImplicitContact::single_field}, {"pairs", ImplicitContact::pairs}},
               "How bodies of particles meet: in one field of displacements, where they stick; or each in its own, where they touch, slide "
               "and part, by forces between pairs of particles (pairs).");
  table.custom(
      {"friction", "1", "number", "0", ">= 0", "Coulomb's coefficient between the bodies of contact = \"pairs\".", false},
      [](ImplicitSpec& solver, const Input& input, const ReadContext& context) {
        read_value(input, context, "friction", non_negative(), solver.friction);
      },
      [](const ImplicitSpec& solver, int) -> std::optional<Input> {
        if (solver.contact == ImplicitContact::single_field) return std::nullopt;
        return Input::real(solver.friction);
      });
  table.custom(
      {"contact_stiffness", "1", "number", "1", "> 0",
       "Of contact = \"pairs\": how stiff surfaces are, over the modulus rho c^2 of the softer body.", false},
      [](ImplicitSpec& solver, const Input& input, const ReadContext& context) {
        read_value(input, context, "contact_stiffness", positive(), solver.contact_stiffness);
      },
      [](const ImplicitSpec& solver, int) -> std::optional<Input> {
        if (solver.contact == ImplicitContact::single_field) return std::nullopt;
        return Input::real(solver.contact_stiffness);
      });
  table.optional(
      "soft_stiffness", "1", &ImplicitSpec::soft_stiffness, non_negative(),
      "C_1, C_2: shares of the shear modulus that hold nodes in partly filled cells, with fewer than 5 (5 to 8) of 9 inner nodes.");
  table.optional("surface_penalty", "1", &ImplicitSpec::surface_penalty, non_negative(),
                 "On B-splines: on jumps of second derivatives at the body's surface, which keeps functions in thin cuts calm; 10 does for "
                 "beams and dynamics, 0: none.");
  table.optional("increment_tolerance", "1", &ImplicitSpec::increment_tolerance, between(0, 1),
                 "Newton's method has converged when an increment is below this share of the step's displacement.");
  table.optional("increment_absolute", "m", &ImplicitSpec::increment_absolute, non_negative(),
                 "The same for displacements (the norm over all nodes) as small as this.");
  table.optional("residual_tolerance", "1", &ImplicitSpec::residual_tolerance, non_negative(),
                 "Or when the residual is below this share of the forces at the nodes, about what rounding leaves of it.");
  table.optional("residual_absolute", "N", &ImplicitSpec::residual_absolute, non_negative(),
                 "Or when the residual's norm is below this force.");
  table.optional("iterations_max", "1", &ImplicitSpec::iterations_max, between_closed(1, 1000),
                 "After so many iterations without convergence the step is halved.");
  table.optional("step_cuts_max", "1", &ImplicitSpec::step_cuts_max, between_closed(0, 30),
                 "How often a step is halved before the run fails.");
  table.choice(
      "halving", &ImplicitSpec::halving, {{"inversion", StepHalving::inversion}, {"residual", StepHalving::residual}},
      "When an increment is halved: inversion: where it would turn a particle inside out; residual: also where it would not reduce the "
      "residual, which is slow where bodies are slender.");
  table.optional("linear_solver", "1", &ImplicitSpec::linear_solver, any_number(),
                 "auto, umfpack, cholmod (with SuiteSparse), ldlt, sparse_lu, cg, bicgstab or gmres; gamg, mumps (with PETSc).");
  table.optional("linear_tolerance", "1", &ImplicitSpec::linear_tolerance, between(0, 1),
                 "Relative residual of the iterative linear solvers.");
  table.custom(
      {"petsc", "1", "string", "\"\"", "",
       "Options for PETSc, as on its command lines (\"-ksp_monitor\"), of linear_solver = \"gamg\" or \"mumps\".", false},
      [](ImplicitSpec& solver, const Input& input, const ReadContext& context) {
        read_value(input, context, "petsc", any_number(), solver.petsc);
      },
      [](const ImplicitSpec& solver, int) -> std::optional<Input> {
        if (solver.petsc.empty()) return std::nullopt;
        return Input::string(solver.petsc);
      });
}

}  // namespace matpoint
