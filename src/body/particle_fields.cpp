// What a body of particles tells about itself: totals for the history, and fields in the order of ids.
#include <algorithm>
#include <cmath>

#include "body/particle_body.hpp"
#include "core/parallel.hpp"

namespace matpoint {

const std::vector<std::string>& particle_field_names() {
  static const std::vector<std::string> names = {"position", "velocity", "stress", "von_mises", "pressure", "deformation_gradient",
                                                 "J",        "id",       "mass",   "volume",    "body"};
  return names;
}

namespace {

Real von_mises(const std::array<Real, 6>& s) {
  const Real mean = (s[0] + s[1] + s[2]) / 3;
  const Real xx = s[0] - mean;
  const Real yy = s[1] - mean;
  const Real zz = s[2] - mean;
  return std::sqrt(1.5 * (xx * xx + yy * yy + zz * zz) + 3 * (s[3] * s[3] + s[4] * s[4] + s[5] * s[5]));
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

}  // namespace

template <int Dim>
std::array<Real, 6> ParticleBody<Dim>::cauchy_stress(Index p) const {
  std::array<Real, 6> sigma{};
  const Real J = particles_.J(p);
  for (std::size_t k = 0; k < k_stress_size<Dim>; ++k) sigma[k] = particles_.tau[k][static_cast<std::size_t>(p)] / J;
  return sigma;
}

template <int Dim>
std::array<Real, 9> ParticleBody<Dim>::deformation_gradient(Index p) const {
  std::array<Real, 9> F{1, 0, 0, 0, 1, 0, 0, 0, 1};
  for (std::size_t r = 0; r < Dim; ++r) {
    for (std::size_t c = 0; c < Dim; ++c) F[3 * r + c] = particles_.F[r * Dim + c][static_cast<std::size_t>(p)];
  }
  return F;
}

/// Sums over slots [begin, end); center_of_mass holds the sum of m x until the caller divides.
template <int Dim>
BodyTotals ParticleBody<Dim>::totals_of(Index begin, Index end, const Vec3& gravity) const {
  BodyTotals sum;
  for (Index p = begin; p < end; ++p) {
    const auto s = static_cast<std::size_t>(p);
    BodyTotals one;
    one.particle_count = 1;
    one.mass = particles_.mass[s];
    one.lower = one.upper = position(p);
    for (std::size_t d = 0; d < Dim; ++d) {
      const Real v = particles_.v[d][s];
      one.momentum[d] = one.mass * v;
      one.center_of_mass[d] = one.mass * one.lower[d];
      one.kinetic_energy += 0.5 * one.mass * v * v;
      one.gravitational_energy -= one.mass * gravity[d] * one.lower[d];
    }
    one.strain_energy = material_->energy_density(deformation_gradient(p)) * particles_.volume0[s];
    one.von_mises_max = von_mises(cauchy_stress(p));
    one.J_min = one.J_max = particles_.J(p);
    add(sum, one);
  }
  return sum;
}

template <int Dim>
BodyTotals ParticleBody<Dim>::totals(const Vec3& gravity) const {
  const Index n = particles_.count();
  const Index chunks = (n + k_chunk - 1) / k_chunk;
  std::vector<BodyTotals> parts(static_cast<std::size_t>(chunks));
  parallel_for(chunks, n, [&](Index chunk) {
    parts[static_cast<std::size_t>(chunk)] = totals_of(chunk * k_chunk, std::min(n, (chunk + 1) * k_chunk), gravity);
  });
  BodyTotals sum;
  for (const BodyTotals& part : parts) add(sum, part);
  if (sum.mass > 0) {
    for (Real& x : sum.center_of_mass) x /= sum.mass;
  }
  return sum;
}

template <int Dim>
std::vector<std::string> ParticleBody<Dim>::field_names() const {
  return particle_field_names();
}

template <int Dim>
Field ParticleBody<Dim>::field(const std::string& name, std::size_t body) const {
  const std::vector<std::uint32_t> slots = particles_.slots_by_id();
  const auto gather = [&](const std::string& unit, int components, auto&& value) {
    Field field{name, unit, components, {}};
    field.values.resize(slots.size() * static_cast<std::size_t>(components));
    Real* out = field.values.data();
    for (const std::uint32_t slot : slots) {
      for (int c = 0; c < components; ++c) *out++ = value(static_cast<Index>(slot), static_cast<std::size_t>(c));
    }
    return field;
  };
  const auto at = [](const auto& array, Index p) { return static_cast<Real>(array[static_cast<std::size_t>(p)]); };
  if (name == "position") return gather("m", Dim, [&](Index p, std::size_t c) { return at(particles_.x[c], p); });
  if (name == "velocity") return gather("m/s", Dim, [&](Index p, std::size_t c) { return at(particles_.v[c], p); });
  if (name == "stress") return gather("Pa", 6, [&](Index p, std::size_t c) { return cauchy_stress(p)[c]; });
  if (name == "von_mises") return gather("Pa", 1, [&](Index p, std::size_t) { return von_mises(cauchy_stress(p)); });
  if (name == "pressure") {
    return gather("Pa", 1, [&](Index p, std::size_t) {
      const auto s = cauchy_stress(p);
      return -(s[0] + s[1] + s[2]) / 3;
    });
  }
  if (name == "deformation_gradient") return gather("1", 9, [&](Index p, std::size_t c) { return deformation_gradient(p)[c]; });
  if (name == "J") return gather("1", 1, [&](Index p, std::size_t) { return particles_.J(p); });
  if (name == "id") return gather("1", 1, [&](Index p, std::size_t) { return at(particles_.id, p); });
  if (name == "mass") return gather("kg", 1, [&](Index p, std::size_t) { return at(particles_.mass, p); });
  if (name == "volume") return gather("m^3", 1, [&](Index p, std::size_t) { return particles_.J(p) * at(particles_.volume0, p); });
  if (name == "body") return gather("1", 1, [&](Index, std::size_t) { return static_cast<Real>(body); });
  throw InputError("body \"{}\" has no field \"{}\", it has {}{}", name_, name, list_names(field_names()),
                   did_you_mean(name, field_names()));
}

template BodyTotals ParticleBody<2>::totals_of(Index, Index, const Vec3&) const;
template BodyTotals ParticleBody<3>::totals_of(Index, Index, const Vec3&) const;
template BodyTotals ParticleBody<2>::totals(const Vec3&) const;
template BodyTotals ParticleBody<3>::totals(const Vec3&) const;
template std::vector<std::string> ParticleBody<2>::field_names() const;
template std::vector<std::string> ParticleBody<3>::field_names() const;
template Field ParticleBody<2>::field(const std::string&, std::size_t) const;
template Field ParticleBody<3>::field(const std::string&, std::size_t) const;

}  // namespace matpoint
