#include "body/point_body.hpp"

#include <algorithm>
#include <numeric>

#include "body/fill_body.hpp"
#include "body/particle_fields.hpp"
#include "core/parallel.hpp"

namespace matpoint {
namespace {

/// Particles whose totals one thread adds; the sums of the pieces are added in their order.
constexpr std::size_t k_piece = 4096;

}  // namespace

/// The accessors that gather_fields asks for.
template <int Dim>
struct PointBody<Dim>::Rows {
  const PointBody& body;
  Vec3 position(std::size_t p) const { return body.row_position(p); }
  Vec3 velocity(std::size_t p) const { return widened(body.velocity[p]); }
  Vec3 displacement(std::size_t p) const {
    Vec3 u{};
    for (std::size_t d = 0; d < Dim; ++d) u[d] = body.position[p][d] - body.start[p][d];
    return u;
  }
  std::array<Real, 6> cauchy_stress(std::size_t p) const { return body.row_cauchy_stress(p); }
  Material::Matrix deformation_gradient(std::size_t p) const { return body.row_deformation_gradient(p); }
  Material::Matrix affine_velocity(std::size_t) const { return {}; }
  Real remembered(std::size_t p, int place) const {
    const auto count = static_cast<std::size_t>(body.material_->history_size(Dim));
    return body.history[p * count + static_cast<std::size_t>(place)];
  }
  Index id(std::size_t p) const { return body.id[p]; }
  Real volume0(std::size_t p) const { return body.volume0[p]; }
};

template <int Dim>
PointBody<Dim>::PointBody(const BodySpec& spec) : name_(spec.name), material_(spec.material) {}

template <int Dim>
void PointBody<Dim>::add_point(const Vec<Dim>& x, Real volume) {
  position.push_back(x);
  velocity.push_back({});
  acceleration.push_back({});
  for (int k = 0; k < Dim * Dim; ++k) F.push_back(k % (Dim + 1) == 0 ? 1 : 0);
  volume0.push_back(volume);
  mass.push_back(volume * material_->density());
  total_mass_ += mass.back();
  history.resize(history.size() + static_cast<std::size_t>(material_->history_size(Dim)), 0);
  if (material_->is_rate_dependent()) {
    const std::array<Real, 6> rest = components_of(material_->kirchhoff_stress({1, 0, 0, 0, 1, 0, 0, 0, 1}));
    tau.insert(tau.end(), rest.begin(), rest.end());
  }
  id.push_back(count() - 1);
}

template <int Dim>
PointBody<Dim>::PointBody(const BodySpec& spec, const SeedingGrid& grid) : name_(spec.name), material_(spec.material) {
  Seeds seeds = fill_body(spec, grid);
  const std::vector<InitialState> states = initial_states(spec, Dim, seeds);
  const std::size_t n = seeds.position.size();
  position.resize(n);
  velocity.resize(n);
  acceleration.resize(n);
  F.assign(n * Dim * Dim, 0);
  volume0 = seeds.volume;
  mass.resize(n);
  history.assign(n * static_cast<std::size_t>(material_->history_size(Dim)), 0);
  id.resize(n);
  std::iota(id.begin(), id.end(), Index{0});
  for (std::size_t p = 0; p < n; ++p) {
    const Vec3 v = spec.velocity ? spec.velocity->at(seeds.position[p]) : Vec3{};
    std::copy_n(seeds.position[p].begin(), Dim, position[p].begin());
    std::copy_n(v.begin(), Dim, velocity[p].begin());
    for (std::size_t d = 0; d < Dim; ++d) F[p * Dim * Dim + d * Dim + d] = 1;
    mass[p] = volume0[p] * material_->density();
  }
  total_mass_ = std::accumulate(mass.begin(), mass.end(), Real{0});
  if (material_->is_rate_dependent()) tau.resize(6 * n);
  if (spec.keeps_displacement) start = position;
  take_states(states);
  reset_stress();
}

template <int Dim>
void PointBody<Dim>::take_states(const std::vector<InitialState>& states) {
  const auto count_of = static_cast<std::size_t>(material_->history_size(Dim));
  for (std::size_t p = 0; p < states.size(); ++p) {
    for (std::size_t r = 0; r < Dim; ++r) {
      for (std::size_t c = 0; c < Dim; ++c) F[(p * Dim + r) * Dim + c] = states[p].F[3 * r + c];
    }
    std::copy(states[p].history.begin(), states[p].history.end(), history.begin() + static_cast<std::ptrdiff_t>(p * count_of));
  }
}

template <int Dim>
void PointBody<Dim>::start_with(const BodySpec& spec) {
  Seeds seeds;
  seeds.volume = volume0;
  for (std::size_t p = 0; p < static_cast<std::size_t>(count()); ++p) seeds.position.push_back(row_position(p));
  take_states(initial_states(spec, Dim, seeds));
  reset_stress();
}

template <int Dim>
void PointBody<Dim>::reset_stress() {
  for (std::size_t p = 0; 6 * p < tau.size(); ++p) {
    const std::array<Real, 6> one = components_of(material_->kirchhoff_stress(row_deformation_gradient(p), row_history(p)));
    std::copy(one.begin(), one.end(), tau.begin() + static_cast<std::ptrdiff_t>(6 * p));
  }
}

template <int Dim>
Vec3 PointBody<Dim>::widened(const Vec<Dim>& a) {
  Vec3 x{};
  std::copy(a.begin(), a.end(), x.begin());
  return x;
}

template <int Dim>
Material::Matrix PointBody<Dim>::row_deformation_gradient(std::size_t p) const {
  Material::Matrix matrix{1, 0, 0, 0, 1, 0, 0, 0, 1};
  for (std::size_t r = 0; r < Dim; ++r) {
    for (std::size_t c = 0; c < Dim; ++c) matrix[3 * r + c] = F[(p * Dim + r) * Dim + c];
  }
  return matrix;
}

template <int Dim>
PointHistory PointBody<Dim>::row_history(std::size_t p) const {
  const int count = material_->has_state() ? material_->history_size(Dim) : 0;
  return {count, [&](int h) { return history[p * static_cast<std::size_t>(count) + static_cast<std::size_t>(h)]; }};
}

template <int Dim>
std::array<Real, 6> PointBody<Dim>::row_cauchy_stress(std::size_t p) const {
  const Material::Matrix matrix = row_deformation_gradient(p);
  std::array<Real, 6> sigma;
  if (tau.empty())
    sigma = components_of(material_->kirchhoff_stress(matrix, row_history(p)));
  else
    std::copy_n(tau.begin() + static_cast<std::ptrdiff_t>(6 * p), 6, sigma.begin());
  const Real J = determinant_of(matrix);
  for (Real& component : sigma) component /= J;
  return sigma;
}

template <int Dim>
BodyTotals PointBody<Dim>::totals(const Vec3& gravity) const {
  const auto n = static_cast<std::size_t>(count());
  std::vector<BodyTotals> parts((n + k_piece - 1) / k_piece);
  parallel_for(static_cast<Index>(parts.size()), count(), [&](Index k) {
    const std::size_t first = static_cast<std::size_t>(k) * k_piece;
    for (std::size_t p = first; p < std::min(n, first + k_piece); ++p) {
      add(parts[static_cast<std::size_t>(k)],
          totals_of({row_position(p), widened(velocity[p]), volume0[p], row_deformation_gradient(p), row_cauchy_stress(p), row_history(p)},
                    *material_, gravity));
    }
  });
  BodyTotals sum;
  for (const BodyTotals& part : parts) add(sum, part);
  if (sum.mass > 0) {
    for (Real& x : sum.center_of_mass) x /= sum.mass;
  }
  sum.mass = total_mass_;
  return sum;
}

template <int Dim>
void PointBody<Dim>::take_fields(const std::vector<std::string>& names, std::size_t body, int vector_size,
                                 std::vector<Field>& fields) const {
  const WantedFields wanted = prepare_fields(name_, *material_, Dim, field_names(), names, vector_size, count(), fields);
  gather_fields(Rows{*this}, wanted, material_->density(), body, fields, [&](bool, auto&& f) {
    for (std::size_t p = 0; p < static_cast<std::size_t>(count()); ++p) f(p, p);
  });
}

template <int Dim>
Field PointBody<Dim>::field(const std::string& name, std::size_t body) const {
  std::vector<Field> one;
  take_fields({name}, body, Dim, one);
  return std::move(one.front());
}

template <int Dim>
void PointBody<Dim>::set_field(const std::string& name, const std::vector<Real>& values) {
  check_assigned_field(name_, name, count(), Dim, values);
  for (std::size_t p = 0; p < static_cast<std::size_t>(count()); ++p) {
    if (name == "position") std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(p * Dim), Dim, position[p].begin());
    if (name == "velocity") std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(p * Dim), Dim, velocity[p].begin());
    if (name == "deformation_gradient") {
      for (std::size_t r = 0; r < Dim; ++r) {
        for (std::size_t c = 0; c < Dim; ++c) F[(p * Dim + r) * Dim + c] = values[9 * p + 3 * r + c];
      }
    }
  }
  if (name == "stress") {
    const std::vector<InitialState> states = states_under(name_, *material_, Dim, values);
    const auto size = static_cast<std::size_t>(material_->history_size(Dim));
    const std::size_t strains = size - material_->internal_variables().size();
    for (std::size_t p = 0; p < states.size(); ++p) {
      if (material_->remembers_strain()) {
        std::copy_n(states[p].history.begin(), strains, history.begin() + static_cast<std::ptrdiff_t>(p * size));
        continue;
      }
      for (std::size_t r = 0; r < Dim; ++r) {
        for (std::size_t c = 0; c < Dim; ++c) F[(p * Dim + r) * Dim + c] = states[p].F[3 * r + c];
      }
      material_->deform_history(states[p].F, {history.data() + p * size, size});
    }
    reset_stress();
  }
  if (name != "deformation_gradient") return;
  // At rest: the rate of the last step belongs to another state.
  reset_stress();
  const auto count_of = static_cast<std::size_t>(material_->history_size(Dim));
  for (std::size_t p = 0; p < static_cast<std::size_t>(count()); ++p)
    material_->deform_history(row_deformation_gradient(p), {history.data() + p * count_of, count_of});
}

