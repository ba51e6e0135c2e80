#include "case/case.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "case/case_reading.hpp"
#include "case/solver_checks.hpp"
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
std::string load_label(const Input& item, std::size_t index) { return named_label("load", item, index); }
std::string tool_label(const Input& item, std::size_t index) { return named_label("tool", item, index); }
std::string boundary_label(const Input&, std::size_t index) { return fmt::format("boundary {}", index + 1); }

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

void check_base_acceleration(const Case& problem, const Input& input) {
  const std::vector<Real>& times = problem.base_acceleration_times;
  const ReadContext context{problem.dim, ""};
  if (times.size() != problem.base_acceleration.size()) {
    fail_input(at_key(input, times.empty() ? "base_acceleration" : "base_acceleration_times"), context,
               fmt::format("base_acceleration_times has {} entries and base_acceleration {}; they must match", times.size(),
                           problem.base_acceleration.size()));
  }
  for (std::size_t k = 1; k < times.size(); ++k) {
    if (times[k] > times[k - 1]) continue;
    fail_input(at_key(input, "base_acceleration_times"), context,
               fmt::format("base_acceleration_times[{}] = {} must be greater than base_acceleration_times[{}] = {}", k, times[k], k - 1,
                           times[k - 1]));
  }
}

/// What loads, tools and bodies say of each other.
void check_loads(const Case& problem) {
  std::set<std::string> taken;
  for (const std::string& name : boundary_names(problem.boundaries)) taken.insert(name);
  std::vector<std::string> bodies;
  for (const BodySpec& body : problem.bodies) {
    bodies.push_back(body.name);
    taken.insert(body.name);
  }
  for (const ToolSpec& tool : problem.tools) {
    if (!taken.insert(tool.name).second)
      fail_at(tool.place, fmt::format("tool {0}: a tool, boundary or body has the name \"{0}\" already; give each its own", tool.name));
  }
  const std::vector<std::string> names = load_names(problem.loads);
  for (std::size_t k = 0; k < problem.loads.size(); ++k) {
    const LoadSpec& load = problem.loads[k];
    const auto fail = [&](const std::string& text) { fail_at(load.place, fmt::format("load {}: {}", names[k], text)); };
    if (!taken.insert(names[k]).second)
      fail(fmt::format("a load, tool, boundary or body has the name \"{}\" already; give each its own", names[k]));
    const auto body = std::find(bodies.begin(), bodies.end(), load.body);
    if (body == bodies.end())
      fail(fmt::format("body = \"{}\" is unknown, allowed: {}{}", load.body, list_names(bodies), did_you_mean(load.body, bodies)));
    const BodySpec& spec = problem.bodies[static_cast<std::size_t>(body - bodies.begin())];
    if (spec.method == BodyMethod::elements) {
      fail(
          fmt::format("body \"{}\" consists of elements; loads on their faces are boundaries with kind = \"traction\", and this is for "
                      "bodies of particles",
                      load.body));
    }
    if (load.is_on_surface() && spec.material->is_fluid()) {
      fail(
          fmt::format("body \"{}\" is a fluid, whose particles do not stay at its surface; a load on it can only be kind = \"force\" "
                      "without a side",
                      load.body));
    }
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
  check_loads(problem);
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
      {"base_acceleration", "m/s^2", "array of points", "", "as many as base_acceleration_times",
       "Acceleration of the ground, e.g. an earthquake's record, dim numbers at each time; the case is seen from the ground, with "
       "velocities against it.",
       false},
      [](Case& problem, const Input& input, const ReadContext& context) {
        read_value(input, context, "base_acceleration", any_number(), problem.base_acceleration);
      },
      [](const Case& problem, int dim) -> std::optional<Input> {
        if (problem.base_acceleration.empty()) return std::nullopt;
        return write_value(problem.base_acceleration, dim);
      });
  table.custom(
      {"base_acceleration_times", "s", "array of numbers", "", "ascending",
       "Times of base_acceleration: linear between, none before the first and after the last.", false},
      [](Case& problem, const Input& input, const ReadContext& context) {
        read_value(input, context, "base_acceleration_times", any_number(), problem.base_acceleration_times);
      },
      [=](const Case& problem, int dim) { return unless_empty(problem.base_acceleration_times, dim); });
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
  list_of(table, "load", &Case::loads, "A force on the particles of a body.", false, load_label, check_load);
  list_of(table, "tool", &Case::tools, "A rigid body that touches particles.", false, tool_label, check_tool);
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
  choose_scheme(problem, input);
  const std::vector<std::string>& fields = problem.output.fields;
  const bool has_displacement = std::find(fields.begin(), fields.end(), "displacement") != fields.end();
  for (BodySpec& body : problem.bodies) body.keeps_displacement = has_displacement;
  check_together(problem);
  resolve_initial_stresses(problem);
  check_gravity_table(problem, input);
  check_base_acceleration(problem, input);
  check_for_solver(problem, input);
  check_output_times(problem, input);
  return problem;
}

