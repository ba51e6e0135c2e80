// A law that a program gives as a function at run time, e.g. one written in Python: no kernel of its own, and slow.
#pragma once

#include <functional>

#include "material/material.hpp"

namespace matpoint {

/// Material points that a FunctionMaterial works together: arrays with one row per point.
struct MaterialPoints {
  Index count = 0;
  const Real* F = nullptr;  ///< Deformation gradients at the end of the step [1], (count, 3, 3).
  const Real* L = nullptr;  ///< Velocity gradients [1/s], (count, 3, 3).
  Real dt = 0;              ///< [s]
  Real* history = nullptr;  ///< In and out: (count, history_size).
  Real* tau = nullptr;      ///< Out: Kirchhoff stress [Pa], (count, 3, 3).
};

class FunctionMaterial final : public Material {
 public:
  /// Called once in a step for all points of a body, in the order of their ids. What it throws ends the step.
  using Function = std::function<void(const MaterialPoints&)>;

  /// `wave_speed` [m/s] and `kinematic_viscosity` [m^2/s] are upper bounds for the stable step. `history_names`: of the last numbers of the
  /// history, as fields have them. Throws InputError.
  FunctionMaterial(std::string name, Function function, Real density, Real wave_speed, Real kinematic_viscosity, int history_size,
                   std::vector<std::string> history_names = {});

  std::string type() const override { return "function"; }
  Real density() const override { return density_; }
  int history_size(int /*dim*/) const override { return history_size_; }
  /// Its stress is stored, so that outputs need not call the function point by point.
  bool is_rate_dependent() const override { return true; }
  bool is_symmetric() const override { return false; }
  bool is_scalar_only() const override { return false; }
  bool is_fluid() const override { return false; }
  int law_index() const override { return -1; }
  const void* law_data() const override { return this; }
  Matrix kirchhoff_stress(const Matrix& F, std::span<const Real> history = {}) const override;
  /// Unknown: 0. The column transfer_loss of the history then holds the strain energy.
  Real energy_density(const Matrix&, std::span<const Real> /*history*/ = {}) const override { return 0; }
  Real wave_speed(Real) const override { return wave_speed_; }
  Real kinematic_viscosity(Real) const override { return kinematic_viscosity_; }
  Input write(int dim) const override;
  std::vector<InternalVariable> internal_variables() const override;

  /// Calls the function. Throws what it throws.
  void evaluate(const MaterialPoints& points) const { function_(points); }

 private:
  std::string name_;
  Function function_;
  Real density_;
  Real wave_speed_;
  Real kinematic_viscosity_;
  int history_size_;
  std::vector<std::string> history_names_;
};

}  // namespace matpoint
