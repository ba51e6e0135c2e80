// What a run says about itself at its end: whether its books of energy and momentum close, what left them, how far its bodies have been
// deformed, which particles were lost. Bounds and why they are what they are: docs/theory.md, "The health of a run".
#pragma once

#include <algorithm>
#include <limits>

#include "io/snapshot.hpp"

namespace matpoint {

/// Energy [J] of the motion of particles inside single cells that no velocity linear in place describes. The grid cannot resolve it, so
/// what is in it can be noise only. Positions and velocities one after the other, `dim` numbers each; cells as wide as given.
Real unresolved_energy(const std::vector<Real>& positions, const std::vector<Real>& velocities, const std::vector<Real>& masses, int dim,
                       const Vec3& cell_size);

class Health {
 public:
  /// Of a simulation before its first step.
  explicit Health(const Snapshot& start);
  /// Takes the extremes of a row of the history (history_row).
  void look(const std::vector<Real>& row);
  /// All lines, of the present state and what was seen on the way.
  std::vector<HealthLine> lines(const Snapshot& now) const;
  void declare_state(State& state);

 private:
  /// The extremes of one column.
  struct Range {
    std::size_t column = 0;
    Real lowest = std::numeric_limits<Real>::infinity();
    Real highest = -std::numeric_limits<Real>::infinity();
    void declare_state(State& state) {
      state.add("lowest", lowest);
      state.add("highest", highest);
    }
  };
  void add_energy(const Snapshot& now, std::vector<HealthLine>& lines) const;
  void add_noise(const Snapshot& now, std::vector<HealthLine>& lines) const;
  /// The greatest energy that was in motion, strain or height, of those that came and went [J].
  Real moved_energy() const { return std::max({kinetic_.highest, strain_.highest, gravitational_.highest - gravitational_.lowest}); }
  void add_momentum(const Snapshot& now, std::vector<HealthLine>& lines) const;
  void add_bodies(const Snapshot& now, std::vector<HealthLine>& lines) const;
  void add_steps(const Snapshot& now, std::vector<HealthLine>& lines) const;
  void add_particles(const Snapshot& now, std::vector<HealthLine>& lines) const;

  bool is_explicit_;
  Range kinetic_, strain_, gravitational_;
  /// What the scheme took: the transfers, and the correction of fluids, which takes again what these make of a splash.
  Range transfer_loss_, filter_dissipation_, scheme_loss_;
  std::vector<Range> J_min_;  ///< Per body.
  std::vector<Range> J_max_;
  std::vector<Real> volume_;  ///< Of each body at the start [m^dim].
  Index particles_ = 0;
  std::vector<Real> momentum_scale_;  ///< Sum of m |v| of the bodies at the start [N s].
};

}  // namespace matpoint
