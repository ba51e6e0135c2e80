#include "plain_loop.hpp"

#include <algorithm>
#include <cmath>

namespace matpoint::bench {
namespace {

template <int Dim>
struct Particle {
  double mass;
  double volume0;
  double volume;
  double x[Dim];
  double v[Dim];
  double F[Dim][Dim];
  double L[Dim][Dim];
  double sigma[Dim][Dim];
};

template <int Dim>
struct Node {
  double mass;
  double momentum[Dim];
  double force[Dim];
  double v[Dim];
  double a[Dim];
};

/// Where a particle is: its cell's first node, weights and derivatives of the weights along each direction.
template <int Dim>
struct Place {
  std::ptrdiff_t node = 0;
  double w[Dim][2];
  double dw[Dim][2];
};

template <int Dim>
class PlainLoopOf final : public PlainLoop {
 public:
  PlainLoopOf(const Scene& scene, PlainOrder order);
  void step() override;
  double kinetic_energy() const override;
  double strain_energy() const override;
  std::size_t memory() const override { return particles_.size() * sizeof(Particle<Dim>) + nodes_.size() * sizeof(Node<Dim>); }

 private:
  Place<Dim> locate(const Particle<Dim>& p) const;
  template <class F>
  void for_each_node(const Place<Dim>& place, F&& f) const;

  void clear();
  template <bool has_force>
  void p2g();
  void solve_nodes();
  void node_velocities();
  template <bool has_velocity, bool has_gradient, bool moves>
  void g2p();
  void move_by_old_displacement();
  void update_stress(Particle<Dim>& p) const;

