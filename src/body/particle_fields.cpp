// What a body of particles tells about itself: totals for the history, and fields in the order of ids.
#include <algorithm>
#include <cmath>

#include "body/particle_body.hpp"
#include "core/parallel.hpp"
#include "core/tensor.hpp"

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

template <int Dim, class R>
Vec3 ParticleBody<Dim, R>::velocity(const Particle& p) const {
  Vec3 v{};
  for (int d = 0; d < Dim; ++d) v[static_cast<std::size_t>(d)] = p.field(blocks_->layout().v + d);
  return v;
}

template <int Dim, class R>
Real ParticleBody<Dim, R>::volume0(const Particle& p) const {
  return blocks_->layout().volume >= 0 ? p.field(blocks_->layout().volume) : uniform_volume_;
}

template <int Dim, class R>
Material::Matrix ParticleBody<Dim, R>::deformation_gradient(const Particle& p) const {
  Material::Matrix F{1, 0, 0, 0, 1, 0, 0, 0, 1};
  for (int r = 0; r < Dim; ++r) {
    for (int c = 0; c < Dim; ++c) F[static_cast<std::size_t>(3 * r + c)] = p.field(blocks_->layout().F + r * Dim + c);
  }
  return F;
}

template <int Dim, class R>
Real ParticleBody<Dim, R>::J(const Particle& p) const {
  Mat3<Real> F;
  const Material::Matrix entries = deformation_gradient(p);
  std::copy(entries.begin(), entries.end(), F.entries);
  return determinant(F);
}

template <int Dim, class R>
std::array<Real, 6> ParticleBody<Dim, R>::cauchy_stress(const Particle& p) const {
  std::array<Real, 6> sigma{};
  const SlotLayout<Dim>& at = blocks_->layout();
  if (at.tau >= 0) {
    for (std::size_t s = 0; s < k_stress_size<Dim>; ++s) sigma[s] = p.field(at.tau + static_cast<int>(s));
  } else {
    const Material::Matrix tau = material_->kirchhoff_stress(deformation_gradient(p));
    sigma = {tau[0], tau[4], tau[8], tau[1], tau[5], tau[2]};
  }
  const Real volume_ratio = J(p);
  for (Real& component : sigma) component /= volume_ratio;
  return sigma;
}

/// Of one particle; center_of_mass holds m x until the caller divides.
template <int Dim, class R>
BodyTotals ParticleBody<Dim, R>::totals_of(const Particle& p, const Vec3& gravity) const {
  BodyTotals one;
  one.particle_count = 1;
  const Real volume = volume0(p);
  one.mass = volume * material_->density();
  one.lower = one.upper = p.position;
  const Vec3 v = velocity(p);
  for (std::size_t d = 0; d < Dim; ++d) {
    one.momentum[d] = one.mass * v[d];
    one.center_of_mass[d] = one.mass * p.position[d];
    one.kinetic_energy += 0.5 * one.mass * v[d] * v[d];
    one.gravitational_energy -= one.mass * gravity[d] * p.position[d];
  }
  one.strain_energy = material_->energy_density(deformation_gradient(p)) * volume;
  one.von_mises_max = von_mises(cauchy_stress(p));
  one.J_min = one.J_max = J(p);
  return one;
}

template <int Dim, class R>
BodyTotals ParticleBody<Dim, R>::totals(const Vec3& gravity) const {
  // Per band, then in the order of the bands: the same bits for any number of threads.
  const std::vector<Band>& bands = blocks_->bands();
  std::vector<BodyTotals> parts(bands.size());
  parallel_for(static_cast<Index>(bands.size()), blocks_->count(), [&](Index b) {
    const auto s = static_cast<std::size_t>(b);
    blocks_->for_each(bands[s], [&](const R* fields, const Vec3& x) {
      add(parts[s], totals_of(Particle{fields, k_lanes<R>, x}, gravity));
    });
  });
  BodyTotals sum;
  for (const BodyTotals& part : parts) {
    if (part.particle_count > 0) add(sum, part);
  }
  Real outside_mass = 0;
  for (const Outside& outside : outside_) {
    const BodyTotals one = totals_of(particle_of(outside), gravity);
    outside_mass += one.mass;
    add(sum, one);
  }
  if (sum.mass > 0) {
    for (Real& x : sum.center_of_mass) x /= sum.mass;
  }
  // As it was summed once and for all: the order of the particles changes, and with it the rounding of a sum over them.
  sum.mass = mass_ + outside_mass;
  return sum;
}

