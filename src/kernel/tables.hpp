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

/// The same of one law: an object for each law and instruction set (law_kernels.cpp.in), so that a change of a law compiles that one only.
struct LawKernels {
  LawKernel<2, double> double_2d;
  LawKernel<3, double> double_3d;
  LawKernel<2, float> float_2d;
  LawKernel<3, float> float_3d;
  template <int Dim, class R>
  LawKernel<Dim, R> get() const {
    if constexpr (Dim == 2 && sizeof(R) == 8) return double_2d;
    if constexpr (Dim == 3 && sizeof(R) == 8) return double_3d;
    if constexpr (Dim == 2 && sizeof(R) == 4) return float_2d;
    if constexpr (Dim == 3 && sizeof(R) == 4) return float_3d;
  }
};
enum class InstructionSet { base, avx2, avx512 };
template <InstructionSet set, class Law>
LawKernels law_kernels();

}  // namespace matpoint
