// A second, plain implementation of the explicit step, for comparison: particles in an array of structs, one loop per stage, dense arrays
// of nodes. Written from the equations of docs/theory.md and from nothing in src/; slow and easy to check by eye. In 2D (plane strain) the
// third component of everything stays what it is at rest.
#pragma once

#include <cmath>
#include <functional>
#include <map>
#include <vector>

#include "case/case.hpp"

namespace matpoint::test {

using Matrix = std::array<Vec3, 3>;

inline Real determinant(const Matrix& F) {
  return F[0][0] * (F[1][1] * F[2][2] - F[1][2] * F[2][1]) - F[0][1] * (F[1][0] * F[2][2] - F[1][2] * F[2][0]) +
         F[0][2] * (F[1][0] * F[2][1] - F[1][1] * F[2][0]);
}

inline Matrix product(const Matrix& a, const Matrix& b) {
  Matrix c{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) c[i][j] = a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j];
  }
  return c;
}

inline Matrix transpose(const Matrix& a) {
  Matrix t;
  for (std::size_t i = 0; i < 3; ++i) t[i] = {a[0][i], a[1][i], a[2][i]};
  return t;
}

/// a^-1, by cofactors.
inline Matrix inverse(const Matrix& a) {
  Matrix b;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      const std::size_t i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      b[j][i] = (a[i1][j1] * a[i2][j2] - a[i1][j2] * a[i2][j1]) / determinant(a);
    }
  }
  return b;
}

inline Real trace(const Matrix& a) { return a[0][0] + a[1][1] + a[2][2]; }

