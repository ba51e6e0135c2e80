// A case: the whole problem as plain, checked data. Case files, Python keywords and C++ all fill this structure, through the same
// reader, and it knows how to write itself back.
#pragma once

#include <functional>
#include <memory>

#include "case/body_spec.hpp"
#include "case/boundary_spec.hpp"
#include "case/grid_spec.hpp"
#include "case/implicit_spec.hpp"
#include "case/load_spec.hpp"
#include "case/output_spec.hpp"
#include "case/solver_spec.hpp"
#include "case/time_spec.hpp"
#include "case/tool_spec.hpp"
#include "core/parameters.hpp"

namespace matpoint {

/// A body force per mass [m/s^2] as a function of position and time, beside gravity; from programs only.
struct BodyForce {
  /// Fills `values` with dim numbers per point, for points at `positions` [m], dim numbers each, at time t [s]: the nodes of the grid in
  /// the order of their numbers (x fastest) in the explicit solver, the particles in the order of their ids in the implicit one.
  std::function<void(Real t, const std::vector<Real>& positions, std::vector<Real>& values)> at;
  bool is_constant = false;      ///< In time: evaluated once.
  bool is_of_particles = false;  ///< Explicit solver: at the particles, in the order of their ids, instead of the nodes.
};

struct Case {
  std::string name;  ///< Not a key: the file's stem.
  std::string title;
  std::string source;
  int dim = 2;
  Vec3 gravity{};
  std::vector<Real> gravity_times;    ///< [s], with factors: a table in time, linear between, constant outside.
  std::vector<Real> gravity_factors;  ///< [1], one per time.
  /// Of the ground, whose frame the case is seen in: [m/s^2] at times [s], linear between, none outside; empty without.
  std::vector<Vec3> base_acceleration;
  std::vector<Real> base_acceleration_times;
  std::shared_ptr<BodyForce> body_force;
  GridSpec grid;
  std::vector<BodySpec> bodies;
  std::vector<BoundarySpec> boundaries;
  std::vector<LoadSpec> loads;
  std::vector<ToolSpec> tools;
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
  /// Factor of a load at time t [1]: by its table, or growing with the load steps of a quasi-static run where it has none.
  Real load_factor(const LoadSpec& load, Real t) const;
  /// Gravity at time t [m/s^2]: by the table, or growing with the load steps of a quasi-static run that has none; less the acceleration of
  /// the base.
  Vec3 gravity_at(Real t) const;

  /// What a program gave as functions, which no file can hold: "body_force", "boundary bottom: velocity", ...
  std::vector<std::string> functions() const;

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
