#include "run/simulation.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "case/case_file.hpp"
#include "io/results_folder.hpp"
#include "run/make_solver.hpp"
#include "run/recovery.hpp"
#include "run/risks.hpp"

namespace matpoint {

class Simulation::Schedule {
 public:
  /// From now on.
  Schedule(Real every, std::vector<Real> at, const Simulation& now) : every_(every), at_(std::move(at)) {
    std::sort(at_.begin(), at_.end());
    while (next() <= now.time() || (now.step_count() > 0 && now.has_reached(next()))) advance();
  }
  /// The next time [s] that has not been written; infinite if there is none.
  Real next() const {
    const Real periodic = every_ > 0 ? static_cast<Real>(multiple_) * every_ : k_never;
    const Real single = at_next_ < at_.size() ? at_[at_next_] : k_never;
    return std::min(periodic, single);
  }
  void advance() {
    const Real written = next();
    if (every_ > 0 && static_cast<Real>(multiple_) * every_ <= written) ++multiple_;
    while (at_next_ < at_.size() && at_[at_next_] <= written) ++at_next_;
  }

 private:
  static constexpr Real k_never = std::numeric_limits<Real>::infinity();
  Real every_;
  std::vector<Real> at_;
  Index multiple_ = 1;
  std::size_t at_next_ = 0;
};

/// When checkpoints are due.
class Simulation::CheckpointSchedule {
 public:
  explicit CheckpointSchedule(const Simulation& now)
      : steps_(now.case_.output.checkpoint_steps.value_or(0)),
        wall_(now.case_.output.checkpoint_wall.value_or(0)),
        times_(now.case_.output.checkpoint_time.value_or(0), {}, now) {}

  bool is_due(const Simulation& now) {
    bool is_due = steps_ > 0 && now.step_count() % steps_ == 0;
    while (now.has_reached(times_.next())) {
      is_due = true;
      times_.advance();
    }
    const Clock::time_point clock = Clock::now();
    if (wall_ > 0 && seconds(clock - last_) >= wall_) is_due = true;
    if (is_due) last_ = clock;
    return is_due;
  }
  /// After the run went back in time.
  void look_again(const Simulation& now) { times_ = Schedule(now.case_.output.checkpoint_time.value_or(0), {}, now); }
  bool is_empty() const { return steps_ == 0 && wall_ == 0 && std::isinf(times_.next()); }
  double seconds_since_start() const { return seconds(Clock::now() - start_); }

 private:
  using Clock = std::chrono::steady_clock;
  static double seconds(Clock::duration time) { return std::chrono::duration<double>(time).count(); }

