// What the examples of the paper on implicit MPM measure: averaged errors, and differences to the series of a reference computation.
#pragma once

#include <cmath>

#include "verify/analytic.hpp"

namespace matpoint {

/// The paper's averaged relative error (eq. 52): of the way s against g sin(45 deg) t^2/3, over all steps.
class AveragedError {
 public:
  void include(Real t, Real s) {
    const Real exact = 9.81 * std::sqrt(0.5) * t * t / 3;
    sum_ += std::abs(s - exact) / exact;
    ++count_;
  }
  Real mean() const { return sum_ / count_; }

 private:
  Real sum_ = 0;
  int count_ = 0;
};

/// The disk of the paper's row E2 on n x n/5 B-spline cells, with `contact` at the bottom instead of C_c; particles by the paper's own
/// rule, which stay within the radius, so that they may touch at the start.
Case disk_on_splines(int cells, Real gap, const std::string& contact);

/// The greatest difference in times and positions to a series (verification/<name>.csv), each in units of what it may be: 1e-6 of the way
/// or 1e-9 m, and the rounding of the printed numbers, of so many digits. Runs to the end of the series.
Real series_difference(Simulation& sim, const std::string& name, std::size_t particle, int digits = 7);
VerifyRow series_row(const std::string& quantity);

}  // namespace matpoint
