// A body as the solver's step sees it: everything that carries mass and stress to the grid. One virtual call per body and stage.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "solver/solver.hpp"
#include "transfer/g2p.hpp"
#include "transfer/p2g.hpp"

namespace matpoint {

template <int Dim>
class Grid;

/// The first particle of a body whose state is no longer admissible.
struct BadPoint {
  Index id = -1;
  Vec3 position{};
  Real J = 0;
};

template <int Dim>
class Body {
 public:
  virtual ~Body() = default;

  virtual const std::string& name() const = 0;
  virtual Index particle_count() const = 0;

  /// Brings the body into a state from which p2g can run, and marks the bands of the grid that it touches.
  virtual void locate(const Grid<Dim>& grid, std::vector<char>& is_band_occupied) = 0;
  /// Adds mass and momentum, and the internal force if asked, to the grid.
  virtual void p2g(Grid<Dim>& grid, Map what) = 0;
  /// Takes velocity, gradient or position from the grid; a pass with the gradient also updates F and the stress.
  virtual void g2p(const Grid<Dim>& grid, Gather what, Real dt, Real flip) = 0;

  /// Viscous dissipation of the last stress update [J].
  virtual Real viscous_dissipation() const = 0;
  /// The first inverted or non-finite point of the last stress update; id -1 if there is none.
  virtual BadPoint bad_point() const = 0;
  /// Whether a particle left the grid in the last pass that moved them.
  virtual bool has_escapes() const = 0;
  virtual void append_escapes(const Grid<Dim>& grid, std::size_t body, std::vector<Escape>& escapes) const = 0;
  virtual void remove_escaped(const Grid<Dim>& grid, const Vec3& gravity, Ledger& ledger) = 0;

  virtual Real stable_dt(const Grid<Dim>& grid) const = 0;
  virtual Real mass() const = 0;
  virtual Real smallest_particle_mass() const = 0;
  virtual BodyTotals totals(const Vec3& gravity) const = 0;
  virtual std::vector<std::string> field_names() const = 0;
  virtual Field field(const std::string& name, std::size_t body) const = 0;
  virtual Index memory() const = 0;
};

}  // namespace matpoint
