// Where to look for near particles: square cells over a box.
#pragma once

#include <algorithm>
#include <limits>

#include "core/types.hpp"

namespace matpoint {

/// A box with its sides along the axes [m].
template <int Dim>
struct Extent {
  Vec<Dim> lower{};
  Vec<Dim> upper{};
};

/// How far boxes are apart along the direction in which they are most so; negative where they overlap.
template <int Dim>
Real gap_of(const Extent<Dim>& a, const Extent<Dim>& b) {
  Real gap = -std::numeric_limits<Real>::infinity();
  for (std::size_t d = 0; d < Dim; ++d) gap = std::max({gap, b.lower[d] - a.upper[d], a.lower[d] - b.upper[d]});
  return gap;
}

/// Square cells, numbered with x fastest, over a box.
template <int Dim>
class Cells {
 public:
  Cells(const Extent<Dim>& box, Real size) : lower_(box.lower), size_(size) {
    for (std::size_t d = 0; d < Dim; ++d) counts_[d] = 1 + static_cast<Index>((box.upper[d] - box.lower[d]) / size);
  }
  std::array<Index, Dim> cell_of(const Vec<Dim>& x) const {
    std::array<Index, Dim> cell;
    for (std::size_t d = 0; d < Dim; ++d) cell[d] = std::clamp<Index>(static_cast<Index>((x[d] - lower_[d]) / size_), 0, counts_[d] - 1);
    return cell;
  }
  Index key_of(const std::array<Index, Dim>& cell) const {
    Index key = 0;
    for (std::size_t d = Dim; d-- > 0;) key = key * counts_[d] + cell[d];
    return key;
  }
  /// Calls f(first key, last key) for the rows of cells around the one with x.
  template <class F>
  void for_each_row_near(const Vec<Dim>& x, F&& f) const {
    const std::array<Index, Dim> middle = cell_of(x);
    std::array<Index, Dim> cell = middle;
    const Index first = std::max<Index>(middle[0] - 1, 0);
    const Index last = std::min(middle[0] + 1, counts_[0] - 1);
    for (int row = 0; row < (Dim == 3 ? 9 : 3); ++row) {
      bool exists = true;
      for (std::size_t d = 1; d < Dim; ++d) {
        cell[d] = middle[d] + (d == 1 ? row % 3 : row / 3) - 1;
        exists = exists && cell[d] >= 0 && cell[d] < counts_[d];
      }
      if (!exists) continue;
      cell[0] = first;
      const Index key = key_of(cell);
      f(key, key + last - first);
    }
  }

 private:
  Vec<Dim> lower_;
  Real size_;
  std::array<Index, Dim> counts_;
};

}  // namespace matpoint
