// A simulation: a solver with a clock, outputs and callbacks. It hides the dimension and owns everything that changes.
#pragma once

#include <atomic>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>

#include "case/case.hpp"
#include "io/history.hpp"
#include "io/snapshot.hpp"
#include "run/health.hpp"
#include "solver/solver.hpp"

namespace matpoint {

class ResultsFolder;

/// Why run() came back.
enum class RunEnd { finished, stopped_by_callback, particle_left, interrupted, time_limit };

/// What may be asked of a run from elsewhere, for example by a signal handler.
struct RunControl {
  const std::atomic<int>* interrupt = nullptr;  ///< Not 0: ends the run at a step boundary with everything written.
  std::atomic<int>* checkpoint = nullptr;       ///< Not 0: writes a checkpoint after the step, and sets it to 0.
  std::optional<double> time_limit;             ///< Of run(), on the clock on the wall [s]: ends it as an interrupt does.
};

class Simulation {
 public:
  /// Builds the solver: all input errors that remain appear here (InputError).
  explicit Simulation(Case problem);
  ~Simulation();

  /// What the outputs see of it now; implicit, so that `results.write_history(simulation)` reads as it should.
  operator Snapshot() const;

  const Case& problem() const { return case_; }
  const Solver& solver() const { return *solver_; }
  Solver& solver() { return *solver_; }

  Real time() const { return time_; }
  Index step_count() const { return step_; }
  Real last_dt() const { return dt_; }
  /// The next step [s]: the fixed one, or cfl times the stable limit of the present state. Throws SolverError below dt_min.
  Real next_dt() const;

  /// One step; an automatic one is cut to end at `latest` [s]. Throws SolverError; with particles_outside = "error" also when a
  /// particle leaves the grid.
  void step(Real latest = std::numeric_limits<Real>::infinity());

  /// Called after every step (and once at the start) by run(); returning false ends the run normally.
  using Callback = std::function<bool(const Simulation&)>;
  void add_callback(Callback callback) { callbacks_.push_back(std::move(callback)); }

  /// Called by run() whenever a row of the history is due, also without a results folder, with the row (history_row).
  using HistoryCallback = std::function<void(const std::vector<Real>&)>;
  void add_history_callback(HistoryCallback callback) { history_callbacks_.push_back(std::move(callback)); }

  /// Assigns a field of a body's particles (Solver::set_field); the energy and momentum that come with it count as the start's, so that
  /// the balances of the history stay closed.
  void set_field(std::size_t body, const std::string& name, const std::vector<Real>& values);

  /// All that decides how it goes on, after a step; with the case. `spare`: an earlier state, whose memory is used.
  StateTable save_state(StateTable spare = {});
  /// Goes on from the state of a simulation of the same case; or of one with other bodies' parameters, loads, sides, outputs where
  /// `is_changed`. Throws InputError where it does not fit, and then this one is of no use any more.
  void load_state(const StateTable& table, bool is_changed = false);

  /// Runs to `until` [s] (default: the case's end), writing into `results` when given; with a checkpoint at the end where it is
  /// interrupted.
  RunEnd run(ResultsFolder* results = nullptr, std::optional<Real> until = {}, const RunControl& control = {});

  /// Things that work as asked but probably not as meant, e.g. a fixed step above the stable limit; one sentence each.
  std::vector<std::string> warnings() const;

  /// What the last run() said about itself at its end; nothing before the first.
  const std::vector<HealthLine>& health() const { return health_lines_; }

  /// Energy of the start [J]: kinetic + strain + gravitational.
  Real initial_energy() const { return initial_energy_; }
  Vec3 initial_momentum() const { return initial_momentum_; }

 private:
  /// Times at which something is written: multiples of an interval and single times.
  class Schedule;
  class CheckpointSchedule;
  class Recovery;
  /// Automatic steps after one that failed.
  struct StepCuts {
    static constexpr Index k_calm_max = 1 << 20;
    static constexpr Index k_last_calm = 20;  // half steps cost little beside another failure
    bool is_calm() const { return calm >= (factor < 0.5 ? calm_needed : k_last_calm * calm_needed); }
    Real factor = 1;          ///< Of the step by cfl: halved where a step fails, doubled after a calm.
    Index calm = 0;           ///< Steps since the factor changed.
    Index calm_needed = 500;  ///< To double it: twice as long after each failure, and k_last_calm times that for the whole step.
    Index failures = 0;
    Index redone = 0;  ///< Steps that were thrown away.
    void declare_state(State& state) {
      state.add("factor", factor);
      state.add("calm", calm);
      state.add("calm_needed", calm_needed);
      state.add("failures", failures);
      state.add("redone", redone);
    }
  };
  /// The next step by the case's rule [s].
  Real rule_dt() const;
  /// Whether an event [s] falls on the present step.
  bool has_reached(Real event) const;
  void handle_escapes();
  HistoryRecord record(const ResultsFolder* results) const;
  void declare_state(State& state);
  /// The state without the case that it is of.
  StateTable save_own_state(StateTable spare);
  void check_usable() const;
  void start_books();
  void write_history(ResultsFolder* results, const HistoryRecord& record);

  Case case_;
  std::unique_ptr<Solver> solver_;
  std::deque<Callback> callbacks_;  // whose elements stay where they are when one is added
  std::vector<HistoryCallback> history_callbacks_;
  Real clock_start_ = 0;  ///< Of the first step [s].
  Real time_ = 0;
  Index step_ = 0;
  Real dt_ = 0;
  StepCuts cuts_;
  bool particle_left_ = false;
  bool is_changed_by_hand_ = false;  ///< Since a state was kept to go back to.
  std::string broken_;               ///< The step in which an error left the state half done; then nothing goes on.
  Real initial_energy_ = 0;
  Vec3 initial_momentum_{};
  std::optional<Health> health_;  ///< From the first step or run on.
  std::vector<HealthLine> health_lines_;
};

}  // namespace matpoint
