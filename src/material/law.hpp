// What the author of a constitutive law writes: one struct with its parameters and pointwise functions, templated on the matrix type M,
// whose scalar is double in the solver and a dual number where the exact tangent is wanted. A law is pure: it stores nothing.
//
//   struct NeoHookean : ElasticParameters {
//     static constexpr auto name = "neo_hookean";                 // the word in case files
//     static constexpr auto summary = "...";                      // one line, with the source
//     static void declare(ParameterTable<NeoHookean>& table);     // parameters: unit, range, help
//     Real density;                                               // of every law: reference density [kg/m^3]
//     template <class M> M kirchhoff_stress(const M& F) const;                        // elastic laws: tau = J sigma [Pa]
//     template <class M> typename M::Scalar energy_density(const M& F) const;         // [J/m^3 of reference volume], if it has one
//     Real wave_speed(Real J) const;                                                  // [m/s], for the stable time step
//   };
//
// A law that needs more than F takes Kinematics and its history instead:
//
//   template <class T> struct History { T plastic_strain; };                          // only members of type T
//   template <class M> M kirchhoff_stress(const Kinematics<M>& k, const History<T>& old, History<T>& updated) const;
//   template <class M> T dissipation_rate(const Kinematics<M>& k) const;              // [W/m^3 of reference volume], optional
//   Real kinematic_viscosity(Real J) const;                                           // [m^2/s], optional
//
// A law whose stress and energy follow from F and its history, whatever the step was, says `static constexpr bool has_state = true;` and
// gives these instead, with h a History<T, is_plane>, which in plane strain may be shorter:
//
//   template <class M, class H> M update(const Kinematics<M>& k, const H& old, H& updated, T& dissipated) const;   // tau after a step
//   template <class M, class H> M stress_of(const M& F, const H& h) const;                                         // tau at rest
//   template <class M, class H> T energy_of(const M& F, const H& h) const;                                         // [J/m^3]
//   template <class M, class H> void deform(const M& F, H& h) const;                  // of a point at rest that is brought to F
//   elastically static constexpr std::array<InternalVariable, n> internal_variables;              // the last n numbers of the history, for
//   outputs
//
// One that flows (metals, soils, grains) derives from FlowLaw, which does that, and says how it flows (flow_law.hpp).
//
// A law whose waves become faster than `wave_speed(J)` tells, as it hardens, also gives their greatest modulus rho0 c^2:
//
//   template <class M, class H> T wave_modulus(const M& F, const H& h) const;         // [Pa]
//
// A law that is written with `select` instead of `if` runs on a whole SIMD pack of points at once. One that must branch says
// `static constexpr bool is_scalar_only = true;`, runs point by point, and a run mentions it.
//
// A fluid, whose stress knows of F only J, says `static constexpr bool is_fluid = true;`: then a body that is not total Lagrangian carries
// F = J^(1/dim) I (kernel/law_kernel.hpp says why).
//
// docs/add_a_material.md walks through one.
#pragma once

#include "core/parameters.hpp"
#include "core/scalar.hpp"
#include "core/tensor.hpp"

namespace matpoint {

/// How a material point moves in a step.
template <class M>
struct Kinematics {
  M F;      ///< Deformation gradient at the end of the step [1].
  M L;      ///< Velocity gradient [1/s].
  Real dt;  ///< [s]
  M g{};    ///< Displacement gradient of the step [1]: F = (I + g) F_n. Only laws with a state are given it.

