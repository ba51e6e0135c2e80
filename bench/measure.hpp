// One scenario, timed with both programs in turn.
#pragma once

#include "scene.hpp"

namespace matpoint::bench {

struct Scenario {
  int dim = 2;
  Arrangement arrangement = Arrangement::lattice;
  std::size_t particles = 0;  ///< Wanted; a scene has the next number that its lattice gives.
  StressOrder order = StressOrder::usl;
  int repetitions = 5;
};

struct StageTime {
  std::string label;
  double nanoseconds = 0;  ///< Per particle and step.
};

/// Rates in particle-updates per CPU second of the one thread: medians over the repetitions.
struct Measurement {
  std::size_t particles = 0;
  double plain_rate = 0;
  double our_rate = 0;
  double our_spread = 0;   ///< (greatest - least rate) / median of ours.
  double plain_bytes = 0;  ///< Per particle, with the grid's share.
  double our_bytes = 0;
  std::vector<StageTime> stages;  ///< Of ours: wall time of the solver's own profile.
  double kinetic_difference = 0;  ///< |ours - plain| / plain at the end of a run.
  double strain_difference = 0;
};

/// Throws std::runtime_error if the two programs' energies differ by more than the rounding of their sums explains.
Measurement measure(const Scenario& scenario);

}  // namespace matpoint::bench
