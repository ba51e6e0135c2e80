// Convected particle domains (CPDI; Sadeghirad, Brannon & Burghardt 2011). A particle's box turns and stretches with F into a
// parallelepiped with the edges 2 R, R = F R_0. Within it a nodal function is replaced by the one that is linear in each edge and has
// its values at the corners x_c = x + R s_c, s_c = (+-1, ...). Means over the domain are then
//
//     N_i = 1/n sum_c S_i(x_c),     grad N_i = R^-T 1/n sum_c s_c S_i(x_c),     S_i: the multilinear functions.
//
// Not products of one function per direction, so a file of their own. As those of GIMP, the domains end at the sides of the grid, and
// reach no further than one cell beyond the particle's own: longer ones are shortened (Homel, Brannon & Guilkey 2016). R is that of the
// corners that are left, so the gradients of linear functions stay exact.
#pragma once

#include "kernel/shape.hpp"

namespace matpoint {
namespace {

template <int Dim, class T>
struct ConvectedDomain {
  static constexpr int k_corners = 1 << Dim;
  static constexpr int k_nodes = ShapeConvected<T>::k_nodes;
  T corner[k_corners][Dim];  ///< In cell sides from the lower corner of the cell.
  T inverse[Dim][Dim];       ///< R^-1

  ConvectedDomain() = default;
  /// R in cell sides, half an edge per column; x: the place in the cell.
  MPM_SHAPE_INLINE ConvectedDomain(const ShapeConvected<T>* shapes, const T* x, const T (&R)[Dim][Dim]) {
    T ends[Dim][Dim];
    for (int d = 0; d < Dim; ++d) {
      T reach = abs(R[d][0]);
      for (int k = 1; k < Dim; ++k) reach += abs(R[d][k]);
      const T scale = T(1) / max(reach, T(1));
      // What has left its cell has no mass here any more, but must stay finite.
      const T centre = min(max(x[d], T(0)), T(1));
      for (int k = 0; k < Dim; ++k) ends[d][k] = T(0);
      for (int c = 0; c < k_corners; ++c) {
        T place = T(0);
        for (int k = 0; k < Dim; ++k) place = is_upper(c, k) ? place + R[d][k] : place - R[d][k];
        corner[c][d] = min(max(centre + scale * place, shapes[d].lower), shapes[d].upper);
        for (int k = 0; k < Dim; ++k) ends[d][k] = is_upper(c, k) ? ends[d][k] + corner[c][d] : ends[d][k] - corner[c][d];
      }
      for (int k = 0; k < Dim; ++k) ends[d][k] *= T(1.0 / k_corners);
    }
    invert(ends);
  }

  MPM_SHAPE_INLINE static constexpr bool is_upper(int c, int k) { return ((c >> k) & 1) != 0; }

  MPM_SHAPE_INLINE T centre(int d) const {
    T sum = corner[0][d];
    for (int c = 1; c < k_corners; ++c) sum += corner[c][d];
    return sum * T(1.0 / k_corners);
  }

  /// Along x for the row of nodes with the numbers `node[1]`, `node[2]`: N_i, and its derivatives in xi, [direction][node].
  MPM_SHAPE_INLINE void weights_of_row(const int* node, T* N, T (&dN)[Dim][k_nodes]) const {
    T along_edge[Dim][k_nodes];
    for (int i = 0; i < k_nodes; ++i) {
      N[i] = T(0);
      for (int k = 0; k < Dim; ++k) along_edge[k][i] = T(0);
    }
    for (int c = 0; c < k_corners; ++c) {
      T across = T(1.0 / k_corners) * ShapeConvected<T>::hat(corner[c][1], node[1]);
      if constexpr (Dim == 3) across *= ShapeConvected<T>::hat(corner[c][2], node[2]);
      for (int i = 0; i < k_nodes; ++i) {
        const T S = across * ShapeConvected<T>::hat(corner[c][0], i);
        N[i] += S;
        for (int k = 0; k < Dim; ++k) along_edge[k][i] = is_upper(c, k) ? along_edge[k][i] + S : along_edge[k][i] - S;
      }
    }
    for (int i = 0; i < k_nodes; ++i) {
      for (int d = 0; d < Dim; ++d) {
        dN[d][i] = inverse[0][d] * along_edge[0][i];
        for (int k = 1; k < Dim; ++k) dN[d][i] += inverse[k][d] * along_edge[k][i];
      }
    }
  }

 private:
  MPM_SHAPE_INLINE void invert(const T (&a)[Dim][Dim]) {
    if constexpr (Dim == 2) {
      const T per_det = T(1) / (a[0][0] * a[1][1] - a[0][1] * a[1][0]);
      inverse[0][0] = a[1][1] * per_det;
      inverse[0][1] = -a[0][1] * per_det;
      inverse[1][0] = -a[1][0] * per_det;
      inverse[1][1] = a[0][0] * per_det;
    } else {
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
          const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
          inverse[j][i] = a[i1][j1] * a[i2][j2] - a[i1][j2] * a[i2][j1];
        }
      }
      const T per_det = T(1) / (a[0][0] * inverse[0][0] + a[0][1] * inverse[1][0] + a[0][2] * inverse[2][0]);
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) inverse[i][j] *= per_det;
      }
    }
  }
};

}  // namespace
}  // namespace matpoint
