#include "body/cell_blocks.hpp"

#include <algorithm>
#include <cmath>

namespace matpoint {
namespace {

/// A place in a cell, in cell sides, kept off its sides (k_off_line).
template <class R>
R off_line(R x) {
  return std::clamp(x, k_off_line<R>, 1 - k_off_line<R>);
}

}  // namespace

template <int Dim, class R>
CellBlocks<Dim, R>::CellBlocks(GridType& grid, const SlotLayout<Dim>& layout)
    : grid_(grid), layout_(layout), bands_(static_cast<std::size_t>(grid.band_count())) {}

template <int Dim, class R>
CellBlocks<Dim, R>::~CellBlocks() {
  for (Band& band : bands_) {
    for (BlockRow<BlockType>& row : band.rows) {
      for (BlockType* block : row.blocks) {
        if (block != nullptr) block->~BlockType();
      }
    }
    for (BlockType* block : band.unused) block->~BlockType();
  }
}

/// Of a cell, within its band.
template <int Dim, class R>
std::size_t CellBlocks<Dim, R>::row_of(const Place<Dim>& cell) const {
  const auto row = static_cast<std::size_t>(cell[Dim - 1] % grid_.band_rows());
  if constexpr (Dim == 3)
    return row * static_cast<std::size_t>(grid_.cells(1)) + static_cast<std::size_t>(cell[1]);
  else
    return row;
}

template <int Dim, class R>
Index CellBlocks<Dim, R>::key_of(const Place<Dim>& first) const {
  Index key = 0;
  for (int d = Dim - 1; d >= 0; --d) key = key * grid_.nodes(d) + first[static_cast<std::size_t>(d)];
  return key;
}

template <int Dim, class R>
R* CellBlocks<Dim, R>::take_slot(Band& band) {
  if (!band.unused_slots.empty()) {
    R* const slot = band.unused_slots.back();
    band.unused_slots.pop_back();
    return slot;
  }
  R* const slot = static_cast<R*>(slots_.take(static_cast<std::size_t>(layout_.field_count * L) * sizeof(R)));
  // The kernels work empty lanes, too: an undeformed particle at rest is harmless there.
  for (int d = 0; d < Dim; ++d) std::fill_n(slot + (layout_.F + d * Dim + d) * L, L, R{1});
  if (layout_.hoop >= 0) std::fill_n(slot + layout_.hoop * L, L, R{1});
  return slot;
}

template <int Dim, class R>
Block<Dim, R>* CellBlocks<Dim, R>::find(const Place<Dim>& cell) const {
  const Band& band = bands_[static_cast<std::size_t>(band_of(cell))];
  return band.rows.empty() ? nullptr : band.rows[row_of(cell)].find(cell[0] / L);
}

template <int Dim, class R>
Block<Dim, R>* CellBlocks<Dim, R>::find_or_make(Band& band, const Place<Dim>& first) {
  // Bands without particles have no rows: memory follows the material.
  if (band.rows.empty()) band.rows.resize(static_cast<std::size_t>(grid_.band_rows() * (Dim == 3 ? grid_.cells(1) : 1)));
  BlockType*& block = band.rows[row_of(first)].at(first[0] / L);
  if (block != nullptr) return block;
  if (band.unused.empty()) {
    block = new (blocks_.take(sizeof(BlockType))) BlockType;
  } else {
    block = band.unused.back();
    band.unused.pop_back();
  }
  block->first = first;
  block->key = key_of(first);
  block->slot_count = 0;
  std::fill_n(block->counts, L, R{0});
  const int rows_across = grid_.span() + 1;
  for (int row = 0; row < grid_.row_count(); ++row) {
    Place<Dim> node = first;
    node[1] += row % rows_across;
    if constexpr (Dim == 3) node[2] += row / rows_across;
    for (int next = 0; next < 2; ++next) {
      block->tiles[row][next] = grid_.acquire(node);
      node[0] += L;
    }
  }
  band.is_list_old = true;
  return block;
}

template <int Dim, class R>
void CellBlocks<Dim, R>::list_blocks(Band& band) {
  if (!band.is_list_old) return;
  band.is_list_old = false;
  band.blocks.clear();
  for (const BlockRow<BlockType>& row : band.rows) {
    std::copy_if(row.blocks.begin(), row.blocks.end(), std::back_inserter(band.blocks), [](BlockType* block) { return block != nullptr; });
  }
}

template <int Dim, class R>
std::pair<Block<Dim, R>*, int> CellBlocks<Dim, R>::insert(const Place<Dim>& cell, const R* fields) {
  Band& band = bands_[static_cast<std::size_t>(band_of(cell))];
  Place<Dim> first = cell;
  const int lane = cell[0] % L;
  first[0] -= lane;
  BlockType* const block = find_or_make(band, first);
  insert(band, *block, lane, fields);
  return {block, lane};
}

template <int Dim, class R>
void CellBlocks<Dim, R>::insert(Band& band, BlockType& block, int lane, const R* fields) {
  const int k = block.count(lane);
  if (k >= block.held_count) block.push_slot(take_slot(band));
  R* const slot = block.slot(k) + lane;
  for (int f = 0; f < layout_.field_count; ++f) slot[f * L] = fields[f];
  for (int d = 0; d < Dim; ++d) slot[(layout_.x + d) * L] = off_line(fields[layout_.x + d]);
  block.counts[lane] = static_cast<R>(k + 1);
  block.slot_count = std::max(block.slot_count, k + 1);
}

template <int Dim, class R>
void CellBlocks<Dim, R>::extract(Band& band, BlockType& block, std::vector<Mover<R>>& movers) {
  // In one order for all instruction sets, and the last slots first: what fills a hole then never is a particle that leaves, too.
  std::sort(movers.begin(), movers.end(),
            [](const Mover<R>& a, const Mover<R>& b) { return a.slot != b.slot ? a.slot > b.slot : a.lane > b.lane; });
  for (const Mover<R>& mover : movers) {
    R* const slot = block.slot(mover.slot) + mover.lane;
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
      const int cells = grid_.cells(d);
      if (grid_.is_periodic(d)) {
        const int here = (cell % cells + cells) % cells;
        if (layout_.start >= 0) {
          R& start = band.leaving.values[begin + static_cast<std::size_t>(layout_.start + d)];
          start += static_cast<R>((here - cell) * grid_.cell_size(d));  // its displacement goes on
        }
        cell = here;
      } else if (cell == cells && x == 0) {
        cell = cells - 1;  // exactly on the far side: inside
        x = 1;
      }
      x = off_line(x);
      target.is_outside = target.is_outside || cell < 0 || cell >= cells;
    }
    band.leaving.targets.push_back(target);
    const int last = block.count(mover.lane) - 1;
    if (last != mover.slot) {
      const R* const from = block.slot(last) + mover.lane;
      for (int f = 0; f < layout_.field_count; ++f) slot[f * L] = from[f * L];
    }
    block.counts[mover.lane] = static_cast<R>(last);
  }
  block.slot_count = static_cast<int>(*std::max_element(block.counts, block.counts + L));
}

