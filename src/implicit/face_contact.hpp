// Rigid faces that let go and rub: an active set on the nodes of sides of the grid, for functions that are nowhere negative (B-splines), so
// that the sign of a reaction at a node means something.
//
//          reaction pulls                     held with more than mu R_n along the face
//   free <---------------- slips, sticks     sticks -------------------------------------> slips
//        ----------------> slips                    <-------------------------------------
//          moved into the face                       would move along with its friction
//
// After Newton's method has converged with a set of states, nodes change as their reactions and motions ask; then Newton again, until the
// set stays. A node that slips is held across the face, and has the force mu R_n against its slip s in its equations along the face: with
// the R_n of that very solution, since R_n is the residual across the face at the same node. In 2D the direction of the slip is a sign that
// belongs to the set. In 3D it turns: s / |s| is taken to first order about the slip s0 of the solution before, t + (I - t t^T) s / |s0|
// with t = s0 / |s0|, until it no longer does. A face without a limit to its friction (no_tension) has no nodes that slip. Sources:
// docs/implicit.md.
#pragma once

#include "implicit/assembly.hpp"
#include "implicit/step_space.hpp"

namespace matpoint {

template <int Dim>
class FaceContacts {
 public:
  /// The space's conditions must outlive it: a node is let go in the components that its face holds, and not in those of another side in a
  /// corner.
  FaceContacts(const std::vector<BoundarySpec>& specs, const StepSpace<Dim>& space);

  bool is_empty() const { return nodes_.empty(); }
  /// Before the first solve of a step: nodes that no particle is near are held across their face, the others are as the last step left
  /// them.
  void start(const StepSpace<Dim>& space);
  /// Components that are let go now, by slot and component, for StepSpace::release.
  const std::vector<bool>& released() const { return released_; }
  /// Friction at nodes that slip now, by active node; empty without any. With the faces' displacements by condition [m].
  std::vector<FaceFriction<Dim>> friction(const StepSpace<Dim>& space, const std::vector<Vec<Dim>>& displacements) const;
  /// With the displacements [m] and the residual [N] of a converged solve, by active node and component, and the faces' displacements by
  /// condition [m]: the next set. Whether it is another one, so that Newton's method must go on; not for ever.
  bool update(const StepSpace<Dim>& space, const std::vector<Real>& u, const std::vector<Real>& residual,
              const std::vector<Vec<Dim>>& displacements);
  /// Displacements along faces with friction, relative to them [m], by active node and component; 0 elsewhere.
  std::vector<Real> slip(const StepSpace<Dim>& space, const std::vector<Real>& u, const std::vector<Vec<Dim>>& displacements) const;
  /// Solves of the last step; the nodes with particles near that its last one held; of these, those that slipped; and the nodes whose state
  /// had not settled when the step had to go on.
  int sets() const { return sets_; }
  int held() const { return held_; }
  int slipping() const { return slipping_; }
  int unsettled() const { return unsettled_; }
  void declare_state(matpoint::State& state);

 private:
  enum class State { free, slips, sticks };
  struct Node {
    Index node;  ///< Of the background.
    Index slot;  ///< Of the space.
    int condition;
    std::size_t axis;
    Real inward;    ///< 1 or -1: the direction into the body along the axis.
    bool can_slip;  ///< Coulomb's law limits what holds it along the face.
    Real friction;  ///< mu [1]
    State state;
    Vec<Dim> direction{};  ///< Of its slip, a unit vector along the face; 0 as long as none is known: it slips without friction.
    int changes = 0;       ///< In this step: of being held across the face,
    int slips = 0;         ///< from sticking to slipping,
    int turns = 0;         ///< and of the direction.
    Real reach = 0;        ///< The slip |s0| that the direction is of [m]; 0: of no slip yet, the direction stays.
  };
  /// What a solve says of a node.
  struct Answer {
    Real pressure;          ///< Reaction across the face [N].
    Real depth;             ///< Displacement into the face, relative to it [m].
    Vec<Dim> slip{};        ///< The same along it, in the components that it holds.
    Vec<Dim> resistance{};  ///< Reaction in these components [N].
    Real rounding;          ///< A force that is nothing [N].
  };
  Answer answer(const Node& one, std::size_t place, const std::vector<Real>& u, const std::vector<Real>& residual, const Vec<Dim>& face,
                Real rounding) const;
  /// Whether the node takes another state or direction.
  static bool change(Node& one, const Answer& found);
  static bool change_slip(Node& one, const Answer& found);
  /// Of a node that slips: whether its friction would bring energy in.
  static bool is_driven(const Node& one, const Answer& found);
  /// Part of the slip that is across the direction of a node [m].
  static Vec<Dim> sideways(const Node& one, const Vec<Dim>& slip);
  bool holds_along(const Node& one, std::size_t d) const;
  void mark();

  const NodeConditions<Dim>* conditions_;
  std::vector<Node> nodes_;
  std::vector<bool> released_;
  int sets_ = 0;
  int held_ = 0;
  int slipping_ = 0;
  int unsettled_ = 0;
};

}  // namespace matpoint
