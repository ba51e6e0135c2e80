// The problem that the benchmark times: two elastic disks (spheres in 3D) that touch, move towards each other, turn and stretch, so
// that every particle has stress from the first step on.
#pragma once

#include <string>

#include "case/case.hpp"
#include "plain_loop.hpp"

namespace matpoint::bench {

/// Lattice: 2 particles per cell along each direction. Jitter: each of them moved at random by up to half their spacing.
enum class Arrangement { lattice, jitter };

/// A scene of about `particles` particles in 2 or 3 dimensions.
Scene make_scene(int dim, Arrangement arrangement, std::size_t particles);

/// The same problem for the library's solver.
Case make_case(const Scene& scene, StressOrder order);

}  // namespace matpoint::bench
