#include "case/case.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "case/case_reading.hpp"
#include "core/interpolate.hpp"

namespace matpoint {
namespace {

/// A nested table with its own parameters, read by the type's declaration and checked by `check`.
template <class Owner, class Section>
void section(ParameterTable<Owner>& table, const std::string& name, Section Owner::*member, const std::string& help, bool is_required,
             void (*check)(Section&, const Input&, const ReadContext&)) {
  table.custom(
      {name, "1", "table", "", "", help, is_required},
      [=](Owner& owner, const Input& input, const ReadContext& context) {
        const ReadContext inside{context.dim, name};
        parameters_of<Section>().read(input, inside, owner.*member);
        check(owner.*member, input, inside);
      },
      [=](const Owner& owner, int dim) -> std::optional<Input> { return parameters_of<Section>().write(owner.*member, dim); });
}

/// A list of tables ([[body]]), each with its own parameters; `label` names one of them in messages.
template <class Owner, class Item>
void list_of(ParameterTable<Owner>& table, const std::string& name, std::vector<Item> Owner::*member, const std::string& help,
             bool is_required, std::string (*label)(const Input&, std::size_t), void (*check)(Item&, const Input&, const ReadContext&)) {
  table.custom(
      {name, "1", "array of tables", "", "", help, is_required},
      [=](Owner& owner, const Input& input, const ReadContext& context) {
        if (input.kind() != Input::Kind::array) {
          fail_input(input, context,
                     fmt::format("{0} must be a list of tables [[{0}]], got {1} ({2})", name, input.text(), input.kind_text()));
        }
        (owner.*member).clear();
        for (std::size_t i = 0; i < input.items().size(); ++i) {
          const Input& item = input.items()[i];
          const ReadContext inside{context.dim, label(item, i)};
          Item value;
          value.place = item.place();
          parameters_of<Item>().read(item, inside, value);
          check(value, item, inside);
          (owner.*member).push_back(std::move(value));
        }
      },
      [=](const Owner& owner, int dim) -> std::optional<Input> {
        if ((owner.*member).empty()) return std::nullopt;
        Input items = Input::array();
        for (const Item& item : owner.*member) items.items().push_back(parameters_of<Item>().write(item, dim));
        return items;
      });
}

std::string named_label(const std::string& what, const Input& item, std::size_t index) {
  const Input* name = item.find("name");
  if (name != nullptr && name->kind() == Input::Kind::string) return fmt::format("{} {}", what, name->text());
  return fmt::format("{} {}", what, index + 1);
}
std::string body_label(const Input& item, std::size_t index) { return named_label("body", item, index); }
std::string probe_label(const Input& item, std::size_t index) { return named_label("probe", item, index); }
std::string boundary_label(const Input&, std::size_t index) { return fmt::format("boundary {}", index + 1); }

// --- bodies, boundaries ----------------------------------------------------------------------------------------------

void check_body(BodySpec& body, const Input& input, const ReadContext& context) {
  if (body.method == BodyMethod::elements) {
    if (body.layout)
      fail_input(at_key(input, "layout"), context,
                 "method = \"elements\" needs no layout: the cells of the grid in the region are the body");
    if (!body.region)
      fail_input(input, context,
                 fmt::format("region is missing (table with a type): the cells that the body consists of; allowed: {}",
                             list_names(region_registry().names())));
  } else {
    for (const char* key : {"weight_density", "receding_correction"}) {
      if (is_given(input, key)) fail_input(at_key(input, key), context, fmt::format("{} is for method = \"elements\" only", key));
    }
    if (!body.layout) {
      fail_input(input, context,
                 fmt::format("layout is missing (table with a type): How particles fill the region.; allowed: {}",
                             list_names(layout_registry().names())));
    }
  }
  if (body.name.empty()) fail_input(at_key(input, "name"), context, "name is empty; bodies are told apart by their names");
  if (!body.layout) return;
  if (body.layout->needs_region() && !body.region) {
    fail_input(
        input, context,
        fmt::format("region is missing (table with a type): what the body fills; allowed: {}", list_names(region_registry().names())));
  }
  if (!body.layout->needs_region() && body.region) {
    fail_input(at_key(input, "region"), context, "layout type = \"points\" says where the particles are; leave the region out");
  }
}

void check_velocity_table(BoundarySpec& boundary, const Input& input, const ReadContext& context) {
  const auto dim = static_cast<std::size_t>(context.dim);
  if (boundary.velocity_history && boundary.times.empty() && boundary.velocities.empty()) return;
  if (boundary.times.empty() == boundary.velocity.empty() || boundary.times.empty() != boundary.velocities.empty()) {
    fail_input(input, context, "kind = \"velocity\" needs velocity = [...], or a table: times = [...] with velocities = [[...], ...]");
  }
  if (!boundary.velocity.empty() && boundary.velocity.size() != dim) {
    fail_input(at_key(input, "velocity"), context,
               fmt::format("velocity has {} numbers; the case has dim = {}, so it must have {}", boundary.velocity.size(), dim, dim));
  }
  if (boundary.times.size() != boundary.velocities.size()) {
    fail_input(at_key(input, "velocities"), context,
               fmt::format("times has {} entries and velocities {}; they must match", boundary.times.size(), boundary.velocities.size()));
  }
  for (std::size_t k = 1; k < boundary.times.size(); ++k) {
    if (boundary.times[k] > boundary.times[k - 1]) continue;
    fail_input(at_key(input, "times"), context,
               fmt::format("times[{}] = {} must be greater than times[{}] = {}", k, boundary.times[k], k - 1, boundary.times[k - 1]));
  }
}

void check_boundary(BoundarySpec& boundary, const Input& input, const ReadContext& context) {
  if (is_given(input, "side") == is_given(input, "region")) {
    fail_input(input, context,
               is_given(input, "side") ? "side and region are both given; give one of them"
                                       : fmt::format("side is missing: give side = one of {}, or region = {{ type = ... }}",
                                                     list_names(side_names(context.dim))));
  }
  if (boundary.region == nullptr) check_words({boundary.side}, "side", side_names(context.dim), input, context);
  check_words(boundary.components, "components", axis_names(context.dim), input, context);
  if (boundary.kind == BoundaryKind::slip) {
    if (!boundary.components.empty()) {
      fail_input(
          at_key(input, "components"), context,
          "kind = \"slip\" fixes the direction normal to the side or region and takes no components; use kind = \"fixed\" with them");
    }
    if (boundary.region != nullptr && !boundary.region->has_normal()) {
      fail_input(
          at_key(input, "region"), context,
          "kind = \"slip\" needs a region with one surface: box, disk, sphere, polygon or half_space; give each part its own boundary");
    }
  }
  if (boundary.kind == BoundaryKind::traction) {
    if (boundary.traction.size() != static_cast<std::size_t>(context.dim)) {
      fail_input(at_key(input, "traction"), context,
                 fmt::format("kind = \"traction\" needs traction = [...] with {} numbers, got {}", context.dim, boundary.traction.size()));
    }
    if (!boundary.components.empty()) fail_input(at_key(input, "components"), context, "kind = \"traction\" takes no components");
  } else if (is_given(input, "traction")) {
    fail_input(at_key(input, "traction"), context, "traction is for kind = \"traction\" only");
  }
  if (boundary.contact != FaceContact::stick) {
    const bool is_friction = boundary.contact == FaceContact::friction;
    const bool has_kind = boundary.kind == BoundaryKind::fixed || boundary.kind == BoundaryKind::velocity ||
                          (boundary.kind == BoundaryKind::slip && !is_friction);
    const char* const problem =
        !has_kind && is_friction       ? "is for kind = \"fixed\" or \"velocity\""
        : !has_kind                    ? "is for kind = \"fixed\", \"velocity\" or \"slip\""
        : !boundary.components.empty() ? "needs all components, so no components"
        : boundary.region != nullptr && !boundary.region->has_normal()
            ? "needs a region with one surface: box, disk, sphere, polygon or half_space; give each part its own boundary"
            : nullptr;
    if (problem != nullptr)
      fail_input(at_key(input, "contact"), context, fmt::format("contact = {} {}", at_key(input, "contact").text(), problem));
    if (is_friction && !is_given(input, "friction"))
      fail_input(at_key(input, "contact"), context, "contact = \"friction\" needs friction, Coulomb's coefficient");
  }
  if (boundary.contact != FaceContact::friction && is_given(input, "friction"))
    fail_input(at_key(input, "friction"), context, "friction is for contact = \"friction\" only");
  if (boundary.kind == BoundaryKind::velocity) {
    check_velocity_table(boundary, input, context);
  } else {
    for (const char* key : {"velocity", "times", "velocities"}) {
      if (is_given(input, key)) fail_input(at_key(input, key), context, fmt::format("{} is for kind = \"velocity\" only", key));
    }
  }
}

// --- output, probes ------------------------------------------------------------------------------------

void check_output(OutputSpec& output, const Input& input, const ReadContext& context) {
  check_words(output.formats, "formats", {"vtkhdf", "vtu"}, input, context);
  check_words({output.precision}, "precision", {"single", "double"}, input, context);
}

void check_probe(ProbeSpec& probe, const Input& input, const ReadContext& context) {
  if (probe.particle.has_value() != probe.nearest.has_value()) return;
  fail_input(input, context,
             probe.particle ? "particle and nearest are both given; give one of them"
                            : "which particle? Give particle = its id, or nearest = [x, y] of a point");
}

[[noreturn]] void fail_at(const std::string& place, const std::string& text) { fail_input(Input::table().with_place(place), {}, text); }

template <class Item>
void check_unique_names(const std::vector<Item>& items, const std::string& what) {
  std::set<std::string> names;
  for (const Item& item : items) {
    if (names.insert(item.name).second) continue;
    fail_at(item.place, fmt::format("two {} have the name \"{}\"; give each its own", what == "body" ? "bodies" : what + "s", item.name));
  }
}

/// Output times that fit to the end of the run.
void check_output_times(const Case& problem, const Input& input) {
  constexpr Real k_outputs_max = 1e8;
  const Input* const table = input.find("output");
  if (table == nullptr) return;
  const ReadContext context{problem.dim, "output"};
  for (const Real t : problem.output.fields_at) {
    if (t <= problem.time.end) continue;
    fail_input(at_key(*table, "fields_at"), context, fmt::format("fields_at: {} s is after the end of the run, {} s", t, problem.time.end));
  }
  const auto check_interval = [&](const std::string& key, const std::optional<Real>& every) {
    if (!every || problem.time.end / *every <= k_outputs_max) return;
    fail_input(at_key(*table, key), context,
               fmt::format("{} = {} makes {:.3g} outputs until the end of the run, {} s; at most {:.0g} are possible", key, *every,
                           problem.time.end / *every, problem.time.end, k_outputs_max));
  };
  check_interval("history_every", problem.output.history_every);
  check_interval("fields_every", problem.output.fields_every);
}

void check_gravity_table(const Case& problem, const Input& input) {
  const std::vector<Real>& times = problem.gravity_times;
  if (times.size() != problem.gravity_factors.size()) {
    fail_input(
        at_key(input, times.empty() ? "gravity_factors" : "gravity_times"), {problem.dim, ""},
        fmt::format("gravity_times has {} entries and gravity_factors {}; they must match", times.size(), problem.gravity_factors.size()));
  }
  for (std::size_t k = 1; k < times.size(); ++k) {
    if (times[k] > times[k - 1]) continue;
    fail_input(at_key(input, "gravity_times"), {problem.dim, ""},
               fmt::format("gravity_times[{}] = {} must be greater than gravity_times[{}] = {}", k, times[k], k - 1, times[k - 1]));
  }
}

/// The components that a condition on a side holds, as letters; "t" for a load.
std::string held_components(const BoundarySpec& boundary, int dim) {
  if (boundary.kind == BoundaryKind::traction) return "t";
  if (boundary.kind == BoundaryKind::slip) {
    const std::vector<std::string> sides = side_names(dim);
    return std::string(1, "xyz"[(std::find(sides.begin(), sides.end(), boundary.side) - sides.begin()) / 2]);
  }
  std::string letters;
  for (const std::string& component : boundary.components.empty() ? axis_names(dim) : boundary.components) letters += component;
  return letters;
}

/// A side may be named by several conditions, but not twice for the same component: the first would do nothing.
void check_sides_named_once(const Case& problem) {
  for (std::size_t b = 0; b < problem.boundaries.size(); ++b) {
    const BoundarySpec& boundary = problem.boundaries[b];
    if (boundary.region != nullptr) continue;
    for (std::size_t a = 0; a < b; ++a) {
      const BoundarySpec& earlier = problem.boundaries[a];
      if (earlier.region != nullptr || earlier.side != boundary.side) continue;
      const std::string held = held_components(earlier, problem.dim);
      const std::string named = held_components(boundary, problem.dim);
      const std::size_t common = named.find_first_of(held);
      if (common == std::string::npos) continue;
      fail_at(
          boundary.place,
          fmt::format("boundary {}: side = \"{}\" has {} already from boundary {}; keep one of them, or give them different components",
                      b + 1, boundary.side, named[common] == 't' ? "a traction" : fmt::format("its component {}", named[common]), a + 1));
    }
  }
}

/// What only the whole case knows.
void check_together(const Case& problem) {
  if (problem.bodies.empty()) throw InputError("the case has no body; add [[body]] with name, region, layout and material");
  check_unique_names(problem.bodies, "body");
  check_unique_names(problem.probes, "probe");
  check_sides_named_once(problem);
  for (std::size_t b = 0; b < problem.boundaries.size(); ++b) {
    const BoundarySpec& boundary = problem.boundaries[b];
    const std::vector<std::string> sides = side_names(problem.dim);
    const auto side = std::find(sides.begin(), sides.end(), boundary.side);
    if (side == sides.end()) continue;
    const std::string axis(1, "xyz"[(side - sides.begin()) / 2]);
    const std::vector<std::string>& periodic = problem.grid.periodic;
    if (std::find(periodic.begin(), periodic.end(), axis) != periodic.end()) {
      fail_at(boundary.place, fmt::format("boundary {}: side = \"{}\" is periodic (grid.periodic has \"{}\"), so it has no boundary", b + 1,
                                          boundary.side, axis));
    }
  }
}

}  // namespace

void BodySpec::declare(ParameterTable<BodySpec>& table) {
  table.required("name", "1", &BodySpec::name, any_number(), "Names the body in results, probes and messages.");
  table.choice("method", &BodySpec::method, {{"particles", BodyMethod::particles}, {"elements", BodyMethod::elements}},
               "particles: material points; elements: a body of finite elements, the cells of the grid in the region (implicit solver).");
  table.choice("formulation", &BodySpec::formulation, {{"updated", Formulation::updated}, {"total", Formulation::total}},
               "Of particles, explicit solver: shape functions at their places now, or where they were at the start (total Lagrangian).");
  table.custom(
      {"fbar", "1", "true or false", "false", "",
       "Of particles, explicit solver: all particles of a cell change their volume at the mean rate, which frees nearly incompressible "
       "ones "
       "from locking.",
       false},
      [](BodySpec& body, const Input& input, const ReadContext& context) {
        read_value(input, context, "fbar", any_number(), body.has_fbar);
      },
      [](const BodySpec& body, int) -> std::optional<Input> {
        if (!body.has_fbar) return std::nullopt;
        return Input::boolean(true);
      });
  typed(table, "region", &BodySpec::region, region_registry, "What the body fills at the start; layout type = \"points\" needs none.",
        false);
  typed(table, "layout", &BodySpec::layout, layout_registry, "How particles fill the region; a body of elements has none.", false);
  typed(table, "velocity", &BodySpec::velocity, velocity_registry, "Initial velocity; without it the body is at rest.", false);
  typed(table, "material", &BodySpec::material, material_registry, "The constitutive law with its parameters.", true);
  table.optional("weight_density", "kg/m^3", &BodySpec::weight_density, non_negative(),
                 "Of a body of elements: the density that gravity acts on; without it the material's.");
  table.custom(
      {"receding_correction", "1", "number", "0", "0 <= value <= 1", "Of a body of elements: C_c for particles that recede from its faces.",
       false},
      [](BodySpec& body, const Input& input, const ReadContext& context) {
        read_value(input, context, "receding_correction", between_closed(0, 1), body.receding_correction);
      },
      [](const BodySpec& body, int) -> std::optional<Input> {
        if (body.receding_correction == 0) return std::nullopt;
        return Input::real(body.receding_correction);
      });
}

void BoundarySpec::declare(ParameterTable<BoundarySpec>& table) {
  table.custom(
      {"side", "1", "string", "", "\"left\", \"right\" (x), \"bottom\", \"top\" (y), \"front\", \"back\" (z, 3D)",
       "Side of the grid; either this or region.", false},
      [](BoundarySpec& boundary, const Input& input, const ReadContext& context) {
        read_value(input, context, "side", any_number(), boundary.side);
      },
      [](const BoundarySpec& boundary, int) -> std::optional<Input> {
        if (boundary.side.empty()) return std::nullopt;
        return Input::string(boundary.side);
      });
  typed(table, "region", &BoundarySpec::region, region_registry, "All nodes in a region: an obstacle, a support, a moving wall.", false);
  table.choice("kind", &BoundarySpec::kind,
               {{"fixed", BoundaryKind::fixed},
                {"slip", BoundaryKind::slip},
                {"velocity", BoundaryKind::velocity},
                {"traction", BoundaryKind::traction}},
               "fixed: velocity zero; slip: no velocity through the side or the region's surface; velocity: a given velocity; traction: a "
               "dead load on "
               "the faces of a body of elements.");
  table.custom(
      {"components", "1", type_text<std::vector<std::string>>(), "all", "\"x\", \"y\", \"z\"", "Components that fixed and velocity hold.",
       false},
      [](BoundarySpec& boundary, const Input& input, const ReadContext& context) {
        read_value(input, context, "components", any_number(), boundary.components);
        if (boundary.components.empty()) fail_input(input, context, "components = [] holds nothing; leave it out to hold all");
      },
      [](const BoundarySpec& boundary, int dim) -> std::optional<Input> {
        if (boundary.components.empty()) return std::nullopt;
        return write_value(boundary.components, dim);
      });
  table.custom(
      {"attached", "1", "true or false", "false", "",
       "Implicit solver: the body grows out of this side, so its nodes are no free surface for the soft stiffness.", false},
      [](BoundarySpec& boundary, const Input& input, const ReadContext& context) {
        read_value(input, context, "attached", any_number(), boundary.is_attached);
      },
      [](const BoundarySpec& boundary, int) -> std::optional<Input> {
        if (!boundary.is_attached) return std::nullopt;
        return Input::boolean(true);
      });
  table.custom(
      {"receding_correction", "1", "number", "0", "0 <= value <= 1",
       "C_c, implicit solver on elements: how far particles in the first row of cells that recede from this side are let go.", false},
      [](BoundarySpec& boundary, const Input& input, const ReadContext& context) {
        read_value(input, context, "receding_correction", between_closed(0, 1), boundary.receding_correction);
      },
      [](const BoundarySpec& boundary, int) -> std::optional<Input> {
        if (boundary.receding_correction == 0) return std::nullopt;
        return Input::real(boundary.receding_correction);
      });
  table.choice("contact", &BoundarySpec::contact,
               {{"stick", FaceContact::stick}, {"no_tension", FaceContact::no_tension}, {"friction", FaceContact::friction}},
               "Of a rigid surface: stick holds what touches it for good; no_tension lets go what it would have to pull; friction does so, "
               "too, and holds along itself with no more than friction times the pressure.");
  table.custom(
      {"friction", "1", "number", "", ">= 0", "Coulomb's coefficient of contact = \"friction\".", false},
      [](BoundarySpec& boundary, const Input& input, const ReadContext& context) {
        read_value(input, context, "friction", non_negative(), boundary.friction);
      },
      [](const BoundarySpec& boundary, int) -> std::optional<Input> {
        if (boundary.contact != FaceContact::friction) return std::nullopt;
        return Input::real(boundary.friction);
      });
  const auto unless_empty = [](const auto& values, int dim) -> std::optional<Input> {
    if (values.empty()) return std::nullopt;
    return write_value(values, dim);
  };
  table.custom(
      {"velocity", "m/s", "dim numbers", "", "", "The velocity, constant in time.", false},
      [](BoundarySpec& boundary, const Input& input, const ReadContext& context) {
        boundary.velocity_history = input.as_object<VelocityHistory>();
        if (!boundary.velocity_history) read_value(input, context, "velocity", any_number(), boundary.velocity);
      },
      [=](const BoundarySpec& boundary, int dim) -> std::optional<Input> {
        if (boundary.velocity_history) return Input::string("a function of time");
        return unless_empty(boundary.velocity, dim);
      });
  table.custom(
      {"traction", "Pa", "dim numbers", "", "", "For kind = \"traction\": force per undeformed area, which keeps its direction.", false},
      [](BoundarySpec& boundary, const Input& input, const ReadContext& context) {
        read_value(input, context, "traction", any_number(), boundary.traction);
      },
      [=](const BoundarySpec& boundary, int dim) { return unless_empty(boundary.traction, dim); });
  table.custom(
      {"times", "s", "array of numbers", "", "ascending", "Times of a table of velocities: linear between, constant before and after.",
       false},
      [](BoundarySpec& boundary, const Input& input, const ReadContext& context) {
        read_value(input, context, "times", any_number(), boundary.times);
      },
      [=](const BoundarySpec& boundary, int dim) { return unless_empty(boundary.times, dim); });
  table.custom(
      {"velocities", "m/s", "array of points", "", "as many as times", "Velocities of the table, dim numbers each.", false},
      [](BoundarySpec& boundary, const Input& input, const ReadContext& context) {
        read_value(input, context, "velocities", any_number(), boundary.velocities);
      },
      [=](const BoundarySpec& boundary, int dim) { return unless_empty(boundary.velocities, dim); });
}

void OutputSpec::declare(ParameterTable<OutputSpec>& table) {
  table.optional("history_every", "s", &OutputSpec::history_every, positive(), "Interval of history.csv and probes; default: 200 rows.");
  table.optional("fields_every", "s", &OutputSpec::fields_every, positive(),
                 "Interval of field files; default: 50 times, none with fields_at.");
  table.optional("fields_at", "s", &OutputSpec::fields_at, non_negative(), "Further times of field files.");
  table.optional("formats", "1", &OutputSpec::formats, any_number(),
                 "Of field files: \"vtkhdf\" (ParaView 5.12 or newer, PyVista), \"vtu\" (older ParaView).");
  table.optional("fields", "1", &OutputSpec::fields, any_number(), "Fields to write; empty for all (`matpoint list fields`).");
  table.optional("grid", "1", &OutputSpec::grid, any_number(), "Whether the nodes' mass and velocity are written, too.");
  table.optional("precision", "1", &OutputSpec::precision, any_number(), "\"single\" or \"double\", of field files.");
  table.optional("compression", "1", &OutputSpec::compression,
                 Constraint{"an integer from 0 to 9", [](Real x) { return x >= 0 && x <= 9; }},
                 "gzip level of VTKHDF files: 0 for none, 1 fast to 9 small.");
}

void ProbeSpec::declare(ParameterTable<ProbeSpec>& table) {
  table.required("name", "1", &ProbeSpec::name, any_number(), "Names the file probe_<name>.csv.");
  table.required("body", "1", &ProbeSpec::body, any_number(), "The particle's body.");
  table.optional("particle", "1", &ProbeSpec::particle, non_negative(), "The particle's id; either this or nearest.");
  table.optional("nearest", "m", &ProbeSpec::nearest, any_number(), "The particle that is nearest to this point at the start.");
}

void Case::declare(ParameterTable<Case>& table) {
  table.optional("title", "1", &Case::title, any_number(), "One line on what is simulated.");
  table.optional("source", "1", &Case::source, any_number(), "Where the problem comes from.");
  table.optional("dim", "1", &Case::dim, any_number(), "2 (plane strain) or 3.");
  table.optional("gravity", "m/s^2", &Case::gravity, any_number(), "Body force per mass.");
  const auto unless_empty = [](const std::vector<Real>& values, int dim) -> std::optional<Input> {
    if (values.empty()) return std::nullopt;
    return write_value(values, dim);
  };
  table.custom(
      {"gravity_times", "s", "array of numbers", "", "ascending",
       "Times of a table of factors of gravity: linear between, constant outside.", false},
      [](Case& problem, const Input& input, const ReadContext& context) {
        read_value(input, context, "gravity_times", non_negative(), problem.gravity_times);
      },
      [=](const Case& problem, int dim) { return unless_empty(problem.gravity_times, dim); });
  table.custom(
      {"gravity_factors", "1", "array of numbers", "", "as many as gravity_times", "The factors, e.g. [1, 0] for gravity that ceases.",
       false},
      [](Case& problem, const Input& input, const ReadContext& context) {
        read_value(input, context, "gravity_factors", any_number(), problem.gravity_factors);
      },
      [=](const Case& problem, int dim) { return unless_empty(problem.gravity_factors, dim); });
  table.custom(
      {"body_force", "m/s^2", "function", "", "from programs only", "Body force per mass, a function of position and time.", false},
      [](Case& problem, const Input& input, const ReadContext& context) {
        problem.body_force = input.as_object<BodyForce>();
        if (!problem.body_force) {
          fail_input(input, context,
                     fmt::format("body_force = {} must be a function of position, which only a program can give", input.text()));
        }
      },
      [](const Case& problem, int) -> std::optional<Input> {
        if (!problem.body_force) return std::nullopt;
        return Input::string("a function of position");
      });
  section(table, "grid", &Case::grid, "The background grid.", true, check_grid);
  section(table, "time", &Case::time, "End and time step.", true, check_time);
  declare_solver(table);
  section(table, "output", &Case::output, "What is written, and when.", false, check_output);
  list_of(table, "body", &Case::bodies, "A body of particles.", true, body_label, check_body);
  list_of(table, "boundary", &Case::boundaries, "A condition on nodes of the grid.", false, boundary_label, check_boundary);
  list_of(table, "probe", &Case::probes, "A particle whose motion and stress are written over time.", false, probe_label, check_probe);
}

Case Case::from_input(const Input& input, const std::string& name) {
  Case problem;
  problem.name = name;
  ReadContext context;
  // Everything else is read in the light of the dimension.
  if (const Input* dim = input.find("dim")) {
    read_value(*dim, context, "dim", any_number(), problem.dim);
    if (problem.dim != 2 && problem.dim != 3)
      fail_input(*dim, context, fmt::format("dim = {} is not allowed, it must be 2 or 3", dim->text()));
  }
  context.dim = problem.dim;
  parameters_of<Case>().read(input, context, problem);
  check_together(problem);
  check_gravity_table(problem, input);
  check_for_solver(problem, input);
  check_output_times(problem, input);
  return problem;
}

Real Case::load_factor(Real t) const {
  if (!gravity_times.empty()) return interpolated(gravity_times, gravity_factors, t);
  return is_implicit() && implicit.mode == ImplicitMode::quasi_static ? t / time.end : 1;
}

Vec3 Case::gravity_at(Real t) const {
  const Real factor = load_factor(t);
  return {factor * gravity[0], factor * gravity[1], factor * gravity[2]};
}

Input Case::to_input() const { return parameters_of<Case>().write(*this, dim); }

std::vector<CaseSection> case_sections() {
  return {{"case", "What stands at the top of a case file, before the first section.", parameters_of<Case>().describe()},
          {"grid", "The background grid: a box of equal cells.", parameters_of<GridSpec>().describe()},
          {"time", "End and time step.", parameters_of<TimeSpec>().describe()},
          {"solver", "The explicit scheme.", parameters_of<SolverSpec>().describe()},
          {"implicit_solver", "[solver] with type = \"implicit\": Newmark and Newton on B-splines or elements.",
           parameters_of<ImplicitSpec>().describe()},
          {"body", "[[body]], one for each: a region filled with particles of one material.", parameters_of<BodySpec>().describe()},
          {"boundary", "[[boundary]], one for each: a condition on the nodes of a side or region; later ones win.",
           parameters_of<BoundarySpec>().describe()},
          {"output", "What is written, and when.", parameters_of<OutputSpec>().describe()},
          {"probe", "[[probe]], one for each: a particle's motion and stress over time.", parameters_of<ProbeSpec>().describe()}};
}

}  // namespace matpoint