template <int Dim>
void PointBody<Dim>::remove(const std::vector<Index>& rows, const Vec3& gravity, Ledger& ledger) {
  std::vector<bool> is_removed(mass.size(), false);
  for (const Index row : rows) {
    const auto p = static_cast<std::size_t>(row);
    is_removed[p] = true;
    const BodyTotals one =
        totals_of({row_position(p), widened(velocity[p]), volume0[p], row_deformation_gradient(p), row_cauchy_stress(p), row_history(p)},
                  *material_, gravity);
    ++ledger.removed_count;
    ledger.removed_mass += one.mass;
    total_mass_ -= one.mass;
    for (std::size_t d = 0; d < 3; ++d) ledger.removed_momentum[d] += one.momentum[d];
    ledger.removed_energy += one.kinetic_energy + one.strain_energy + one.gravitational_energy;
  }
  const auto keep = [&](auto& array) {
    const std::size_t width = array.size() / is_removed.size();
    std::size_t next = 0;
    for (std::size_t k = 0; k < array.size(); ++k) {
      if (!is_removed[k / width]) array[next++] = array[k];
    }
    array.resize(next);
  };
  keep(position);
  keep(velocity);
  keep(acceleration);
  keep(F);
  keep(volume0);
  keep(mass);
  if (!history.empty()) keep(history);
  if (!tau.empty()) keep(tau);
  keep(id);
  if (!start.empty()) keep(start);
}

