// Implicit MPM: Newmark's method in time, Newton's method in each step, particles as quadrature points. Nothing goes from the particles to
// the grid but forces and masses: the unknowns are the displacements of the step, and the particles read theirs off the converged field.
//
// Source: the paper by Aulisa & Capodaglio on implicit MPM and its coupling with FEM, sections 2, 3 and 5; docs/implicit.md has the
// equations with every gap closed.
#pragma once

#include <deque>

#include "body/fem_body.hpp"
#include "body/point_body.hpp"
#include "case/case.hpp"
#include "implicit/assembly.hpp"
#include "implicit/background_reset.hpp"
#include "implicit/face_contact.hpp"
#include "implicit/newton.hpp"
#include "implicit/side_contact.hpp"
#include "implicit/step_space.hpp"
#include "mesh/basis.hpp"
#include "solver/solver.hpp"

namespace matpoint {

/// The work of a force on nodes, by the trapezoidal rule in time, as Newmark's method has it.
template <int Dim>
class NodalWork {
 public:
  /// Adds the work of one step: of the mean of the last force and this one, by active node and component [N], in the displacements [m].
  void advance(const StepSpace<Dim>& space, const std::vector<Real>& force, const std::vector<Real>& u);
  /// Of the last step: half the work of the force at its start, and of that at its end [J].
  Real start() const { return start_; }
  Real end() const { return end_; }
  /// Another force in the place of the last step's, by active node and component [N].
  void start_with(const StepSpace<Dim>& space, const std::vector<Real>& force);
  void declare_state(State& state) { state.add("force", last_); }

 private:
  std::vector<Real> last_;  ///< By slot of the space and component [N].
  Real start_ = 0;
  Real end_ = 0;
};

template <int Dim>
class ImplicitSolver final : public Solver {
 public:
  explicit ImplicitSolver(const Case& problem);

  int dim() const override { return Dim; }
  const GridGeometry& grid() const override { return geometry_; }
  void step(Real t, Real dt) override;
  Real stable_dt() const override { return std::numeric_limits<Real>::infinity(); }
  const std::vector<Escape>& escapes() const override { return escapes_; }
  void remove_escaped() override;
  void declare_state(State& state) override;

  std::size_t body_count() const override { return sources_.size(); }
  const std::string& body_name(std::size_t body) const override { return sources_[body].points->name(); }
  Index particle_count(std::size_t body) const override { return sources_[body].points->count(); }
  std::vector<std::string> field_names(std::size_t body) const override;
  void take_fields(std::size_t body, const std::vector<std::string>& names, int vector_size, std::vector<Field>& fields) const override {
    sources_[body].points->take_fields(names, body, vector_size, fields);
  }
  void set_field(std::size_t body, const std::string& name, const std::vector<Real>& values) override;
  const BodyCells* cells(std::size_t body) const override {
    return sources_[body].fem != nullptr ? &sources_[body].fem->cells_for_output() : nullptr;
  }
  std::vector<std::string> node_field_names(std::size_t body) const override;
  Field node_field(std::size_t body, const std::string& name) const override;
  std::vector<Field> grid_fields() const override { return {}; }
  BodyTotals totals(std::size_t body) const override { return sources_[body].points->totals(gravity_on(body)); }
  std::vector<BoundaryTotals> boundaries() const override;
  const Ledger& ledger() const override { return ledger_; }
  const Profile& profile() const override { return profile_; }
  Index node_count() const override { return basis_->node_count(); }
  Index memory() const override;
  Occupancy occupancy() const override;
  std::vector<StepNumber> step_numbers() const override;
  std::vector<std::string> warnings() const override;

  // For tests: the parts of a step.
  const NewtonReport& newton_report() const { return newton_.report(); }
  StepSpace<Dim>& space() { return space_; }
  Assembly<Dim>& assembly() { return assembly_; }
  const std::vector<PointSource<Dim>>& sources() const { return sources_; }
  const Basis<Dim>& basis() const { return *basis_; }

