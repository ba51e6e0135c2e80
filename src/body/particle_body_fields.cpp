// What a body in cell blocks tells about itself, and what may be assigned to it.
#include <algorithm>
#include <cmath>

#include "body/fill_body.hpp"
#include "body/particle_body.hpp"
#include "body/particle_fields.hpp"
#include "core/parallel.hpp"
#include "core/tensor.hpp"
#include "material/function_material.hpp"

namespace matpoint {

template <int Dim, class R>
Vec3 ParticleBody<Dim, R>::position_of(const R* fields, int stride, Vec3 place) const {
  for (int d = 0; d < Dim && blocks_->layout().u >= 0; ++d)
    place[static_cast<std::size_t>(d)] += static_cast<Real>(fields[(blocks_->layout().u + d) * stride]);
  return place;
}

template <int Dim, class R>
Vec3 ParticleBody<Dim, R>::velocity(const Particle& p) const {
  Vec3 v{};
  for (int d = 0; d < Dim; ++d) v[static_cast<std::size_t>(d)] = p.field(blocks_->layout().v + d);
  return v;
}

template <int Dim, class R>
Vec3 ParticleBody<Dim, R>::displacement(const Particle& p) const {
  const SlotLayout<Dim>& at = blocks_->layout();
  Vec3 u{};
  for (int d = 0; d < Dim; ++d) {
    const auto s = static_cast<std::size_t>(d);
    u[s] = at.u >= 0 ? p.field(at.u + d) : p.position[s] - grid_.lower(d) - p.field(at.start + d);
  }
  return u;
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
  if (blocks_->layout().hoop >= 0) F[8] = p.field(blocks_->layout().hoop);
  return F;
}

template <int Dim, class R>
Real ParticleBody<Dim, R>::J(const Particle& p) const {
  return determinant_of(deformation_gradient(p));
}

template <int Dim, class R>
PointHistory ParticleBody<Dim, R>::history(const Particle& p) const {
  const SlotLayout<Dim>& at = blocks_->layout();
  return {material_->has_state() ? at.history_count : 0, [&](int h) { return p.field(at.history + h); }};
}

template <int Dim, class R>
std::array<Real, 6> ParticleBody<Dim, R>::cauchy_stress(const Particle& p) const {
  std::array<Real, 6> sigma{};
  const SlotLayout<Dim>& at = blocks_->layout();
  if (at.tau >= 0) {
    for (std::size_t s = 0; s < k_stress_size<Dim>; ++s) sigma[s] = p.field(at.tau + static_cast<int>(s));
  } else if (p.tau != nullptr) {
    for (std::size_t s = 0; s < k_stress_size<Dim>; ++s) sigma[s] = static_cast<Real>(p.tau[static_cast<int>(s) * p.stride]);
  } else {
    sigma = components_of(material_->kirchhoff_stress(deformation_gradient(p), history(p)));
  }
  const Real volume_ratio = J(p);
  for (Real& component : sigma) component /= volume_ratio;
  return sigma;
}

template <int Dim, class R>
Material::Matrix ParticleBody<Dim, R>::affine_velocity(const Particle& p) const {
  Material::Matrix affine{};
  for (int r = 0; r < Dim; ++r) {
    for (int c = 0; c < Dim; ++c) affine[static_cast<std::size_t>(3 * r + c)] = p.field(blocks_->layout().C + r * Dim + c);
  }
  return affine;
}

template <int Dim, class R>
template <class F>
void ParticleBody<Dim, R>::for_each_with_stress(const Band& band, F&& f) const {
  constexpr int L = k_lanes<R>;
  Context context = make_context(0, 0);
  alignas(64) R tau[k_chunk_slots][k_stress_size<Dim>][L];
  alignas(64) R counts[L];
  R* slots[k_chunk_slots];
  int slots_in_use[k_parts_max];
  LawChunk<Dim, R> chunk;
  chunk.slots = slots;
  chunk.counts = counts;
  chunk.slots_in_use = slots_in_use;
  chunk.layout = &context.layout;
  chunk.uniform_volume = context.uniform_volume;
  chunk.tau = &tau[0][0][0];
  chunk.J_min = context.J_min;
  chunk.J_max = context.J_max;
  chunk.wave_modulus = context.wave_modulus;
  blocks_->for_each_block(band, [&](const Block<Dim, R>& block) {
    for (int first = 0; first < block.slot_count; first += k_chunk_slots) {
      const int slot_count = std::min(k_chunk_slots, block.slot_count - first);
      for (int k = 0; k < slot_count; ++k) slots[k] = block.slot(first + k);
      for (int lane = 0; lane < L; ++lane) counts[lane] = block.counts[lane] - static_cast<R>(first);
      std::fill_n(slots_in_use, k_parts_max, slot_count);
      // With no velocity gradient a kernel changes nothing but the stresses of rate-dependent laws, which are here already.
      if (context.layout.tau < 0) context.law_kernel(context.law, chunk);
      for (int k = 0; k < slot_count; ++k) {
        for (int lane = 0; lane < L; ++lane) {
          if (!(static_cast<R>(k) < counts[lane])) continue;
          const R* const fields = slots[k] + lane;
          f(Particle{fields, L, position_of(fields, L, blocks_->position(block, fields, lane)), &tau[k][0][lane]});
        }
      }
    }
  });
}

template <int Dim, class R>
BodyTotals ParticleBody<Dim, R>::totals_of(const Particle& p, const Vec3& gravity) const {
  return matpoint::totals_of({p.position, velocity(p), volume0(p), deformation_gradient(p), cauchy_stress(p), history(p)}, *material_,
                             gravity);
}

template <int Dim, class R>
BodyTotals ParticleBody<Dim, R>::totals(const Vec3& gravity) const {
  // Per band, then in the order of the bands: the same bits for any number of threads.
  const std::vector<Band>& bands = blocks_->bands();
  std::vector<BodyTotals> parts(bands.size());
  parallel_for(static_cast<Index>(bands.size()), blocks_->count(), [&](Index b) {
    const auto s = static_cast<std::size_t>(b);
    for_each_with_stress(bands[s], [&](const Particle& p) { add(parts[s], totals_of(p, gravity)); });
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
  std::vector<std::string> names = particle_field_names(*material_);
  if (blocks_->layout().C >= 0) names.push_back("affine_velocity");
  if (blocks_->layout().start >= 0 || blocks_->layout().u >= 0) names.push_back("displacement");
  return names;
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
    blocks_->for_each(bands[static_cast<std::size_t>(b)], [&](const R* fields, const Vec3& place) {
      f(Particle{fields, k_lanes<R>, position_of(fields, k_lanes<R>, place)});
    });
  });
  for (const Outside& outside : outside_) f(particle_of(outside));
}

template <int Dim, class R>
void ParticleBody<Dim, R>::take_fields(const std::vector<std::string>& names, std::size_t body, int vector_size,
                                       std::vector<Field>& fields) const {
  const WantedFields wanted = prepare_fields(name_, *material_, Dim, field_names(), names, vector_size, particle_count(), fields);
  // Without removed particles an id is its own row.
  const std::vector<std::int32_t> rows = particle_count() == id_count_ ? std::vector<std::int32_t>{} : rows_of_ids();
  gather_fields(*this, wanted, material_->density(), body, fields, [&](bool needs_stress, auto&& f) {
    const auto at_row = [&](const Particle& p) {
      const auto number = static_cast<std::size_t>(id(p));
      f(p, rows.empty() ? number : static_cast<std::size_t>(rows[number]));
    };
    if (!needs_stress) {
      for_each_particle_in_parallel(at_row);
      return;
    }
    const std::vector<Band>& bands = blocks_->bands();
    parallel_for(static_cast<Index>(bands.size()), blocks_->count(),
                 [&](Index b) { for_each_with_stress(bands[static_cast<std::size_t>(b)], at_row); });
    for (const Outside& outside : outside_) at_row(particle_of(outside));
  });
}

template <int Dim, class R>
void ParticleBody<Dim, R>::set_field(const std::string& name, const std::vector<Real>& values) {
  if (name == "affine_velocity" && blocks_->layout().C >= 0) {
    set_affine_velocity(values);
    return;
  }
  check_assigned_field(name_, name, particle_count(), Dim, values, scheme_.is_axisymmetric);
  if (name == "velocity") set_velocity(values);
  if (name == "position") set_position(values);
  if (name == "deformation_gradient") set_deformation_gradient(values);
  if (name == "stress") set_stress(values);
  measure_extremes();
}

template <int Dim, class R>
void ParticleBody<Dim, R>::set_body_force(const std::vector<Real>& values) {
  change_each_particle([&](R* fields, int stride, std::size_t row) {
    for (int d = 0; d < Dim; ++d)
      fields[(blocks_->layout().b + d) * stride] = static_cast<R>(values[row * Dim + static_cast<std::size_t>(d)]);
  });
}

template <int Dim, class R>
Real ParticleBody<Dim, R>::body_force_power(const std::vector<Real>& values, Vec3& force) const {
  const std::vector<std::int32_t> rows = rows_of_ids();
  // By id: the same bits for any number of threads and any history of the blocks.
  std::vector<Vec3> velocities(static_cast<std::size_t>(id_count_), Vec3{});
  std::vector<Real> mass(static_cast<std::size_t>(id_count_), 0);
  for_each_particle_in_parallel([&](const Particle& p) {
    const auto number = static_cast<std::size_t>(id(p));
    mass[number] = volume0(p) * material_->density();
    velocities[number] = velocity(p);
  });
  Real power = 0;
  force = {};
  for (std::size_t number = 0; number < rows.size(); ++number) {
    if (rows[number] < 0) continue;
    for (std::size_t d = 0; d < Dim; ++d) {
      const Real f = mass[number] * values[static_cast<std::size_t>(rows[number]) * Dim + d];
      force[d] += f;
      power += f * velocities[number][d];
    }
  }
  return power;
}

template <int Dim, class R>
void ParticleBody<Dim, R>::set_velocity(const std::vector<Real>& values) {
  change_each_particle([&](R* fields, int stride, std::size_t row) {
    const SlotLayout<Dim>& at = blocks_->layout();
    for (int d = 0; d < Dim; ++d) fields[(at.v + d) * stride] = static_cast<R>(values[row * Dim + static_cast<std::size_t>(d)]);
    // The affine part belonged to the old velocities.
    for (int e = 0; at.C >= 0 && e < Dim * Dim; ++e) fields[(at.C + e) * stride] = 0;
  });
}

template <int Dim, class R>
void ParticleBody<Dim, R>::set_affine_velocity(const std::vector<Real>& values) {
  if (values.size() != 9 * static_cast<std::size_t>(particle_count())) {
    throw InputError("body \"{}\": affine_velocity needs 9 numbers for each of its {} particles, got {} numbers", name_, particle_count(),
                     values.size());
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i]))
      throw InputError("body \"{}\": affine_velocity of particle row {} is not finite: {}", name_, i / 9, values[i]);
  }
  const int C = blocks_->layout().C;
  change_each_particle([&](R* fields, int stride, std::size_t row) {
    for (int r = 0; r < Dim; ++r) {
      for (int c = 0; c < Dim; ++c)
        fields[(C + r * Dim + c) * stride] = static_cast<R>(values[9 * row + static_cast<std::size_t>(3 * r + c)]);
    }
  });
}

