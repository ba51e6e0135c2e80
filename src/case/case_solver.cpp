// The sections [solver] and [time] of a case, and what the two solvers can and cannot do with the rest of it.
#include <cmath>

#include "case/case.hpp"
#include "case/case_reading.hpp"
#include "solver/linear_solver_names.hpp"

namespace matpoint {

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

namespace {

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
  const std::vector<std::string>& missing = missing_linear_solver_names();
  if (std::find(missing.begin(), missing.end(), solver.linear_solver) != missing.end()) {
    fail_input(at_key(input, "linear_solver"), context,
               fmt::format("linear_solver = \"{}\" is not in this program, which was built without SuiteSparse; it has {}",
                           solver.linear_solver, list_names(linear_solver_names())));
  }
  check_words({solver.linear_solver}, "linear_solver", linear_solver_names(), input, context);
}

/// A key of the other solver gets its own message: whoever switches the type has to clear these away.
template <class Other, class Own>
void refuse_keys_of_other(const Input& input, const ReadContext& context, const char* other) {
  const auto has = [](const std::vector<ParameterDescription>& all, const std::string& name) {
    return std::any_of(all.begin(), all.end(), [&](const ParameterDescription& one) { return one.name == name; });
  };
  const std::vector<ParameterDescription> own = parameters_of<Own>().describe();
  const std::vector<ParameterDescription> others = parameters_of<Other>().describe();
  for (const auto& [key, value] : input.entries()) {
    if (!has(own, key) && has(others, key)) fail_input(value, context, fmt::format("{} is for solver.type = \"{}\" only", key, other));
  }
}

[[noreturn]] void fail_case(const Input& at, const std::string& where, const std::string& text) { fail_input(at, {2, where}, text); }

/// The given section, for the place of a message.
const Input& section_of(const Input& input, const std::string& name) { return at_key(input, name); }

/// What the shape functions and the formulation cannot do.
void check_shape(const Case& problem, const Input& input) {
  if (problem.solver.shape == ShapeKind::cpdi) {
    const Input& solver = section_of(input, "solver");
    if (problem.solver.transfer == Transfer::apic) {
      fail_case(
          at_key(solver, "transfer"), "solver",
          "transfer = \"apic\" cannot be used with shape = \"cpdi\", whose domains couple the directions of APIC's slopes; use \"flip\", "
          "\"pic\", \"tpic\" or \"fmpm\"");
    }
    if (problem.solver.stress_order == StressOrder::usf) {
      fail_case(at_key(solver, "stress_order"), "solver",
                "stress_order = \"usf\" cannot be used with shape = \"cpdi\": the domains would change between the two mappings of a step, "
                "and momentum would be lost; use \"usl\" or \"musl\"");
    }
  }
  if (problem.solver.shape != ShapeKind::linear) {
    const Input& grid = section_of(input, "grid");
    if (!problem.grid.periodic.empty()) {
      fail_case(at_key(grid, "periodic"), "grid",
                "periodic sides are for solver.shape = \"linear\" only: wider shapes end at the sides of the grid");
    }
    const Input& output = section_of(input, "output");
    if (problem.output.grid) {
      fail_case(
          at_key(output, "grid"), "output",
          "grid = true is for solver.shape = \"linear\" only: the nodes of wider shapes are no corners of cells with values of a field");
    }
  }
}

/// What bodies that meet by themselves cannot do.
void check_contact(const Case& problem, const Input& input) {
  const ContactMethod method = problem.solver.contact;
  if (method != ContactMethod::single_field) {
    const Input& at = at_key(section_of(input, "solver"), "contact");
    const char* const name = method == ContactMethod::pairs ? "pairs" : "multi_field";
    if (problem.bodies.size() < 2)
      fail_case(at, "solver", fmt::format("contact = \"{}\" is for two or more bodies, and the case has one", name));
    if (method == ContactMethod::multi_field && problem.solver.shape != ShapeKind::linear) {
      fail_case(at, "solver",
                "contact = \"multi_field\" is for shape = \"linear\" only: with wider shapes bodies that slide are held by their edges; "
                "contact = \"pairs\" is for all shapes");
    }
    if (!problem.grid.periodic.empty()) fail_case(at, "solver", fmt::format("contact = \"{}\" cannot be used with periodic sides", name));
    if (method == ContactMethod::multi_field && problem.solver.transfer == Transfer::fmpm) {
      fail_case(at, "solver",
                "contact = \"multi_field\" cannot be used with transfer = \"fmpm\", which spreads a node's velocity to its neighbours; use "
                "\"flip\", \"pic\", \"apic\" or \"tpic\"");
    }
  }
  for (const BodySpec& body : problem.bodies) {
    if (body.formulation == Formulation::updated || problem.bodies.size() == 1 || method == ContactMethod::pairs) continue;
    fail_case(Input::table().with_place(body.place), fmt::format("body {}", body.name),
              "formulation = \"total\" is for cases with one body, or for contact = \"pairs\": on the grid, in its reference "
              "configuration, it does not meet others");
  }
}

void check_for_explicit(const Case& problem, const Input& input) {
  const Input& grid = section_of(input, "grid");
  for (const char* key : {"grading", "refinements", "lines_x", "lines_y", "lines_z", "corners"}) {
    if (is_given(grid, key)) fail_case(at_key(grid, key), "grid", fmt::format("{} is for solver.type = \"implicit\" only", key));
  }
  check_shape(problem, input);
  check_contact(problem, input);
  const Input& time = section_of(input, "time");
  if (problem.time.rule) fail_case(at_key(time, "rule"), "time", "rule is for solver.type = \"implicit\" only; automatic steps follow cfl");
  for (const BodySpec& body : problem.bodies) {
    if (body.method == BodyMethod::elements) {
      fail_case(Input::table().with_place(body.place), fmt::format("body {}", body.name),
                "method = \"elements\" is for solver.type = \"implicit\" only: the explicit solver's grid has no finite elements");
    }
  }
  for (std::size_t b = 0; b < problem.boundaries.size(); ++b) {
    const BoundarySpec& boundary = problem.boundaries[b];
    const Input place = Input::table().with_place(boundary.place);
    const std::string where = fmt::format("boundary {}", b + 1);
    if (boundary.kind == BoundaryKind::traction) fail_case(place, where, "kind = \"traction\" is for solver.type = \"implicit\" only");
    if (boundary.receding_correction > 0) fail_case(place, where, "receding_correction is for solver.type = \"implicit\" only");
    if (boundary.is_attached) fail_case(place, where, "attached is for solver.type = \"implicit\" only");
    const bool has_total =
        std::any_of(problem.bodies.begin(), problem.bodies.end(), [](const auto& body) { return body.formulation == Formulation::total; });
    if (boundary.contact != FaceContact::stick && has_total) {
      fail_case(
          place, where,
          "contact cannot be used with bodies of formulation = \"total\", whose nodes do not move towards a surface; use \"updated\"");
    }
  }
}

/// Whether a side of the mapped grid is not along an axis.
bool is_inclined(const GridSpec& grid, const std::string& side) {
  if (grid.corners.empty()) return false;
  const std::vector<std::string> order = {"bottom", "right", "top", "left"};
  const auto first = static_cast<std::size_t>(std::find(order.begin(), order.end(), side) - order.begin());
  const std::size_t across = first % 2 == 0 ? 1 : 0;
  return grid.corners[first][across] != grid.corners[(first + 1) % 4][across];
}

void check_implicit_boundaries(const Case& problem) {
  const bool is_element = problem.implicit.basis == BasisKind::element;
  for (std::size_t b = 0; b < problem.boundaries.size(); ++b) {
    const BoundarySpec& boundary = problem.boundaries[b];
    const Input place = Input::table().with_place(boundary.place);
    const std::string where = fmt::format("boundary {}", b + 1);
    if (boundary.region) {
      if (!is_element) {
        fail_case(
            place, where,
            "the implicit solver on B-splines takes conditions on sides of the grid only: motion that is prescribed within cells needs "
            "basis = \"element\"");
      }
      if (boundary.kind == BoundaryKind::slip)
        fail_case(place, where, "the implicit solver has no kind = \"slip\" for a region; use kind = \"fixed\" with components");
      if (boundary.is_attached || boundary.receding_correction > 0)
        fail_case(place, where, "attached and receding_correction are for sides of the grid");
    }
    if (boundary.receding_correction > 0 && is_inclined(problem.grid, boundary.side)) {
      fail_case(place, where,
                fmt::format("receding_correction is for sides along an axis, but grid.corners inclines side = \"{}\"", boundary.side));
    }
    if (boundary.kind == BoundaryKind::slip && !boundary.region && is_inclined(problem.grid, boundary.side)) {
      fail_case(place, where,
                fmt::format("kind = \"slip\" holds the component across a side, but grid.corners inclines side = \"{}\"; use kind = "
                            "\"fixed\", with components where they fit",
                            boundary.side));
    }
    if (boundary.receding_correction > 0 && !is_element) {
      fail_case(place, where, "receding_correction is for basis = \"element\" only; B-splines have contact = \"no_tension\"");
    }
    if (boundary.contact != FaceContact::stick && boundary.kind == BoundaryKind::slip)
      fail_case(place, where, "the implicit solver has contact for kind = \"fixed\" or \"velocity\"");
    if (boundary.contact != FaceContact::stick && is_element) {
      fail_case(place, where,
                "contact goes by the signs of reactions at nodes, which mean nothing on elements; use basis = \"bspline\", or "
                "receding_correction");
    }
    if (boundary.contact != FaceContact::stick && problem.implicit.mode == ImplicitMode::quasi_static) {
      fail_case(place, where, "contact is for mode = \"dynamic\" only: a body that is let go is held by its inertia");
    }
    const std::string& linear_solver = problem.implicit.linear_solver;
    if (boundary.friction > 0 && (linear_solver == "ldlt" || linear_solver == "cholmod" || linear_solver == "cg")) {
      fail_case(place, where,
                fmt::format("friction makes the matrix unsymmetric, and linear_solver = \"{}\" is for symmetric ones; use \"auto\"",
                            linear_solver));
    }
  }
}

void check_for_implicit(const Case& problem, const Input& input) {
  const Input& grid = section_of(input, "grid");
  const bool is_element = problem.implicit.basis == BasisKind::element;
  if (!problem.grid.periodic.empty()) fail_case(at_key(grid, "periodic"), "grid", "the implicit solver has no periodic sides");
  for (const char* key : {"grading", "lines_x", "lines_y", "lines_z", "corners"}) {
    if (!is_element && is_given(grid, key))
      fail_case(at_key(grid, key), "grid", fmt::format("{} is for solver.basis = \"element\"; B-splines need equal cells", key));
  }
  int particle_bodies = 0;
  for (const BodySpec& body : problem.bodies) {
    const Input place = Input::table().with_place(body.place);
    const std::string where = fmt::format("body {}", body.name);
    if (body.formulation == Formulation::total) fail_case(place, where, "formulation = \"total\" is for solver.type = \"explicit\" only");
    if (body.has_fbar) fail_case(place, where, "fbar is for solver.type = \"explicit\" only");
    if (body.method == BodyMethod::elements && !is_element)
      fail_case(place, where, "method = \"elements\" needs solver.basis = \"element\": its cells are elements of the background");
    if (body.method == BodyMethod::particles && ++particle_bodies > 1) {
      fail_case(place, where, "the implicit solver has no contact between bodies of particles yet, so a case has one of them at most");
    }
    if (body.material->law_index() < 0) {
      fail_case(place, where,
                "the implicit solver needs a law's exact tangent, which a law given as a function does not have; write it in C++ "
                "(docs/add_a_material.md), or use solver.type = \"explicit\"");
    }
    if (problem.implicit.mode != ImplicitMode::quasi_static) continue;
    if (body.material->is_rate_dependent() && body.material->history_size() == 0) {
      fail_case(place, where, fmt::format("the law \"{}\" depends on rates, which mode = \"static\" does not have", body.material->type()));
    }
    if (body.velocity) fail_case(place, where, "a body in mode = \"static\" has no velocity");
  }
  const Input& output = section_of(input, "output");
  if (problem.output.grid)
    fail_case(at_key(output, "grid"), "output", "the implicit solver writes no fields of nodes; leave grid = true out");
  const Input& time = section_of(input, "time");
  for (const char* key : {"cfl", "dt_max", "dt_min"}) {
    if (is_given(time, key))
      fail_case(at_key(time, key), "time", fmt::format("{} is for the explicit solver's automatic steps; use dt or rule", key));
  }
  if (!problem.time.dt && !problem.time.rule) {
    fail_case(time, "time",
              fmt::format("dt is missing: the implicit solver needs dt = ..., or rule = {{ type = ... }}, one of {}",
                          list_names(step_rule_registry().names())));
  }
  check_implicit_boundaries(problem);
}

}  // namespace

