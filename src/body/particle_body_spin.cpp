// The frame that turns with a body.
//
// The nodes at the edge of a body take the mean velocity of the particles around them, which are on one side only: there the grid turns
// slower than the body, particles move along the grid's velocity and not along their own, and angular momentum is lost. Mapped with the
// affine part of the body's own rigid turn, v_p + W (x_i - x_p), the velocities of the nodes of a turning body are exact. The particles
// keep no affine part, so nothing is smoothed, and what deforms is not damped, as it is with an affine part for each particle (APIC).
//
// What the forces do on these velocities differs from what the particles get by W : sum m N (x_i - x_p) (x) a_i. With a turn that stays
// this averages out over the body's vibrations; but a turn that vibrates with them, as the angular momentum of a body does that is held
// at one end, gives or takes energy in every period. So the frame follows slowly.
#include <cmath>

#include "body/particle_body.hpp"
#include "core/tensor.hpp"

namespace matpoint {
namespace {

// A turn that moves nodes by less than this share of the body's speed, a cell away, is rounding.
template <class R>
constexpr Real k_rounding = sizeof(R) == 8 ? 1e-12 : 1e-6;

// Each of the means over time is over so many times in which a wave crosses the body.
constexpr Real k_crossings = 50;

struct Moments {
  Real mass = 0;
  Vec3 place{};             ///< sum m r
  Vec3 momentum{};          ///< sum m v
  Vec3 angular_momentum{};  ///< sum m r x v
  Mat3<Real> square{};      ///< sum m r r

  void add(const Moments& other) {
    mass += other.mass;
    for (std::size_t d = 0; d < 3; ++d) {
      place[d] += other.place[d];
      momentum[d] += other.momentum[d];
      angular_momentum[d] += other.angular_momentum[d];
    }
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) square(r, c) += other.square(r, c);
    }
  }
};

}  // namespace

template <int Dim, class R>
void ParticleBody<Dim, R>::measure_spin(Real dt) {
  const std::vector<Band>& bands = blocks_->bands();
  std::vector<Moments> sums(bands.size());
  parallel_for(static_cast<Index>(bands.size()), blocks_->count(), [&](Index b) {
    Moments& sum = sums[static_cast<std::size_t>(b)];
    blocks_->for_each(bands[static_cast<std::size_t>(b)], [&](const R* fields, const Vec3& place) {
      const Particle p{fields, k_lanes<R>, place};
      const Real m = volume0(p);
      const Vec3 v = velocity(p);
      Vec3 r{};
      for (std::size_t d = 0; d < Dim; ++d) r[d] = place[d] - spin_.center[d];
      const Vec3 turn = cross(r, v);
      sum.mass += m;
      for (std::size_t d = 0; d < 3; ++d) {
        sum.place[d] += m * r[d];
        sum.momentum[d] += m * v[d];
        sum.angular_momentum[d] += m * turn[d];
        for (std::size_t e = 0; e < Dim && d < Dim; ++e) sum.square(static_cast<int>(d), static_cast<int>(e)) += m * r[d] * r[e];
      }
    });
  });
  Moments all;
  for (const Moments& sum : sums) all.add(sum);
  spin_.is_used = false;
  if (!(all.mass > 0)) return;
  // About the centre of mass.
  Vec3 center{};
  for (std::size_t d = 0; d < 3; ++d) center[d] = all.place[d] / all.mass;
  const Vec3 moved = cross(center, all.momentum);
  Real trace = 0;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) all.square(r, c) -= all.mass * center[static_cast<std::size_t>(r)] * center[static_cast<std::size_t>(c)];
    trace += all.square(r, r);
    all.angular_momentum[static_cast<std::size_t>(r)] -= moved[static_cast<std::size_t>(r)];
    spin_.center[static_cast<std::size_t>(r)] += center[static_cast<std::size_t>(r)];
  }
  if (!(trace > 0)) return;
  // Angular momentum, which a body that flies keeps however it tumbles.
  const Real crossing = 2 * std::sqrt(trace / all.mass) / material_->wave_speed(1);
  const Real share = dt > 0 && !spin_.is_held ? -std::expm1(-dt / (k_crossings * crossing)) : 1;
  Vec3 momentum{};
  for (std::size_t d = 0; d < 3; ++d) momentum[d] = all.angular_momentum[d] / all.mass;
  for (Vec3& mean : spin_.means) {
    for (std::size_t d = 0; d < 3; ++d) mean[d] += share * (momentum[d] - mean[d]);
    momentum = mean;
  }
  // I = tr(S) - S. A rod has no inertia about itself, and what the mean differs by may point along it.
  const auto turn_of = [&](const Vec3& angular_momentum, Real least_inertia) {
    Mat3<Real> inertia{};
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) inertia(r, c) = (r == c ? trace * (1 + least_inertia) : 0) - all.square(r, c);
    }
    const Mat3<Real> G = cofactor(inertia);
    const Real det = determinant(inertia);
    Vec3 turn{};
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) turn[static_cast<std::size_t>(r)] += G(c, r) * angular_momentum[static_cast<std::size_t>(c)] / det;
    }
    return turn;
  };
  Vec3 difference{};
  for (std::size_t d = 0; d < 3; ++d) difference[d] = all.mass * momentum[d] - all.angular_momentum[d];
  Vec3 w = turn_of(all.angular_momentum, 1e-9);
  const Vec3 correction = turn_of(difference, 1e-3);
  for (std::size_t d = 0; d < 3; ++d) w[d] += correction[d];
  const Real spin[3][3] = {{0, -w[2], w[1]}, {w[2], 0, -w[0]}, {-w[1], w[0], 0}};
  Real largest = 0;
  for (int d = 0; d < Dim; ++d) {
    for (int c = 0; c < Dim; ++c) {
      spin_.velocity_gradient[d][c] = spin[d][c];
      largest = std::max(largest, std::abs(spin[d][c]) * grid_.cell_size(c));
    }
  }
  spin_.is_used = !spin_.is_held && largest > k_rounding<R> * greatest_speed();
}

template void ParticleBody<2, double>::measure_spin(Real);
template void ParticleBody<3, double>::measure_spin(Real);
template void ParticleBody<2, float>::measure_spin(Real);
template void ParticleBody<3, float>::measure_spin(Real);

}  // namespace matpoint
