#include "case/case.hpp"

#include <algorithm>
#include <cmath>
#include <set>

namespace matpoint {
namespace {

constexpr Real k_nodes_max = 4e9;

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

/// Something chosen by `type` from a registry.
template <class Owner, class Base>
void typed(ParameterTable<Owner>& table, const std::string& name, std::shared_ptr<Base> Owner::*member,
           const TypeRegistry<Base>& (*registry)(), const std::string& help, bool is_required) {
  table.custom(
      {name, "1", "table with a type", "", list_names(registry().names()), help, is_required},
      [=](Owner& owner, const Input& input, const ReadContext& context) { owner.*member = registry().read(input, context, name); },
      [=](const Owner& owner, int dim) -> std::optional<Input> {
        if (!(owner.*member)) return std::nullopt;
        return (owner.*member)->write(dim);
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

/// The given value, for the place of a message; the table itself when the key is absent.
const Input& at_key(const Input& table, const std::string& key) {
  const Input* value = table.find(key);
  return value != nullptr ? *value : table;
}

bool is_given(const Input& table, const std::string& key) { return table.find(key) != nullptr; }

void check_words(const std::vector<std::string>& given, const std::string& key, const std::vector<std::string>& allowed, const Input& table,
                 const ReadContext& context) {
  for (const std::string& word : given) {
    if (std::find(allowed.begin(), allowed.end(), word) != allowed.end()) continue;
    fail_input(at_key(table, key), context,
               fmt::format("{}: \"{}\" is unknown, allowed: {}{}", key, word, list_names(allowed), did_you_mean(word, allowed)));
  }
}

std::vector<std::string> axis_names(int dim) {
  return dim == 2 ? std::vector<std::string>{"x", "y"} : std::vector<std::string>{"x", "y", "z"};
}

std::vector<std::string> side_names(int dim) {
  std::vector<std::string> names = {"left", "right", "bottom", "top"};
  if (dim == 3) names.insert(names.end(), {"front", "back"});
  return names;
}

// --- grid ------------------------------------------------------------------------------------------------------------

void cells_from_size(GridSpec& grid, const Input& input, const ReadContext& context) {
  const auto dim = static_cast<std::size_t>(context.dim);
  const Input& given = at_key(input, "cell_size");
  if (grid.cell_size.size() != 1 && grid.cell_size.size() != dim) {
    fail_input(given, context,
               fmt::format("cell_size = {} has {} numbers; give one, or one per direction ({})", given.text(), grid.cell_size.size(), dim));
  }
  if (grid.cell_size.size() == 1) grid.cell_size.resize(dim, grid.cell_size[0]);
  for (std::size_t d = 0; d < dim; ++d) {
    const Real side = grid.upper[d] - grid.lower[d];
    const Real exact = side / grid.cell_size[d];
    const Real whole = std::round(exact);
    if (whole < 1 || whole > 2e9 || std::abs(exact - whole) > 1e-9 * whole) {
      const Real nearest = side / std::max(Real{1}, whole);
      fail_input(given, context,
                 fmt::format("cell_size = {} does not divide the side of {} m in {} ({} cells); the nearest that does is {:.10g}",
                             grid.cell_size[d], side, "xyz"[d], exact, nearest));
    }
    grid.cells.push_back(static_cast<int>(whole));
  }
}

void check_grid(GridSpec& grid, const Input& input, const ReadContext& context) {
  const auto dim = static_cast<std::size_t>(context.dim);
  for (std::size_t d = 0; d < dim; ++d) {
    if (grid.upper[d] > grid.lower[d]) continue;
    fail_input(at_key(input, "upper"), context,
               fmt::format("upper[{}] = {} must be greater than lower[{}] = {}", d, grid.upper[d], d, grid.lower[d]));
  }
  if (is_given(input, "cells") == is_given(input, "cell_size")) {
    fail_input(input, context,
               is_given(input, "cells") ? "cells and cell_size are both given; give one of them"
                                        : "cells is missing: give cells = [...], or cell_size = ...");
  }
  if (is_given(input, "cells")) {
    if (grid.cells.size() != dim) {
      const Input& given = at_key(input, "cells");
      fail_input(
          given, context,
          fmt::format("cells = {} has {} numbers; the case has dim = {}, so it must have {}", given.text(), grid.cells.size(), dim, dim));
    }
    for (std::size_t d = 0; d < dim; ++d) grid.cell_size.push_back((grid.upper[d] - grid.lower[d]) / grid.cells[d]);
  } else {
    cells_from_size(grid, input, context);
  }
  Real nodes = 1;
  for (std::size_t d = 0; d < dim; ++d) {
    nodes *= static_cast<Real>(grid.cells[d]) + 1;
    const Real size = grid.cell_size[d];
    if (!(size > 0) || !std::isfinite(size) || !std::isfinite(1 / size)) {
      fail_input(input, context,
                 fmt::format("the cells' side of {} m in {} is beyond the range of numbers; lengths are in m", size, "xyz"[d]));
    }
  }
  if (nodes > k_nodes_max)
    fail_input(input, context,
               fmt::format("the grid has {:.3g} nodes, at most {:.0g} are possible; take larger cells", nodes, k_nodes_max));
  check_words(grid.periodic, "periodic", axis_names(context.dim), input, context);
}

// --- bodies, boundaries ----------------------------------------------------------------------------------------------

void check_body(BodySpec& body, const Input& input, const ReadContext& context) {
  if (body.name.empty()) fail_input(at_key(input, "name"), context, "name is empty; bodies are told apart by their names");
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
  if (boundary.kind == BoundaryKind::velocity) {
    check_velocity_table(boundary, input, context);
  } else {
    for (const char* key : {"velocity", "times", "velocities"}) {
      if (is_given(input, key)) fail_input(at_key(input, key), context, fmt::format("{} is for kind = \"velocity\" only", key));
    }
  }
}

// --- solver, time, output, probes ------------------------------------------------------------------------------------

void check_solver(SolverSpec& solver, const Input& input, const ReadContext& context) {
  check_words({solver.type}, "type", {"explicit"}, input, context);
  check_words({solver.precision}, "precision", {"double", "single"}, input, context);
  solver.mass_cutoff_place = at_key(input, solver.mass_cutoff ? "mass_cutoff" : "mass_cutoff_relative").place();
  if (solver.mass_cutoff && is_given(input, "mass_cutoff_relative")) {
    fail_input(at_key(input, "mass_cutoff_relative"), context, "mass_cutoff and mass_cutoff_relative are both given; give one of them");
  }
}

void check_time(TimeSpec& time, const Input& input, const ReadContext& context) {
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

/// What only the whole case knows.
void check_together(const Case& problem) {
  if (problem.bodies.empty()) throw InputError("the case has no body; add [[body]] with name, region, layout and material");
  check_unique_names(problem.bodies, "body");
  check_unique_names(problem.probes, "probe");
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

void GridSpec::declare(ParameterTable<GridSpec>& table) {
  table.optional("lower", "m", &GridSpec::lower, any_number(), "Corner with the smallest coordinates.");
  table.required("upper", "m", &GridSpec::upper, any_number(), "Corner with the largest coordinates.");
  table.optional("cells", "1", &GridSpec::cells, at_least(1), "Cells per direction; either this or cell_size.");
  table.custom(
      {"cell_size", "m", type_text<std::vector<Real>>(), "", "> 0, divides the sides to 1e-9",
       "Side of a cell, one number or one per direction.", false},
      [](GridSpec& grid, const Input& input, const ReadContext& context) {
        read_value(input, context, "cell_size", positive(), grid.cell_size);
      },
      [](const GridSpec&, int) -> std::optional<Input> { return std::nullopt; });  // written as cells
  table.optional("periodic", "1", &GridSpec::periodic, any_number(), "Directions in which the two sides are one, e.g. [\"x\"].");
  table.choice(
      "particles_outside", &GridSpec::particles_outside,
      {{"error", OutsidePolicy::error}, {"remove", OutsidePolicy::remove}, {"stop", OutsidePolicy::stop}},
      "What happens when a particle leaves the grid: the run fails, the particle is removed and booked, or the run ends normally.");
}

void BodySpec::declare(ParameterTable<BodySpec>& table) {
  table.required("name", "1", &BodySpec::name, any_number(), "Names the body in results, probes and messages.");
  typed(table, "region", &BodySpec::region, region_registry, "What the body fills at the start; layout type = \"points\" needs none.",
        false);
  typed(table, "layout", &BodySpec::layout, layout_registry, "How particles fill the region.", true);
  typed(table, "velocity", &BodySpec::velocity, velocity_registry, "Initial velocity; without it the body is at rest.", false);
  typed(table, "material", &BodySpec::material, material_registry, "The constitutive law with its parameters.", true);
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
               {{"fixed", BoundaryKind::fixed}, {"slip", BoundaryKind::slip}, {"velocity", BoundaryKind::velocity}},
               "fixed: velocity zero; slip: no velocity through the side or the region's surface; velocity: a given velocity.");
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

void SolverSpec::declare(ParameterTable<SolverSpec>& table) {
  table.optional("type", "1", &SolverSpec::type, any_number(), "\"explicit\".");
  table.choice("stress_order", &SolverSpec::stress_order,
               {{"usl", StressOrder::usl}, {"usf", StressOrder::usf}, {"musl", StressOrder::musl}},
               "When a step updates the stress: last (usl), first (usf), or last from velocities mapped once more (musl).");
  table.optional("flip", "1", &SolverSpec::flip, between_closed(0, 1), "Share of FLIP in the particles' velocity; the rest is PIC.");
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

void TimeSpec::declare(ParameterTable<TimeSpec>& table) {
  table.required("end", "s", &TimeSpec::end, positive(), "The run ends at this time.");
  table.optional("dt", "s", &TimeSpec::dt, positive(), "Fixed time step; without it steps are automatic.");
  const auto automatic = [&table](const std::string& name, const std::string& unit, auto member, Constraint constraint,
                                  const std::string& default_text, const std::string& help) {
    table.custom(
        {name, unit, "number", default_text, constraint.text, help, false},
        [=](TimeSpec& time, const Input& input, const ReadContext& context) { read_value(input, context, name, constraint, time.*member); },
        [=](const TimeSpec& time, int) -> std::optional<Input> {
          if (time.dt) return std::nullopt;
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
  section(table, "solver", &Case::solver, "The scheme.", false, check_solver);
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
  check_output_times(problem, input);
  return problem;
}

Input Case::to_input() const { return parameters_of<Case>().write(*this, dim); }

std::vector<CaseSection> case_sections() {
  return {{"case", "What stands at the top of a case file, before the first section.", parameters_of<Case>().describe()},
          {"grid", "The background grid: a box of equal cells.", parameters_of<GridSpec>().describe()},
          {"time", "End and time step.", parameters_of<TimeSpec>().describe()},
          {"solver", "The explicit scheme.", parameters_of<SolverSpec>().describe()},
          {"body", "[[body]], one for each: a region filled with particles of one material.", parameters_of<BodySpec>().describe()},
          {"boundary", "[[boundary]], one for each: a condition on the nodes of a side or region; later ones win.",
           parameters_of<BoundarySpec>().describe()},
          {"output", "What is written, and when.", parameters_of<OutputSpec>().describe()},
          {"probe", "[[probe]], one for each: a particle's motion and stress over time.", parameters_of<ProbeSpec>().describe()}};
}

}  // namespace matpoint
