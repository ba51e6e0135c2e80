// Contact of particles with sides of the grid.
//
// A particle touches where the surface of its piece of the body does, half a spacing before its middle: at d_p = (V_p)^(1/dim) / 2 from the
// side. What is nearer presses, with the potential
//
//     Phi = sum_p V_p K w^2 / 2 <d_p - d>^2,
//
// K in moduli of the body and w as in contact between pairs (body_contact.hpp), whose discrete gradient in time and whose friction this
// has, too. So bodies come to rest at the side, and a bounce makes no energy.
#pragma once

#include <map>

#include "case/case.hpp"
#include "implicit/pressing.hpp"
#include "implicit/step_space.hpp"

namespace matpoint {

template <int Dim>
class SideContact {
 public:
  /// Of the sides with contact. The space must outlive it.
  SideContact(const Case& problem, const StepSpace<Dim>& space);

  bool is_empty() const { return sides_.empty(); }
  /// Whether a particle may touch a side in this step.
  bool is_near() const { return is_near_; }

  /// To be called when the space has been updated.
  void start();
  /// At the start of a step, with the displacements of the conditions in it [m].
  void start_step(const std::vector<Vec<Dim>>& displacements) { displacements_ = displacements; }

  /// As BodyContact's.
  void balance(const std::vector<Real>& way);

  /// Adds the forces on the particles of a cell to its residual, by its functions and components, and to its matrix if there is one; with
  /// the cell's displacements [m].
  void work(std::size_t cell, const std::vector<Real>& u, bool is_dynamic, Real* residual, Real* K) const;
  /// Whether a particle would come through a side. Says where; empty if not.
  std::string find_overlap(const std::vector<Real>& u) const;

  /// Half the work of the forces at the start of the step in its displacements [J].
  Real work_at_start(const std::vector<Real>& u) const;
  /// What a side does in a step.
  struct Action {
    int condition;
    Vec<Dim> end{};      ///< Force on the bodies as the residual has it at the end of the step [N].
    Vec<Dim> mean{};     ///< Over the step [N].
    Real work = 0;       ///< Of the mean force in the side's own displacement [J].
    Real slip_work = 0;  ///< Taken by friction [J].
  };
  std::vector<Action> actions(const std::vector<Real>& u, bool is_dynamic) const;
  /// Ends the step.
  void commit(const std::vector<Real>& u, bool is_dynamic);
  /// Stored now [J].
  Real energy() const { return energy_; }

 private:
  struct Hold {
    Vec<Dim> pulled{};  ///< [m]
    Real energy = 0;    ///< [J]
    bool slips = false;
  };
  struct Side {
    std::size_t axis;
    Real inward;  ///< 1 or -1
    Real place;   ///< Along the axis [m].
    int condition;
    Real friction;                             ///< Infinite where what presses sticks.
    std::vector<Real> shifts;                  ///< Of the pressing at the start of the step, by place among the space's particles [m].
    std::vector<std::map<Index, Hold>> holds;  ///< By source and id.
  };
  /// A particle at a side in a step.
  struct Touch {
    Real g0 = 0, g1 = 0;  ///< d_p - d at the start and now [m].
    Real depth = 0;       ///< d_p [m]
    Real pressed_at_start() const { return pressing_up_to(depth, 0, g0, false).value; }
    Real stiffness = 0;           ///< [N/m]
    Real pressed = 0, slope = 0;  ///< Mean of <g>, or its value in statics, and its derivative [m], [1].
    Vec<Dim> old_force{};         ///< Of friction [N].
    Vec<Dim> slip{}, pull{}, force{};
    Real limit = 0;
    bool slips = false;
    bool presses() const { return g0 > 0 || g1 > 0; }
  };
  Touch touch(const Side& side, std::size_t cell, Index k, const Vec<Dim>& du, bool is_dynamic) const;
  Vec<Dim> displacement(std::size_t cell, Index k, const std::vector<Real>& u) const;
  template <class F>
  void for_each_touch(const std::vector<Real>& u, bool is_dynamic, F&& f) const;

  const StepSpace<Dim>& space_;
  std::vector<Side> sides_;
  std::vector<Real> modulus_;  ///< By source: K [Pa].
  std::vector<Vec<Dim>> displacements_;
  std::vector<std::vector<std::size_t>> near_;  ///< By cell entry: sides that are near.
  bool is_near_ = false;
  Real energy_ = 0;
};

}  // namespace matpoint
