#include "geometry/velocity_field.hpp"

#include <cmath>

namespace matpoint {
namespace {

struct Uniform final : VelocityField {
  static constexpr auto name = "uniform";
  static constexpr auto summary = "The same velocity everywhere.";

  Vec3 value{};

  static void declare(ParameterTable<Uniform>& table) { table.required("value", "m/s", &Uniform::value, any_number(), "Velocity."); }
  Vec3 at(const Vec3&) const override { return value; }
  Input write(int dim) const override { return write_typed(*this, dim); }
};

struct Linear final : VelocityField {
  static constexpr auto name = "linear";
  static constexpr auto summary = "Linear in the position: v = value + gradient (x - center).";

  Vec3 value{};
  Vec3 center{};
  std::vector<Vec3> gradient;

  static void declare(ParameterTable<Linear>& table) {
    table.optional("value", "m/s", &Linear::value, any_number(), "Velocity at the center.");
    table.optional("center", "m", &Linear::center, any_number(), "Where the velocity is `value`.");
    table.required("gradient", "1/s", &Linear::gradient, any_number(),
                   "dim rows of dim numbers: row r holds the derivatives of component r.");
  }
  Vec3 at(const Vec3& x) const override {
    Vec3 v = value;
    for (std::size_t r = 0; r < gradient.size(); ++r) {
      for (std::size_t c = 0; c < 3; ++c) v[r] += gradient[r][c] * (x[c] - center[c]);
    }
    return v;
  }
  Input write(int dim) const override { return write_typed(*this, dim); }
  void check(const Input& input, const ReadContext& context) const override {
    if (gradient.size() == static_cast<std::size_t>(context.dim)) return;
    fail_input(*input.find("gradient"), context,
               fmt::format("gradient has {} rows; the case has dim = {}, so it must have {}", gradient.size(), context.dim, context.dim));
  }
};

struct Rotating final : VelocityField {
  static constexpr auto name = "rotating";
  static constexpr auto summary = "A rigid rotation about a center, with a translation: v = value + omega x (x - center).";

  Vec3 value{};
  Vec3 center{};
  Vec3 omega{};

  static void declare(ParameterTable<Rotating>& table) {
    table.optional("value", "m/s", &Rotating::value, any_number(), "Velocity of the center.");
    table.required("center", "m", &Rotating::center, any_number(), "Center of rotation.");
    table.custom(
        {"angular_velocity", "rad/s", "number in 2D, 3 numbers in 3D", "", "", "Angular velocity, counter-clockwise in 2D; a vector in 3D.",
         true},
        [](Rotating& field, const Input& input, const ReadContext& context) {
          if (context.dim == 3)
            read_value(input, context, "angular_velocity", any_number(), field.omega);
          else
            read_value(input, context, "angular_velocity", any_number(), field.omega[2]);
        },
        [](const Rotating& field, int dim) -> std::optional<Input> {
          return dim == 3 ? write_value(field.omega, dim) : write_value(field.omega[2], dim);
        });
  }
  Vec3 at(const Vec3& x) const override {
    const Vec3 r{x[0] - center[0], x[1] - center[1], x[2] - center[2]};
    return {value[0] + omega[1] * r[2] - omega[2] * r[1], value[1] + omega[2] * r[0] - omega[0] * r[2],
            value[2] + omega[0] * r[1] - omega[1] * r[0]};
  }
  Input write(int dim) const override { return write_typed(*this, dim); }
};

struct Sine final : VelocityField {
  static constexpr auto name = "sine";
  static constexpr auto summary = "A standing wave: v = value sin(wave_vector . (x - center)).";

  Vec3 value{};
  Vec3 wave_vector{};
  Vec3 center{};

  static void declare(ParameterTable<Sine>& table) {
    table.required("value", "m/s", &Sine::value, any_number(), "Velocity where the sine is 1.");
    table.required("wave_vector", "rad/m", &Sine::wave_vector, any_number(), "2 pi / wave length, in the direction of the wave.");
    table.optional("center", "m", &Sine::center, any_number(), "A point where the velocity is 0.");
  }
  Vec3 at(const Vec3& x) const override {
    Real phase = 0;
    for (std::size_t d = 0; d < 3; ++d) phase += wave_vector[d] * (x[d] - center[d]);
    const Real sine = std::sin(phase);
    return {value[0] * sine, value[1] * sine, value[2] * sine};
  }
  Real greatest_speed(const Vec3&, const Vec3&) const override { return std::sqrt(dot(value, value)); }
  Input write(int dim) const override { return write_typed(*this, dim); }
};

}  // namespace

Real VelocityField::greatest_speed(const Vec3& lower, const Vec3& upper) const {
  Real greatest = 0;
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 x = lower;
    for (std::size_t d = 0; d < 3; ++d) x[d] = (corner >> d & 1) == 1 ? upper[d] : lower[d];
    const Vec3 v = at(x);
    greatest = std::max(greatest, std::sqrt(dot(v, v)));
  }
  return greatest;
}

Input velocity_table(const Input& input) {
  if (input.kind() != Input::Kind::array) return input;
  Input table = Input::table();
  table.with_place(input.place());
  table.set("type", Input::string(Uniform::name));
  table.set("value", input);
  return table;
}

const TypeRegistry<VelocityField>& velocity_registry() {
  static const TypeRegistry<VelocityField> registry = [] {
    TypeRegistry<VelocityField> all;
    all.add<Uniform>();
    all.add<Linear>();
    all.add<Rotating>();
    all.add<Sine>();
    return all;
  }();
  return registry;
}

}  // namespace matpoint
