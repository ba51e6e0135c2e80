// The equations of nearly incompressible bodies, patch by patch (volume_patches.hpp has the method).
//
// Per particle the energy is w(A, m) = W(A' F) with A' = (m / j)^(1/dim) A and m = Pi j. Its derivatives S^ = dw/dA, p = dw/dm, D^ =
// d2w/dA2, E = dS^/dm and E' = dp/dA, h = dp/dm follow from the law's S' and D' at A'. With b_a = sum_p V0 psi_a j A^-T g, and e_a, e'_a
// the sums of V0 psi_a E g and V0 psi_a E' g,
//   K = sum_p V0 g [D^ + pi d(j A^-T)/dA] g + sum_a (e_a b_a^T + b_a e'_a^T) + sum_ab H_ab b_a b_b^T,   H_ab = sum_p V0 psi_a psi_b h.
#include <algorithm>
#include <cmath>

#include "core/parallel.hpp"
#include "implicit/assembly.hpp"
#include "implicit/point_kernels.hpp"

namespace matpoint {
namespace {

/// Patches that are worked before their matrices are added to the sparse one.
constexpr std::size_t k_batch = 16;

/// w(A, m) of one particle, with its derivatives.
template <int Dim>
struct ProjectedPoint {
  static constexpr int n = Dim * Dim;
  Real S[n];      ///< S^
  Real D[n * n];  ///< D^
  Real E[n];      ///< dS^/dm
  Real E_of[n];   ///< dp/dA
  Real p;         ///< dw/dm
  Real h;         ///< dp/dm