  Index steps_;
  Real wall_;
  Schedule times_;
  Clock::time_point start_ = Clock::now();
  Clock::time_point last_ = start_;
};

Simulation::Simulation(Case problem) : case_(std::move(problem)), solver_(make_solver(case_)) {
  // Also when nothing is to be written: `matpoint check` shall find what `matpoint run` would refuse.
  check_outputs(case_, *solver_);
  start_books();
}

void Simulation::start_books() {
  initial_energy_ = solver_->ledger().contact_energy;
  initial_momentum_ = {};
  for (std::size_t b = 0; b < solver_->body_count(); ++b) {
    const BodyTotals totals = solver_->totals(b);
    initial_energy_ += totals.kinetic_energy + totals.strain_energy + totals.gravitational_energy;
    for (std::size_t d = 0; d < 3; ++d) initial_momentum_[d] += totals.momentum[d];
  }
}

Simulation::~Simulation() = default;

Simulation::operator Snapshot() const {
  Snapshot now(case_, *solver_);
  now.time = time_;
  now.step = step_;
  now.dt = dt_;
  now.initial_energy = initial_energy_;
  now.failed_steps = cuts_.failures;
  now.redone_steps = cuts_.redone;
  now.health = &health_lines_;
  return now;
}

void Simulation::set_field(std::size_t body, const std::string& name, const std::vector<Real>& values) {
  check_usable();
  is_changed_by_hand_ = true;
  const auto energy = [](const BodyTotals& totals) { return totals.kinetic_energy + totals.strain_energy + totals.gravitational_energy; };
  const BodyTotals before = solver_->totals(body);
  initial_energy_ -= solver_->ledger().contact_energy;
  solver_->set_field(body, name, values);
  const BodyTotals after = solver_->totals(body);
  initial_energy_ += energy(after) - energy(before) + solver_->ledger().contact_energy;
  for (std::size_t d = 0; d < 3; ++d) initial_momentum_[d] += after.momentum[d] - before.momentum[d];
}

void Simulation::check_usable() const {
  if (!broken_.empty()) throw SolverError("the simulation broke off in {}; its state is of no use any more, build it again", broken_);
}

void Simulation::declare_state(State& state) {
  state.add("time", time_);
  state.add("dt", dt_);
  if (state.is_changed()) {
    // A run of its own, with its own steps and books.
    clock_start_ = time_;
    state.part("solver", *solver_);
    start_books();
    return;
  }
  state.add("clock_start", clock_start_);
  state.add("step", step_);
  state.part("step_cuts", cuts_);
  state.add("particle_left", particle_left_);
  state.add("initial_energy", initial_energy_);
  state.add("initial_momentum", initial_momentum_);
  bool has_health = health_.has_value();
  state.add("has_health", has_health);
  if (has_health && !health_) health_.emplace(*this);
  if (has_health) state.part("health", *health_);
  state.part("solver", *solver_);
}

StateTable Simulation::save_own_state(StateTable spare) {
  check_usable();
  StateTable table;
  State state = State::saving(table, &spare);
  state.in("simulation", [&] { declare_state(state); });
  return table;
}

StateTable Simulation::save_state(StateTable spare) {
  StateTable table = save_own_state(std::move(spare));
  State state = State::saving(table);
  std::string text = write_toml(case_.to_input());
  std::string functions = fmt::format("{}", fmt::join(case_.functions(), ", "));
  state.add("case_name", case_.name);
  state.add("case", text);
  state.add("case_functions", functions);
  return table;
}

void Simulation::load_state(const StateTable& table, bool is_changed) {
  check_usable();
  State state = State::loading(table, is_changed);
  broken_ = "the middle of loading a state";
  state.in("simulation", [&] { declare_state(state); });
  if (!is_changed) {
    const std::vector<std::string> left_over = state.left_over("simulation/");
    if (!left_over.empty()) state.fail(left_over.front(), "is nothing that this case has");
  }
  broken_.clear();
}

std::vector<std::string> Simulation::warnings() const {
  std::vector<std::string> all;
  const Real stable = solver_->stable_dt();
  if (case_.time.dt && *case_.time.dt > stable) {
    all.push_back(
        fmt::format("the fixed time step dt = {:.4g} s is above the stable limit of the start, {:.4g} s; the run will probably blow up",
                    *case_.time.dt, stable));
  }
  for (const std::string& text : risks_of(case_, *solver_)) all.push_back(text);
  constexpr Real k_short = 0.1;  // of the stable step
  if (!case_.is_implicit() && case_.solver.transfer != Transfer::flip && case_.time.dt && *case_.time.dt < k_short * stable) {
    all.push_back(fmt::format(
        "this transfer takes some of the motion in each step, and dt = {:.4g} s is only {:.2g} of the stable step; take a longer one, or "
        "transfer = \"flip\"",
        *case_.time.dt, *case_.time.dt / stable));
  }
  for (const std::string& text : solver_->warnings()) all.push_back(text);
  for (const BodySpec& body : case_.bodies) {
    if (!body.material->is_scalar_only()) continue;
    all.push_back(fmt::format("the law \"{}\" of body \"{}\" branches, so it has no SIMD kernel and runs point by point",
                              body.material->type(), body.name));
  }
  return all;
}

Real Simulation::next_dt() const {
  if (case_.time.dt) return *case_.time.dt;
  if (case_.time.rule) return rule_dt();
  // Computed afresh each step: the limit rises again when waves or particles slow down.
  Real dt = case_.time.cfl * solver_->stable_dt();
  if (case_.time.dt_max) dt = std::min(dt, *case_.time.dt_max);
  if (!(dt > 0) || dt < case_.time.dt_min) {
    throw SolverError("step {}, t = {:.8g} s: the stable time step {:.4g} s is below dt_min = {:.4g} s", step_ + 1, time_, dt,
                      case_.time.dt_min);
  }
  return cuts_.factor * dt;
}

Real Simulation::rule_dt() const {
  StepState state{time_, dt_, {}, {}, 0, 0};
  // The box around all bodies of particles, for it is they that meet things; their order in the file changes nothing.
  const bool has_particles =
      std::any_of(case_.bodies.begin(), case_.bodies.end(), [](const BodySpec& body) { return body.method == BodyMethod::particles; });
  bool is_first = true;
  for (std::size_t b = 0; b < solver_->body_count(); ++b) {
    if (has_particles && case_.bodies[b].method != BodyMethod::particles) continue;
    const BodyTotals totals = solver_->totals(b);
    if (totals.particle_count == 0) continue;
    for (std::size_t d = 0; d < 3; ++d) {
      state.lower[d] = is_first ? totals.lower[d] : std::min(state.lower[d], totals.lower[d]);
      state.upper[d] = is_first ? totals.upper[d] : std::max(state.upper[d], totals.upper[d]);
    }
    is_first = false;
  }
  for (const StepNumber& number : solver_->step_numbers()) {
    if (number.name == "newton_iterations") state.newton_iterations = static_cast<int>(number.value);
    if (number.name == "step_cuts") state.step_cuts = static_cast<int>(number.value);
  }
  return case_.time.rule->dt(state);
}

bool Simulation::has_reached(Real event) const {
  // A fixed step is never cut: an event falls on the nearest step.
  if (case_.time.dt) return step_ >= std::llround(std::min((event - clock_start_) / *case_.time.dt, 9e18));
  return time_ >= event;
}

void Simulation::step(Real latest) {
  check_usable();
  if (!health_) health_.emplace(*this);
  if (particle_left_)
    throw SolverError("t = {:.8g} s: a particle has left the grid, and particles_outside = \"stop\" ends the simulation there", time_);
  Real dt = next_dt();
  bool ends_at_latest = false;
  // A step may be longer by this share, so that none is left over that is next to nothing.
  constexpr Real k_stretch = 1e-6;
  if (!case_.time.dt && time_ + (1 + k_stretch) * dt >= latest) {
    dt = latest - time_;
    ends_at_latest = true;
  }
  try {
    solver_->step(time_, dt);
  } catch (const ParticleError& error) {
    broken_ = fmt::format("step {}", step_ + 1);
    throw ParticleError(fmt::format("step {}, {}", step_ + 1, error.what()), error.body, error.id);
  } catch (const SolverError& error) {
    broken_ = fmt::format("step {}", step_ + 1);
    throw SolverError(fmt::format("step {}, {}", step_ + 1, error.what()));
  } catch (...) {
    // From a function that a program gave: some stages of the step are done and others not.
    broken_ = fmt::format("the middle of step {}", step_ + 1);
    throw;
  }
  ++step_;
  dt_ = dt;
  ++cuts_.calm;
  if (cuts_.factor < 1 && cuts_.is_calm()) {
    cuts_.factor *= 2;
    cuts_.calm = 0;
  }
  // step * dt, not a sum: adding dt a million times ends visibly beside the end.
  time_ = case_.time.dt ? clock_start_ + static_cast<Real>(step_) * dt : ends_at_latest ? latest : time_ + dt;
  if (!solver_->escapes().empty()) handle_escapes();
}

void Simulation::handle_escapes() {
  switch (case_.grid.particles_outside) {
    case OutsidePolicy::remove: solver_->remove_escaped(); break;
    case OutsidePolicy::stop: particle_left_ = true; break;
    case OutsidePolicy::error: {
      broken_ = fmt::format("step {}", step_);
      const Escape& escape = solver_->escapes().front();
      const auto point = [&](const Vec3& x) { return fmt::format("({:.6g})", fmt::join(x.begin(), x.begin() + solver_->dim(), ", ")); };
      throw SolverError(
          "step {}, t = {:.8g} s: particle {} of body \"{}\" left the grid at {} with velocity {} ({} particle{} in this step); enlarge "
          "the grid, add a boundary, or set grid.particles_outside = \"remove\" or \"stop\"",
          step_, time_, escape.id, solver_->body_name(escape.body), point(escape.position), point(escape.velocity),
          solver_->escapes().size(), solver_->escapes().size() == 1 ? "" : "s");
    }
  }
}

HistoryRecord Simulation::record(const ResultsFolder* results) const {
  return results != nullptr ? results->record(*this) : HistoryRecord{step_, history_row(*this), {}};
}

void Simulation::write_history(ResultsFolder* results, const HistoryRecord& record) {
  health_->look(record.history);
  if (results != nullptr) results->write_history(record);
  for (const HistoryCallback& callback : history_callbacks_) callback(record.history);
}

RunEnd Simulation::run(ResultsFolder* results, std::optional<Real> until, const RunControl& control) {
  if (!health_) health_.emplace(*this);
  const Real end = until.value_or(case_.time.end);
  const auto history_from_now = [this] { return Schedule(case_.output.history_every.value_or(case_.time.end / 200), {}, *this); };
  const auto fields_from_now = [this] {
    return Schedule(case_.output.fields_every.value_or(case_.output.fields_at.empty() ? case_.time.end / 50 : 0), case_.output.fields_at,
                    *this);
  };
  Schedule history = history_from_now();
  Schedule fields = fields_from_now();
  CheckpointSchedule checkpoints(*this);
  Recovery recovery(*this, results);
  // Automatic steps are cut at the end only: how often a run is looked at must not change it. The rows of the history that fall into a step
  // are interpolated; fields, and everything with a rule or a fixed step, are of the first step at or after their time.
  const bool is_interpolating = !case_.time.dt && !case_.time.rule;
  std::optional<HistoryRecord> before;
  std::optional<HistoryRecord> after;
  const auto write = [&](bool is_last) {
    bool is_history_due = is_last;
    while (has_reached(history.next())) {
      if (before && history.next() < time_)
        write_history(results, interpolated(*before, *after, history.next(), *solver_));
      else
        is_history_due = true;
      history.advance();
    }
    const bool are_fields_due = is_last || has_reached(fields.next());
    while (has_reached(fields.next())) fields.advance();
    if (is_history_due) write_history(results, record(results));
    if (results != nullptr && are_fields_due) results->write_fields(*this);
  };
  const auto call_back = [&] {
    // By index: a callback may add another one.
    for (std::size_t i = 0; i < callbacks_.size(); ++i) {
      if (!callbacks_[i](*this)) return false;
    }
    return true;
  };
  if (step_ == 0) {
    write_history(results, record(results));
    if (results != nullptr) results->write_fields(*this);
  }
  if (particle_left_) return RunEnd::particle_left;
  RunEnd ending = step_ > 0 || call_back() ? RunEnd::finished : RunEnd::stopped_by_callback;
  while (ending == RunEnd::finished && !has_reached(end)) {
    before.reset();
    after.reset();
    recovery.keep_if_due();
    try {
      if (is_interpolating && std::min(time_ + next_dt(), end) > history.next()) before = record(results);
      step(end);
    } catch (const SolverError& error) {
      if (!recovery.go_back()) recovery.give_up(error, end);
      history = history_from_now();
      fields = fields_from_now();
      checkpoints.look_again(*this);
      continue;
    }
    if (before) after = record(results);
    if (!call_back()) ending = RunEnd::stopped_by_callback;
    if (particle_left_) ending = RunEnd::particle_left;
    const bool is_at_end = has_reached(end);
    if (control.time_limit && !is_at_end && checkpoints.seconds_since_start() >= *control.time_limit) ending = RunEnd::time_limit;
    if (control.interrupt != nullptr && *control.interrupt != 0) ending = RunEnd::interrupted;
    write(is_at_end);
    const bool is_cut_off = ending == RunEnd::interrupted || ending == RunEnd::time_limit;
    const bool is_asked_for = control.checkpoint != nullptr && control.checkpoint->exchange(0) != 0;
    const bool is_due = checkpoints.is_due(*this) || is_asked_for || is_cut_off || (is_at_end && !checkpoints.is_empty());
    if (results != nullptr && is_due) results->write_checkpoint(*this, save_state(results->spare_state()));
    // After the checkpoint: the run that goes on from there shall write what it would have written without a break.
    if (ending != RunEnd::finished && !is_at_end) write(true);
  }
  health_lines_ = health_->lines(*this);
  return ending;
}

}  // namespace matpoint
