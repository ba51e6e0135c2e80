// The loads of a case on particles, in the equations of an implicit step.
//
// A face of a particle adds to the residual r_I -= N_I f at its place at the start of the step, x_p + F_n X (body/particle_load.hpp); of a
// pressure f = cof(A) f_n, with the deformation A in the step at that place, whose derivative is not symmetric.
#pragma once

#include "body/particle_load.hpp"
#include "implicit/step_space.hpp"

namespace matpoint {

template <int Dim>
class PointLoads {
 public:
  /// Of bodies as they start. The space must outlive it.
  PointLoads(const Case& problem, const SeedingGrid& grid, const StepSpace<Dim>& space);

  bool is_empty() const { return loads_.empty(); }
  std::size_t count() const { return loads_.size(); }
  const std::string& name(std::size_t load) const { return loads_[load].name(); }
  /// Whether any is a pressure, which makes the matrix unsymmetric.
  bool follows() const;
  /// To be called when the space has been updated.
  void start();
  bool acts_in(std::size_t cell) const { return !loads_.empty() && first_[cell] < first_[cell + 1]; }
  /// Adds the loads, each with its factor, on the particles of a cell to its residual, by its functions and components, and to its matrix
  /// if there is one.
  void work(std::size_t cell, const std::vector<Real>& u, const std::vector<Real>& factors, Real* residual, Real* K) const;
  /// Of one load by active node and component [N].
  std::vector<Real> nodal_forces(std::size_t load, const std::vector<Real>& u, const std::vector<Real>& factors) const;
  /// Its sum over the particles as they are now, in the space or not [N].
  Vec3 resultant(std::size_t load, Real factor) const;

 private:
  struct Point {
    std::size_t load;
    std::size_t number;  ///< Of its face, among the load's.
    std::size_t row;     ///< Of its source.
  };
  void work(std::size_t cell, std::size_t point, const std::vector<Real>& u, Real factor, Real* residual, Real* K) const;

  const StepSpace<Dim>& space_;
  std::vector<ParticleLoad<Dim>> loads_;
  std::vector<std::vector<std::int32_t>> places_;  ///< By load and id of its body: among the ids of the load, or -1.
  std::vector<Point> points_;                      ///< Cell by cell.
  std::vector<std::size_t> first_;                 ///< Of each cell's points.
  std::vector<Real> N_, gradients_;                ///< The basis at the points.
};

}  // namespace matpoint
