#include "geometry/seed_surface.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.hpp"

namespace matpoint {
namespace {

/// Places and distances are known to this share of a spacing.
constexpr Real k_tolerance = 1e-4;

/// Of points that lie in the middle of its boxes; nothing where they do not.
std::optional<BoxLattice> lattice_of(const std::vector<Vec3>& positions, int dim) {
  BoxLattice lattice;
  for (std::size_t d = 0; d < static_cast<std::size_t>(dim); ++d) {
    std::vector<Real> places;
    for (const Vec3& x : positions) places.push_back(x[d]);
    std::sort(places.begin(), places.end());
    const Real rounding = 1e-9 * std::max(std::abs(places.front()), std::abs(places.back()));
    Real least = std::numeric_limits<Real>::infinity();
    for (std::size_t k = 1; k < places.size(); ++k) {
      const Real distance = places[k] - places[k - 1];
      if (distance > rounding) least = std::min(least, distance);
    }
    if (!std::isfinite(least)) return std::nullopt;
    // Many steps of the least distance would add up what rounding has done to it.
    const Real steps = std::round((places.back() - places.front()) / least);
    lattice.spacing[d] = (places.back() - places.front()) / steps;
    lattice.corner[d] = places.front() - 0.5 * lattice.spacing[d];
    for (const Real place : places) {
      const Real box = (place - places.front()) / lattice.spacing[d];
      if (std::abs(box - std::round(box)) > k_tolerance) return std::nullopt;
    }
  }
  return lattice;
}

/// Boxes of a lattice by their numbers, ascending, with who is in each.
class Boxes {
 public:
  Boxes(const Seeds& seeds, const BoxLattice& lattice, int dim) {
    std::array<Index, 3> highest;
    lowest_.fill(std::numeric_limits<Index>::max());
    highest.fill(std::numeric_limits<Index>::min());
    for (const Vec3& x : seeds.position) {
      std::array<Index, 3> box{};
      for (std::size_t d = 0; d < static_cast<std::size_t>(dim); ++d)
        box[d] = static_cast<Index>(std::floor((x[d] - lattice.corner[d]) / lattice.spacing[d]));
      for (std::size_t d = 0; d < 3; ++d) {
        lowest_[d] = std::min(lowest_[d], box[d]);
        highest[d] = std::max(highest[d], box[d]);
      }
      boxes_.push_back(box);
    }
    for (std::size_t d = 0; d < 3; ++d) count_[d] = highest[d] - lowest_[d] + 3;  // a layer of empty ones around
    for (const std::array<Index, 3>& box : boxes_) numbers_.push_back(number(box));
    std::sort(numbers_.begin(), numbers_.end());
  }
  bool has_one_each() const { return std::adjacent_find(numbers_.begin(), numbers_.end()) == numbers_.end(); }
  /// Layers of boxes along an axis.
  Index layers(std::size_t d) const { return count_[d] - 2; }
  Index lowest(std::size_t d) const { return lowest_[d]; }
  const std::array<Index, 3>& of(std::size_t seed) const { return boxes_[seed]; }
  bool is_filled(const std::array<Index, 3>& box) const { return std::binary_search(numbers_.begin(), numbers_.end(), number(box)); }

 private:
  Index number(const std::array<Index, 3>& box) const {
    Index all = 0;
    for (std::size_t d = 0; d < 3; ++d) all = all * count_[d] + box[d] - lowest_[d] + 1;
    return all;
  }
  std::vector<std::array<Index, 3>> boxes_;
  std::vector<Index> numbers_;
  std::array<Index, 3> lowest_;
  std::array<Index, 3> count_;
};

bool is_box(const Region* region, int dim) {
  if (region == nullptr || !region->measure(dim)) return false;
  const Vec3 lower = region->lower(), upper = region->upper();
  Real product = 1;
  for (std::size_t d = 0; d < static_cast<std::size_t>(dim); ++d) product *= upper[d] - lower[d];
  return std::abs(*region->measure(dim) - product) <= 1e-12 * product;
}

}  // namespace

std::vector<SeedFace> surface_of(const Seeds& seeds, const Region* region, int dim) {
  const std::optional<BoxLattice> lattice = seeds.lattice ? seeds.lattice : lattice_of(seeds.position, dim);
  const auto fail = [] {
    throw InputError(
        "its particles do not lie on a lattice, one in each box, so their surface is not known; use layout type = \"per_cell\" or "
        "\"lattice\", or points with equal distances along each axis, or kind = \"force\" without a side");
  };
  if (!lattice) fail();
  if (!seeds.lattice) {
    // Points far apart, or out of step, lie on a fine lattice, too.
    Real box = 1;
    for (std::size_t d = 0; d < static_cast<std::size_t>(dim); ++d) box *= lattice->spacing[d];
    const Real volume = *std::max_element(seeds.volume.begin(), seeds.volume.end());
    if (std::abs(box - volume) > 0.1 * volume) fail();
  }
  const Boxes boxes(seeds, *lattice, dim);
  if (!boxes.has_one_each()) fail();
  // The ends of the layers along each axis.
  const auto axes = static_cast<std::size_t>(dim);
  Vec3 lower{}, width{1, 1, 1};
  const bool has_own_faces = is_box(region, dim);
  for (std::size_t d = 0; d < axes; ++d) {
    lower[d] = has_own_faces ? region->lower()[d] : lattice->corner[d] + static_cast<Real>(boxes.lowest(d)) * lattice->spacing[d];
    width[d] = has_own_faces ? (region->upper()[d] - region->lower()[d]) / static_cast<Real>(boxes.layers(d)) : lattice->spacing[d];
  }
  std::vector<SeedFace> faces;
  for (std::size_t p = 0; p < seeds.position.size(); ++p) {
    for (std::size_t axis = 0; axis < axes; ++axis) {
      for (const bool is_upper : {false, true}) {
        std::array<Index, 3> box = boxes.of(p);
        box[axis] += is_upper ? 1 : -1;
        if (boxes.is_filled(box)) continue;
        SeedFace face{p, static_cast<int>(axis), is_upper, {}, 1, 0};
        for (std::size_t d = 0; d < axes; ++d) {
          const auto layer = static_cast<Real>(boxes.of(p)[d] - boxes.lowest(d));
          face.center[d] = lower[d] + (layer + (d != axis ? 0.5 : is_upper ? 1.0 : 0.0)) * width[d];
          if (d != axis) face.area *= width[d];
        }
        const Real side = lattice->corner[axis] + static_cast<Real>(boxes.of(p)[axis] + (is_upper ? 1 : 0)) * lattice->spacing[axis];
        face.depth = std::abs(side - seeds.position[p][axis]) * seeds.volume[p] / (face.area * lattice->spacing[axis]);
        faces.push_back(face);
      }
    }
  }
  return faces;
}

}  // namespace matpoint
