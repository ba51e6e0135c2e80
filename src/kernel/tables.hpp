// The kernels of each instruction set, as kernels_<name>.cpp hands them out.
#pragma once

#include "kernel/kernel.hpp"

namespace matpoint {

struct KernelTables {
  const KernelTable<2, double>* double_2d;
  const KernelTable<3, double>* double_3d;
  const KernelTable<2, float>* float_2d;
  const KernelTable<3, float>* float_3d;
};

KernelTables kernels_base();    ///< What the program itself is compiled for: SSE2 on x86-64, NEON on ARM.
KernelTables kernels_avx2();    ///< AVX2 and FMA.
KernelTables kernels_avx512();  ///< AVX-512 F, VL, DQ, BW.

}  // namespace matpoint
