// The particles of one body in memory: blocks of cells, as kernel/kernel.hpp describes. Private to body/: everybody else sees fields in
// the order of ids.
//
// A cell may hold any number of particles: a full one grows its block by a slot. Particles are never sorted: one that leaves its cell is
// taken out, its place is filled by the cell's last, and it is put into its new cell after the sweep.
#pragma once

#include <algorithm>
#include <bit>
#include <memory>

#include "core/arena.hpp"
#include "core/state.hpp"
#include "grid/grid.hpp"

namespace matpoint {

template <int Dim, class R>
struct Block {
  static constexpr int L = k_lanes<R>;
  /// Slots whose addresses lie in the block itself.
  static constexpr int k_near_slots = Dim == 2 ? 12 : 16;

  alignas(64) R counts[L] = {};  ///< Particles in each cell.
  int slot_count = 0;            ///< The largest of the counts.
  int held_count = 0;            ///< Slots that the block has memory for.
  R* near_slots[k_near_slots] = {};
  Tile<Dim, R>* tiles[k_rows_max<Dim>][2] = {};  ///< Of as many rows as the grid's shape functions have; the others are null.
  Index key = 0;
  Place<Dim> first{};  ///< The cell of lane 0.
  std::vector<R*> far_slots;

  R* slot(int k) const { return k < k_near_slots ? near_slots[k] : far_slots[static_cast<std::size_t>(k - k_near_slots)]; }
  int count(int lane) const { return static_cast<int>(counts[lane]); }

  void push_slot(R* slot) {
    if (held_count < k_near_slots)
      near_slots[held_count] = slot;
    else
      far_slots.push_back(slot);
    ++held_count;
  }
  R* pop_slot() {
    R* const last = slot(--held_count);
    if (held_count >= k_near_slots) far_slots.pop_back();
    return last;
  }
};

/// The blocks of one row of cells, from the first to the last that exists: index 0 is block `begin` of the row.
template <class BlockType>
struct BlockRow {
  int begin = 0;
  std::vector<BlockType*> blocks;

  BlockType* find(int block) const {
    const int i = block - begin;
    return i < 0 || i >= static_cast<int>(blocks.size()) ? nullptr : blocks[static_cast<std::size_t>(i)];
  }
  BlockType*& at(int block) {
    if (blocks.empty()) begin = block;
    if (block < begin) {
      blocks.insert(blocks.begin(), static_cast<std::size_t>(begin - block), nullptr);
      begin = block;
    }
    if (block - begin >= static_cast<int>(blocks.size())) blocks.resize(static_cast<std::size_t>(block - begin + 1), nullptr);
    return blocks[static_cast<std::size_t>(block - begin)];
  }
};

/// Particles on their way to another cell, or out of the grid: all fields of the slot, then the stress.
template <int Dim, class R>
struct MovingParticles {
  struct Target {
    Place<Dim> cell;
    bool is_outside;
  };
  std::vector<R> values;
  std::vector<Target> targets;

  std::size_t count() const { return targets.size(); }
  const R* particle(std::size_t i, int stride) const { return values.data() + i * static_cast<std::size_t>(stride); }
  void push(const R* particle, int stride, const Target& target) {
    values.insert(values.end(), particle, particle + stride);
    targets.push_back(target);
  }
  /// Keeps the particles for which `is_kept(i)`, in their order.
  template <class F>
  void keep_if(std::size_t begin, int stride, F&& is_kept) {
    std::size_t kept = begin;
    for (std::size_t i = begin; i < count(); ++i) {
      if (!is_kept(i)) continue;
      if (kept != i) {
        std::copy_n(particle(i, stride), stride, values.data() + kept * static_cast<std::size_t>(stride));
        targets[kept] = targets[i];
      }
      ++kept;
    }
    values.resize(kept * static_cast<std::size_t>(stride));
    targets.resize(kept);
  }
  void clear() {
    values.clear();
    targets.clear();
  }
};

/// Ids travel in a field, as bits.
template <class R>
inline R id_to_bits(std::uint32_t id) {
  if constexpr (sizeof(R) == 8)
    return std::bit_cast<R>(static_cast<std::uint64_t>(id));
  else
    return std::bit_cast<R>(id);
}
template <class R>
inline std::uint32_t id_from_bits(R bits) {
  if constexpr (sizeof(R) == 8)
    return static_cast<std::uint32_t>(std::bit_cast<std::uint64_t>(bits));
  else
    return std::bit_cast<std::uint32_t>(bits);
}

template <int Dim, class R>
class CellBlocks {
 public:
  using BlockType = Block<Dim, R>;
  using GridType = Grid<Dim, R>;
  static constexpr int L = k_lanes<R>;

