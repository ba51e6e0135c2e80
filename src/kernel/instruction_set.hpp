// Compiled once per instruction set: MPM_SIMD_NAME names the function that hands out the kernels, MPM_SIMD_BYTES the width of a pack.
#pragma once

#include "kernel/law_kernel.hpp"
#include "kernel/node_kernel.hpp"
#include "kernel/sweep.hpp"

namespace matpoint {
namespace {

template <int Dim, class R>
constexpr KernelTable<Dim, R> k_table = {
    {&sweep_chunk<Sweep::start, Dim, R>, &sweep_chunk<Sweep::start_momentum, Dim, R>, &sweep_chunk<Sweep::usl, Dim, R>,
     &sweep_chunk<Sweep::musl_velocity, Dim, R>, &sweep_chunk<Sweep::musl_gradient, Dim, R>, &sweep_chunk<Sweep::usf_stress, Dim, R>,
     &sweep_chunk<Sweep::usf_velocity, Dim, R>},
    law_kernels_of<Dim, R>(static_cast<AllLaws*>(nullptr)),
    &advance_nodes<Dim, R>,
    &map_node_velocity<Dim, R>,
    &clear_nodes<Dim, R>,
};

}  // namespace
}  // namespace matpoint
