// Works and forces of an implicit step that only its books ask for.
#include <algorithm>

#include "core/parallel.hpp"
#include "implicit/assembly.hpp"

namespace matpoint {

template <int Dim>
void Assembly<Dim>::soft_force(const std::vector<Real>& u, std::vector<Real>& out) const {
  out.assign(space_.nodes().size() * Dim, 0);
  for (std::size_t c = 0; c < space_.cells().size(); ++c) {
    if (soft_cells_[c] < 0) continue;
    const Real* const K = soft_stiffness_.data() + static_cast<std::size_t>(soft_cells_[c]) * width() * width();
    const int* const nodes = space_.cell_nodes(c);
    const auto place = [&](std::size_t k) { return static_cast<std::size_t>(nodes[k / Dim]) * Dim + k % Dim; };
    for (std::size_t row = 0; row < width(); ++row) {
      for (std::size_t column = 0; column < width(); ++column) out[place(row)] += K[row * width() + column] * u[place(column)];
    }
  }
  for (const SurfaceFace<Dim>& face : faces_) {
    const std::size_t n = face.nodes.size();
    const Real modulus = surface_penalty_ * laws_[face.source].soft_modulus * face.emptiness;
    for (std::size_t k = 0; k < n * n; ++k) {
      for (std::size_t d = 0; d < Dim; ++d)
        out[static_cast<std::size_t>(face.nodes[k / n]) * Dim + d] +=
            modulus * face.stiffness[k] * u[static_cast<std::size_t>(face.nodes[k % n]) * Dim + d];
    }
  }
}

template <int Dim>
typename Assembly<Dim>::StressWork Assembly<Dim>::stress_work(const std::vector<Real>& u, Real dt) const {
  constexpr auto n = static_cast<std::size_t>(Dim * Dim);
  std::vector<StressWork> of_cells(space_.cells().size());
  // Mean stresses in patches act by their projections.
  std::vector<Real> means(patches_.is_empty() ? 0 : space_.particles().size()), growths(means.size());
  parallel_for(static_cast<Index>(of_cells.size()), static_cast<Index>(space_.particles().size()) * 5, [&](Index cell) {
    const auto c = static_cast<std::size_t>(cell);
    const std::size_t source = space_.source_of(c);
    const PointBody<Dim>& body = *space_.sources()[source].points;
    const auto history_size = static_cast<std::size_t>(body.material().history_size(Dim));
    /// S = tau A^-T of one particle.
    const auto stress = [&](std::size_t p, const Real* A, Real* S) {
      TangentPoints point;
      point.count = 1;
      point.dt = dt;
      point.A = A;
      point.F = body.F.data() + p * n;
      point.history = body.history.data() + p * history_size;
      point.S = S;
      laws_[source].evaluate(laws_[source].data, point);
    };
    const int* const nodes = space_.cell_nodes(c);
    StressWork& work = of_cells[c];
    for (Index k = space_.cell_begin(c); k < space_.cell_end(c); ++k) {
      const auto p = static_cast<std::size_t>(space_.particles()[static_cast<std::size_t>(k)]);
      const Real* const g = space_.gradients(k);
      const Real* const trial = space_.trial_gradients(k);
      Real A[n] = {};
      Real gradient[n] = {};
      Real correction[n] = {};
      for (std::size_t d = 0; d < Dim; ++d) A[d * Dim + d] = 1;
      for (std::size_t node = 0; node < static_cast<std::size_t>(space_.functions()); ++node) {
        const Real* const u_node = u.data() + static_cast<std::size_t>(nodes[node]) * Dim;
        for (std::size_t i = 0; i < Dim; ++i) {
          for (std::size_t j = 0; j < Dim; ++j) {
            gradient[i * Dim + j] += u_node[i] * g[node * Dim + j];
            correction[i * Dim + j] += u_node[i] * (trial[node * Dim + j] - g[node * Dim + j]);
          }
        }
      }
      Real S[n];
      if (body.tau.empty()) {
        stress(p, A, S);
      } else {  // a stress that does not follow from F: as the last step left it
        constexpr std::size_t voigt[3][3] = {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}};
        for (std::size_t i = 0; i < Dim; ++i) {
          for (std::size_t j = 0; j < Dim; ++j) S[i * Dim + j] = body.tau[6 * p + voigt[i][j]];
        }
      }
      for (std::size_t i = 0; i < n; ++i) work.start += body.volume0[p] * S[i] * gradient[i];
      if (patches_.holds(c)) {
        Real mean = 0, growth = 0;
        for (std::size_t d = 0; d < Dim; ++d) mean += S[d * Dim + d] / Dim, growth += gradient[d * Dim + d];
        means[static_cast<std::size_t>(k)] = mean;
        growths[static_cast<std::size_t>(k)] = growth;
        work.start -= body.volume0[p] * mean * growth;
      }
      if (g == trial) continue;
      for (std::size_t i = 0; i < n; ++i) {
        work.correction_start += body.volume0[p] * S[i] * correction[i];
        A[i] += gradient[i] + correction[i];
      }
      stress(p, A, S);
      for (std::size_t i = 0; i < n; ++i) work.correction_end += body.volume0[p] * S[i] * correction[i];
    }
  });
  StressWork sum;
  for (const StressWork& work : of_cells) {
    sum.start += work.start;
    sum.correction_start += work.correction_start;
    sum.correction_end += work.correction_end;
  }
  for (const VolumePatch<Dim>& patch : patches_.all()) {
    const PointBody<Dim>& body = *space_.sources()[patch.source].points;
    const auto modes = static_cast<std::size_t>(patch.modes);
    std::vector<Real> mean(modes, 0), growth(modes, 0);
    std::size_t k = 0;
    for (const std::size_t cell : patch.cells) {
      for (Index place = space_.cell_begin(cell); place < space_.cell_end(cell); ++place, ++k) {
        const auto at = static_cast<std::size_t>(place);
        const Real volume = body.volume0[static_cast<std::size_t>(space_.particles()[at])];
        for (std::size_t a = 0; a < modes; ++a) {
          mean[a] += volume * patch.psi[k * modes + a] * means[at];
          growth[a] += volume * patch.psi[k * modes + a] * growths[at];
        }
      }
    }
    for (std::size_t a = 0; a < modes; ++a) sum.start += mean[a] * growth[a];
  }
  return sum;
}

// Used by implicit_update.cpp.
template void Assembly<2>::soft_force(const std::vector<Real>&, std::vector<Real>&) const;
template void Assembly<3>::soft_force(const std::vector<Real>&, std::vector<Real>&) const;
template Assembly<2>::StressWork Assembly<2>::stress_work(const std::vector<Real>&, Real) const;
template Assembly<3>::StressWork Assembly<3>::stress_work(const std::vector<Real>&, Real) const;

}  // namespace matpoint