  /// Rate of deformation sym(L) [1/s].
  M d() const { return symmetric_part(L); }
};

template <class T>
struct NoHistory {};

/// Whether the law's stress and energy follow from F and its history, and a step from the step's deformation.
template <class Law>
constexpr bool k_has_state = requires {
  requires Law::has_state;
};

/// The law's history, or the empty one; in plane strain it may be shorter.
template <class Law, class T, bool is_plane = false>
struct LawHistory {
  using Type = NoHistory<T>;
};
template <class Law, class T, bool is_plane>
requires requires { typename Law::template History<T>; }
struct LawHistory<Law, T, is_plane> {
  using Type = typename Law::template History<T>;
};
template <class Law, class T, bool is_plane>
requires k_has_state<Law>
struct LawHistory<Law, T, is_plane> {
  using Type = typename Law::template History<T, is_plane>;
};

/// Scalars per point in the law's history.
template <class Law, bool is_plane = false>
constexpr int k_history_size = std::is_empty_v<typename LawHistory<Law, Real, is_plane>::Type>
                                   ? 0
                                   : static_cast<int>(sizeof(typename LawHistory<Law, Real, is_plane>::Type) / sizeof(Real));

/// The law's stress after a step whichever of the forms it is written in. `dissipated`: out, of a law with a state [J/m^3].
template <class Law, class M, class History>
inline M kirchhoff_stress_of(const Law& law, const Kinematics<M>& k, const History& old_history, History& new_history,
                             typename M::Scalar& dissipated) {
  if constexpr (k_has_state<Law>) {
    return law.update(k, old_history, new_history, dissipated);
  } else if constexpr (requires { law.kirchhoff_stress(k.F); }) {
    return law.kirchhoff_stress(k.F);
  } else {
    return law.kirchhoff_stress(k, old_history, new_history);
  }
}

/// Whether the law remembers its elastic strain, `static constexpr bool remembers_strain = true;`, so that its stress does not follow from
/// F.
template <class Law>
constexpr bool k_remembers_strain = requires {
  requires Law::remembers_strain;
};

/// Whether the law says that its stress depends on the step, too, `static constexpr bool is_rate_dependent = true;`.
template <class Law>
constexpr bool k_says_rate_dependent = requires {
  requires Law::is_rate_dependent;
};
/// Whether the stress depends on more than the state, F and the history: then a body stores it.
template <class Law>
constexpr bool k_is_rate_dependent = k_says_rate_dependent<Law> ||
                                     (!k_has_state<Law> && !requires(const Law& law, const Mat3<Real>& F) { law.kirchhoff_stress(F); });

/// Whether what a law with a state dissipates is viscous, `static constexpr bool is_viscous = true;`, and not plastic.
template <class Law>
constexpr bool k_is_viscous = requires {
  requires Law::is_viscous;
};

/// Whether the law knows the greatest modulus of its waves.
template <class Law>
constexpr bool k_has_wave_modulus = requires(const Law& law, const Mat3<Real>& F, const typename LawHistory<Law, Real>::Type& history) {
  law.wave_modulus(F, history);
};

/// Whether the derivative of the step's stress is symmetric, as where an energy is minimised. A law with a state says so:
/// `static constexpr bool is_symmetric = true;`.
template <class Law>
constexpr bool k_is_symmetric = requires(const Law& law, const Mat3<Real>& F) {
  law.kirchhoff_stress(F);
}
|| requires { requires Law::is_symmetric; };

template <class Law>
constexpr bool k_has_dissipation = requires(const Law& law, const Kinematics<Mat3<Real>>& k) {
  law.dissipation_rate(k);
};

/// Whether the law says that it branches on its scalars, `static constexpr bool is_scalar_only = true;`: it then runs lane by lane.
template <class Law>
constexpr bool k_is_scalar_only = requires {
  requires Law::is_scalar_only;
};

/// Whether the law says that it is a fluid, `static constexpr bool is_fluid = true;`: it knows of F only J.
template <class Law>
constexpr bool k_is_fluid = requires {
  requires Law::is_fluid;
};

/// Parameters of isotropic elastic solids, and what follows from them.
struct ElasticParameters {
  Real density = 0;         ///< [kg/m^3]
  Real youngs_modulus = 0;  ///< [Pa]
  Real poissons_ratio = 0;  ///< [1]

  Real lambda() const { return youngs_modulus * poissons_ratio / ((1 + poissons_ratio) * (1 - 2 * poissons_ratio)); }  ///< [Pa]
  Real mu() const { return youngs_modulus / (2 * (1 + poissons_ratio)); }                                              ///< [Pa]

  template <class Law>
  static void declare_elastic(ParameterTable<Law>& table) {
    table.required("density", "kg/m^3", static_cast<Real Law::*>(&Law::density), positive(), "Mass per reference volume.");
    table.required("youngs_modulus", "Pa", static_cast<Real Law::*>(&Law::youngs_modulus), positive(), "Young's modulus E.");
    table.required("poissons_ratio", "1", static_cast<Real Law::*>(&Law::poissons_ratio), between(-1, 0.5),
                   "Poisson's ratio nu; an incompressible solid (0.5) has no finite wave speed.");
  }
};

/// Whether the law says that it flows without limit, `static constexpr bool flows_freely = true;`: the default scheme follows from that.
template <class Law>
constexpr bool k_flows_freely = requires {
  requires Law::flows_freely;
};

/// Reads a law's parameters, and checks what goes beyond single ones: its `check(input, context)`, which may be absent. Throws InputError.
template <class Law>
void read_law(const Input& input, const ReadContext& context, Law& law, const std::vector<std::string>& also_allowed = {}) {
  parameters_of<Law>().read(input, context, law, also_allowed);
  if constexpr (requires { law.check(input, context); }) law.check(input, context);
}

}  // namespace matpoint