template <int Dim, class R>
void ParticleBody<Dim, R>::set_deformation_gradient(const std::vector<Real>& values) {
  const SlotLayout<Dim>& at = blocks_->layout();
  // At rest: the rate of the last step belongs to another state. All before the first change, for a law given by a program may fail.
  const std::vector<Real> tau = at.tau >= 0 ? stresses_at_rest(values) : std::vector<Real>{};
  const bool has_shape = !material_->is_fluid() || at.u >= 0;  // a fluid keeps of F only J
  change_each_particle([&](R* fields, int stride, std::size_t row) {
    const Real* const F = values.data() + 9 * row;
    const Real J = determinant(Mat3<Real>{{F[0], F[1], F[2], F[3], F[4], F[5], F[6], F[7], F[8]}});
    for (int r = 0; r < Dim; ++r) {
      for (int c = 0; c < Dim; ++c) {
        const Real kept = has_shape ? F[3 * r + c] : r == c ? std::pow(J, Real{1} / (at.hoop >= 0 ? 3 : Dim)) : 0;
        fields[(at.F + r * Dim + c) * stride] = static_cast<R>(kept);
      }
    }
    if (at.hoop >= 0) fields[at.hoop * stride] = static_cast<R>(has_shape ? F[8] : std::cbrt(J));
    for (int s = 0; at.tau >= 0 && s < k_stress_size<Dim>; ++s)
      fields[(at.tau + s) * stride] = static_cast<R>(tau[6 * row + static_cast<std::size_t>(s)]);
    if (!material_->has_state()) return;
    Material::Matrix matrix;
    std::copy_n(F, 9, matrix.begin());
    std::vector<Real> remembered(static_cast<std::size_t>(at.history_count));
    for (std::size_t h = 0; h < remembered.size(); ++h)
      remembered[h] = static_cast<Real>(fields[(at.history + static_cast<int>(h)) * stride]);
    material_->deform_history(matrix, remembered);
    for (std::size_t h = 0; h < remembered.size(); ++h) fields[(at.history + static_cast<int>(h)) * stride] = static_cast<R>(remembered[h]);
  });
}