 private:
  /// Advances by dt, in halves where Newton's method fails.
  void advance(Real t, Real dt, int cuts);
  /// Does nothing when it fails, and says why.
  std::optional<std::string> try_step(Real t, Real dt);
  /// The unknowns and the friction of the faces' set of states as it is; with the faces' displacements by condition [m].
  void take_contacts(StepLoad<Dim>& load, const std::vector<Vec<Dim>>& displacements);
  /// Where sides let go: accelerations at the start of the step that balance the forces on its own background. Those that the particles
  /// carry balance them on that of the step before, on which they lay elsewhere, with what was held then; the trapezoidal rule takes half
  /// of them on into the motion, and in a bounce that works in one direction: a block gained up to its whole energy.
  void balance(Real t, Real dt, const std::vector<Vec<Dim>>& displacements);
  void balance_pairs(const std::vector<Real>& up, const std::vector<Real>& down, Real small);
  /// Newton's method and the faces' sets of states, until they agree; balance() before each where asked for.
  std::optional<std::string> settle(Real t, Real dt, StepLoad<Dim>& load, const std::vector<Vec<Dim>>& displacements, bool is_balanced,
                                    std::vector<Real>& u);
  bool loses_particles(const std::vector<Real>& u) const;
  struct StepStart;
  StepStart start_of_step() const;
  void restore(const StepStart& start);
  /// Newton's method with the faces' set of states as it is, from `u`, or from 0 where it is empty.
  std::optional<std::string> solve(Real t, const StepLoad<Dim>& load, const std::vector<Vec<Dim>>& displacements, std::vector<Real>& u);
  void make_bodies();
  void make_tractions();
  /// The background where it is at the start of the step, the particles in it, the unknowns.
  void update_space(Real t);
  void set_initial_acceleration(Real t, Real dt);
  void take_nodal_accelerations(const std::vector<Real>& nodal);
  void start_loads(const StepLoad<Dim>& load);
  void balance_initial_stress();
  bool is_small_correction(const std::vector<Real>& A, const StepLoad<Dim>& load) const;
  void take_stress(const std::vector<Real>& A);
  StepLoad<Dim> make_load(Real t_end, Real dt);
  StepInertia newmark(Real dt) const;
  void commit(Real t, Real dt, const StepLoad<Dim>& load, const std::vector<Real>& u);
  void commit_law(Real dt, const std::vector<Real>& A);
  void commit_nodes(Real dt, const StepLoad<Dim>& load, const std::vector<Real>& u);
  void book(Real t, Real dt, const StepLoad<Dim>& load, const std::vector<Real>& u, const std::vector<Vec<Dim>>& du, const Vec3& reaction);
  /// Books what each condition does in a step; `slip` along faces with friction by active node and component [m]. Returns the sum of their
  /// forces on the bodies [N].
  Vec3 hold(const StepLoad<Dim>& load, const std::vector<Real>& u, const std::vector<Real>& residual, const std::vector<Real>& slip,
            Real dt);
  /// The same of bodies in contact with each other, which the ledger does not see.
  void hold_pairs(const std::vector<Real>& u, Real dt);
  /// Books what the loads on particles do in a step from time t. Returns the sum of their forces at its end [N].
  Vec3 book_loads(Real t, Real dt, const StepLoad<Dim>& load, const std::vector<Real>& u);
  /// Their factors at time t.
  std::vector<Real> load_factors(Real t) const;
  /// The condition that acts on a component of an active node, or -1.
  int acting_condition(std::size_t active_node, std::size_t component, const StepLoad<Dim>& load) const;
  void book_forces_at_start(Real dt, const StepLoad<Dim>& load, const std::vector<Real>& u, const std::vector<Vec<Dim>>& du);
  void change_gravity(const Vec3& gravity, const std::vector<Vec<Dim>>& du);
  /// Gravity on a body, by its weight [m/s^2].
  Vec3 gravity_on(std::size_t body) const;
  void check_support() const;
  void find_escapes();
  void check_sides(std::size_t source) const;
  /// What contact stores after particles were moved or taken away other than by steps.
  void measure_contact();

