// Rigid faces that let go: an active set on the nodes of sides of the grid, for functions that are nowhere negative (B-splines), so that
// the sign of a reaction at a node means something.
//
// After Newton's method has converged with a set of held nodes, a node whose reaction pulls is let go, and a free node that has moved into
// the face is held again; then Newton again, until the set stays.
#pragma once

#include "solver/step_space.hpp"

namespace matpoint {

template <int Dim>
class FaceContacts {
 public:
  /// `conditions` must outlive it: a node is let go in the components that its face holds, and not in those of another side in a corner.
  FaceContacts(const std::vector<BoundarySpec>& specs, const Basis<Dim>& basis, const NodeConditions<Dim>& conditions);

  bool is_empty() const { return nodes_.empty(); }
  /// Before the first solve of a step: nodes that no particle is near are held, the others are as the last step left them.
  void start(const StepSpace<Dim>& space);
  /// Components that are let go now, by node and component, for StepSpace::release.
  const std::vector<bool>& released() const { return released_; }
  /// With the displacements [m] and the residual [N] of a converged solve, by active node and component, and the faces' displacements by
  /// condition [m]: the next set. Whether it is another one, so that Newton's method must go on; not for ever.
  bool update(const StepSpace<Dim>& space, const std::vector<Real>& u, const std::vector<Real>& residual,
              const std::vector<Vec<Dim>>& displacements);
  /// Solves of the last step, and the nodes with particles near that its last one held.
  int sets() const { return sets_; }
  int held() const { return held_; }

 private:
  struct Node {
    Index node;
    int condition;
    std::size_t axis;
    Real inward;  ///< 1 or -1: the direction into the body along the axis.
    bool is_free = false;
    int changes = 0;  ///< In this step.
  };
  void mark();

  const NodeConditions<Dim>& conditions_;
  std::vector<Node> nodes_;
  std::vector<bool> released_;
  int sets_ = 0;
  int held_ = 0;
};

}  // namespace matpoint
