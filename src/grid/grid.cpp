#include "grid/grid.hpp"

#include <algorithm>

#include "core/parallel.hpp"

namespace matpoint {

template <int Dim>
Grid<Dim>::Grid(const GridSpec& spec) {
  Index stride = 1;
  for (int d = 0; d < Dim; ++d) {
    const auto s = static_cast<std::size_t>(d);
    view_.lower[d] = spec.lower[s];
    view_.upper[d] = spec.upper[s];
    view_.cells[d] = spec.cells[s];
    view_.cell_size[d] = (spec.upper[s] - spec.lower[s]) / spec.cells[s];
    view_.inverse_cell_size[d] = 1 / view_.cell_size[d];
    const std::string axis(1, "xyz"[d]);
    view_.is_periodic[d] = std::find(spec.periodic.begin(), spec.periodic.end(), axis) != spec.periodic.end();
    has_periodic_ = has_periodic_ || view_.is_periodic[d];
    view_.stride[d] = stride;
    row_size_ = stride;
    stride *= spec.cells[s] + 1;
  }
  node_count_ = stride;
  row_count_ = node_count_ / row_size_;
  mapped_.assign(static_cast<std::size_t>(node_count_ * k_mapped_width), 0);
  motion_.assign(static_cast<std::size_t>(node_count_ * k_motion_width<Dim>), 0);
  is_row_active_.assign(static_cast<std::size_t>(row_count_), 0);
  view_.mapped = mapped_.data();
  view_.motion = motion_.data();
}

template <int Dim>
GridGeometry Grid<Dim>::geometry() const {
  GridGeometry geometry;
  for (int d = 0; d < Dim; ++d) {
    const auto s = static_cast<std::size_t>(d);
    geometry.lower[s] = view_.lower[d];
    geometry.cell_size[s] = view_.cell_size[d];
    geometry.nodes[s] = nodes(d);
  }
  return geometry;
}

template <int Dim>
Vec<Dim> Grid<Dim>::node_position(Index node) const {
  Vec<Dim> position;
  for (int d = Dim - 1; d >= 0; --d) {
    const Index i = node / view_.stride[d];
    node -= i * view_.stride[d];
    // The far side exactly, so that `side = "top"` and a region that ends there mean the same nodes.
    position[static_cast<std::size_t>(d)] =
        i == view_.cells[d] ? view_.upper[d] : view_.lower[d] + static_cast<Real>(i) * view_.cell_size[d];
  }
  return position;
}

template <int Dim>
template <class F>
void Grid<Dim>::for_each_active_row(F&& f) {
  parallel_for(row_count_, node_count_, [&](Index row) {
    if (is_row_active_[static_cast<std::size_t>(row)]) f(row);
  });
}

template <int Dim>
bool Grid<Dim>::is_periodic_twin(Index node) const {
  if (!has_periodic_) return false;
  for (int d = 0; d < Dim; ++d) {
    if (view_.is_periodic[d] && (node / view_.stride[d]) % nodes(d) == view_.cells[d]) return true;
  }
  return false;
}

template <int Dim>
void Grid<Dim>::clear(const std::vector<char>& is_band_occupied) {
  std::fill(is_row_active_.begin(), is_row_active_.end(), char{0});
  for (std::size_t band = 0; band < is_band_occupied.size(); ++band) {
    if (is_band_occupied[band]) is_row_active_[band] = is_row_active_[band + 1] = 1;
  }
  if (view_.is_periodic[Dim - 1]) {
    is_row_active_.front() = is_row_active_.back() = static_cast<char>(is_row_active_.front() | is_row_active_.back());
  }
  for_each_active_row([&](Index row) {
    Real* const first = mapped(row * row_size_);
    std::fill(first, first + row_size_ * k_mapped_width, Real{0});
  });
}

template <int Dim>
void Grid<Dim>::fold_periodic() {
  if (!has_periodic_) return;
  // The two ends of a periodic direction are one node: both get the sum, and everything after treats them alike.
  for (int d = 0; d < Dim; ++d) {
    if (!view_.is_periodic[d]) continue;
    const Index span = view_.stride[d] * view_.cells[d];
    for (Index node = 0; node + span < node_count_; ++node) {
      if ((node / view_.stride[d]) % nodes(d) != 0 || !is_row_active(node)) continue;
      Real* const a = mapped(node);
      Real* const b = mapped(node + span);
      for (int k = 0; k < k_mapped_width; ++k) a[k] = b[k] = a[k] + b[k];
    }
  }
}

template <int Dim>
void Grid<Dim>::compute_velocity(const NodalDynamics<Dim>& dynamics) {
  for_each_active_row([&](Index row) {
    for (Index node = row * row_size_; node < (row + 1) * row_size_; ++node) {
      const Real* const in = mapped(node);
      Real* const out = motion(node);
      const bool is_active = in[0] > 0 && in[0] >= dynamics.mass_cutoff;
      const Real inverse_mass = is_active ? 1 / in[0] : 0;
      for (int d = 0; d < Dim; ++d) {
        out[d] = in[1 + d] * inverse_mass;
        out[Dim + d] = 0;
      }
    }
  });
}

template <int Dim>
void Grid<Dim>::advance_velocity(const NodalDynamics<Dim>& dynamics, Real dt, Ledger& ledger) {
  // Sums per row, added in the order of the rows: the same bits for any number of threads. Periodic twins count once.
  struct RowSums {
    Real damping_dissipation = 0;
    Vec<Dim> damping_impulse{};
    Vec<Dim> cutoff_impulse{};
  };
  std::vector<RowSums> sums(static_cast<std::size_t>(row_count_));
  for_each_active_row([&](Index row) {
    RowSums& sum = sums[static_cast<std::size_t>(row)];
    for (Index node = row * row_size_; node < (row + 1) * row_size_; ++node) {
      const Real* const in = mapped(node);
      Real* const out = motion(node);
      const Real m = in[0];
      const Real booked = is_periodic_twin(node) ? 0 : 1;
      if (m > 0 && m >= dynamics.mass_cutoff) {
        const Real inverse_mass = 1 / m;
        for (int d = 0; d < Dim; ++d) {
          const auto s = static_cast<std::size_t>(d);
          const Real p = in[1 + d];
          const Real a = (in[1 + Dim + d] - dynamics.damping * p) * inverse_mass + dynamics.gravity[s];
          out[d] = p * inverse_mass + a * dt;
          out[Dim + d] = a;
          const Real impulse = booked * dt * dynamics.damping * p;
          sum.damping_impulse[s] -= impulse;
          sum.damping_dissipation += impulse * out[d];
        }
      } else {
        for (int d = 0; d < Dim; ++d) {
          const auto s = static_cast<std::size_t>(d);
          out[d] = out[Dim + d] = 0;
          // What the node holds back: the FLIP share would have gained a dt, the PIC share loses the node's momentum, too.
          sum.cutoff_impulse[s] -= booked * (dt * (in[1 + Dim + d] + m * dynamics.gravity[s]) + (1 - dynamics.flip) * in[1 + d]);
        }
      }
    }
  });
  for (const RowSums& sum : sums) {
    ledger.damping_dissipation += sum.damping_dissipation;
    for (std::size_t d = 0; d < Dim; ++d) {
      ledger.damping_impulse[d] += sum.damping_impulse[d];
      ledger.cutoff_impulse[d] += sum.cutoff_impulse[d];
    }
  }
}

template class Grid<2>;
template class Grid<3>;

}  // namespace matpoint
