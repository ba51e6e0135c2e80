// What a body of particles keeps from one step to the next.
#include "body/particle_body.hpp"
#include "core/state.hpp"

namespace matpoint {

template <int Dim, class R>
void ParticleBody<Dim, R>::clear() {
  blocks_->clear();
  outside_.clear();
  seats_.clear();
}

template <int Dim, class R>
void ParticleBody<Dim, R>::declare_state(State& state) {
  blocks_->declare_state(state);
  state.add("sweeps_since_prune", sweeps_since_prune_);
  state.add("mass", mass_);
  state.part("spin", spin_);
  // Those that the last step left outside of the grid, where the run ends with them.
  std::vector<R> outside;
  std::vector<Vec3> outside_positions;
  const auto stride = static_cast<std::size_t>(blocks_->layout().field_count);
  for (const Outside& one : outside_) {
    outside.insert(outside.end(), one.fields.begin(), one.fields.end());
    outside_positions.push_back(one.position);
  }
  state.add("outside_fields", outside);
  state.add("outside_position", outside_positions);
  if (outside.size() != outside_positions.size() * stride) state.fail("outside_fields", "has not one row for each position");
  if (state.is_loading()) {
    for (std::size_t k = 0; k < outside_positions.size(); ++k) {
      const auto begin = outside.begin() + static_cast<std::ptrdiff_t>(k * stride);
      outside_.push_back({{begin, begin + static_cast<std::ptrdiff_t>(stride)}, outside_positions[k]});
    }
  }
  if (state.is_loading()) {
    std::vector<bool> is_taken(static_cast<std::size_t>(id_count_), false);
    for_each_particle([&](const Particle& p) {
      const auto number = static_cast<std::size_t>(id(p));
      if (number >= is_taken.size() || is_taken[number]) {
        state.fail("id", fmt::format("has {} {}; each particle has its own, below {}", number, number < is_taken.size() ? "twice" : "in it",
                                     is_taken.size()));
      }
      is_taken[number] = true;
    });
  }
  state.in("inside_obstacle", [&] {
    for (std::size_t k = 0; k < inside_.size(); ++k) state.add(std::to_string(k), inside_[k]);
  });
  state.add("greatest_velocity", speed_max_);
  state.add("J_min", J_min_);
  state.add("J_max", J_max_);
  state.add("wave_modulus", wave_modulus_);
}

template void ParticleBody<2, double>::clear();
template void ParticleBody<3, double>::clear();
template void ParticleBody<2, float>::clear();
template void ParticleBody<3, float>::clear();
template void ParticleBody<2, double>::declare_state(State&);
template void ParticleBody<3, double>::declare_state(State&);
template void ParticleBody<2, float>::declare_state(State&);
template void ParticleBody<3, float>::declare_state(State&);

}  // namespace matpoint
