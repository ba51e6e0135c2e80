// Nearly incompressible bodies: the volume change of a step is projected, over patches of cells, onto few functions, and the law sees the
// projected one. Without that each particle asks for its own volume to be kept, and there are more of them than the displacements can do:
// the body locks, and its pressures mean nothing.
//
// With A the deformation of a particle in the step, j = det A, and Pi the projection by reference volumes onto 1, x, y(, z) within a patch
// (onto 1 where its particles lie in too few places, and on elements of first order),
//   A' = (Pi j / j)^(1/dim) A          goes to the law in place of A, and into F <- A' F at the end of the step,
//   r_I = sum_p V0 [S^ + pi j A^-T] g_I,   S^ = s S'(A') - (t/dim) A^-T,   t = S' : A',   pi = Pi (t / (dim Pi j)),
// which is the derivative of the energy sum V0 W(A' F) in the displacements, so the matrix is symmetric where the law's is. A patch is one
// element, or a block of two B-spline cells in each direction: three conditions for the eight displacements that it brings along in 2D.
//
// F-bar: de Souza Neto et al. 1996; over patches of cells: de Souza Neto, Pires & Owen 2005; the projection as the derivative of an energy:
// Simo, Taylor & Pister 1985; linear pressure on nine-node elements: Hughes, The Finite Element Method (1987), sec. 4.4 and 4.5.
#pragma once

#include "implicit/step_space.hpp"

namespace matpoint {

template <int Dim>
struct VolumePatch {
  std::size_t source = 0;
  std::vector<std::size_t> cells;  ///< Places among the space's cells.
  std::vector<int> nodes;          ///< Active nodes, ascending.
  std::vector<int> local;          ///< By cell and function: place in `nodes`.
  std::vector<int> row_offset;     ///< By pair of nodes (I, K): place of I's rows in the columns of K (Assembly).
  int modes = 1;                   ///< Functions of the projection.
  std::vector<Real> psi;           ///< By particle, cell by cell, and function; orthonormal by reference volume [m^(-dim/2)].
};

template <int Dim>
class VolumePatches {
 public:
  /// Of the sources that ask for it; `width` cells in each direction, and more than the mean where `is_linear`.
  VolumePatches(const StepSpace<Dim>& space, int width, bool is_linear);

  bool is_empty() const { return !has_any_; }
  /// Cells and nodes anew; when the space's pattern has changed.
  void gather();
  /// The functions at the particles where they are now.
  void evaluate();

  std::vector<VolumePatch<Dim>>& all() { return patches_; }
  const std::vector<VolumePatch<Dim>>& all() const { return patches_; }
  /// Whether a cell belongs to a patch.
  bool holds(std::size_t cell) const { return has_any_ && space_.sources()[space_.source_of(cell)].has_fbar; }

 private:
  const StepSpace<Dim>& space_;
  int width_;
  bool is_linear_;
  bool has_any_;
  Vec<Dim> first_{};  ///< Corner of the background [m].
  Vec<Dim> size_{};   ///< Of a patch [m].
  std::vector<VolumePatch<Dim>> patches_;
};

}  // namespace matpoint
