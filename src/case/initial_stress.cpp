#include "case/initial_stress.hpp"

#include <cmath>

#include "case/case.hpp"
#include "case/case_reading.hpp"

namespace matpoint {
namespace {

template <class Stress>
void declare_consolidation(ParameterTable<Stress>& table) {
  table.optional("overconsolidation", "1", static_cast<std::optional<Real> Stress::*>(&Stress::overconsolidation),
                 Constraint{"at least 1", [](Real x) { return x >= 1; }},
                 "For cam_clay: the preconsolidation pressure is this many times that of the start. Without it the material's holds.");
}

struct UniformStress final : InitialStress {
  static constexpr auto name = "uniform";
  static constexpr auto summary = "The same stress everywhere.";

  std::vector<Real> value;

  static void declare(ParameterTable<UniformStress>& table) {
    table.custom(
        {"value", "Pa", "4 numbers in 2D, 6 in 3D", "", "finite", "Cauchy stress, tension positive: xx yy zz xy, and yz xz in 3D.", true},
        [](UniformStress& stress, const Input& input, const ReadContext& context) {
          read_value(input, context, "value", any_number(), stress.value);
          const std::size_t count = context.dim == 2 ? 4 : 6;
          if (stress.value.size() != count) {
            fail_input(
                input, context,
                fmt::format("value has {} numbers; give {}: xx yy zz xy{}", stress.value.size(), count, context.dim == 2 ? "" : " yz xz"));
          }
        },
        [](const UniformStress& stress, int dim) -> std::optional<Input> { return write_value(stress.value, dim); });
    declare_consolidation(table);
  }
  std::array<Real, 6> at(const Vec3&) const override {
    std::array<Real, 6> all{};
    std::copy(value.begin(), value.end(), all.begin());
    return all;
  }
  Input write(int dim) const override { return write_typed(*this, dim); }
};

/// Under a horizontal surface: sigma_v = -(surcharge + weight above), sigma_h = K0 sigma_v. Layers are bodies one above the other.
struct GeostaticStress final : InitialStress {
  static constexpr auto name = "geostatic";
  static constexpr auto summary = "The weight of what lies above, under a horizontal surface, in layers; K0 times that across.";

  Real K0 = 0;
  std::optional<Real> surface;  ///< [m]
  Real surcharge = 0;           ///< [Pa]

  static void declare(ParameterTable<GeostaticStress>& table) {
    table.required("K0", "1", &GeostaticStress::K0, positive(),
                   "Horizontal over vertical stress; 1 - sin(phi) in sand at rest, 1 in a fluid.");
    table.optional("surface", "m", &GeostaticStress::surface, any_number(),
                   "Where the ground ends, along gravity's axis; default: the top of the highest body with such a stress.");
    table.optional("surcharge", "Pa", &GeostaticStress::surcharge, non_negative(), "Pressure on the surface.");
    declare_consolidation(table);
  }
  std::array<Real, 6> at(const Vec3& x) const override {
    const Real height = x[axis_] * up_;
    Real weight = surcharge;
    for (const Layer& layer : layers_) weight += layer.weight * std::max(Real{0}, layer.top - std::max(height, layer.bottom));
    std::array<Real, 6> stress{-K0 * weight, -K0 * weight, -K0 * weight, 0, 0, 0};
    stress[axis_] = -weight;
    return stress;
  }
  Input write(int dim) const override { return write_typed(*this, dim); }
  void resolve(const Case& problem, const BodySpec& body) override;

 private:
  /// Heights against gravity [m], and weight per volume [N/m^3].
  struct Layer {
    Real bottom, top, weight;
  };
  std::size_t axis_ = 1;
  Real up_ = 1;
  std::vector<Layer> layers_;
};

[[noreturn]] void fail_stress(const BodySpec& body, const std::string& text) {
  throw InputError("{}: initial_stress: {}", place_of(body), text);
}

void GeostaticStress::resolve(const Case& problem, const BodySpec& body) {
  int count = 0;
  for (std::size_t d = 0; d < 3; ++d) {
    if (problem.gravity[d] == 0) continue;
    ++count;
    axis_ = d;
    up_ = problem.gravity[d] < 0 ? 1 : -1;
  }
  if (count != 1) {
    fail_stress(body,
                fmt::format("\"geostatic\" needs gravity along one axis, and the case has [{}]; take \"uniform\", or turn the geometry",
                            fmt::join(problem.gravity.begin(), problem.gravity.begin() + problem.dim, ", ")));
  }
  const Real g = std::abs(problem.gravity[axis_]);
  layers_.clear();
  Real highest = -std::numeric_limits<Real>::infinity();
  for (const BodySpec& other : problem.bodies) {
    if (dynamic_cast<const GeostaticStress*>(other.initial_stress.get()) == nullptr) continue;
    if (!other.region) fail_stress(other, "\"geostatic\" needs a region, from which the layer's top and bottom follow");
    const Real a = up_ * std::max(other.region->lower()[axis_], problem.grid.lower[axis_]);
    const Real b = up_ * std::min(other.region->upper()[axis_], problem.grid.upper[axis_]);
    layers_.push_back({std::min(a, b), std::max(a, b), g * other.material->density()});
    highest = std::max(highest, std::max(a, b));
  }
  std::sort(layers_.begin(), layers_.end(), [](const Layer& a, const Layer& b) { return a.bottom < b.bottom; });
  for (std::size_t i = 1; i < layers_.size(); ++i) {
    const Real apart = layers_[i].bottom - layers_[i - 1].top;
    if (std::abs(apart) <= 1e-6 * (layers_[i].top - layers_[i].bottom)) continue;
    fail_stress(body,
                fmt::format("\"geostatic\" is for layers one above the other; one ends at {:.6g} and the next begins at {:.6g}: bodies "
                            "side by side, or with a gap, need \"uniform\"",
                            up_ * layers_[i - 1].top, up_ * layers_[i].bottom));
  }
  if (!surface) return;
  const Real level = up_ * *surface;
  if (level < highest - 1e-9 * std::abs(highest)) {
    fail_stress(body, fmt::format("surface = {} is below the top of the bodies, {:.6g}", *surface, up_ * highest));
  }
  layers_.back().top = level;
}

}  // namespace

const TypeRegistry<InitialStress>& initial_stress_registry() {
  static const TypeRegistry<InitialStress> registry = [] {
    TypeRegistry<InitialStress> all;
    all.add<UniformStress>();
    all.add<GeostaticStress>();
    return all;
  }();
  return registry;
}

void resolve_initial_stresses(Case& problem) {
  for (BodySpec& body : problem.bodies) {
    if (!body.initial_stress) continue;
    const bool is_kept_by_F = !body.material->remembers_strain();
    if (is_kept_by_F && body.formulation == Formulation::total)
      fail_stress(body,
                  fmt::format("formulation = \"total\" measures F from the start, and \"{}\" keeps its stress in F; take formulation = "
                              "\"updated\", or a law that flows, as \"j2\"",
                              body.material->type()));
    if (is_kept_by_F && body.method == BodyMethod::elements)
      fail_stress(body, fmt::format("elements measure F from the start, and \"{}\" keeps its stress in F; take a law that flows, as \"j2\"",
                                    body.material->type()));
    if (body.initial_stress->overconsolidation && !body.material->consolidates())
      fail_stress(body, fmt::format("overconsolidation is for cam_clay, and the material is \"{}\"", body.material->type()));
    body.initial_stress->resolve(problem, body);
  }
}

}  // namespace matpoint
