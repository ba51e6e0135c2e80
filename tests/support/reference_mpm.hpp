// A second, plain implementation of the explicit step in 2D, for comparison: particles in an array of structs, one loop per stage, dense
// arrays of nodes. Written from the equations of docs/theory.md and from nothing in src/; slow and easy to check by eye.
#pragma once

#include <cmath>
#include <functional>
#include <vector>

#include "case/case.hpp"

namespace matpoint::test {

struct ReferenceParticle {
  Real x[2] = {};
  Real v[2] = {};
  Real F[2][2] = {{1, 0}, {0, 1}};
  Real sigma[2][2] = {};  ///< Cauchy stress [Pa]
  Real mass = 0;
  Real V0 = 0;
  int law = 0;

  Real J() const { return F[0][0] * F[1][1] - F[0][1] * F[1][0]; }
};

/// A law in the reference: Cauchy stress from F and L, and the dissipated power per present volume [W/m^3].
struct ReferenceLaw {
  std::function<void(const ReferenceParticle&, const Real L[2][2], Real sigma[2][2])> stress;
  std::function<Real(const Real L[2][2])> dissipation = [](const Real[2][2]) { return Real{0}; };
};

/// sigma = mu/J (F F^T - I) + lambda/J ln J I. Source: Kamuth (thesis on explicit MPM), eq. 47.
inline ReferenceLaw reference_neo_hookean(Real E, Real nu) {
  const Real lambda = E * nu / ((1 + nu) * (1 - 2 * nu));
  const Real mu = E / (2 * (1 + nu));
  return {[=](const ReferenceParticle& p, const Real[2][2], Real sigma[2][2]) {
    const Real J = p.J();
    for (int r = 0; r < 2; ++r) {
      for (int c = 0; c < 2; ++c) {
        const Real b = p.F[r][0] * p.F[c][0] + p.F[r][1] * p.F[c][1];
        sigma[r][c] = mu / J * (b - (r == c)) + (r == c) * lambda / J * std::log(J);
      }
    }
  }};
}

/// sigma = 2 mu d' - p I, p = kappa (J^-gamma - 1), d' the deviator of the 3D rate: plane strain. Source: the same, eq. 49 and 50.
inline ReferenceLaw reference_newtonian_fluid(Real kappa, Real gamma, Real viscosity) {
  ReferenceLaw law;
  law.stress = [=](const ReferenceParticle& p, const Real L[2][2], Real sigma[2][2]) {
    const Real pressure = kappa * (std::pow(p.J(), -gamma) - 1);
    const Real trace = L[0][0] + L[1][1];
    for (int r = 0; r < 2; ++r) {
      for (int c = 0; c < 2; ++c) {
        sigma[r][c] = 2 * viscosity * ((L[r][c] + L[c][r]) / 2 - (r == c) * trace / 3) - (r == c) * pressure;
      }
    }
  };
  law.dissipation = [=](const Real L[2][2]) {
    const Real trace = L[0][0] + L[1][1];
    const Real xx = L[0][0] - trace / 3;
    const Real yy = L[1][1] - trace / 3;
    const Real zz = -trace / 3;
    const Real xy = (L[0][1] + L[1][0]) / 2;
    return 2 * viscosity * (xx * xx + yy * yy + zz * zz + 2 * xy * xy);
  };
  return law;
}

class ReferenceMpm {
 public:
  /// One node and component whose velocity is given as a function of time.
  struct Constraint {
    int node;
    int component;
    std::function<Real(Real t)> velocity;
  };

  StressOrder order = StressOrder::usl;
  Real lower[2] = {};
  Real h[2] = {1, 1};
  int cells[2] = {1, 1};
  Real gravity[2] = {};
  Real damping = 0;
  Real flip = 1;
  Real mass_cutoff = 0;
  std::vector<ReferenceParticle> particles;
  std::vector<ReferenceLaw> laws;
  std::vector<Constraint> constraints;

  // Books, each from its own definition.
  Real damping_dissipation = 0;  ///< Sum over free components of alpha p_i v_i(end) dt.
  Real viscous_dissipation = 0;  ///< Sum over particles of 2 mu d':d' J V0 dt.

  int node_count() const { return (cells[0] + 1) * (cells[1] + 1); }

  void step(Real t, Real dt) {
    if (order == StressOrder::usf) {
      map();
      node_velocities(t);
      update_stress(dt);
    }
    map();
    momentum_equation(t + dt, dt);
    const std::vector<std::array<Real, 2>> moving_v = v_;
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
    Real dN[2];
  };

