// The surface of a body of particles before the first step: the free faces of the boxes that its particles fill.
#pragma once

#include "geometry/layout.hpp"

namespace matpoint {

/// A face of a particle's box that no other particle's box touches.
struct SeedFace {
  std::size_t seed = 0;  ///< Of the particle, among the seeds.
  int axis = 0;
  bool is_upper = false;  ///< Whether the outward normal points along the axis, or against it.
  Vec3 center{};          ///< [m]
  Real area = 0;          ///< [m^2], per metre of thickness in 2D.
  Real depth = 0;         ///< Of the particle behind the face, as its volume has it [m].
};

/// The free faces, in the order of the seeds. The faces of a region that is a box are its own, so that their areas are exact wherever the
/// lattice lies in it; of other regions they are those of the lattice's boxes, a staircase, whose areas along each axis are those of the
/// body's shadow to half a box. `region` may be null. Throws InputError for seeds that are not one in each box of a lattice.
std::vector<SeedFace> surface_of(const Seeds& seeds, const Region* region, int dim);

}  // namespace matpoint
