// The stress of a law in an implicit step, with its exact derivative by automatic differentiation: the law's own text with dual numbers as
// scalars, so that nobody writes a tangent by hand.
#pragma once

#include "core/tensor.hpp"
#include "material/material.hpp"

namespace matpoint {

/// Material points of an implicit step that deforms them by A: F = A F_n, and L = (A - I) A^-1 / dt for laws that ask for a rate.
/// Matrices are dim x dim, row by row, one after the other; in plane strain A_zz = 1.
struct TangentPoints {
  Index count = 0;
  Real dt = 0;                    ///< [s]
  const Real* A = nullptr;        ///< Deformation in this step [1].
  const Real* F = nullptr;        ///< Deformation gradient at the start of the step [1].
  const Real* history = nullptr;  ///< At the start of the step, history_size numbers a point.
  Real* S = nullptr;              ///< Out: tau A^-T [Pa].
  Real* tangent = nullptr;        ///< Out, or null: dS_ij / dA_kl [Pa], dim^2 x dim^2 a point, row (i, j), column (k, l).
  Real* new_history = nullptr;    ///< Out, or null: at the end of the step.
  Real* tau = nullptr;            ///< Out, or null: Kirchhoff stress [Pa], 6 a point: xx yy zz xy yz xz.
  Real* dissipated = nullptr;     ///< Out, or null: in the step [J/m^3] of reference volume.
};

template <int Dim>
using TangentFunction = void (*)(const void* law, const TangentPoints& points);

/// The function of a material's law; null for a law that a program gave, which has no text to differentiate.
template <int Dim>
TangentFunction<Dim> tangent_function(const Material& material);

/// The same of a law by its type, for laws outside of the registry.
template <int Dim, class Law>
void evaluate_tangent(const void* law, const TangentPoints& points);  // tangent_of_law.hpp

}  // namespace matpoint