void check_time(TimeSpec& time, const Input& input, const ReadContext& context) {
  if (time.rule && time.dt) fail_input(at_key(input, "rule"), context, "dt and rule are both given; give one of them");
  if (time.dt) {
    for (const char* key : {"cfl", "dt_max", "dt_min"}) {
      if (is_given(input, key)) {
        fail_input(at_key(input, key), context,
                   fmt::format("{} is for automatic time steps, but dt = {} fixes them; leave one out", key, *time.dt));
      }
    }
    if (time.end / *time.dt < 0.5) {
      fail_input(at_key(input, "dt"), context,
                 fmt::format("dt = {} is longer than the whole run (end = {}): no step would be done", *time.dt, time.end));
    }
  }
  constexpr Real k_steps_max = 1e15;  // near 2^53 a sum of steps would stand still
  const Real longest = time.dt.value_or(time.dt_max.value_or(time.end));
  if (time.end / longest > k_steps_max) {
    const char* key = time.dt ? "dt" : "dt_max";
    fail_input(at_key(input, key), context,
               fmt::format("{} = {} makes {:.3g} steps to end = {}, at most {:.0g} are possible", key, longest, time.end / longest,
                           time.end, k_steps_max));
  }
  if (time.dt_max && *time.dt_max < time.dt_min) {
    fail_input(at_key(input, "dt_max"), context, fmt::format("dt_max = {} is below dt_min = {}", *time.dt_max, time.dt_min));
  }
}

