// What the simulation, the outputs, the checks and Python see of a solver: no dimension, no storage.
#pragma once

#include <functional>
#include <memory>

#include "case/case.hpp"
#include "core/error.hpp"
#include "core/profile.hpp"
#include "core/types.hpp"

namespace matpoint {

/// Sums and extremes over the particles of one body at one time. SI units, per metre of thickness in 2D.
struct BodyTotals {
  Index particle_count = 0;
  Real mass = 0;
  Vec3 momentum{};
  Vec3 center_of_mass{};
  Real kinetic_energy = 0;
  Real strain_energy = 0;         ///< Sum of W(F) V0: the stored energy, never 1/2 sigma : eps.
  Real gravitational_energy = 0;  ///< -m g . x
  Real von_mises_max = 0;
  Vec3 lower{};  ///< Extent of the particle positions [m].
  Vec3 upper{};
  Real J_min = 1;
  Real J_max = 1;
};

/// What crossed the system's border since the start: with it the energy and momentum balances close (docs/theory.md).
struct Ledger {
  Real damping_dissipation = 0;  ///< [J]
  Real viscous_dissipation = 0;  ///< [J]
  Real contact_dissipation = 0;  ///< Taken by the impulses of contact between bodies, and by friction [J].
  Real contact_energy = 0;       ///< Stored now in the forces between pairs of particles [J].
  Real boundary_work = 0;        ///< Work done by moving boundaries on the particles [J].
  Vec3 boundary_impulse{};       ///< [N s]
  Vec3 damping_impulse{};        ///< [N s]
  Vec3 gravity_impulse{};        ///< [N s]
  Real body_force_work = 0;      ///< Work done by a body force other than gravity [J].
  Vec3 body_force_impulse{};     ///< [N s]
  Vec3 cutoff_impulse{};         ///< What nodes under the mass cutoff did not pass on [N s].
  Index removed_count = 0;       ///< Particles removed because they left the grid.
  Real removed_mass = 0;         ///< [kg]
  Vec3 removed_momentum{};       ///< [N s]
  Real removed_energy = 0;       ///< Kinetic + strain + gravitational energy of the removed particles [J].
  Real soft_dissipation = 0;     ///< Taken by the implicit solver's soft stiffness [J].
  Real receding_work = 0;        ///< Brought in by its correction for receding particles [J].
  Real integrator_loss = 0;      ///< Taken from the kinetic energy by Newmark's formulas [J]; 0 for beta = 1/4, gamma = 1/2.
  Real reset_loss = 0;           ///< Taken by resets of the background: forces that balanced on the old one do not on the new one [J].

  /// What the bodies have lost of their energy by all of this, or keep between them [J].
  Real energy_spent() const {
    return damping_dissipation + viscous_dissipation + contact_dissipation + contact_energy - boundary_work - body_force_work +
           removed_energy + soft_dissipation - receding_work + integrator_loss + reset_loss;
  }
};

/// How the particles lie in memory: what the speed of a step depends on (docs/performance.md).
struct Occupancy {
  Index lanes = 0;        ///< Places for particles that a sweep works, empty ones too.
  Index moved = 0;        ///< Particles that changed their cell in the last step.
  Index state_bytes = 0;  ///< What all particles keep from one step to the next.
};

/// A particle that left the grid in the last step.
struct Escape {
  std::size_t body = 0;
  Index id = 0;
  Vec3 position{};
  Vec3 velocity{};
};

/// A number that a solver tells about its last step, for the history.
struct StepNumber {
  std::string name;
  std::string unit;
  Real value = 0;
};

/// The cells of a body of finite elements, for output.
struct BodyCells {
  int vtk_type = 1;  ///< VTK's number of their shape; 1 is a vertex.
  Index nodes_per_cell = 1;
  std::vector<Index> nodes;  ///< Of each cell, in VTK's order: rows of the body's nodal fields.
};

/// The grid's nodes as a whole, for output.
struct GridGeometry {
  Vec3 lower{};
  Vec3 cell_size{};
  std::array<int, 3> nodes{1, 1, 1};
};

class Solver {
 public:
  virtual ~Solver() = default;

  virtual int dim() const = 0;
  virtual const GridGeometry& grid() const = 0;

  /// Advances all bodies by dt [s] from time t [s]. Throws SolverError when the state stops being finite.
  virtual void step(Real t, Real dt) = 0;
  /// Largest stable step [s] for CFL number 1, from the present state.
  virtual Real stable_dt() const = 0;
  /// Particles that left the grid in the last step; the policy is the simulation's.
  virtual const std::vector<Escape>& escapes() const = 0;
  /// Takes the escaped particles out and books them in the ledger.
  virtual void remove_escaped() = 0;

  virtual std::size_t body_count() const = 0;
  virtual const std::string& body_name(std::size_t body) const = 0;
  virtual Index particle_count(std::size_t body) const = 0;
  /// Names of the fields that field() knows: position velocity stress von_mises pressure deformation_gradient J id mass volume ...
  virtual std::vector<std::string> field_names(std::size_t body) const = 0;
  /// A field of a body, in the order of particle ids.
  Field field(std::size_t body, const std::string& name) const {
    std::vector<Field> one;
    take_fields(body, {name}, dim(), one);
    return std::move(one.front());
  }
  /// Several fields of a body, which cost little more than one; vectors have `vector_size` components, dim() or 3. What `fields` holds from
  /// an earlier call lends its memory.
  virtual void take_fields(std::size_t body, const std::vector<std::string>& names, int vector_size, std::vector<Field>& fields) const = 0;
  /// Assigns a field of all particles, shaped as field() gives it: position, velocity or deformation_gradient. Throws InputError for other
  /// fields, with the reason, and for values that no particle can have; then nothing has changed.
  virtual void set_field(std::size_t body, const std::string& name, const std::vector<Real>& values) = 0;
  /// The cells of a body of finite elements; null for a body of particles.
  virtual const BodyCells* cells(std::size_t) const { return nullptr; }
  /// Names of the fields that such a body has at its nodes: position displacement velocity stress ...
  virtual std::vector<std::string> node_field_names(std::size_t) const { return {}; }
  /// A field at the nodes of a body of finite elements. Throws InputError for another name or body.
  virtual Field node_field(std::size_t body, const std::string&) const {
    throw InputError("body \"{}\" consists of particles and has no nodes of its own", body_name(body));
  }
  /// Nodal mass and velocity of the last step, x fastest.
  virtual std::vector<Field> grid_fields() const = 0;

  virtual BodyTotals totals(std::size_t body) const = 0;
  virtual const Ledger& ledger() const = 0;
  virtual const Profile& profile() const = 0;
  virtual Index node_count() const = 0;
  /// Bytes of the particle and grid storage.
  virtual Index memory() const = 0;
  virtual Occupancy occupancy() const = 0;
  /// Further columns of the history; the same names all through a run.
  virtual std::vector<StepNumber> step_numbers() const { return {}; }
  /// Things that work as asked but probably not as meant; one sentence each.
  virtual std::vector<std::string> warnings() const { return {}; }
};

/// Makes the bodies' particles, checks that they fit the grid, and returns a solver ready for its first step. Throws InputError.
std::unique_ptr<Solver> make_solver(const Case& problem);

}  // namespace matpoint
