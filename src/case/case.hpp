// A case: the whole problem as plain, checked data. Case files, Python keywords and C++ all fill this structure, through the same
// reader, and it knows how to write itself back.
#pragma once

#include <functional>
#include <limits>
#include <map>

#include "body/seeding.hpp"
#include "case/implicit_spec.hpp"
#include "case/step_rule.hpp"
#include "core/parameters.hpp"
#include "kernel/kernel.hpp"
#include "material/material.hpp"

namespace matpoint {

enum class StressOrder { usl, usf, musl };
/// How velocities go from the grid to the particles and back.
enum class Transfer { flip, pic, apic, tpic, fmpm };
/// How bodies meet: in one velocity field, or each with its own, and impulses at the nodes or forces between pairs of particles.
enum class ContactMethod { single_field, multi_field, pairs };
/// Where shape functions are taken: at the particles' places now, or in the reference configuration.
enum class Formulation { updated, total };
enum class OutsidePolicy { error, remove, stop };
enum class BoundaryKind { fixed, slip, velocity, traction };

/// A velocity [m/s] as a function of time [s]; programs can give one, case files have tables instead.
struct VelocityHistory {
  std::function<Vec3(Real)> at;
};

/// A body force per mass [m/s^2] as a function of position and time, beside gravity; from programs only.
struct BodyForce {
  /// Fills `values` with dim numbers per point, for points at `positions` [m], dim numbers each, at time t [s]: the nodes of the grid in
  /// the order of their numbers (x fastest) in the explicit solver, the particles in the order of their ids in the implicit one.
  std::function<void(Real t, const std::vector<Real>& positions, std::vector<Real>& values)> at;
  bool is_constant = false;      ///< In time: evaluated once.
  bool is_of_particles = false;  ///< Explicit solver: at the particles, in the order of their ids, instead of the nodes.
};

/// The background grid: a box of equal cells.
struct GridSpec {
  Vec3 lower{};
  Vec3 upper{};
  std::vector<int> cells;       ///< Cells per direction; either this
  std::vector<Real> cell_size;  ///< or this, one number or one per direction, is given. Both are resolved after reading.
  std::vector<std::string> periodic;
  std::vector<Real> grading;               ///< Per direction: how many times as long each cell is as the one before it. Empty: equal cells.
  std::array<std::vector<Real>, 3> lines;  ///< Per direction, instead of equal or graded cells: their coordinates [m]; empty: none.
  int refinements = 0;                     ///< Cells of a mesh are halved so many times.
  std::vector<Vec3> corners;               ///< Quadrilateral into which the box is mapped, counter-clockwise from the lower left [m].
  OutsidePolicy particles_outside = OutsidePolicy::error;
  static void declare(ParameterTable<GridSpec>& table);
};

/// What a body consists of.
enum class BodyMethod { particles, elements };

struct BodySpec {
  std::string name;
  BodyMethod method = BodyMethod::particles;
  Formulation formulation = Formulation::updated;
  bool has_fbar = false;  ///< Of particles: the volume changes as the mean of a cell does.
  RegionPointer region;
  std::shared_ptr<Layout> layout;
  std::shared_ptr<VelocityField> velocity;  ///< Null: at rest.
  std::shared_ptr<Material> material;
  std::optional<Real> weight_density;  ///< Of a body of elements: what gravity acts on [kg/m^3]; without it the material's density.
  Real receding_correction = 0;        ///< Of a body of elements: C_c of its faces [1].
  std::string place;                   ///< Where the body stands in the case file, for messages.
  static void declare(ParameterTable<BodySpec>& table);
};

/// How a rigid face holds what touches it: for good; only as long as it presses; or as long as it presses, and along the face no harder
/// than Coulomb's law allows.
enum class FaceContact { stick, no_tension, friction };

/// A condition on the grid's nodes: on one side of the grid, or in a region.
struct BoundarySpec {
  std::string side;  ///< left right bottom top (front back in 3D); empty when a region is given.
  RegionPointer region;
  BoundaryKind kind = BoundaryKind::slip;
  std::vector<std::string> components;  ///< Fixed components of `fixed` and `velocity`; empty: all.
  std::vector<Real> velocity;           ///< [m/s], dim numbers, for kind = "velocity".
  std::vector<Real> traction;           ///< [Pa], dim numbers, for kind = "traction".
  std::vector<Real> times;              ///< [s], with velocities: a table in time, linear between, constant outside.
  std::vector<Vec3> velocities;         ///< [m/s], one per time.
  std::shared_ptr<VelocityHistory> velocity_history;
  bool is_attached = false;
  Real receding_correction = 0;  ///< C_c [1]
  FaceContact contact = FaceContact::stick;
  Real friction = 0;  ///< Coulomb's coefficient of contact = "friction" [1].
  std::string place;
  static void declare(ParameterTable<BoundarySpec>& table);
};

struct SolverSpec {
  std::string type = "explicit";
  StressOrder stress_order = StressOrder::musl;
  ShapeKind shape = ShapeKind::linear;
  Transfer transfer = Transfer::flip;
  ContactMethod contact = ContactMethod::single_field;
  Real friction = 0;           ///< Between bodies with velocity fields of their own [1].
  Real contact_stiffness = 1;  ///< Of contact = "pairs": over the modulus of the softer body [1].
  Real flip = 1;
  int fmpm_order = 2;  ///< Of transfer = "fmpm": terms of the series for the inverse of the mass matrix.
  Real damping = 0;
  Real mass_cutoff_relative = 1e-3;
  std::optional<Real> mass_cutoff;
  std::string mass_cutoff_place;  ///< Where either of the two stands in the case file, for messages.
  std::string precision = "double";
  static void declare(ParameterTable<SolverSpec>& table);
};

struct TimeSpec {
  Real end = 0;
  std::optional<Real> dt;
  Real cfl = 0.4;
  std::optional<Real> dt_max;
  Real dt_min = 0;
  std::shared_ptr<StepRule> rule;  ///< Of an implicit run without dt.
  static void declare(ParameterTable<TimeSpec>& table);
};

struct OutputSpec {
  std::optional<Real> history_every;
  std::optional<Real> fields_every;
  std::vector<Real> fields_at;
  std::vector<std::string> formats = {"vtkhdf"};
  std::vector<std::string> fields;  ///< Empty: all of the body's fields.
  bool grid = false;
  std::string precision = "single";
  int compression = 0;  ///< Of VTKHDF files: gzip level, 0 for none.
  static void declare(ParameterTable<OutputSpec>& table);
};

/// A particle whose motion and stress are written over time.
struct ProbeSpec {
  std::string name;
  std::string body;
  std::optional<Index> particle;  ///< Either the id
  std::optional<Vec3> nearest;    ///< or the particle that is nearest to this point at the start [m].
  std::string place;
  static void declare(ParameterTable<ProbeSpec>& table);
};

struct Case {
  std::string name;  ///< Not a key: the file's stem.
  std::string title;
  std::string source;
  int dim = 2;
  Vec3 gravity{};
  std::vector<Real> gravity_times;    ///< [s], with factors: a table in time, linear between, constant outside.
  std::vector<Real> gravity_factors;  ///< [1], one per time.
  std::shared_ptr<BodyForce> body_force;
  GridSpec grid;
  std::vector<BodySpec> bodies;
  std::vector<BoundarySpec> boundaries;
  SolverSpec solver;  ///< Its type decides which of the two counts.
  ImplicitSpec implicit;
  TimeSpec time;
  OutputSpec output;
  std::vector<ProbeSpec> probes;
  static void declare(ParameterTable<Case>& table);

  /// Reads and checks everything that can be checked without making particles. Throws InputError.
  static Case from_input(const Input& input, const std::string& name);
  bool is_implicit() const { return solver.type == "implicit"; }
  /// Factor of gravity and tractions at time t [1]: by the table of gravity, or growing with the load steps of a quasi-static run that has
  /// none.
  Real load_factor(Real t) const;
  /// Gravity at time t [m/s^2]: by the table, or growing with the load steps of a quasi-static run that has none.
  Vec3 gravity_at(Real t) const;

  /// All values with their defaults, as a case file would give them: from_input(to_input()) is the same case.
  Input to_input() const;
};

/// A section of a case file with its parameters, for `matpoint explain`.
struct CaseSection {
  std::string name;
  std::string summary;
  std::vector<ParameterDescription> parameters;
};
std::vector<CaseSection> case_sections();

}  // namespace matpoint
