// What the surfaces of bodies add to the residual of an implicit step: thin cuts, sides, other bodies.
#include <algorithm>

#include "core/parallel.hpp"
#include "implicit/assembly.hpp"

namespace matpoint {

template <int Dim>
template <class Acts, class Work>
void Assembly<Dim>::assemble_cells(const std::vector<Real>& u, const StepLoad<Dim>& load, std::vector<Real>& residual, Lift* lift,
                                   Acts&& acts, Work&& work) {
  const auto functions = static_cast<std::size_t>(space_.functions());
  std::vector<Real> r(width()), K(lift != nullptr ? width() * width() : 0);
  for (std::size_t c = 0; c < space_.cells().size(); ++c) {
    if (!acts(c)) continue;
    const int* const nodes = space_.cell_nodes(c);
    std::fill(r.begin(), r.end(), 0);
    std::fill(K.begin(), K.end(), 0);
    Real* const matrix = lift != nullptr ? K.data() : nullptr;
    work(c, r.data(), matrix);
    if (!load.friction.empty()) add_friction(nodes, functions, u, load, r.data(), matrix);
    for (std::size_t k = 0; k < width(); ++k) residual[static_cast<std::size_t>(nodes[k / Dim]) * Dim + k % Dim] += r[k];
    if (lift != nullptr) scatter(nodes, functions, row_offset_.data() + c * functions * functions, matrix, *lift);
  }
}

template <int Dim>
void Assembly<Dim>::assemble_sides(const std::vector<Real>& u, const StepLoad<Dim>& load, std::vector<Real>& residual, Lift* lift) {
  assemble_cells(
      u, load, residual, lift, [&](std::size_t c) { return sides_.is_near(c); },
      [&](std::size_t c, Real* r, Real* K) { sides_.work(c, u, load.inertia.u > 0, r, K); });
}

template <int Dim>
void Assembly<Dim>::assemble_loads(const std::vector<Real>& u, const StepLoad<Dim>& load, std::vector<Real>& residual, Lift* lift) {
  assemble_cells(
      u, load, residual, lift, [&](std::size_t c) { return loads_.acts_in(c); },
      [&](std::size_t c, Real* r, Real* K) { loads_.work(c, u, load.factors, r, K); });
}

template <int Dim>
void Assembly<Dim>::assemble_faces(const std::vector<Real>& u, const StepLoad<Dim>& load, std::vector<Real>& residual, Lift* lift) {
  std::vector<Real> r, K;
  for (const SurfaceFace<Dim>& face : faces_) {
    const std::size_t n = face.nodes.size();
    const Real modulus = surface_penalty_ * laws_[face.source].soft_modulus * face.emptiness;
    r.assign(n * Dim, 0);
    if (lift != nullptr) K.assign(n * Dim * n * Dim, 0);
    for (std::size_t I = 0; I < n; ++I) {
      for (std::size_t J = 0; J < n; ++J) {
        const Real k = modulus * face.stiffness[I * n + J];
        for (std::size_t d = 0; d < Dim; ++d) {
          // Against the first node: what moves as a whole has no force, not even of rounding.
          r[I * Dim + d] +=
              k * (u[static_cast<std::size_t>(face.nodes[J]) * Dim + d] - u[static_cast<std::size_t>(face.nodes[0]) * Dim + d]);
          if (lift != nullptr) K[(I * Dim + d) * n * Dim + J * Dim + d] = k;
        }
      }
    }
    if (!load.friction.empty()) add_friction(face.nodes.data(), n, u, load, r.data(), lift != nullptr ? K.data() : nullptr);
    for (std::size_t k = 0; k < r.size(); ++k) residual[static_cast<std::size_t>(face.nodes[k / Dim]) * Dim + k % Dim] += r[k];
    if (lift != nullptr) scatter(face.nodes.data(), n, face.row_offset.data(), K.data(), *lift);
  }
}

template <int Dim>
void Assembly<Dim>::assemble_contact(const std::vector<Real>& u, const StepLoad<Dim>& load, std::vector<Real>& residual, Lift* lift) {
  constexpr std::size_t k_patches = 16;  // worked before they are added: in 3D the matrix of one may take 2 MB
  const std::vector<ContactPatch<Dim>>& patches = contact_.patches();
  std::vector<std::vector<Real>> r(k_patches), K(k_patches);
  for (std::size_t first = 0; first < patches.size(); first += k_patches) {
    const std::size_t count = std::min(k_patches, patches.size() - first);
    parallel_for(static_cast<Index>(count), static_cast<Index>(count) * 1000, [&](Index number) {
      const auto k = static_cast<std::size_t>(number);
      const ContactPatch<Dim>& patch = patches[first + k];
      const std::size_t size = patch.nodes.size() * Dim;
      r[k].resize(size);
      if (lift != nullptr) K[k].resize(size * size);
      Real* const matrix = lift != nullptr ? K[k].data() : nullptr;
      contact_.work(patch, load.inertia.u > 0, r[k].data(), matrix);
      if (!load.friction.empty()) add_friction(patch.nodes.data(), patch.nodes.size(), u, load, r[k].data(), matrix);
    });
    for (std::size_t k = 0; k < count; ++k) {
      const std::vector<int>& nodes = patches[first + k].nodes;
      for (std::size_t i = 0; i < nodes.size() * Dim; ++i) residual[static_cast<std::size_t>(nodes[i / Dim]) * Dim + i % Dim] += r[k][i];
      if (lift != nullptr) scatter(nodes.data(), nodes.size(), patches[first + k].row_offset.data(), K[k].data(), *lift);
    }
  }
}

// Used by assembly.cpp.
template void Assembly<2>::assemble_sides(const std::vector<Real>&, const StepLoad<2>&, std::vector<Real>&, Lift*);
template void Assembly<3>::assemble_sides(const std::vector<Real>&, const StepLoad<3>&, std::vector<Real>&, Lift*);
template void Assembly<2>::assemble_loads(const std::vector<Real>&, const StepLoad<2>&, std::vector<Real>&, Lift*);
template void Assembly<3>::assemble_loads(const std::vector<Real>&, const StepLoad<3>&, std::vector<Real>&, Lift*);
template void Assembly<2>::assemble_contact(const std::vector<Real>&, const StepLoad<2>&, std::vector<Real>&, Lift*);
template void Assembly<3>::assemble_contact(const std::vector<Real>&, const StepLoad<3>&, std::vector<Real>&, Lift*);
template void Assembly<2>::assemble_faces(const std::vector<Real>&, const StepLoad<2>&, std::vector<Real>&, Lift*);
template void Assembly<3>::assemble_faces(const std::vector<Real>&, const StepLoad<3>&, std::vector<Real>&, Lift*);

}  // namespace matpoint
