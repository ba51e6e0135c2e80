#include "body/particle_body.hpp"

#include <algorithm>
#include <cmath>

#include "core/parallel.hpp"
#include "grid/grid.hpp"

namespace matpoint {
namespace {

Index chunk_count(Index particles) { return (particles + k_chunk - 1) / k_chunk; }

}  // namespace

template <int Dim>
ParticleBody<Dim>::ParticleBody(const BodySpec& spec, const Grid<Dim>& grid, const TransferTable<Dim>& transfer)
    : name_(spec.name), material_(spec.material), transfer_(transfer) {
  const GridGeometry geometry = grid.geometry();
  const std::string where = fmt::format("{}{}body \"{}\"", spec.place, spec.place.empty() ? "" : ": ", spec.name);
  const Seeds seeds = [&] {
    try {
      return spec.layout->fill(*spec.region, {Dim, geometry.lower, geometry.cell_size});
    } catch (const InputError& error) {
      throw InputError("{}: {}", where, error.what());
    }
  }();
  if (seeds.position.empty()) {
    throw InputError("{}: no particle lies in its region; make the region larger or the layout finer", where);
  }
  if (seeds.position.size() > 0xfffffff0u) throw InputError("{}: {} particles are more than 2^32", where, seeds.position.size());
  const Index n = static_cast<Index>(seeds.position.size());
  particles_.resize(n, material_->history_size());
  for (Index p = 0; p < n; ++p) {
    const auto s = static_cast<std::size_t>(p);
    const Vec3& x = seeds.position[s];
    const Vec3 v = spec.velocity ? spec.velocity->at(x) : Vec3{};
    for (std::size_t d = 0; d < Dim; ++d) {
      particles_.x[d][s] = x[d];
      particles_.v[d][s] = v[d];
    }
    particles_.volume0[s] = seeds.volume[s];
    particles_.mass[s] = seeds.volume[s] * material_->density();
    mass_ += particles_.mass[s];
    if (is_outside(grid, p)) {
      const GridView<Dim>& view = grid.view();
      std::vector<Real> lower(view.lower, view.lower + Dim);
      std::vector<Real> upper(view.upper, view.upper + Dim);
      throw InputError("{}: particle {} at [{}] is outside the grid [{}] to [{}]; move the body or enlarge the grid", where, p,
                       fmt::join(x.begin(), x.begin() + Dim, ", "), fmt::join(lower, ", "), fmt::join(upper, ", "));
    }
  }
  reports_.resize(static_cast<std::size_t>(chunk_count(n)));
}

template <int Dim>
bool ParticleBody<Dim>::is_outside(const Grid<Dim>& grid, Index p) const {
  for (int d = 0; d < Dim; ++d) {
    const Real x = particles_.x[d][static_cast<std::size_t>(p)];
    if (!(x >= grid.view().lower[d] && x <= grid.view().upper[d])) return true;
  }
  return false;
}

template <int Dim>
Vec3 ParticleBody<Dim>::position(Index p) const {
  Vec3 x{};
  for (std::size_t d = 0; d < Dim; ++d) x[d] = particles_.x[d][static_cast<std::size_t>(p)];
  return x;
}

template <int Dim>
void ParticleBody<Dim>::sort_by_cell(const Grid<Dim>& grid) {
  const GridView<Dim>& view = grid.view();
  const auto n = static_cast<std::size_t>(particles_.count());
  std::vector<std::uint32_t> cell(n);
  Index cells = 1;
  for (int d = 0; d < Dim; ++d) {
    for (std::size_t p = 0; p < n; ++p) {
      Real xi;
      cell[p] += static_cast<std::uint32_t>(cells * locate_in_cell<Dim>(view, d, particles_.x[d][p], xi));
    }
    cells *= view.cells[d];
  }
  std::vector<std::uint32_t> begin(static_cast<std::size_t>(cells) + 1, 0);
  for (std::uint32_t c : cell) ++begin[c + 1];
  for (std::size_t c = 0; c < static_cast<std::size_t>(cells); ++c) begin[c + 1] += begin[c];
  std::vector<std::uint32_t> order(n);
  for (std::size_t p = 0; p < n; ++p) order[begin[cell[p]]++] = static_cast<std::uint32_t>(p);
  particles_.permute(order);
  moved_since_sort_ = 0;
  is_sorted_ = true;
  is_band_order_valid_ = false;
}

template <int Dim>
void ParticleBody<Dim>::order_by_band(const Grid<Dim>& grid) {
  const auto n = static_cast<std::size_t>(particles_.count());
  const Particles<Dim>& particles = particles_;
  band_begin_.assign(static_cast<std::size_t>(grid.band_count()) + 1, 0);
  for (std::size_t p = 0; p < n; ++p) ++band_begin_[static_cast<std::size_t>(grid.band_of(particles.x[Dim - 1][p])) + 1];
  for (std::size_t b = 1; b < band_begin_.size(); ++b) band_begin_[b] += band_begin_[b - 1];
  band_order_.resize(n);
  std::vector<Index> next = band_begin_;
  for (std::size_t p = 0; p < n; ++p) {
    const auto band = static_cast<std::size_t>(grid.band_of(particles.x[Dim - 1][p]));
    band_order_[static_cast<std::size_t>(next[band]++)] = static_cast<std::uint32_t>(p);
  }
  is_band_order_valid_ = true;
}

template <int Dim>
void ParticleBody<Dim>::locate(const Grid<Dim>& grid, std::vector<char>& is_band_occupied) {
  // Neighbours in space should be neighbours in memory; sorted anew when half of the particles have crossed into another cell.
  if (!is_sorted_ || 2 * moved_since_sort_ > particles_.count()) sort_by_cell(grid);
  if (!is_band_order_valid_) order_by_band(grid);
  for (std::size_t band = 0; band + 1 < band_begin_.size(); ++band) {
    if (band_begin_[band + 1] > band_begin_[band]) is_band_occupied[band] = 1;
  }
}

template <int Dim>
void ParticleBody<Dim>::p2g(Grid<Dim>& grid, Map what) {
  const auto kernel = what == Map::momentum ? transfer_.p2g_momentum : transfer_.p2g_momentum_and_force;
  const ParticleView<Dim> view = particles_.view();
  const Index bands = grid.band_count();
  // Neighbouring bands share a row of nodes: first all even bands, then all odd ones, so no two threads add to one node, and each
  // node's sum is formed in the same order always.
  for (Index parity = 0; parity < 2; ++parity) {
    parallel_for((bands + 1 - parity) / 2, particles_.count(), [&](Index k) {
      const auto band = static_cast<std::size_t>(2 * k + parity);
      if (band_begin_[band] < band_begin_[band + 1]) {
        kernel(grid.view(), view, band_order_.data(), band_begin_[band], band_begin_[band + 1]);
      }
    });
  }
}

template <int Dim>
void ParticleBody<Dim>::g2p(const Grid<Dim>& grid, Gather what, Real dt, Real flip) {
  const auto kernel = transfer_.g2p(what);
  const bool has_gradient = what == Gather::all || what == Gather::gradient_move || what == Gather::gradient;
  const bool moves = what == Gather::all || what == Gather::gradient_move || what == Gather::velocity_move;
  const ParticleView<Dim> view = particles_.view();
  const Index n = particles_.count();
  const Index chunks = chunk_count(n);
  reports_.resize(static_cast<std::size_t>(chunks));
  parallel_for(chunks, n, [&](Index chunk) {
    const Index begin = chunk * k_chunk;
    const Index count = std::min(k_chunk, n - begin);
    alignas(64) Real L[Dim * Dim * k_chunk];
    ChunkReport report;
    kernel(grid.view(), view, begin, count, dt, flip, L, report.gather);
    if (has_gradient) {
      PointBlock block;
      block.count = count;
      block.dt = dt;
      for (int k = 0; k < Dim * Dim; ++k) {
        block.F[k] = view.F[k] + begin;
        block.L[k] = L + k * k_chunk;
      }
      for (int k = 0; k < k_stress_size<Dim>; ++k) block.tau[k] = view.tau[k] + begin;
      block.volume0 = view.volume0 + begin;
      Real* history[64];
      for (std::size_t k = 0; k < particles_.history.size(); ++k) history[k] = particles_.history[k].data() + begin;
      block.history = history;
      material_->update(block, Dim);
      report.dissipated = block.dissipated;
      report.first_inverted = block.first_inverted < 0 ? -1 : begin + block.first_inverted;
    }
    reports_[static_cast<std::size_t>(chunk)] = report;
  });
  if (has_gradient) {
    viscous_dissipation_ = 0;
    bad_slot_ = -1;
  }
  GatherReport sum;
  for (const ChunkReport& report : reports_) {
    sum.moved_cell += report.gather.moved_cell;
    sum.moved_band += report.gather.moved_band;
    sum.outside += report.gather.outside;
    if (has_gradient) {
      viscous_dissipation_ += report.dissipated;
      if (bad_slot_ < 0) bad_slot_ = report.first_inverted;
    }
  }
  if (moves) {
    has_escapes_ = sum.outside > 0;
    moved_since_sort_ += sum.moved_cell;
    if (sum.moved_band > 0) is_band_order_valid_ = false;
  }
}

template <int Dim>
BadPoint ParticleBody<Dim>::bad_point() const {
  if (bad_slot_ < 0) return {};
  return {particles_.id[static_cast<std::size_t>(bad_slot_)], position(bad_slot_), particles_.J(bad_slot_)};
}

template <int Dim>
void ParticleBody<Dim>::append_escapes(const Grid<Dim>& grid, std::size_t body, std::vector<Escape>& escapes) const {
  if (!has_escapes_) return;
  for (Index p = 0; p < particles_.count(); ++p) {
    if (!is_outside(grid, p)) continue;
    Escape escape{body, particles_.id[static_cast<std::size_t>(p)], position(p), {}};
    for (std::size_t d = 0; d < Dim; ++d) escape.velocity[d] = particles_.v[d][static_cast<std::size_t>(p)];
    escapes.push_back(escape);
  }
}

template <int Dim>
void ParticleBody<Dim>::remove_escaped(const Grid<Dim>& grid, const Vec3& gravity, Ledger& ledger) {
  if (!has_escapes_) return;
  std::vector<std::uint32_t> kept;
  for (Index p = 0; p < particles_.count(); ++p) {
    if (!is_outside(grid, p)) {
      kept.push_back(static_cast<std::uint32_t>(p));
      continue;
    }
    const BodyTotals lost = totals_of(p, p + 1, gravity);
    ++ledger.removed_count;
    ledger.removed_mass += lost.mass;
    mass_ -= lost.mass;
    ledger.removed_energy += lost.kinetic_energy + lost.strain_energy + lost.gravitational_energy;
    for (std::size_t d = 0; d < 3; ++d) ledger.removed_momentum[d] += lost.momentum[d];
  }
  particles_.permute(kept);
  is_band_order_valid_ = false;
  has_escapes_ = false;
}

template <int Dim>
Real ParticleBody<Dim>::stable_dt(const Grid<Dim>& grid) const {
  struct Extremes {
    Real J_min = 1;
    Real J_max = 1;
    Real speed_max[Dim] = {};
  };
  const Index n = particles_.count();
  std::vector<Extremes> extremes(static_cast<std::size_t>(chunk_count(n)));
  parallel_for(chunk_count(n), n, [&](Index chunk) {
    Extremes e;
    for (Index p = chunk * k_chunk; p < std::min(n, (chunk + 1) * k_chunk); ++p) {
      const Real J = particles_.J(p);
      e.J_min = std::min(e.J_min, J);
      e.J_max = std::max(e.J_max, J);
      for (int d = 0; d < Dim; ++d) e.speed_max[d] = std::max(e.speed_max[d], std::abs(particles_.v[d][static_cast<std::size_t>(p)]));
    }
    extremes[static_cast<std::size_t>(chunk)] = e;
  });
  Extremes all;
  for (const Extremes& e : extremes) {
    all.J_min = std::min(all.J_min, e.J_min);
    all.J_max = std::max(all.J_max, e.J_max);
    for (int d = 0; d < Dim; ++d) all.speed_max[d] = std::max(all.speed_max[d], e.speed_max[d]);
  }
  Real dt = std::numeric_limits<Real>::infinity();
  for (const Real J : {all.J_min, Real{1}, all.J_max}) {
    const Real wave_speed = material_->wave_speed(J);
    const Real viscosity = material_->kinematic_viscosity(J);
    for (int d = 0; d < Dim; ++d) {
      const Real h = grid.view().cell_size[d];
      dt = std::min(dt, h / (wave_speed + all.speed_max[d]));
      if (viscosity > 0) dt = std::min(dt, h * h / (2 * Dim * viscosity));
    }
  }
  return dt;
}

template <int Dim>
Real ParticleBody<Dim>::smallest_particle_mass() const {
  return particles_.mass.empty() ? std::numeric_limits<Real>::infinity()
                                 : *std::min_element(particles_.mass.begin(), particles_.mass.end());
}

template <int Dim>
Index ParticleBody<Dim>::memory() const {
  return particles_.memory() + static_cast<Index>(band_order_.size() * sizeof(std::uint32_t));
}

template class ParticleBody<2>;
template class ParticleBody<3>;

}  // namespace matpoint
