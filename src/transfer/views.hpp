// Trivially copyable views that the transfer kernels work on, and the layout of the grid's records.
//
// A node's record is 8 reals wide in 2D and 3D, so that a contribution is one or two vector operations:
//   mapped: mass, momentum[Dim], force[Dim], padding        (summed by P2G)
//   motion: velocity[Dim], acceleration[Dim], padding       (made by the momentum equation, read by G2P; 4 wide in 2D)
#pragma once

#include <cstdint>

#include "core/types.hpp"

namespace matpoint {

constexpr int k_mapped_width = 8;

template <int Dim>
constexpr int k_motion_width = Dim == 2 ? 4 : 8;

/// Independent components of a symmetric tensor that a body stores: xx yy zz xy, and yz xz in 3D.
template <int Dim>
constexpr int k_stress_size = Dim == 2 ? 4 : 6;

/// Where the stress component (row, column) is stored.
constexpr int stress_index(int row, int column) { return row == column ? row : row + column == 1 ? 3 : row + column == 3 ? 4 : 5; }

template <int Dim>
struct GridView {
  Real lower[Dim];              ///< [m]
  Real upper[Dim];              ///< [m]
  Real cell_size[Dim];          ///< [m]
  Real inverse_cell_size[Dim];  ///< [1/m]
  int cells[Dim];
  bool is_periodic[Dim];
  Index stride[Dim];            ///< Nodes between neighbours in each direction.
  Real* mapped;
  const Real* motion;
};

/// Pointers to the fields of a body, one array per component.
template <int Dim>
struct ParticleView {
  Real* x[Dim];
  Real* v[Dim];
  Real* F[Dim * Dim];
  Real* tau[k_stress_size<Dim>];
  Real* displacement[Dim];  ///< Scratch of schemes that move the particles in a later pass.
  const Real* mass;
  const Real* volume0;
};

/// Cell and place within the cell along one direction. Coordinates beyond the grid (or nan) are put into the nearest cell: the caller
/// has reported such a particle, and here it must only not touch foreign memory.
template <int Dim>
inline int locate_in_cell(const GridView<Dim>& grid, int d, Real x, Real& xi) {
  Real place = (x - grid.lower[d]) * grid.inverse_cell_size[d];
  place = place > 0 ? place : 0;
  const Real last = static_cast<Real>(grid.cells[d] - 1);
  const int cell = static_cast<int>(place < last ? place : last);
  xi = place - static_cast<Real>(cell);
  xi = xi < 1 ? xi : 1;
  return cell;
}

}  // namespace matpoint
