// What all laws share that flow: metals, soils, grains, yield-stress fluids. They keep the elastic left Cauchy-Green tensor b, as
// h = b - I, and some numbers of their own. A step takes it along, h* = f b f^T - I with the step's deformation f, and the law brings the
// three principal logarithmic strains e* back to where it allows them to be. That is exact for any elastic strain and any rotation, no
// spin has to be chosen, and no energy comes from closed paths.
// Sources: Weber & Anand (1990); Simo (1992); Cuitino & Ortiz (1992).
//
// Elasticity is Hencky's: tau_i = K theta + 2 G dev e_i, W = K theta^2/2 + G |dev e|^2, theta the sum of the e_i.
//
//   struct J2 : FlowLaw<J2> {
//     ...                                                                   // name, summary, parameters as of any law
//     template <class T> struct Internal { T plastic_strain; };            // what it remembers beside h: members of type T, 0 at rest
//     static constexpr std::array<InternalVariable, 1> internal_variables = {{{"plastic_strain", "1"}}};
//     template <class State, class T> void flow(State& p, const Internal<T>& old, Internal<T>& updated, Real dt) const;
//   };
//
// `flow` finds p.e = e* (a Strain) and leaves the elastic e, without a branch on values of type T. With dt = 0 nothing that takes time
// happens. A law that only scales the deviator, by p.theta(), p.shear() and p.set(), says `static constexpr bool scales_deviator = true;`:
// then it is given a whole tensor where strains are small, and runs three times as fast in 3D.
#pragma once

#include <array>

#include "material/law.hpp"
#include "material/material.hpp"
#include "material/spectral.hpp"

namespace matpoint {

/// The strain of a point in a step, in its principal directions or as a tensor: 3 principal values, or xx yy zz xy, and yz xz in 3D.
template <class T, std::size_t size>
struct Strain {
  std::array<T, size> e;  ///< In: as the step would leave it without flow; out: elastic logarithmic strain [1].
  T dissipated{0.0};      ///< Out: in this step [J/m^3].

  T theta() const { return T(e[0] + e[1] + e[2]); }
  /// |dev e|, never 0, where its derivative would be infinite.
  T shear() const { return T(sqrt(T(shear_squared() + T(1e-30)))); }
  T shear_squared() const {
    std::array<T, size> s = e;
    const T mean = T(theta() * (1.0 / 3));
    for (std::size_t i = 0; i < 3; ++i) s[i] = T(e[i] - mean);
    return norm_squared(s);
  }
  /// Leaves a share of dev e, and the volume's strain theta.
  void set(const T& theta_new, const T& share) {
    const T mean = T(theta() * (1.0 / 3));
    for (std::size_t i = 0; i < size; ++i) e[i] = i < 3 ? T(T((e[i] - mean) * share) + T(theta_new * (1.0 / 3))) : T(e[i] * share);
  }
  /// Closes a gap that has opened, as far as the point is pressed: no stress builds up before. Returns what is left of the gap.
  ///
  /// A material that parts keeps its stress while F goes on; coming back, it would carry a load at once, at J > 1. So what has opened is
  /// kept: Klar et al. (2016) and Tampubolon et al. (2017) keep the same number for sand.
  T close(const T& gap) {
    const T closed = max(T(0.0), min(gap, T(-theta())));
    for (std::size_t i = 0; i < 3; ++i) e[i] = e[i] + closed * (1.0 / 3);
    return T(gap - closed);
  }

  static T norm_squared(const std::array<T, size>& a) {
    const T along = T(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
    if constexpr (size == 3) {
      return along;
    } else {
      T across = T(a[3] * a[3]);
      for (std::size_t i = 4; i < size; ++i) across = T(across + a[i] * a[i]);
      return T(along + 2.0 * across);
    }
  }
};
template <class T>
using Principal = Strain<T, 3>;

template <class Law>
struct FlowLaw : ElasticParameters {
  template <class T, bool is_plane>
  struct History {
    T h[is_plane ? 4 : 6];  ///< b - I: xx yy zz xy (yz xz).
    typename Law::template Internal<T> internal;
  };

  Real bulk_modulus() const { return lambda() + mu() * (2.0 / 3); }  ///< K [Pa]

  /// Kirchhoff stress after a step.
  template <class M, class H, class T = typename M::Scalar>
  M update(const Kinematics<M>& k, const H& old_history, H& updated, T& dissipated) const {
    // f b f^T - I with f = I + g.
    const M h = unpacked<M>(old_history);
    const M moved = k.g + k.g * h;
    const M trial = h + moved + transpose(moved) + moved * transpose(k.g);
    if constexpr (k_has_derivatives<T>) {
      using Inner = typename Law::template Internal<Dual<3>>;
      constexpr int count = sizeof(typename Law::template Internal<Real>) / sizeof(Real);
      Inner before{}, after{};
      for (int i = 0; i < count; ++i)
        reinterpret_cast<Dual<3>*>(&before)[i] = Dual<3>(reinterpret_cast<const T*>(&old_history.internal)[i].value());
      return isotropic(trial, [&](const Dual<3>* e) {
        Principal<Dual<3>> p{{e[0], e[1], e[2]}};
        law().flow(p, before, after, k.dt);
        return stress(p.e.data());
      });
    } else if constexpr (requires { requires Law::scales_deviator; }) {
      // Small elastic strains need no eigenvectors, which cost ten times as much. Each lane has the numbers of its own strain, whatever
      // the others have.
      constexpr std::size_t size = M::k_size == 9 ? 6 : 4;
      std::array<T, size> h_trial = {trial(0, 0), trial(1, 1), trial(2, 2), trial(0, 1)};
      if constexpr (size == 6) {
        h_trial[4] = trial(1, 2);
        h_trial[5] = trial(0, 2);
      }
      const T norm = Strain<T, size>::norm_squared(h_trial);
      const auto is_large = norm > T(k_series_norm * k_series_norm);
      M tau = update_by_series<M>(h_trial, old_history, updated, k.dt, dissipated);
      if (any(is_large)) {
        H other = updated;
        T other_dissipated(0.0);
        const M other_tau = update_by_spectrum<M>(trial, old_history, other, k.dt, other_dissipated);
        for (int e = 0; e < M::k_size; ++e) tau.entries[e] = select(is_large, other_tau.entries[e], tau.entries[e]);
        constexpr int count = static_cast<int>(sizeof(H) / sizeof(T));
        for (int i = 0; i < count; ++i) {
          T& number = reinterpret_cast<T*>(&updated)[i];
          number = select(is_large, reinterpret_cast<const T*>(&other)[i], number);
        }
        dissipated = select(is_large, other_dissipated, dissipated);
      }
      return tau;
    } else {
      return update_by_spectrum<M>(trial, old_history, updated, k.dt, dissipated);
    }
  }

