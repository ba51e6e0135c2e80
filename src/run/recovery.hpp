// What a run does where a step fails: it goes back to a state that it kept and takes smaller steps; and where nothing helps, it leaves the
// last good state behind and says what is around the particle that failed. docs/states.md says how often states are kept and what it costs.
#pragma once

#include "io/results_folder.hpp"
#include "run/simulation.hpp"

namespace matpoint {

class Simulation::Recovery {
 public:
  /// `results` may be null.
  Recovery(Simulation& simulation, ResultsFolder* results);

  /// Before each step: keeps the state where that is due.
  void keep_if_due();
  /// After a step has failed: the simulation is at the state that was kept and goes on with smaller steps, and what was written since is
  /// taken back. False where smaller steps are of no use, or not to be taken; then nothing has changed.
  bool go_back();
  /// Where that is false: leaves the state before the step in the results, and throws the error with what was found out.
  [[noreturn]] void give_up(const SolverError& error, Real end);

 private:
  struct Kept {
    StateTable state;
    ResultsFolder::Mark mark;
    Index step = 0;
  };
  void keep();
  void restore();
  /// The fixed step [s] that gets past the one that failed at `time`; nothing if none does.
  std::optional<Real> find_fixed_step(Real time);
  std::string neighbours(std::size_t body, Index id) const;

  Simulation& simulation_;
  ResultsFolder* results_;
  bool is_implicit_;
  bool is_automatic_;
  Real start_limit_ = 0;  ///< Of a fixed step: the stable one at the start of the run [s].
  std::optional<Kept> kept_;
  StepCuts start_cuts_;    ///< With which the run left the kept state.
  Index step_before_ = 0;  ///< Of the step that may fail.
  Real time_before_ = 0;
  Real trouble_ = -std::numeric_limits<Real>::infinity();  ///< The latest time at which a step failed [s].
  Real keep_at_ = std::numeric_limits<Real>::infinity();   ///< A state is kept at this time [s], too: shortly before such a failure.
  int repeats_ = 0;                                        ///< How often it has failed there again.
};

}  // namespace matpoint
