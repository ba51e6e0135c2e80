// Contact of particles with sides of the grid.
//
// A particle touches where the surface of its piece of the body does, half a spacing before its middle: at d_p = (V_p)^(1/dim) / 2 from the
// side. What is nearer, by g_p = d_p - d, presses with the potential
//
//     Phi = sum_p k_p / 2 d_p <g_p>^2 / (d_p - g_p),     k_p = V_p K w^2,
//
// endless at the side itself, so that nothing comes through; K is ten moduli of the body and w as in contact between pairs
// (body_contact.hpp), whose discrete gradient in time and whose friction this has, too. So bodies come to rest at the side and not before
// it, and a bounce makes no energy. Sides of kind "slip" only push; what presses on the others sticks to them, or rubs by Coulomb's law.
// A side with a velocity across itself moves into the grid with it, as a piston.
#pragma once

#include <map>

#include "case/case.hpp"
#include "implicit/pressing.hpp"
#include "implicit/step_space.hpp"

namespace matpoint {

template <int Dim>
class SideContact {
 public:
  /// Of the sides that particles touch. The space must outlive it.
  SideContact(const Case& problem, const StepSpace<Dim>& space);

  bool is_empty() const { return sides_.empty(); }
  /// Whether any side has Coulomb's friction, which makes the matrix unsymmetric.
  bool has_friction() const;
  /// Whether a particle may touch a side in this step; and one of a cell.
  bool is_near() const { return is_near_; }
  bool is_near(std::size_t cell) const { return is_near_ && !near_[cell].empty(); }

  /// To be called when the space has been updated.
  void start();
  /// At the start of a step, with the displacements of the conditions in it [m].
  void start_step(const std::vector<Vec<Dim>>& displacements) { displacements_ = displacements; }
  /// As BodyContact's.
  void balance(const std::vector<Real>& way);

  /// Adds the forces on the particles of a cell to its residual, by its functions and components, and to its matrix if there is one.
  void work(std::size_t cell, const std::vector<Real>& u, bool is_dynamic, Real* residual, Real* K) const;
  /// Whether a particle would come through a side. Says where; empty if not.
  std::string find_overlap(const std::vector<Real>& u) const;

  /// Half the work of the forces at the start of the step in its displacements [J].
  Real work_at_start(const std::vector<Real>& u) const;
  /// What a side does in a step.
  struct Action {
    int condition;
    Vec<Dim> start{};    ///< Force on the bodies as the accelerations at the start of the step have it [N],
    Vec<Dim> end{};      ///< and as the residual has it at the end. Their mean is that of the step.
    Real work = 0;       ///< Of the mean force in the side's own displacement [J].
    Real slip_work = 0;  ///< Taken by friction [J].
  };
  std::vector<Action> actions(const std::vector<Real>& u, bool is_dynamic) const;
  /// A particle that lies on a side, which may hold it.
  struct Support {
    std::size_t cell;  ///< Among the space's.
    Vec<Dim> x;        ///< [m]
    std::size_t axis;
    bool holds_along;  ///< Also across the axis.
  };
  std::vector<Support> supports() const;
  /// Whether anything pressed in the step, or does at its end.
  bool has_pressed(const std::vector<Real>& u) const;
  /// Ends the step.
  void commit(const std::vector<Real>& u, bool is_dynamic);
  /// After displacements.
  void measure_energy(const std::vector<Real>& u);
  /// Stored now [J].
  Real energy() const { return energy_; }
  void declare_state(State& state);

 private:
  /// What forces that are linearised at the start of a step have beside those of the places.
  struct Shift {
    Real pressed = 0;  ///< [m]
    Vec<Dim> force{};  ///< [N]
  };
  struct Side {
    std::size_t axis;
    Real inward;  ///< 1 or -1
    Real place;   ///< Along the axis, now [m].
    int condition;
    Real friction;                                  ///< Infinite where what presses sticks.
    std::vector<Shift> shifts;                      ///< By place among the space's particles; empty: none.
    std::vector<std::map<Index, Hold<Dim>>> holds;  ///< By source and id.
    std::vector<std::map<Index, Real>> laid;        ///< d_p of particles that were laid nearer than half a spacing, the same.
  };
  /// A particle at a side in a step.
  struct Touch {
    Real g0 = 0, g1 = 0;            ///< At the start and now [m].
    Real depth = 0;                 ///< d_p [m]
    Real stiffness = 0;             ///< k_p [N/m]
    Real start = 0;                 ///< Force at the start over k_p [m].
    Real pressed = 0;               ///< The mean of that over the step, in statics that at its end [m],
    Real slope = 0;                 ///< and its derivative by g1 [1].
    Vec<Dim> old_force{}, force{};  ///< Of friction at the start, and its mean [N].
    Vec<Dim> slip{};                ///< [m]
    Vec<Dim> pull{};                ///< Of the spring, if nothing limited it, over its stiffness [m].
    Real limit = 0;                 ///< Of friction [N].
    bool slips = false;
    bool presses() const { return g0 > 0 || g1 > 0; }
    /// What friction has of a stiffness of 1 along the pull: all, or what is left of it where it slips.
    Real share() const;
  };
  Touch touch(const Side& side, std::size_t cell, Index k, const Vec<Dim>& du, bool is_dynamic) const;
  void rub(const Side& side, std::size_t cell, Index k, const Vec<Dim>& du, bool is_dynamic, Touch& touch) const;
  /// Of the residual's force, by the displacement.
  static std::array<Vec<Dim>, Dim> tangent(const Side& side, const Touch& touch, Real weight);
  void lay();
  Vec<Dim> displacement(std::size_t cell, Index k, const std::vector<Real>& u) const;
  /// Calls f(side's number, cell, place, touch, displacement) for the particles that press.
  template <class F>
  void for_each_touch(const std::vector<Real>& u, bool is_dynamic, F&& f) const;

  const StepSpace<Dim>& space_;
  std::vector<Side> sides_;
  std::vector<Real> modulus_;  ///< By source: K [Pa].
  Real slope_ = 0;             ///< w of particles with a spacing of 1 [1/m].
  std::vector<Vec<Dim>> displacements_;
  std::vector<std::vector<std::size_t>> near_;  ///< By cell: numbers of the sides.
  bool is_near_ = false;
  bool is_first_ = true;
  bool is_static_;
  Real energy_ = 0;
};

}  // namespace matpoint