  /// The four nodes around x; a particle on a node line belongs to the cell behind it, on the far side to the last cell.
  void corners(const Real x[2], Corner out[4]) const {
    int cell[2];
    Real xi[2];
    for (int d = 0; d < 2; ++d) {
      const Real place = (x[d] - lower[d]) / h[d];
      cell[d] = std::min(static_cast<int>(std::floor(place)), cells[d] - 1);
      xi[d] = place - cell[d];
    }
    for (int a = 0; a < 4; ++a) {
      const int i = a % 2;
      const int j = a / 2;
      const Real wx = i ? xi[0] : 1 - xi[0];
      const Real wy = j ? xi[1] : 1 - xi[1];
      out[a] = {(cell[1] + j) * (cells[0] + 1) + cell[0] + i, wx * wy, {(i ? 1 : -1) / h[0] * wy, (j ? 1 : -1) / h[1] * wx}};
    }
  }

  bool is_active(int node) const { return m_[at(node)] > 0 && m_[at(node)] >= mass_cutoff; }
  static std::size_t at(int node) { return static_cast<std::size_t>(node); }

  void map() {
    m_.assign(at(node_count()), 0);
    p_.assign(at(node_count()), {0, 0});
    f_.assign(at(node_count()), {0, 0});
    for (const ReferenceParticle& q : particles) {
      Corner c[4];
      corners(q.x, c);
      for (const Corner& k : c) {
        m_[at(k.node)] += k.N * q.mass;
        for (std::size_t d = 0; d < 2; ++d) {
          p_[at(k.node)][d] += k.N * q.mass * q.v[d];
          f_[at(k.node)][d] += k.N * q.mass * gravity[d] - q.V0 * q.J() * (q.sigma[d][0] * k.dN[0] + q.sigma[d][1] * k.dN[1]);
        }
      }
    }
  }

  void node_velocities(Real t) {
    v_.assign(at(node_count()), {0, 0});
    for (int n = 0; n < node_count(); ++n) {
      if (!is_active(n)) continue;
      for (std::size_t d = 0; d < 2; ++d) v_[at(n)][d] = p_[at(n)][d] / m_[at(n)];
    }
    for (const Constraint& c : constraints) v_[at(c.node)][at(c.component)] = c.velocity(t);
  }

  void momentum_equation(Real t, Real dt) {
    v_.assign(at(node_count()), {0, 0});
    a_.assign(at(node_count()), {0, 0});
    std::vector<std::array<bool, 2>> is_free(at(node_count()), {true, true});
    for (int n = 0; n < node_count(); ++n) {
      if (!is_active(n)) {
        is_free[at(n)] = {false, false};
        continue;
      }
      for (std::size_t d = 0; d < 2; ++d) {
        a_[at(n)][d] = (f_[at(n)][d] - damping * p_[at(n)][d]) / m_[at(n)];
        v_[at(n)][d] = p_[at(n)][d] / m_[at(n)] + dt * a_[at(n)][d];
      }
    }
    for (const Constraint& c : constraints) {
      is_free[at(c.node)][at(c.component)] = false;
      v_[at(c.node)][at(c.component)] = c.velocity(t);
      a_[at(c.node)][at(c.component)] = 0;
    }
    for (int n = 0; n < node_count(); ++n) {
      for (std::size_t d = 0; d < 2; ++d) {
        if (is_free[at(n)][d]) damping_dissipation += damping * p_[at(n)][d] * v_[at(n)][d] * dt;
      }
    }
  }

  void gather_velocity(Real dt) {
    for (ReferenceParticle& q : particles) {
      Corner c[4];
      corners(q.x, c);
      for (std::size_t d = 0; d < 2; ++d) {
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
      Corner c[4];
      corners(q.x, c);
      Real L[2][2] = {};
      for (const Corner& k : c) {
        for (int r = 0; r < 2; ++r) {
          for (int s = 0; s < 2; ++s) L[r][s] += v_[at(k.node)][at(r)] * k.dN[s];
        }
      }
      Real F[2][2];
      for (int r = 0; r < 2; ++r) {
        for (int s = 0; s < 2; ++s) F[r][s] = q.F[r][s] + dt * (L[r][0] * q.F[0][s] + L[r][1] * q.F[1][s]);
      }
      std::copy(&F[0][0], &F[0][0] + 4, &q.F[0][0]);
      const ReferenceLaw& law = laws[at(q.law)];
      law.stress(q, L, q.sigma);
      viscous_dissipation += law.dissipation(L) * q.J() * q.V0 * dt;
    }
  }

  void move(Real dt) {
    for (ReferenceParticle& q : particles) {
      Corner c[4];
      corners(q.x, c);
      Real u[2] = {};
      for (const Corner& k : c) {
        for (std::size_t d = 0; d < 2; ++d) u[d] += dt * k.N * v_[at(k.node)][d];
      }
      for (int d = 0; d < 2; ++d) q.x[d] += u[d];
    }
  }

  std::vector<Real> m_;
  std::vector<std::array<Real, 2>> p_;
  std::vector<std::array<Real, 2>> f_;
  std::vector<std::array<Real, 2>> v_;
  std::vector<std::array<Real, 2>> a_;
};

}  // namespace matpoint::test
