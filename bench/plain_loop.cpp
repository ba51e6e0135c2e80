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

/// Where a particle is: its cell's first node; tuned, too: weights and derivatives of the weights along each direction.
template <int Dim, int nodes>
struct Place {
  std::ptrdiff_t node = 0;
  int cell[Dim];
  double w[Dim][nodes];
  double dw[Dim][nodes];
};

/// `nodes`: of a cell along each direction; 2 for linear shape functions, 3 for quadratic B-splines, whose nodes stand at the middles of
/// the cells, the first one before the first cell.
template <int Dim, int nodes, PlainStyle style>
class PlainLoopOf final : public PlainLoop {
 public:
  PlainLoopOf(const Scene& scene, PlainOrder order);
  void step() override;
  double kinetic_energy() const override;
  double strain_energy() const override;
  std::size_t memory() const override { return particles_.size() * sizeof(Particle<Dim>) + nodes_.size() * sizeof(Node<Dim>); }

 private:
  Place<Dim, nodes> locate(const Particle<Dim>& p) const;
  template <class F>
  void for_each_node(const Particle<Dim>& p, F&& f) const;

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

template <int Dim, int nodes, PlainStyle style>
PlainLoopOf<Dim, nodes, style>::PlainLoopOf(const Scene& scene, PlainOrder order)
    : order_(order), cell_size_(scene.cell_size), mass_cutoff_(scene.mass_cutoff), dt_(scene.dt) {
  lambda_ = scene.youngs_modulus * scene.poissons_ratio / ((1 + scene.poissons_ratio) * (1 - 2 * scene.poissons_ratio));
  mu_ = scene.youngs_modulus / (2 * (1 + scene.poissons_ratio));
  std::ptrdiff_t count = 1;
  for (int d = 0; d < Dim; ++d) {
    stride_[d] = count;
    count *= scene.cells[static_cast<std::size_t>(d)] + nodes - 1;
  }
  nodes_.resize(static_cast<std::size_t>(count));
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

template <int Dim, int nodes, PlainStyle style>
Place<Dim, nodes> PlainLoopOf<Dim, nodes, style>::locate(const Particle<Dim>& p) const {
  Place<Dim, nodes> place;
  const double inverse = 1 / cell_size_;
  for (int d = 0; d < Dim; ++d) {
    const double xi = style == PlainStyle::tuned ? p.x[d] * inverse : p.x[d] / cell_size_;
    place.cell[d] = static_cast<int>(xi);
    place.node += place.cell[d] * stride_[d];
    if constexpr (style == PlainStyle::tuned) {
      const double q = xi - place.cell[d];
      if constexpr (nodes == 2) {
        place.w[d][1] = q;
        place.w[d][0] = 1 - q;
        place.dw[d][0] = -inverse;
        place.dw[d][1] = inverse;
      } else {
        place.w[d][0] = 0.5 * (1 - q) * (1 - q);
        place.w[d][1] = 0.5 + q * (1 - q);
        place.w[d][2] = 0.5 * q * q;
        place.dw[d][0] = (q - 1) * inverse;
        place.dw[d][1] = (1 - 2 * q) * inverse;
        place.dw[d][2] = q * inverse;
      }
    }
  }
  return place;
}

/// Calls f(node, N, dN) for the nodes of the particle's cell.
template <int Dim, int nodes, PlainStyle style>
template <class F>
void PlainLoopOf<Dim, nodes, style>::for_each_node(const Particle<Dim>& p, F&& f) const {
  const Place<Dim, nodes> place = locate(p);
  for (int corner = 0; corner < (Dim == 2 ? nodes * nodes : nodes * nodes * nodes); ++corner) {
    std::ptrdiff_t node = place.node;
    double w[Dim];
    double dw[Dim];
    for (int d = 0, rest = corner; d < Dim; ++d, rest /= nodes) {
      const int side = rest % nodes;
      node += side * stride_[d];
      if constexpr (style == PlainStyle::tuned) {
        w[d] = place.w[d][side];
        dw[d] = place.dw[d][side];
      } else if constexpr (nodes == 3) {
        const double r = (p.x[d] - (place.cell[d] + side - 0.5) * cell_size_) / cell_size_;
        const bool is_near = std::abs(r) < 0.5;
        const double left = 1.5 - std::abs(r);
        w[d] = is_near ? 0.75 - r * r : 0.5 * left * left;
        dw[d] = (is_near ? -2 * r : r >= 0 ? -left : left) / cell_size_;
      } else {
        const double r = (p.x[d] - (place.cell[d] + side) * cell_size_) / cell_size_;
        w[d] = 1 - std::abs(r);
        dw[d] = (r >= 0 ? -1 : 1) / cell_size_;
      }
    }
    if constexpr (Dim == 2) {
      const double dN[2] = {dw[0] * w[1], w[0] * dw[1]};
      f(static_cast<std::size_t>(node), w[0] * w[1], dN);
    } else {
      const double dN[3] = {dw[0] * w[1] * w[2], w[0] * dw[1] * w[2], w[0] * w[1] * dw[2]};
      f(static_cast<std::size_t>(node), w[0] * w[1] * w[2], dN);
    }
  }
}

template <int Dim, int nodes, PlainStyle style>
void PlainLoopOf<Dim, nodes, style>::step() {
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

template <int Dim, int nodes, PlainStyle style>
void PlainLoopOf<Dim, nodes, style>::clear() {
  for (Node<Dim>& node : nodes_) node = {};
}

template <int Dim, int nodes, PlainStyle style>
template <bool has_force>
void PlainLoopOf<Dim, nodes, style>::p2g() {
  for (const Particle<Dim>& p : particles_) {
    for_each_node(p, [&](std::size_t i, double N, const double* dN) {
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

template <int Dim, int nodes, PlainStyle style>
void PlainLoopOf<Dim, nodes, style>::solve_nodes() {
  for (Node<Dim>& node : nodes_) {
    if (!(node.mass > 0 && node.mass >= mass_cutoff_)) continue;
    for (int d = 0; d < Dim; ++d) {
      node.a[d] = node.force[d] / node.mass;
      node.v[d] = node.momentum[d] / node.mass + dt_ * node.a[d];
    }
  }
}

template <int Dim, int nodes, PlainStyle style>
void PlainLoopOf<Dim, nodes, style>::node_velocities() {
  for (Node<Dim>& node : nodes_) {
    if (!(node.mass > 0 && node.mass >= mass_cutoff_)) continue;
    for (int d = 0; d < Dim; ++d) node.v[d] = node.momentum[d] / node.mass;
  }
}

template <int Dim, int nodes, PlainStyle style>
template <bool has_velocity, bool has_gradient, bool moves>
void PlainLoopOf<Dim, nodes, style>::g2p() {
  for (std::size_t n = 0; n < particles_.size(); ++n) {
    Particle<Dim>& p = particles_[n];
    double v[Dim] = {};
    double a[Dim] = {};
    double L[Dim][Dim] = {};
    for_each_node(p, [&](std::size_t i, double N, const double* dN) {
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

template <int Dim, int nodes, PlainStyle style>
void PlainLoopOf<Dim, nodes, style>::move_by_old_displacement() {
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
template <int Dim, int nodes, PlainStyle style>
void PlainLoopOf<Dim, nodes, style>::update_stress(Particle<Dim>& p) const {
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

template <int Dim, int nodes, PlainStyle style>
double PlainLoopOf<Dim, nodes, style>::kinetic_energy() const {
  double sum = 0;
  for (const Particle<Dim>& p : particles_) {
    for (double v : p.v) sum += 0.5 * p.mass * v * v;
  }
  return sum;
}

template <int Dim, int nodes, PlainStyle style>
double PlainLoopOf<Dim, nodes, style>::strain_energy() const {
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

std::unique_ptr<PlainLoop> make_plain_loop(const Scene& scene, PlainOrder order, PlainShape shape, PlainStyle style) {
  const auto make = [&]<int Dim, int nodes>() -> std::unique_ptr<PlainLoop> {
    if (style == PlainStyle::tuned) return std::make_unique<PlainLoopOf<Dim, nodes, PlainStyle::tuned>>(scene, order);
    return std::make_unique<PlainLoopOf<Dim, nodes, PlainStyle::textbook>>(scene, order);
  };
  if (shape == PlainShape::linear) return scene.dim == 3 ? make.operator()<3, 2>() : make.operator()<2, 2>();
  return scene.dim == 3 ? make.operator()<3, 3>() : make.operator()<2, 3>();
}

}  // namespace matpoint::bench
