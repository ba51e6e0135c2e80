#include "implicit/balance.hpp"

namespace matpoint {
namespace {

// Measured on bounces of a block and a disk, E = 1e5 to 1e7, steps of 2 and 0.5 ms: greatest gain of energy 1.6 % after one, 0.7 % after
// four, 0.5 % after ten, 3.5 % after twenty; what it costs falls all the time.
constexpr int k_rounds = 10;

/// Calls f(cell, place of the particle, mass).
template <int Dim, class F>
void for_each_mass(const StepSpace<Dim>& space, F&& f) {
  for (std::size_t c = 0; c < space.cells().size(); ++c) {
    const std::vector<Real>& mass = space.sources()[space.source_of(c)].points->mass;
    for (Index k = space.cell_begin(c); k < space.cell_end(c); ++k)
      f(c, k, mass[static_cast<std::size_t>(space.particles()[static_cast<std::size_t>(k)])]);
  }
}

template <int Dim>
Vec<Dim> value_at(const StepSpace<Dim>& space, std::size_t c, Index k, const std::vector<Real>& a) {
  Vec<Dim> value{};
  for (int i = 0; i < space.functions(); ++i) {
    for (std::size_t d = 0; d < Dim; ++d) value[d] += space.N(k)[i] * a[static_cast<std::size_t>(space.cell_nodes(c)[i]) * Dim + d];
  }
  return value;
}

template <int Dim>
std::vector<Real> mass_times(const StepSpace<Dim>& space, const std::vector<Real>& a) {
  std::vector<Real> product(a.size(), 0);
  for_each_mass(space, [&](std::size_t c, Index k, Real mass) {
    const Vec<Dim> value = value_at(space, c, k, a);
    for (int i = 0; i < space.functions(); ++i) {
      for (std::size_t d = 0; d < Dim; ++d)
        product[static_cast<std::size_t>(space.cell_nodes(c)[i]) * Dim + d] += mass * space.N(k)[i] * value[d];
    }
  });
  return product;
}

}  // namespace

template <int Dim>
BalancedMotion<Dim> balanced_motion(const StepSpace<Dim>& space, const std::vector<Real>& force) {
  std::vector<Real> is_free(force.size());
  for (std::size_t k = 0; k < force.size(); ++k)
    is_free[k] = space.unknown(static_cast<Index>(k / Dim), static_cast<int>(k % Dim)) < 0 ? 0 : 1;
  const std::vector<Real> row_sums = mass_times(space, is_free);
  std::vector<Real> a(force.size(), 0);
  BalancedMotion<Dim> motion;
  motion.force.assign(force.size(), 0);
  for (int round = 0; round < k_rounds; ++round) {
    for (std::size_t k = 0; k < a.size(); ++k) {
      if (is_free[k] > 0 && row_sums[k] > 0) a[k] += (force[k] - motion.force[k]) / row_sums[k];
    }
    motion.force = mass_times(space, a);
  }
  for (const PointSource<Dim>& source : space.sources())
    motion.accelerations.emplace_back(static_cast<std::size_t>(source.points->count()), Vec<Dim>{});
  for_each_mass(space, [&](std::size_t c, Index k, Real) {
    const auto row = static_cast<std::size_t>(space.particles()[static_cast<std::size_t>(k)]);
    motion.accelerations[space.source_of(c)][row] = value_at(space, c, k, a);
  });
  return motion;
}

template BalancedMotion<2> balanced_motion<2>(const StepSpace<2>&, const std::vector<Real>&);
template BalancedMotion<3> balanced_motion<3>(const StepSpace<3>&, const std::vector<Real>&);

}  // namespace matpoint
