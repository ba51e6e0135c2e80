// A material on its own: one point on a path of strains, or under stresses that are held, as in a laboratory.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "material/material.hpp"

namespace matpoint {

/// One point with its history. Letters as in docs/notation.md; stresses are Cauchy's, tension positive.
class MaterialPoint {
 public:
  /// At rest and undeformed.
  explicit MaterialPoint(std::shared_ptr<const Material> material);

  /// To the deformation gradient F in dt [s] > 0. Throws SolverError for one that is turned inside out, and where the stress is not finite.
  void move_to(const Material::Matrix& F, Real dt);
  /// Under a pressure [Pa], at rest, and F counts from there; of laws that flow, which remember their elastic state.
  void press(Real pressure);
  /// The stress [Pa] that move_to would lead to.
  std::array<Real, 6> stress_at(const Material::Matrix& F, Real dt) const;

  const Material& material() const { return *material_; }
  const Material::Matrix& F() const { return F_; }
  std::array<Real, 6> stress() const { return stress_; }  ///< [Pa]: xx yy zz xy yz xz
  const std::vector<Real>& history() const { return history_; }
  Real dissipated() const { return dissipated_; }                          ///< Since the start [J/m^3] of reference volume.
  Real energy() const { return material_->energy_density(F_, history_); }  ///< Stored [J/m^3].

 private:
  struct Step {
    std::array<Real, 6> stress;
    std::vector<Real> history;
    Real dissipated = 0;
  };
  Step step_to(const Material::Matrix& F, Real dt) const;

  std::shared_ptr<const Material> material_;
  Material::Matrix F_{1, 0, 0, 0, 1, 0, 0, 0, 1};
  std::array<Real, 6> stress_{};
  std::vector<Real> history_;
  Real dissipated_ = 0;
};

/// A test, by name: what is driven, and what is held.
///
///   uniaxial_strain       ln F_xx driven, nothing else moves (an oedometer)
///   uniaxial_stress       ln F_xx driven, stresses across are held at -confining
///   triaxial              the same (drained)
///   triaxial_undrained    ln F_xx driven, the volume is kept
///   biaxial               ln F_xx driven, F_zz = 1, sigma_yy is held at -confining
///   isotropic             ln J driven
///   simple_shear          F_xy driven
///   cyclic_shear          F_xy driven to `strain` and to -strain, `cycles` times
///   deformation           F is `deformation` at `times`, linear between them
struct PointTestSpec {
  std::string path = "uniaxial_strain";
  Real strain = 0.1;   ///< Where it ends [1], tension positive.
  Real confining = 0;  ///< Pressure [Pa] that the point is brought to first; the strains of a law that flows count from there.
  Real rate = 1;       ///< Strain per time [1/s].
  int steps = 200;     ///< Of the path, or of each of its parts.
  int cycles = 3;
  std::vector<Real> times;        ///< [s]
  std::vector<Real> deformation;  ///< F at these times [1], 9 numbers each, row by row.
  static void declare(ParameterTable<PointTestSpec>& table);
};
const std::vector<std::string>& point_test_paths();

/// What a test measured: a row for each step.
struct PointTestResult {
  std::vector<std::string> names;
  std::vector<std::string> units;
  std::vector<std::vector<Real>> rows;
};
/// Throws InputError for an unknown path, and SolverError where no stretch holds the stress that is to be held.
PointTestResult run_point_test(std::shared_ptr<const Material> material, const PointTestSpec& spec);

}  // namespace matpoint
