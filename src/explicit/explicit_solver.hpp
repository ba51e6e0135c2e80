// Explicit MPM: one step for the three stress orders. Letters: docs/notation.md.
#pragma once

#include "body/body.hpp"
#include "explicit/applied_loads.hpp"
#include "explicit/fluid_correction.hpp"
#include "explicit/node_contact.hpp"
#include "explicit/pair_contact.hpp"
#include "explicit/tools.hpp"
#include "grid/boundary_condition.hpp"
#include "grid/grid.hpp"
#include "solver/solver.hpp"

namespace matpoint {

/// R: the numbers that particles and grid are kept in, double or float.
template <int Dim, class R>
class ExplicitSolver final : public Solver {
 public:
  explicit ExplicitSolver(const Case& problem);

  int dim() const override { return Dim; }
  const GridGeometry& grid() const override { return geometry_; }
  void step(Real t, Real dt) override;
  Real stable_dt() const override;
  const std::vector<Escape>& escapes() const override { return escapes_; }
  void remove_escaped() override;
  void declare_state(State& state) override;

  std::size_t body_count() const override { return bodies_.size(); }
  const std::string& body_name(std::size_t body) const override { return bodies_[body]->name(); }
  Index particle_count(std::size_t body) const override { return bodies_[body]->particle_count(); }
  std::vector<std::string> field_names(std::size_t body) const override { return bodies_[body]->field_names(); }
  void take_fields(std::size_t body, const std::vector<std::string>& names, int vector_size, std::vector<Field>& fields) const override {
    bodies_[body]->take_fields(names, body, vector_size, fields);
  }
  void set_field(std::size_t body, const std::string& name, const std::vector<Real>& values) override;
  std::vector<Field> grid_fields() const override;
  BodyTotals totals(std::size_t body) const override { return bodies_[body]->totals(gravity_); }
  std::vector<StepNumber> step_numbers() const override { return tools_ ? tools_->numbers() : std::vector<StepNumber>{}; }
  const Ledger& ledger() const override { return ledger_; }
  std::vector<BoundaryTotals> boundaries() const override;
  const Profile& profile() const override { return profile_; }
  Index node_count() const override { return grids_[0]->node_count(); }
  Index memory() const override;
  Occupancy occupancy() const override;

 private:
  void start();
  /// Evaluates the body force for a step from time t [s].
  void update_body_force(Real t);
  /// The same for a body force of particles: what the next mapping takes to the nodes.
  void update_particle_forces(Real t);
  /// Half of the impulse and work of the body force of particles in a step.
  void book_particle_forces(const std::vector<std::vector<Real>>& forces, Real dt);
  /// Evaluates the forces between pairs of particles, dt [s] after the last time, and books them.
  void update_pairs(Real dt);
  /// Moves the tools from time t, and evaluates and books what they do.
  void move_tools(Real t, Real dt);
  void renew_tools();
  void take_contact_energy();
  /// Adds both to what is mapped.
  void add_contact_forces();
  void update_gravity(Real t);
  void measure_gaps();
  /// FMPM: further terms of the nodes' velocity, after they have advanced.
  void refine(Real t, Real dt);
  void start_pass(typename Grid<Dim, R>::NodePass pass, Real t, Real dt);
  void sweep(const char* label, Sweep what, Real dt);
  /// Tells bodies with a frame of their own whether something holds them: a surface that sticks, or a body in the same velocity field.
  void find_held();
  void check_state(Real t);
  void take_boundaries(Real dt);
  void return_escaped(Real t);
  void keep_out(Real t);
  void check_cutoff(const SolverSpec& spec, Real smallest_mass) const;

  std::function<Vec3(Real t)> gravity_at_;  ///< Empty where it is constant.
  Vec3 gravity_;                            ///< Now [m/s^2].
  std::shared_ptr<BodyForce> body_force_;
  std::vector<Real> node_positions_;                ///< For the body force.
  std::vector<Real> body_force_values_;             ///< Dim per node [m/s^2]; empty without a body force.
  std::vector<std::vector<Real>> particle_forces_;  ///< Of a body force of particles, now: per body, Dim per particle [m/s^2].
  StressOrder stress_order_;
  NodalDynamics<Dim> dynamics_;
  int fmpm_order_;  ///< 1 without FMPM.
  const KernelTable<Dim, R>& kernels_;
  /// One for all bodies, or one for each of them.
  std::vector<std::unique_ptr<Grid<Dim, R>>> grids_;
  GridGeometry geometry_;
  BoundaryConditions<Dim, R> boundary_conditions_;
  std::vector<std::unique_ptr<Body<Dim>>> bodies_;  // after the grids that they point to
  std::unique_ptr<Contact<Dim, R>> contact_;        ///< Of contact = "multi_field" only.
  std::unique_ptr<PairContact<Dim>> pairs_;         ///< Of contact = "pairs" only.
  std::unique_ptr<FluidCorrection<Dim, R>> correction_;
  std::unique_ptr<Tools<Dim>> tools_;         ///< Of cases with tools.
  std::unique_ptr<AppliedLoads<Dim>> loads_;  ///< Of cases with loads.
  Real load_time_ = 0;                        ///< Of the forces that the next sweep maps [s].
  /// Whether the grid holds the particles' mass and momentum (and force): a cache between steps, the sweep that moves the particles
  /// has mapped them, too.
  bool is_mapped_ = false;
  bool has_obstacles_ = false;  ///< That fluids may meet.
  /// Boxes around the surfaces that hold what touches them for good.
  std::vector<Extent<Dim>> holds_;
  Real time_ = 0;  ///< At the end of the last step [s].
  std::vector<Escape> escapes_;
  std::vector<BoundaryTotals> boundaries_;  ///< In the order of the case, without loads.
  Ledger ledger_;
  Profile profile_;
};

/// Of the dimension and precision that the case asks for. Throws InputError.
std::unique_ptr<Solver> make_explicit_solver(const Case& problem);

}  // namespace matpoint
