#pragma once

#include "case/case.hpp"
#include "solver/solver.hpp"

namespace matpoint {

/// What the outputs see of a run at one time. A view: valid while the case and the solver live, and until the next step.
struct Snapshot {
  Snapshot(const Case& case_, const Solver& solver_) : problem(case_), solver(solver_) {}

  const Case& problem;
  const Solver& solver;
  Real time = 0;                                    ///< [s]
  Index step = 0;                                   ///< Steps done.
  Real dt = 0;                                      ///< The last step [s]; 0 before the first.
  Real initial_energy = 0;                          ///< Kinetic + strain + gravitational energy of the start [J].
  Index failed_steps = 0;                           ///< That were taken again, smaller.
  Index redone_steps = 0;                           ///< That were thrown away for it.
  const std::vector<HealthLine>* health = nullptr;  ///< Of a run that has ended; null: of none.
};

}  // namespace matpoint
