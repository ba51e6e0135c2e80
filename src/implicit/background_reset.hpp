// Where the background's nodes are at the start of a step when bodies of finite elements move in it (the paper's eq. 8): with the body on
// its nodes, and elsewhere as an elastic sheet that is held by it and by the sides, so that cells keep a good shape.
#pragma once

#include <Eigen/SparseCholesky>

#include "implicit/linear_solver.hpp"
#include "implicit/step_space.hpp"

namespace matpoint {

/// K_(Ii)(Kk) += factor int (delta_ik g_I . g_K + g_Ik g_Ki) over a cell: of (grad u + grad u^T) : grad N. `K`: (functions Dim)^2 numbers.
template <int Dim>
void add_symmetric_gradient_stiffness(const Basis<Dim>& basis, Index cell, Real factor, Real* K);

template <int Dim>
class BackgroundReset {
 public:
  /// For the background as it is now, undeformed.
  BackgroundReset(const Basis<Dim>& basis, const NodeConditions<Dim>& conditions, const StepSpace<Dim>& space);

  /// Positions of all nodes [m] for the bodies' displacements.
  std::vector<Vec<Dim>> positions(const std::vector<PointSource<Dim>>& sources) const;

 private:
  std::vector<Vec<Dim>> X_;
  std::vector<int> unknowns_;  ///< By node and component: number, or -1 where the displacement is given, or no cell asks for it.
  SparseMatrix coupling_;      ///< Unknowns by all components.
  Eigen::SimplicialLDLT<SparseMatrix> factorization_;
  int unknown_count_ = 0;
};

}  // namespace matpoint
