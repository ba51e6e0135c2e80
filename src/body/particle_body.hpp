// A body of particles with one material.
#pragma once

#include <set>

#include "body/body.hpp"
#include "body/cell_blocks.hpp"
#include "body/particle_fields.hpp"
#include "case/body_spec.hpp"
#include "case/solver_spec.hpp"
#include "core/parallel.hpp"
#include "kernel/particle_weights.hpp"
#include "material/material.hpp"

namespace matpoint {

struct WantedFields;

/// What the solver chose for its bodies of particles.
struct ParticleScheme {
  ShapeKind shape = ShapeKind::linear;
  Transfer transfer = Transfer::flip;
  bool has_body_force = false;   ///< Particles carry a body force.
  bool is_corrected = false;     ///< Fluids are corrected.
  bool is_axisymmetric = false;  ///< The plane is that of the radius and the axis.
  bool is_co_rotating = false;   ///< Velocities are mapped in the frame that turns with the body.
};

template <int Dim, class R>
class ParticleBody final : public Body<Dim> {
 public:
  /// Fills the body's region. Throws InputError for an empty body and for particles outside the grid. The grid must outlive the body.
  ParticleBody(const BodySpec& spec, const ParticleScheme& scheme, Grid<Dim, R>& grid);

  const std::string& name() const override { return name_; }
  Index particle_count() const override { return blocks_->count() + static_cast<Index>(outside_.size()); }
  void sweep(Sweep what, Real dt, Real flip) override;
  void set_body_force(const std::vector<Real>& values) override;
  Real body_force_power(const std::vector<Real>& values, Vec3& force) const override;
  void add_forces(const std::vector<Real>& values, const std::vector<Index>& ids, const Extent<Dim>& box) override;
  void take_points(const std::vector<std::int32_t>& places, std::vector<LoadedPoint<Dim>>& points) const override;
  void add_loads(const std::vector<std::int32_t>& places, const std::vector<std::size_t>& first,
                 const std::vector<PointForce<Dim>>& forces) override;
  Extent<Dim> extent() const override;
  bool is_co_rotating() const override { return scheme_.is_co_rotating; }
  void set_held(bool is_held) override { spin_.is_held = is_held; }
  std::vector<MovingPoint<Dim>> particles_in(const Extent<Dim>& box, const std::vector<Index>* candidates) const override;
  Real viscous_dissipation() const override { return material_->is_plastic() ? 0 : dissipated_; }
  Real plastic_dissipation() const override { return material_->is_plastic() ? dissipated_ : 0; }
  BadPoint bad_point() const override { return bad_point_; }
  void append_escapes(std::size_t body, std::vector<Escape>& escapes) const override;
  void remove_escaped(const Vec3& gravity, Ledger& ledger) override;
  void return_escaped(const std::vector<ClosedSide>& sides, const Vec3& gravity, Ledger& ledger) override;
  void note_inside(const std::vector<Obstacle>& obstacles) override;
  Index keep_out(const std::vector<Obstacle>& obstacles, const Vec3& gravity, Ledger& ledger) override;
  std::vector<NodeSurface<Dim>> surfaces(const TileNodes<Dim>& nodes) const override;
  void measure_reach(const TileNodes<Dim>& nodes, std::vector<NodeReach<Dim>>& reach) const override;
  void measure_gaps(const TileNodes<Dim>& nodes, int axis, bool is_upper, std::vector<Real>& gaps) const override;
  bool is_fluid() const override { return material_->is_fluid() && blocks_->layout().u < 0; }
  bool fills_space() const override { return blocks_->layout().u < 0; }
  Real kinematic_viscosity() const override { return material_->kinematic_viscosity(1); }
  Real correct(CorrectionPass pass, const Correction<Dim>& correction) override;
  std::vector<Real> node_lengths(int d) const override;
  Real stable_dt() const override;
  Real greatest_speed() const override;
  Real mass() const override { return mass_; }
  Real smallest_particle_mass() const override { return smallest_volume_ * material_->density(); }
  BodyTotals totals(const Vec3& gravity) const override;
  void clear() override;
  void declare_state(State& state) override;
  std::vector<std::string> field_names() const override;
  void take_fields(const std::vector<std::string>& names, std::size_t body, int vector_size, std::vector<Field>& fields) const override;
  void set_field(const std::string& name, const std::vector<Real>& values) override;
  Index memory() const override { return blocks_->memory() + call_.memory(); }
  Occupancy occupancy() const override;

 private:
  using Blocks = CellBlocks<Dim, R>;
  using Band = typename Blocks::Band;
  using Context = SweepContext<Dim, R>;

