// What a particle adds to the equations of its cell's nodes, with their number known to the compiler.
#pragma once

#include "core/types.hpp"

namespace matpoint {

/// A = I + sum_K u_K g_K.
template <int Dim, int N>
void deformation(const Real* u, const Real* g, Real* A) {
  for (int i = 0; i < Dim; ++i) {
    for (int j = 0; j < Dim; ++j) A[i * Dim + j] = i == j ? 1 : 0;
  }
  for (int K = 0; K < N; ++K) {
    for (int i = 0; i < Dim; ++i) {
      for (int j = 0; j < Dim; ++j) A[i * Dim + j] += u[K * Dim + i] * g[K * Dim + j];
    }
  }
}

/// K_IK += V0 g_I D g*_K
template <int Dim, int N>
void add_stiffness(Real volume, const Real* D, const Real* g, const Real* trial_g, Real* K) {
  Real H[Dim * Dim][N * Dim];  // V0 D_ij,kl g*_K,l by (i, j) and (K, k)
  for (int ij = 0; ij < Dim * Dim; ++ij) {
    for (int node = 0; node < N; ++node) {
      for (int k = 0; k < Dim; ++k) {
        Real sum = 0;
        for (int l = 0; l < Dim; ++l) sum += D[ij * Dim * Dim + k * Dim + l] * trial_g[node * Dim + l];
        H[ij][node * Dim + k] = volume * sum;
      }
    }
  }
  for (int I = 0; I < N; ++I) {
    for (int i = 0; i < Dim; ++i) {
      Real* const row = K + (I * Dim + i) * N * Dim;
      for (int column = 0; column < N * Dim; ++column) {
        Real sum = 0;
        for (int j = 0; j < Dim; ++j) sum += g[I * Dim + j] * H[i * Dim + j][column];
        row[column] += sum;
      }
    }
  }
}

/// det of a Dim x Dim matrix, row by row.
template <int Dim>
Real determinant_of(const Real* a) {
  if constexpr (Dim == 3)
    return a[0] * (a[4] * a[8] - a[5] * a[7]) - a[1] * (a[3] * a[8] - a[5] * a[6]) + a[2] * (a[3] * a[7] - a[4] * a[6]);
  else
    return a[0] * a[3] - a[1] * a[2];
}

/// A^-T of a Dim x Dim matrix with the determinant j.
template <int Dim>
void inverse_transposed(const Real* a, Real j, Real* B) {
  if constexpr (Dim == 3) {
    B[0] = (a[4] * a[8] - a[5] * a[7]) / j;
    B[1] = (a[5] * a[6] - a[3] * a[8]) / j;
    B[2] = (a[3] * a[7] - a[4] * a[6]) / j;
    B[3] = (a[2] * a[7] - a[1] * a[8]) / j;
    B[4] = (a[0] * a[8] - a[2] * a[6]) / j;
    B[5] = (a[1] * a[6] - a[0] * a[7]) / j;
    B[6] = (a[1] * a[5] - a[2] * a[4]) / j;
    B[7] = (a[2] * a[3] - a[0] * a[5]) / j;
    B[8] = (a[0] * a[4] - a[1] * a[3]) / j;
  } else {
    B[0] = a[3] / j;
    B[1] = -a[2] / j;
    B[2] = -a[1] / j;
    B[3] = a[0] / j;
  }
}

}  // namespace matpoint
