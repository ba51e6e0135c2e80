// What all laws share that flow: metals, soils, grains, yield-stress fluids. They keep the elastic left Cauchy-Green tensor b, as
// h = b - I, and some numbers of their own. A step takes it along, h* = f b f^T - I with the step's deformation f, and the law brings the
// three principal logarithmic strains e* back to where it allows them to be. That is exact for any elastic strain and any rotation, no
// spin has to be chosen, and no energy comes from closed paths.
// Sources: Weber & Anand (1990); Simo (1992); Cuitino & Ortiz (1992).
//
// Elasticity is Hencky's: tau_i = K theta + 2 G dev e_i, W = K theta^2/2 + G |dev e|^2, theta the sum of the e_i. A law that has another
// one gives, instead of K theta and its energy,
//
//   template <class T> T mean_stress(const T& theta) const;          template <class T> T volume_energy(const T& theta) const;
//
// or the whole of it, which may depend on what it remembers, with e a pointer to the three strains:
//
//   template <class T, class I> std::array<T, 3> principal_stress(const T* e, const I& now) const;
//   template <class T, class I> T principal_energy(const T* e, const I& now) const;
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
// then it is given a whole tensor where strains are small, and runs three times as fast in 3D. One that reads p.rate says
// `static constexpr bool needs_rate = true;`.
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
  T rate{0.0};            ///< In: sqrt(2/3 d':d') [1/s], d' the deviator of the rate of deformation of the step.

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

template <class Law, class Parameters = ElasticParameters>
struct FlowLaw : Parameters {
  static constexpr bool has_state = true;
  static constexpr bool remembers_strain = true;

  template <class T, bool is_plane>
  struct History {
    T h[is_plane ? 4 : 6];  ///< b - I: xx yy zz xy (yz xz).
    typename Law::template Internal<T> internal;
  };

  Real bulk_modulus() const { return this->lambda() + this->mu() * (2.0 / 3); }  ///< K [Pa]