  /// Kirchhoff stress of a state.
  template <class M, class H>
  M stress_of(const H& history) const {
    return elastic_stress(unpacked<M>(history));
  }
  /// The same where h is given.
  template <class M>
  M elastic_stress(const M& h) const {
    return isotropic(h, [this](const auto* e) { return stress(e); });
  }
  /// Stored energy of a state [J/m^3].
  template <class M, class H>
  typename M::Scalar energy_of(const H& history) const {
    return elastic_energy(unpacked<M>(history));
  }
  template <class M>
  typename M::Scalar elastic_energy(const M& h) const {
    using T = typename M::Scalar;
    const Spectrum<T, M::k_size == 5> spectrum(h);
    const Principal<T> p{{spectrum.half_log[0], spectrum.half_log[1], spectrum.half_log[2]}};
    const T theta = p.theta();
    return T(0.5 * bulk_modulus() * theta * theta + mu() * p.shear_squared());
  }
  /// Elastic waves in a stretched material: exact along a uniaxial one, and never below those of what flows.
  Real wave_speed(Real J) const { return std::sqrt((lambda() + 2 * mu()) * (1 - std::min(std::log(J), Real{0})) / density); }

  /// h as a matrix, and back.
  template <class M, class H>
  static M unpacked(const H& history) {
    M h;
    for (int d = 0; d < 3; ++d) h(d, d) = history.h[d];
    h(0, 1) = h(1, 0) = history.h[3];
    if constexpr (M::k_size == 9) {
      h(1, 2) = h(2, 1) = history.h[4];
      h(0, 2) = h(2, 0) = history.h[5];
    }
    return h;
  }
  template <class M, class H>
  static void pack(const M& h, H& history) {
    for (int d = 0; d < 3; ++d) history.h[d] = h(d, d);
    history.h[3] = h(0, 1);
    if constexpr (M::k_size == 9) {
      history.h[4] = h(1, 2);
      history.h[5] = h(0, 2);
    }
  }

 private:
  template <class M, class H, class T = typename M::Scalar>
  M update_by_spectrum(const M& trial, const H& old_history, H& updated, Real dt, T& dissipated) const {
    const Spectrum<T, M::k_size == 5> spectrum(trial);
    Principal<T> p{{spectrum.half_log[0], spectrum.half_log[1], spectrum.half_log[2]}};
    law().flow(p, old_history.internal, updated.internal, dt);
    T values[3];
    for (int i = 0; i < 3; ++i) values[i] = expm1(T(2.0 * p.e[i]));
    pack(spectrum.compose(values), updated);
    dissipated = p.dissipated;
    return spectrum.compose(stress(p.e.data()).data());
  }
  template <class M, class H, class T, std::size_t size>
  M update_by_series(const std::array<T, size>& h_trial, const H& old_history, H& updated, Real dt, T& dissipated) const {
    Strain<T, size> p{half_log1p_of_small(h_trial)};
    law().flow(p, old_history.internal, updated.internal, dt);
    std::array<T, size> twice;
    for (std::size_t i = 0; i < size; ++i) twice[i] = T(2.0 * p.e[i]);
    const std::array<T, size> h = expm1_of_small(twice);
    for (std::size_t i = 0; i < size; ++i) updated.h[i] = h[i];
    dissipated = p.dissipated;
    const T pressure = T(lambda() * p.theta());
    M tau;
    for (int d = 0; d < 3; ++d) tau(d, d) = T(pressure + mu() * twice[static_cast<std::size_t>(d)]);
    tau(0, 1) = tau(1, 0) = T(mu() * twice[3]);
    if constexpr (size == 6) {
      tau(1, 2) = tau(2, 1) = T(mu() * twice[4]);
      tau(0, 2) = tau(2, 0) = T(mu() * twice[5]);
    }
    return tau;
  }
  const Law& law() const { return static_cast<const Law&>(*this); }
  template <class T>
  std::array<T, 3> stress(const T* e) const {
    const T pressure = T(lambda() * (e[0] + e[1] + e[2]));
    return {T(pressure + 2 * mu() * e[0]), T(pressure + 2 * mu() * e[1]), T(pressure + 2 * mu() * e[2])};
  }
};

/// What all laws share that flow without limit and may part: they remember the plastic shear strain, and the gap in volume that has opened.
template <class Law>
struct PartingLaw : FlowLaw<Law> {
  static constexpr bool flows_freely = true;

  template <class T>
  struct Internal {
    T plastic_strain;
    T gap;
  };
  static constexpr std::array<InternalVariable, 2> internal_variables = {{{"plastic_strain", "1"}, {"gap", "1"}}};
};

}  // namespace matpoint
