#include "explicit/rigid_motion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace matpoint {
namespace {

Vec3 minus(const Vec3& a, const Vec3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Vec3 plus(const Vec3& a, const Vec3& b, Real factor = 1) { return {a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]}; }
Vec3 times(const std::array<Real, 9>& A, const Vec3& b) {
  return {A[0] * b[0] + A[1] * b[1] + A[2] * b[2], A[3] * b[0] + A[4] * b[1] + A[5] * b[2], A[6] * b[0] + A[7] * b[1] + A[8] * b[2]};
}
Vec3 transposed_times(const std::array<Real, 9>& A, const Vec3& b) {
  return {A[0] * b[0] + A[3] * b[1] + A[6] * b[2], A[1] * b[0] + A[4] * b[1] + A[7] * b[2], A[2] * b[0] + A[5] * b[1] + A[8] * b[2]};
}
Vec3 unit(const Vec3& a) {
  const Real size = std::hypot(a[0], a[1], a[2]);
  return {a[0] / size, a[1] / size, a[2] / size};
}

/// Eigenvectors of a symmetric matrix, one a row, and its eigenvalues: rotations until nothing is beside the diagonal (Jacobi).
void find_axes(std::array<Real, 9> A, std::array<Real, 9>& axes, Vec3& values) {
  axes = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  const Real size = std::max({std::abs(A[0]), std::abs(A[4]), std::abs(A[8])});
  for (int sweep = 0; sweep < 30; ++sweep) {
    for (std::size_t p = 0; p < 3; ++p) {
      for (std::size_t q = p + 1; q < 3; ++q) {
        if (std::abs(A[3 * p + q]) <= 1e-17 * size) continue;
        const Real angle = 0.5 * std::atan2(2 * A[3 * p + q], A[4 * p] - A[4 * q]);
        const Real c = std::cos(angle), s = std::sin(angle);
        for (std::size_t k = 0; k < 3; ++k) {
          const Real a = A[3 * k + p], b = A[3 * k + q];
          A[3 * k + p] = c * a + s * b;
          A[3 * k + q] = c * b - s * a;
        }
        for (std::size_t k = 0; k < 3; ++k) {
          const Real a = A[3 * p + k], b = A[3 * q + k];
          A[3 * p + k] = c * a + s * b;
          A[3 * q + k] = c * b - s * a;
          const Real x = axes[3 * p + k], y = axes[3 * q + k];
          axes[3 * p + k] = c * x + s * y;
          axes[3 * q + k] = c * y - s * x;
        }
      }
    }
  }
  values = {A[0], A[4], A[8]};
}

}  // namespace

RigidMotion::RigidMotion(const ToolSpec& spec, int dim) : spec_(spec) {
  const std::optional<Solid> solid = spec.shape->solid(dim);
  if (spec.is_free()) {
    const Real density = spec.density ? *spec.density : *spec.mass / solid->volume;
    mass_ = density * solid->volume;
    start_pivot_ = spec.hinge ? *spec.hinge : solid->center;
    arm_ = minus(solid->center, start_pivot_);
    std::array<Real, 9> inertia = solid->inertia;
    const Real square = arm_[0] * arm_[0] + arm_[1] * arm_[1] + arm_[2] * arm_[2];
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j)
        inertia[3 * i + j] = density * inertia[3 * i + j] + mass_ * ((i == j ? square : 0) - arm_[i] * arm_[j]);
    }
    if (dim == 2)
      fixed_axis_ = Vec3{0, 0, 1};
    else if (spec.axis)
      fixed_axis_ = unit(*spec.axis);
    find_axes(inertia, axes_, moments_);
    if (fixed_axis_) inertia_ = dot(*fixed_axis_, times(inertia, *fixed_axis_));
    is_turn_held_ = std::find(spec.held.begin(), spec.held.end(), "rotation") != spec.held.end();
    std::copy(spec.velocity.begin(), spec.velocity.end(), velocity_.begin());
    angular_momentum_ = times(inertia, spec.angular_velocity);
    angular_velocity_ = spec.angular_velocity;
    if (fixed_axis_) {
      const Real rate = dot(spec.angular_velocity, *fixed_axis_);
      for (std::size_t d = 0; d < 3; ++d) {
        angular_velocity_[d] = rate * (*fixed_axis_)[d];
        angular_momentum_[d] = inertia_ * angular_velocity_[d];
      }
    }
    for (std::size_t d = 0; d < 3; ++d) {
      if (std::find(spec.held.begin(), spec.held.end(), std::string(1, "xyz"[d])) != spec.held.end()) velocity_[d] = 0;
    }
    if (is_turn_held_) angular_velocity_ = angular_momentum_ = {};
  } else {
    if (spec.pivot) {
      start_pivot_ = *spec.pivot;
    } else if (solid) {
      start_pivot_ = solid->center;
    } else {
      const Vec3 lower = spec.shape->lower(), upper = spec.shape->upper();
      for (std::size_t d = 0; d < 3; ++d) {
        const Real middle = 0.5 * (lower[d] + upper[d]);
        start_pivot_[d] = std::isfinite(middle) ? middle : 0;
      }
    }
    const Vec3 w = spec.angular_velocity;
    if (w != Vec3{}) fixed_axis_ = unit(w);
    velocity_ = spec.velocity_at(0);
    angular_velocity_ = spec.angular_velocity_at(0);
  }
  pivot_ = start_pivot_;
}

