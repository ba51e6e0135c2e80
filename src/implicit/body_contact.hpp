// Contact between bodies in fields of displacements of their own; of a body of elements the Gauss points are the particles.
//
// The potential that the explicit solver has (docs/theory.md, contact between bodies),
//
//     Phi = sum_p V_p K / 2 <g_p>^2,     g_p = c_p - c0_p,     c_p = sum_q V_q W(|x_p - x_q|),
//
// as a function of the nodes' displacements: particles read theirs off the field of their body. In statics the forces are -dPhi/dx at the
// end of a step. In dynamics that would make or lose energy where bodies meet and part, in steps that are long beside the time for which
// they touch. So the mean force over a step is the discrete gradient D (Gonzalez 1996; Simo & Tarnow 1992): differences of Phi over
// differences of the squared distances, with which D . u is the change of Phi whatever the step, equal and opposite on both bodies, and
// without a moment. At the end of the step the residual has 2 D less the forces at its start, so that the mean is D.
//
// Friction goes by a spring per particle as in the explicit solver, with the surface's direction and the neighbours' weights as they were
// at the start of the step, and its mean normal force, in statics that of its end (return mapping, Simo & Laursen 1992). Tangents are
// exact.
#pragma once

#include <map>

#include "body/mirror_image.hpp"
#include "geometry/pair_kernel.hpp"
#include "implicit/pressing.hpp"
#include "implicit/step_space.hpp"

namespace matpoint {

/// Particles of a cell, and the cells of another body that may touch them.
template <int Dim>
struct ContactPatch {
  std::size_t pair = 0;              ///< Of bodies,
  std::size_t side = 0;              ///< and which of the two the particles are of.
  std::vector<std::size_t> entries;  ///< The cell, then those of the other body, as places among the space's.
  std::vector<int> nodes;            ///< Active nodes of all of them, ascending.
  std::vector<int> local;            ///< By entry and function: place among the nodes.
  std::vector<int> row_offset;       ///< As VolumePatch's.
  struct Candidate {
    std::uint32_t q;      ///< Place among the space's particles.
    std::uint32_t entry;  ///< Among the patch's.
    std::uint32_t image;
  };
  std::vector<Index> points;       ///< Places among the space's particles.
  std::vector<std::size_t> begin;  ///< Of each point's candidates; one more at the end.
  std::vector<Candidate> candidates;
};

template <int Dim>
class BodyContact {
 public:
  /// Without any contact where the case has none. The space must outlive it.
  BodyContact(const Case& problem, const StepSpace<Dim>& space);

  bool has_pairs() const { return !pairs_.empty(); }
  /// Whether bodies may touch in this step.
  bool is_near() const { return !patches_.empty(); }

  /// To be called when the space has been updated: the places at the start of the step, and what is near.
  void start();
  /// Takes displacements by active node and component [m]; where particles have gone farther than was looked for, there are other
  /// patches then.
  void move(const std::vector<Real>& u);
  /// Where the accelerations at the start of the step balance the forces to first order in displacements `way` (ImplicitSolver::balance):
  /// the normal forces that they hold are those after it. Empty: those of the places.
  void balance(const std::vector<Real>& way);
  std::vector<ContactPatch<Dim>>& patches() { return patches_; }

  /// Whether a particle has run so deep into another body, or moved so far past it, that what pushes it back is no longer what it should
  /// be. Says where; empty if not. After move().
  std::string find_overlap() const;

  /// Residual of a patch by its nodes and components, and its matrix where asked for. After move().
  void work(const ContactPatch<Dim>& patch, bool is_dynamic, Real* residual, Real* K) const;

  /// The numbers of the two bodies of each pair.
  std::vector<std::array<std::size_t, 2>> pairs() const;
  /// Forces on the first body of each pair as the residual has them, by active node and component [N]. After move().
  std::vector<std::vector<Real>> pair_forces(bool is_dynamic) const;

