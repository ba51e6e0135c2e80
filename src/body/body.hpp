// A body as the solver's step sees it: everything that carries mass and stress to the grid. One virtual call per body and sweep.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "body/particle_load.hpp"
#include "core/state.hpp"
#include "geometry/point_cells.hpp"
#include "grid/grid.hpp"
#include "kernel/kernel.hpp"
#include "solver/ledger.hpp"
#include "solver/report.hpp"

namespace matpoint {

/// The first particle of a body whose state is no longer admissible.
struct BadPoint {
  Index id = -1;
  Vec3 position{};
  Real J = 0;
};

/// Where a body ends, as a node sees it.
template <int Dim>
struct NodeSurface {
  Vec<Dim> outward{};   ///< Sum of J V0 grad N_i [m^(dim-1)].
  Vec<Dim> centroid{};  ///< Mean of x_p, weighted by N_i m_p [m].
};

/// Directions at a node, and how far a body's particles around it reach along each.
template <int Dim>
struct NodeReach {
  static constexpr std::size_t k_directions = 5;
  std::array<Vec<Dim>, k_directions> along{};
  std::array<Real, k_directions> farthest{};  ///< Greatest x_p . along [m].
};

/// Where a particle is and how it moves.
template <int Dim>
struct MovingPoint {
  Index id = 0;
  Vec<Dim> x{};  ///< [m]
  Vec<Dim> v{};  ///< [m/s]
};

/// Forces on some particles of a body.
template <int Dim>
struct ParticleForces {
  std::vector<Real> values;  ///< Dim numbers per id [N].
  std::vector<Index> ids;    ///< Those with a force, ascending.
  Extent<Dim> box;           ///< Has these in it [m].

  /// Of none, for so many ids.
  void clear(std::size_t count) {
    values.resize(count * Dim, 0);
    for (const Index id : ids) std::fill_n(values.begin() + static_cast<std::ptrdiff_t>(id * Dim), Dim, 0);
    ids.clear();
    box.lower.fill(std::numeric_limits<Real>::infinity());
    box.upper.fill(-std::numeric_limits<Real>::infinity());
  }
};

/// What a load wants to know of a particle.
template <int Dim>
struct LoadedPoint {
  bool is_there = false;  ///< Not removed, and in the grid.
  Vec<Dim> x{};           ///< [m]
  std::array<Real, Dim * Dim> F{};
  Real F33 = 1;
};

/// The passes of the correction of fluids over the particles (explicit/fluid_correction.cpp). Each reads what the one before has summed at
/// the nodes.
enum class CorrectionPass {
  spread,    ///< Volume into force[0]; of fluids, mass, momentum and, weighted by mass, J into force[1].
  residual,  ///< What a fluid's velocity has beyond `velocity`, into momentum.
  apply,     ///< Velocities lose a share of what is beyond `velocity` and `second`; positions move down the slope of moved_mass.
};
template <int Dim>
struct Correction {
  Real share = 0;       ///< Of the velocity that the grid does not see [1].
  Real relaxation = 0;  ///< Share of J that goes to the mean around it [1].
  Vec<Dim> shift{};     ///< Over the slope of the overfill [m^2].
  Vec3 gravity{};       ///< [m/s^2]
};

template <int Dim>
class Body {
 public:
  virtual ~Body() = default;

  virtual const std::string& name() const = 0;
  virtual Index particle_count() const = 0;

  /// One pass over the particles (kernel/kernel.hpp lists them); particles that leave their cell are in the new one when it returns,
  /// those that leave the grid are apart.
  virtual void sweep(Sweep what, Real dt, Real flip) = 0;

  /// The force per mass [m/s^2] that the next mapping of forces takes to the nodes, Dim numbers per particle in the order of ids.
  virtual void set_body_force(const std::vector<Real>& values) = 0;
  /// Sum of m b . v [W], and of m b [N].
  virtual Real body_force_power(const std::vector<Real>& values, Vec3& force) const = 0;

