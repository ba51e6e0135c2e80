// What bodies of particles tell about themselves, written once for all storages: totals for the history, fields in the order of ids, and
// what may be assigned.
#pragma once

#include <algorithm>
#include <span>

#include "core/error.hpp"
#include "material/material.hpp"
#include "solver/report.hpp"

namespace matpoint {

enum class ParticleField {
  position,
  velocity,
  stress,
  von_mises,
  pressure,
  deformation_gradient,
  J,
  id,
  mass,
  volume,
  body,
  density,
  principal_stress,
  stress_ratio,
  equivalent_strain,
  affine_velocity,
  displacement
};

/// All fields that a body of particles always has.
const std::vector<std::string>& particle_field_names();
/// The same, and what its law remembers; `displacement` is there where a body keeps it.
std::vector<std::string> particle_field_names(const Material& material);

Real von_mises(const std::array<Real, 6>& sigma);
/// Ascending.
std::array<Real, 3> principal_stresses(const std::array<Real, 6>& sigma);
/// q/p, von Mises' stress over the pressure; 0 where there is no pressure.
Real stress_ratio(const std::array<Real, 6>& sigma);
/// sqrt(2/3) |dev ln V| of F = V R.
Real equivalent_strain(const Material::Matrix& F);
inline Real determinant_of(const Material::Matrix& F) {
  return F[0] * (F[4] * F[8] - F[5] * F[7]) - F[1] * (F[3] * F[8] - F[5] * F[6]) + F[2] * (F[3] * F[7] - F[4] * F[6]);
}

/// What the law of one particle remembers, in double: filled for laws that flow, which need it for their stress and energy, and for fields.
class PointHistory {
 public:
  PointHistory() = default;
  template <class At>
  PointHistory(int count, At&& at) : count_(static_cast<std::size_t>(count)) {
    MPM_ASSERT(count_ <= k_most);
    for (std::size_t h = 0; h < count_; ++h) values_[h] = static_cast<Real>(at(static_cast<int>(h)));
  }
  operator std::span<const Real>() const { return {values_, count_}; }
  Real operator[](std::size_t h) const { return values_[h]; }

 private:
  static constexpr std::size_t k_most = 32;
  Real values_[k_most];
  std::size_t count_ = 0;
};

/// One particle, for the totals.
struct ParticleState {
  Vec3 position{};
  Vec3 velocity{};
  Real volume0 = 0;
  Material::Matrix F{1, 0, 0, 0, 1, 0, 0, 0, 1};
  std::array<Real, 6> sigma{};  ///< Cauchy stress [Pa]: xx yy zz xy yz xz.
  PointHistory history{};
};

/// Of one particle; center_of_mass holds m x until all are added.
BodyTotals totals_of(const ParticleState& particle, const Material& material, const Vec3& gravity);
/// Adds sums and extremes; center_of_mass is added like a sum.
void add(BodyTotals& sum, const BodyTotals& part);

/// Throws InputError unless the field can be assigned to a body of `count` particles and the values fit.
void check_assigned_field(const std::string& body, const std::string& name, Index count, int dim, const std::vector<Real>& values,
                          bool is_axisymmetric = false);

/// What gather_fields was asked for.
struct WantedFields {
  std::vector<ParticleField> kinds;
  bool needs_stress = false;
  std::vector<Real> at_rest;        ///< Of what the law remembers, what its outputs count from.
  std::vector<int> history_places;  ///< Of what the law remembers, its place in the history; -1: a field of `kinds`.
};

/// Brings `fields` into the shape of the named ones, for `count` particles; vectors have `vector_size` components. Memory that is there is
/// kept. Throws InputError for a name that is not among `known`.
WantedFields prepare_fields(const std::string& body, const Material& material, int dim, const std::vector<std::string>& known,
                            const std::vector<std::string>& names, int vector_size, Index count, std::vector<Field>& fields);

/// The named fields, in one pass: a pass for each would go through all particles, and evaluate their law, once more. `of` has the accessors
/// position(p), velocity(p), displacement(p), cauchy_stress(p), deformation_gradient(p), remembered(p, place), id(p), volume0(p) and
/// affine_velocity(p);
/// for_each(needs_stress, f) calls f(p, row) for all particles.
template <class Of, class ForEach>
void gather_fields(const Of& of, const WantedFields& wanted, Real density, std::size_t body, std::vector<Field>& fields,
                   ForEach&& for_each) {
  for_each(wanted.needs_stress, [&](const auto& p, std::size_t row) {
    const Material::Matrix F = of.deformation_gradient(p);
    const Real J = determinant_of(F);
    const std::array<Real, 6> sigma = wanted.needs_stress ? of.cauchy_stress(p) : std::array<Real, 6>{};
    for (std::size_t i = 0; i < wanted.kinds.size(); ++i) {
      if (wanted.history_places[i] >= 0) {
        fields[i].values[row] = wanted.at_rest[i] + of.remembered(p, wanted.history_places[i]);
        continue;
      }
      const int components = fields[i].components;
      Real* const to = fields[i].values.data() + row * static_cast<std::size_t>(components);
      const auto copy = [&](const auto& values) { std::copy(values.begin(), values.end(), to); };
      const auto copy_vector = [&](const Vec3& values) {
        to[0] = values[0];
        to[1] = values[1];
        if (components == 3) to[2] = values[2];
      };
      switch (wanted.kinds[i]) {
        case ParticleField::position: copy_vector(of.position(p)); break;
        case ParticleField::velocity: copy_vector(of.velocity(p)); break;
        case ParticleField::stress: copy(sigma); break;
        case ParticleField::von_mises: *to = von_mises(sigma); break;
        case ParticleField::pressure: *to = -(sigma[0] + sigma[1] + sigma[2]) / 3; break;
        case ParticleField::deformation_gradient: copy(F); break;
        case ParticleField::J: *to = J; break;
        case ParticleField::id: *to = static_cast<Real>(of.id(p)); break;
        case ParticleField::mass: *to = of.volume0(p) * density; break;
        case ParticleField::volume: *to = J * of.volume0(p); break;
        case ParticleField::body: *to = static_cast<Real>(body); break;
        case ParticleField::density: *to = density / J; break;
        case ParticleField::principal_stress: copy(principal_stresses(sigma)); break;
        case ParticleField::stress_ratio: *to = stress_ratio(sigma); break;
        case ParticleField::equivalent_strain: *to = equivalent_strain(F); break;
        case ParticleField::affine_velocity: copy(of.affine_velocity(p)); break;
        case ParticleField::displacement: copy_vector(of.displacement(p)); break;
      }
    }
  });
}

}  // namespace matpoint