  /// One particle as the outputs see it; a view of its fields.
  struct Particle {
    const R* fields;
    int stride;
    Vec3 position;
    const R* tau = nullptr;  ///< Kirchhoff stress, with the stride of the fields, where it was made for all lanes of a slot at once.
    Real field(int f) const { return static_cast<Real>(fields[f * stride]); }
  };
  /// A particle outside of the grid: its fields and its stress, one after the other.
  struct Outside {
    std::vector<R> fields;
    Vec3 position;
  };
  /// Puts one back that is in the obstacle; false if it does not come out.
  bool push_out(R* fields, Vec3 position, const Obstacle& obstacle, const Vec3& gravity, Ledger& books) const;
  /// Puts one back, at a side for each axis along which it is outside; false if there is none.
  bool put_back(Outside& outside, const std::vector<ClosedSide>& sides, const Vec3& gravity, Ledger& ledger);
  /// Of one band and sweep.
  struct BandReport {
    Context context;
    BadPoint bad;
    Index moved = 0;  ///< Particles that left their cells.
  };

  /// What a law that is a function is given and gives, row by row in the order of ids.
  struct FunctionCall {
    int history_size = 0;
    bool has_fbar = false;
    std::vector<std::int32_t> rows;  ///< Of ids.
    std::vector<Real> F, L, history, tau;
    // With F-bar: the row of the first particle of those whose spherical stress is averaged with this one's, and its weight there.
    std::vector<std::int32_t> leaders;
    std::vector<Real> weights;
    Index memory() const {
      const std::size_t numbers = F.capacity() + L.capacity() + history.capacity() + tau.capacity() + weights.capacity();
      return static_cast<Index>(numbers * sizeof(Real) + (rows.capacity() + leaders.capacity()) * sizeof(std::int32_t));
    }
  };
  void start_function_call();
  static void collect_points(const void* law, LawChunk<Dim, R>& chunk);
  /// Calls the function and takes the forces. Throws what it throws.
  void call_function(Real dt, const Context& context);
  /// Kirchhoff stresses, 9 numbers each, into the particles.
  void store_stresses(const std::vector<Real>& tau);

  /// Where a total Lagrangian particle lies in memory, for good.
  struct Seat {
    const Block<Dim, R>* block = nullptr;
    int slot = 0;
    int lane = 0;
  };

  /// The rigid turn that has the body's angular momentum.
  struct Spin {
    bool is_used = false;
    bool is_held = false;  ///< What is held does not turn, whatever its particles' momenta say.
    // Angular momentum over mass as a mean over time, and means of means: the last is free of vibrations [m^2/s].
    std::array<Vec3, 4> means{};
    Real velocity_gradient[Dim][Dim] = {};  ///< Of it [1/s].
    Vec3 center{};                          ///< Where sums are taken about: the centre of mass, a step ago [m].
    void declare_state(State& state) {
      state.add("is_used", is_used);
      state.add("is_held", is_held);
      state.add("means", means);
      state.add("velocity_gradient", velocity_gradient);
      state.add("center", center);
    }
  };

