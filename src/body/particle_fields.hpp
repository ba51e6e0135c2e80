// What bodies of particles tell about themselves, written once for all storages: totals for the history, fields in the order of ids, and
// what may be assigned.
#pragma once

#include "material/material.hpp"
#include "solver/solver.hpp"

namespace matpoint {

/// All fields that a body of particles has.
const std::vector<std::string>& particle_field_names();

Real von_mises(const std::array<Real, 6>& sigma);
Real determinant_of(const Material::Matrix& F);

/// One particle, for the totals.
struct ParticleState {
  Vec3 position{};
  Vec3 velocity{};
  Real volume0 = 0;
  Material::Matrix F{1, 0, 0, 0, 1, 0, 0, 0, 1};
  std::array<Real, 6> sigma{};  ///< Cauchy stress [Pa]: xx yy zz xy yz xz.
};

/// Of one particle; center_of_mass holds m x until all are added.
BodyTotals totals_of(const ParticleState& particle, const Material& material, const Vec3& gravity);
/// Adds sums and extremes; center_of_mass is added like a sum.
void add(BodyTotals& sum, const BodyTotals& part);

/// Throws InputError unless the field can be assigned to a body of `count` particles and the values fit.
void check_assigned_field(const std::string& body, const std::string& name, Index count, int dim, const std::vector<Real>& values);

/// Throws InputError for a field that no body of particles has.
[[noreturn]] void fail_unknown_field(const std::string& body, const std::string& name);

/// The field by its name: gather(unit, components, values_of) makes it, where values_of(p) gives the numbers of one particle. `of` has the
/// accessors position(p), velocity(p), cauchy_stress(p), deformation_gradient(p), J(p), id(p) and volume0(p).
template <int Dim, class Body, class Gather>
Field gather_field(const Body& of, const Material& material, const std::string& body_name, std::size_t body, const std::string& name,
                   Gather&& gather) {
  using One = std::array<Real, 1>;
  if (name == "position") return gather("m", Dim, [&](const auto& p) { return of.position(p); });
  if (name == "velocity") return gather("m/s", Dim, [&](const auto& p) { return of.velocity(p); });
  if (name == "stress") return gather("Pa", 6, [&](const auto& p) { return of.cauchy_stress(p); });
  if (name == "von_mises") return gather("Pa", 1, [&](const auto& p) { return One{von_mises(of.cauchy_stress(p))}; });
  if (name == "pressure") {
    return gather("Pa", 1, [&](const auto& p) {
      const auto s = of.cauchy_stress(p);
      return One{-(s[0] + s[1] + s[2]) / 3};
    });
  }
  if (name == "deformation_gradient") return gather("1", 9, [&](const auto& p) { return of.deformation_gradient(p); });
  if (name == "J") return gather("1", 1, [&](const auto& p) { return One{of.J(p)}; });
  if (name == "id") return gather("1", 1, [&](const auto& p) { return One{static_cast<Real>(of.id(p))}; });
  if (name == "mass") return gather("kg", 1, [&](const auto& p) { return One{of.volume0(p) * material.density()}; });
  if (name == "volume") return gather("m^3", 1, [&](const auto& p) { return One{of.J(p) * of.volume0(p)}; });
  if (name == "body") return gather("1", 1, [&](const auto&) { return One{static_cast<Real>(body)}; });
  fail_unknown_field(body_name, name);
}

}  // namespace matpoint
