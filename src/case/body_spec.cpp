#include "case/body_spec.hpp"

#include "case/case_reading.hpp"
#include "material/parameter_sets.hpp"

namespace matpoint {

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

void BodySpec::declare(ParameterTable<BodySpec>& table) {
  table.required("name", "1", &BodySpec::name, any_number(), "Names the body in results, probes and messages.");
  table.choice("method", &BodySpec::method, {{"particles", BodyMethod::particles}, {"elements", BodyMethod::elements}},
               "particles: material points; elements: a body of finite elements, the cells of the grid in the region (implicit solver).");
  table.choice("formulation", &BodySpec::formulation, {{"updated", Formulation::updated}, {"total", Formulation::total}},
               "Of particles, explicit solver: shape functions at their places now, or where they were at the start (total Lagrangian).");
  table.custom(
      {"fbar", "1", "true or false", "chosen", "",
       "The volume changes as it does in the mean of a cell, or in the implicit solver linearly over a patch of cells, which frees nearly "
       "incompressible bodies from locking. Where it is not given: in the implicit solver from Poisson's ratio 0.45 on.",
       false},
      [](BodySpec& body, const Input& input, const ReadContext& context) {
        read_value(input, context, "fbar", any_number(), body.fbar.emplace());
      },
      [](const BodySpec& body, int) -> std::optional<Input> {
        if (!body.fbar) return std::nullopt;
        return Input::boolean(*body.fbar);
      });
  typed(table, "region", &BodySpec::region, region_registry, "What the body fills at the start; layout type = \"points\" needs none.",
        false);
  typed(table, "layout", &BodySpec::layout, layout_registry, "How particles fill the region; a body of elements has none.", false);
  table.custom(
      {"velocity", "1", "table with a type, or a vector", "", list_names(velocity_registry().names()),
       "Initial velocity, or the same one everywhere [m/s]; without it the body is at rest.", false},
      [](BodySpec& body, const Input& input, const ReadContext& context) {
        body.velocity = velocity_registry().read(velocity_table(input), context, "velocity");
      },
      [](const BodySpec& body, int dim) -> std::optional<Input> {
        if (!body.velocity) return std::nullopt;
        return body.velocity->write(dim);
      });
  table.custom(
      {"material", "1", "table with a type, or a name", "", list_names(material_registry().names()),
       "The constitutive law with its parameters, or the name of a parameter set (`matpoint list parameter_sets`).", true},
      [](BodySpec& body, const Input& input, const ReadContext& context) {
        body.material = material_registry().read(material_table(input, context), context, "material");
      },
      [](const BodySpec& body, int dim) -> std::optional<Input> {
        if (!body.material) return std::nullopt;
        return body.material->write(dim);
      });
  typed(table, "initial_stress", &BodySpec::initial_stress, initial_stress_registry,
        "Stress that it starts with; without it the material is at rest.", false);
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

std::string place_of(const BodySpec& body) { return fmt::format("{}{}body \"{}\"", body.place, body.place.empty() ? "" : ": ", body.name); }

}  // namespace matpoint