template <int Dim, class R>
void ParticleBody<Dim, R>::set_stress(const std::vector<Real>& values) {
  if (!material_->remembers_strain() && blocks_->layout().u >= 0)
    throw InputError("body \"{}\": stress cannot be assigned: with formulation = \"total\" the law \"{}\" has it from F", name_,
                     material_->type());
  const bool has_hoop_in_F = scheme_.is_axisymmetric && !material_->remembers_strain();
  const std::vector<InitialState> states = states_under(name_, *material_, has_hoop_in_F ? 3 : Dim, values);
  if (!material_->remembers_strain()) {
    std::vector<Real> F;
    for (const InitialState& state : states) F.insert(F.end(), state.F.begin(), state.F.end());
    set_deformation_gradient(F);
    return;
  }
  const SlotLayout<Dim>& at = blocks_->layout();
  const int strains = at.history_count - static_cast<int>(material_->internal_variables().size());
  change_each_particle([&](R* fields, int stride, std::size_t row) {
    for (int h = 0; h < strains; ++h) fields[(at.history + h) * stride] = static_cast<R>(states[row].history[static_cast<std::size_t>(h)]);
  });
}

template <int Dim, class R>
std::vector<Real> ParticleBody<Dim, R>::stresses_at_rest(const std::vector<Real>& F) {
  const std::size_t count = F.size() / 9;
  const SlotLayout<Dim>& at = blocks_->layout();
  const auto history_size = static_cast<std::size_t>(material_->history_size(Dim));
  std::vector<Real> history(count * history_size);
  change_each_particle([&](const R* fields, int stride, std::size_t row) {
    for (std::size_t h = 0; h < history_size; ++h)
      history[row * history_size + h] = static_cast<Real>(fields[(at.history + static_cast<int>(h)) * stride]);
  });
  std::vector<Real> tau(9 * count);
  if (const auto* function = dynamic_cast<const FunctionMaterial*>(material_.get())) {
    const std::vector<Real> L(9 * count, 0);
    function->evaluate({static_cast<Index>(count), F.data(), L.data(), 0, history.data(), tau.data()});
  } else {
    for (std::size_t i = 0; i < tau.size(); i += 9) {
      Material::Matrix m;
      std::copy_n(F.begin() + static_cast<std::ptrdiff_t>(i), 9, m.begin());
      m = material_->kirchhoff_stress(m);
      std::copy(m.begin(), m.end(), tau.begin() + static_cast<std::ptrdiff_t>(i));
    }
  }
  std::vector<Real> components(6 * count);
  for (std::size_t row = 0; row < count; ++row) {
    Material::Matrix m;
    std::copy_n(tau.begin() + static_cast<std::ptrdiff_t>(9 * row), 9, m.begin());
    const std::array<Real, 6> one = components_of(m);
    if (!std::all_of(one.begin(), one.end(), [](Real x) { return std::isfinite(x); }))
      throw InputError("body \"{}\": the stress that belongs to deformation_gradient of particle row {} is not finite", name_, row);
    std::copy(one.begin(), one.end(), components.begin() + static_cast<std::ptrdiff_t>(6 * row));
  }
  return components;
}

