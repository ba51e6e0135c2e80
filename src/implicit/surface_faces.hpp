// Ghost penalty: what keeps functions calm that reach into the body by a thin cut only.
//
// Where the surface of a body cuts a cell thinly, few particles in a corner of the cell are all that a function of the cell beside it sees.
// They do not determine it: it swings, and these particles are torn. So on the faces between the cells at the surface and their neighbours
// jumps of the second derivative across the face are penalised, which quadratic splines have and smooth fields do not,
//
//     r_I += gamma mu e h^3 int [d_nn u] [d_nn N_I] dA        on the displacements of the step,
//
// with e the empty share of the emptier of the two cells. Such a function then goes on as the polynomial of the cell inside, however thin
// the cut. Not across the end of a condition, which is no polynomial of the body: a body that comes near a side would be braked. What it
// takes is booked with the soft stiffness. Burman 2010; for material points Coombs, Ghost stabilisation of the material point method, IJNME
// 124:4841 (2023), who penalises first derivatives of elements.
#pragma once

#include "implicit/step_space.hpp"

namespace matpoint {

template <int Dim>
struct SurfaceFace {
  std::size_t source = 0;
  std::size_t cells[2] = {0, 0};  ///< Places among the space's cells.
  Real emptiness = 1;             ///< Share of the emptier cell that no particle fills [1].
  std::vector<int> nodes;         ///< Active nodes of both cells, ascending.
  std::vector<Real> stiffness;    ///< By pair of nodes, times the identity, for a shear modulus of 1 [m^(dim-2)].
  std::vector<int> row_offset;    ///< As VolumePatch's.
};

/// Empty for elements, which have jumps of their own.
template <int Dim>
std::vector<SurfaceFace<Dim>> surface_faces(const StepSpace<Dim>& space);
/// How empty the cells are now.
template <int Dim>
void measure_emptiness(const StepSpace<Dim>& space, std::vector<SurfaceFace<Dim>>& faces);

}  // namespace matpoint
