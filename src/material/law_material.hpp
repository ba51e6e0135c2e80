// From a law to a Material: the loops over points, written once for all laws.
#pragma once

#include "core/multiversion.hpp"
#include "material/law.hpp"
#include "material/material.hpp"

namespace matpoint {

/// The law's history, or the empty one.
template <class Law, class T>
struct LawHistory {
  using Type = NoHistory<T>;
};
template <class Law, class T>
  requires requires { typename Law::template History<T>; }
struct LawHistory<Law, T> {
  using Type = typename Law::template History<T>;
};

/// Scalars per point in the law's history.
template <class Law>
constexpr int k_history_size = std::is_empty_v<typename LawHistory<Law, Real>::Type>
                                   ? 0
                                   : static_cast<int>(sizeof(typename LawHistory<Law, Real>::Type) / sizeof(Real));

/// The law's stress whichever of the two forms it is written in.
template <class Law, class M, class History>
inline M kirchhoff_stress_of(const Law& law, const Kinematics<M>& k, const History& old_history, History& new_history) {
  if constexpr (requires { law.kirchhoff_stress(k.F); }) {
    return law.kirchhoff_stress(k.F);
  } else {
    return law.kirchhoff_stress(k, old_history, new_history);
  }
}

template <class Law, int Dim>
struct PointUpdate {
  MPM_MULTIVERSION static void run(const Law& law, PointBlock& block);
};

template <class Law, int Dim>
MPM_MULTIVERSION void PointUpdate<Law, Dim>::run(const Law& law, PointBlock& block) {
  using M = Mat3<Real, Dim == 2>;
  using History = typename LawHistory<Law, Real>::Type;
  Real dissipated = 0;
  Index first_inverted = -1;
  for (Index n = 0; n < block.count; ++n) {
    Kinematics<M> k{M::identity(), M::zero(), block.dt};
    M F_old = M::identity();
    for (int r = 0; r < Dim; ++r) {
      for (int c = 0; c < Dim; ++c) {
        F_old(r, c) = block.F[r * Dim + c][n];
        k.L(r, c) = block.L[r * Dim + c][n];
      }
    }
    k.F = F_old + block.dt * (k.L * F_old);
    for (int r = 0; r < Dim; ++r) {
      for (int c = 0; c < Dim; ++c) block.F[r * Dim + c][n] = k.F(r, c);
    }
    const Real J = determinant(k.F);
    if (!(J > 0) || !std::isfinite(J)) [[unlikely]] {
      // The law may take the logarithm of J: its stress would be nonsense, and the run ends after this step anyway.
      if (first_inverted < 0) first_inverted = n;
      continue;
    }
    History old_history{};
    History new_history{};
    if constexpr (k_history_size<Law> > 0) {
      for (int h = 0; h < k_history_size<Law>; ++h) reinterpret_cast<Real*>(&old_history)[h] = block.history[h][n];
    }
    const M tau = kirchhoff_stress_of(law, k, old_history, new_history);
    if constexpr (k_history_size<Law> > 0) {
      for (int h = 0; h < k_history_size<Law>; ++h) block.history[h][n] = reinterpret_cast<Real*>(&new_history)[h];
    }
    for (int d = 0; d < 3; ++d) block.tau[d][n] = tau(d, d);
    block.tau[3][n] = tau(0, 1);
    if constexpr (Dim == 3) {
      block.tau[4][n] = tau(1, 2);
      block.tau[5][n] = tau(0, 2);
    }
    if constexpr (requires { law.dissipation_rate(k); }) dissipated += law.dissipation_rate(k) * block.volume0[n] * block.dt;
  }
  block.dissipated = dissipated;
  block.first_inverted = first_inverted;
}

template <class Law>
class LawMaterial final : public Material {
 public:
  static constexpr auto name = Law::name;
  static constexpr auto summary = Law::summary;

  Law law;

  std::string type() const override { return Law::name; }
  Real density() const override { return law.density; }
  Index history_size() const override { return k_history_size<Law>; }

  void update(PointBlock& block, int dim) const override {
    if (dim == 2) PointUpdate<Law, 2>::run(law, block);
    else PointUpdate<Law, 3>::run(law, block);
  }

  Real energy_density(const std::array<Real, 9>& F) const override {
    if constexpr (requires(Mat3<Real> m) { law.energy_density(m); }) {
      Mat3<Real> matrix;
      std::copy(F.begin(), F.end(), matrix.entries);
      return law.energy_density(matrix);
    } else {
      return 0;
    }
  }
  Real wave_speed(Real J) const override { return law.wave_speed(J); }
  Real kinematic_viscosity(Real J) const override {
    if constexpr (requires { law.kinematic_viscosity(J); }) return law.kinematic_viscosity(J);
    else return 0;
  }
  Input write(int dim) const override {
    return write_typed(law, dim);
  }
};

}  // namespace matpoint