  /// Adds forces [N] on some particles, Dim numbers per id, to the nodes, after the sweep that has mapped them. `ids`: those with a force,
  /// each once; `box` has them in it.
  virtual void add_forces(const std::vector<Real>& values, const std::vector<Index>& ids, const Extent<Dim>& box) = 0;
  /// Those with a place among `points`, by id; -1: none.
  virtual void take_points(const std::vector<std::int32_t>& places, std::vector<LoadedPoint<Dim>>& points) const = 0;
  /// Adds forces beside such particles to the nodes, after the sweep that has mapped them and before the grid's pass ends. `first`: of
  /// each place, and one more.
  virtual void add_loads(const std::vector<std::int32_t>& places, const std::vector<std::size_t>& first,
                         const std::vector<PointForce<Dim>>& forces) = 0;
  /// A box with all particles in it; of updated bodies it may be wider by a cell.
  virtual Extent<Dim> extent() const = 0;
  /// Whether its velocities are mapped in the frame that turns with it where nothing holds it, and whether something does.
  virtual bool is_co_rotating() const = 0;
  virtual void set_held(bool is_held) = 0;
  /// Those in a box, in an order that is the same for any number of threads. `candidates`: the ids to look at,
  /// ascending; null: all.
  virtual std::vector<MovingPoint<Dim>> particles_in(const Extent<Dim>& box, const std::vector<Index>* candidates) const = 0;

  /// Viscous dissipation of the last sweep that updated the stress [J].
  virtual Real viscous_dissipation() const = 0;
  virtual Real plastic_dissipation() const = 0;
  /// The first inverted or non-finite point of the last sweep that updated the stress; id -1 if there is none.
  virtual BadPoint bad_point() const = 0;
  /// Particles that are outside of the grid.
  virtual void append_escapes(std::size_t body, std::vector<Escape>& escapes) const = 0;
  virtual void remove_escaped(const Vec3& gravity, Ledger& ledger) = 0;
  /// Puts those back that have left through closed sides only, just inside and without a velocity through the side, and books it.
  virtual void return_escaped(const std::vector<ClosedSide>& sides, const Vec3& gravity, Ledger& ledger) = 0;

  /// Whether it flows, and so may be corrected; and whether its particles are where its material is.
  virtual bool is_fluid() const = 0;
  virtual bool fills_space() const = 0;
  /// At rest [m^2/s].
  virtual Real kinematic_viscosity() const = 0;
  /// To be called when the nodes hold nothing that is still needed. Returns the work of moving particles against gravity [J].
  virtual Real correct(CorrectionPass pass, const Correction<Dim>& correction) = 0;
  /// Integral over the grid of the functions of the nodes along a direction [m].
  virtual std::vector<Real> node_lengths(int d) const = 0;

  /// Of the particles around each node: for contact.
  virtual std::vector<NodeSurface<Dim>> surfaces(const TileNodes<Dim>& nodes) const = 0;
  /// Of the particles around each node: takes into `farthest` those that reach farther.
  virtual void measure_reach(const TileNodes<Dim>& nodes, std::vector<NodeReach<Dim>>& reach) const = 0;
  /// For fluids: which particles are in obstacles from the start, and so may stay there.
  virtual void note_inside(const std::vector<Obstacle>& obstacles) = 0;
  /// For fluids: puts particles that have entered an obstacle back to the nearest place outside, without a velocity into it, and books it.
  /// Returns how many.
  virtual Index keep_out(const std::vector<Obstacle>& obstacles, const Vec3& gravity, Ledger& ledger) = 0;

  /// Of the particles around each node: takes the distance [m] of the nearest to a side of the grid into `gaps`, if it is less. A particle
  /// reaches as far as half of its size, by volume.
  virtual void measure_gaps(const TileNodes<Dim>& nodes, int axis, bool is_upper, std::vector<Real>& gaps) const = 0;

  /// Largest stable step [s] from the present state.
  virtual Real stable_dt() const = 0;
  /// Of all particles, an upper bound [m/s].
  virtual Real greatest_speed() const = 0;
  /// Mass of the particles in the grid [kg].
  virtual Real mass() const = 0;
  virtual Real smallest_particle_mass() const = 0;
  virtual BodyTotals totals(const Vec3& gravity) const = 0;
  /// Without particles, so that a state may be loaded.
  virtual void clear() = 0;
  virtual void declare_state(State& state) = 0;
  virtual std::vector<std::string> field_names() const = 0;
  /// As Solver::take_fields.
  virtual void take_fields(const std::vector<std::string>& names, std::size_t body, int vector_size, std::vector<Field>& fields) const = 0;
  Field field(const std::string& name, std::size_t body) const {
    std::vector<Field> one;
    take_fields({name}, body, Dim, one);
    return std::move(one.front());
  }
  virtual void set_field(const std::string& name, const std::vector<Real>& values) = 0;
  virtual Index memory() const = 0;
  virtual Occupancy occupancy() const = 0;
};

}  // namespace matpoint
