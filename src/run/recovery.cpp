#include "run/recovery.hpp"

#include <algorithm>
#include <cmath>

namespace matpoint {
namespace {

/// Steps between states that are kept: a copy takes the time of two or three steps. An implicit step takes much longer than a copy.
constexpr Index k_keep_every = 100;
/// Where two smaller steps have moved a failure no further, the state this many steps before it is what is gone back to, so that the
/// smallest steps cost little.
constexpr Real k_near = 4;

}  // namespace

Simulation::Recovery::Recovery(Simulation& simulation, ResultsFolder* results)
    : simulation_(simulation),
      results_(results),
      is_implicit_(simulation.case_.is_implicit()),
      is_automatic_(!simulation.case_.time.dt && !simulation.case_.time.rule) {
  if (!is_implicit_ && !is_automatic_) start_limit_ = simulation.solver_->stable_dt();
}

void Simulation::Recovery::keep_if_due() {
  step_before_ = simulation_.step_;
  time_before_ = simulation_.time_;
  if (simulation_.case_.time.step_cuts_max == 0) return;
  const bool is_past = simulation_.time_ > trouble_;
  const bool is_due = !kept_ || is_implicit_ || (is_past && simulation_.step_ - kept_->step >= k_keep_every);
  if (!is_due && simulation_.time_ < keep_at_) return;
  keep_at_ = std::numeric_limits<Real>::infinity();
  keep();
}

void Simulation::Recovery::keep() {
  StateTable state = simulation_.save_own_state(kept_ ? std::move(kept_->state) : StateTable{});
  kept_ = {std::move(state), results_ != nullptr ? results_->mark() : ResultsFolder::Mark{}, simulation_.step_};
  start_cuts_ = simulation_.cuts_;
  simulation_.is_changed_by_hand_ = false;
}

void Simulation::Recovery::restore() {
  simulation_.broken_.clear();
  simulation_.load_state(kept_->state);
  simulation_.cuts_ = start_cuts_;
}

bool Simulation::Recovery::go_back() {
  if (!kept_ || is_implicit_ || !is_automatic_ || simulation_.is_changed_by_hand_) return false;
  const Real failed = time_before_;
  const Real dt = simulation_.dt_;
  repeats_ = failed <= trouble_ + 2 * dt ? repeats_ + 1 : 0;
  trouble_ = std::max(trouble_, failed);
  const Index done = step_before_ - kept_->step;
  StepCuts next = simulation_.cuts_;
  if (repeats_ == 2 && static_cast<Real>(done) > 2 * k_near) {
    // The same steps again.
    next = start_cuts_;
    keep_at_ = failed - k_near * dt;
  } else {
    if (next.factor <= std::ldexp(1.0, -simulation_.case_.time.step_cuts_max)) return false;
    next.factor /= 2;
    next.calm = 0;
    next.calm_needed = std::min(2 * next.calm_needed, StepCuts::k_calm_max);
    ++next.failures;
  }
  next.redone = simulation_.cuts_.redone + done + 1;
  start_cuts_ = next;
  restore();
  if (results_ != nullptr) results_->take_back(kept_->mark, simulation_, [this] { return simulation_.save_state(); });
  return true;
}

void Simulation::Recovery::give_up(const SolverError& error, Real end) {
  std::string text = error.what();
  if (!kept_ || simulation_.is_changed_by_hand_) throw SolverError(text);
  const std::string broken = simulation_.broken_;
  const auto* const of_particle = dynamic_cast<const ParticleError*>(&error);
  const Real failed = time_before_;
  const Real dt = simulation_.dt_;
  const Index failed_step = step_before_;
  try {
    restore();
    while (simulation_.step_ < failed_step) simulation_.step(end);
    if (of_particle != nullptr) text += neighbours(of_particle->body, of_particle->id);
    if (results_ != nullptr) {
      results_->write_fields(simulation_);
      results_->write_checkpoint(simulation_, simulation_.save_state());
    }
    if (!is_implicit_ && !is_automatic_) {
      const StateTable last = simulation_.save_own_state({});
      if (const std::optional<Real> works = find_fixed_step(failed + 2 * dt))
        text += fmt::format("; a fixed step of {:.2g} s gets past this time", *works);
      simulation_.broken_.clear();
      simulation_.load_state(last);
    }
  } catch (const std::exception& second) {
    text += fmt::format("; and then: {}", second.what());
  }
  simulation_.broken_ = broken;
  throw SolverError(text);
}

std::optional<Real> Simulation::Recovery::find_fixed_step(Real time) {
  // Two digits, rounded down: as it is printed.
  const auto rounded = [](Real x) {
    const Real digit = std::pow(10.0, std::floor(std::log10(x)) - 1);
    return std::floor(x / digit) * digit;
  };
  Real dt = *simulation_.case_.time.dt;
  for (int cut = 1; cut <= simulation_.case_.time.step_cuts_max; ++cut) {
    dt = rounded(std::min(dt / 2, simulation_.case_.time.cfl * start_limit_));
    try {
      restore();
      Real now = simulation_.time_;
      for (; now < time; now += dt) {
        simulation_.solver_->step(now, dt);
        if (!simulation_.solver_->escapes().empty() && simulation_.case_.grid.particles_outside == OutsidePolicy::error) break;
      }
      if (now >= time) return dt;
    } catch (const SolverError&) {
      // The next smaller one.
    }
  }
  return std::nullopt;
}

std::string Simulation::Recovery::neighbours(std::size_t body, Index id) const {
  struct Near {
    Real distance;
    std::size_t body;
    Index id;
    Real J;
    Vec3 position;
  };
  const Solver& solver = *simulation_.solver_;
  const auto dim = static_cast<std::size_t>(solver.dim());
  std::vector<Near> all;
  for (std::size_t b = 0; b < solver.body_count(); ++b) {
    const std::vector<Real> x = solver.field(b, "position").values;
    const std::vector<Real> J = solver.field(b, "J").values;
    const std::vector<Real> ids = solver.field(b, "id").values;
    for (std::size_t p = 0; p < ids.size(); ++p) {
      Vec3 place{};
      for (std::size_t d = 0; d < dim; ++d) place[d] = x[dim * p + d];
      all.push_back({0, b, static_cast<Index>(ids[p]), J[p], place});
    }
  }
  const auto failed = std::find_if(all.begin(), all.end(), [&](const Near& near) { return near.body == body && near.id == id; });
  if (failed == all.end()) return "";
  const Vec3 center = failed->position;
  for (Near& near : all)
    near.distance = std::hypot(near.position[0] - center[0], near.position[1] - center[1], near.position[2] - center[2]);
  // The particle itself is first.
  const std::size_t count = std::min<std::size_t>(4, all.size());
  std::swap(all.front(), *failed);
  std::partial_sort(all.begin() + 1, all.begin() + static_cast<std::ptrdiff_t>(count), all.end(),
                    [](const Near& a, const Near& b) { return std::tie(a.distance, a.body, a.id) < std::tie(b.distance, b.body, b.id); });
  std::string text = fmt::format("; in the step before it was at ({:.6g}) with J = {:.4g}",
                                 fmt::join(center.begin(), center.begin() + solver.dim(), ", "), all.front().J);
  for (std::size_t k = 1; k < count; ++k)
    text +=
        fmt::format("{} {} of \"{}\" (J = {:.4g})", k == 1 ? ", next to it were" : ",", all[k].id, solver.body_name(all[k].body), all[k].J);
  return text;
}

}  // namespace matpoint