  Case case_;
  ImplicitSpec spec_;
  std::unique_ptr<Basis<Dim>> basis_;
  GridGeometry geometry_;
  NodeConditions<Dim> conditions_;
  std::deque<PointBody<Dim>> particles_;  // whose elements stay where they are, for sources_ points to them
  std::deque<FemBody<Dim>> fem_bodies_;
  std::vector<PointSource<Dim>> sources_;  ///< In the order of the case.
  StepSpace<Dim> space_;
  FaceContacts<Dim> contacts_;  ///< With sides.
  BodyContact<Dim> contact_;    ///< Of bodies with each other.
  SideContact<Dim> sides_;
  PointLoads<Dim> point_loads_;
  Assembly<Dim> assembly_;
  Profile profile_;
  Newton<Dim> newton_;
  std::unique_ptr<BackgroundReset<Dim>> reset_;  ///< Where the basis moves.
  std::vector<Vec<Dim>> tractions_;              ///< Full nodal forces by node of the background [N]; empty without.
  Vec3 gravity_;                                 ///< Now [m/s^2].
  Real time_ = 0;                                ///< At the end of the last step [s].
  bool has_acceleration_ = false;
  Vec3 acceleration_gravity_{};  ///< The gravity that the particles' accelerations hold [m/s^2].
  Vec3 gravity_force_{};         ///< On all particles, as the accelerations at the end of the last step have it [N].
  Vec3 body_force_force_{};      ///< The same of the body force.
  Vec3 reaction_{};              ///< And of the conditions at nodes.
  /// A condition that holds components, and what it does.
  struct HeldBoundary {
    BoundaryTotals totals;
    NodalWork<Dim> work;
    NodalWork<Dim> in_slip;  ///< The share of the work in slip along faces, which dissipates.
    void declare_state(State& state) {
      state.part("totals", totals);
      state.part("work", work);
      state.part("in_slip", in_slip);
    }
  };
  /// What balance() changes.
  struct StepStart {
    FaceContacts<Dim> contacts;
    std::vector<HeldBoundary> boundaries;
    std::vector<HeldBoundary> pairs;
    std::vector<BoundaryTotals> loads;
    NodalWork<Dim> soft_work;
    NodalWork<Dim> traction_work;
    Vec3 gravity_force;
    Vec3 body_force_force;
    Vec3 reaction;
    std::vector<std::vector<Vec<Dim>>> accelerations;        ///< By source and particle [m/s^2].
    std::vector<std::vector<Vec<Dim>>> nodal_accelerations;  ///< By source and node of a body of elements [m/s^2].
  };
  std::vector<HeldBoundary> boundaries_;  ///< By condition, also those that hold nothing.
  std::vector<HeldBoundary> pairs_;       ///< What the second body of a pair in contact does to the first.
  std::vector<BoundaryTotals> loads_;     ///< What the loads on particles do.
  bool has_pressed_ = false;              ///< Contact, in the last step of a case without particles.
  Real load_work_at_start_ = 0;           ///< Half the work of the loads on particles at the start of the step, likewise [J].
  Real work_at_start_ = 0;                ///< Half the work of all reactions at the start of the step, in its displacements [J].
  NodalWork<Dim> traction_work_;
  NodalWork<Dim> soft_work_;
  int iterations_ = 0;         ///< Of the last step, all parts of it together.
  int linear_iterations_ = 0;  ///< The same, of iterative methods for the linear systems.
  int cuts_ = 0;
  double step_seconds_ = 0;
  std::vector<Escape> escapes_;
  std::vector<std::vector<Index>> escaped_rows_;  ///< By body.
  Ledger ledger_;
};

std::unique_ptr<Solver> make_implicit_solver(const Case& problem);

}  // namespace matpoint
