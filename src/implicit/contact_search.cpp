// Which particles of bodies in contact are near each other (body_contact.hpp).
#include <algorithm>
#include <limits>

#include "core/parallel.hpp"
#include "geometry/point_cells.hpp"
#include "implicit/body_contact.hpp"

namespace matpoint {
namespace {

// In ranges of W: so much farther than it particles are looked for, and half of it they may move until they are looked for again.
constexpr Real k_margin = 0.5;

template <int Dim>
Real distance_squared(const Vec<Dim>& a, const Vec<Dim>& b) {
  Real sum = 0;
  for (std::size_t d = 0; d < Dim; ++d) sum += (a[d] - b[d]) * (a[d] - b[d]);
  return sum;
}

}  // namespace

template <int Dim>
void BodyContact<Dim>::start() {
  if (!has_pairs()) return;
  const std::size_t n = space_.particles().size();
  entry_.resize(n);
  x0_.resize(n);
  places_.assign(space_.sources().size(), {});
  for (std::size_t c = 0; c < space_.cells().size(); ++c) {
    for (Index k = space_.cell_begin(c); k < space_.cell_end(c); ++k) {
      const auto place = static_cast<std::size_t>(k);
      entry_[place] = c;
      x0_[place] = space_.sources()[space_.source_of(c)].points->position[static_cast<std::size_t>(space_.particles()[place])];
      places_[space_.source_of(c)].push_back(k);
    }
  }
  x_ = x0_;
  search();
  if (!is_first_) return;
  is_first_ = false;
  lay();
  measure_energy();
}

template <int Dim>
void BodyContact<Dim>::move(const std::vector<Real>& u) {
  if (!has_pairs()) return;
  const int functions = space_.functions();
  parallel_for(static_cast<Index>(space_.cells().size()), static_cast<Index>(x_.size()), [&](Index cell) {
    const auto c = static_cast<std::size_t>(cell);
    const int* const nodes = space_.cell_nodes(c);
    for (Index k = space_.cell_begin(c); k < space_.cell_end(c); ++k) {
      Vec<Dim> x = x0_[static_cast<std::size_t>(k)];
      for (int node = 0; node < functions; ++node) {
        for (std::size_t d = 0; d < Dim; ++d) x[d] += space_.N(k)[node] * u[static_cast<std::size_t>(nodes[node]) * Dim + d];
      }
      x_[static_cast<std::size_t>(k)] = x;
    }
  });
  Real range = std::numeric_limits<Real>::infinity();
  for (const Pair& pair : pairs_) range = std::min(range, pair.kernel.range());
  const Real free_way = 0.5 * k_margin * range;
  bool is_far = false;
  for (std::size_t k = 0; k < x_.size(); ++k) is_far = is_far || distance_squared<Dim>(x_[k], searched_at_[k]) > free_way * free_way;
  if (is_far) search();
}

/// Candidates are near at the start of the step or now.
template <int Dim>
void BodyContact<Dim>::search() {
  std::vector<ContactPatch<Dim>> old = std::move(patches_);
  patches_.clear();
  searched_at_ = x_;
  for (std::size_t p = 0; p < pairs_.size(); ++p) {
    std::vector<Found> found;
    search(pairs_[p], x0_, found);
    if (x_ != x0_) search(pairs_[p], x_, found);
    for (std::size_t side : {0, 1}) {
      make_patches(found, p, side);
      for (Found& one : found) std::swap(one[0], one[1]);
    }
  }
  const auto is_same = [](const ContactPatch<Dim>& a, const ContactPatch<Dim>& b) { return a.nodes == b.nodes; };
  if (!std::equal(old.begin(), old.end(), patches_.begin(), patches_.end(), is_same)) {
    ++pattern_;
    return;
  }
  for (std::size_t k = 0; k < old.size(); ++k) patches_[k].row_offset = std::move(old[k].row_offset);
}

template <int Dim>
void BodyContact<Dim>::search(const Pair& pair, const std::vector<Vec<Dim>>& positions, std::vector<Found>& found) const {
  const Real reach = (1 + k_margin) * pair.kernel.range();
  std::array<Extent<Dim>, 2> boxes;
  for (std::size_t s : {0, 1}) {
    boxes[s].lower.fill(std::numeric_limits<Real>::infinity());
    boxes[s].upper.fill(-std::numeric_limits<Real>::infinity());
    for (const Index k : places_[pair.sources[s]]) {
      for (std::size_t d = 0; d < Dim; ++d) {
        boxes[s].lower[d] = std::min(boxes[s].lower[d], positions[static_cast<std::size_t>(k)][d]);
        boxes[s].upper[d] = std::max(boxes[s].upper[d], positions[static_cast<std::size_t>(k)][d]);
      }
    }
  }
  if (gap_of<Dim>(boxes[0], boxes[1]) >= reach) return;
  Extent<Dim> box;
  for (std::size_t d = 0; d < Dim; ++d) {
    box.lower[d] = std::max(boxes[0].lower[d], boxes[1].lower[d]) - reach;
    box.upper[d] = std::min(boxes[0].upper[d], boxes[1].upper[d]) + reach;
  }
  const Cells<Dim> cells(box, reach);
  const auto is_in = [&](const Vec<Dim>& x) {
    for (std::size_t d = 0; d < Dim; ++d) {
      if (x[d] < box.lower[d] || x[d] > box.upper[d]) return false;
    }
    return true;
  };
  std::vector<std::pair<Index, Index>> others;  // cell and place
  for (const Index k : places_[pair.sources[1]]) {
    const Vec<Dim>& x = positions[static_cast<std::size_t>(k)];
    if (is_in(x)) others.emplace_back(cells.key_of(cells.cell_of(x)), k);
  }
  std::sort(others.begin(), others.end());
  for (const Index p : places_[pair.sources[0]]) {
    const Vec<Dim>& x = positions[static_cast<std::size_t>(p)];
    if (!is_in(x)) continue;
    cells.for_each_row_near(x, [&](Index first, Index last) {
      auto other = std::lower_bound(others.begin(), others.end(), std::pair<Index, Index>{first, -1});
      for (; other != others.end() && other->first <= last; ++other) {
        // An image is never nearer than what it is the image of.
        for (std::size_t image = 0; image < images_.size(); ++image) {
          const Vec<Dim> y = images_[image].place(positions[static_cast<std::size_t>(other->second)]);
          if (distance_squared<Dim>(x, y) < reach * reach)
            found.push_back({p, other->second, static_cast<Index>(image)});
          else if (image == 0)
            break;
        }
      }
    });
  }
}

template <int Dim>
void BodyContact<Dim>::make_patches(std::vector<Found> found, std::size_t pair, std::size_t side) {
  const auto entry_of = [&](Index k) { return entry_[static_cast<std::size_t>(k)]; };
  std::sort(found.begin(), found.end());  // places go cell by cell
  found.erase(std::unique(found.begin(), found.end()), found.end());
  for (std::size_t first = 0, last = 0; first < found.size(); first = last) {
    while (last < found.size() && entry_of(found[last][0]) == entry_of(found[first][0])) ++last;
    ContactPatch<Dim> patch;
    patch.pair = pair;
    patch.side = side;
    for (std::size_t k = first; k < last; ++k) patch.entries.push_back(entry_of(found[k][1]));
    std::sort(patch.entries.begin(), patch.entries.end());
    patch.entries.erase(std::unique(patch.entries.begin(), patch.entries.end()), patch.entries.end());
    patch.entries.insert(patch.entries.begin(), entry_of(found[first][0]));
    for (std::size_t k = first; k < last; ++k) {
      if (patch.points.empty() || patch.points.back() != found[k][0]) {
        patch.points.push_back(found[k][0]);
        patch.begin.push_back(patch.candidates.size());
      }
      const auto entry = std::lower_bound(patch.entries.begin() + 1, patch.entries.end(), entry_of(found[k][1])) - patch.entries.begin();
      patch.candidates.push_back(
          {static_cast<std::uint32_t>(found[k][1]), static_cast<std::uint32_t>(entry), static_cast<std::uint32_t>(found[k][2])});
    }
    patch.begin.push_back(patch.candidates.size());
    for (const std::size_t c : patch.entries)
      patch.nodes.insert(patch.nodes.end(), space_.cell_nodes(c), space_.cell_nodes(c) + space_.functions());
    std::sort(patch.nodes.begin(), patch.nodes.end());
    patch.nodes.erase(std::unique(patch.nodes.begin(), patch.nodes.end()), patch.nodes.end());
    for (const std::size_t c : patch.entries) {
      for (int i = 0; i < space_.functions(); ++i)
        patch.local.push_back(
            static_cast<int>(std::lower_bound(patch.nodes.begin(), patch.nodes.end(), space_.cell_nodes(c)[i]) - patch.nodes.begin()));
    }
    patches_.push_back(std::move(patch));
  }
}

// Used by body_contact.cpp, assembly.cpp and implicit_solver.cpp.
template void BodyContact<2>::start();
template void BodyContact<3>::start();
template void BodyContact<2>::move(const std::vector<Real>&);
template void BodyContact<3>::move(const std::vector<Real>&);

}  // namespace matpoint
