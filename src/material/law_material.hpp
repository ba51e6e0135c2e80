// From a law to a Material: written once for all laws.
#pragma once

#include "material/laws.hpp"
#include "material/material.hpp"

namespace matpoint {

/// The place of a law in AllLaws.
template <class Law, class... Laws>
constexpr int law_index(std::tuple<Laws...>*) {
  int index = 0;
  (void)((std::is_same_v<Law, Laws> ? true : (++index, false)) || ...);
  return index;
}

template <class Law>
class LawMaterial final : public Material {
 public:
  Law law;

  std::string type() const override { return Law::name; }
  Real density() const override { return law.density; }
  int history_size(int dim) const override { return dim == 2 ? k_history_size<Law, true> : k_history_size<Law, false>; }
  bool is_rate_dependent() const override { return k_is_rate_dependent<Law>; }
  bool has_state() const override { return k_has_state<Law>; }
  bool remembers_strain() const override { return k_remembers_strain<Law>; }
  bool is_plastic() const override { return k_has_state<Law> && !k_is_viscous<Law>; }
  bool flows_freely() const override { return k_flows_freely<Law>; }
  bool is_symmetric() const override { return k_is_symmetric<Law>; }
  bool is_scalar_only() const override { return k_is_scalar_only<Law>; }
  bool is_fluid() const override { return k_is_fluid<Law>; }
  int law_index() const override { return matpoint::law_index<Law>(static_cast<AllLaws*>(nullptr)); }
  const void* law_data() const override { return &law; }
  std::vector<InternalVariable> internal_variables() const override {
    if constexpr (requires { law.variables(); }) {
      const auto variables = law.variables();
      return {variables.begin(), variables.end()};
    } else if constexpr (k_has_state<Law>) {
      return {Law::internal_variables.begin(), Law::internal_variables.end()};
    } else {
      return {};
    }
  }

  Matrix kirchhoff_stress(const Matrix& F, std::span<const Real> history = {}) const override {
    if constexpr (k_has_state<Law>) {
      return of_state(F, history, [this](const auto& deformation, const auto& h) { return to_matrix(law.stress_of(deformation, h)); });
    } else {
      const Kinematics<Mat3<Real>> k{to_mat3(F), Mat3<Real>::zero(), 0};
      using History = typename LawHistory<Law, Real>::Type;
      History unused{};
      Real nothing = 0;
      return to_matrix(kirchhoff_stress_of(law, k, History{}, unused, nothing));
    }
  }
  Real energy_density(const Matrix& F, std::span<const Real> history = {}) const override {
    if constexpr (k_has_state<Law>)
      return of_state(F, history, [this](const auto& deformation, const auto& h) { return law.energy_of(deformation, h); });
    else if constexpr (requires(Mat3<Real> m) { law.energy_density(m); })
      return law.energy_density(to_mat3(F));
    else
      return 0;
  }
  void deform_history(const Matrix& F, std::span<Real> history) const override {
    if constexpr (k_has_state<Law>) {
      if (is_plane(history.size()))
        law.deform(plane_of(F), *reinterpret_cast<typename LawHistory<Law, Real, true>::Type*>(history.data()));
      else
        law.deform(to_mat3(F), *reinterpret_cast<typename LawHistory<Law, Real>::Type*>(history.data()));
    }
  }
  bool consolidates() const override { return k_consolidates; }
  void consolidate([[maybe_unused]] std::span<Real> history, [[maybe_unused]] Real ratio) const override {
    if constexpr (k_consolidates) {
      if (is_plane(history.size()))
        law.template consolidate<Mat3<Real, true>>(*reinterpret_cast<typename LawHistory<Law, Real, true>::Type*>(history.data()), ratio);
      else
        law.template consolidate<Mat3<Real>>(*reinterpret_cast<typename LawHistory<Law, Real>::Type*>(history.data()), ratio);
    }
  }
  bool needs_length() const override {
    if constexpr (requires { law.needs_length(); })
      return law.needs_length();
    else if constexpr (requires { law.length; })
      return !law.length;
    else
      return false;
  }
  std::shared_ptr<Material> with_length([[maybe_unused]] Real length, [[maybe_unused]] const Input& place,
                                        [[maybe_unused]] const ReadContext& context) const override {
    auto same = std::make_shared<LawMaterial<Law>>(*this);
    if constexpr (requires { law.length; }) {
      same->law.length = length;
      if constexpr (requires { same->law.check(place, context); }) same->law.check(place, context);
    }
    return same;
  }
  bool has_wave_modulus() const override { return k_has_wave_modulus<Law>; }
  Real wave_modulus(const Matrix& F, std::span<const Real> history) const override {
    if constexpr (k_has_wave_modulus<Law>) {
      return of_state(F, history, [this](const auto& deformation, const auto& h) { return law.wave_modulus(deformation, h); });
    } else {
      return 0;
    }
  }
  Real wave_speed(Real J) const override { return law.wave_speed(J); }
  Real kinematic_viscosity(Real J) const override {
    if constexpr (requires { law.kinematic_viscosity(J); })
      return law.kinematic_viscosity(J);
    else
      return 0;
  }
  Input write(int dim) const override { return write_typed(law, dim); }

 private:
  static constexpr bool k_consolidates = requires(const Law& one, typename LawHistory<Law, Real>::Type& history) {
    one.template consolidate<Mat3<Real>>(history, Real{1});
  };

  /// f(F, history) of a law with a state; where `history` is empty, of a point that was brought to F elastically.
  template <class Function>
  auto of_state(const Matrix& F, std::span<const Real> history, Function&& f) const {
    using Plane = typename LawHistory<Law, Real, true>::Type;
    using Full = typename LawHistory<Law, Real>::Type;
    if constexpr (std::is_empty_v<Full>) {
      return f(to_mat3(F), Full{});
    } else {
      if (is_plane(history.size())) return f(plane_of(F), *reinterpret_cast<const Plane*>(history.data()));
      if (!history.empty()) return f(to_mat3(F), *reinterpret_cast<const Full*>(history.data()));
      Full brought{};
      law.deform(to_mat3(F), brought);
      return f(to_mat3(F), brought);
    }
  }
  static Mat3<Real, true> plane_of(const Matrix& F) { return {{F[0], F[1], F[3], F[4], F[8]}}; }
  /// Whether a history of that size is one of plane strain. Where both are as long, F tells, and is 0 out of the plane.
  static bool is_plane(std::size_t size) {
    return k_history_size<Law, true> != k_history_size<Law, false> && size == static_cast<std::size_t>(k_history_size<Law, true>);
  }
  template <bool plane>
  static Matrix to_matrix(const Mat3<Real, plane>& a) {
    Matrix result{};
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) {
        if (a.is_stored(r, c)) result[static_cast<std::size_t>(3 * r + c)] = a(r, c);
      }
    }
    return result;
  }
  static Mat3<Real> to_mat3(const Matrix& F) {
    Mat3<Real> matrix;
    std::copy(F.begin(), F.end(), matrix.entries);
    return matrix;
  }
};

}  // namespace matpoint
