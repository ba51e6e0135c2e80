#define MPM_SIMD_BYTES 64
#include "kernel/instruction_set.hpp"

#include "kernel/tables.hpp"

namespace matpoint {

KernelTables kernels_avx512() { return {&k_table<2, double>, &k_table<3, double>, &k_table<2, float>, &k_table<3, float>}; }

}  // namespace matpoint