  void seed(const BodySpec& spec, Grid<Dim, R>& grid);
  /// After a step of dt [s]; 0 at the start.
  void measure_spin(Real dt);
  template <class Shape>
  Real correct_with(CorrectionPass pass, const Correction<Dim>& correction);
  template <class Shape>
  std::vector<Real> node_lengths_with(int d) const;
  Context make_context(Real dt, Real flip) const;
  void sweep_band(Sweep what, std::size_t band_index, BandReport& report);
  /// Particles that wait, within their band, until the sweep has passed the block that they go to.
  struct Waiting {
    MovingParticles<Dim, R> row;    ///< In the plane that is being swept; 2D: in the band.
    MovingParticles<Dim, R> plane;  ///< In later planes.
  };
  void insert_near(Sweep what, Waiting& waiting, Band& band, const Block<Dim, R>& block, std::size_t begin);
  void insert_waiting(Sweep what, Waiting& waiting, Band& band, const Block<Dim, R>& last, const Block<Dim, R>& next);
  void insert_swept(Sweep what, MovingParticles<Dim, R>& list, Band& band, const Block<Dim, R>& last);
  bool insert_if_swept(Sweep what, Band& band, const Block<Dim, R>& last, const Place<Dim>& cell, const R* fields);
  void settle(Sweep what);
  void settle_band(Sweep what, std::size_t band, const std::vector<std::pair<std::size_t, std::size_t>>& arrivals);
  void map_arrival(Sweep what, const Block<Dim, R>& block, int lane, const R* fields);
  /// The shape functions of a cell of a direction.
  template <class Shape>
  Shape shape_at(int cell, int d) const {
    const bool is_far = grid_.is_periodic(d);
    const int before = is_far ? 2 : cell;
    const int after = is_far ? 2 : grid_.cells(d) - 1 - cell;
    return Shape(static_cast<R>(std::min(before, 2)), static_cast<R>(std::min(after, 2)), static_cast<R>(reach_));
  }
  /// Of the particle with the fields in a cell, or of a place beside it, by an arm in cell sides.
  template <class Shape>
  ParticleWeights<Dim, R, Shape> weights_of(const Block<Dim, R>& block, int lane, const R* fields, int stride,
                                            const R* arm = nullptr) const;
  template <class Shape>
  void map_arrival_with(Sweep what, const Block<Dim, R>& block, int lane, const R* fields);
  SweepVariant variant() const;
  /// Calls f(i, index, block, lane) for each of the cells around the i-th node; index: the number of the node among the cell's, by
  /// direction.
  template <class F>
  void for_each_cell_around(const TileNodes<Dim>& nodes, F&& f) const;
  template <class Shape>
  void add_forces_with(const std::vector<Real>& values, const std::vector<Index>& ids, const Extent<Dim>& box);
  template <class Shape>
  void add_force_with(const Block<Dim, R>& block, int lane, const R* fields, const Real* force);
  template <class Shape>
  void add_loads_with(const std::vector<std::int32_t>& places, const std::vector<std::size_t>& first,
                      const std::vector<PointForce<Dim>>& forces);
  /// Of a total Lagrangian body.
  const std::vector<Seat>& seats() const;
  /// Calls f(block, slot, lane) for the particles of a band whose cells are in or beside the box; of total Lagrangian bodies, for all.
  template <class F>
  void for_each_place_near(const Band& band, const Extent<Dim>& box, F&& f) const;
  template <class Shape>
  void add_surfaces(const TileNodes<Dim>& nodes, std::vector<NodeSurface<Dim>>& sums, std::vector<Real>& masses) const;
  void keep_outside(const MovingParticles<Dim, R>& leaving, std::size_t i);
  void collect(Sweep what, const std::vector<BandReport>& reports);
  /// Calls f(band, ...) for all even bands, then for all odd ones.
  template <class F>
  void for_each_band(F&& f);

  template <class F>
  void for_each_particle(F&& f) const;
  /// The same on all threads: f must not touch what it touches for another particle.
  template <class F>
  void for_each_particle_in_parallel(F&& f) const;
  /// Calls f(particle) for all in a band, with their stresses made by the law's kernel where it follows from F.
  template <class F>
  void for_each_with_stress(const Band& band, F&& f) const;
  Particle particle_of(const Outside& outside) const { return {outside.fields.data(), 1, outside.position}; }
  Index id(const Particle& p) const { return id_from_bits(p.fields[blocks_->layout().id * p.stride]); }
  // What gather_fields (particle_fields.hpp) asks for.
  template <class Of, class ForEach>
  friend void gather_fields(const Of&, const WantedFields&, Real, std::size_t, std::vector<Field>&, ForEach&&);
  Vec3 position(const Particle& p) const { return p.position; }
  /// Of the particle with the fields, whose place in the cells is `place`.
  Vec3 position_of(const R* fields, int stride, Vec3 place) const;
  Vec3 velocity(const Particle& p) const;
  Vec3 displacement(const Particle& p) const;
  Real volume0(const Particle& p) const;
  Material::Matrix deformation_gradient(const Particle& p) const;
  PointHistory history(const Particle& p) const;
  Real remembered(const Particle& p, int place) const { return p.field(blocks_->layout().history + place); }
  Real J(const Particle& p) const;
  std::array<Real, 6> cauchy_stress(const Particle& p) const;
  Material::Matrix affine_velocity(const Particle& p) const;
  BodyTotals totals_of(const Particle& p, const Vec3& gravity) const;
  void set_velocity(const std::vector<Real>& values);
  void set_deformation_gradient(const std::vector<Real>& values);
  void set_stress(const std::vector<Real>& values);
  void set_affine_velocity(const std::vector<Real>& values);
  void set_position(const std::vector<Real>& values);
  /// Kirchhoff stresses [Pa], six components a row, at the deformation gradients F, nine numbers a row, without rates.
  std::vector<Real> stresses_at_rest(const std::vector<Real>& F);
  /// Calls f(fields, stride, row) for all particles; row: place in the fields that are handed out.
  template <class F>
  void change_each_particle(F&& f) {
    change_each_particle(rows_of_ids(), f);
  }
  template <class F>
  void change_each_particle(const std::vector<std::int32_t>& rows, F&& f);
  /// What the stable time step depends on, from the particles as they are.
  void measure_extremes();
  /// Row of each id in the fields that are handed out, or -1 for ids that were removed.
  std::vector<std::int32_t> rows_of_ids() const;

