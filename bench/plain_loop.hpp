// The yardstick of the benchmark: explicit MPM as a textbook or a thesis writes it, one struct per particle and per node and plain
// loops over them. It shares nothing with the library but the physics: linear shape functions or quadratic B-splines (away from the
// sides of the grid), lumped mass, FLIP, Neo-Hookean,
// plane strain in 2D, no loads and no boundary conditions. Standard headers only, for its source is compiled for the building host alone.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <vector>

namespace matpoint::bench {

/// The problem that both programs solve. The grid begins at the origin and has cubic cells.
struct Scene {
  int dim = 2;
  double cell_size = 0;                                        ///< [m]
  std::array<int, 3> cells{1, 1, 1};                           ///< Cells per direction.
  std::array<std::vector<std::array<double, 3>>, 2> position;  ///< Of each body's particles [m].
  std::array<std::vector<std::array<double, 3>>, 2> velocity;  ///< [m/s]
  double gap = 0;                                              ///< Between the bodies [m].
  bool is_at_rest = false;                                     ///< All velocities are zero.
  double volume = 0;                                           ///< Of one particle [m^3].
  double density = 0;                                          ///< [kg/m^3]
  double youngs_modulus = 0;                                   ///< [Pa]
  double poissons_ratio = 0;                                   ///< [1]
  double mass_cutoff = 0;                                      ///< Nodes with less mass do not move [kg].
  double dt = 0;                                               ///< [s]

  std::size_t particle_count() const { return position[0].size() + position[1].size(); }
};

/// Textbook: every shape function is evaluated where it is used, from the distance of particle and node, as the formulas are written.
/// Tuned: the cell's index and the weights along each direction once per particle and mapping, without divisions.
enum class PlainStyle { textbook, tuned };

/// When the stress is updated within a step: after it, before it, or after it from velocities that were mapped once more.
enum class PlainOrder { usl, usf, musl };

enum class PlainShape { linear, bspline2 };

class PlainLoop {
 public:
  virtual ~PlainLoop() = default;
  virtual void step() = 0;
  virtual double kinetic_energy() const = 0;  ///< [J]
  virtual double strain_energy() const = 0;   ///< [J]
  virtual std::size_t memory() const = 0;     ///< Bytes of particles and nodes.
};

/// Both bodies in one array, in the order of the cells.
std::unique_ptr<PlainLoop> make_plain_loop(const Scene& scene, PlainOrder order, PlainShape shape, PlainStyle style);

}  // namespace matpoint::bench
