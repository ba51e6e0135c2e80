#include "case/solver_spec.hpp"

#include "case/case_reading.hpp"

namespace matpoint {
namespace {

/// All take what does most of the everyday problems rightly (docs/choices.md), which is what a case has that says nothing.
void read_quality(SolverSpec& solver, const Input& input, const ReadContext& context) {
  const std::string given = input.kind() == Input::Kind::string ? input.as_string() : "";
  check_words({given}, "quality", {"robust", "accurate", "fast"}, input, context);
  solver.quality_cfl.reset();
  if (given == "robust") solver.quality_cfl = 0.1;
  if (given == "accurate") solver.quality_cfl = 0.2;
  if (given == "fast") solver.precision = "single";
}

}  // namespace

void check_solver(SolverSpec& solver, const Input& input, const ReadContext& context) {
  check_words({solver.type}, "type", {"explicit", "implicit"}, input, context);
  check_words({solver.precision}, "precision", {"double", "single"}, input, context);
  solver.mass_cutoff_place = at_key(input, solver.mass_cutoff ? "mass_cutoff" : "mass_cutoff_relative").place();
  if (solver.transfer != Transfer::flip && is_given(input, "flip"))
    fail_input(at_key(input, "flip"), context, "flip is the share of FLIP in transfer = \"flip\"; leave it out with the others");
  if (solver.transfer != Transfer::fmpm && is_given(input, "fmpm_order"))
    fail_input(at_key(input, "fmpm_order"), context, "fmpm_order is for transfer = \"fmpm\" only");
  if (solver.contact == ContactMethod::single_field && is_given(input, "friction"))
    fail_input(at_key(input, "friction"), context,
               "friction is for contact = \"multi_field\" or \"pairs\": in one velocity field bodies stick");
  if (solver.contact != ContactMethod::pairs && is_given(input, "contact_stiffness"))
    fail_input(at_key(input, "contact_stiffness"), context, "contact_stiffness is for contact = \"pairs\" only");
  if (solver.mass_cutoff && is_given(input, "mass_cutoff_relative")) {
    fail_input(at_key(input, "mass_cutoff_relative"), context, "mass_cutoff and mass_cutoff_relative are both given; give one of them");
  }
}

void SolverSpec::declare(ParameterTable<SolverSpec>& table) {
  // First, so that keys after it override what it chooses; it is written as what it chose.
  table.custom({"quality", "1", "string", "", "\"accurate\" or \"fast\"",
                "Where they are not given: time.cfl = 0.2 (accurate), or precision = \"single\" (fast). The rest of the scheme is chosen "
                "well as it is.",
                false},
               read_quality, [](const SolverSpec&, int) -> std::optional<Input> { return std::nullopt; });
  table.optional("type", "1", &SolverSpec::type, any_number(), "\"explicit\" or \"implicit\".");
  table.choice("stress_order", &SolverSpec::stress_order,
               {{"usl", StressOrder::usl}, {"usf", StressOrder::usf}, {"musl", StressOrder::musl}},
               "When a step updates the stress: last (usl), first (usf), or last from velocities mapped once more (musl).");
  table.choice(
      "shape", &SolverSpec::shape,
      {{"linear", ShapeKind::linear},
       {"bspline2", ShapeKind::bspline2},
       {"bspline3", ShapeKind::bspline3},
       {"gimp", ShapeKind::gimp},
       {"cpdi", ShapeKind::cpdi}},
      "Shape functions of the grid: linear, quadratic or cubic B-splines that are clamped at the sides, or linear averaged over the "
      "particles' domains, which keep their shape (gimp: uGIMP) or deform with the particles (cpdi). Where none is given: linear with "
      "output.grid or contact = \"multi_field\", else bspline2 where something flows (fluids, soils, grains, muds), else "
      "gimp, and gimp with periodic sides.");
  table.choice(
      "transfer", &SolverSpec::transfer,
      {{"flip", Transfer::flip}, {"pic", Transfer::pic}, {"apic", Transfer::apic}, {"tpic", Transfer::tpic}, {"fmpm", Transfer::fmpm}},
      "How velocities reach the particles: their changes (flip), themselves (pic), with an affine part (apic, tpic), or by a better "
      "inverse "
      "of the mass matrix (fmpm). Where none is given: apic where there are soils, grains or muds and the shape is not linear (tpic with "
      "cpdi), else flip.");
  table.custom(
      {"flip", "1", "number", "1", "0 <= value <= 1", "Of transfer = \"flip\": its share in the particles' velocity; the rest is PIC.",
       false},
      [](SolverSpec& solver, const Input& input, const ReadContext& context) {
        read_value(input, context, "flip", between_closed(0, 1), solver.flip);
      },
      [](const SolverSpec& solver, int) -> std::optional<Input> {
        if (solver.transfer != Transfer::flip) return std::nullopt;
        return Input::real(solver.flip);
      });
  table.optional(
      "co_rotating", "1", &SolverSpec::co_rotating, any_number(),
      "Whether velocities are mapped in the frame that turns with each body, so that what turns goes on turning. Where it is not "
      "given: with transfer = \"flip\", but for linear shapes and stress_order = \"usf\".");
  table.optional("fluid_correction", "1", &SolverSpec::fluid_correction, any_number(),
                 "Whether the particles of fluids are moved apart where they are too dense, and freed (transfer = \"flip\", flip = 1) of "
                 "motion that the grid does not see. Where it is not given: with B-splines and GIMP.");
  table.custom(
      {"fmpm_order", "1", "integer", "2", "1 <= value <= 20",
       "Of transfer = \"fmpm\": terms of the series for the inverse of the mass matrix; 1 is PIC.", false},
      [](SolverSpec& solver, const Input& input, const ReadContext& context) {
        read_value(input, context, "fmpm_order", between_closed(1, 20), solver.fmpm_order);
      },
      [](const SolverSpec& solver, int) -> std::optional<Input> {
        if (solver.transfer != Transfer::fmpm) return std::nullopt;
        return Input::integer(solver.fmpm_order);
      });
  table.choice(
      "contact", &SolverSpec::contact,
      {{"single_field", ContactMethod::single_field}, {"multi_field", ContactMethod::multi_field}, {"pairs", ContactMethod::pairs}},
      "How bodies meet: in one velocity field, where they stick; or each in its own, where they touch, slide and part, by impulses at "
      "the nodes (multi_field) or by forces between pairs of particles (pairs).");
  table.custom(
      {"friction", "1", "number", "0", ">= 0", "Coulomb's coefficient between the bodies of contact = \"multi_field\" or \"pairs\".",
       false},
      [](SolverSpec& solver, const Input& input, const ReadContext& context) {
        read_value(input, context, "friction", non_negative(), solver.friction);
      },
      [](const SolverSpec& solver, int) -> std::optional<Input> {
        if (solver.contact == ContactMethod::single_field) return std::nullopt;
        return Input::real(solver.friction);
      });
  table.custom(
      {"contact_stiffness", "1", "number", "1", "> 0",
       "Of contact = \"pairs\": how stiff surfaces are, over the modulus rho c^2 of the softer body.", false},
      [](SolverSpec& solver, const Input& input, const ReadContext& context) {
        read_value(input, context, "contact_stiffness", positive(), solver.contact_stiffness);
      },
      [](const SolverSpec& solver, int) -> std::optional<Input> {
        if (solver.contact != ContactMethod::pairs) return std::nullopt;
        return Input::real(solver.contact_stiffness);
      });
  table.optional("damping", "1/s", &SolverSpec::damping, non_negative(), "alpha of the nodal damping force alpha m v.");
  table.custom(
      {"mass_cutoff_relative", "1", "number", "0", ">= 0", "Nodes with less than this share of the smallest particle mass do not move.",
       false},
      [](SolverSpec& solver, const Input& input, const ReadContext& context) {
        read_value(input, context, "mass_cutoff_relative", non_negative(), solver.mass_cutoff_relative);
      },
      [](const SolverSpec& solver, int) -> std::optional<Input> {
        if (solver.mass_cutoff) return std::nullopt;
        return Input::real(solver.mass_cutoff_relative);
      });
  table.optional("mass_cutoff", "kg", &SolverSpec::mass_cutoff, non_negative(), "The same as an absolute mass.");
  table.optional("precision", "1", &SolverSpec::precision, any_number(),
                 "Of the computation: \"double\", or \"single\" for about 1.5 times the speed with 7 digits.");
}

}  // namespace matpoint
