// The kernel of a FunctionMaterial: copies the points of a chunk into arrays and calls the function once for all of them.
#pragma once

#include <algorithm>

#include "core/tensor.hpp"
#include "kernel/kernel.hpp"
#include "material/function_material.hpp"

namespace matpoint {

template <int Dim, class R>
void update_function_law(const void* law, LawChunk<Dim, R>& chunk) {
  constexpr int L = k_lanes<R>;
  constexpr int points_max = k_chunk_slots * L;
  const auto& material = *static_cast<const FunctionMaterial*>(law);
  const SlotLayout<Dim>& at = *chunk.layout;
  const auto history_size = static_cast<std::size_t>(material.history_size(Dim));
  std::array<Real, 9 * points_max> F{}, velocity_gradient{}, tau{};
  std::vector<Real> history(history_size * points_max);
  std::array<R*, points_max> fields{};
  std::array<R*, points_max> stresses{};
  std::size_t count = 0;
  // Lanes without a particle, and bad points, are summed with a stress of zero.
  std::fill_n(chunk.tau, k_chunk_slots * k_stress_size<Dim> * L, R{0});
  for (int k = 0; k < k_chunk_slots; ++k) {
    for (int lane = 0; lane < L; ++lane) {
      if (!(static_cast<R>(k) < chunk.counts[lane])) continue;
      R* const point = chunk.slots[k] + lane;
      fields[count] = point;
      stresses[count] = chunk.tau + k * k_stress_size<Dim> * L + lane;
      Mat3<Real> old_F = Mat3<Real>::identity(), gradient = Mat3<Real>::zero();
      for (int r = 0; r < Dim; ++r) {
        for (int c = 0; c < Dim; ++c) {
          old_F(r, c) = static_cast<Real>(point[(at.F + r * Dim + c) * L]);
          if (chunk.L != nullptr) gradient(r, c) = static_cast<Real>(chunk.L[(k * Dim * Dim + r * Dim + c) * L + lane]);
        }
      }
      Mat3<Real> new_F = old_F;
      for (int r = 0; r < Dim; ++r) {
        for (int c = 0; c < Dim; ++c) {
          for (int e = 0; e < Dim; ++e) new_F(r, c) += chunk.dt * gradient(r, e) * old_F(e, c);
          point[(at.F + r * Dim + c) * L] = static_cast<R>(new_F(r, c));
        }
      }
      const R J = static_cast<R>(determinant(new_F));
      chunk.J_min[lane] = std::min(chunk.J_min[lane], J);
      chunk.J_max[lane] = std::max(chunk.J_max[lane], J);
      if (!(J > 0 && J < R(1e30))) {
        // The function would raise something of its own, and hide which particle it is.
        if (chunk.bad_slot < 0) {
          chunk.bad_slot = k;
          chunk.bad_lane = lane;
        }
        continue;
      }
      std::copy_n(new_F.entries, 9, F.begin() + static_cast<std::ptrdiff_t>(9 * count));
      std::copy_n(gradient.entries, 9, velocity_gradient.begin() + static_cast<std::ptrdiff_t>(9 * count));
      for (std::size_t h = 0; h < history_size; ++h)
        history[count * history_size + h] = static_cast<Real>(point[(at.history + static_cast<int>(h)) * L]);
      ++count;
    }
  }
  if (count == 0) return;
  material.evaluate(
      {static_cast<Index>(count), F.data(), velocity_gradient.data(), chunk.L != nullptr ? chunk.dt : 0, history.data(), tau.data()});
  for (std::size_t p = 0; p < count; ++p) {
    const Real* const t = tau.data() + 9 * p;
    const std::array<Real, 6> components{t[0], t[4], t[8], 0.5 * (t[1] + t[3]), 0.5 * (t[5] + t[7]), 0.5 * (t[2] + t[6])};
    for (int s = 0; s < k_stress_size<Dim>; ++s) {
      stresses[p][s * L] = static_cast<R>(components[static_cast<std::size_t>(s)]);
      fields[p][(at.tau + s) * L] = stresses[p][s * L];
    }
    for (std::size_t h = 0; h < history_size; ++h)
      fields[p][(at.history + static_cast<int>(h)) * L] = static_cast<R>(history[p * history_size + h]);
  }
}

}  // namespace matpoint
