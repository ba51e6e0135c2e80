// What bodies, grids and solvers say about themselves: to the outputs, the checks and Python.
#pragma once

#include "core/state.hpp"
#include "core/types.hpp"

namespace matpoint {

/// Sums and extremes over the particles of one body at one time. SI units, per metre of thickness in 2D.
struct BodyTotals {
  Index particle_count = 0;
  Real mass = 0;
  Vec3 momentum{};
  Vec3 center_of_mass{};
  Real kinetic_energy = 0;
  Real strain_energy = 0;         ///< Sum of W(F) V0: the stored energy, never 1/2 sigma : eps.
  Real gravitational_energy = 0;  ///< -m g . x
  Real von_mises_max = 0;
  Vec3 lower{};  ///< Extent of the particle positions [m].
  Vec3 upper{};
  Real J_min = 1;
  Real J_max = 1;
};

/// What one boundary does to the bodies.
struct BoundaryTotals {
  std::string name;  ///< Of the boundary, or of its side.
  Vec3 force{};      ///< On the bodies, in the last step [N].
  Vec3 impulse{};    ///< Sum of force times time since the start [N s]; 0 without inertia.
  Real work = 0;     ///< Done on the bodies since the start [J].
  void declare_state(State& state) {
    state.add("force", force);
    state.add("impulse", impulse);
    state.add("work", work);
  }
};

/// How the particles lie in memory: what the speed of a step depends on (docs/performance.md).
struct Occupancy {
  Index lanes = 0;        ///< Places for particles that a sweep works, empty ones too.
  Index moved = 0;        ///< Particles that changed their cell in the last step.
  Index state_bytes = 0;  ///< What all particles keep from one step to the next.
};

/// A particle that left the grid in the last step.
struct Escape {
  std::size_t body = 0;
  Index id = 0;
  Vec3 position{};
  Vec3 velocity{};
};

/// A number that a solver tells about its last step, for the history.
struct StepNumber {
  std::string name;
  std::string unit;
  Real value = 0;
};

/// One thing that a run says about itself at its end, with a verdict.
struct HealthLine {
  std::string name;  ///< "energy", "momentum", "volume of water", ...
  std::string text;  ///< What was measured, in words.
  bool is_good = true;
  std::string remedy;  ///< What would do, where it is not good.
};

/// The cells of a body of finite elements, for output.
struct BodyCells {
  int vtk_type = 1;  ///< VTK's number of their shape; 1 is a vertex.
  Index nodes_per_cell = 1;
  std::vector<Index> nodes;  ///< Of each cell, in VTK's order: rows of the body's nodal fields.
};

/// The grid's nodes as a whole, for output.
struct GridGeometry {
  Vec3 lower{};
  Vec3 cell_size{};
  std::array<int, 3> nodes{1, 1, 1};
};

}  // namespace matpoint