  std::string name_;
  std::shared_ptr<Material> material_;
  ParticleScheme scheme_;
  Grid<Dim, R>& grid_;
  const KernelTable<Dim, R>& kernels_;
  std::unique_ptr<Blocks> blocks_;
  std::vector<Outside> outside_;
  Index id_count_ = 0;
  Real uniform_volume_ = 0;
  Real smallest_volume_ = 0;
  bool has_fbar_ = false;
  Real reach_ = 0;  ///< Half of a particle's domain at rest, in cell sides, for GIMP and CPDI: one for the body.
  Real mass_ = 0;
  Spin spin_;
  int sweeps_since_prune_ = 0;
  FunctionCall call_;                    ///< Of the last sweep; the next one uses its memory.
  std::vector<std::set<Index>> inside_;  ///< Per obstacle: ids that were in it at the start.
  mutable std::vector<Seat> seats_;      ///< By id; made when first asked for.

  std::vector<BandReport> reports_;
  std::vector<std::vector<std::pair<std::size_t, std::size_t>>> arrivals_;  ///< Per band: (band, index) of the particles that come.
  Real dissipated_ = 0;                                                     ///< By the law in the last step [J].
  BadPoint bad_point_;
  Index moved_ = 0;
  Real speed_max_[Dim] = {};
  Real J_min_ = 1;
  Real J_max_ = 1;
  Real wave_modulus_ = 0;  ///< The greatest rho0 c^2 [Pa], of a law that knows it.
};

template <int Dim, class R>
template <class F>
void ParticleBody<Dim, R>::change_each_particle(const std::vector<std::int32_t>& rows, F&& f) {
  const auto row_of = [&](const Particle& p) { return static_cast<std::size_t>(rows[static_cast<std::size_t>(id(p))]); };
  // The particles are this body's own; a view of them is constant only for the outputs.
  for_each_particle([&](const Particle& p) { f(const_cast<R*>(p.fields), p.stride, row_of(p)); });
}

template <int Dim, class R>
template <class F>
void ParticleBody<Dim, R>::for_each_particle(F&& f) const {
  for (const Band& band : blocks_->bands()) {
    blocks_->for_each(band, [&](const R* fields, const Vec3& place) {
      f(Particle{fields, k_lanes<R>, position_of(fields, k_lanes<R>, place)});
    });
  }
  for (const Outside& outside : outside_) f(particle_of(outside));
}

template <int Dim, class R>
template <class Shape>
ParticleWeights<Dim, R, Shape> ParticleBody<Dim, R>::weights_of(const Block<Dim, R>& block, int lane, const R* fields, int stride,
                                                                const R* arm) const {
  const SlotLayout<Dim>& at = blocks_->layout();
  Shape shapes[Dim];
  R x[Dim], edges[Dim][Dim];
  for (int d = 0; d < Dim; ++d) {
    shapes[d] = shape_at<Shape>(block.first[static_cast<std::size_t>(d)] + (d == 0 ? lane : 0), d);
    x[d] = fields[(at.x + d) * stride] + (arm != nullptr ? arm[d] : R(0));
    for (int k = 0; k < Dim; ++k) {
      const R F = at.u >= 0 ? static_cast<R>(d == k) : fields[(at.F + d * Dim + k) * stride];
      edges[d][k] = F * static_cast<R>(reach_ * grid_.cell_size(k) / grid_.cell_size(d));
    }
  }
  return {shapes, x, edges};
}

template <int Dim, class R>
template <class F>
void ParticleBody<Dim, R>::for_each_band(F&& f) {
  const Index bands = static_cast<Index>(blocks_->bands().size());
  // Tiles at periodic sides belong to far bands, which then must not be worked at the same time.
  const Index work = grid_.has_periodic() ? 0 : blocks_->count();
  for (Index parity = 0; parity < 2; ++parity) {
    parallel_for((bands + 1 - parity) / 2, work, [&](Index k) { f(static_cast<std::size_t>(2 * k + parity)); });
  }
}

}  // namespace matpoint
