// What the simulation, the outputs, the checks and Python see of a solver: no dimension, no storage.
#pragma once

#include <memory>

#include "core/error.hpp"
#include "core/profile.hpp"
#include "core/types.hpp"
#include "solver/ledger.hpp"
#include "solver/report.hpp"

namespace matpoint {

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

  /// Everything that decides the next step. Loading is into a solver of the same case; throws InputError where the state does not fit, and
  /// then this solver is of no use any more.
  virtual void declare_state(State& state) = 0;

  virtual BodyTotals totals(std::size_t body) const = 0;
  /// What each boundary that holds something does, in the order of the case, then pairs of bodies, tools and loads; empty where the solver
  /// does not tell them apart.
  virtual std::vector<BoundaryTotals> boundaries() const { return {}; }
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

}  // namespace matpoint