struct ReferenceParticle {
  Vec3 x{};
  Vec3 X{};  ///< At the start.
  Vec3 v{};
  Matrix C{};  ///< Affine part of the velocity [1/s].
  Matrix F{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  Matrix sigma{};             ///< Cauchy stress [Pa]
  Real spherical_change = 0;  ///< Of F-bar: what the forces see more than J sigma, in each diagonal entry [Pa].
  Real mass = 0;
  Real V0 = 0;
};

/// A law in the reference: Cauchy stress from F and L, and the dissipated power per present volume [W/m^3].
struct ReferenceLaw {
  std::function<Matrix(const Matrix& F, const Matrix& L)> stress;
  std::function<Real(const Matrix& L)> dissipation = [](const Matrix&) { return Real{0}; };
  bool is_fluid = false;  ///< Carries J alone.
};

/// sigma = mu/J (F F^T - I) + lambda/J ln J I. Source: Kamuth (thesis on explicit MPM), eq. 47.
inline ReferenceLaw reference_neo_hookean(Real E, Real nu) {
  const Real lambda = E * nu / ((1 + nu) * (1 - 2 * nu));
  const Real mu = E / (2 * (1 + nu));
  return {[=](const Matrix& F, const Matrix&) {
    const Real J = determinant(F);
    Matrix sigma = product(F, transpose(F));
    for (std::size_t r = 0; r < 3; ++r) {
      for (std::size_t c = 0; c < 3; ++c) sigma[r][c] = mu / J * (sigma[r][c] - (r == c)) + (r == c) * lambda / J * std::log(J);
    }
    return sigma;
  }};
}

/// sigma = F S F^T / J, S = lambda tr(E) I + 2 mu E, E = (F^T F - I) / 2. Source: the same, section on hyperelasticity.
inline ReferenceLaw reference_st_venant_kirchhoff(Real E, Real nu) {
  const Real lambda = E * nu / ((1 + nu) * (1 - 2 * nu));
  const Real mu = E / (2 * (1 + nu));
  return {[=](const Matrix& F, const Matrix&) {
    Matrix strain = product(transpose(F), F);
    for (std::size_t r = 0; r < 3; ++r) {
      for (std::size_t c = 0; c < 3; ++c) strain[r][c] = (strain[r][c] - (r == c)) / 2;
    }
    Matrix S;
    for (std::size_t r = 0; r < 3; ++r) {
      for (std::size_t c = 0; c < 3; ++c) S[r][c] = 2 * mu * strain[r][c] + (r == c) * lambda * trace(strain);
    }
    Matrix sigma = product(product(F, S), transpose(F));
    for (Vec3& row : sigma) {
      for (Real& entry : row) entry /= determinant(F);
    }
    return sigma;
  }};
}

/// sigma = 2 mu d' - p I, p = kappa (J^-gamma - 1), d' the deviator of the 3D rate. Source: the same, eq. 49 and 50.
inline ReferenceLaw reference_newtonian_fluid(Real kappa, Real gamma, Real viscosity) {
  const auto deviator = [](const Matrix& L) {
    Matrix d;
    for (std::size_t r = 0; r < 3; ++r) {
      for (std::size_t c = 0; c < 3; ++c) d[r][c] = (L[r][c] + L[c][r]) / 2 - (r == c) * trace(L) / 3;
    }
    return d;
  };
  ReferenceLaw law;
  law.is_fluid = true;
  law.stress = [=](const Matrix& F, const Matrix& L) {
    const Real pressure = kappa * (std::pow(determinant(F), -gamma) - 1);
    Matrix sigma = deviator(L);
    for (std::size_t r = 0; r < 3; ++r) {
      for (std::size_t c = 0; c < 3; ++c) sigma[r][c] = 2 * viscosity * sigma[r][c] - (r == c) * pressure;
    }
    return sigma;
  };
  law.dissipation = [=](const Matrix& L) {
    Real sum = 0;
    for (const Vec3& row : deviator(L)) {
      for (const Real entry : row) sum += entry * entry;
    }
    return 2 * viscosity * sum;
  };
  return law;
}

/// B-spline `i` of degree `p` on a knot vector, at x: the recursion of Cox and de Boor. The last interval holds its end, too.
inline Real bspline(const std::vector<Real>& knots, std::size_t i, int p, Real x) {
  if (p == 0) {
    const bool is_last = knots[i + 1] == knots.back() && knots[i] < knots[i + 1];
    return knots[i] <= x && (x < knots[i + 1] || (is_last && x == knots[i + 1])) ? 1 : 0;
  }
  const auto n = static_cast<std::size_t>(p);
  const auto share = [](Real a, Real b) { return b == 0 ? 0 : a / b; };
  return share(x - knots[i], knots[i + n] - knots[i]) * bspline(knots, i, p - 1, x) +
         share(knots[i + n + 1] - x, knots[i + n + 1] - knots[i + 1]) * bspline(knots, i + 1, p - 1, x);
}

/// Its derivative.
inline Real bspline_slope(const std::vector<Real>& knots, std::size_t i, int p, Real x) {
  const auto n = static_cast<std::size_t>(p);
  const auto share = [](Real a, Real b) { return b == 0 ? 0 : a / b; };
  return share(p, knots[i + n] - knots[i]) * bspline(knots, i, p - 1, x) -
         share(p, knots[i + n + 1] - knots[i + 1]) * bspline(knots, i + 1, p - 1, x);
}

/// The hat of width 1 on each side, and its integral from the left.
inline Real hat(Real x) { return std::max(0.0, 1 - std::abs(x)); }
inline Real hat_integral(Real x) { return x <= -1 ? 0 : x <= 0 ? (1 + x) * (1 + x) / 2 : x <= 1 ? 1 - (1 - x) * (1 - x) / 2 : 1; }

class ReferenceMpm {
 public:
  /// One node and component whose velocity is given as a function of time.
  struct Constraint {
    int node;
    std::size_t component;
    std::function<Real(Real t)> velocity;
  };

