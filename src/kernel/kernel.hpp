// What the kernels work on: blocks of particles, tiles of the grid, and the table of compiled kernels.
//
// The idea (docs/performance.md): a SIMD lane is a cell. A block is `k_lanes` neighbouring cells of one row of the grid; its slot k holds
// the k-th particle of each of its cells, one per lane, and a field of a slot is one aligned run of `k_lanes` numbers:
//
//     slot 0   x: [cell 0 | cell 1 | ... | cell 7]   y: [...]   vx: [...]   ...
//     slot 1   x: [cell 0 |   -    | ... | cell 7]   ...            (cell 1 holds one particle only)
//
// A tile holds the nodes of a row in the same way. All lanes of a slot need the node at the same offset from their own cell, so a
// particle's node values are the tile's values, shifted by one lane: no gather, no scatter, no index arithmetic.
//
// Positions are local: xi in [0, 1) is the place in the cell, in cell sides.
#pragma once

#include "core/types.hpp"
#include "kernel/shape_kind.hpp"

namespace matpoint {

/// Cells in a block and nodes in a tile: 64 bytes of numbers.
template <class R>
constexpr int k_lanes = 64 / static_cast<int>(sizeof(R));

/// Particles keep so far away from the sides of their cells, in cell sides. One exactly on a line of the grid has no weight at the nodes
/// behind it, but its functions have a slope there: such a node has no mass, so no velocity, and the particle would be strained by flying.
template <class R>
constexpr R k_off_line = sizeof(R) == 8 ? R(1e-9) : R(1e-6);

/// Independent components of a symmetric tensor: xx yy zz xy, and yz xz in 3D.
template <int Dim>
constexpr int k_stress_size = Dim == 2 ? 4 : 6;

/// Where the stress component (row, column) is stored.
constexpr int stress_index(int row, int column) { return row == column ? row : row + column == 1 ? 3 : row + column == 3 ? 4 : 5; }

/// Rows of nodes around a cell, for shapes of a span.
template <int Dim>
constexpr int rows_of(int span) {
  return Dim == 2 ? span + 1 : (span + 1) * (span + 1);
}
template <int Dim>
constexpr int k_rows_max = rows_of<Dim>(k_span_max);

/// Slots that one call of a kernel works: their stresses and velocity gradients stay in the first-level cache.
constexpr int k_chunk_slots = 8;

/// Packs in 64 bytes of the narrowest instruction set, 16 bytes.
constexpr int k_parts_max = 4;

/// The numbers of `k_lanes` neighbouring nodes of a row.
template <int Dim, class R>
struct alignas(64) NodeValues {
  using Lanes = R[k_lanes<R>];
  Lanes mass;
  Lanes momentum[Dim];
  Lanes force[Dim];
  Lanes velocity[Dim];
  /// Acceleration; in the second mapping of MUSL and USF the velocity that the gradient is taken of; of FMPM the last term of the velocity.
  Lanes second[Dim];
  Lanes moved_mass;  ///< The mass that `velocity` belongs to; `mass` is that of the next step by then.
};

/// Where the fields are in a slot, as multiples of `k_lanes` numbers; -1: the body does not store it.
template <int Dim>
struct SlotLayout {
  static constexpr int x = 0;        ///< dim fields, local coordinates.
  static constexpr int v = Dim;      ///< dim fields [m/s].
  static constexpr int F = 2 * Dim;  ///< dim x dim fields, row by row.
  int id = 0;                        ///< The id's bits; the last field that sweeps need.
  int volume = -1;                   ///< Reference volume [m^3], where it differs between particles.
  int tau = -1;                      ///< Kirchhoff stress [Pa] of laws that depend on the rate.
  int C = -1;                        ///< Affine part of the velocity [1/s], dim x dim fields, row by row.
  int u = -1;                        ///< Displacement [m], dim fields, of bodies whose x is their place in the reference configuration.
  int b = -1;                        ///< Body force per mass [m/s^2], dim fields.
  int hoop = -1;                     ///< Stretch around the axis [1], where the plane is that of the radius and the axis.
  int start = -1;  ///< Position at the start, from the grid's lower corner [m], dim fields, where the displacement is asked for.
  int history = -1;
  int history_count = 0;
  int field_count = 0;
};

/// The stages of a step that one sweep over the particles does. The three stress orders are sequences of sweeps (explicit_solver.cpp).
enum class Sweep {
  start,           ///< Stress from the state, mass + momentum + force to the grid.
  start_momentum,  ///< Mass + momentum to the grid.
  usl,             ///< Velocity, gradient, F, stress, position; mass + momentum + force for the next step.
  musl_velocity,   ///< Velocity; momentum to the grid.
  musl_gradient,   ///< Gradient, F, stress, position; mass + momentum + force for the next step.
  usf_stress,      ///< Gradient, F, stress; force to the grid.
  usf_velocity,    ///< Velocity, position; mass + momentum for the next step.
  force,           ///< Force to the grid, from the stress that the particles have.
  refine,          ///< FMPM: `second` to the particles, and from there as momentum to the grid; they keep nothing of it.
};
constexpr int k_sweep_count = 9;

/// Some slots of a block, for a law.
template <int Dim, class R>
struct LawChunk {
  R* const* slots = nullptr;
  const R* counts = nullptr;          ///< Per lane: slots below this hold a particle.
  const int* slots_in_use = nullptr;  ///< Per pack of lanes.
  const SlotLayout<Dim>* layout = nullptr;
  R uniform_volume = 0;       ///< [m^3], unless the layout has volumes.
  Real dt = 0;                ///< [s]
  const R* L = nullptr;       ///< Velocity gradient [1/s], [slot][dim x dim][lane]; null: it is zero and F stays.
  const R* L_hoop = nullptr;  ///< v_r / r [1/s], [slot][lane], where the layout has `hoop`.
  R* tau = nullptr;           ///< Out: Kirchhoff stress [Pa], [slot][k_stress_size][lane].
  R* J_min = nullptr;         ///< In and out, per lane.
  R* J_max = nullptr;
  R* wave_modulus = nullptr;  ///< The greatest rho0 c^2 [Pa], of a law that knows it.
  Real dissipated = 0;        ///< Out: dissipation [J].
  int bad_slot = -1;          ///< Out: first slot with a particle whose det F is not positive and finite,
  int bad_lane = -1;          ///< and its lane.
};

template <int Dim, class R>
using LawKernel = void (*)(const void* law, LawChunk<Dim, R>& chunk);

/// A particle that has left its cell, as the kernel found it.
template <class R>
struct Mover {
  int slot;
  int lane;
  R tau[6];
};

/// Memory that will be needed soon, in lines of 64 bytes.
struct FetchRun {
  const char* begin;
  const char* end;
};

/// Some slots of a block, for a sweep.
template <int Dim, class R>
struct SweepChunk {
  int slot_count = 0;
  R* slots[k_chunk_slots] = {};
  FetchRun fetch[k_chunk_slots + k_rows_max<Dim>];  ///< Slots and tiles of a block that comes soon, and its header.
  int fetch_count = 0;
  alignas(64) R counts[k_lanes<R>] = {};          ///< Per lane: slots below this hold a particle.
  int slots_in_use[k_parts_max];                  ///< Per pack of lanes; the kernel fills it.
  int cell[Dim];                                  ///< The cell of lane 0.
  NodeValues<Dim, R>* nodes[k_rows_max<Dim>][2];  ///< The block's tile and the next one, per row of nodes.
  Mover<R> movers[k_chunk_slots * k_lanes<R>];    ///< Out.
  int mover_count = 0;                            ///< Out.
  int bad_slot = -1;                              ///< Out, as in LawChunk.
  int bad_lane = -1;
};

/// What is the same for all chunks of a body in a sweep, and what is summed over them.
template <int Dim, class R>
struct SweepContext {
  SlotLayout<Dim> layout;
  R density = 0;
  R uniform_volume = 0;
  Real dt = 0;
  R flip = 1;
  R inverse_cell_size[Dim] = {};
  int cells[Dim] = {};          ///< Of the grid.
  bool is_periodic[Dim] = {};   ///< Shape functions go on across the two sides.
  R reach[Dim] = {};            ///< Half of a particle's domain at rest, in cell sides, for GIMP and CPDI.
  R axis = 0;                   ///< Where r = 0, in cells from the grid's lower corner; not above 0.
  bool has_fbar = false;        ///< Particles of a cell change their volume at one rate.
  bool is_affine_full = false;  ///< The affine part is the velocity gradient (TPIC), not APIC's least-squares slope.
  bool has_spin = false;        ///< All particles of the body have one affine part: that of a rigid turn.
  R spin[Dim][Dim] = {};        ///< [1/s]
  const void* law = nullptr;
  LawKernel<Dim, R> law_kernel = nullptr;
  // Sums and extremes; the caller starts them.
  alignas(64) R speed_max[Dim][k_lanes<R>] = {};
  alignas(64) R J_min[k_lanes<R>];
  alignas(64) R J_max[k_lanes<R>];
  alignas(64) R wave_modulus[k_lanes<R>] = {};
  Real dissipated = 0;
};

/// The momentum equation on a tile, and what it books.
template <int Dim>
struct NodalDynamics {
  Vec<Dim> gravity{};    ///< [m/s^2]
  Real damping = 0;      ///< alpha in f_d = alpha m v [1/s]; Li et al. (2018)
  Real mass_cutoff = 0;  ///< Nodes with less mass [kg] do not move.
  Real flip = 1;         ///< The particles' FLIP share, for the books of impulse.
};

template <int Dim>
struct NodalSums {
  Real damping_dissipation = 0;
  Vec<Dim> damping_impulse{};
  Vec<Dim> cutoff_impulse{};
};

/// Sweeps are compiled for each shape. The `plain` ones with linear shapes have no affine part, no displacements and no body forces of
/// particles, and are the fastest; the others look what the particles have.
enum class SweepVariant { linear_plain, linear, bspline2, bspline3, gimp, cpdi };
constexpr int k_variant_count = 6;

/// All kernels of one instruction set. Chosen once, at set-up.
template <int Dim, class R>
struct KernelTable {
  using SweepKernel = void (*)(SweepContext<Dim, R>&, SweepChunk<Dim, R>&);
  SweepKernel sweeps[k_variant_count][k_sweep_count];
  /// v = p/m, a = 0 on nodes above the cutoff, into velocity; or into `second`.
  void (*advance)(NodeValues<Dim, R>&, const NodalDynamics<Dim>&, Real dt, const R* booked, NodalSums<Dim>&);
  void (*map_velocity)(NodeValues<Dim, R>&, const NodalDynamics<Dim>&);
  /// Zeroes momentum and force, and the mass unless it is kept.
  void (*clear)(NodeValues<Dim, R>&, bool keeps_mass);
};

/// Instruction sets, best first, that this program has kernels for and this processor can run; "avx512", "avx2", "base".
std::vector<std::string> available_instruction_sets();

/// The one in use: the best, or the one that the environment variable MATPOINT_SIMD names. Throws InputError for one that is not
/// available.
const std::string& instruction_set();

template <int Dim, class R>
const KernelTable<Dim, R>& kernel_table();

/// The kernel of a law by its place in AllLaws, for the instruction set in use.
template <int Dim, class R>
LawKernel<Dim, R> law_kernel(int law_index);

}  // namespace matpoint
