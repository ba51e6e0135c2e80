// How much a particle counts at a distance, for contact by forces between pairs of particles.
#pragma once

#include <vector>

#include "core/types.hpp"

namespace matpoint {

/// R in spacings: wide enough that lattices are smooth, and 33 neighbours in 3D at a flat surface.
constexpr Real k_pair_range = 2.5;

/// How a body's points lie behind a flat surface of it: again and again.
struct SurfaceRows {
  struct Row {
    Real depth;  ///< Of the period, as the share [1].
    Real share;  ///< Of its volume.
  };
  Real period;  ///< [m]
  std::vector<Row> rows;
  static SurfaceRows of_particles(Real spacing) { return {spacing, {{0.5, 1}}}; }
  /// Three Gauss points a cell.
  static SurfaceRows of_elements(Real cell);
};

/// W(d) = alpha (1 - d^2 / R^2)^4.
template <int Dim>
class PairKernel {
 public:
  explicit PairKernel(Real range);
  Real range() const { return range_; }
  /// W [1/m^dim] where q = 1 - d^2 / R^2, in [0, 1].
  Real value(Real q) const { return alpha_ * q * q * q * q; }
  /// -W' / d [1/m^(dim+2)].
  Real slope(Real q) const { return 8 * alpha_ * q * q * q / (range_ * range_); }
  /// The change of W over that of d^2 from q0 to q1, of which one may be negative: W = 0 there [1/m^(dim+2)]; and its derivative with
  /// respect to the second d^2 [1/m^(dim+4)].
  struct Secant {
    Real value;
    Real slope;
  };
  Secant secant(Real q0, Real q1) const;
  /// The derivatives of W with respect to d^2.
  Secant tangent(Real q) const;
  /// The integral of W over a plane at the distance z [1/m].
  Real over_plane(Real z) const;
  /// The sum of W over rows of points beyond a surface at the distance z [1]. Of particles its integral would be 5 % more: flat bodies
  /// would come to rest 4 % of a spacing too near to each other.
  Real beyond_surface(Real z, const SurfaceRows& rows) const;

 private:
  Real range_;
  Real alpha_;
};

}  // namespace matpoint
