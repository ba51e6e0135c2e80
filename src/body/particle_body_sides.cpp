// Particles that have passed a side of the grid which holds them: put back, with books.
#include <algorithm>

#include "body/particle_body.hpp"

namespace matpoint {

template <int Dim, class R>
void ParticleBody<Dim, R>::return_escaped(const std::vector<ClosedSide>& sides, const Vec3& gravity, Ledger& ledger) {
  const auto is_back = [&](Outside& outside) { return put_back(outside, sides, gravity, ledger); };
  const auto first_lost = std::remove_if(outside_.begin(), outside_.end(), is_back);
  const Index count = outside_.end() - first_lost;
  outside_.erase(first_lost, outside_.end());
  ledger.returned_count += count;
  // As when it left (keep_outside).
  blocks_->add_to_count(count);
}

/// A wall on nodes slows what comes near, and stops it only as far as the particle weighs at its nodes: one alone in a cell, or one that is
/// pressed against the wall harder than a node can hold in a step, may pass. So the wall acts on the particle itself, by an impulse.
template <int Dim, class R>
bool ParticleBody<Dim, R>::put_back(Outside& outside, const std::vector<ClosedSide>& sides, const Vec3& gravity, Ledger& ledger) {
  constexpr Real k_inside = 1e-6;  // of a cell
  const SlotLayout<Dim>& at = blocks_->layout();
  Place<Dim> cell{};
  std::vector<R> fields = outside.fields;
  const Real m = volume0(particle_of(outside)) * material_->density();
  Ledger books;
  for (int d = 0; d < Dim; ++d) {
    const auto s = static_cast<std::size_t>(d);
    const Real x = outside.position[s];
    const bool is_upper = x >= grid_.upper(d);
    if (!is_upper && x >= grid_.lower(d)) {
      const Real place = (x - grid_.lower(d)) / grid_.cell_size(d);
      cell[s] = std::clamp(static_cast<int>(place), 0, grid_.cells(d) - 1);
      fields[static_cast<std::size_t>(at.x + d)] = static_cast<R>(std::min(place - cell[s], 1 - k_inside));
      continue;
    }
    const auto side =
        std::find_if(sides.begin(), sides.end(), [&](const ClosedSide& one) { return one.axis == d && one.is_upper == is_upper; });
    if (side == sides.end()) return false;
    cell[s] = is_upper ? grid_.cells(d) - 1 : 0;
    fields[static_cast<std::size_t>(at.x + d)] = static_cast<R>(is_upper ? 1 - k_inside : k_inside);
    const Real back = is_upper ? grid_.upper(d) - k_inside * grid_.cell_size(d) : grid_.lower(d) + k_inside * grid_.cell_size(d);
    books.boundary_work -= m * gravity[s] * (back - x);
    R& v = fields[static_cast<std::size_t>(at.v + d)];
    const Real old = v;
    const Real held = is_upper ? std::min(old, side->velocity) : std::max(old, side->velocity);
    v = static_cast<R>(held);
    const Real impulse = m * (held - old);
    books.boundary_impulse[s] += impulse;
    books.boundary_work += impulse * side->velocity;
    books.contact_dissipation += impulse * side->velocity - 0.5 * m * (held * held - old * old);
    for (int c = 0; at.C >= 0 && c < Dim; ++c) fields[static_cast<std::size_t>(at.C + d * Dim + c)] = 0;
  }
  blocks_->insert(cell, fields.data());
  mass_ += m;
  ledger.boundary_work += books.boundary_work;
  ledger.contact_dissipation += books.contact_dissipation;
  for (std::size_t d = 0; d < 3; ++d) ledger.boundary_impulse[d] += books.boundary_impulse[d];
  return true;
}

template void ParticleBody<2, double>::return_escaped(const std::vector<ClosedSide>&, const Vec3&, Ledger&);
template void ParticleBody<3, double>::return_escaped(const std::vector<ClosedSide>&, const Vec3&, Ledger&);
template void ParticleBody<2, float>::return_escaped(const std::vector<ClosedSide>&, const Vec3&, Ledger&);
template void ParticleBody<3, float>::return_escaped(const std::vector<ClosedSide>&, const Vec3&, Ledger&);

}  // namespace matpoint