template <int Dim, class R>
std::vector<std::string> ParticleBody<Dim, R>::field_names() const {
  return particle_field_names();
}

template <int Dim, class R>
std::vector<std::int32_t> ParticleBody<Dim, R>::rows_of_ids() const {
  std::vector<std::int32_t> rows(static_cast<std::size_t>(id_count_), -1);
  for_each_particle([&](const Particle& p) { rows[static_cast<std::size_t>(id(p))] = 0; });
  std::int32_t next = 0;
  for (std::int32_t& row : rows) {
    if (row == 0) row = next++;
  }
  return rows;
}

template <int Dim, class R>
template <class F>
void ParticleBody<Dim, R>::for_each_particle_in_parallel(F&& f) const {
  const std::vector<Band>& bands = blocks_->bands();
  parallel_for(static_cast<Index>(bands.size()), blocks_->count(), [&](Index b) {
    blocks_->for_each(bands[static_cast<std::size_t>(b)], [&](const R* fields, const Vec3& position) {
      f(Particle{fields, k_lanes<R>, position});
    });
  });
  for (const Outside& outside : outside_) f(particle_of(outside));
}

template <int Dim, class R>
Field ParticleBody<Dim, R>::field(const std::string& name, std::size_t body) const {
  // Without removed particles an id is its own row.
  const std::vector<std::int32_t> rows = particle_count() == id_count_ ? std::vector<std::int32_t>{} : rows_of_ids();
  const auto gather = [&](const std::string& unit, std::size_t components, auto&& values_of) {
    Field field{name, unit, static_cast<int>(components), {}};
    field.values.resize(static_cast<std::size_t>(particle_count()) * components);
    for_each_particle_in_parallel([&](const Particle& p) {
      const auto number = static_cast<std::size_t>(id(p));
      const std::size_t row = rows.empty() ? number : static_cast<std::size_t>(rows[number]);
      const auto values = values_of(p);
      std::copy_n(values.begin(), components, field.values.begin() + static_cast<std::ptrdiff_t>(row * components));
    });
    return field;
  };
  using One = std::array<Real, 1>;
  if (name == "position") return gather("m", Dim, [&](const Particle& p) { return p.position; });
  if (name == "velocity") return gather("m/s", Dim, [&](const Particle& p) { return velocity(p); });
  if (name == "stress") return gather("Pa", 6, [&](const Particle& p) { return cauchy_stress(p); });
  if (name == "von_mises") return gather("Pa", 1, [&](const Particle& p) { return One{von_mises(cauchy_stress(p))}; });
  if (name == "pressure") {
    return gather("Pa", 1, [&](const Particle& p) {
      const auto s = cauchy_stress(p);
      return One{-(s[0] + s[1] + s[2]) / 3};
    });
  }
  if (name == "deformation_gradient") return gather("1", 9, [&](const Particle& p) { return deformation_gradient(p); });
  if (name == "J") return gather("1", 1, [&](const Particle& p) { return One{J(p)}; });
  if (name == "id") return gather("1", 1, [&](const Particle& p) { return One{static_cast<Real>(id(p))}; });
  if (name == "mass") return gather("kg", 1, [&](const Particle& p) { return One{volume0(p) * material_->density()}; });
  if (name == "volume") return gather("m^3", 1, [&](const Particle& p) { return One{J(p) * volume0(p)}; });
  if (name == "body") return gather("1", 1, [&](const Particle&) { return One{static_cast<Real>(body)}; });
  throw InputError("body \"{}\" has no field \"{}\", it has {}{}", name_, name, list_names(field_names()),
                   did_you_mean(name, field_names()));
}

template class ParticleBody<2, double>;
template class ParticleBody<3, double>;
template class ParticleBody<2, float>;
template class ParticleBody<3, float>;

}  // namespace matpoint
