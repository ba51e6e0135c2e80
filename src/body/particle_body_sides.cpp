// Particles that have passed a side of the grid, or the surface of a region, which holds them: put back, with books.
#include <algorithm>
#include <cmath>

#include "body/particle_body.hpp"
#include "geometry/region.hpp"

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
    const Real velocity = side->velocity.at(outside.position)[s];
    if (is_upper ? velocity > 0 : velocity < 0) return false;
    cell[s] = is_upper ? grid_.cells(d) - 1 : 0;
    fields[static_cast<std::size_t>(at.x + d)] = static_cast<R>(is_upper ? 1 - k_inside : k_inside);
    const Real back = is_upper ? grid_.upper(d) - k_inside * grid_.cell_size(d) : grid_.lower(d) + k_inside * grid_.cell_size(d);
    books.press(side->condition, s, 0, -m * gravity[s] * (back - x));
    R& v = fields[static_cast<std::size_t>(at.v + d)];
    const Real old = v;
    const Real held = is_upper ? std::min(old, velocity) : std::max(old, velocity);
    v = static_cast<R>(held);
    const Real impulse = m * (held - old);
    books.press(side->condition, s, impulse, impulse * velocity);
    books.contact_dissipation += impulse * velocity - 0.5 * m * (held * held - old * old);
    for (int c = 0; at.C >= 0 && c < Dim; ++c) fields[static_cast<std::size_t>(at.C + d * Dim + c)] = 0;
  }
  blocks_->insert(cell, fields.data());
  mass_ += m;
  ledger.add_boundaries(books);
  ledger.contact_dissipation += books.contact_dissipation;
  return true;
}

template <int Dim, class R>
void ParticleBody<Dim, R>::note_inside(const std::vector<Obstacle>& obstacles) {
  constexpr Real k_surface = 1e-3;  // of a cell
  inside_.assign(obstacles.size(), {});
  if (!is_fluid()) return;
  for_each_particle([&](const Particle& p) {
    for (std::size_t o = 0; o < obstacles.size(); ++o) {
      // One on the surface is not in it.
      bool is_inside = obstacles[o].region->contains(p.position);
      for (int d = 0; d < Dim && is_inside; ++d) {
        for (const Real sign : {1, -1}) {
          Vec3 beside = p.position;
          beside[static_cast<std::size_t>(d)] += sign * k_surface * grid_.cell_size(d);
          is_inside = is_inside && obstacles[o].region->contains(beside);
        }
      }
      if (is_inside) inside_[o].insert(id(p));
    }
  });
}

/// The nodes in a wall hold what is beside it, but a fluid may seep between two of them where the wall is thin, or where two walls meet.
/// Solids have their own strength against that.
template <int Dim, class R>
Index ParticleBody<Dim, R>::keep_out(const std::vector<Obstacle>& obstacles, const Vec3& gravity, Ledger& ledger) {
  if (!is_fluid()) return 0;
  constexpr int L = k_lanes<R>;
  struct Report {
    Index count = 0;
    Ledger books;
  };
  std::vector<Report> reports(blocks_->bands().size());
  for_each_band([&](std::size_t b) {
    Band& band = blocks_->bands()[b];
    blocks_->list_blocks(band);
    std::vector<Mover<R>> movers;
    for (Block<Dim, R>* const block : band.blocks) {
      movers.clear();
      for (std::size_t o = 0; o < obstacles.size(); ++o) {
        const Vec3 lower = obstacles[o].region->lower(), upper = obstacles[o].region->upper();
        bool is_near = true;
        for (std::size_t d = 0; d < Dim; ++d) {
          const int axis = static_cast<int>(d);
          const Real begin = grid_.lower(axis) + block->first[d] * grid_.cell_size(axis);
          const Real end = begin + (d == 0 ? L : 1) * grid_.cell_size(axis);
          is_near = is_near && lower[d] <= end && upper[d] >= begin;
        }
        for (int k = 0; is_near && k < block->slot_count; ++k) {
          for (int lane = 0; lane < L; ++lane) {
            if (k >= block->count(lane)) continue;
            R* const fields = block->slot(k) + lane;
            const Vec3 x = blocks_->position(*block, fields, lane);
            if (!obstacles[o].region->contains(x)) continue;
            if (!inside_[o].empty() && inside_[o].count(id_from_bits(fields[blocks_->layout().id * L])) > 0) continue;
            if (!push_out(fields, x, obstacles[o], gravity, reports[b].books)) continue;
            ++reports[b].count;
            bool is_elsewhere = false;
            for (int d = 0; d < Dim; ++d) {
              const R place = fields[(blocks_->layout().x + d) * L];
              is_elsewhere = is_elsewhere || place < 0 || place >= 1;
            }
            const bool is_listed =
                std::any_of(movers.begin(), movers.end(), [&](const Mover<R>& m) { return m.slot == k && m.lane == lane; });
            if (is_elsewhere && !is_listed) movers.push_back({k, lane, {}});
          }
        }
      }
      if (!movers.empty()) blocks_->extract(band, *block, movers);
    }
  });
  Index count = 0;
  for (const Report& report : reports) {
    count += report.count;
    ledger.add_boundaries(report.books);
    ledger.contact_dissipation += report.books.contact_dissipation;
  }
  if (count > 0) settle(Sweep::usl);
  return count;
}

