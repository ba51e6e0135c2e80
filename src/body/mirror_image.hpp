// Sides that are planes of symmetry: beyond them bodies go on as their own images, and so touch.
#pragma once

#include "case/case.hpp"

namespace matpoint {

template <int Dim>
struct MirrorImage {
  std::array<bool, Dim> is_turned{};  ///< Along which axes.
  Vec<Dim> plane{};                   ///< Where [m].

  Vec<Dim> place(Vec<Dim> x) const {
    for (std::size_t d = 0; d < Dim; ++d) x[d] = is_turned[d] ? 2 * plane[d] - x[d] : x[d];
    return x;
  }
  Vec<Dim> direction(Vec<Dim> v) const {
    for (std::size_t d = 0; d < Dim; ++d) v[d] = is_turned[d] ? -v[d] : v[d];
    return v;
  }
};

/// The bodies themselves first, then their images: in each plane, and in two and three that meet.
template <int Dim>
std::vector<MirrorImage<Dim>> mirror_images(const Case& problem) {
  std::vector<MirrorImage<Dim>> images(1);
  for (const BoundarySpec& spec : problem.boundaries) {
    if (spec.region || spec.kind != BoundaryKind::slip || spec.contact != FaceContact::stick) continue;
    const BoundarySide side = side_of(spec.side);
    const auto d = static_cast<std::size_t>(side.axis);
    const std::size_t before = images.size();
    for (std::size_t k = 0; k < before; ++k) {
      if (images[k].is_turned[d]) continue;
      MirrorImage<Dim> image = images[k];
      image.is_turned[d] = true;
      image.plane[d] = side.is_upper ? problem.grid.upper[d] : problem.grid.lower[d];
      images.push_back(image);
    }
  }
  return images;
}

}  // namespace matpoint
