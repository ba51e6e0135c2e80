// How far a run is: one line that updates itself on a terminal, a line every 10 % elsewhere.
#pragma once

#include <chrono>
#include <string>

#include "run/simulation.hpp"

namespace matpoint {

class Progress {
 public:
  explicit Progress(const Case& problem);

  /// To be called after every step; prints now and then.
  void update(const Simulation& simulation);
  /// Removes the line that updates itself, so that other text can follow.
  void clear();

  double seconds() const;                               ///< Wall time since construction [s].
  double particle_updates() const { return updates_; }  ///< Sum over the steps of the number of particles.

 private:
  using Clock = std::chrono::steady_clock;

  std::string status(const Simulation& simulation, double fraction) const;
  void print_bar(const Simulation& simulation, double fraction);

  double end_ = 0;
  bool is_terminal_ = false;
  Clock::time_point start_;
  Clock::time_point last_print_;
  bool has_line_ = false;
  int tenths_ = 0;
  Index step_ = 0;
  double updates_ = 0;
};

}  // namespace matpoint
