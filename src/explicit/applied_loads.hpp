// The loads of a case on the bodies of the explicit solver, and their books.
#pragma once

#include <memory>

#include "body/body.hpp"
#include "case/case.hpp"

namespace matpoint {

template <int Dim>
class AppliedLoads {
 public:
  /// The bodies, in the order of the case and as they start, must outlive this.
  AppliedLoads(const Case& problem, const SeedingGrid& grid, std::vector<Body<Dim>*> bodies);

  /// Evaluates the loads where the particles are, at time t [s].
  void evaluate(Real t);
  /// Adds them to the nodes, after a sweep that maps forces.
  void add();
  /// Books the impulse of what the nodes have, which acts for dt [s].
  void book_impulse(Real dt, Ledger& ledger);
  /// What the work of a step begins with.
  void start_work() { before_ = now_; }
  /// Books the work from there to the last evaluation: the mean force in the way of each face.
  void book_work(Ledger& ledger);
  /// Particles have been moved or taken away other than by steps.
  void forget() { is_current_ = false; }
  bool is_current() const { return is_current_; }

  const std::vector<BoundaryTotals>& totals() const { return totals_; }
  void declare_state(State& state);

 private:
  /// Of one load: the states of its particles, and what it does to each.
  struct Carried {
    std::vector<LoadedPoint<Dim>> points;
    std::vector<PointForce<Dim>> forces;  ///< By face.
  };
  std::vector<ParticleLoad<Dim>> loads_;
  std::vector<std::function<Real(Real)>> factors_;
  std::vector<Body<Dim>*> bodies_;                 ///< By load.
  std::vector<std::vector<std::int32_t>> places_;  ///< By load and id of its body: among the ids of the load, or -1.
  std::vector<std::vector<std::size_t>> first_;    ///< By load and its ids: the first of its faces.
  std::vector<Carried> now_, before_;
  Vec3 period_{};  ///< Of periodic sides [m]; 0: none.
  bool is_current_ = false;
  std::vector<BoundaryTotals> totals_;
};

}  // namespace matpoint
