// A body of particles in plain arrays, for the implicit solver: its cost is in the equations, so the storage stays as simple as it can be.
#pragma once

#include "body/particle_fields.hpp"
#include "case/body_spec.hpp"
#include "geometry/layout.hpp"
#include "material/initial_state.hpp"
#include "material/material.hpp"
#include "solver/ledger.hpp"
#include "solver/report.hpp"

namespace matpoint {

template <int Dim>
class PointBody {
 public:
  /// Fills the body's region. Throws InputError for an empty body and for particles outside the grid.
  PointBody(const BodySpec& spec, const SeedingGrid& grid);
  /// Without points.
  explicit PointBody(const BodySpec& spec);
  /// Another point, at rest and undeformed, at x [m] with the reference volume [m^3].
  void add_point(const Vec<Dim>& x, Real volume);
  /// With the initial stress of the body, if it has one.
  void start_with(const BodySpec& spec);

  const std::string& name() const { return name_; }
  const Material& material() const { return *material_; }
  Index count() const { return static_cast<Index>(mass.size()); }
  BodyTotals totals(const Vec3& gravity) const;
  /// As Solver::take_fields.
  void take_fields(const std::vector<std::string>& names, std::size_t body, int vector_size, std::vector<Field>& fields) const;
  Field field(const std::string& name, std::size_t body) const;
  std::vector<std::string> field_names() const;
  /// Throws InputError and changes nothing for what cannot be. Accelerations stay.
  void set_field(const std::string& name, const std::vector<Real>& values);
  /// Takes out the particles of the given rows, ascending, and books them.
  void remove(const std::vector<Index>& rows, const Vec3& gravity, Ledger& ledger);
  Index memory() const;
  void declare_state(State& state);

  // One row per particle, in the order of the ids.
  std::vector<Vec<Dim>> position;      ///< [m]
  std::vector<Vec<Dim>> velocity;      ///< [m/s]
  std::vector<Vec<Dim>> acceleration;  ///< [m/s^2]
  std::vector<Real> F;                 ///< Dim x Dim numbers each [1].
  std::vector<Real> volume0;           ///< [m^3]
  std::vector<Real> mass;              ///< [kg]
  std::vector<Real> history;           ///< history_size numbers each.
  std::vector<Real> tau;               ///< Kirchhoff stress [Pa], 6 each; empty where it follows from F.
  std::vector<Index> id;
  std::vector<Vec<Dim>> start;  ///< Position at the start [m]; empty where no displacement is asked for.

 private:
  // By row, for fields and totals.
  static Vec3 widened(const Vec<Dim>& a);
  Vec3 row_position(std::size_t p) const { return widened(position[p]); }
  Material::Matrix row_deformation_gradient(std::size_t p) const;
  std::array<Real, 6> row_cauchy_stress(std::size_t p) const;
  PointHistory row_history(std::size_t p) const;
  struct Rows;

  void reset_stress();
  void take_states(const std::vector<InitialState>& states);

  std::string name_;
  std::shared_ptr<Material> material_;
  Real total_mass_ = 0;
};

}  // namespace matpoint