  /// Half the work of the forces at the start of the step in its displacements [J]. After move(), as all below.
  Real work_at_start() const;
  /// Ends the step. Returns what friction takes [J].
  Real commit(bool is_dynamic);
  /// Whether anything pressed in the step, or does at its end. After move().
  bool has_pressed() const;
  /// Stored now: in the overlap, and in the springs of particles that stick [J].
  Real energy() const { return energy_; }
  /// Where the particles are now.
  void measure_energy();
  /// Changes when the patches do.
  Index pattern() const { return pattern_; }
  void declare_state(State& state);

 private:
  struct Pair {
    std::array<std::size_t, 2> sources;
    PairKernel<Dim> kernel;
    Real stiffness;                                   ///< K [Pa]
    std::array<std::vector<Real>, 2> at_touch;        ///< c0 of each particle, by id [1].
    std::array<std::map<Index, Hold<Dim>>, 2> holds;  ///< By id.
    std::array<std::map<Index, Real>, 2> shifts;      ///< Of <g> at the start of the step, by id [1].
  };
  /// A neighbour in a step.
  struct Near {
    std::uint32_t q;
    std::uint32_t entry;
    std::uint32_t image;
    Vec<Dim> r0, r1;  ///< From it to the particle, at the start and now [m].
    Real q0, q1;      ///< 1 - r^2 / R^2
  };
  /// A particle in a step.
  struct Meeting {
    std::vector<Near> near;
    Real c0 = 0;  ///< c_p at the start [1].
    Real g0 = 0, g1 = 0;
    bool presses() const { return g0 > 0 || g1 > 0; }
  };
  /// Friction of a particle in a step.
  struct Rub {
    bool is_on = false;
    Vec<Dim> normal{};
    Real stiffness = 0;    ///< Of the spring [N/m].
    Real reach = 0;        ///< |grad c_p| [1/m]
    Vec<Dim> old_force{};  ///< At the start of the step [N].
    Vec<Dim> slip{};       ///< Along the surface [m].
    Vec<Dim> pull{};       ///< Of the spring, if nothing limited it, over its stiffness [m].
    Vec<Dim> force{};      ///< [N]
    Real limit = 0;        ///< mu N [N]
    bool slips = false;
  };
  Meeting meet(const ContactPatch<Dim>& patch, std::size_t point) const;
  Rub rub(const ContactPatch<Dim>& patch, std::size_t point, const Meeting& meeting, bool is_dynamic) const;
  struct Arm;
  void press(const ContactPatch<Dim>& patch, std::size_t point, const Meeting& meeting, bool is_dynamic, Real* residual, Real* K) const;
  void add_rubbing(const Rub& rubbing, Real weight, Real limit_slope, const std::vector<Real>& past, const std::vector<Real>& now,
                   Real* K) const;
  using Found = std::array<Index, 3>;  ///< A particle, another one, and the image of it.
  void search();
  void search(const Pair& pair, const std::vector<Vec<Dim>>& positions, std::vector<Found>& found) const;
  void make_patches(std::vector<Found> found, std::size_t pair, std::size_t side);
  void lay();
  Real volume(Index k) const;
  Index id(Index k) const;

  const StepSpace<Dim>& space_;
  std::vector<MirrorImage<Dim>> images_;
  Real friction_ = 0;
  std::vector<Pair> pairs_;
  std::vector<ContactPatch<Dim>> patches_;
  bool is_first_ = true;
  Index pattern_ = 0;
  std::vector<std::vector<Index>> places_;  ///< By source: places among the space's particles.
  // By place among the space's particles.
  std::vector<std::size_t> entry_;     ///< Cell.
  std::vector<Vec<Dim>> x0_, x_;       ///< At the start of the step, and now [m].
  std::vector<Vec<Dim>> searched_at_;  ///< When the patches were made [m].
  Real energy_ = 0;
};

}  // namespace matpoint
