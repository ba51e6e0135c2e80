#include "geometry/pair_kernel.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace matpoint {

constexpr Real k_exponent = 4;

SurfaceRows SurfaceRows::of_elements(Real cell) {
  const Real depth = 0.5 * (1 - std::sqrt(0.6));
  return {cell, {{depth, 5.0 / 18}, {0.5, 8.0 / 18}, {1 - depth, 5.0 / 18}}};
}

template <int Dim>
PairKernel<Dim>::PairKernel(Real range)
    : range_(range),
      alpha_(std::tgamma(k_exponent + 1 + 0.5 * Dim) /
             (std::pow(std::numbers::pi, 0.5 * Dim) * std::tgamma(k_exponent + 1) * std::pow(range, Dim))) {}

template <int Dim>
Real PairKernel<Dim>::over_plane(Real z) const {
  // Over a plane W integrates to a power of the same form, half a power higher per direction of the plane.
  const Real exponent = k_exponent + 0.5 * (Dim - 1);
  const Real q = 1 - z * z / (range_ * range_);
  if (q <= 0) return 0;
  return std::tgamma(exponent + 1.5) / (std::sqrt(std::numbers::pi) * std::tgamma(exponent + 1) * range_) * std::pow(q, exponent);
}

template <int Dim>
typename PairKernel<Dim>::Secant PairKernel<Dim>::secant(Real q0, Real q1) const {
  Real value = 0, slope = 0;  // of q^4 by q
  if (q0 > 0 && q1 > 0) {
    value = q1 * q1 * q1 + q1 * q1 * q0 + q1 * q0 * q0 + q0 * q0 * q0;
    slope = 3 * q1 * q1 + 2 * q1 * q0 + q0 * q0;
  } else if (q0 > 0 || q1 > 0) {
    const Real way = q1 - q0;
    const Real power = std::pow(std::max(q0, q1), 4);
    value = power / std::abs(way);
    slope = q1 > 0 ? (4 * q1 * q1 * q1 - value) / way : value / -way;
  }
  return {-alpha_ * value / (range_ * range_), alpha_ * slope / (range_ * range_ * range_ * range_)};
}

template <int Dim>
typename PairKernel<Dim>::Secant PairKernel<Dim>::tangent(Real q) const {
  if (q <= 0) return {0, 0};
  return {-4 * alpha_ * q * q * q / (range_ * range_), 12 * alpha_ * q * q / (range_ * range_ * range_ * range_)};
}

template <int Dim>
Real PairKernel<Dim>::beyond_surface(Real z, const SurfaceRows& rows) const {
  Real sum = 0;
  for (Real start = z; start < range_; start += rows.period) {
    for (const auto& [depth, share] : rows.rows) sum += share * rows.period * over_plane(start + depth * rows.period);
  }
  return sum;
}

template class PairKernel<2>;
template class PairKernel<3>;

}  // namespace matpoint