template <int Dim>
std::vector<std::string> PointBody<Dim>::field_names() const {
  std::vector<std::string> names = particle_field_names(*material_);
  if (!start.empty()) names.push_back("displacement");
  return names;
}

template <int Dim>
Index PointBody<Dim>::memory() const {
  const std::size_t numbers =
      (position.size() * 3 + start.size()) * Dim + F.size() + volume0.size() + mass.size() + history.size() + tau.size() + id.size();
  return static_cast<Index>(numbers * sizeof(Real));
}

template <int Dim>
void PointBody<Dim>::declare_state(State& state) {
  state.add("id", id);
  state.add("position", position);
  state.add("velocity", velocity);
  state.add("acceleration", acceleration);
  state.add("deformation_gradient", F);
  state.add("reference_volume", volume0);
  state.add("mass", mass);
  state.add("history", history);
  state.add("kirchhoff_stress", tau);
  state.add("total_mass", total_mass_);
  const bool keeps_displacement = !start.empty();
  if (keeps_displacement) state.add("start_position", start);
  const auto check = [&](const char* name, std::size_t size, std::size_t width) {
    if (size != id.size() * width) state.fail(name, fmt::format("has {} numbers, not {}", size, id.size() * width));
  };
  for (std::size_t p = 0; p < id.size(); ++p) {
    if (id[p] < 0 || (p > 0 && id[p] <= id[p - 1])) state.fail("id", fmt::format("has {} in row {}, and ids ascend", id[p], p));
  }
  check("position", position.size(), 1);
  check("start_position", start.size(), keeps_displacement ? 1 : 0);
  check("velocity", velocity.size(), 1);
  check("acceleration", acceleration.size(), 1);
  check("deformation_gradient", F.size(), Dim * Dim);
  check("reference_volume", volume0.size(), 1);
  check("mass", mass.size(), 1);
  check("history", history.size(), static_cast<std::size_t>(material_->history_size(Dim)));
  check("kirchhoff_stress", tau.size(), material_->is_rate_dependent() ? 6 : 0);
}

template class PointBody<2>;
template class PointBody<3>;

}  // namespace matpoint
