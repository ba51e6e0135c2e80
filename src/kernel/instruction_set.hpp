// Compiled once per instruction set: MPM_SIMD_NAME names the function that hands out the kernels, MPM_SIMD_BYTES the width of a pack.
#pragma once

#include "kernel/node_kernel.hpp"
#include "kernel/sweep.hpp"

namespace matpoint {
namespace {

template <SweepVariant V, int Dim, class R>
constexpr void set_sweeps(KernelTable<Dim, R>& table) {
  auto& sweeps = table.sweeps[static_cast<int>(V)];
  sweeps[static_cast<int>(Sweep::start)] = &sweep_chunk<Sweep::start, V, Dim, R>;
  sweeps[static_cast<int>(Sweep::start_momentum)] = &sweep_chunk<Sweep::start_momentum, V, Dim, R>;
  sweeps[static_cast<int>(Sweep::usl)] = &sweep_chunk<Sweep::usl, V, Dim, R>;
  sweeps[static_cast<int>(Sweep::musl_velocity)] = &sweep_chunk<Sweep::musl_velocity, V, Dim, R>;
  sweeps[static_cast<int>(Sweep::musl_gradient)] = &sweep_chunk<Sweep::musl_gradient, V, Dim, R>;
  sweeps[static_cast<int>(Sweep::usf_stress)] = &sweep_chunk<Sweep::usf_stress, V, Dim, R>;
  sweeps[static_cast<int>(Sweep::usf_velocity)] = &sweep_chunk<Sweep::usf_velocity, V, Dim, R>;
  sweeps[static_cast<int>(Sweep::force)] = &sweep_chunk<Sweep::force, V, Dim, R>;
  sweeps[static_cast<int>(Sweep::refine)] = &sweep_chunk<Sweep::refine, V, Dim, R>;
}

template <int Dim, class R>
constexpr KernelTable<Dim, R> make_table() {
  KernelTable<Dim, R> table{};
  set_sweeps<SweepVariant::linear_plain>(table);
  set_sweeps<SweepVariant::linear>(table);
  set_sweeps<SweepVariant::bspline2>(table);
  set_sweeps<SweepVariant::bspline3>(table);
  set_sweeps<SweepVariant::gimp>(table);
  set_sweeps<SweepVariant::cpdi>(table);
  table.advance = &advance_nodes<Dim, R>;
  table.map_velocity = &map_node_velocity<Dim, R>;
  table.clear = &clear_nodes<Dim, R>;
  return table;
}

template <int Dim, class R>
constexpr KernelTable<Dim, R> k_table = make_table<Dim, R>();

}  // namespace
}  // namespace matpoint