template <int Dim, class R>
void ParticleBody<Dim, R>::set_position(const std::vector<Real>& values) {
  if (blocks_->layout().u >= 0) {
    // The particle keeps its place in the reference configuration.
    std::vector<Real> old = this->field("position", 0).values;
    change_each_particle([&](R* fields, int stride, std::size_t row) {
      for (int d = 0; d < Dim; ++d) {
        const std::size_t k = row * Dim + static_cast<std::size_t>(d);
        fields[(blocks_->layout().u + d) * stride] += static_cast<R>(values[k] - old[k]);
      }
    });
    return;
  }
  if (!outside_.empty()) throw InputError("body \"{}\": position cannot be assigned while particles are outside of the grid", name_);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const int d = static_cast<int>(i % Dim);
    if (values[i] >= grid_.lower(d) && values[i] <= grid_.upper(d)) continue;
    throw InputError("body \"{}\": position of particle row {} is outside of the grid: {} = {}, allowed: {} to {}", name_, i / Dim,
                     "xyz"[d], values[i], grid_.lower(d), grid_.upper(d));
  }
  const SlotLayout<Dim>& at = blocks_->layout();
  const auto field_count = static_cast<std::size_t>(at.field_count);
  std::vector<R> all(static_cast<std::size_t>(particle_count()) * field_count);
  change_each_particle([&](R* fields, int stride, std::size_t row) {
    for (std::size_t f = 0; f < field_count; ++f) all[row * field_count + f] = fields[static_cast<int>(f) * stride];
  });
  blocks_->remove_all();
  for (std::size_t row = 0; row < values.size() / Dim; ++row) {
    Place<Dim> cell;
    R* const fields = all.data() + row * field_count;
    for (int d = 0; d < Dim; ++d) {
      const auto s = static_cast<std::size_t>(d);
      const Real place = (values[row * Dim + s] - grid_.lower(d)) / grid_.cell_size(d);
      cell[s] = std::min(static_cast<int>(place), grid_.cells(d) - 1);  // points on the far side belong to the last cell
      fields[at.x + d] = static_cast<R>(std::min(place - cell[s], Real{1}));
    }
    blocks_->insert(cell, fields);
  }
  for (Band& band : blocks_->bands()) blocks_->prune(band);
}

template <int Dim, class R>
void ParticleBody<Dim, R>::measure_extremes() {
  std::fill_n(speed_max_, Dim, Real{0});
  J_min_ = J_max_ = 1;
  wave_modulus_ = 0;
  for_each_particle([&](const Particle& p) {
    const Vec3 v = velocity(p);
    for (int d = 0; d < Dim; ++d) speed_max_[d] = std::max(speed_max_[d], std::abs(v[static_cast<std::size_t>(d)]));
    J_min_ = std::min(J_min_, J(p));
    J_max_ = std::max(J_max_, J(p));
    if (material_->has_wave_modulus())
      wave_modulus_ = std::max(wave_modulus_, material_->wave_modulus(deformation_gradient(p), history(p)));
  });
}

template class ParticleBody<2, double>;
template class ParticleBody<3, double>;
template class ParticleBody<2, float>;
template class ParticleBody<3, float>;

}  // namespace matpoint
