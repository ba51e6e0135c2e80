// Accelerations from forces at nodes: M a = f with the mass matrix of the particles as quadrature points, nearly.
//
// What it is for: the trapezoidal rule takes the mean of the accelerations at the start and the end of a step. Those that particles carry
// balance the forces on the background of the step before, on which the particles lay elsewhere, and with the nodes that a side held then.
// In a bounce the difference works in one direction: a block of 1e7 Pa gained a seventh of its energy. So where sides let go, a step starts
// with accelerations that balance the forces on its own background.
#pragma once

#include "implicit/step_space.hpp"

namespace matpoint {

template <int Dim>
struct BalancedMotion {
  std::vector<std::vector<Vec<Dim>>> accelerations;  ///< By source and particle [m/s^2].
  std::vector<Real> force;                           ///< M a, by active node and component [N].
};

/// `force`: by active node and component [N]; prescribed components have no acceleration. a <- a + m^-1 (f - M a), ten times from 0, with m
/// the row sums of M: the sum of M a is that of f from the first time on. Not to the end: where cuts are thin M is nearly singular, and
/// M^-1 f is wild there.
template <int Dim>
BalancedMotion<Dim> balanced_motion(const StepSpace<Dim>& space, const std::vector<Real>& force);

}  // namespace matpoint