  PlainOrder order_;
  double cell_size_;
  double mass_cutoff_;
  double dt_;
  double lambda_;
  double mu_;
  std::ptrdiff_t stride_[Dim];
  std::vector<Particle<Dim>> particles_;
  std::vector<Node<Dim>> nodes_;
  std::vector<std::array<double, Dim>> displacement_;  ///< MUSL only.
};

template <int Dim>
PlainLoopOf<Dim>::PlainLoopOf(const Scene& scene, PlainOrder order)
    : order_(order), cell_size_(scene.cell_size), mass_cutoff_(scene.mass_cutoff), dt_(scene.dt) {
  lambda_ = scene.youngs_modulus * scene.poissons_ratio / ((1 + scene.poissons_ratio) * (1 - 2 * scene.poissons_ratio));
  mu_ = scene.youngs_modulus / (2 * (1 + scene.poissons_ratio));
  std::ptrdiff_t nodes = 1;
  for (int d = 0; d < Dim; ++d) {
    stride_[d] = nodes;
    nodes *= scene.cells[static_cast<std::size_t>(d)] + 1;
  }
  nodes_.resize(static_cast<std::size_t>(nodes));
  for (std::size_t body = 0; body < 2; ++body) {
    for (std::size_t k = 0; k < scene.position[body].size(); ++k) {
      Particle<Dim> p{};
      p.mass = scene.density * scene.volume;
      p.volume0 = p.volume = scene.volume;
      for (int d = 0; d < Dim; ++d) {
        p.x[d] = scene.position[body][k][static_cast<std::size_t>(d)];
        p.v[d] = scene.velocity[body][k][static_cast<std::size_t>(d)];
        p.F[d][d] = 1;
      }
      particles_.push_back(p);
    }
  }
  std::stable_sort(particles_.begin(), particles_.end(),
                   [&](const Particle<Dim>& a, const Particle<Dim>& b) { return locate(a).node < locate(b).node; });
  if (order == PlainOrder::musl) displacement_.resize(particles_.size());
}

template <int Dim>
Place<Dim> PlainLoopOf<Dim>::locate(const Particle<Dim>& p) const {
  Place<Dim> place;
  const double inverse = 1 / cell_size_;
  for (int d = 0; d < Dim; ++d) {
    const double xi = p.x[d] * inverse;
    const int i = static_cast<int>(xi);
    place.node += i * stride_[d];
    place.w[d][1] = xi - i;
    place.w[d][0] = 1 - place.w[d][1];
    place.dw[d][0] = -inverse;
    place.dw[d][1] = inverse;
  }
  return place;
}

/// Calls f(node, N, dN) for the 4 or 8 nodes of the cell.
template <int Dim>
template <class F>
void PlainLoopOf<Dim>::for_each_node(const Place<Dim>& place, F&& f) const {
  if constexpr (Dim == 2) {
    for (int j = 0; j < 2; ++j) {
      for (int i = 0; i < 2; ++i) {
        const double dN[2] = {place.dw[0][i] * place.w[1][j], place.w[0][i] * place.dw[1][j]};
        f(static_cast<std::size_t>(place.node + i + j * stride_[1]), place.w[0][i] * place.w[1][j], dN);
      }
    }
  } else {
    for (int k = 0; k < 2; ++k) {
      for (int j = 0; j < 2; ++j) {
        for (int i = 0; i < 2; ++i) {
          const double dN[3] = {place.dw[0][i] * place.w[1][j] * place.w[2][k], place.w[0][i] * place.dw[1][j] * place.w[2][k],
                                place.w[0][i] * place.w[1][j] * place.dw[2][k]};
          f(static_cast<std::size_t>(place.node + i + j * stride_[1] + k * stride_[2]), place.w[0][i] * place.w[1][j] * place.w[2][k], dN);
        }
      }
    }
  }
}

template <int Dim>
void PlainLoopOf<Dim>::step() {
  if (order_ == PlainOrder::usf) {
    clear();
    p2g<false>();
    node_velocities();
    g2p<false, true, false>();
  }
  clear();
  p2g<true>();
  solve_nodes();
  if (order_ == PlainOrder::usl) g2p<true, true, true>();
  if (order_ == PlainOrder::usf) g2p<true, false, true>();
  if (order_ == PlainOrder::musl) {
    g2p<true, false, false>();
    clear();
    p2g<false>();
    node_velocities();
    g2p<false, true, false>();
    move_by_old_displacement();
  }
}

template <int Dim>
void PlainLoopOf<Dim>::clear() {
  for (Node<Dim>& node : nodes_) node = {};
}

template <int Dim>
template <bool has_force>
void PlainLoopOf<Dim>::p2g() {
  for (const Particle<Dim>& p : particles_) {
    for_each_node(locate(p), [&](std::size_t i, double N, const double* dN) {
      Node<Dim>& node = nodes_[i];
      node.mass += N * p.mass;
      for (int d = 0; d < Dim; ++d) {
        node.momentum[d] += N * p.mass * p.v[d];
        if constexpr (has_force) {
          for (int e = 0; e < Dim; ++e) node.force[d] -= p.volume * p.sigma[d][e] * dN[e];
        }
      }
    });
  }
}

template <int Dim>
void PlainLoopOf<Dim>::solve_nodes() {
  for (Node<Dim>& node : nodes_) {
    if (!(node.mass > 0 && node.mass >= mass_cutoff_)) continue;
    for (int d = 0; d < Dim; ++d) {
      node.a[d] = node.force[d] / node.mass;
      node.v[d] = node.momentum[d] / node.mass + dt_ * node.a[d];
    }
  }
}

template <int Dim>
void PlainLoopOf<Dim>::node_velocities() {
  for (Node<Dim>& node : nodes_) {
    if (!(node.mass > 0 && node.mass >= mass_cutoff_)) continue;
    for (int d = 0; d < Dim; ++d) node.v[d] = node.momentum[d] / node.mass;
  }
}

template <int Dim>
template <bool has_velocity, bool has_gradient, bool moves>
void PlainLoopOf<Dim>::g2p() {
  for (std::size_t n = 0; n < particles_.size(); ++n) {
    Particle<Dim>& p = particles_[n];
    double v[Dim] = {};
    double a[Dim] = {};
    double L[Dim][Dim] = {};
    for_each_node(locate(p), [&](std::size_t i, double N, const double* dN) {
      const Node<Dim>& node = nodes_[i];
      for (int d = 0; d < Dim; ++d) {
        if constexpr (has_velocity) {
          v[d] += N * node.v[d];
          a[d] += N * node.a[d];
        }
        if constexpr (has_gradient) {
          for (int e = 0; e < Dim; ++e) L[d][e] += node.v[d] * dN[e];
        }
      }
    });
    if constexpr (has_gradient) {
      for (int d = 0; d < Dim; ++d) {
        for (int e = 0; e < Dim; ++e) p.L[d][e] = L[d][e];
      }
      update_stress(p);
    }
    if constexpr (has_velocity) {
      for (int d = 0; d < Dim; ++d) {
        p.v[d] += dt_ * a[d];
        if constexpr (moves) {
          p.x[d] += dt_ * v[d];
        } else {
          displacement_[n][static_cast<std::size_t>(d)] = dt_ * v[d];
        }
      }
    }
  }
}

template <int Dim>
void PlainLoopOf<Dim>::move_by_old_displacement() {
  for (std::size_t n = 0; n < particles_.size(); ++n) {
    for (int d = 0; d < Dim; ++d) particles_[n].x[d] += displacement_[n][static_cast<std::size_t>(d)];
  }
}

template <int Dim>
double determinant(const double (&F)[Dim][Dim]) {
  if constexpr (Dim == 2) {
    return F[0][0] * F[1][1] - F[0][1] * F[1][0];
  } else {
    return F[0][0] * (F[1][1] * F[2][2] - F[1][2] * F[2][1]) - F[0][1] * (F[1][0] * F[2][2] - F[1][2] * F[2][0]) +
           F[0][2] * (F[1][0] * F[2][1] - F[1][1] * F[2][0]);
  }
}

/// F <- (I + L dt) F and sigma = (mu (F F^T - I) + lambda ln(J) I) / J.
template <int Dim>
void PlainLoopOf<Dim>::update_stress(Particle<Dim>& p) const {
  double F[Dim][Dim];
  for (int d = 0; d < Dim; ++d) {
    for (int e = 0; e < Dim; ++e) {
      F[d][e] = p.F[d][e];
      for (int k = 0; k < Dim; ++k) F[d][e] += dt_ * p.L[d][k] * p.F[k][e];
    }
  }
  const double J = determinant(F);
  const double pressure_part = lambda_ * std::log(J);
  p.volume = p.volume0 * J;
  for (int d = 0; d < Dim; ++d) {
    for (int e = 0; e < Dim; ++e) {
      double b = 0;
      for (int k = 0; k < Dim; ++k) b += F[d][k] * F[e][k];
      p.sigma[d][e] = (d == e ? mu_ * (b - 1) + pressure_part : mu_ * b) / J;
      p.F[d][e] = F[d][e];
    }
  }
}

template <int Dim>
double PlainLoopOf<Dim>::kinetic_energy() const {
  double sum = 0;
  for (const Particle<Dim>& p : particles_) {
    for (double v : p.v) sum += 0.5 * p.mass * v * v;
  }
  return sum;
}

template <int Dim>
double PlainLoopOf<Dim>::strain_energy() const {
  double sum = 0;
  for (const Particle<Dim>& p : particles_) {
    double trace_b = 0;
    for (const auto& row : p.F) {
      for (double f : row) trace_b += f * f;
    }
    const double log_J = std::log(determinant(p.F));
    sum += p.volume0 * (0.5 * mu_ * (trace_b - Dim) - mu_ * log_J + 0.5 * lambda_ * log_J * log_J);
  }
  return sum;
}

}  // namespace

std::unique_ptr<PlainLoop> make_plain_loop(const Scene& scene, PlainOrder order) {
  if (scene.dim == 3) return std::make_unique<PlainLoopOf<3>>(scene, order);
  return std::make_unique<PlainLoopOf<2>>(scene, order);
}

}  // namespace matpoint::bench
