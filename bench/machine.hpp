// What one core of this machine can do at best: the roofline that rates are compared with. Measured, not looked up, for machines are
// shared and clocks vary.
#pragma once

namespace matpoint::bench {

struct Machine {
  double update_bandwidth = 0;  ///< Bytes read and written per second when an array larger than the caches is updated in place.
  double double_flops = 0;      ///< Operations per second of independent fused multiply-adds (two each).
  double single_flops = 0;
};

/// Takes about a second; the best of several repetitions each, because everything that disturbs makes it slower.
Machine measure_machine();

}  // namespace matpoint::bench
