// One scenario, timed with all programs in turn.
#pragma once

#include "machine.hpp"
#include "scene.hpp"

namespace matpoint::bench {

/// Linear shape functions: those of the plain loops, where a scenario names no others.
inline SolverSpec linear_scheme() {
  SolverSpec solver;
  solver.shape = ShapeKind::linear;
  return solver;
}

struct Scenario {
  std::string name;
  SceneSpec scene;
  SolverSpec solver = linear_scheme();  ///< Of the scene's case.
  std::string law;                      ///< TOML table of the material; empty: Neo-Hookean, for which there are plain loops, too.
  std::string case_text;                ///< A whole case instead of the scene, without a plain loop.
  double warm_up = 0;                   ///< Of such a case: simulated time before the measurement [s].
  int threads = 1;
  bool is_wall_time = false;  ///< Also with one thread, so that it can be compared with more.
  int repetitions = 5;
  bool has_plain = true;  ///< Whether the plain loops run beside.
};

struct StageTime {
  std::string label;
  double nanoseconds = 0;  ///< Per particle and step, all threads together.
};

/// Rates in particle-updates per second and core: by CPU time with one thread, by wall time with more
/// (and where the scenario says so). Medians over the repetitions.
struct Measurement {
  std::size_t particles = 0;
  double rate = 0;
  double spread = 0;         ///< (greatest - least rate) / median.
  double textbook_rate = 0;  ///< 0: did not run.
  double tuned_rate = 0;
  double bytes = 0;  ///< Per particle, the grid's share and all lists counted.
  double plain_bytes = 0;
  double lane_fill = 0;  ///< Particles over lanes worked.
  double moved = 0;      ///< Share of the particles that change their cell in a step.
  double roofline = 0;   ///< Share of the rate at which the memory could read and write the particles' state.
  std::vector<StageTime> stages;
  double energy_difference = 0;  ///< The larger one of kinetic and strain, relative, at the end of a run.
};

/// Throws std::runtime_error if the programs' energies differ by more than the rounding of their sums explains.
Measurement measure(const Scenario& scenario, const Machine& machine);

}  // namespace matpoint::bench
