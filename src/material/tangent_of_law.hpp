// evaluate_tangent, written once for all laws.
#pragma once

#include <Eigen/Core>
#include <unsupported/Eigen/AutoDiff>

#include "material/law.hpp"
#include "material/tangent.hpp"

namespace matpoint {

/// A number with its derivatives with respect to the entries of A.
template <int Dim>
using TangentDual = Eigen::AutoDiffScalar<Eigen::Matrix<Real, Dim * Dim, 1>>;

template <class T>
inline const Real& value_of(const T& x) {
  if constexpr (std::is_same_v<T, Real>)
    return x;
  else
    return x.value();
}

/// What a law says for one point, in double or dual numbers.
template <class T, int Dim, class Law>
struct TangentPoint {
  using M = Mat3<T, Dim == 2>;
  using History = typename LawHistory<Law, T, Dim == 2>::Type;
  M tau;
  M S;
  History updated{};
  Kinematics<M> kinematics;
  T dissipated = T(0.0);

  TangentPoint(const Law& law, const M& A, const Real* F_start, const Real* history, Real dt) {
    kinematics.dt = dt;
    kinematics.F = M::identity();
    for (int r = 0; r < Dim; ++r) {
      for (int c = 0; c < Dim; ++c) {
        T sum = T(A(r, 0) * F_start[c]);
        for (int e = 1; e < Dim; ++e) sum = T(sum + A(r, e) * F_start[Dim * e + c]);
        kinematics.F(r, c) = sum;
      }
    }
    if constexpr (k_has_state<Law>) kinematics.g = A - M::identity();
    const T one_over_J = T(1.0 / determinant(A));
    const M cofactors = cofactor(A);
    if constexpr (k_is_rate_dependent<Law>) {
      // (A - I) A^-1 / dt = (I - A^-1) / dt
      const T factor = T(one_over_J * (dt > 0 ? 1 / dt : 0));
      kinematics.L = M::diagonal(T(dt > 0 ? 1 / dt : 0)) - scaled(factor, transpose(cofactors));
    } else {
      kinematics.L = M::zero();
    }
    History old{};
    constexpr int history_size = k_history_size<Law, Dim == 2>;
    for (int h = 0; h < history_size; ++h) reinterpret_cast<T*>(&old)[h] = T(history[h]);
    tau = kirchhoff_stress_of(law, kinematics, old, updated, dissipated);
    S = scaled(one_over_J, tau * cofactors);
  }
};

template <int Dim, class T>
Mat3<T, Dim == 2> step_deformation(const Real* A) {
  auto matrix = Mat3<T, Dim == 2>::identity();
  for (int r = 0; r < Dim; ++r) {
    for (int c = 0; c < Dim; ++c) {
      if constexpr (std::is_same_v<T, Real>)
        matrix(r, c) = A[Dim * r + c];
      else
        matrix(r, c) = T(A[Dim * r + c], Dim * Dim, Dim * r + c);
    }
  }
  return matrix;
}

template <int Dim, class Law>
void evaluate_tangent(const void* data, const TangentPoints& points) {
  constexpr int n = Dim * Dim;
  constexpr int history_size = k_history_size<Law, Dim == 2>;
  const Law& law = *static_cast<const Law*>(data);
  for (Index p = 0; p < points.count; ++p) {
    const Real* const F = points.F + p * n;
    const Real* const history = points.history + p * history_size;
    if (points.tangent != nullptr) {
      using T = TangentDual<Dim>;
      const TangentPoint<T, Dim, Law> point(law, step_deformation<Dim, T>(points.A + p * n), F, history, points.dt);
      for (int i = 0; i < n; ++i) {
        const T& S = point.S(i / Dim, i % Dim);
        points.S[p * n + i] = S.value();
        for (int k = 0; k < n; ++k) points.tangent[(p * n + i) * n + k] = S.derivatives()[k];
      }
      continue;
    }
    const TangentPoint<Real, Dim, Law> point(law, step_deformation<Dim, Real>(points.A + p * n), F, history, points.dt);
    for (int i = 0; i < n; ++i) points.S[p * n + i] = point.S(i / Dim, i % Dim);
    if constexpr (history_size > 0) {
      for (int h = 0; points.new_history != nullptr && h < history_size; ++h)
        points.new_history[p * history_size + h] = reinterpret_cast<const Real*>(&point.updated)[h];
    }
    if (points.tau != nullptr) {
      Real* const out = points.tau + 6 * p;
      for (int d = 0; d < 3; ++d) out[d] = point.tau(d, d);
      out[3] = point.tau(0, 1);
      out[4] = Dim == 3 ? point.tau(1, 2 % Dim) : 0;
      out[5] = Dim == 3 ? point.tau(0, 2 % Dim) : 0;
    }
    if (points.dissipated != nullptr) {
      if constexpr (k_has_dissipation<Law>)
        points.dissipated[p] = points.dt * law.dissipation_rate(point.kinematics);
      else
        points.dissipated[p] = point.dissipated;
    }
  }
}

}  // namespace matpoint
