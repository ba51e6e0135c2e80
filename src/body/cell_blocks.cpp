#include "body/cell_blocks.hpp"

#include <algorithm>
#include <cmath>

namespace matpoint {

template <int Dim, class R>
CellBlocks<Dim, R>::CellBlocks(GridType& grid, const SlotLayout& layout)
    : grid_(grid), layout_(layout), bands_(static_cast<std::size_t>(grid.band_count())) {}

template <int Dim, class R>
CellBlocks<Dim, R>::~CellBlocks() = default;

template <int Dim, class R>
Index CellBlocks<Dim, R>::key_of(const Place<Dim>& first) const {
  Index key = 0;
  for (int d = Dim - 1; d >= 0; --d) key = key * grid_.nodes(d) + first[static_cast<std::size_t>(d)];
  return key;
}

template <int Dim, class R>
R* CellBlocks<Dim, R>::take_page(Band& band) {
  const std::size_t page_size = static_cast<std::size_t>(BlockType::k_page_slots * layout_.field_count * L);
  if (band.unused_pages.empty()) return static_cast<R*>(pages_.take(page_size * sizeof(R)));
  R* const page = band.unused_pages.back();
  band.unused_pages.pop_back();
  return page;
}

template <int Dim, class R>
Block<Dim, R>* CellBlocks<Dim, R>::find_or_make(Band& band, const Place<Dim>& first) {
  const Index key = key_of(first);
  BlockType*& block = band.by_key[key];
  if (block != nullptr) return block;
  if (band.unused.empty()) {
    block = &band.storage.emplace_back();
  } else {
    block = band.unused.back();
    band.unused.pop_back();
  }
  block->first = first;
  block->key = key;
  block->slot_count = 0;
  std::fill_n(block->counts, L, R{0});
  for (int row = 0; row < k_rows<Dim>; ++row) {
    Place<Dim> node = first;
    node[1] += row % 2;
    if constexpr (Dim == 3) node[2] += row / 2;
    for (int next = 0; next < 2; ++next) {
      block->tiles[row][next] = grid_.acquire(node);
      node[0] += L;
    }
  }
  const auto after = std::lower_bound(band.blocks.begin(), band.blocks.end(), key, [](const BlockType* b, Index k) { return b->key < k; });
  band.blocks.insert(after, block);
  return block;
}

template <int Dim, class R>
std::pair<Block<Dim, R>*, int> CellBlocks<Dim, R>::insert(const Place<Dim>& cell, const R* fields) {
  Band& band = bands_[static_cast<std::size_t>(grid_.band_of(cell[Dim - 1]))];
  Place<Dim> first = cell;
  const int lane = cell[0] % L;
  first[0] -= lane;
  BlockType* const block = find_or_make(band, first);
  const int k = block->count(lane);
  if (static_cast<std::size_t>(k / BlockType::k_page_slots) >= block->pages.size()) block->pages.push_back(take_page(band));
  R* const slot = block->slot(k, layout_.field_count) + lane;
  for (int f = 0; f < layout_.field_count; ++f) slot[f * L] = fields[f];
  block->counts[lane] = static_cast<R>(k + 1);
  block->slot_count = std::max(block->slot_count, k + 1);
  return {block, lane};
}

template <int Dim, class R>
void CellBlocks<Dim, R>::extract(Band& band, BlockType& block, std::vector<Mover<R>>& movers) {
  // In one order for all instruction sets, and the last slots first: what fills a hole then never is a particle that leaves, too.
  std::sort(movers.begin(), movers.end(),
            [](const Mover<R>& a, const Mover<R>& b) { return a.slot != b.slot ? a.slot > b.slot : a.lane > b.lane; });
  for (const Mover<R>& mover : movers) {
    R* const slot = block.slot(mover.slot, layout_.field_count) + mover.lane;
    typename MovingParticles<Dim, R>::Target target{block.first, false};
    target.cell[0] += mover.lane;
    const std::size_t begin = band.leaving.values.size();
    for (int f = 0; f < layout_.field_count; ++f) band.leaving.values.push_back(slot[f * L]);
    for (int s = 0; s < k_stress_size<Dim>; ++s) band.leaving.values.push_back(mover.tau[s]);
    for (int d = 0; d < Dim; ++d) {
      R& x = band.leaving.values[begin + static_cast<std::size_t>(layout_.x + d)];
      int& cell = target.cell[static_cast<std::size_t>(d)];
      const R shift = std::floor(x);
      if (!(std::abs(shift) < R(1e9))) {
        target.is_outside = true;  // not finite, or as good as that
        continue;
      }
      cell += static_cast<int>(shift);
      x -= shift;
      if (x >= 1) x = std::nextafter(R(1), R(0));  // rounding of a tiny negative x
      const int cells = grid_.cells(d);
      if (grid_.is_periodic(d)) {
        cell = (cell % cells + cells) % cells;
      } else if (cell == cells && x == 0) {
        cell = cells - 1;  // exactly on the far side: inside
        x = 1;
      }
      target.is_outside = target.is_outside || cell < 0 || cell >= cells;
    }
    band.leaving.targets.push_back(target);
    const int last = block.count(mover.lane) - 1;
    if (last != mover.slot) {
      const R* const from = block.slot(last, layout_.field_count) + mover.lane;
      for (int f = 0; f < layout_.field_count; ++f) slot[f * L] = from[f * L];
    }
    block.counts[mover.lane] = static_cast<R>(last);
  }
  block.slot_count = static_cast<int>(*std::max_element(block.counts, block.counts + L));
}

template <int Dim, class R>
void CellBlocks<Dim, R>::prune(Band& band) {
  const auto is_empty = [&](BlockType* block) {
    const auto needed = static_cast<std::size_t>((block->slot_count + BlockType::k_page_slots - 1) / BlockType::k_page_slots);
    while (block->pages.size() > needed) {
      band.unused_pages.push_back(block->pages.back());
      block->pages.pop_back();
    }
    if (block->slot_count > 0) return false;
    for (auto& row : block->tiles) {
      for (Tile<Dim, R>*& tile : row) grid_.release(tile);
    }
    band.by_key.erase(block->key);
    band.unused.push_back(block);
    return true;
  };
  band.blocks.erase(std::remove_if(band.blocks.begin(), band.blocks.end(), is_empty), band.blocks.end());
}

template <int Dim, class R>
Vec3 CellBlocks<Dim, R>::position(const BlockType& block, const R* fields, int lane) const {
  Vec3 x{};
  for (int d = 0; d < Dim; ++d) {
    const auto s = static_cast<std::size_t>(d);
    const int cell = block.first[s] + (d == 0 ? lane : 0);
    x[s] = grid_.lower(d) + (cell + static_cast<Real>(fields[(layout_.x + d) * L])) * grid_.cell_size(d);
  }
  return x;
}

template <int Dim, class R>
Index CellBlocks<Dim, R>::memory() const {
  auto bytes = static_cast<std::size_t>(pages_.memory());
  for (const Band& band : bands_) {
    bytes += band.unused_pages.capacity() * sizeof(R*);
    bytes += band.storage.size() * (sizeof(BlockType) + 8 * sizeof(void*)) + band.leaving.values.capacity() * sizeof(R);
  }
  return static_cast<Index>(bytes);
}

template class CellBlocks<2, double>;
template class CellBlocks<3, double>;
template class CellBlocks<2, float>;
template class CellBlocks<3, float>;

}  // namespace matpoint
