#include "verify/analytic.hpp"

#include "core/error.hpp"

namespace matpoint {
namespace {

VerifyRow row(std::string quantity, Real expected, Bound bound, std::string source) {
  VerifyRow made;
  made.quantity = std::move(quantity);
  made.expected = expected;
  made.bound = bound;
  made.source = std::move(source);
  return made;
}

}  // namespace

VerifyRow within(std::string quantity, Real expected, Real tolerance, std::string source) {
  VerifyRow made = row(std::move(quantity), expected, Bound::within, std::move(source));
  made.tolerance = tolerance;
  return made;
}

VerifyRow at_most(std::string quantity, Real expected, std::string source) {
  return row(std::move(quantity), expected, Bound::at_most, std::move(source));
}

VerifyRow at_least(std::string quantity, Real expected, std::string source) {
  return row(std::move(quantity), expected, Bound::at_least, std::move(source));
}

VerifyRow reported(std::string quantity, Real expected, std::string source) {
  VerifyRow made = row(std::move(quantity), expected, Bound::within, std::move(source));
  made.kind = RowKind::truth;
  return made;
}

void add_problem(VerifySuite& suite, VerifyJob job, std::vector<VerifyRow> rows) {
  if (job.case_name.empty()) job.case_name = job.group;
  for (VerifyRow& row_of_job : rows) {
    row_of_job.group = job.group;
    job.quantities.push_back(row_of_job.quantity);
    suite.rows.push_back(std::move(row_of_job));
  }
  suite.jobs.push_back(std::move(job));
}

Real ZeroCrossings::period() const {
  if (times_.size() < 2) throw SolverError("the signal changed its sign {} times only, so it has no period", times_.size());
  return 2 * (times_.back() - times_.front()) / static_cast<Real>(times_.size() - 1);
}

VerifySuite analytic_suite() {
  VerifySuite suite;
  add_bars(suite);
  add_solids(suite);
  add_fluids(suite);
  add_invariants(suite);
  add_manufactured(suite);
  add_inclines(suite);
  add_everyday(suite);
  add_implicit_analytic(suite);
  add_implicit_newton(suite);
  add_implicit_incompressible(suite);
  add_elastic_cylinder(suite);
  add_axisymmetry(suite);
  add_loads(suite);
  add_tools(suite);
  add_implicit_paper(suite);
  add_implicit_explicit(suite);
  add_implicit_friction(suite);
  add_implicit_bounce(suite);
  add_implicit_contact(suite);
  add_implicit_dynamics(suite);
  add_coupled_paper(suite);
  add_fem(suite);
  add_materials(suite);
  return suite;
}

}  // namespace matpoint
