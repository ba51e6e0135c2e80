#include "implicit/volume_patches.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/parallel.hpp"

namespace matpoint {
namespace {

/// What a function must have left, beside those before it, of its square's mean over the patch in units of its width. A patch that is full
/// has 1/12; one of two halves that is full 1/48.
constexpr Real k_rest = 0.012;

}  // namespace

template <int Dim>
VolumePatches<Dim>::VolumePatches(const StepSpace<Dim>& space, int width, bool is_linear)
    : space_(space), width_(width), is_linear_(is_linear) {
  has_any_ = std::any_of(space.sources().begin(), space.sources().end(), [](const auto& source) { return source.has_fbar; });
  ElementPoint<Dim> low{0, {}}, high{0, {}};
  low.xi.fill(-1);
  high.xi.fill(1);
  first_ = space.basis().position(low);
  const Vec<Dim> end = space.basis().position(high);
  for (std::size_t d = 0; d < Dim; ++d) size_[d] = width * (end[d] - first_[d]);
}

template <int Dim>
void VolumePatches<Dim>::gather() {
  patches_.clear();
  std::map<std::vector<Index>, std::size_t> by_place;
  for (std::size_t c = 0; c < space_.cells().size(); ++c) {
    if (!holds(c)) continue;
    const std::size_t source = space_.source_of(c);
    std::vector<Index> place{static_cast<Index>(source)};
    if (width_ == 1) {
      place.push_back(space_.cells()[c]);
    } else {
      const Vec<Dim> middle = space_.basis().position({space_.cells()[c], {}});
      for (std::size_t d = 0; d < Dim; ++d) place.push_back(static_cast<Index>(std::floor((middle[d] - first_[d]) / size_[d])));
    }
    const auto [found, is_new] = by_place.try_emplace(place, patches_.size());
    if (is_new) {
      patches_.emplace_back();
      patches_.back().source = source;
    }
    VolumePatch<Dim>& patch = patches_[found->second];
    patch.cells.push_back(c);
    patch.nodes.insert(patch.nodes.end(), space_.cell_nodes(c), space_.cell_nodes(c) + space_.functions());
  }
  for (VolumePatch<Dim>& patch : patches_) {
    std::sort(patch.nodes.begin(), patch.nodes.end());
    patch.nodes.erase(std::unique(patch.nodes.begin(), patch.nodes.end()), patch.nodes.end());
    for (const std::size_t c : patch.cells) {
      for (int i = 0; i < space_.functions(); ++i) {
        const auto place = std::lower_bound(patch.nodes.begin(), patch.nodes.end(), space_.cell_nodes(c)[i]);
        patch.local.push_back(static_cast<int>(place - patch.nodes.begin()));
      }
    }
  }
}

template <int Dim>
void VolumePatches<Dim>::evaluate() {
  parallel_for(static_cast<Index>(patches_.size()), static_cast<Index>(space_.particles().size()), [&](Index number) {
    VolumePatch<Dim>& patch = patches_[static_cast<std::size_t>(number)];
    const PointBody<Dim>& body = *space_.sources()[patch.source].points;
    std::vector<std::size_t> rows;
    for (const std::size_t c : patch.cells) {
      for (Index k = space_.cell_begin(c); k < space_.cell_end(c); ++k)
        rows.push_back(static_cast<std::size_t>(space_.particles()[static_cast<std::size_t>(k)]));
    }
    const Vec<Dim> origin = body.position[rows.front()];
    Real volume = 0;
    for (const std::size_t p : rows) volume += body.volume0[p];
    // Gram and Schmidt, by volume.
    std::vector<std::vector<Real>> basis;
    for (int mode = 0; mode <= (is_linear_ ? Dim : 0); ++mode) {
      std::vector<Real> f(rows.size(), 1);
      for (std::size_t k = 0; k < rows.size() && mode > 0; ++k) {
        const auto d = static_cast<std::size_t>(mode - 1);
        f[k] = (body.position[rows[k]][d] - origin[d]) / size_[d];
      }
      const auto product = [&](const std::vector<Real>& a, const std::vector<Real>& b) {
        Real sum = 0;
        for (std::size_t k = 0; k < rows.size(); ++k) sum += body.volume0[rows[k]] * a[k] * b[k];
        return sum;
      };
      for (int twice = 0; twice < 2; ++twice) {
        for (const std::vector<Real>& one : basis) {
          const Real part = product(one, f);
          for (std::size_t k = 0; k < rows.size(); ++k) f[k] -= part * one[k];
        }
      }
      const Real rest = product(f, f);
      if (mode > 0 && rest < k_rest * volume) continue;
      for (Real& value : f) value /= std::sqrt(rest);
      basis.push_back(std::move(f));
    }
    patch.modes = static_cast<int>(basis.size());
    patch.psi.resize(rows.size() * basis.size());
    for (std::size_t k = 0; k < rows.size(); ++k) {
      for (std::size_t a = 0; a < basis.size(); ++a) patch.psi[k * basis.size() + a] = basis[a][k];
    }
  });
}

template class VolumePatches<2>;
template class VolumePatches<3>;

}  // namespace matpoint
