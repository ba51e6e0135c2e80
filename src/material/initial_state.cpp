#include "material/initial_state.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "material/tangent.hpp"

namespace matpoint {
namespace {

using Vector = Eigen::Vector3d;

/// Logarithms of the principal stretches under the principal stresses `wanted`, of which the first `count` are met: Newton's method with
/// differences, in steps that no law is lost in.
template <class Stress>
Vector solve_stretches(const Stress& stress, const Vector& wanted, int count, Real modulus) {
  constexpr Real k_step = 1e-6, k_longest = 0.02;
  constexpr int k_iterations = 1000;
  const Real tolerance = 1e-12 * (modulus + wanted.norm());
  Vector e = Vector::Zero();
  for (int n = 0; n < k_iterations; ++n) {
    Vector residual = stress(e) - wanted;
    Eigen::Matrix3d slope = Eigen::Matrix3d::Identity();
    for (int j = 0; j < 3; ++j) {
      if (j >= count) {
        residual[j] = 0;
        continue;
      }
      Vector ahead = e, behind = e;
      ahead[j] += k_step;
      behind[j] -= k_step;
      const Vector column = (stress(ahead) - stress(behind)) / (2 * k_step);
      for (int i = 0; i < count; ++i) slope(i, j) = column[i];
    }
    if (residual.cwiseAbs().maxCoeff() < tolerance) return e;
    Vector step = -slope.fullPivLu().solve(residual);
    if (!step.allFinite()) break;
    const Real longest = step.cwiseAbs().maxCoeff();
    if (longest < 1e-15) return e;
    if (longest > k_longest) step *= k_longest / longest;
    e += step;
  }
  throw SolverError("no elastic stretch carries the stress {:.6g}, {:.6g}, {:.6g} Pa", wanted[0], wanted[1], wanted[2]);
}

Material::Matrix to_matrix(const Eigen::Matrix3d& a) {
  Material::Matrix m;
  for (int k = 0; k < 9; ++k) m[static_cast<std::size_t>(k)] = a(k / 3, k % 3);
  return m;
}

}  // namespace

InitialState initial_state(const Material& material, int dim, const std::array<Real, 6>& sigma, std::optional<Real> overconsolidation) {
  Eigen::Matrix3d tensor;
  tensor << sigma[0], sigma[3], sigma[5], sigma[3], sigma[1], sigma[4], sigma[5], sigma[4], sigma[2];
  const Real modulus = material.density() * std::pow(material.wave_speed(1), 2);
  const bool is_remembered = material.remembers_strain();
  const auto stress = [&](const Vector& e) {
    const Material::Matrix tau = material.kirchhoff_stress(to_matrix(e.array().exp().matrix().asDiagonal()));
    // What a law remembers is a stress at J = 1, from where F counts.
    const Real J = is_remembered ? 1 : std::exp(e.sum());
    return Vector(tau[0] / J, tau[4] / J, tau[8] / J);
  };
  InitialState state;
  state.history.assign(static_cast<std::size_t>(material.history_size(dim)), 0);
  if (material.is_fluid()) {
    const Real mean = tensor.trace() / 3;
    if ((tensor - mean * Eigen::Matrix3d::Identity()).norm() > 1e-9 * (tensor.norm() + 1e-9 * modulus))
      throw SolverError("a fluid at rest carries the same pressure in all directions, and \"{}\" is one; take K0 = 1", material.type());
    const auto pressure = [&](const Vector& e) { return Vector(stress(Vector::Constant(e[0] / 3))[0], 0, 0); };
    const Real J = std::exp(solve_stretches(pressure, Vector(mean, 0, 0), 1, modulus)[0]);
    for (int d = 0; d < dim; ++d) state.F[static_cast<std::size_t>(4 * d)] = std::pow(J, Real{1} / dim);
    material.deform_history(state.F, state.history);
    return state;
  }
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(tensor);
  Vector values = principal.eigenvalues();
  Eigen::Matrix3d directions = principal.eigenvectors();
  int count = 3;
  if (dim == 2) {
    // The third direction is z, whatever its value.
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> in_plane(tensor.topLeftCorner<2, 2>());
    values << in_plane.eigenvalues(), tensor(2, 2);
    directions.setIdentity();
    directions.topLeftCorner<2, 2>() = in_plane.eigenvectors();
    if (!is_remembered) count = 2;
  }
  const Vector e = solve_stretches(stress, values, count, modulus);
  const Eigen::Matrix3d V = directions * e.array().exp().matrix().asDiagonal() * directions.transpose();
  material.deform_history(to_matrix(V), state.history);
  if (!is_remembered) state.F = to_matrix(V);
  if (overconsolidation) material.consolidate(state.history, *overconsolidation);
  return state;
}

template <int Dim>
static Real yields_by_in(const Material& material, const InitialState& state) {
  const TangentFunction<Dim> evaluate = tangent_function<Dim>(material);
  if (evaluate == nullptr || !material.has_state()) return 0;
  std::array<Real, Dim * Dim> A{}, F{}, S{};
  for (std::size_t r = 0; r < Dim; ++r) {
    A[r * Dim + r] = 1;
    for (std::size_t c = 0; c < Dim; ++c) F[r * Dim + c] = state.F[3 * r + c];
  }
  std::vector<Real> history = state.history;
  std::array<Real, 6> tau{};
  TangentPoints point;
  point.count = 1;
  point.dt = 0;
  point.A = A.data();
  point.F = F.data();
  point.history = state.history.data();
  point.S = S.data();
  point.new_history = history.data();
  point.tau = tau.data();
  evaluate(material.law_data(), point);
  const std::array<Real, 6> before = components_of(material.kirchhoff_stress(state.F, state.history));
  Real moved = 0, size = 0;
  for (std::size_t s = 0; s < 6; ++s) {
    moved = std::max(moved, std::abs(tau[s] - before[s]));
    size = std::max(size, std::abs(before[s]));
  }
  return size > 0 ? moved / size : 0;
}

Real yields_by(const Material& material, int dim, const InitialState& state) {
  return dim == 2 ? yields_by_in<2>(material, state) : yields_by_in<3>(material, state);
}

}  // namespace matpoint