Real Case::load_factor(Real t) const {
  if (!gravity_times.empty()) return interpolated(gravity_times, gravity_factors, t);
  return is_implicit() && implicit.mode == ImplicitMode::quasi_static ? t / time.end : 1;
}

Real Case::load_factor(const LoadSpec& load, Real t) const {
  if (!load.times.empty()) return interpolated(load.times, load.factors, t);
  return is_implicit() && implicit.mode == ImplicitMode::quasi_static ? t / time.end : 1;
}

Vec3 Case::gravity_at(Real t) const {
  const Real factor = load_factor(t);
  Vec3 base{};
  const std::vector<Real>& times = base_acceleration_times;
  if (!times.empty() && t >= times.front() && t <= times.back()) base = interpolated(times, base_acceleration, t);
  return {factor * gravity[0] - base[0], factor * gravity[1] - base[1], factor * gravity[2] - base[2]};
}

std::vector<std::string> Case::functions() const {
  std::vector<std::string> all;
  const auto is_text = [&](const RegionPointer& region) { return region && region->write(dim).kind() == Input::Kind::string; };
  if (body_force) all.push_back("body_force");
  for (const BodySpec& body : bodies) {
    if (is_text(body.region)) all.push_back(fmt::format("region of body \"{}\"", body.name));
    if (body.material->law_index() < 0) all.push_back(fmt::format("material of body \"{}\"", body.name));
  }
  for (const ToolSpec& tool : tools) {
    if (is_text(tool.shape)) all.push_back(fmt::format("shape of tool {}", tool.name));
  }
  const std::vector<std::string> loaded = load_names(loads);
  for (std::size_t k = 0; k < loads.size(); ++k) {
    if (is_text(loads[k].region)) all.push_back(fmt::format("region of load {}", loaded[k]));
  }
  const std::vector<std::string> names = boundary_names(boundaries);
  for (std::size_t b = 0; b < boundaries.size(); ++b) {
    if (is_text(boundaries[b].region)) all.push_back(fmt::format("region of boundary {}", names[b]));
    if (boundaries[b].velocity_history) all.push_back(fmt::format("velocity of boundary {}", names[b]));
  }
  return all;
}

Input Case::to_input() const { return parameters_of<Case>().write(*this, dim); }

std::vector<CaseSection> case_sections() {
  return {{"case", "What stands at the top of a case file, before the first section.", parameters_of<Case>().describe()},
          {"grid", "The background grid: a box of equal cells.", parameters_of<GridSpec>().describe()},
          {"ring", "The table ring of [grid]: the sector of a ring about an axis along z, into which the box is mapped.",
           parameters_of<RingSpec>().describe()},
          {"time", "End and time step.", parameters_of<TimeSpec>().describe()},
          {"solver", "The explicit scheme.", parameters_of<SolverSpec>().describe()},
          {"implicit_solver", "[solver] with type = \"implicit\": Newmark and Newton on B-splines or elements.",
           parameters_of<ImplicitSpec>().describe()},
          {"body", "[[body]], one for each: a region filled with particles of one material.", parameters_of<BodySpec>().describe()},
          {"boundary", "[[boundary]], one for each: a condition on the nodes of a side or region; later ones win.",
           parameters_of<BoundarySpec>().describe()},
          {"load", "[[load]], one for each: a pressure, traction or force on a body of particles.", parameters_of<LoadSpec>().describe()},
          {"tool", "[[tool]], one for each: a rigid body that moves as it is told, or freely, and touches particles.",
           parameters_of<ToolSpec>().describe()},
          {"output", "What is written, and when.", parameters_of<OutputSpec>().describe()},
          {"probe", "[[probe]], one for each: a particle's motion and stress over time.", parameters_of<ProbeSpec>().describe()}};
}

}  // namespace matpoint
