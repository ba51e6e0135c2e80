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
  int history_size() const override { return k_history_size<Law>; }
  bool is_rate_dependent() const override { return k_is_rate_dependent<Law>; }
  bool is_scalar_only() const override { return k_is_scalar_only<Law>; }
  bool is_fluid() const override { return k_is_fluid<Law>; }
  int law_index() const override { return matpoint::law_index<Law>(static_cast<AllLaws*>(nullptr)); }
  const void* law_data() const override { return &law; }

  Matrix kirchhoff_stress(const Matrix& F) const override {
    const Kinematics<Mat3<Real>> k{to_mat3(F), Mat3<Real>::zero(), 0};
    using History = typename LawHistory<Law, Real>::Type;
    History unused{};
    const Mat3<Real> tau = kirchhoff_stress_of(law, k, History{}, unused);
    Matrix result;
    std::copy_n(tau.entries, 9, result.begin());
    return result;
  }
  Real energy_density(const Matrix& F) const override {
    if constexpr (requires(Mat3<Real> m) { law.energy_density(m); })
      return law.energy_density(to_mat3(F));
    else
      return 0;
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
  static Mat3<Real> to_mat3(const Matrix& F) {
    Mat3<Real> matrix;
    std::copy(F.begin(), F.end(), matrix.entries);
    return matrix;
  }
};

}  // namespace matpoint
