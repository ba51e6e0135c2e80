#include "case/tool_spec.hpp"

#include "case/case_reading.hpp"
#include "core/interpolate.hpp"

namespace matpoint {
namespace {

/// A key that is written only where it was given.
template <class T>
void declare_given(ParameterTable<ToolSpec>& table, const std::string& name, const std::string& unit, const std::string& type,
                   const std::string& allowed, T ToolSpec::*member, const Constraint& constraint, const std::string& help) {
  table.custom(
      {name, unit, type, "", allowed, help, false},
      [=](ToolSpec& tool, const Input& input, const ReadContext& context) { read_value(input, context, name, constraint, tool.*member); },
      [=](const ToolSpec& tool, int dim) -> std::optional<Input> {
        if constexpr (requires { (tool.*member).has_value(); }) {
          if (!(tool.*member)) return std::nullopt;
          return write_value(*(tool.*member), dim);
        } else {
          if ((tool.*member).empty()) return std::nullopt;
          return write_value(tool.*member, dim);
        }
      });
}

}  // namespace

void ToolSpec::declare(ParameterTable<ToolSpec>& table) {
  table.required("name", "1", &ToolSpec::name, any_number(), "Names it in results.");
  typed(table, "shape", &ToolSpec::shape, region_registry,
        "Where it is at the start: box, disk, sphere, cylinder, polygon, half_space, or a union of these.", true);
  declare_given(table, "density", "kg/m^3", "number", "> 0", &ToolSpec::density, positive(), "With it, or with mass, it moves freely.");
  declare_given(table, "mass", "kg", "number", "> 0", &ToolSpec::mass, positive(), "Instead; per metre of thickness in 2D.");
  declare_given(table, "velocity", "m/s", "dim numbers", "", &ToolSpec::velocity, any_number(),
                "Prescribed, or, of what moves freely, at the start.");
  table.custom(
      {"angular_velocity", "rad/s", "number; 3 numbers in 3D", "0", "", "The same of its turn, counterclockwise.", false},
      [](ToolSpec& tool, const Input& input, const ReadContext& context) {
        if (context.dim == 2)
          read_value(input, context, "angular_velocity", any_number(), tool.angular_velocity[2]);
        else
          read_value(input, context, "angular_velocity", any_number(), tool.angular_velocity);
      },
      [](const ToolSpec& tool, int dim) -> std::optional<Input> {
        if (tool.angular_velocity == Vec3{}) return std::nullopt;
        return dim == 2 ? Input::real(tool.angular_velocity[2]) : write_value(tool.angular_velocity, dim);
      });
  declare_given(table, "times", "s", "array of numbers", "ascending", &ToolSpec::times, any_number(),
                "Times of a table of factors or velocities: linear between, constant before and after.");
  declare_given(table, "factors", "1", "array of numbers", "as many as times", &ToolSpec::factors, any_number(),
                "Factors of the prescribed velocity and angular_velocity.");
  declare_given(table, "velocities", "m/s", "array of points", "as many as times", &ToolSpec::velocities, any_number(),
                "Instead of velocity: one for each time.");
  declare_given(table, "pivot", "m", "dim numbers", "", &ToolSpec::pivot, any_number(),
                "The point that a prescribed turn is about, which moves with the velocity; without it the middle of the shape.");
  declare_given(table, "held", "1", "array of strings", "\"x\", \"y\", \"z\", \"rotation\"", &ToolSpec::held, any_number(),
                "What of a free motion is held.");
  declare_given(table, "hinge", "m", "dim numbers", "", &ToolSpec::hinge, any_number(),
                "A point of what moves freely that stays where it is.");
  declare_given(table, "axis", "1", "3 numbers", "not zero", &ToolSpec::axis, any_number(),
                "3D: the axis through the hinge; without it all turns about the point are free.");
  table.optional("spring", "N m/rad", &ToolSpec::spring, non_negative(), "Of the hinge: a moment against its turn.");
  table.optional("spring_damping", "N m s/rad", &ToolSpec::spring_damping, non_negative(), "The same against the rate of its turn.");
  declare_given(table, "force", "N", "dim numbers", "", &ToolSpec::force, any_number(), "On what moves freely, at its centre of mass.");
  table.optional("friction", "1", &ToolSpec::friction, non_negative(), "Coulomb's coefficient against particles.");
  table.optional("stiffness", "1", &ToolSpec::stiffness, positive(),
                 "Of the contact, over that of the particles: more lets them in less, and shortens the steps.");
}

void check_tool(ToolSpec& tool, const Input& input, const ReadContext& context) {
  const auto dim = static_cast<std::size_t>(context.dim);
  const auto fail = [&](const char* key, const std::string& text) { fail_input(at_key(input, key), context, text); };
  if (tool.name.empty() || tool.name.find_first_of(".,\n\"") != std::string::npos)
    fail("name", fmt::format("name = \"{}\" names columns of the history, so it needs letters, and no dot, comma or quote", tool.name));
  if (!tool.shape->surface_near(tool.shape->lower(), context.dim)) {
    fail("shape", "the surface of this shape is not known; use box, disk, sphere, cylinder, polygon or half_space, or a union of these");
  }
  for (const auto& [key, numbers] : {std::pair("velocity", &tool.velocity), std::pair("force", &tool.force)}) {
    if (!numbers->empty() && numbers->size() != dim)
      fail(key, fmt::format("{} has {} numbers; the case has dim = {}, so it must have {}", key, numbers->size(), dim, dim));
  }
  if (tool.density && tool.mass) fail("mass", "density and mass are both given; give one of them");
  if (tool.is_free() && !tool.shape->solid(context.dim))
    fail("shape", "what moves freely needs a shape whose centre and inertia are known: box, disk, sphere, cylinder or polygon");
  for (const char* key : {"held", "hinge", "axis", "spring", "spring_damping", "force"}) {
    if (is_given(input, key) && !tool.is_free())
      fail(key, fmt::format("{} is for what moves freely; give the tool a density or a mass", key));
  }
  for (const char* key : {"times", "factors", "velocities", "pivot"}) {
    if (is_given(input, key) && tool.is_free())
      fail(key, fmt::format("{} is for a prescribed motion, and with density or mass the tool moves freely", key));
  }
  const bool has_velocities = !tool.velocities.empty();
  if (tool.times.empty() != (tool.factors.empty() && !has_velocities) || (has_velocities && !tool.factors.empty()) ||
      (has_velocities && !tool.velocity.empty()))
    fail("times", "times goes with factors, of velocity and angular_velocity, or with velocities instead of velocity");
  const std::size_t values = has_velocities ? tool.velocities.size() : tool.factors.size();
  if (tool.times.size() != values) {
    const char* const key = has_velocities ? "velocities" : "factors";
    fail(key, fmt::format("times has {} entries and {} {}; they must match", tool.times.size(), key, values));
  }
  for (std::size_t k = 1; k < tool.times.size(); ++k) {
    if (tool.times[k] > tool.times[k - 1]) continue;
    fail("times", fmt::format("times[{}] = {} must be greater than times[{}] = {}", k, tool.times[k], k - 1, tool.times[k - 1]));
  }
  std::vector<std::string> words = axis_names(context.dim);
  words.emplace_back("rotation");
  check_words(tool.held, "held", words, input, context);
  if (tool.axis && (context.dim == 2 || !tool.hinge)) fail("axis", "axis is for a hinge in 3D");
  if (tool.axis && *tool.axis == Vec3{}) fail("axis", "axis must not be zero, it gives a direction");
  if (tool.hinge && !tool.held.empty()) fail("held", "held is for what has no hinge");
  if (tool.hinge && !tool.velocity.empty()) fail("velocity", "velocity cannot be given to what turns about a hinge; use angular_velocity");
  if ((tool.spring > 0 || tool.spring_damping > 0) && (!tool.hinge || (context.dim == 3 && !tool.axis)))
    fail(tool.spring > 0 ? "spring" : "spring_damping", "a spring needs a hinge, in 3D with an axis");
}

Vec3 ToolSpec::velocity_at(Real t) const {
  if (!velocities.empty()) return interpolated(times, velocities, t);
  const Real factor = factors.empty() ? 1 : interpolated(times, factors, t);
  Vec3 v{};
  for (std::size_t d = 0; d < velocity.size(); ++d) v[d] = factor * velocity[d];
  return v;
}

Vec3 ToolSpec::angular_velocity_at(Real t) const {
  const Real factor = factors.empty() ? 1 : interpolated(times, factors, t);
  return {factor * angular_velocity[0], factor * angular_velocity[1], factor * angular_velocity[2]};
}

}  // namespace matpoint