  std::size_t dim = 2;
  StressOrder order = StressOrder::usl;
  int degree = 1;  ///< Of the B-splines on clamped knots that are the shape functions; degree 1: hats.
  Real reach = 0;  ///< Not 0: hats averaged over this much [cell sides] to both sides instead, but not beyond the grid.
  Transfer transfer = Transfer::flip;
  bool is_convected = false;  ///< With `reach`: the averaged functions are linear between the corners of a domain that deforms with F.
  bool has_fbar = false;      ///< The volumetric part of L is the mean of a cell, and so is the spherical part of the stress in the forces.
  int fmpm_order = 1;         ///< Terms of the inverse of the mass matrix.
  bool is_total = false;      ///< Shape functions in the reference configuration.
  Vec3 lower{};
  Vec3 h{1, 1, 1};
  std::array<int, 3> cells{1, 1, 1};
  Vec3 gravity{};
  Real damping = 0;
  Real flip = 1;
  Real mass_cutoff = 0;
  std::vector<ReferenceParticle> particles;
  ReferenceLaw law;
  std::vector<Constraint> constraints;

  // Books, each from its own definition.
  Real damping_dissipation = 0;  ///< Sum over free components of alpha p_i v_i(end) dt.
  Real viscous_dissipation = 0;  ///< Sum over particles of 2 mu d':d' J V0 dt.

  int nodes(std::size_t d) const { return d < dim ? cells[d] + (reach > 0 ? 3 : degree) : 1; }
  int side_node(std::size_t d, bool is_upper) const { return is_upper ? nodes(d) - 1 - (reach > 0) : (reach > 0); }
  int node_count() const { return nodes(0) * nodes(1) * nodes(2); }

  void step(Real t, Real dt) {
    if (order == StressOrder::usf) {
      map();
      node_velocities(t);
      update_stress(dt);
    }
    map();
    momentum_equation(t + dt, dt);
    refine();
    gather_velocity(dt);
    const std::vector<Vec3> displacements = displacements_in(dt);
    if (order == StressOrder::musl) {
      map();
      node_velocities(t + dt);
    }
    if (order != StressOrder::usf) update_stress(dt);
    for (std::size_t p = 0; p < particles.size(); ++p) {
      for (std::size_t d = 0; d < dim; ++d) particles[p].x[d] += displacements[p][d];
    }
    keep_off_lines();
  }

  /// No particle is nearer to a line of the grid than 1e-9 of a cell; one on a line belongs to the cell above, on the far side to the last.
  void keep_off_lines() {
    for (ReferenceParticle& q : particles) {
      for (std::size_t d = 0; d < dim; ++d) {
        Real& x = (is_total ? q.X : q.x)[d];
        const Real before = x;
        const Real place = (x - lower[d]) / h[d];
        const Real cell = std::min(std::floor(place), static_cast<Real>(cells[d] - 1));
        if (place - cell < 1e-9) x = lower[d] + (cell + 1e-9) * h[d];
        if (place - cell > 1 - 1e-9) x = lower[d] + (cell + 1 - 1e-9) * h[d];
        if (is_total) q.x[d] += x - before;
      }
    }
  }

 private:
  struct Corner {
    int node;
    Real N;
    Vec3 dN;
    Vec3 x;  ///< Of the node, for linear precision: the mean of the knots inside its function (Greville).
  };

  /// In cell sides from the lower side of the grid.
  std::vector<Real> knots(std::size_t d) const {
    std::vector<Real> all(static_cast<std::size_t>(degree), 0);
    for (int i = 0; i <= cells[d]; ++i) all.push_back(i);
    all.insert(all.end(), static_cast<std::size_t>(degree), all.back());
    return all;
  }

  /// What a particle's domain reaches from and to, in cell sides.
  std::pair<Real, Real> domain(std::size_t d, Real here) const {
    return {std::max(here - reach, Real{0}), std::min(here + reach, static_cast<Real>(cells[d]))};
  }

