#include "body/particles.hpp"

#include <algorithm>
#include <numeric>

#include "core/parallel.hpp"

namespace matpoint {

template <int Dim>
template <class Function>
void Particles<Dim>::for_each_array(Function&& f) {
  for (auto& a : x) f(a);
  for (auto& a : v) f(a);
  for (auto& a : F) f(a);
  for (auto& a : tau) f(a);
  for (auto& a : displacement) f(a);
  f(mass);
  f(volume0);
  for (auto& a : history) f(a);
}

template <int Dim>
void Particles<Dim>::resize(Index n, Index history_size) {
  history.resize(static_cast<std::size_t>(history_size));
  for_each_array([&](Array& array) { array.assign(static_cast<std::size_t>(n), 0); });
  for (int d = 0; d < Dim; ++d) std::fill(F[d * Dim + d].begin(), F[d * Dim + d].end(), Real{1});
  id.resize(static_cast<std::size_t>(n));
  std::iota(id.begin(), id.end(), std::int64_t{0});
}

template <int Dim>
ParticleView<Dim> Particles<Dim>::view() {
  ParticleView<Dim> view{};
  for (int d = 0; d < Dim; ++d) {
    view.x[d] = x[d].data();
    view.v[d] = v[d].data();
    view.displacement[d] = displacement[d].data();
  }
  for (int k = 0; k < Dim * Dim; ++k) view.F[k] = F[k].data();
  for (int k = 0; k < k_stress_size<Dim>; ++k) view.tau[k] = tau[k].data();
  view.mass = mass.data();
  view.volume0 = volume0.data();
  return view;
}

template <int Dim>
Real Particles<Dim>::J(Index slot) const {
  const auto p = static_cast<std::size_t>(slot);
  if constexpr (Dim == 2) {
    return F[0][p] * F[3][p] - F[1][p] * F[2][p];
  } else {
    return F[0][p] * (F[4][p] * F[8][p] - F[5][p] * F[7][p]) - F[1][p] * (F[3][p] * F[8][p] - F[5][p] * F[6][p]) +
           F[2][p] * (F[3][p] * F[7][p] - F[4][p] * F[6][p]);
  }
}

template <int Dim>
void Particles<Dim>::permute(const std::vector<std::uint32_t>& order) {
  std::vector<Array*> arrays;
  for_each_array([&](Array& array) { arrays.push_back(&array); });
  parallel_for(static_cast<Index>(arrays.size()) + 1, count(), [&](Index k) {
    const auto apply = [&](auto& array) {
      std::remove_reference_t<decltype(array)> sorted(order.size());
      for (std::size_t n = 0; n < order.size(); ++n) sorted[n] = array[order[n]];
      array.swap(sorted);
    };
    if (k < static_cast<Index>(arrays.size())) {
      apply(*arrays[static_cast<std::size_t>(k)]);
    } else {
      apply(id);
    }
  });
}

template <int Dim>
std::vector<std::uint32_t> Particles<Dim>::slots_by_id() const {
  constexpr std::uint32_t k_none = 0xffffffffu;
  std::int64_t id_end = 0;
  for (std::int64_t i : id) id_end = std::max(id_end, i + 1);
  std::vector<std::uint32_t> slot_of(static_cast<std::size_t>(id_end), k_none);
  for (std::size_t slot = 0; slot < id.size(); ++slot) slot_of[static_cast<std::size_t>(id[slot])] = static_cast<std::uint32_t>(slot);
  std::erase(slot_of, k_none);  // ids of particles that were removed
  return slot_of;
}

template <int Dim>
Index Particles<Dim>::memory() const {
  Index arrays = 0;
  const_cast<Particles*>(this)->for_each_array([&](const Array&) { ++arrays; });
  return count() * static_cast<Index>(sizeof(Real)) * (arrays + 1);
}

template class Particles<2>;
template class Particles<3>;

}  // namespace matpoint
