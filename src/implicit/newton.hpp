// Newton's method for the displacements of one implicit step.
#pragma once

#include <optional>

#include "case/implicit_spec.hpp"
#include "implicit/assembly.hpp"
#include "implicit/linear_solver.hpp"

namespace matpoint {

/// How it went.
struct NewtonReport {
  std::vector<Real> residuals;   ///< Norms over the unknowns before each iteration [N], and after the last one.
  std::vector<Real> increments;  ///< Of each iteration, relative to the displacement of the step [1].
  int iterations = 0;
  int halvings = 0;           ///< How often an increment was halved.
  int linear_iterations = 0;  ///< Of iterative methods for the linear systems, of all of them.
  Real pivot_ratio = 0;       ///< Of the last matrix (LinearSolver).
};

template <int Dim>
class Newton {
 public:
  /// All must outlive it.
  Newton(const ImplicitSpec& spec, const StepSpace<Dim>& space, Assembly<Dim>& assembly, Profile& profile);

  /// From `u`, or from 0 where it is empty, with the prescribed displacements by active node and component [m]: fills `u`, or says why it
  /// failed. Where full increments do not converge, once more with increments that are halved until they reduce the residual.
  std::optional<std::string> solve(const StepLoad<Dim>& load, std::vector<Real> prescribed, Symmetry symmetry, std::vector<Real>& u);

  /// Displacements by active node and component that the forces `right` make with the assembly's present matrix, 0 where prescribed; false
  /// when there are none.
  bool solve_linear(const std::vector<Real>& right, Symmetry symmetry, std::vector<Real>& result);

  const NewtonReport& report() const { return report_; }
  /// Norm over the unknowns of numbers by active node and component.
  Real unknown_norm(const std::vector<Real>& nodal) const;
  void report_residual(Real norm) { report_.residuals.push_back(norm); }

 private:
  /// What one call of solve() works on.
  struct Search {
    const StepLoad<Dim>& load;
    std::vector<Real> prescribed;  ///< What of the prescribed displacements is still to come [m].
    std::vector<Real> u;
    std::vector<Real> trial;
    std::vector<Real> increment;
    std::vector<Real> residual;
    Lift lift;
    Real last_norm = 0;
    Real norm = 0;
    int halvings_to_fall = 0;  ///< So often an increment is halved that does not reduce the residual.
    Real force_scale = 0;      ///< Of all nodes, prescribed components, too: a body at rest has its weight here [N].
    bool has_all() const { return lift.displacement == nullptr; }
  };
  enum class Outcome { goes_on, converged, failed };
  std::optional<std::string> search_from(Search search, Symmetry symmetry, std::vector<Real>& u);
  bool is_balanced(const Search& search) const;
  bool has_converged(const Search& search, Real share);
  bool make_increment(Search& search, Symmetry symmetry);
  Outcome take_increment(Search& search, std::string& failure);

  UnknownPlaces places() const;

  const ImplicitSpec& spec_;
  const StepSpace<Dim>& space_;
  Assembly<Dim>& assembly_;
  Profile& profile_;
  std::unique_ptr<LinearSolver> linear_solver_;
  Index analyzed_ = -1;  ///< Pattern of the assembly.
  NewtonReport report_;
};

}  // namespace matpoint