  /// Where the nodes see the particle: sum N_i x_i.
  Vec3 centre(const ReferenceParticle& q) const {
    Vec3 x = is_total ? q.X : q.x;
    if (is_convected) {
      x = {};
      const std::vector<Vec3> at_corners = domain_corners(q);
      for (const Vec3& corner : at_corners) {
        for (std::size_t d = 0; d < dim; ++d) x[d] += corner[d] / Real(at_corners.size());
      }
      return x;
    }
    for (std::size_t d = 0; d < dim && reach > 0; ++d) {
      const auto [a, b] = domain(d, (x[d] - lower[d]) / h[d]);
      x[d] = lower[d] + (a + b) / 2 * h[d];
    }
    return x;
  }

  /// Corners of a convected domain [m], its longest half-diagonal along an axis at most a cell, cut off at the sides of the grid.
  std::vector<Vec3> domain_corners(const ReferenceParticle& q) const {
    std::vector<Vec3> all;
    for (int c = 0; c < (dim == 2 ? 4 : 8); ++c) {
      Vec3 x = is_total ? q.X : q.x;
      for (std::size_t d = 0; d < dim; ++d) {
        Real away = 0;
        Real longest = 0;
        for (std::size_t k = 0; k < dim; ++k) {
          const Real edge = reach * h[k] * (is_total ? static_cast<Real>(d == k) : q.F[d][k]);
          away += (c >> k) % 2 == 1 ? edge : -edge;
          longest += std::abs(edge);
        }
        x[d] += away * std::min(1.0, h[d] / longest);
        x[d] = std::clamp(x[d], lower[d], lower[d] + cells[d] * h[d]);
      }
      all.push_back(x);
    }
    return all;
  }

  /// CPDI (Sadeghirad et al. 2011): means of the hats at the corners, and of their slopes, by the inverse of the domain's edges.
  std::vector<Corner> convected_corners(const ReferenceParticle& q) const {
    const std::vector<Vec3> at_corners = domain_corners(q);
    Matrix edges{};
    if (dim == 2) edges[2][2] = 1;
    for (std::size_t c = 0; c < at_corners.size(); ++c) {
      for (std::size_t d = 0; d < dim; ++d) {
        for (std::size_t k = 0; k < dim; ++k) edges[d][k] += ((c >> k) % 2 == 1 ? 1 : -1) * at_corners[c][d] / Real(at_corners.size());
      }
    }
    const Matrix to_slope = transpose(inverse(edges));
    std::vector<Corner> out;
    for (int n = 0; n < node_count(); ++n) {
      const std::array<int, 3> index{n % nodes(0), n / nodes(0) % nodes(1), n / nodes(0) / nodes(1)};
      Corner corner{n, 0, {}, {}};
      Vec3 along_edge{};
      for (std::size_t d = 0; d < dim; ++d) corner.x[d] = lower[d] + (index[d] - 1) * h[d];
      for (std::size_t c = 0; c < at_corners.size(); ++c) {
        Real N = 1.0 / Real(at_corners.size());
        for (std::size_t d = 0; d < dim; ++d) N *= hat((at_corners[c][d] - corner.x[d]) / h[d]);
        corner.N += N;
        for (std::size_t k = 0; k < dim; ++k) along_edge[k] += (c >> k) % 2 == 1 ? N : -N;
      }
      if (corner.N == 0) continue;
      for (std::size_t d = 0; d < dim; ++d) {
        for (std::size_t k = 0; k < dim; ++k) corner.dN[d] += to_slope[d][k] * along_edge[k];
      }
      out.push_back(corner);
    }
    return out;
  }

