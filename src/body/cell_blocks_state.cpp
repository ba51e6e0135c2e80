// The state of the particles of a body, as they lie in memory: which blocks of cells exist, also empty ones, and the order of the particles
// in each cell decide the order of all sums, and so their last bits.
#include <tuple>

#include "body/cell_blocks.hpp"
#include "core/parallel.hpp"
#include "core/state.hpp"

namespace matpoint {
namespace {

/// Runs of fields that have a name in files; the id is apart, it is no number.
template <int Dim>
std::vector<std::tuple<std::string, int, int>> named_fields(const SlotLayout<Dim>& at) {
  return {{"place_in_cell", at.x, Dim},
          {"velocity", at.v, Dim},
          {"deformation_gradient", at.F, Dim * Dim},
          {"kirchhoff_stress", at.tau, k_stress_size<Dim>},
          {"affine_velocity", at.C, Dim * Dim},
          {"displacement", at.u, Dim},
          {"body_force", at.b, Dim},
          {"hoop_stretch", at.hoop, 1},
          {"start_position", at.start, Dim},
          {"reference_volume", at.volume, 1},
          {"history", at.history, at.history_count}};
}

}  // namespace

template <int Dim, class R>
void CellBlocks<Dim, R>::clear() {
  remove_all();
  for (Band& band : bands_) prune(band);
  count_ = 0;
}

template <int Dim, class R>
void CellBlocks<Dim, R>::declare_state(State& state) {
  std::vector<Place<Dim>> firsts;
  std::vector<std::array<int, L>> counts;
  if (!state.is_loading()) {
    for (const Band& band : bands_) {
      for_each_block(band, [&](const BlockType& block) {
        firsts.push_back(block.first);
        std::array<int, L>& lanes = counts.emplace_back();
        for (int lane = 0; lane < L; ++lane) lanes[static_cast<std::size_t>(lane)] = block.count(lane);
      });
    }
  }
  state.add("block_first_cell", firsts);
  state.add("block_particle_counts", counts);
  state.add("count", count_);
  if (state.is_loading()) {
    if (firsts.size() != counts.size()) state.fail("block_particle_counts", "has not one row for each block");
    for (std::size_t b = 0; b < firsts.size(); ++b) {
      for (std::size_t d = 0; d < Dim; ++d) {
        const int cell = firsts[b][d];
        if (cell < 0 || cell >= grid_.cells(static_cast<int>(d)) || (d == 0 && cell % L != 0))
          state.fail("block_first_cell", fmt::format("has a cell ({}) that the grid does not have", fmt::join(firsts[b], ", ")));
      }
      Band& band = bands_[static_cast<std::size_t>(band_of(firsts[b]))];
      BlockType* const block = find_or_make(band, firsts[b]);
      for (int lane = 0; lane < L; ++lane) {
        const int count = counts[b][static_cast<std::size_t>(lane)];
        // More particles than this in a cell would need more memory than a damaged file may ask for.
        constexpr int k_cell_max = 1 << 24;
        if (count < 0 || count > k_cell_max || (count > 0 && firsts[b][0] + lane >= grid_.cells(0)))
          state.fail("block_particle_counts", fmt::format("has {} particles in one cell", count));
        block->counts[lane] = static_cast<R>(count);
        block->slot_count = std::max(block->slot_count, count);
      }
      while (block->held_count < block->slot_count) block->push_slot(take_slot(band));
    }
  }
  // In one pass over the particles: they are read from memory once, on all threads.
  std::vector<std::size_t> begin;  // of each band
  std::size_t total = 0;
  for (const Band& band : bands_) {
    begin.push_back(total);
    for_each_block(band, [&](const BlockType& block) {
      for (int lane = 0; lane < L; ++lane) total += static_cast<std::size_t>(block.count(lane));
    });
  }
  if (count_ != static_cast<Index>(total)) state.fail("count", fmt::format("is {}, and the cells have {} particles", count_, total));
  struct Column {
    std::string name;
    int first;
    std::size_t width;
    std::vector<R> values;
  };
  std::vector<Column> columns;
  for (const auto& [name, first, width] : named_fields(layout_)) {
    if (first >= 0 && width > 0) columns.push_back({name, first, static_cast<std::size_t>(width), {}});
  }
  std::vector<Index> ids;
  if (state.is_loading()) {
    state.take("id", ids);
    if (ids.size() != total) state.fail("id", fmt::format("has {} numbers, not {}", ids.size(), total));
    for (Column& column : columns) {
      state.take(column.name, column.values);
      if (column.values.size() != total * column.width)
        state.fail(column.name, fmt::format("has {} numbers, not {}", column.values.size(), total * column.width));
    }
  } else {
    ids = state.spare_list<Index>("id");
    ids.resize(total);
    for (Column& column : columns) {
      column.values = state.spare_list<R>(column.name);
      column.values.resize(total * column.width);
    }
  }
  const bool is_loading = state.is_loading();
  parallel_for(static_cast<Index>(bands_.size()), static_cast<Index>(total), [&](Index b) {
    std::size_t p = begin[static_cast<std::size_t>(b)];
    for_each_block(bands_[static_cast<std::size_t>(b)], [&](const BlockType& block) {
      for (int lane = 0; lane < L; ++lane) {
        for (int k = 0; k < block.count(lane); ++k, ++p) {
          R* const particle = block.slot(k) + lane;
          if (is_loading)
            particle[layout_.id * L] = id_to_bits<R>(static_cast<std::uint32_t>(ids[p]));
          else
            ids[p] = id_from_bits(particle[layout_.id * L]);
          for (Column& column : columns) {
            R* const values = column.values.data() + p * column.width;
            for (std::size_t f = 0; f < column.width; ++f) {
              R& field = particle[(column.first + static_cast<int>(f)) * L];
              if (is_loading)
                field = values[f];
              else
                values[f] = field;
            }
          }
        }
      }
    });
  });
  if (is_loading) return;
  state.take("id", ids);
  for (Column& column : columns) state.take(column.name, column.values);
}

// Used by particle_body_state.cpp.
template void CellBlocks<2, double>::clear();
template void CellBlocks<2, double>::declare_state(State&);
template void CellBlocks<2, float>::clear();
template void CellBlocks<2, float>::declare_state(State&);
template void CellBlocks<3, double>::clear();
template void CellBlocks<3, double>::declare_state(State&);
template void CellBlocks<3, float>::clear();
template void CellBlocks<3, float>::declare_state(State&);

}  // namespace matpoint
