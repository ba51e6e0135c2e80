// Linear (tent) shape functions: the classical MPM. Source: Sulsky, Chen & Schreyer (1994).
//
// A shape is a type with k_support nodes per direction and weights() along one direction; transfer kernels take products over the
// directions and know nothing else.
#pragma once

#include "core/types.hpp"

namespace matpoint {

struct ShapeLinear {
  static constexpr int k_support = 2;  ///< Nodes per direction that a particle touches.

  /// Weights [1] and their derivatives [1/m] at the place xi in [0, 1] of a cell, for the nodes at its ends.
  static inline void weights(Real xi, Real inverse_cell_size, Real* w, Real* dw) {
    w[0] = 1 - xi;
    w[1] = xi;
    dw[0] = -inverse_cell_size;
    dw[1] = inverse_cell_size;
  }
};

}  // namespace matpoint