  /// The nodes whose functions live on the particle's cell; a particle on a knot belongs to the cell behind it, on the far side to the
  /// last.
  std::vector<Corner> corners(const ReferenceParticle& q) const {
    if (is_convected) return convected_corners(q);
    const Vec3& x = is_total ? q.X : q.x;
    std::array<std::vector<Real>, 3> N, dN, place;
    std::array<std::size_t, 3> first{};
    std::vector<Corner> out;
    for (std::size_t d = 0; d < 3; ++d) {
      if (d >= dim) {
        N[d] = {1};
        dN[d] = {0};
        place[d] = {0};
        continue;
      }
      const std::vector<Real> t = knots(d);
      const Real here = (x[d] - lower[d]) / h[d];
      first[d] = static_cast<std::size_t>(std::min(static_cast<int>(here), cells[d] - 1));
      for (std::size_t i = first[d]; reach > 0 && i < first[d] + 4; ++i) {
        const Real node = static_cast<Real>(i) - 1;
        const auto [a, b] = domain(d, here);
        N[d].push_back((hat_integral(b - node) - hat_integral(a - node)) / (b - a));
        dN[d].push_back((hat(b - node) - hat(a - node)) / (b - a) / h[d]);
        place[d].push_back(lower[d] + node * h[d]);
      }
      for (std::size_t i = first[d]; reach == 0 && i <= first[d] + static_cast<std::size_t>(degree); ++i) {
        N[d].push_back(bspline(t, i, degree, here));
        dN[d].push_back(bspline_slope(t, i, degree, here) / h[d]);
        Real sum = 0;
        for (std::size_t k = 1; k <= static_cast<std::size_t>(degree); ++k) sum += t[i + k];
        place[d].push_back(lower[d] + sum / degree * h[d]);
      }
    }
    const auto rows = [&](std::size_t d) { return static_cast<std::size_t>(nodes(d)); };
    for (std::size_t k = 0; k < N[2].size(); ++k) {
      for (std::size_t j = 0; j < N[1].size(); ++j) {
        for (std::size_t i = 0; i < N[0].size(); ++i) {
          out.push_back({static_cast<int>(((first[2] + k) * rows(1) + first[1] + j) * rows(0) + first[0] + i),
                         N[0][i] * N[1][j] * N[2][k],
                         {dN[0][i] * N[1][j] * N[2][k], N[0][i] * dN[1][j] * N[2][k], N[0][i] * N[1][j] * dN[2][k]},
                         {place[0][i], place[1][j], place[2][k]}});
        }
      }
    }
    return out;
  }

  bool is_active(int node) const { return m_[at(node)] > 0 && m_[at(node)] >= mass_cutoff; }
  static std::size_t at(int node) { return static_cast<std::size_t>(node); }

  void map() {
    m_.assign(at(node_count()), 0);
    p_.assign(at(node_count()), Vec3{});
    f_.assign(at(node_count()), Vec3{});
    for (const ReferenceParticle& q : particles) {
      const std::vector<Corner> c = corners(q);
      // Kirchhoff stress, or the first Piola-Kirchhoff stress J sigma F^-T.
      Matrix S = q.sigma;
      for (Vec3& row : S) {
        for (Real& entry : row) entry *= determinant(q.F);
      }
      for (std::size_t d = 0; d < dim; ++d) S[d][d] += q.spherical_change;
      if (is_total) S = product(S, transpose(inverse(q.F)));
      for (const Corner& k : c) {
        m_[at(k.node)] += k.N * q.mass;
        for (std::size_t d = 0; d < dim; ++d) {
          Real v = q.v[d];
          for (std::size_t e = 0; e < dim; ++e) v += q.C[d][e] * (k.x[e] - centre(q)[e]);
          p_[at(k.node)][d] += k.N * q.mass * v;
          f_[at(k.node)][d] += k.N * q.mass * gravity[d];
          for (std::size_t e = 0; e < dim; ++e) f_[at(k.node)][d] -= q.V0 * S[d][e] * k.dN[e];
        }
      }
    }
  }

  void node_velocities(Real t) {
    v_.assign(at(node_count()), Vec3{});
    for (int n = 0; n < node_count(); ++n) {
      if (!is_active(n)) continue;
      for (std::size_t d = 0; d < dim; ++d) v_[at(n)][d] = p_[at(n)][d] / m_[at(n)];
    }
    for (const Constraint& c : constraints) v_[at(c.node)][c.component] = c.velocity(t);
  }