  /// Of S' and D' (or null: no second derivatives) at A' = s A, with B = A^-T.
  ProjectedPoint(const Real* A, const Real* B, Real s, Real m, const Real* S_law, const Real* D_law) {
    Real SA = 0;  // S' : A
    for (int i = 0; i < n; ++i) SA += S_law[i] * A[i];
    const Real t = s * SA;
    for (int i = 0; i < n; ++i) S[i] = s * S_law[i] - t / Dim * B[i];
    p = t / (Dim * m);
    if (D_law == nullptr) return;
    Real Y[n * n];        // D' : dA'/dA
    Real DA[n], ADA = 0;  // D' : A, A : D' : A
    for (int ij = 0; ij < n; ++ij) {
      DA[ij] = 0;
      for (int pq = 0; pq < n; ++pq) DA[ij] += D_law[ij * n + pq] * A[pq];
      ADA += A[ij] * DA[ij];
      for (int kl = 0; kl < n; ++kl) Y[ij * n + kl] = s * D_law[ij * n + kl] - s / Dim * DA[ij] * B[kl];
    }
    Real AY[n];  // A : Y
    for (int kl = 0; kl < n; ++kl) {
      AY[kl] = 0;
      for (int ij = 0; ij < n; ++ij) AY[kl] += A[ij] * Y[ij * n + kl];
    }
    for (int i = 0; i < Dim; ++i) {
      for (int j = 0; j < Dim; ++j) {
        for (int k = 0; k < Dim; ++k) {
          for (int l = 0; l < Dim; ++l) {
            const int ij = i * Dim + j, kl = k * Dim + l;
            D[ij * n + kl] = s * Y[ij * n + kl] - s / Dim * B[ij] * AY[kl] - s / Dim * (S_law[ij] - SA / Dim * B[ij]) * B[kl] -
                             s / Dim * B[ij] * S_law[kl] + s / Dim * SA * B[i * Dim + l] * B[k * Dim + j];
          }
        }
      }
    }
    for (int ij = 0; ij < n; ++ij) {
      E[ij] = (s * s * (DA[ij] - ADA / Dim * B[ij]) + S[ij]) / (Dim * m);
      E_of[ij] = (s * AY[ij] + S[ij]) / (Dim * m);
    }
    h = (s * s * ADA + (1 - Dim) * t) / (Dim * m * Dim * m);
  }
};

/// v_I += factor M g_I for the nodes of a cell, at their places in the patch.
template <int Dim>
void add_divergence(Real factor, const Real* M, const Real* g, const int* local, int functions, Real* v) {
  for (int node = 0; node < functions; ++node) {
    for (int i = 0; i < Dim; ++i) {
      Real sum = 0;
      for (int j = 0; j < Dim; ++j) sum += M[i * Dim + j] * g[node * Dim + j];
      v[local[node] * Dim + i] += factor * sum;
    }
  }
}

}  // namespace

template <int Dim>
void Assembly<Dim>::work_patch(const VolumePatch<Dim>& patch, const std::vector<Real>& u, const StepLoad<Dim>& load,
                               std::vector<Real>& residual, std::vector<Real>* K) const {
  constexpr int n = Dim * Dim;
  const PointBody<Dim>& body = *space_.sources()[patch.source].points;
  const Law& law = laws_[patch.source];
  const int functions = space_.functions();
  const std::size_t size = patch.nodes.size() * Dim;
  const auto modes = static_cast<std::size_t>(patch.modes);
  residual.assign(size, 0);
  if (K != nullptr) K->assign(size * size, 0);
  // The particles, cell by cell: where they are, A, and what the law is given.
  struct At {
    Index place;
    std::size_t row;
    std::size_t cell;  // of the patch
  };
  std::vector<At> points;
  for (std::size_t c = 0; c < patch.cells.size(); ++c) {
    for (Index k = space_.cell_begin(patch.cells[c]); k < space_.cell_end(patch.cells[c]); ++k)
      points.push_back({k, static_cast<std::size_t>(space_.particles()[static_cast<std::size_t>(k)]), c});
  }
  const std::size_t count = points.size();
  std::vector<Real> A(count * n), A_law(count * n), F(count * n), j(count), mean(count, 0), scale(count), S(count * n), c(modes, 0);
  const auto history_size = static_cast<std::size_t>(body.material().history_size(Dim));
  std::vector<Real> history(count * history_size), tangent(K != nullptr ? count * n * n : 0);
  for (std::size_t k = 0; k < count; ++k) {
    const At& at = points[k];
    const int* const nodes = space_.cell_nodes(patch.cells[at.cell]);
    Real u_cell[27 * Dim];
    for (int node = 0; node < functions; ++node) std::copy_n(u.data() + nodes[node] * Dim, Dim, u_cell + node * Dim);
    if (functions == whole_power(2, Dim))
      deformation<Dim, whole_power(2, Dim)>(u_cell, space_.trial_gradients(at.place), A.data() + k * n);
    else
      deformation<Dim, whole_power(3, Dim)>(u_cell, space_.trial_gradients(at.place), A.data() + k * n);
    j[k] = determinant_of<Dim>(A.data() + k * n);
    for (std::size_t a = 0; a < modes; ++a) c[a] += body.volume0[at.row] * patch.psi[k * modes + a] * j[k];
    std::copy_n(body.F.data() + at.row * n, n, F.data() + k * n);
    std::copy_n(body.history.data() + at.row * history_size, history_size, history.data() + k * history_size);
  }
  for (std::size_t k = 0; k < count; ++k) {
    for (std::size_t a = 0; a < modes; ++a) mean[k] += patch.psi[k * modes + a] * c[a];
    scale[k] = std::pow(mean[k] / j[k], 1.0 / Dim);
    for (int e = 0; e < n; ++e) A_law[k * n + static_cast<std::size_t>(e)] = scale[k] * A[k * n + static_cast<std::size_t>(e)];
  }
  TangentPoints law_points;
  law_points.count = static_cast<Index>(count);
  law_points.dt = load.dt;
  law_points.A = A_law.data();
  law_points.F = F.data();
  law_points.history = history.data();
  law_points.S = S.data();
  law_points.tangent = K != nullptr ? tangent.data() : nullptr;
  law.evaluate(law.data, law_points);
  // What the volumes of the patch do together.
  std::vector<Real> pressure(modes, 0), H(modes * modes, 0);
  std::vector<Real> b(modes * size, 0), b_trial(modes * size, 0), e(modes * size, 0), e_trial(modes * size, 0);
  std::vector<ProjectedPoint<Dim>> projected;
  projected.reserve(count);
  std::vector<Real> B(count * n);
  for (std::size_t k = 0; k < count; ++k) {
    const At& at = points[k];
    const Real volume = body.volume0[at.row];
    inverse_transposed<Dim>(A.data() + k * n, j[k], B.data() + k * n);
    projected.emplace_back(A.data() + k * n, B.data() + k * n, scale[k], mean[k], S.data() + k * n,
                           K != nullptr ? tangent.data() + k * n * n : nullptr);
    const ProjectedPoint<Dim>& point = projected.back();
    const int* const local = patch.local.data() + at.cell * static_cast<std::size_t>(functions);
    for (std::size_t a = 0; a < modes; ++a) {
      const Real weight = volume * patch.psi[k * modes + a];
      pressure[a] += weight * point.p;
      add_divergence<Dim>(weight * j[k], B.data() + k * n, space_.gradients(at.place), local, functions, b.data() + a * size);
      if (K == nullptr) continue;
      add_divergence<Dim>(weight * j[k], B.data() + k * n, space_.trial_gradients(at.place), local, functions, b_trial.data() + a * size);
      add_divergence<Dim>(weight, point.E, space_.gradients(at.place), local, functions, e.data() + a * size);
      add_divergence<Dim>(weight, point.E_of, space_.trial_gradients(at.place), local, functions, e_trial.data() + a * size);
      for (std::size_t other = 0; other < modes; ++other) H[a * modes + other] += weight * patch.psi[k * modes + other] * point.h;
    }
  }
  for (std::size_t a = 0; a < modes; ++a) {
    for (std::size_t row = 0; row < size; ++row) residual[row] += pressure[a] * b[a * size + row];
    if (K == nullptr) continue;
    for (std::size_t column = 0; column < size; ++column) {
      for (std::size_t other = 0; other < modes; ++other)
        e_trial[a * size + column] += H[a * modes + other] * b_trial[other * size + column];
    }
    for (std::size_t row = 0; row < size; ++row) {
      const Real left = e[a * size + row], right = b[a * size + row];
      if (left == 0 && right == 0) continue;
      Real* const out = K->data() + row * size;
      for (std::size_t column = 0; column < size; ++column)
        out[column] += left * b_trial[a * size + column] + right * e_trial[a * size + column];
    }
  }
  // Each particle by itself.
  const std::size_t width_of_cell = width();
  std::vector<Real> K_cell(K != nullptr ? width_of_cell * width_of_cell : 0);
  std::size_t k = 0;
  for (std::size_t cell = 0; cell < patch.cells.size(); ++cell) {
    const int* const local = patch.local.data() + cell * static_cast<std::size_t>(functions);
    const int* const nodes = space_.cell_nodes(patch.cells[cell]);
    std::fill(K_cell.begin(), K_cell.end(), 0);
    for (; k < count && points[k].cell == cell; ++k) {
      const At& at = points[k];
      const Real volume = body.volume0[at.row], mass = body.mass[at.row];
      const Real* const N = space_.N(at.place);
      const ProjectedPoint<Dim>& point = projected[k];
      add_divergence<Dim>(volume, point.S, space_.gradients(at.place), local, functions, residual.data());
      for (int i = 0; i < Dim; ++i) {
        const auto s = static_cast<std::size_t>(i);
        Real du = 0;
        for (int node = 0; node < functions; ++node) du += N[node] * u[static_cast<std::size_t>(nodes[node] * Dim + i)];
        const Real acceleration =
            load.inertia.u * du - load.inertia.v * body.velocity[at.row][s] - load.inertia.a * body.acceleration[at.row][s];
        const Real force = mass * (acceleration - load.b(patch.source, law.weight_ratio, at.row, s));
        for (int node = 0; node < functions; ++node) residual[static_cast<std::size_t>(local[node] * Dim + i)] += N[node] * force;
      }
      if (K == nullptr) continue;
      Real pi = 0;
      for (std::size_t a = 0; a < modes; ++a) pi += patch.psi[k * modes + a] * pressure[a];
      Real D[n * n];
      const Real* const B_k = B.data() + k * n;
      for (int r = 0; r < Dim; ++r) {
        for (int q = 0; q < Dim; ++q) {
          for (int o = 0; o < Dim; ++o) {
            for (int l = 0; l < Dim; ++l) {
              const int rq = r * Dim + q, ol = o * Dim + l;
              D[rq * n + ol] = point.D[rq * n + ol] + pi * j[k] * (B_k[rq] * B_k[ol] - B_k[r * Dim + l] * B_k[o * Dim + q]);
            }
          }
        }
      }
      if (functions == whole_power(2, Dim))
        add_stiffness<Dim, whole_power(2, Dim)>(volume, D, space_.gradients(at.place), space_.trial_gradients(at.place), K_cell.data());
      else
        add_stiffness<Dim, whole_power(3, Dim)>(volume, D, space_.gradients(at.place), space_.trial_gradients(at.place), K_cell.data());
      const Real inertia = mass * load.inertia.u;
      for (int I = 0; I < functions && inertia != 0; ++I) {
        for (int node = 0; node < functions; ++node) {
          for (int i = 0; i < Dim; ++i)
            K_cell[static_cast<std::size_t>(I * Dim + i) * width_of_cell + static_cast<std::size_t>(node * Dim + i)] +=
                inertia * N[I] * N[node];
        }
      }
    }
    const int soft = soft_cells_[patch.cells[cell]];
    for (std::size_t row = 0; row < width_of_cell; ++row) {
      const std::size_t out_row = static_cast<std::size_t>(local[row / Dim]) * Dim + row % Dim;
      for (std::size_t column = 0; column < width_of_cell; ++column) {
        const Real entry = soft < 0 ? 0 : soft_stiffness_[(static_cast<std::size_t>(soft) * width_of_cell + row) * width_of_cell + column];
        residual[out_row] += entry * u[static_cast<std::size_t>(nodes[column / Dim]) * Dim + column % Dim];
        if (K == nullptr) continue;
        (*K)[out_row * size + static_cast<std::size_t>(local[column / Dim]) * Dim + column % Dim] +=
            entry + K_cell[row * width_of_cell + column];
      }
    }
  }
}

template <int Dim>
void Assembly<Dim>::assemble_patches(const std::vector<Real>& u, const StepLoad<Dim>& load, std::vector<Real>& residual, Lift* lift) {
  const std::vector<VolumePatch<Dim>>& patches = patches_.all();
  std::vector<std::vector<Real>> residuals(k_batch), matrices(k_batch);
  for (std::size_t first = 0; first < patches.size(); first += k_batch) {
    const std::size_t count = std::min(k_batch, patches.size() - first);
    parallel_for(static_cast<Index>(count), static_cast<Index>(count) * 1000, [&](Index number) {
      const auto s = static_cast<std::size_t>(number);
      const VolumePatch<Dim>& patch = patches[first + s];
      work_patch(patch, u, load, residuals[s], lift != nullptr ? &matrices[s] : nullptr);
      if (!load.friction.empty())
        add_friction(patch.nodes.data(), patch.nodes.size(), u, load, residuals[s].data(), lift != nullptr ? matrices[s].data() : nullptr);
    });
    for (std::size_t s = 0; s < count; ++s) {
      const VolumePatch<Dim>& patch = patches[first + s];
      for (std::size_t k = 0; k < residuals[s].size(); ++k)
        residual[static_cast<std::size_t>(patch.nodes[k / Dim]) * Dim + k % Dim] += residuals[s][k];
      if (lift != nullptr) scatter(patch.nodes.data(), patch.nodes.size(), patch.row_offset.data(), matrices[s].data(), *lift);
    }
  }
}

template void Assembly<2>::assemble_patches(const std::vector<Real>&, const StepLoad<2>&, std::vector<Real>&, Lift*);
template void Assembly<3>::assemble_patches(const std::vector<Real>&, const StepLoad<3>&, std::vector<Real>&, Lift*);

}  // namespace matpoint
