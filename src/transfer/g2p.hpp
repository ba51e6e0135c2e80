// Grid to particles: velocity (FLIP/PIC blend), velocity gradient and position, for a chunk of particles that lie side by side in memory.
#pragma once

#include "core/multiversion.hpp"
#include "transfer/views.hpp"

namespace matpoint {

/// What a G2P pass does. The three stress orders are sequences of these passes (explicit_solver.cpp).
enum class Gather {
  all,                    ///< velocity, gradient, position: USL
  velocity_displacement,  ///< velocity, and the displacement kept for later: first pass of MUSL
  gradient_move,          ///< gradient, then position by the kept displacement: second pass of MUSL
  gradient,               ///< gradient only: first pass of USF
  velocity_move,          ///< velocity and position: second pass of USF
};

/// What a pass found out about its chunk.
struct GatherReport {
  Index moved_cell = 0;      ///< Particles that are in another cell now.
  Index moved_band = 0;      ///< Particles that are in another band (row of cells along the last axis) now.
  Index outside = 0;         ///< Particles that are not inside the grid now, or have no finite position.
};

constexpr Index k_chunk = 256;

template <int Dim, class Shape, Gather What>
struct G2P {
  /// Particles [begin, begin + count), count <= k_chunk. `flip` is 1 for FLIP and 0 for PIC. L: one array of k_chunk reals per component.
  MPM_MULTIVERSION static void run(const GridView<Dim>& grid, const ParticleView<Dim>& particles, Index begin, Index count, Real dt,
                                   Real flip, Real* L, GatherReport& report);
};

template <int Dim, class Shape, Gather What>
MPM_MULTIVERSION void G2P<Dim, Shape, What>::run(const GridView<Dim>& grid, const ParticleView<Dim>& particles, Index begin, Index count,
                                                 Real dt, Real flip, Real* L, GatherReport& report) {
  constexpr bool has_velocity = What == Gather::all || What == Gather::velocity_displacement || What == Gather::velocity_move;
  constexpr bool has_gradient = What == Gather::all || What == Gather::gradient_move || What == Gather::gradient;
  constexpr bool moves = What == Gather::all || What == Gather::gradient_move || What == Gather::velocity_move;
  constexpr int W = k_motion_width<Dim>;
  constexpr int S = Shape::k_support;
  constexpr int k_rows = 1 + (has_gradient ? Dim : 0);
  alignas(64) Real gathered[k_chunk][k_rows][W];
  std::int32_t cell_of[k_chunk][Dim];

  for (Index n = 0; n < count; ++n) {
    Real w[Dim][S];
    Real dw[Dim][S];
    Index node = 0;
    for (int d = 0; d < Dim; ++d) {
      Real xi;
      cell_of[n][d] = locate_in_cell<Dim>(grid, d, particles.x[d][begin + n], xi);
      node += grid.stride[d] * cell_of[n][d];
      Shape::weights(xi, grid.inverse_cell_size[d], w[d], dw[d]);
    }
    const Real* const corner = grid.motion + W * node;
    alignas(64) Real sum[k_rows][W] = {};
    for (int k = 0; k < (Dim == 3 ? S : 1); ++k) {
      const Real wz = Dim == 3 ? w[Dim - 1][k] : 1;
      for (int j = 0; j < S; ++j) {
        const Real* const line = corner + W * (j * grid.stride[1] + (Dim == 3 ? k * grid.stride[Dim - 1] : 0));
        for (int i = 0; i < S; ++i) {
          const Real N = w[0][i] * w[1][j] * wz;
          for (int c = 0; c < W; ++c) sum[0][c] += N * line[W * i + c];
          if constexpr (has_gradient) {
            const Real dNx = dw[0][i] * w[1][j] * wz;
            const Real dNy = w[0][i] * dw[1][j] * wz;
            for (int c = 0; c < W; ++c) sum[1][c] += dNx * line[W * i + c];
            for (int c = 0; c < W; ++c) sum[2][c] += dNy * line[W * i + c];
            if constexpr (Dim == 3) {
              const Real dNz = w[0][i] * w[1][j] * dw[Dim - 1][k];
              for (int c = 0; c < W; ++c) sum[Dim][c] += dNz * line[W * i + c];
            }
          }
        }
      }
    }
    for (int r = 0; r < k_rows; ++r) {
      for (int c = 0; c < W; ++c) gathered[n][r][c] = sum[r][c];
    }
  }

  if constexpr (has_gradient) {
    for (int r = 0; r < Dim; ++r) {
      for (int c = 0; c < Dim; ++c) {
        Real* const component = L + (r * Dim + c) * k_chunk;
        for (Index n = 0; n < count; ++n) component[n] = gathered[n][1 + c][r];
      }
    }
  }
  for (int d = 0; d < Dim; ++d) {
    if constexpr (has_velocity) {
      Real* const v = particles.v[d] + begin;
      for (Index n = 0; n < count; ++n) v[n] = flip * (v[n] + dt * gathered[n][0][Dim + d]) + (1 - flip) * gathered[n][0][d];
    }
    if constexpr (What == Gather::velocity_displacement) {
      Real* const u = particles.displacement[d] + begin;
      for (Index n = 0; n < count; ++n) u[n] = dt * gathered[n][0][d];
    }
    if constexpr (moves) {
      Real* const x = particles.x[d] + begin;
      const Real* const u = particles.displacement[d] + begin;
      for (Index n = 0; n < count; ++n) x[n] += What == Gather::gradient_move ? u[n] : dt * gathered[n][0][d];
    }
  }
  if constexpr (moves) {
    for (int d = 0; d < Dim; ++d) {
      Real* const x = particles.x[d] + begin;
      if (grid.is_periodic[d]) {
        const Real length = grid.upper[d] - grid.lower[d];
        for (Index n = 0; n < count; ++n) {
          const Real turns = __builtin_floor((x[n] - grid.lower[d]) / length);
          if (turns != 0) x[n] -= turns * length;
        }
      }
      const Real lower = grid.lower[d];
      const Real upper = grid.upper[d];
      Index outside = 0;
      for (Index n = 0; n < count; ++n) outside += !(x[n] >= lower && x[n] <= upper);
      report.outside += outside;
      Index moved = 0;
      for (Index n = 0; n < count; ++n) {
        Real xi;
        moved += locate_in_cell<Dim>(grid, d, x[n], xi) != cell_of[n][d];
      }
      report.moved_cell += moved;
      if (d == Dim - 1) report.moved_band += moved;
    }
  }
}

}  // namespace matpoint