void declare_solver(ParameterTable<Case>& table) {
  table.custom(
      {"solver", "1", "table", "", "", "The scheme.", false},
      [](Case& problem, const Input& input, const ReadContext& context) {
        const ReadContext inside{context.dim, "solver"};
        const Input* const type = input.kind() == Input::Kind::table ? input.find("type") : nullptr;
        if (type != nullptr && type->kind() == Input::Kind::string && type->as_string() == "implicit") {
          refuse_keys_of_other<SolverSpec, ImplicitSpec>(input, inside, "explicit");
          parameters_of<ImplicitSpec>().read(input, inside, problem.implicit);
          check_implicit(problem.implicit, input, inside);
          problem.solver.type = "implicit";
        } else {
          if (input.kind() == Input::Kind::table) refuse_keys_of_other<ImplicitSpec, SolverSpec>(input, inside, "implicit");
          parameters_of<SolverSpec>().read(input, inside, problem.solver);
          check_solver(problem.solver, input, inside);
        }
      },
      [](const Case& problem, int dim) -> std::optional<Input> {
        return problem.is_implicit() ? parameters_of<ImplicitSpec>().write(problem.implicit, dim)
                                     : parameters_of<SolverSpec>().write(problem.solver, dim);
      });
}

void check_for_solver(const Case& problem, const Input& input) {
  if (problem.is_implicit())
    check_for_implicit(problem, input);
  else
    check_for_explicit(problem, input);
}

