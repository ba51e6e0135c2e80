#pragma once

#include "material/law.hpp"
#include "material/spectral.hpp"

namespace matpoint {

/// Hencky's solid: tau = K theta I + 2 G dev e with the logarithmic strain e = ln(b)/2 and theta = tr e = ln J;
/// W = K theta^2/2 + G |dev e|^2. Source: Hencky (1928); Anand (1979). For small elastic strains of any rotation: beyond J = e, and beyond
/// a simple shear of 3.018, it softens. The elastic part of all laws that flow (flow_law.hpp).
struct Hencky : ElasticParameters {
  static constexpr auto name = "hencky";
  static constexpr auto summary = "Hencky's solid, linear in the logarithmic strain (Anand 1979): the elastic part of the laws that flow.";

  static void declare(ParameterTable<Hencky>& table) { declare_elastic(table); }

  template <class M>
  M kirchhoff_stress(const M& F) const {
    return isotropic(left_cauchy_green_minus_identity(F), [this](const auto* e) {
      using T = std::remove_cvref_t<decltype(*e)>;
      const T volumetric = T(lambda() * (e[0] + e[1] + e[2]));
      return std::array<T, 3>{T(volumetric + 2 * mu() * e[0]), T(volumetric + 2 * mu() * e[1]), T(volumetric + 2 * mu() * e[2])};
    });
  }

  template <class M>
  typename M::Scalar energy_density(const M& F) const {
    using T = typename M::Scalar;
    // The trace of the tensor whose principal values are those of the energy, e by e.
    const M energies = isotropic(left_cauchy_green_minus_identity(F), [this](const auto* e) {
      using U = std::remove_cvref_t<decltype(*e)>;
      const U theta = U(e[0] + e[1] + e[2]);
      const U shared = U(lambda() / 6 * theta * theta);
      return std::array<U, 3>{U(shared + mu() * e[0] * e[0]), U(shared + mu() * e[1] * e[1]), U(shared + mu() * e[2] * e[2])};
    });
    return T(trace(energies));
  }

  /// Of plane waves along a uniaxial stretch J: c^2 = (K + 4G/3) (1 - ln J) / rho0, and never below that of shear.
  Real wave_speed(Real J) const { return std::sqrt(std::max(mu(), (lambda() + 2 * mu()) * (1 - std::log(J))) / density); }
};

}  // namespace matpoint
