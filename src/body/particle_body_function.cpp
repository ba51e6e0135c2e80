// Laws that programs give as functions: a sweep collects the points of a body, the function is called once for all of them, in the order
// of their ids, what it gives is stored with the particles, and a sweep of its own takes the forces from there.
#include <algorithm>

#include "body/particle_body.hpp"
#include "core/tensor.hpp"
#include "material/function_material.hpp"

namespace matpoint {

template <int Dim, class R>
void ParticleBody<Dim, R>::start_function_call() {
  const auto count = static_cast<std::size_t>(particle_count());
  call_.history_size = material_->history_size(Dim);
  call_.has_fbar = has_fbar_;
  call_.rows = rows_of_ids();
  for (std::vector<Real>* values : {&call_.F, &call_.L, &call_.tau}) values->resize(9 * count);
  call_.history.resize(static_cast<std::size_t>(call_.history_size) * count);
  if (!has_fbar_) return;
  call_.leaders.resize(count);
  call_.weights.resize(count);
}

/// In place of a law's kernel: deforms the points, and keeps what the function will be given. There is no stress yet.
template <int Dim, class R>
void ParticleBody<Dim, R>::collect_points(const void* law, LawChunk<Dim, R>& chunk) {
  constexpr int L = k_lanes<R>;
  // The kernels know laws that do not change.
  auto& call = *static_cast<FunctionCall*>(const_cast<void*>(law));
  const SlotLayout<Dim>& at = *chunk.layout;
  std::fill_n(chunk.tau, k_chunk_slots * k_stress_size<Dim> * L, R{0});
  const auto row_of = [&](const R* point) { return call.rows[id_from_bits(point[at.id * L])]; };
  for (int k = 0; k < k_chunk_slots; ++k) {
    for (int lane = 0; lane < L; ++lane) {
      if (!(static_cast<R>(k) < chunk.counts[lane])) continue;
      R* const point = chunk.slots[k] + lane;
      Mat3<Real> old_F = Mat3<Real>::identity(), gradient = Mat3<Real>::zero();
      for (int r = 0; r < Dim; ++r) {
        for (int c = 0; c < Dim; ++c) {
          old_F(r, c) = static_cast<Real>(point[(at.F + r * Dim + c) * L]);
          gradient(r, c) = static_cast<Real>(chunk.L[(k * Dim * Dim + r * Dim + c) * L + lane]);
        }
      }
      if (at.hoop >= 0) {
        old_F(2, 2) = static_cast<Real>(point[at.hoop * L]);
        gradient(2, 2) = static_cast<Real>(chunk.L_hoop[k * L + lane]);
      }
      Mat3<Real> new_F = old_F;
      if (at.hoop >= 0) {
        new_F(2, 2) += chunk.dt * gradient(2, 2) * old_F(2, 2);
        point[at.hoop * L] = static_cast<R>(new_F(2, 2));
      }
      for (int r = 0; r < Dim; ++r) {
        for (int c = 0; c < Dim; ++c) {
          for (int e = 0; e < Dim; ++e) new_F(r, c) += chunk.dt * gradient(r, e) * old_F(e, c);
          point[(at.F + r * Dim + c) * L] = static_cast<R>(new_F(r, c));
        }
      }
      const R J = static_cast<R>(determinant(new_F));
      chunk.J_min[lane] = std::min(chunk.J_min[lane], J);
      chunk.J_max[lane] = std::max(chunk.J_max[lane], J);
      // The function, which would raise something of its own and hide which particle it is, is not called then.
      if (!(J > 0 && J < R(1e30)) && chunk.bad_slot < 0) {
        chunk.bad_slot = k;
        chunk.bad_lane = lane;
      }
      const auto row = static_cast<std::size_t>(row_of(point));
      std::copy_n(new_F.entries, 9, call.F.data() + 9 * row);
      std::copy_n(gradient.entries, 9, call.L.data() + 9 * row);
      for (int h = 0; h < call.history_size; ++h)
        call.history[row * static_cast<std::size_t>(call.history_size) + static_cast<std::size_t>(h)] =
            static_cast<Real>(point[(at.history + h) * L]);
      if (!call.has_fbar) continue;
      call.leaders[row] = row_of(chunk.slots[0] + lane);
      call.weights[row] = static_cast<Real>(at.volume >= 0 ? point[at.volume * L] : chunk.uniform_volume);
    }
  }
}

template <int Dim, class R>
void ParticleBody<Dim, R>::call_function(Real dt, const Context& context) {
  const auto count = static_cast<std::size_t>(particle_count());
  if (count == 0) return;
  const auto& law = static_cast<const FunctionMaterial&>(*material_);
  law.evaluate({static_cast<Index>(count), call_.F.data(), call_.L.data(), dt, call_.history.data(), call_.tau.data()});
  const SlotLayout<Dim>& at = blocks_->layout();
  const auto history_size = static_cast<std::size_t>(call_.history_size);
  if (history_size > 0) {
    change_each_particle(call_.rows, [&](R* fields, int stride, std::size_t row) {
      for (std::size_t h = 0; h < history_size; ++h)
        fields[(at.history + static_cast<int>(h)) * stride] = static_cast<R>(call_.history[row * history_size + h]);
    });
  }
  // With F-bar the forces are of averages over the cells in which the gradients were averaged, and where the particles no longer are; the
  // stresses that they keep are their own.
  std::vector<Real> averaged;
  if (call_.has_fbar) {
    const std::size_t directions = at.hoop >= 0 ? 3 : Dim;
    averaged = call_.tau;
    std::vector<Real> sums(count, 0), weights(count, 0);
    const auto spherical = [&](std::size_t row) {
      Real trace = 0;
      for (std::size_t d = 0; d < directions; ++d) trace += call_.tau[9 * row + 4 * d];
      return trace / static_cast<Real>(directions);
    };
    for (std::size_t row = 0; row < count; ++row) {
      const auto leader = static_cast<std::size_t>(call_.leaders[row]);
      sums[leader] += call_.weights[row] * spherical(row);
      weights[leader] += call_.weights[row];
    }
    for (std::size_t row = 0; row < count; ++row) {
      const auto leader = static_cast<std::size_t>(call_.leaders[row]);
      const Real change = sums[leader] / weights[leader] - spherical(row);
      for (std::size_t d = 0; d < directions; ++d) averaged[9 * row + 4 * d] += change;
    }
  }
  store_stresses(call_.has_fbar ? averaged : call_.tau);
  Context stored = context;
  stored.has_fbar = false;
  for_each_band([&](std::size_t b) {
    reports_[b].context = stored;
    sweep_band(Sweep::force, b, reports_[b]);
  });
  if (call_.has_fbar) store_stresses(call_.tau);
}

template <int Dim, class R>
void ParticleBody<Dim, R>::store_stresses(const std::vector<Real>& tau) {
  const SlotLayout<Dim>& at = blocks_->layout();
  change_each_particle(call_.rows, [&](R* fields, int stride, std::size_t row) {
    const Real* const t = tau.data() + 9 * row;
    const std::array<Real, 6> components{t[0], t[4], t[8], 0.5 * (t[1] + t[3]), 0.5 * (t[5] + t[7]), 0.5 * (t[2] + t[6])};
    for (int s = 0; s < k_stress_size<Dim>; ++s) fields[(at.tau + s) * stride] = static_cast<R>(components[static_cast<std::size_t>(s)]);
  });
}

#define MPM_INSTANTIATE(Dim, R)                                                       \
  template void ParticleBody<Dim, R>::start_function_call();                          \
  template void ParticleBody<Dim, R>::collect_points(const void*, LawChunk<Dim, R>&); \
  template void ParticleBody<Dim, R>::call_function(Real, const Context&);            \
  template void ParticleBody<Dim, R>::store_stresses(const std::vector<Real>&);
MPM_INSTANTIATE(2, double)
MPM_INSTANTIATE(3, double)
MPM_INSTANTIATE(2, float)
MPM_INSTANTIATE(3, float)
#undef MPM_INSTANTIATE

}  // namespace matpoint
