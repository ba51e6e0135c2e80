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

}  // namespace

const TypeRegistry<Material>& material_registry() {
  static const TypeRegistry<Material> registry = make_registry(static_cast<AllLaws*>(nullptr));
  return registry;
}

}  // namespace matpoint
