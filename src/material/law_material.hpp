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
  bool flows() const override { return k_flows<Law>; }
  bool flows_freely() const override { return k_flows_freely<Law>; }
  bool is_symmetric() const override { return k_is_symmetric<Law>; }
  bool is_scalar_only() const override { return k_is_scalar_only<Law>; }
  bool is_fluid() const override { return k_is_fluid<Law>; }
  int law_index() const override { return matpoint::law_index<Law>(static_cast<AllLaws*>(nullptr)); }
  const void* law_data() const override { return &law; }
  std::vector<InternalVariable> internal_variables() const override {
    if constexpr (k_flows<Law>)
      return {Law::internal_variables.begin(), Law::internal_variables.end()};
    else
      return {};
  }

  Matrix kirchhoff_stress(const Matrix& F, std::span<const Real> history = {}) const override {
    if constexpr (k_flows<Law>) {
      return of_state(F, history, [this](const auto& h) { return to_matrix(law.elastic_stress(h)); });
    } else {
      const Kinematics<Mat3<Real>> k{to_mat3(F), Mat3<Real>::zero(), 0};
      using History = typename LawHistory<Law, Real>::Type;
      History unused{};
      Real nothing = 0;
      return to_matrix(kirchhoff_stress_of(law, k, History{}, unused, nothing));
    }
  }
  Real energy_density(const Matrix& F, std::span<const Real> history = {}) const override {
    if constexpr (k_flows<Law>)
      return of_state(F, history, [this](const auto& h) { return law.elastic_energy(h); });
    else if constexpr (requires(Mat3<Real> m) { law.energy_density(m); })
      return law.energy_density(to_mat3(F));
    else
      return 0;
  }
  void deform_history(const Matrix& F, std::span<Real> history) const override {
    if constexpr (k_flows<Law>) {
      const Mat3<Real> h = left_cauchy_green_minus_identity(to_mat3(F));
      if (history.size() == static_cast<std::size_t>(k_history_size<Law, true>)) {
        Law::pack(plane_of(h), *reinterpret_cast<typename LawHistory<Law, Real, true>::Type*>(history.data()));
      } else {
        Law::pack(h, *reinterpret_cast<typename LawHistory<Law, Real, false>::Type*>(history.data()));
      }
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
  /// f(h) of a law that flows, h = b - I of the elastic state: from the history, or from F where that is empty.
  template <class F_of_h>
  static auto of_state(const Matrix& F, std::span<const Real> history, F_of_h&& f) {
    if (history.empty()) return f(left_cauchy_green_minus_identity(to_mat3(F)));
    if (history.size() == static_cast<std::size_t>(k_history_size<Law, true>)) {
      using History = typename LawHistory<Law, Real, true>::Type;
      return f(Law::template unpacked<Mat3<Real, true>>(*reinterpret_cast<const History*>(history.data())));
    }
    using History = typename LawHistory<Law, Real, false>::Type;
    return f(Law::template unpacked<Mat3<Real>>(*reinterpret_cast<const History*>(history.data())));
  }
  static Mat3<Real, true> plane_of(const Mat3<Real>& a) { return {{a(0, 0), a(0, 1), a(1, 0), a(1, 1), a(2, 2)}}; }
  template <bool is_plane>
  static Matrix to_matrix(const Mat3<Real, is_plane>& a) {
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
