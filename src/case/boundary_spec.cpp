#include "case/boundary_spec.hpp"

#include <set>

#include "case/case_reading.hpp"
#include "core/interpolate.hpp"

namespace matpoint {
namespace {

void check_velocity_table(BoundarySpec& boundary, const Input& input, const ReadContext& context) {
  const auto dim = static_cast<std::size_t>(context.dim);
  const bool has_function = boundary.velocity_history != nullptr;
  const bool has_velocity = !boundary.velocity.empty() || boundary.velocity_field != nullptr;
  const bool has_table = !boundary.velocities.empty();
  const bool has_factors = !boundary.factors.empty();
  if (int{has_function} + int{has_velocity} + int{has_table} != 1 || boundary.times.empty() != !(has_table || has_factors) ||
      (has_factors && !has_velocity)) {
    fail_input(input, context,
               "kind = \"velocity\" needs velocity = [...] or { type = ... }, with times = [...] and factors = [...] where it changes in "
               "time, or a table: times = [...] with velocities = [[...], ...]");
  }
  if (!boundary.velocity.empty() && boundary.velocity.size() != dim) {
    fail_input(at_key(input, "velocity"), context,
               fmt::format("velocity has {} numbers; the case has dim = {}, so it must have {}", boundary.velocity.size(), dim, dim));
  }
  const std::size_t values = has_table ? boundary.velocities.size() : boundary.factors.size();
  if (boundary.times.size() != values) {
    const char* const key = has_table ? "velocities" : "factors";
    fail_input(at_key(input, key), context,
               fmt::format("times has {} entries and {} {}; they must match", boundary.times.size(), key, values));
  }
  for (std::size_t k = 1; k < boundary.times.size(); ++k) {
    if (boundary.times[k] > boundary.times[k - 1]) continue;
    fail_input(at_key(input, "times"), context,
               fmt::format("times[{}] = {} must be greater than times[{}] = {}", k, boundary.times[k], k - 1, boundary.times[k - 1]));
  }
}

}  // namespace

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
      fail_input(at_key(input, "region"), context,
                 "kind = \"slip\" needs a region with one surface: box, disk, sphere, cylinder, polygon or half_space; give each part its "
                 "own boundary");
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
            ? "needs a region with one surface: box, disk, sphere, cylinder, polygon or half_space; give each part its own boundary"
            : nullptr;
    if (problem != nullptr)
      fail_input(at_key(input, "contact"), context, fmt::format("contact = {} {}", at_key(input, "contact").text(), problem));
    if (is_friction && !is_given(input, "friction"))
      fail_input(at_key(input, "contact"), context, "contact = \"friction\" needs friction, Coulomb's coefficient");
  }
  if (boundary.contact == FaceContact::stick && is_given(input, "contact_by"))
    fail_input(at_key(input, "contact_by"), context, "contact_by is for contact = \"no_tension\" or \"friction\"");
  if (boundary.contact != FaceContact::friction && is_given(input, "friction"))
    fail_input(at_key(input, "friction"), context, "friction is for contact = \"friction\" only");
  if (boundary.kind == BoundaryKind::velocity) {
    check_velocity_table(boundary, input, context);
  } else {
    for (const char* key : {"velocity", "times", "velocities", "factors"}) {
      if (is_given(input, key)) fail_input(at_key(input, key), context, fmt::format("{} is for kind = \"velocity\" only", key));
    }
  }
}

std::vector<std::string> boundary_names(const std::vector<BoundarySpec>& boundaries) {
  std::set<std::string> taken;
  std::vector<std::string> names;
  const auto fail = [](const BoundarySpec& boundary, const std::string& message) {
    throw InputError("{}{}{}", boundary.place, boundary.place.empty() ? "" : ": ", message);
  };
  for (const BoundarySpec& boundary : boundaries) {
    if (!boundary.name.empty() && !taken.insert(boundary.name).second)
      fail(boundary, fmt::format("two boundaries have the name \"{}\"; give each its own", boundary.name));
  }
  for (std::size_t b = 0; b < boundaries.size(); ++b) {
    const BoundarySpec& boundary = boundaries[b];
    names.push_back(!boundary.name.empty()                                      ? boundary.name
                    : !boundary.side.empty() && taken.count(boundary.side) == 0 ? boundary.side
                                                                                : fmt::format("boundary_{}", b + 1));
    if (boundary.name.empty() && !taken.insert(names.back()).second)
      fail(boundary, fmt::format("boundary {} has no name, and another has \"{}\", which would be its; name it", b + 1, names.back()));
  }
  return names;
}

