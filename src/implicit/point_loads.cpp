#include "implicit/point_loads.hpp"

#include <algorithm>

namespace matpoint {
namespace {

/// d cof(A)_ij / dA_kl
template <int Dim>
Real cofactor_slope(const Real* A, int i, int j, int k, int l) {
  if (i == k || j == l) return 0;
  if constexpr (Dim == 2) {
    return i == j ? 1 : -1;
  } else {
    // What is left of the rows and columns, and the sign of both permutations.
    const int n = 3 - i - k, q = 3 - j - l;
    const int sign = ((k - i + 3) % 3 == 1 ? 1 : -1) * ((l - j + 3) % 3 == 1 ? 1 : -1);
    return sign * A[n * 3 + q];
  }
}

}  // namespace

template <int Dim>
PointLoads<Dim>::PointLoads(const Case& problem, const SeedingGrid& grid, const StepSpace<Dim>& space)
    : space_(space), loads_(particle_loads<Dim>(problem, grid)) {
  for (ParticleLoad<Dim>& load : loads_) {
    const PointBody<Dim>& body = *space.sources()[load.body()].points;
    std::vector<std::int32_t> places(static_cast<std::size_t>(body.count()), -1);
    for (std::size_t p = 0; p < load.ids().size(); ++p) places[static_cast<std::size_t>(load.ids()[p])] = static_cast<std::int32_t>(p);
    places_.push_back(std::move(places));
    if (!problem.bodies[load.body()].initial_stress) continue;
    std::vector<Real> F;
    for (const Index id : load.ids()) F.insert(F.end(), body.F.begin() + id * Dim * Dim, body.F.begin() + (id + 1) * Dim * Dim);
    load.refer_to(F, std::vector<Real>(load.ids().size(), 1));
  }
}

template <int Dim>
bool PointLoads<Dim>::follows() const {
  return std::any_of(loads_.begin(), loads_.end(), [](const auto& load) { return load.follows(); });
}

template <int Dim>
void PointLoads<Dim>::start() {
  points_.clear();
  first_.assign(1, 0);
  for (std::size_t c = 0; c < space_.cells().size() && !loads_.empty(); ++c) {
    const std::size_t source = space_.source_of(c);
    for (std::size_t load = 0; load < loads_.size(); ++load) {
      if (loads_[load].body() != source) continue;
      for (Index k = space_.cell_begin(c); k < space_.cell_end(c); ++k) {
        const auto row = static_cast<std::size_t>(space_.particles()[static_cast<std::size_t>(k)]);
        const std::int32_t number = places_[load][static_cast<std::size_t>(space_.sources()[source].points->id[row])];
        if (number < 0) continue;
        const auto p = static_cast<std::size_t>(number);
        for (std::size_t face = loads_[load].first_face(p); face < loads_[load].first_face(p + 1); ++face)
          points_.push_back({load, face, row});
      }
    }
    first_.push_back(points_.size());
  }
  const auto functions = static_cast<std::size_t>(space_.functions());
  N_.resize(points_.size() * functions);
  gradients_.resize(points_.size() * functions * Dim);
  for (std::size_t k = 0; k < points_.size(); ++k) {
    const ParticleLoad<Dim>& load = loads_[points_[k].load];
    const Real* const F = space_.sources()[load.body()].points->F.data() + points_[k].row * Dim * Dim;
    const Vec<Dim> X = load.on(points_[k].number, 1, F, 1).arm;
    ElementPoint<Dim> place = space_.point(load.body(), points_[k].row);
    const std::array<Real, Dim> xi = place.xi;
    std::array<Real, Dim * Dim> J;  // dx / dxi
    for (std::size_t e = 0; e < Dim; ++e) {
      place.xi[e] = xi[e] + 1;
      const Vec<Dim> after = space_.basis().position(place);
      place.xi[e] = xi[e] - 1;
      const Vec<Dim> before = space_.basis().position(place);
      place.xi[e] = xi[e];
      for (std::size_t d = 0; d < Dim; ++d) J[d * Dim + e] = 0.5 * (after[d] - before[d]);
    }
    const std::array<Real, Dim* Dim> cof = cofactors<Dim>(J.data());
    Real det = 0;
    for (std::size_t d = 0; d < Dim; ++d) det += J[d] * cof[d];
    for (std::size_t d = 0; d < Dim; ++d) {
      Real arm = 0;
      for (std::size_t e = 0; e < Dim; ++e) arm += F[d * Dim + e] * X[e];
      for (std::size_t e = 0; e < Dim; ++e) place.xi[e] += cof[d * Dim + e] / det * arm;
    }
    space_.basis().evaluate(place, N_.data() + k * functions, gradients_.data() + k * functions * Dim);
  }
}

template <int Dim>
void PointLoads<Dim>::work(std::size_t cell, std::size_t number, const std::vector<Real>& u, Real factor, Real* residual, Real* K) const {
  const auto functions = static_cast<std::size_t>(space_.functions());
  const std::size_t width = functions * Dim;
  const Point& point = points_[number];
  const Real* const N = N_.data() + number * functions;
  const Real* const g = gradients_.data() + number * width;
  const ParticleLoad<Dim>& load = loads_[point.load];
  Vec<Dim> force = load.on(point.number, factor, space_.sources()[load.body()].points->F.data() + point.row * Dim * Dim, 1).force;
  if (load.follows()) {
    std::array<Real, Dim * Dim> A{};
    for (std::size_t d = 0; d < Dim; ++d) A[d * Dim + d] = 1;
    const int* const nodes = space_.cell_nodes(cell);
    for (std::size_t node = 0; node < functions; ++node) {
      const Real* const u_node = u.data() + static_cast<std::size_t>(nodes[node]) * Dim;
      for (std::size_t i = 0; i < Dim; ++i) {
        for (std::size_t j = 0; j < Dim; ++j) A[i * Dim + j] += u_node[i] * g[node * Dim + j];
      }
    }
    const Vec<Dim> before = force;
    const std::array<Real, Dim* Dim> cof = cofactors<Dim>(A.data());
    for (std::size_t i = 0; i < Dim; ++i) {
      force[i] = 0;
      for (std::size_t j = 0; j < Dim; ++j) force[i] += cof[i * Dim + j] * before[j];
    }
    for (std::size_t i = 0; i < Dim && K != nullptr; ++i) {
      for (std::size_t k = 0; k < Dim; ++k) {
        Vec<Dim> slope{};  // df_i / dA_kl
        for (std::size_t l = 0; l < Dim; ++l) {
          for (std::size_t j = 0; j < Dim; ++j)
            slope[l] += before[j] *
                        cofactor_slope<Dim>(A.data(), static_cast<int>(i), static_cast<int>(j), static_cast<int>(k), static_cast<int>(l));
        }
        for (std::size_t other = 0; other < functions; ++other) {
          Real change = 0;
          for (std::size_t l = 0; l < Dim; ++l) change += slope[l] * g[other * Dim + l];
          for (std::size_t I = 0; I < functions; ++I) K[(I * Dim + i) * width + other * Dim + k] -= N[I] * change;
        }
      }
    }
  }
  for (std::size_t I = 0; I < functions; ++I) {
    for (std::size_t i = 0; i < Dim; ++i) residual[I * Dim + i] -= N[I] * force[i];
  }
}

template <int Dim>
void PointLoads<Dim>::work(std::size_t cell, const std::vector<Real>& u, const std::vector<Real>& factors, Real* residual, Real* K) const {
  for (std::size_t p = first_[cell]; p < first_[cell + 1]; ++p) work(cell, p, u, factors[points_[p].load], residual, K);
}

template <int Dim>
std::vector<Real> PointLoads<Dim>::nodal_forces(std::size_t load, const std::vector<Real>& u, const std::vector<Real>& factors) const {
  std::vector<Real> forces(space_.nodes().size() * Dim, 0);
  const auto functions = static_cast<std::size_t>(space_.functions());
  std::vector<Real> residual(functions * Dim);
  for (std::size_t c = 0; c < space_.cells().size(); ++c) {
    for (std::size_t p = first_[c]; p < first_[c + 1]; ++p) {
      if (points_[p].load != load) continue;
      std::fill(residual.begin(), residual.end(), 0);
      work(c, p, u, factors[load], residual.data(), nullptr);
      const int* const nodes = space_.cell_nodes(c);
      for (std::size_t k = 0; k < residual.size(); ++k) forces[static_cast<std::size_t>(nodes[k / Dim]) * Dim + k % Dim] -= residual[k];
    }
  }
  return forces;
}

template <int Dim>
Vec3 PointLoads<Dim>::resultant(std::size_t load, Real factor) const {
  const PointBody<Dim>& body = *space_.sources()[loads_[load].body()].points;
  Vec3 sum{};
  for (std::size_t row = 0; row < static_cast<std::size_t>(body.count()); ++row) {
    const std::int32_t number = places_[load][static_cast<std::size_t>(body.id[row])];
    if (number < 0) continue;
    const auto p = static_cast<std::size_t>(number);
    for (std::size_t face = loads_[load].first_face(p); face < loads_[load].first_face(p + 1); ++face) {
      const Vec<Dim> force = loads_[load].on(face, factor, body.F.data() + row * Dim * Dim, 1).force;
      for (std::size_t d = 0; d < Dim; ++d) sum[d] += force[d];
    }
  }
  return sum;
}

template class PointLoads<2>;
template class PointLoads<3>;

}  // namespace matpoint