void RigidMotion::advance(Real t, Real dt, const Vec3& force, const Vec3& torque, const Vec3& gravity) {
  if (!spec_.is_free()) {
    // In the middle of the step, so that velocities that grow evenly are taken exactly.
    velocity_ = spec_.velocity_at(t + 0.5 * dt);
    angular_velocity_ = spec_.angular_velocity_at(t + 0.5 * dt);
    pivot_ = plus(pivot_, velocity_, dt);
    if (fixed_axis_) {
      const Real rate = dot(angular_velocity_, *fixed_axis_);
      angle_ += dt * rate;
      turn_by(*fixed_axis_, dt * rate);
    }
    return;
  }
  Vec3 load{};
  std::copy(spec_.force.begin(), spec_.force.end(), load.begin());
  load = plus(load, gravity, mass_);
  if (!spec_.hinge) {
    velocity_ = plus(velocity_, plus(load, force), dt / mass_);
    for (std::size_t d = 0; d < 3; ++d) {
      if (std::find(spec_.held.begin(), spec_.held.end(), std::string(1, "xyz"[d])) != spec_.held.end()) velocity_[d] = 0;
    }
    pivot_ = plus(pivot_, velocity_, dt);
  }
  if (is_turn_held_) return;
  const Vec3 moment = plus(torque, cross(times(R_, arm_), load));
  if (fixed_axis_) {
    Real rate = dot(angular_velocity_, *fixed_axis_);
    rate = (rate + dt / inertia_ * (dot(moment, *fixed_axis_) - spec_.spring * angle_)) / (1 + dt / inertia_ * spec_.spring_damping);
    angle_ += dt * rate;
    R_ = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    turn_by(*fixed_axis_, angle_);
    for (std::size_t d = 0; d < 3; ++d) {
      angular_velocity_[d] = rate * (*fixed_axis_)[d];
      angular_momentum_[d] = inertia_ * angular_velocity_[d];
    }
    return;
  }
  angular_momentum_ = plus(angular_momentum_, moment, dt);
  turn_freely(dt);
  update_rate();
}

void RigidMotion::turn_freely(Real dt) {
  const auto about = [&](std::size_t a, Real step) {
    const Vec3 axis = times(R_, {axes_[3 * a], axes_[3 * a + 1], axes_[3 * a + 2]});
    turn_by(axis, step * dot(axis, angular_momentum_) / moments_[a]);
  };
  about(0, 0.5 * dt);
  about(1, 0.5 * dt);
  about(2, dt);
  about(1, 0.5 * dt);
  about(0, 0.5 * dt);
  // Rounding, for ever small.
  Vec3 x{R_[0], R_[3], R_[6]}, y{R_[1], R_[4], R_[7]};
  x = unit(x);
  y = unit(plus(y, x, -dot(x, y)));
  const Vec3 z = cross(x, y);
  for (std::size_t d = 0; d < 3; ++d) R_[3 * d] = x[d], R_[3 * d + 1] = y[d], R_[3 * d + 2] = z[d];
}

void RigidMotion::turn_by(const Vec3& axis, Real angle) {
  const Real s = std::sin(angle), c = 2 * std::pow(std::sin(0.5 * angle), 2);  // 1 - cos, also of small angles
  for (std::size_t column = 0; column < 3; ++column) {
    const Vec3 v{R_[column], R_[3 + column], R_[6 + column]};
    const Vec3 across = cross(axis, v), twice = cross(axis, across);
    for (std::size_t d = 0; d < 3; ++d) R_[3 * d + column] = v[d] + s * across[d] + c * twice[d];
  }
}

void RigidMotion::update_rate() {
  Vec3 rate{};
  for (std::size_t a = 0; a < 3; ++a) {
    const Vec3 axis = times(R_, {axes_[3 * a], axes_[3 * a + 1], axes_[3 * a + 2]});
    rate = plus(rate, axis, dot(axis, angular_momentum_) / moments_[a]);
  }
  angular_velocity_ = rate;
}

Vec3 RigidMotion::center() const { return plus(pivot_, times(R_, arm_)); }
Vec3 RigidMotion::velocity_of(const Vec3& x) const { return plus(velocity_, cross(angular_velocity_, minus(x, pivot_))); }
Vec3 RigidMotion::at_start(const Vec3& x) const { return plus(start_pivot_, transposed_times(R_, minus(x, pivot_))); }
Vec3 RigidMotion::turned(const Vec3& direction) const { return times(R_, direction); }

Vec3 RigidMotion::turn() const {
  if (fixed_axis_) return {angle_ * (*fixed_axis_)[0], angle_ * (*fixed_axis_)[1], angle_ * (*fixed_axis_)[2]};
  const Vec3 twice{R_[7] - R_[5], R_[2] - R_[6], R_[3] - R_[1]};  // 2 sin(angle) axis
  const Real sine = 0.5 * std::hypot(twice[0], twice[1], twice[2]), cosine = 0.5 * (R_[0] + R_[4] + R_[8] - 1);
  const Real angle = std::atan2(sine, cosine);
  if (sine < 1e-12) return {0.5 * twice[0], 0.5 * twice[1], 0.5 * twice[2]};
  return {angle * twice[0] / (2 * sine), angle * twice[1] / (2 * sine), angle * twice[2] / (2 * sine)};
}

Real RigidMotion::kinetic_energy() const {
  if (!is_free()) return 0;
  return 0.5 * (dot(angular_velocity_, angular_momentum_) + (spec_.hinge ? 0 : mass_ * dot(velocity_, velocity_)));
}

Real RigidMotion::stable_dt() const {
  if (spec_.spring == 0) return std::numeric_limits<Real>::infinity();
  return std::sqrt(inertia_ / spec_.spring);
}

void RigidMotion::declare_state(State& state) {
  state.add("pivot", pivot_);
  state.add("velocity", velocity_);
  state.add("rotation", R_);
  state.add("angular_velocity", angular_velocity_);
  state.add("angular_momentum", angular_momentum_);
  state.add("angle", angle_);
}

}  // namespace matpoint