  void momentum_equation(Real t, Real dt) {
    v_.assign(at(node_count()), Vec3{});
    a_.assign(at(node_count()), Vec3{});
    std::vector<std::array<bool, 3>> is_free(at(node_count()), {true, true, true});
    for (int n = 0; n < node_count(); ++n) {
      if (!is_active(n)) {
        is_free[at(n)] = {false, false, false};
        continue;
      }
      for (std::size_t d = 0; d < dim; ++d) {
        a_[at(n)][d] = (f_[at(n)][d] - damping * p_[at(n)][d]) / m_[at(n)];
        v_[at(n)][d] = p_[at(n)][d] / m_[at(n)] + dt * a_[at(n)][d];
      }
    }
    for (const Constraint& c : constraints) {
      is_free[at(c.node)][c.component] = false;
      v_[at(c.node)][c.component] = c.velocity(t);
      a_[at(c.node)][c.component] = (c.velocity(t) - c.velocity(t - dt)) / dt;
    }
    for (int n = 0; n < node_count(); ++n) {
      for (std::size_t d = 0; d < dim; ++d) {
        if (is_free[at(n)][d]) damping_dissipation += damping * p_[at(n)][d] * v_[at(n)][d] * dt;
      }
    }
  }

  /// v = sum over j < k of (I - S+ S)^j v_1, with S v the velocities of the particles and S+ their mapping back (Nairn & Hammerquist 2021);
  /// prescribed components and nodes under the cutoff keep theirs.
  void refine() {
    std::vector<Vec3> term = v_;
    for (int j = 1; j < fmpm_order; ++j) {
      std::vector<Vec3> mapped(at(node_count()), Vec3{});
      for (const ReferenceParticle& q : particles) {
        const std::vector<Corner> c = corners(q);
        Vec3 u{};
        for (const Corner& k : c) {
          for (std::size_t d = 0; d < dim; ++d) u[d] += k.N * term[at(k.node)][d];
        }
        for (const Corner& k : c) {
          for (std::size_t d = 0; d < dim; ++d) mapped[at(k.node)][d] += k.N * q.mass * u[d];
        }
      }
      for (int n = 0; n < node_count(); ++n) {
        for (std::size_t d = 0; d < dim; ++d) term[at(n)][d] = is_active(n) ? term[at(n)][d] - mapped[at(n)][d] / m_[at(n)] : 0;
      }
      for (const Constraint& c : constraints) term[at(c.node)][c.component] = 0;
      for (int n = 0; n < node_count(); ++n) {
        for (std::size_t d = 0; d < dim; ++d) v_[at(n)][d] += term[at(n)][d];
      }
    }
  }

  void gather_velocity(Real dt) {
    for (ReferenceParticle& q : particles) {
      const std::vector<Corner> c = corners(q);
      for (std::size_t d = 0; d < dim; ++d) {
        Real flip_v = q.v[d];
        Real pic_v = 0;
        for (const Corner& k : c) {
          flip_v += dt * k.N * a_[at(k.node)][d];
          pic_v += k.N * v_[at(k.node)][d];
        }
        const Real share = transfer == Transfer::flip ? flip : 0;
        q.v[d] = share * flip_v + (1 - share) * pic_v;
      }
      if (transfer != Transfer::apic && transfer != Transfer::tpic) continue;
      q.C = {};
      for (std::size_t e = 0; e < dim; ++e) {
        Real inertia = 0;
        for (const Corner& k : c) inertia += k.N * std::pow(k.x[e] - centre(q)[e], 2);
        for (const Corner& k : c) {
          // APIC: B D^-1 (Jiang et al. 2015); TPIC: the velocity gradient, which APIC is, too, in the limit of a particle on a node.
          const Real weight = transfer == Transfer::tpic || inertia == 0 ? k.dN[e] : k.N * (k.x[e] - centre(q)[e]) / inertia;
          for (std::size_t d = 0; d < dim; ++d) q.C[d][e] += v_[at(k.node)][d] * weight;
        }
      }
    }
  }

