#include "body/particle_fields.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/tensor.hpp"
#include "material/spectral.hpp"

namespace matpoint {

namespace {

struct FieldShape {
  const char* name;
  const char* unit;
  int components;  ///< 0: of a vector.
};
/// In the order of ParticleField.
constexpr FieldShape k_shapes[] = {{"position", "m", 0},
                                   {"velocity", "m/s", 0},
                                   {"stress", "Pa", 6},
                                   {"von_mises", "Pa", 1},
                                   {"pressure", "Pa", 1},
                                   {"deformation_gradient", "1", 9},
                                   {"J", "1", 1},
                                   {"id", "1", 1},
                                   {"mass", "kg", 1},
                                   {"volume", "m^3", 1},
                                   {"body", "1", 1},
                                   {"density", "kg/m^3", 1},
                                   {"principal_stress", "Pa", 3},
                                   {"stress_ratio", "1", 1},
                                   {"equivalent_strain", "1", 1},
                                   {"affine_velocity", "1/s", 9},
                                   {"displacement", "m", 0}};
/// What only some bodies have.
constexpr bool is_special(std::string_view name) { return name == "affine_velocity" || name == "displacement"; }

[[noreturn]] void fail_unknown_field(const std::string& body, const std::string& name, const std::vector<std::string>& known) {
  if (name == "displacement")
    throw InputError("body \"{}\" has no displacement: particles remember where they started if output.fields names \"displacement\"",
                     body);
  throw InputError("body \"{}\" has no field \"{}\", it has {}{}", body, name, list_names(known), did_you_mean(name, known));
}

}  // namespace

const std::vector<std::string>& particle_field_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const FieldShape& shape : k_shapes) {
      if (!is_special(shape.name)) all.emplace_back(shape.name);
    }
    return all;
  }();
  return names;
}

std::vector<std::string> particle_field_names(const Material& material) {
  std::vector<std::string> names = particle_field_names();
  for (const InternalVariable& variable : material.internal_variables()) {
    // A program may have named it.
    if (std::any_of(std::begin(k_shapes), std::end(k_shapes),
                    [&](const FieldShape& s) { return s.name == std::string_view(variable.name); }))
      throw InputError("history \"{}\" of a law has the name of another field of particles; take another name", variable.name);
    names.emplace_back(variable.name);
  }
  return names;
}

WantedFields prepare_fields(const std::string& body, const Material& material, int dim, const std::vector<std::string>& known,
                            const std::vector<std::string>& names, int vector_size, Index count, std::vector<Field>& fields) {
  WantedFields wanted;
  const std::vector<InternalVariable> remembered = material.internal_variables();
  fields.resize(names.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto variable =
        std::find_if(remembered.begin(), remembered.end(), [&](const InternalVariable& one) { return one.name == names[i]; });
    wanted.history_places.push_back(-1);
    wanted.at_rest.push_back(0);
    if (variable != remembered.end()) {
      wanted.history_places.back() = material.history_size(dim) - static_cast<int>(remembered.end() - variable);
      wanted.at_rest.back() = variable->at_rest;
      wanted.kinds.push_back(ParticleField::J);  // which stands for it
      fields[i].name = variable->name;
      fields[i].unit = variable->unit;
      fields[i].components = 1;
      fields[i].values.resize(static_cast<std::size_t>(count));
      continue;
    }
    const auto* const shape =
        std::find_if(std::begin(k_shapes), std::end(k_shapes), [&](const FieldShape& s) { return s.name == names[i]; });
    if (shape == std::end(k_shapes) || std::find(known.begin(), known.end(), names[i]) == known.end())
      fail_unknown_field(body, names[i], known);
    const auto kind = static_cast<ParticleField>(shape - std::begin(k_shapes));
    wanted.kinds.push_back(kind);
    wanted.needs_stress = wanted.needs_stress || kind == ParticleField::stress || kind == ParticleField::von_mises ||
                          kind == ParticleField::pressure || kind == ParticleField::principal_stress || kind == ParticleField::stress_ratio;
    fields[i].name = shape->name;
    fields[i].unit = shape->unit;
    fields[i].components = shape->components > 0 ? shape->components : vector_size;
    fields[i].values.resize(static_cast<std::size_t>(count) * static_cast<std::size_t>(fields[i].components));
  }
  return wanted;
}

Real von_mises(const std::array<Real, 6>& s) {
  const Real mean = (s[0] + s[1] + s[2]) / 3;
  const Real xx = s[0] - mean;
  const Real yy = s[1] - mean;
  const Real zz = s[2] - mean;
  return std::sqrt(1.5 * (xx * xx + yy * yy + zz * zz) + 3 * (s[3] * s[3] + s[4] * s[4] + s[5] * s[5]));
}

std::array<Real, 3> principal_stresses(const std::array<Real, 6>& s) {
  Mat3<Real> matrix;
  for (int d = 0; d < 3; ++d) matrix(d, d) = s[static_cast<std::size_t>(d)];
  matrix(0, 1) = matrix(1, 0) = s[3];
  matrix(1, 2) = matrix(2, 1) = s[4];
  matrix(0, 2) = matrix(2, 0) = s[5];
  const Spectrum<Real, false> spectrum(matrix);
  std::array<Real, 3> values = {spectrum.value[0], spectrum.value[1], spectrum.value[2]};
  std::sort(values.begin(), values.end());
  return values;
}