template <int Dim, class R>
void CellBlocks<Dim, R>::prune(Band& band) {
  for (BlockRow<BlockType>& row : band.rows) {
    for (BlockType*& block : row.blocks) {
      if (block == nullptr) continue;
      while (block->held_count > block->slot_count) band.unused_slots.push_back(block->pop_slot());
      if (block->slot_count > 0) continue;
      for (int r = 0; r < grid_.row_count(); ++r) {
        for (Tile<Dim, R>* tile : block->tiles[r]) grid_.release(tile);
      }
      band.unused.push_back(block);
      band.is_list_old = true;
      block = nullptr;
    }
    const auto exists = [](const BlockType* block) { return block != nullptr; };
    row.blocks.erase(std::find_if(row.blocks.rbegin(), row.blocks.rend(), exists).base(), row.blocks.end());
    const auto first = std::find_if(row.blocks.begin(), row.blocks.end(), exists);
    row.begin += static_cast<int>(first - row.blocks.begin());
    row.blocks.erase(row.blocks.begin(), first);
  }
}

template <int Dim, class R>
Vec3 CellBlocks<Dim, R>::position(const BlockType& block, const R* fields, int lane) const {
  Vec3 x{};
  for (int d = 0; d < Dim; ++d) {
    const auto s = static_cast<std::size_t>(d);
    const int cell = block.first[s] + (d == 0 ? lane : 0);
    // On the far side the sum may round to more.
    x[s] = std::min(grid_.lower(d) + (cell + static_cast<Real>(fields[(layout_.x + d) * L])) * grid_.cell_size(d), grid_.upper(d));
  }
  return x;
}

template <int Dim, class R>
Index CellBlocks<Dim, R>::memory() const {
  auto bytes = static_cast<std::size_t>(slots_.memory() + blocks_.memory());
  for (const Band& band : bands_) {
    bytes += (band.blocks.capacity() + band.unused_slots.capacity() + band.unused.capacity()) * sizeof(void*);
    bytes +=
        band.leaving.values.capacity() * sizeof(R) + band.leaving.targets.capacity() * sizeof(typename MovingParticles<Dim, R>::Target);
    for (const BlockRow<BlockType>& row : band.rows) bytes += sizeof row + row.blocks.capacity() * sizeof(BlockType*);
  }
  return static_cast<Index>(bytes);
}

template <int Dim, class R>
Index CellBlocks<Dim, R>::lane_count() const {
  Index slots = 0;
  for (const Band& band : bands_) {
    for (const BlockRow<BlockType>& row : band.rows) {
      for (const BlockType* block : row.blocks) slots += block == nullptr ? 0 : block->slot_count;
    }
  }
  return slots * L;
}

template <int Dim, class R>
void CellBlocks<Dim, R>::remove_all() {
  for (Band& band : bands_) {
    for (const BlockRow<BlockType>& row : band.rows) {
      for (BlockType* block : row.blocks) {
        if (block == nullptr) continue;
        std::fill_n(block->counts, L, R{0});
        block->slot_count = 0;
      }
    }
  }
}

template class CellBlocks<2, double>;
template class CellBlocks<3, double>;
template class CellBlocks<2, float>;
template class CellBlocks<3, float>;

}  // namespace matpoint
