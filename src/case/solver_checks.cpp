#include "case/solver_checks.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "case/case_reading.hpp"

namespace matpoint {
namespace {

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

/// Whether overfilled places have a slope that particles can follow.
bool is_smooth(ShapeKind shape) { return shape == ShapeKind::bspline2 || shape == ShapeKind::bspline3 || shape == ShapeKind::gimp; }

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
  const Transfer transfer = problem.solver.transfer;
  const bool is_delicate = transfer == Transfer::apic || transfer == Transfer::tpic ||
                           (transfer == Transfer::fmpm && problem.solver.stress_order == StressOrder::usl);
  if (problem.solver.shape == ShapeKind::linear && is_delicate && problem.solver.precision == "single") {
    fail_case(at_key(section_of(input, "solver"), "precision"), "solver",
              "precision = \"single\" cannot be used with shape = \"linear\" and this transfer: rounding of the force on a node with "
              "next to "
              "no mass strains what flies freely; take shape = \"bspline2\", or precision = \"double\"");
  }
  const bool has_affine = transfer == Transfer::apic || transfer == Transfer::tpic;
  if (problem.solver.co_rotating.value_or(false) && has_affine) {
    fail_case(at_key(section_of(input, "solver"), "co_rotating"), "solver",
              "co_rotating = true cannot be used with transfer = \"apic\" or \"tpic\", whose particles turn by themselves");
  }
  for (const BodySpec& body : problem.bodies) {
    if (!is_given(section_of(input, "solver"), "fluid_correction") || !problem.solver.fluid_correction.value_or(false)) break;
    if (!body.material->is_gas()) continue;
    fail_case(at_key(section_of(input, "solver"), "fluid_correction"), "solver",
              fmt::format("fluid_correction = true moves volume without its energy, which \"{}\" of body \"{}\" has; leave it out",
                          body.material->type(), body.name));
  }
  if (problem.solver.fluid_correction.value_or(false) && !is_smooth(problem.solver.shape)) {
    fail_case(at_key(section_of(input, "solver"), "fluid_correction"), "solver",
              "fluid_correction = true is for shape = \"bspline2\", \"bspline3\" or \"gimp\": the others have no smooth slope to move "
              "particles along");
  }
  for (const std::string& axis : problem.grid.periodic) {
    const int cells = problem.grid.cells[static_cast<std::size_t>(axis[0] - 'x')];
    if (cells >= span_of(problem.solver.shape)) continue;
    fail_case(at_key(section_of(input, "grid"), "periodic"), "grid",
              fmt::format("periodic = [\"{}\"] with {} cell{} is narrower than the shape functions; give it {} or more", axis, cells,
                          cells == 1 ? "" : "s", span_of(problem.solver.shape)));
  }
  if (problem.solver.co_rotating.value_or(false) && !problem.grid.periodic.empty()) {
    fail_case(at_key(section_of(input, "solver"), "co_rotating"), "solver",
              "co_rotating = true cannot be used with periodic sides: what goes round them does not turn about a centre");
  }
  if (problem.solver.shape != ShapeKind::linear) {
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

/// What knows no hoops around an axis.
void check_axisymmetry(const Case& problem, const Input& input) {
  if (!problem.grid.is_axisymmetric) return;
  const auto fail = [&](const char* section, const char* key, const std::string& what) {
    fail_case(at_key(section_of(input, section), key), section,
              fmt::format("{} cannot be used with grid.axisymmetric = true{}", key, what));
  };
  if (problem.solver.contact != ContactMethod::single_field)
    fail("solver", "contact", ": bodies in one field stick to each other; leave it out");
  if (problem.solver.shape == ShapeKind::cpdi)
    fail("solver", "shape", " and \"cpdi\"; use \"gimp\", \"bspline2\", \"bspline3\" or \"linear\"");
  if (problem.solver.fluid_correction.value_or(false)) fail("solver", "fluid_correction", "; leave it out");
  if (problem.solver.co_rotating.value_or(false)) fail("solver", "co_rotating", ": a ring does not turn in the plane; leave it out");
  if (!problem.grid.periodic.empty() && problem.grid.periodic != std::vector<std::string>{"y"})
    fail("grid", "periodic", " along the radius; it may be [\"y\"]");
  if (problem.gravity[0] != 0) {
    fail_case(at_key(input, "gravity"), "",
              fmt::format("gravity[0] = {} points along the radius, which no weight does; with grid.axisymmetric = "
                          "true it must be 0",
                          problem.gravity[0]));
  }
  for (const ToolSpec& tool : problem.tools) {
    Real along_radius = tool.velocity.empty() ? 0 : tool.velocity[0];
    for (const Vec3& v : tool.velocities) along_radius = std::max(std::abs(along_radius), std::abs(v[0]));
    if (!tool.is_free() && along_radius == 0 && tool.angular_velocity == Vec3{}) continue;
    fail_case(Input::table().with_place(tool.place), fmt::format("tool {}", tool.name),
              "with grid.axisymmetric = true a tool can only be moved along the axis, by a velocity whose first number is 0");
  }
  for (const Vec3& a : problem.base_acceleration) {
    if (a[0] == 0) continue;
    fail_case(at_key(input, "base_acceleration"), "",
              "base_acceleration along the radius cannot be with grid.axisymmetric = true; its first numbers must be 0");
  }
  for (const BodySpec& body : problem.bodies) {
    // Without the correction of fluids, affine velocities of spray grow without bound.
    if (body.material->is_fluid() && problem.solver.transfer != Transfer::flip && problem.solver.transfer != Transfer::pic)
      fail("solver", "transfer", fmt::format(" unless it is \"flip\" or \"pic\" (body \"{}\" is a fluid)", body.name));
    if (body.formulation != Formulation::total) continue;
    fail_case(Input::table().with_place(body.place), fmt::format("body {}", body.name),
              "formulation = \"total\" cannot be used with grid.axisymmetric = true; use \"updated\"");
  }
}

void check_for_explicit(const Case& problem, const Input& input) {
  const Input& grid = section_of(input, "grid");
  for (const char* key : {"grading", "refinements", "lines_x", "lines_y", "lines_z", "corners", "ring"}) {
    if (is_given(grid, key)) fail_case(at_key(grid, key), "grid", fmt::format("{} is for solver.type = \"implicit\" only", key));
  }
  for (std::size_t b = 0; b < problem.boundaries.size(); ++b) {
    const BoundarySpec& boundary = problem.boundaries[b];
    if (!boundary.velocity_field) continue;
    const Input place = Input::table().with_place(boundary.place);
    const std::string where = fmt::format("boundary {}", b + 1);
    if (!problem.grid.periodic.empty())
      fail_case(place, where, "a velocity by place cannot be used with periodic sides, where one node has two places; give one velocity");
    for (const BodySpec& body : problem.bodies) {
      if (body.formulation == Formulation::updated) continue;
      fail_case(place, where,
                fmt::format("a velocity by place cannot be used with formulation = \"total\" (body \"{}\"), whose nodes know where the "
                            "body was at the start; give one velocity",
                            body.name));
    }
  }
  if (!problem.tools.empty() && !problem.grid.periodic.empty()) {
    fail_case(Input::table().with_place(problem.tools[0].place), fmt::format("tool {}", problem.tools[0].name),
              "tools cannot be used with periodic sides");
  }
  check_shape(problem, input);
  check_contact(problem, input);
  check_axisymmetry(problem, input);
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
    if (boundary.contact_by) fail_case(place, where, "contact_by is for solver.type = \"implicit\" only");
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
  if (grid.ring) {
    // "bottom" and "top" are held across themselves where they lie along x.
    const Real angle = side == "bottom" ? grid.ring->start_angle : grid.ring->end_angle;
    return side != "front" && side != "back" && !((side == "bottom" || side == "top") && std::fmod(angle, 180) == 0);
  }
  if (grid.corners.empty()) return false;
  const std::vector<std::string> order = {"bottom", "right", "top", "left"};
  const auto first = static_cast<std::size_t>(std::find(order.begin(), order.end(), side) - order.begin());
  const std::size_t across = first % 2 == 0 ? 1 : 0;
  return grid.corners[first][across] != grid.corners[(first + 1) % 4][across];
}

bool has_body_of(const Case& problem, BodyMethod method) {
  return std::any_of(problem.bodies.begin(), problem.bodies.end(), [&](const BodySpec& body) { return body.method == method; });
}

/// Where they do, the background moves with the elements.
bool shares_nodes_with_elements(const Case& problem) {
  return problem.implicit.contact == ImplicitContact::single_field && has_body_of(problem, BodyMethod::particles) &&
         has_body_of(problem, BodyMethod::elements);
}

void check_implicit_boundaries(const Case& problem) {
  const bool is_element = problem.implicit.basis == BasisKind::element;
  const char* const map = problem.grid.ring ? "ring" : "corners";
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
                fmt::format("receding_correction is for sides along an axis, but grid.{} inclines side = \"{}\"", map, boundary.side));
    }
    if (boundary.kind == BoundaryKind::slip && !boundary.region && is_inclined(problem.grid, boundary.side)) {
      fail_case(place, where,
                fmt::format("kind = \"slip\" holds the component across a side, but grid.{} inclines side = \"{}\"; use kind = "
                            "\"fixed\", with components where they fit",
                            map, boundary.side));
    }
    if (boundary.velocity_field && (boundary.contact != FaceContact::stick || boundary.receding_correction > 0)) {
      fail_case(place, where,
                fmt::format("a velocity by place is for nodes that a boundary holds, not for {} in the implicit solver; give the side one "
                            "velocity",
                            boundary.receding_correction > 0 ? "receding_correction" : "contact"));
    }
    if (boundary.receding_correction > 0 && !is_element) {
      fail_case(place, where, "receding_correction is for basis = \"element\" only; B-splines have contact = \"no_tension\"");
    }
    const bool by_nodes = boundary.contact != FaceContact::stick && !boundary.touches_by_particles();
    if (by_nodes && boundary.kind == BoundaryKind::slip)
      fail_case(place, where, "contact_by = \"nodes\" is for kind = \"fixed\" or \"velocity\"; use \"particles\"");
    if (boundary.touches_by_particles()) {
      if (is_inclined(problem.grid, boundary.side)) {
        fail_case(place, where, fmt::format("contact is for sides along an axis, but grid.{} inclines side = \"{}\"", map, boundary.side));
      }
      if (shares_nodes_with_elements(problem)) {
        fail_case(place, where,
                  "where particles and bodies of elements share their nodes, sides do not let go of them; give the solver contact = "
                  "\"pairs\", or the side receding_correction");
      }
    }
    if (boundary.touches_by_particles() && is_element && problem.implicit.element_order == 2 &&
        has_body_of(problem, BodyMethod::particles)) {
      fail_case(
          place, where,
          "contact is for basis = \"bspline\" or element_order = 1: at a free surface particles do not hold elements with 9 (27) nodes, "
          "which are negative in places, well enough to bounce; receding_correction is for them");
    }
    if (by_nodes && is_element) {
      fail_case(
          place, where,
          "contact_by = \"nodes\" goes by the signs of reactions at nodes, which mean nothing on elements; use \"particles\", basis = "
          "\"bspline\", or receding_correction");
    }
    if (by_nodes && problem.implicit.mode == ImplicitMode::quasi_static) {
      fail_case(
          place, where,
          "contact_by = \"nodes\" is for mode = \"dynamic\" only, where a node that is let go is held by its inertia; use \"particles\"");
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
  for (const ToolSpec& tool : problem.tools) {
    fail_case(
        Input::table().with_place(tool.place), fmt::format("tool {}", tool.name),
        "tools are for solver.type = \"explicit\" only; the implicit one has stiff bodies with contact = \"pairs\", and sides that move");
  }
  const std::string& linear_solver = problem.implicit.linear_solver;
  for (const LoadSpec& load : problem.loads) {
    if (load.is_on_surface() && problem.implicit.basis == BasisKind::element && problem.implicit.element_order == 2) {
      fail_case(
          Input::table().with_place(load.place), fmt::format("load on body {}", load.body),
          "a load on the surface of particles is for basis = \"bspline\" or element_order = 1: at a free surface particles do not hold "
          "elements with 9 (27) nodes, which are negative in places");
    }
    if (load.kind != LoadKind::pressure || (linear_solver != "ldlt" && linear_solver != "cholmod" && linear_solver != "cg")) continue;
    fail_case(Input::table().with_place(load.place), fmt::format("load on body {}", load.body),
              fmt::format("a pressure, which follows the surface, makes the matrix unsymmetric, and linear_solver = \"{}\" is for "
                          "symmetric ones; use \"auto\"",
                          linear_solver));
  }
  const Input& grid = section_of(input, "grid");
  const bool is_element = problem.implicit.basis == BasisKind::element;
  if (!problem.grid.periodic.empty()) fail_case(at_key(grid, "periodic"), "grid", "the implicit solver has no periodic sides");
  if (problem.grid.is_axisymmetric) {
    fail_case(at_key(grid, "axisymmetric"), "grid",
              "axisymmetric is for solver.type = \"explicit\" only; take the sector of a ring (grid.ring), or a quarter in 3D");
  }
  for (const char* key : {"grading", "lines_x", "lines_y", "lines_z", "corners", "ring"}) {
    if (!is_element && is_given(grid, key))
      fail_case(at_key(grid, key), "grid", fmt::format("{} is for solver.basis = \"element\"; B-splines need equal cells", key));
  }
  for (const BodySpec& body : problem.bodies) {
    const Input place = Input::table().with_place(body.place);
    const std::string where = fmt::format("body {}", body.name);
    if (body.formulation == Formulation::total) fail_case(place, where, "formulation = \"total\" is for solver.type = \"explicit\" only");
    if (body.method == BodyMethod::elements && !is_element)
      fail_case(place, where, "method = \"elements\" needs solver.basis = \"element\": its cells are elements of the background");
    if (body.material->law_index() < 0) {
      fail_case(place, where,
                "the implicit solver needs a law's exact tangent, which a law given as a function does not have; write it in C++ "
                "(docs/add_a_material.md), or use solver.type = \"explicit\"");
    }
    if (body.material->is_gas()) {
      fail_case(
          place, where,
          fmt::format("\"{}\" is for solver.type = \"explicit\" only: shocks need steps that no wave outruns", body.material->type()));
    }
    if (problem.implicit.mode != ImplicitMode::quasi_static) continue;
    if (body.material->is_rate_dependent() && body.material->history_size(problem.dim) == 0) {
      fail_case(place, where, fmt::format("the law \"{}\" depends on rates, which mode = \"static\" does not have", body.material->type()));
    }
    if (body.velocity) fail_case(place, where, "a body in mode = \"static\" has no velocity");
  }
  if (problem.implicit.contact == ImplicitContact::pairs) {
    const Input& at = at_key(section_of(input, "solver"), "contact");
    if (problem.bodies.size() < 2) fail_case(at, "solver", "contact = \"pairs\" is for two or more bodies, and the case has one");
    for (const BodySpec& body : problem.bodies) {
      if (body.receding_correction == 0) continue;
      fail_case(Input::table().with_place(body.place), fmt::format("body {}", body.name),
                "receding_correction is for particles that share the nodes of a body of elements; with contact = \"pairs\" leave it out");
    }
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

/// Poisson's ratio of a law at small strains, from its bulk and shear moduli; of a fluid, which has no shear modulus, 1/2.
Real poissons_ratio_of(const Material& material) {
  constexpr Real e = 1e-6;
  const Material::Matrix swollen = material.kirchhoff_stress({1 + e, 0, 0, 0, 1 + e, 0, 0, 0, 1 + e});
  const Material::Matrix sheared = material.kirchhoff_stress({1, e, 0, 0, 1, 0, 0, 0, 1});
  const Real bulk = (swollen[0] + swollen[4] + swollen[8]) / 9, shear = sheared[1];
  return (3 * bulk - 2 * shear) / (2 * (3 * bulk + shear));
}

/// How many cells wide a band is in which soil softens: smooth functions that carry velocities with their slopes widen it in each step.
Real cells_of_band(const Case& problem) {
  const SolverSpec& solver = problem.solver;
  if (problem.is_implicit() || (solver.shape != ShapeKind::bspline2 && solver.shape != ShapeKind::bspline3)) return 1;
  return solver.transfer == Transfer::apic ? 3 : solver.transfer == Transfer::tpic ? 2 : 1;
}

/// Around an axis no direction is that of plane strain: laws that go by the dimension are those of space.
int stress_dim(const Case& problem) { return problem.grid.is_axisymmetric ? 3 : problem.dim; }

void read_laws_in_space(Case& problem) {
  for (BodySpec& body : problem.bodies) {
    if (stress_dim(problem) == problem.dim || body.material->law_index() < 0) continue;
    const ReadContext context{stress_dim(problem), fmt::format("body {}", body.name)};
    body.material = material_registry().read(body.material->write(problem.dim), context, "material");
  }
}

/// The length of what breaks, or of shocks, is the cell size where a case gives none, that of a band as many as it is wide.
void choose_lengths(Case& problem) {
  const GridSpec& grid = problem.grid;
  for (BodySpec& body : problem.bodies) {
    if (!body.material->needs_length()) continue;
    const Input place = Input::table().with_place(body.place);
    const ReadContext context{stress_dim(problem), fmt::format("body {}: material", body.name)};
    const bool has_equal_cells = grid.cell_size.size() == static_cast<std::size_t>(problem.dim) && grid.grading.empty() &&
                                 !grid.is_mapped() &&
                                 std::all_of(grid.lines.begin(), grid.lines.end(), [](const auto& line) { return line.empty(); });
    if (!has_equal_cells) fail_input(place, context, "length is missing: it is the cell size, and the cells are not equal");
    const Real volume = std::accumulate(grid.cell_size.begin(), grid.cell_size.end(), Real{1}, std::multiplies<>());
    const Real cells = body.material->flows_freely() ? cells_of_band(problem) : 1;
    body.material = body.material->with_length(cells * std::pow(volume, Real{1} / problem.dim), place, context);
  }
}

/// Nothing moves across the axis of symmetry.
void hold_axis(Case& problem) {
  if (!problem.grid.is_axisymmetric || problem.grid.lower[0] > 0) return;
  const std::vector<std::string>& periodic = problem.grid.periodic;
  if (std::find(periodic.begin(), periodic.end(), "x") != periodic.end()) return;  // refused with its reason
  const auto is_left = [](const BoundarySpec& boundary) { return boundary.side == "left"; };
  if (std::any_of(problem.boundaries.begin(), problem.boundaries.end(), is_left)) return;
  BoundarySpec axis;
  axis.side = "left";
  axis.kind = BoundaryKind::slip;
  axis.name = "axis";
  problem.boundaries.push_back(axis);
}

void choose_scheme(Case& problem, const Input& input) {
  if (problem.is_implicit()) {
    choose_lengths(problem);
    for (BoundarySpec& boundary : problem.boundaries) {
      if (problem.implicit.mode == ImplicitMode::quasi_static && boundary.contact != FaceContact::stick && !boundary.contact_by)
        boundary.contact_by = ContactBy::particles;
    }
    // From here on B-splines and elements lock: a cantilever with nu = 0.49 sinks by 3 % too little, with 0.499 by 6 %.
    constexpr Real k_nearly_incompressible = 0.45 - 1e-4;  // moduli by differences
    for (BodySpec& body : problem.bodies) {
      if (body.fbar || body.material->law_index() < 0 || body.material->is_fluid()) continue;
      if (poissons_ratio_of(*body.material) >= k_nearly_incompressible) body.fbar = true;
    }
    return;
  }
  const Input& given = section_of(input, "solver");
  SolverSpec& solver = problem.solver;
  const bool has_fluid = std::any_of(problem.bodies.begin(), problem.bodies.end(), [](const BodySpec& body) {
    return body.material->is_fluid() && body.formulation == Formulation::updated;
  });
  const bool has_loose = std::any_of(problem.bodies.begin(), problem.bodies.end(), [](const BodySpec& body) {
    return body.material->flows_freely() && body.formulation == Formulation::updated;
  });
  if (!is_given(given, "shape")) {
    const bool needs_linear = problem.output.grid || solver.contact == ContactMethod::multi_field;
    // Fluids need the smoothest pressures, solids functions that end where they are held (docs/choices.md has the measurements).
    // GIMP's functions integrate a stress that is linear in the depth exactly, also at surfaces and walls: ground at rest stays at rest,
    // and layers that flow between periodic sides have the right profile (with B-splines mud between plates is 10 % too slow on 10 cells).
    const bool is_resting =
        std::any_of(problem.bodies.begin(), problem.bodies.end(), [](const BodySpec& body) { return body.initial_stress != nullptr; });
    const bool is_splashing = problem.grid.periodic.empty() && (has_fluid || (has_loose && !is_resting));
    solver.shape = needs_linear ? ShapeKind::linear : is_splashing ? ShapeKind::bspline2 : ShapeKind::gimp;
  }
  // FLIP keeps velocities that the grid does not see, and grains have nothing that damps them: single ones are shaken loose, and what
  // should lie still goes on moving. Affine velocities need smooth functions, and APIC's slopes functions of their own in each direction.
  if (has_loose && solver.shape != ShapeKind::linear && !is_given(given, "transfer") && !is_given(given, "flip") &&
      !is_given(given, "co_rotating"))
    solver.transfer = solver.shape == ShapeKind::cpdi ? Transfer::tpic : Transfer::apic;
  if (solver.quality_cfl && !problem.time.dt && !is_given(section_of(input, "time"), "cfl")) problem.time.cfl = *solver.quality_cfl;
  // The correction moves volume without its energy, which a gas has.
  const bool has_gas =
      std::any_of(problem.bodies.begin(), problem.bodies.end(), [](const BodySpec& body) { return body.material->is_gas(); });
  // The energy of a gas follows the work of a step to first order: shocks are 1.2 % off with steps of 0.4, 0.7 % with 0.2 of the stable
  // one.
  constexpr Real k_gas_cfl = 0.2;
  if (has_gas && !problem.time.dt && !is_given(section_of(input, "time"), "cfl")) problem.time.cfl = std::min(problem.time.cfl, k_gas_cfl);
  // Linear shapes are the textbook's scheme, and stay that.
  if (!solver.co_rotating)
    solver.co_rotating = solver.shape != ShapeKind::linear && solver.transfer == Transfer::flip &&
                         solver.stress_order != StressOrder::usf && problem.grid.periodic.empty() && !problem.grid.is_axisymmetric;
  if (!solver.fluid_correction) solver.fluid_correction = has_fluid && !has_gas && is_smooth(solver.shape) && !problem.grid.is_axisymmetric;
  // Its filter is what keeps spray calm; a share of PIC does that, too. Water that closes over the axis gained 19 % without.
  constexpr Real k_flip_around_axis = 0.99;
  if (problem.grid.is_axisymmetric && has_fluid && !*solver.fluid_correction && solver.transfer == Transfer::flip &&
      !is_given(given, "flip"))
    solver.flip = k_flip_around_axis;
  hold_axis(problem);
  read_laws_in_space(problem);
  choose_lengths(problem);
}

void check_for_solver(const Case& problem, const Input& input) {
  if (problem.is_implicit())
    check_for_implicit(problem, input);
  else
    check_for_explicit(problem, input);
}

}  // namespace matpoint