Real stress_ratio(const std::array<Real, 6>& s) {
  const Real p = -(s[0] + s[1] + s[2]) / 3;
  return p > 0 ? von_mises(s) / p : 0;
}

Real equivalent_strain(const Material::Matrix& F) {
  Mat3<Real> matrix;
  std::copy(F.begin(), F.end(), matrix.entries);
  const Spectrum<Real, false> spectrum(left_cauchy_green_minus_identity(matrix));
  const Real mean = (spectrum.half_log[0] + spectrum.half_log[1] + spectrum.half_log[2]) / 3;
  Real squared = 0;
  for (const Real e : spectrum.half_log) squared += (e - mean) * (e - mean);
  return std::sqrt(squared * (2.0 / 3));
}

void add(BodyTotals& sum, const BodyTotals& part) {
  const bool is_first = sum.particle_count == 0;
  sum.particle_count += part.particle_count;
  sum.mass += part.mass;
  sum.kinetic_energy += part.kinetic_energy;
  sum.strain_energy += part.strain_energy;
  sum.gravitational_energy += part.gravitational_energy;
  sum.von_mises_max = std::max(sum.von_mises_max, part.von_mises_max);
  sum.J_min = is_first ? part.J_min : std::min(sum.J_min, part.J_min);
  sum.J_max = is_first ? part.J_max : std::max(sum.J_max, part.J_max);
  for (std::size_t d = 0; d < 3; ++d) {
    sum.momentum[d] += part.momentum[d];
    sum.center_of_mass[d] += part.center_of_mass[d];
    sum.lower[d] = is_first ? part.lower[d] : std::min(sum.lower[d], part.lower[d]);
    sum.upper[d] = is_first ? part.upper[d] : std::max(sum.upper[d], part.upper[d]);
  }
}

BodyTotals totals_of(const ParticleState& particle, const Material& material, const Vec3& gravity) {
  BodyTotals one;
  one.particle_count = 1;
  one.mass = particle.volume0 * material.density();
  one.lower = one.upper = particle.position;
  for (std::size_t d = 0; d < 3; ++d) {
    one.momentum[d] = one.mass * particle.velocity[d];
    one.center_of_mass[d] = one.mass * particle.position[d];
    one.kinetic_energy += 0.5 * one.mass * particle.velocity[d] * particle.velocity[d];
    one.gravitational_energy -= one.mass * gravity[d] * particle.position[d];
  }
  one.strain_energy = material.energy_density(particle.F, particle.history) * particle.volume0;
  one.von_mises_max = von_mises(particle.sigma);
  one.J_min = one.J_max = determinant_of(particle.F);
  return one;
}

namespace {

void check_assigned_deformation(const std::string& body, int dim, const std::vector<Real>& values, bool is_axisymmetric) {
  for (std::size_t row = 0; row < values.size() / 9; ++row) {
    Mat3<Real> F;
    std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(9 * row), 9, F.entries);
    if (!(determinant(F) > 0)) {
      throw InputError("body \"{}\": deformation_gradient of particle row {} has the determinant {}, it must be > 0", body, row,
                       determinant(F));
    }
    for (int r = 0; r < 3 && dim == 2; ++r) {
      for (int c = 0; c < 3; ++c) {
        const bool is_free = (r < 2 && c < 2) || (is_axisymmetric && r == 2 && c == 2);
        if (is_free || F(r, c) == (r == c ? 1 : 0)) continue;
        throw InputError("body \"{}\": deformation_gradient[{}][{}] of particle row {} is {}, but {} it is {}", body, r, c, row, F(r, c),
                         is_axisymmetric ? "around an axis" : "in plane strain", r == c ? 1 : 0);
      }
    }
  }
}

}  // namespace

void check_assigned_field(const std::string& body, const std::string& name, Index count, int dim, const std::vector<Real>& values,
                          bool is_axisymmetric) {
  if (name == "displacement") throw InputError("body \"{}\": displacement cannot be assigned: assign position", body);
  const std::vector<std::string>& names = particle_field_names();
  if (std::find(names.begin(), names.end(), name) == names.end()) fail_unknown_field(body, name, names);
  const auto refuse = [&](const char* reason) { throw InputError("body \"{}\": {} cannot be assigned: {}", body, name, reason); };
  for (const char* one : {"von_mises", "pressure", "principal_stress", "stress_ratio"}) {
    if (name == one) refuse("it follows from the stress; assign stress, which the material is brought to, or deformation_gradient");
  }
  if (name == "J" || name == "volume" || name == "density" || name == "equivalent_strain")
    refuse("the volume follows from the deformation; assign deformation_gradient");
  if (name == "mass") refuse("particles keep their mass; the material's density and the layout's volumes decide it");
  if (name == "id" || name == "body") refuse("particles keep their numbers");
  const std::size_t components = name == "deformation_gradient" ? 9 : name == "stress" ? 6 : static_cast<std::size_t>(dim);
  if (values.size() != static_cast<std::size_t>(count) * components) {
    throw InputError("body \"{}\": {} needs {} numbers for each of its {} particles, got {} numbers", body, name, components, count,
                     values.size());
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isfinite(values[i])) continue;
    throw InputError("body \"{}\": {} of particle row {} is not finite: {}", body, name, i / components, values[i]);
  }
  if (name == "deformation_gradient") check_assigned_deformation(body, dim, values, is_axisymmetric);
}

}  // namespace matpoint