  /// Kirchhoff stress after a step.
  template <class M, class H, class T = typename M::Scalar>
  M update(const Kinematics<M>& k, const H& old_history, H& updated, T& dissipated) const {
    // f b f^T - I with f = I + g.
    const M h = unpacked<M>(old_history.h);
    const M moved = k.g + k.g * h;
    const M trial = h + moved + transpose(moved) + moved * transpose(k.g);
    if constexpr (k_has_derivatives<T>) {
      using D = Dual<k_needs_rate ? 4 : 3>;
      using Inner = typename Law::template Internal<D>;
      constexpr int count = sizeof(typename Law::template Internal<Real>) / sizeof(Real);
      Inner before{}, after{};
      for (int i = 0; i < count; ++i) reinterpret_cast<D*>(&before)[i] = D(reinterpret_cast<const T*>(&old_history.internal)[i].value());
      const auto flowed = [&](const D* e, const D& rate) {
        Principal<D> p{{e[0], e[1], e[2]}, D(0.0), rate};
        law().flow(p, before, after, k.dt);
        return stress(p.e.data(), after);
      };
      if constexpr (k_needs_rate)
        return isotropic(trial, flowed, rate_of(k));
      else
        return isotropic(trial, [&](const D* e) { return flowed(e, D(0.0)); });
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
      M tau = update_by_series<M>(h_trial, k, old_history, updated, dissipated);
      if (any(is_large)) {
        H other = updated;
        T other_dissipated(0.0);
        const M other_tau = update_by_spectrum<M>(trial, k, old_history, other, other_dissipated);
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
      return update_by_spectrum<M>(trial, k, old_history, updated, dissipated);
    }
  }

  /// Kirchhoff stress of a state.
  template <class M, class H>
  M stress_of(const M& /*F*/, const H& history) const {
    return isotropic(unpacked<M>(history.h), [&](const auto* e) { return stress(e, history.internal); });
  }
  /// Stored energy of a state [J/m^3].
  template <class M, class H>
  typename M::Scalar energy_of(const M& /*F*/, const H& history) const {
    using T = typename M::Scalar;
    const Spectrum<T, M::k_size == 5> spectrum(unpacked<M>(history.h));
    if constexpr (requires { law().principal_energy(spectrum.half_log, history.internal); }) {
      return law().principal_energy(spectrum.half_log, history.internal);
    } else {
      const Principal<T> p{{spectrum.half_log[0], spectrum.half_log[1], spectrum.half_log[2]}};
      const T theta = p.theta();
      if constexpr (requires { law().volume_energy(theta); })
        return T(law().volume_energy(theta) + this->mu() * p.shear_squared());
      else
        return T(0.5 * bulk_modulus() * theta * theta + this->mu() * p.shear_squared());
    }
  }
  /// The elastic state of F, which a point that has not flowed is brought to.
  template <class M, class H>
  void deform(const M& F, H& history) const {
    pack(left_cauchy_green_minus_identity(F), history.h);
  }
  /// Elastic waves in a stretched material: exact along a uniaxial one, and never below those of what flows.
  Real wave_speed(Real J) const {
    return std::sqrt((this->lambda() + 2 * this->mu()) * (1 - std::min(std::log(J), Real{0})) / this->density);
  }

 private:
  static constexpr bool k_needs_rate = requires { requires Law::needs_rate; };

  /// sqrt(2/3 d':d') with the logarithm of the step's deformation, to second order, for d dt: a turn has none.
  template <class M, class T = typename M::Scalar>
  static T rate_of(const Kinematics<M>& k) {
    if constexpr (k_needs_rate) {
      const M d = deviator(k.g + transpose(k.g) + k.g * transpose(k.g));
      return T(sqrt(T(contract(d, d) + T(1e-30))) * (k.dt > 0 ? 0.5 * std::sqrt(2.0 / 3) / k.dt : 0));
    } else {
      return T(0.0);
    }
  }
  template <class M, class H, class T = typename M::Scalar>
  M update_by_spectrum(const M& trial, const Kinematics<M>& k, const H& old_history, H& updated, T& dissipated) const {
    const Spectrum<T, M::k_size == 5> spectrum(trial);
    Principal<T> p{{spectrum.half_log[0], spectrum.half_log[1], spectrum.half_log[2]}, T(0.0), rate_of(k)};
    law().flow(p, old_history.internal, updated.internal, k.dt);
    T values[3];
    for (int i = 0; i < 3; ++i) values[i] = expm1(T(2.0 * p.e[i]));
    pack(spectrum.compose(values), updated.h);
    dissipated = p.dissipated;
    return spectrum.compose(stress(p.e.data(), updated.internal).data());
  }
  template <class M, class H, class T, std::size_t size>
  M update_by_series(const std::array<T, size>& h_trial, const Kinematics<M>& k, const H& old_history, H& updated, T& dissipated) const {
    Strain<T, size> p{half_log1p_of_small(h_trial), T(0.0), rate_of(k)};
    law().flow(p, old_history.internal, updated.internal, k.dt);
    std::array<T, size> twice;
    for (std::size_t i = 0; i < size; ++i) twice[i] = T(2.0 * p.e[i]);
    const std::array<T, size> h = expm1_of_small(twice);
    for (std::size_t i = 0; i < size; ++i) updated.h[i] = h[i];
    dissipated = p.dissipated;
    const T pressure = shared_stress(p.theta());
    M tau;
    for (int d = 0; d < 3; ++d) tau(d, d) = T(pressure + this->mu() * twice[static_cast<std::size_t>(d)]);
    tau(0, 1) = tau(1, 0) = T(this->mu() * twice[3]);
    if constexpr (size == 6) {
      tau(1, 2) = tau(2, 1) = T(this->mu() * twice[4]);
      tau(0, 2) = tau(2, 0) = T(this->mu() * twice[5]);
    }
    return tau;
  }
  const Law& law() const { return static_cast<const Law&>(*this); }
  /// What is added to 2 G e_i for each principal stress.
  template <class T>
  T shared_stress(const T& theta) const {
    if constexpr (requires { law().mean_stress(theta); })
      return T(law().mean_stress(theta) - (2.0 / 3) * this->mu() * theta);
    else
      return T(this->lambda() * theta);
  }
  template <class T, class I>
  std::array<T, 3> stress(const T* e, const I& now) const {
    if constexpr (requires { law().principal_stress(e, now); }) {
      return law().principal_stress(e, now);
    } else {
      const Real twice_G = 2 * this->mu();
      const T pressure = shared_stress(T(e[0] + e[1] + e[2]));
      return {T(pressure + twice_G * e[0]), T(pressure + twice_G * e[1]), T(pressure + twice_G * e[2])};
    }
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