  void update_stress(Real dt) {
    std::vector<Matrix> all;
    for (const ReferenceParticle& q : particles) {
      const std::vector<Corner> c = corners(q);
      Matrix L{};
      for (const Corner& k : c) {
        for (std::size_t r = 0; r < dim; ++r) {
          for (std::size_t s = 0; s < dim; ++s) L[r][s] += v_[at(k.node)][r] * k.dN[s];
        }
      }
      if (is_total) L = product(L, inverse(q.F));
      all.push_back(L);
    }
    if (has_fbar) {
      const std::vector<Real> means = cell_means([&](std::size_t p) { return spherical(all[p]); });
      for (std::size_t p = 0; p < all.size(); ++p) {
        const Real own = spherical(all[p]);
        for (std::size_t d = 0; d < dim; ++d) all[p][d][d] += means[p] - own;
      }
    }
    for (std::size_t p = 0; p < particles.size(); ++p) {
      ReferenceParticle& q = particles[p];
      const Matrix& L = all[p];
      const Matrix change = product(L, q.F);
      for (std::size_t r = 0; r < 3 && (is_total || !law.is_fluid); ++r) {
        for (std::size_t s = 0; s < 3; ++s) q.F[r][s] += dt * change[r][s];
      }
      for (std::size_t d = 0; d < dim && law.is_fluid && !is_total; ++d) q.F[d][d] *= std::exp(dt * trace(L) / static_cast<Real>(dim));
      q.sigma = law.stress(q.F, L);
      viscous_dissipation += law.dissipation(L) * determinant(q.F) * q.V0 * dt;
    }
    if (!has_fbar) return;
    const auto tau = [&](std::size_t p) { return determinant(particles[p].F) * spherical(particles[p].sigma); };
    const std::vector<Real> means = cell_means(tau);
    for (std::size_t p = 0; p < particles.size(); ++p) particles[p].spherical_change = means[p] - tau(p);
  }

  /// Mean of the diagonal entries in the problem's dimensions.
  Real spherical(const Matrix& a) const {
    Real sum = 0;
    for (std::size_t d = 0; d < dim; ++d) sum += a[d][d] / static_cast<Real>(dim);
    return sum;
  }

  /// Of each particle's cell, weighted by masses.
  std::vector<Real> cell_means(const std::function<Real(std::size_t)>& value) const {
    std::map<std::array<int, 3>, std::pair<Real, Real>> cell_sums;
    const auto cell_of = [&](const ReferenceParticle& q) {
      std::array<int, 3> cell{};
      for (std::size_t d = 0; d < dim; ++d) cell[d] = static_cast<int>(((is_total ? q.X : q.x)[d] - lower[d]) / h[d]);
      return cell;
    };
    for (std::size_t p = 0; p < particles.size(); ++p) {
      auto& [sum, mass] = cell_sums[cell_of(particles[p])];
      sum += particles[p].mass * value(p);
      mass += particles[p].mass;
    }
    std::vector<Real> means;
    for (const ReferenceParticle& q : particles) {
      const auto& [sum, mass] = cell_sums.at(cell_of(q));
      means.push_back(sum / mass);
    }
    return means;
  }

  /// Of the particles in a step, by the weights that their velocities were gathered with.
  std::vector<Vec3> displacements_in(Real dt) const {
    std::vector<Vec3> all;
    for (const ReferenceParticle& q : particles) {
      Vec3 u{};
      for (const Corner& k : corners(q)) {
        for (std::size_t d = 0; d < dim; ++d) u[d] += dt * k.N * v_[at(k.node)][d];
      }
      all.push_back(u);
    }
    return all;
  }

  std::vector<Real> m_;
  std::vector<Vec3> p_;
  std::vector<Vec3> f_;
  std::vector<Vec3> v_;
  std::vector<Vec3> a_;
};

}  // namespace matpoint::test
