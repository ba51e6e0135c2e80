#include "explicit/applied_loads.hpp"

#include <cmath>

namespace matpoint {

template <int Dim>
AppliedLoads<Dim>::AppliedLoads(const Case& problem, const SeedingGrid& grid, std::vector<Body<Dim>*> bodies)
    : loads_(particle_loads<Dim>(problem, grid)) {
  for (const std::string& axis : problem.grid.periodic) {
    const auto d = static_cast<std::size_t>(axis[0] - 'x');
    period_[d] = grid.upper[d] - grid.lower[d];
  }
  for (std::size_t k = 0; k < loads_.size(); ++k) {
    ParticleLoad<Dim>& load = loads_[k];
    Body<Dim>& body = *bodies[load.body()];
    std::vector<std::int32_t> places(static_cast<std::size_t>(body.particle_count()), -1);
    for (std::size_t p = 0; p < load.ids().size(); ++p) places[static_cast<std::size_t>(load.ids()[p])] = static_cast<std::int32_t>(p);
    Carried carried;
    carried.points.resize(load.ids().size());
    std::vector<std::size_t> first;
    for (std::size_t p = 0; p <= load.ids().size(); ++p) first.push_back(load.first_face(p));
    carried.forces.resize(first.back());
    first_.push_back(std::move(first));
    if (problem.bodies[load.body()].initial_stress) {
      body.take_points(places, carried.points);
      std::vector<Real> F, F33;
      for (const LoadedPoint<Dim>& point : carried.points) {
        F.insert(F.end(), point.F.begin(), point.F.end());
        F33.push_back(point.F33);
      }
      load.refer_to(F, F33);
    }
    factors_.emplace_back([problem, k](Real t) { return problem.load_factor(problem.loads[k], t); });
    bodies_.push_back(&body);
    places_.push_back(std::move(places));
    now_.push_back(std::move(carried));
    totals_.push_back({load.name(), {}, {}, 0});
  }
}

template <int Dim>
void AppliedLoads<Dim>::evaluate(Real t) {
  for (std::size_t k = 0; k < loads_.size(); ++k) {
    Carried& carried = now_[k];
    bodies_[k]->take_points(places_[k], carried.points);
    const Real factor = factors_[k](t);
    Vec3 sum{};
    for (std::size_t p = 0; p < carried.points.size(); ++p) {
      const LoadedPoint<Dim>& point = carried.points[p];
      for (std::size_t f = first_[k][p]; f < first_[k][p + 1]; ++f) {
        carried.forces[f] = point.is_there ? loads_[k].on(f, factor, point.F.data(), point.F33) : PointForce<Dim>{};
        for (std::size_t d = 0; d < Dim; ++d) sum[d] += carried.forces[f].force[d];
      }
    }
    totals_[k].force = sum;
  }
  is_current_ = true;
}

template <int Dim>
void AppliedLoads<Dim>::add() {
  for (std::size_t k = 0; k < loads_.size(); ++k) bodies_[k]->add_loads(places_[k], first_[k], now_[k].forces);
}

template <int Dim>
void AppliedLoads<Dim>::book_impulse(Real dt, Ledger& ledger) {
  for (BoundaryTotals& load : totals_) {
    for (std::size_t d = 0; d < Dim; ++d) {
      load.impulse[d] += dt * load.force[d];
      ledger.body_force_impulse[d] += dt * load.force[d];
    }
  }
}

template <int Dim>
void AppliedLoads<Dim>::book_work(Ledger& ledger) {
  for (std::size_t k = 0; k < loads_.size(); ++k) {
    Real work = 0;
    for (std::size_t p = 0; p < now_[k].points.size(); ++p) {
      const LoadedPoint<Dim>&old = before_[k].points[p], &point = now_[k].points[p];
      if (!old.is_there || !point.is_there) continue;
      for (std::size_t f = first_[k][p]; f < first_[k][p + 1]; ++f) {
        const PointForce<Dim>&first = before_[k].forces[f], &last = now_[k].forces[f];
        for (std::size_t d = 0; d < Dim; ++d) {
          Real way = point.x[d] - old.x[d];
          if (period_[d] > 0) way -= period_[d] * std::round(way / period_[d]);
          for (std::size_t e = 0; e < Dim; ++e) way += (point.F[d * Dim + e] - old.F[d * Dim + e]) * last.arm[e];
          work += 0.5 * (first.force[d] + last.force[d]) * way;
        }
      }
    }
    totals_[k].work += work;
    ledger.body_force_work += work;
  }
}

template <int Dim>
void AppliedLoads<Dim>::declare_state(State& state) {
  state.parts("load", totals_);
  if (state.is_loading()) is_current_ = false;
}

template class AppliedLoads<2>;
template class AppliedLoads<3>;

}  // namespace matpoint
