// The problem that the benchmark times: two elastic disks (spheres in 3D) that touch, move towards each other, turn and stretch, so
// that every particle has stress from the first step on.
#pragma once

#include <string>

#include "case/case.hpp"
#include "plain_loop.hpp"

namespace matpoint::bench {

/// Lattice: 2 particles per cell along each direction. Jitter: each of them moved at random by up to half their spacing. Random: as many,
/// anywhere in the bodies.
enum class Arrangement { lattice, jitter, random };

struct SceneSpec {
  int dim = 2;
  Arrangement arrangement = Arrangement::lattice;
  std::size_t particles = 0;  ///< Wanted; a scene has the next number that its lattice gives.
  double gap = 1;             ///< Between the bodies, in cells: with less than 2 they share nodes, so contact is part of the work.
  double box_factor = 1;      ///< The grid has so many times the cells that the bodies need.
  bool is_at_rest = false;    ///< Then hardly any particle changes its cell.
};

Scene make_scene(const SceneSpec& spec);

/// The same problem for the library's solver, with the scene's elastic law or another one (density and parameters in the input).
Case make_case(const Scene& scene, const SolverSpec& solver, const std::optional<Input>& law = {});

}  // namespace matpoint::bench
