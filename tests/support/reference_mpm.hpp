// A second, plain implementation of the explicit step, for comparison: particles in an array of structs, one loop per stage, dense arrays
// of nodes. Written from the equations of docs/theory.md and from nothing in src/; slow and easy to check by eye. In 2D (plane strain) the
// third component of everything stays what it is at rest.
#pragma once

#include <cmath>
#include <functional>
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

inline Real trace(const Matrix& a) { return a[0][0] + a[1][1] + a[2][2]; }

struct ReferenceParticle {
  Vec3 x{};
  Vec3 v{};
  Matrix F{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  Matrix sigma{};  ///< Cauchy stress [Pa]
  Real mass = 0;
  Real V0 = 0;
};

/// A law in the reference: Cauchy stress from F and L, and the dissipated power per present volume [W/m^3].
struct ReferenceLaw {
  std::function<Matrix(const Matrix& F, const Matrix& L)> stress;
  std::function<Real(const Matrix& L)> dissipation = [](const Matrix&) { return Real{0}; };
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

  int node_count() const { return (cells[0] + 1) * (cells[1] + 1) * (dim == 3 ? cells[2] + 1 : 1); }

  void step(Real t, Real dt) {
    if (order == StressOrder::usf) {
      map();
      node_velocities(t);
      update_stress(dt);
    }
    map();
    momentum_equation(t + dt, dt);
    const std::vector<Vec3> moving_v = v_;
    gather_velocity(dt);
    if (order == StressOrder::musl) {
      map();
      node_velocities(t + dt);
    }
    if (order != StressOrder::usf) update_stress(dt);
    v_ = moving_v;
    move(dt);
  }

 private:
  struct Corner {
    int node;
    Real N;
    Vec3 dN;
  };

  /// The nodes around x; a particle on a node line belongs to the cell behind it, on the far side to the last cell.
  std::vector<Corner> corners(const Vec3& x) const {
    std::array<int, 3> cell{};
    Vec3 xi{};
    for (std::size_t d = 0; d < dim; ++d) {
      const Real place = (x[d] - lower[d]) / h[d];
      cell[d] = std::min(static_cast<int>(std::floor(place)), cells[d] - 1);
      xi[d] = place - cell[d];
    }
    std::vector<Corner> out;
    for (int a = 0; a < (1 << dim); ++a) {
      std::array<int, 3> node = cell;
      Vec3 w{1, 1, 1};
      Vec3 dw{};
      for (std::size_t d = 0; d < dim; ++d) {
        const bool is_far = (a >> d & 1) != 0;
        node[d] += is_far;
        w[d] = is_far ? xi[d] : 1 - xi[d];
        dw[d] = (is_far ? 1 : -1) / h[d];
      }
      out.push_back({(node[2] * (cells[1] + 1) + node[1]) * (cells[0] + 1) + node[0],
                     w[0] * w[1] * w[2],
                     {dw[0] * w[1] * w[2], w[0] * dw[1] * w[2], w[0] * w[1] * dw[2]}});
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
      const std::vector<Corner> c = corners(q.x);
      for (const Corner& k : c) {
        m_[at(k.node)] += k.N * q.mass;
        for (std::size_t d = 0; d < dim; ++d) {
          p_[at(k.node)][d] += k.N * q.mass * q.v[d];
          f_[at(k.node)][d] += k.N * q.mass * gravity[d];
          for (std::size_t e = 0; e < dim; ++e) f_[at(k.node)][d] -= q.V0 * determinant(q.F) * q.sigma[d][e] * k.dN[e];
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
      a_[at(c.node)][c.component] = 0;
    }
    for (int n = 0; n < node_count(); ++n) {
      for (std::size_t d = 0; d < dim; ++d) {
        if (is_free[at(n)][d]) damping_dissipation += damping * p_[at(n)][d] * v_[at(n)][d] * dt;
      }
    }
  }

  void gather_velocity(Real dt) {
    for (ReferenceParticle& q : particles) {
      const std::vector<Corner> c = corners(q.x);
      for (std::size_t d = 0; d < dim; ++d) {
        Real flip_v = q.v[d];
        Real pic_v = 0;
        for (const Corner& k : c) {
          flip_v += dt * k.N * a_[at(k.node)][d];
          pic_v += k.N * v_[at(k.node)][d];
        }
        q.v[d] = flip * flip_v + (1 - flip) * pic_v;
      }
    }
  }

  void update_stress(Real dt) {
    for (ReferenceParticle& q : particles) {
      const std::vector<Corner> c = corners(q.x);
      Matrix L{};
      for (const Corner& k : c) {
        for (std::size_t r = 0; r < dim; ++r) {
          for (std::size_t s = 0; s < dim; ++s) L[r][s] += v_[at(k.node)][r] * k.dN[s];
        }
      }
      const Matrix change = product(L, q.F);
      for (std::size_t r = 0; r < 3; ++r) {
        for (std::size_t s = 0; s < 3; ++s) q.F[r][s] += dt * change[r][s];
      }
      q.sigma = law.stress(q.F, L);
      viscous_dissipation += law.dissipation(L) * determinant(q.F) * q.V0 * dt;
    }
  }

  void move(Real dt) {
    for (ReferenceParticle& q : particles) {
      const std::vector<Corner> c = corners(q.x);
      Vec3 u{};
      for (const Corner& k : c) {
        for (std::size_t d = 0; d < dim; ++d) u[d] += dt * k.N * v_[at(k.node)][d];
      }
      for (std::size_t d = 0; d < dim; ++d) q.x[d] += u[d];
    }
  }

  std::vector<Real> m_;
  std::vector<Vec3> p_;
  std::vector<Vec3> f_;
  std::vector<Vec3> v_;
  std::vector<Vec3> a_;
};

}  // namespace matpoint::test
