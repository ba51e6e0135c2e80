#include "material/law_material.hpp"

namespace matpoint {
namespace {

template <class Law>
void add_law(TypeRegistry<Material>& registry) {
  registry.add({Law::name, Law::summary, parameters_of<Law>().describe(), [](const Input& input, const ReadContext& context) {
                  auto material = std::make_shared<LawMaterial<Law>>();
                  read_law(input, context, material->law, {"type"});
                  return material;
                }});
}

template <class... Laws>
TypeRegistry<Material> make_registry(std::tuple<Laws...>*) {
  TypeRegistry<Material> registry;
  (add_law<Laws>(registry), ...);
  return registry;
}

template <class... Laws>
std::map<std::string, std::vector<std::string>> make_variables(std::tuple<Laws...>*) {
  std::map<std::string, std::vector<std::string>> all;
  const auto add = [&](const Material& material) {
    for (const InternalVariable& variable : material.internal_variables()) all[variable.name].push_back(material.type());
  };
  (add(LawMaterial<Laws>()), ...);
  return all;
}

}  // namespace

const std::map<std::string, std::vector<std::string>>& material_variables() {
  static const std::map<std::string, std::vector<std::string>> variables = make_variables(static_cast<AllLaws*>(nullptr));
  return variables;
}

const TypeRegistry<Material>& material_registry() {
  static const TypeRegistry<Material> registry = make_registry(static_cast<AllLaws*>(nullptr));
  return registry;
}

}  // namespace matpoint
