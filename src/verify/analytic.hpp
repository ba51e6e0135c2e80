// Problems whose answers are known in closed form, and how they are written down: a job together with the rows of its numbers.
#pragma once

#include "verify/measure.hpp"
#include "verify/verify.hpp"

namespace matpoint {

/// Adds a job and its rows; the rows take the job's group, the job measures the rows' quantities.
void add_problem(VerifySuite& suite, VerifyJob job, std::vector<VerifyRow> rows);

/// Rows without a group.
VerifyRow within(std::string quantity, Real expected, Real tolerance, std::string source);
VerifyRow at_most(std::string quantity, Real expected, std::string source);
VerifyRow at_least(std::string quantity, Real expected, std::string source);
/// Printed beside the expected value, without a bound that must be kept.
VerifyRow reported(std::string quantity, Real expected, std::string source);

void add_bars(VerifySuite& suite);
void add_solids(VerifySuite& suite);
void add_fluids(VerifySuite& suite);
void add_invariants(VerifySuite& suite);
void add_manufactured(VerifySuite& suite);
void add_inclines(VerifySuite& suite);
/// With the defaults and each quality, or with the numerics given as --set would.
void add_everyday(VerifySuite& suite, const Sets& numerics = {});
void add_implicit_analytic(VerifySuite& suite);
void add_implicit_newton(VerifySuite& suite);
void add_implicit_incompressible(VerifySuite& suite);
void add_elastic_cylinder(VerifySuite& suite);
void add_axisymmetry(VerifySuite& suite);
/// Loads on particles and on the ground (loads.cpp).
void add_loads(VerifySuite& suite);
/// Rigid tools (tools.cpp).
void add_tools(VerifySuite& suite);
void add_implicit_paper(VerifySuite& suite);
void add_implicit_explicit(VerifySuite& suite);
void add_implicit_friction(VerifySuite& suite);
void add_implicit_bounce(VerifySuite& suite);
void add_implicit_contact(VerifySuite& suite);
void add_implicit_dynamics(VerifySuite& suite);
void add_coupled_paper(VerifySuite& suite);
void add_fem(VerifySuite& suite);
void add_materials(VerifySuite& suite);

/// Greatest and least of what a callback sees.
struct Range {
  Real least = std::numeric_limits<Real>::infinity();
  Real greatest = -std::numeric_limits<Real>::infinity();
  void include(Real value) {
    least = std::min(least, value);
    greatest = std::max(greatest, value);
  }
};

/// Instants at which a signal changes its sign, linear between samples: the period of an oscillation.
class ZeroCrossings {
 public:
  void include(Real t, Real value) {
    if (has_last_ && (value > 0) != (last_ > 0)) times_.push_back(t_last_ + (t - t_last_) * last_ / (last_ - value));
    has_last_ = true;
    t_last_ = t;
    last_ = value;
  }
  std::size_t count() const { return times_.size(); }
  /// [s], from the first to the last crossing; throws SolverError with fewer than two.
  Real period() const;

 private:
  std::vector<Real> times_;
  bool has_last_ = false;
  Real t_last_ = 0;
  Real last_ = 0;
};

}  // namespace matpoint