  /// The blocks of one band of the grid.
  struct Band {
    std::vector<BlockType*> blocks;  ///< In the order of the cells, as of the last call of `list_blocks`.
    MovingParticles<Dim, R> leaving;
    std::vector<BlockRow<BlockType>> rows;
    bool is_list_old = false;
    std::vector<BlockType*> unused;
    std::vector<R*> unused_slots;
  };

  CellBlocks(GridType& grid, const SlotLayout<Dim>& layout);
  ~CellBlocks();

  const SlotLayout<Dim>& layout() const { return layout_; }
  /// Numbers per moving particle.
  int stride() const { return layout_.field_count + k_stress_size<Dim>; }
  Index count() const { return count_; }

  std::vector<Band>& bands() { return bands_; }
  const std::vector<Band>& bands() const { return bands_; }

  /// Puts a particle with the given fields (layout().field_count numbers) into a cell. Returns its block and lane. Threads: as
  /// Grid::acquire.
  std::pair<BlockType*, int> insert(const Place<Dim>& cell, const R* fields);
  /// The same for a block that is there already.
  void insert(Band& band, BlockType& block, int lane, const R* fields);
  /// The block with a cell, or null.
  BlockType* find(const Place<Dim>& cell) const;
  /// Brings `band.blocks` up to date.
  void list_blocks(Band& band);
  int band_of(const Place<Dim>& cell) const { return grid_.band_of(cell[Dim - 1]); }
  /// Takes the particles out of a block that `movers` names, into `band.leaving`.
  void extract(Band& band, BlockType& block, std::vector<Mover<R>>& movers);
  /// Gives back blocks without particles, and slots that are not needed. All even bands, then all odd ones, may run side by side.
  void prune(Band& band);
  /// Leaves all cells empty; the number of particles stays as it is, and so do the blocks, for they are to come back. Then prune.
  void remove_all();
  /// Without particles and blocks.
  void clear();
  /// Loading: into blocks without any.
  void declare_state(State& state);
  /// Adds to the number of particles; insert and extract do not count, because they run side by side.
  void add_to_count(Index change) { count_ += change; }

  /// Calls f(fields, position) for all particles of a band: field f of the particle is fields[f * k_lanes], position in m.
  template <class F>
  void for_each(const Band& band, F&& f) const {
    for_each_block(band, [&](const BlockType& block) {
      for (int k = 0; k < block.slot_count; ++k) {
        const R* const slot = block.slot(k);
        for (int lane = 0; lane < L; ++lane) {
          if (k < block.count(lane)) f(slot + lane, position(block, slot + lane, lane));
        }
      }
    });
  }
  template <class F>
  void for_each_block(const Band& band, F&& f) const {
    for (const BlockRow<BlockType>& row : band.rows) {
      for (const BlockType* block : row.blocks) {
        if (block != nullptr) f(*block);
      }
    }
  }

  /// Position [m] of a particle.
  Vec3 position(const BlockType& block, const R* fields, int lane) const;
  Index memory() const;
  /// Lanes of all slots that a sweep works.
  Index lane_count() const;

 private:
  BlockType* find_or_make(Band& band, const Place<Dim>& first);
  R* take_slot(Band& band);
  Index key_of(const Place<Dim>& first) const;
  std::size_t row_of(const Place<Dim>& cell) const;

  GridType& grid_;
  SlotLayout<Dim> layout_;
  Arena slots_;
  Arena blocks_;
  std::vector<Band> bands_;
  Index count_ = 0;
};

}  // namespace matpoint