namespace {

/// Choices that go together; keys that are given beside override them. Why these: docs/theory.md, "Which combination".
struct Quality {
  const char* name;
  ShapeKind shape;
  Transfer transfer;
  StressOrder stress_order;
  const char* precision;
};
constexpr Quality k_qualities[] = {{"robust", ShapeKind::bspline2, Transfer::apic, StressOrder::usl, "double"},
                                   {"accurate", ShapeKind::bspline2, Transfer::flip, StressOrder::musl, "double"},
                                   {"fast", ShapeKind::linear, Transfer::flip, StressOrder::musl, "single"}};

void read_quality(SolverSpec& solver, const Input& input, const ReadContext& context) {
  std::string given;
  read_value(input, context, "quality", any_number(), given);
  std::vector<std::string> names;
  for (const Quality& quality : k_qualities) {
    names.emplace_back(quality.name);
    if (given != quality.name) continue;
    solver.shape = quality.shape;
    solver.transfer = quality.transfer;
    solver.stress_order = quality.stress_order;
    solver.precision = quality.precision;
    return;
  }
  fail_input(input, context,
             fmt::format("quality = {} is unknown, allowed: {}{}", input.text(), list_names(names), did_you_mean(given, names)));
}

}  // namespace

void SolverSpec::declare(ParameterTable<SolverSpec>& table) {
  // First, so that keys after it override what it chooses; it is written as what it chose.
  table.custom(
      {"quality", "1", "string", "", "\"robust\", \"accurate\" or \"fast\"",
       "Chooses shape, transfer, stress_order and precision together, where they are not given; `matpoint check` prints what.", false},
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
      "particles' domains, which keep their shape (gimp: uGIMP) or deform with the particles (cpdi).");
  table.choice(
      "transfer", &SolverSpec::transfer,
      {{"flip", Transfer::flip}, {"pic", Transfer::pic}, {"apic", Transfer::apic}, {"tpic", Transfer::tpic}, {"fmpm", Transfer::fmpm}},
      "How velocities reach the particles: their changes (flip), themselves (pic), with an affine part (apic, tpic), or by a better "
      "inverse "
      "of the mass matrix (fmpm).");
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
      {"mass_cutoff_relative", "1", "number", "0.001", ">= 0", "Nodes with less than this share of the smallest particle mass do not move.",
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

void ImplicitSpec::declare(ParameterTable<ImplicitSpec>& table) {
  table.optional("type", "1", &ImplicitSpec::type, any_number(), "\"implicit\".");
  table.choice("mode", &ImplicitSpec::mode, {{"dynamic", ImplicitMode::dynamic}, {"static", ImplicitMode::quasi_static}},
               "dynamic: Newmark's method in time; static: no inertia, time is the load parameter and dt the load step.");
  table.choice("basis", &ImplicitSpec::basis, {{"bspline", BasisKind::bspline}, {"element", BasisKind::element}},
               "Functions of the background: quadratic B-splines on equal cells, or Lagrange elements.");
  table.optional("element_order", "1", &ImplicitSpec::element_order, between_closed(1, 2),
                 "Of basis = \"element\": 1 for corner nodes only, 2 for 9-node (27-node) elements.");
  table.optional("beta", "1", &ImplicitSpec::beta, between_closed(0.25, 1),
                 "Newmark's beta. 0.25 conserves best, but lets velocities that the grid cannot see grow; 0.3 bounds them.");
  table.optional("gamma", "1", &ImplicitSpec::gamma, between_closed(0.5, 1), "Newmark's gamma; above 0.5 it damps, and is first order.");
  table.choice("initial_acceleration", &ImplicitSpec::initial_acceleration,
               {{"consistent", InitialAcceleration::consistent}, {"zero", InitialAcceleration::zero}},
               "Accelerations before the first step: from the forces, or none.");
  table.optional(
      "soft_stiffness", "1", &ImplicitSpec::soft_stiffness, non_negative(),
      "C_1, C_2: shares of the shear modulus that hold nodes in partly filled cells, with fewer than 5 (5 to 8) of 9 inner nodes.");
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
                 "auto, umfpack, cholmod (with SuiteSparse), ldlt, sparse_lu, cg, bicgstab or gmres.");
  table.optional("linear_tolerance", "1", &ImplicitSpec::linear_tolerance, between(0, 1),
                 "Relative residual of the iterative linear solvers.");
}

void TimeSpec::declare(ParameterTable<TimeSpec>& table) {
  table.required("end", "s", &TimeSpec::end, positive(), "The run ends at this time.");
  table.optional("dt", "s", &TimeSpec::dt, positive(), "Fixed time step; without it steps are automatic.");
  const auto automatic = [&table](const std::string& name, const std::string& unit, auto member, Constraint constraint,
                                  const std::string& default_text, const std::string& help) {
    table.custom(
        {name, unit, "number", default_text, constraint.text, help, false},
        [=](TimeSpec& time, const Input& input, const ReadContext& context) { read_value(input, context, name, constraint, time.*member); },
        [=](const TimeSpec& time, int) -> std::optional<Input> {
          if (time.dt || time.rule) return std::nullopt;
          if constexpr (std::is_same_v<decltype(member), Real TimeSpec::*>)
            return Input::real(time.*member);
          else
            return time.*member ? std::optional(Input::real(*(time.*member))) : std::nullopt;
        });
  };
  automatic("cfl", "1", &TimeSpec::cfl, Constraint{"in the interval (0, 1]", [](Real x) { return x > 0 && x <= 1; }}, "0.4",
            "Share of the stable time step that an automatic step takes.");
  automatic("dt_max", "s", &TimeSpec::dt_max, positive(), "", "Longest automatic step.");
  automatic("dt_min", "s", &TimeSpec::dt_min, non_negative(), "0", "The run fails when an automatic step would be shorter.");
  typed(table, "rule", &TimeSpec::rule, step_rule_registry, "Implicit solver without dt: how long the next step is.", false);
}

}  // namespace matpoint