template <int Dim, class R>
bool ParticleBody<Dim, R>::push_out(R* fields, Vec3 position, const Obstacle& obstacle, const Vec3& gravity, Ledger& books) const {
  constexpr int L = k_lanes<R>;
  constexpr int k_halvings = 20;
  constexpr Real k_first = 1.0 / 256;  // of a cell
  const SlotLayout<Dim>& at = blocks_->layout();
  const Real m = volume0(Particle{fields, L, position}) * material_->density();
  const Vec3 wall = obstacle.velocity.at(position);
  Real cell_size = grid_.cell_size(0);
  for (int d = 1; d < Dim; ++d) cell_size = std::min(cell_size, grid_.cell_size(d));
  // The shortest way out that stays in the grid: across the surface, or along an axis.
  std::vector<Vec3> directions = obstacle.region->has_normal() ? obstacle.region->normals(position, Dim) : std::vector<Vec3>{};
  for (std::size_t d = 0; d < Dim; ++d) {
    for (const Real sign : {1, -1}) {
      directions.emplace_back();
      directions.back()[d] = sign;
    }
  }
  const auto across = [&](const Vec3& n) {  // beside the wall
    Real sum = 0;
    for (std::size_t d = 0; d < Dim; ++d) sum += (static_cast<Real>(fields[(at.v + static_cast<int>(d)) * L]) - wall[d]) * n[d];
    return sum;
  };
  Real shortest = 2 * cell_size;
  Vec3 n{};
  for (const Vec3& direction : directions) {
    const auto is_inside = [&](Real way) {
      Vec3 x = position;
      for (std::size_t d = 0; d < Dim; ++d) x[d] += way * direction[d];
      return obstacle.region->contains(x);
    };
    Real inside = 0, outside = k_first * cell_size;
    while (outside < shortest && is_inside(outside)) {
      inside = outside;
      outside *= 2;
    }
    if (outside >= shortest) continue;
    for (int k = 0; k < k_halvings; ++k) {
      const Real middle = 0.5 * (inside + outside);
      (is_inside(middle) ? inside : outside) = middle;
    }
    bool is_in_grid = true;
    for (std::size_t d = 0; d < Dim; ++d) {
      const Real x = position[d] + outside * direction[d];
      is_in_grid = is_in_grid && x >= grid_.lower(static_cast<int>(d)) && x <= grid_.upper(static_cast<int>(d));
    }
    if (!is_in_grid) continue;
    shortest = outside;
    n = direction;
  }
  if (!(dot(n, n) > 0)) return false;
  const Real approach = std::min(across(n), Real{0});
  for (std::size_t d = 0; d < Dim; ++d) {
    const int axis = static_cast<int>(d);
    R& x = fields[(at.x + axis) * L];
    const Real way = shortest * n[d];
    x = static_cast<R>(x + way / grid_.cell_size(axis));
    R& v = fields[(at.v + axis) * L];
    const Real old = v;
    v = static_cast<R>(old - approach * n[d]);
    const Real impulse = m * (static_cast<Real>(v) - old);
    books.press(obstacle.condition, d, impulse, impulse * wall[d] - m * gravity[d] * way);
    books.contact_dissipation += impulse * wall[d] - 0.5 * m * (static_cast<Real>(v) * static_cast<Real>(v) - old * old);
    for (int c = 0; at.C >= 0 && c < Dim; ++c) fields[(at.C + axis * Dim + c) * L] = 0;
  }
  return true;
}

template void ParticleBody<2, double>::return_escaped(const std::vector<ClosedSide>&, const Vec3&, Ledger&);
template void ParticleBody<3, double>::return_escaped(const std::vector<ClosedSide>&, const Vec3&, Ledger&);
template void ParticleBody<2, float>::return_escaped(const std::vector<ClosedSide>&, const Vec3&, Ledger&);
template void ParticleBody<3, float>::return_escaped(const std::vector<ClosedSide>&, const Vec3&, Ledger&);

#define MATPOINT_INSTANTIATE(Dim, R)                                                 \
  template void ParticleBody<Dim, R>::note_inside(const std::vector<Obstacle>& all); \
  template Index ParticleBody<Dim, R>::keep_out(const std::vector<Obstacle>& all, const Vec3& gravity, Ledger& ledger);
MATPOINT_INSTANTIATE(2, double)
MATPOINT_INSTANTIATE(3, double)
MATPOINT_INSTANTIATE(2, float)
MATPOINT_INSTANTIATE(3, float)
#undef MATPOINT_INSTANTIATE

}  // namespace matpoint
