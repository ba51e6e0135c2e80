#include "explicit/pair_kernel.hpp"

#include <cmath>
#include <numbers>

namespace matpoint {

constexpr Real k_exponent = 4;

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
Real PairKernel<Dim>::beyond_surface(Real z, Real spacing) const {
  Real sum = 0;
  for (Real row = z + 0.5 * spacing; row < range_; row += spacing) sum += spacing * over_plane(row);
  return sum;
}

template class PairKernel<2>;
template class PairKernel<3>;

}  // namespace matpoint