void BoundarySpec::declare(ParameterTable<BoundarySpec>& table) {
  table.custom(
      {"name", "1", "string", "its side", "", "Names the boundary in results (implicit solver).", false},
      [](BoundarySpec& boundary, const Input& input, const ReadContext& context) {
        read_value(input, context, "name", any_number(), boundary.name);
        if (boundary.name.empty() || boundary.name.find_first_of(".,\n\"") != std::string::npos)
          fail_input(
              input, context,
              fmt::format("name = \"{}\" names columns of the history, so it needs letters, and no dot, comma or quote", boundary.name));
      },
      [](const BoundarySpec& boundary, int) -> std::optional<Input> {
        if (boundary.name.empty()) return std::nullopt;
        return Input::string(boundary.name);
      });
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
  table.custom(
      {"contact_by", "1", "string", "particles; nodes with friction in time", "\"nodes\" or \"particles\"",
       "What of a body touches a side with contact in the implicit solver: nodes of B-splines, up to a cell before the side, or the "
       "surfaces of its particles.",
       false},
      [](BoundarySpec& boundary, const Input& input, const ReadContext& context) {
        const std::string given = input.kind() == Input::Kind::string ? input.as_string() : "";
        check_words({given}, "contact_by", {"nodes", "particles"}, input, context);
        boundary.contact_by = given == "nodes" ? ContactBy::nodes : ContactBy::particles;
      },
      [](const BoundarySpec& boundary, int) -> std::optional<Input> {
        if (!boundary.contact_by) return std::nullopt;
        return Input::string(*boundary.contact_by == ContactBy::nodes ? "nodes" : "particles");
      });
  const auto unless_empty = [](const auto& values, int dim) -> std::optional<Input> {
    if (values.empty()) return std::nullopt;
    return write_value(values, dim);
  };
  table.custom(
      {"velocity", "m/s", "dim numbers, or table with a type", "", list_names(velocity_registry().names()),
       "The velocity: the same one everywhere, or by place.", false},
      [](BoundarySpec& boundary, const Input& input, const ReadContext& context) {
        boundary.velocity_history = input.as_object<VelocityHistory>();
        if (boundary.velocity_history) return;
        if (input.kind() == Input::Kind::table)
          boundary.velocity_field = velocity_registry().read(input, context, "velocity");
        else
          read_value(input, context, "velocity", any_number(), boundary.velocity);
      },
      [=](const BoundarySpec& boundary, int dim) -> std::optional<Input> {
        if (boundary.velocity_history) return Input::string("a function of time");
        if (boundary.velocity_field) return boundary.velocity_field->write(dim);
        return unless_empty(boundary.velocity, dim);
      });
  table.custom(
      {"traction", "Pa", "dim numbers", "", "", "For kind = \"traction\": force per undeformed area, which keeps its direction.", false},
      [](BoundarySpec& boundary, const Input& input, const ReadContext& context) {
        read_value(input, context, "traction", any_number(), boundary.traction);
      },
      [=](const BoundarySpec& boundary, int dim) { return unless_empty(boundary.traction, dim); });
  table.custom(
      {"times", "s", "array of numbers", "", "ascending",
       "Times of a table of velocities or factors: linear between, constant before and after.", false},
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
  table.custom(
      {"factors", "1", "array of numbers", "", "as many as times", "Factors of velocity in the course of time.", false},
      [](BoundarySpec& boundary, const Input& input, const ReadContext& context) {
        read_value(input, context, "factors", any_number(), boundary.factors);
      },
      [=](const BoundarySpec& boundary, int dim) { return unless_empty(boundary.factors, dim); });
}

BoundarySide side_of(const std::string& name) {
  if (name == "left") return {0, false};
  if (name == "right") return {0, true};
  if (name == "bottom") return {1, false};
  if (name == "top") return {1, true};
  return {2, name == "back"};
}

Vec3 PrescribedVelocity::at(const Vec3& x) const {
  if (field == nullptr) return everywhere;
  Vec3 v = field->at(x);
  for (Real& component : v) component *= factor;
  return v;
}

PrescribedVelocity velocity_at(const BoundarySpec& spec, Real t) {
  if (spec.kind != BoundaryKind::velocity) return {};
  if (spec.velocity_history) return {spec.velocity_history->at(t)};
  if (!spec.velocities.empty()) return {interpolated(spec.times, spec.velocities, t)};
  const Real factor = spec.factors.empty() ? 1 : interpolated(spec.times, spec.factors, t);
  if (spec.velocity_field) return {{}, spec.velocity_field.get(), factor};
  PrescribedVelocity value;
  for (std::size_t d = 0; d < spec.velocity.size(); ++d) value.everywhere[d] = factor * spec.velocity[d];
  return value;
}

}  // namespace matpoint
