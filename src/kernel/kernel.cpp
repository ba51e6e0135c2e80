#include "kernel/kernel.hpp"

#include <algorithm>
#include <cstdlib>

#include "core/error.hpp"
#include "kernel/tables.hpp"
#include "material/laws.hpp"

namespace matpoint {
namespace {

template <InstructionSet set, class... Laws>
std::vector<LawKernels> all_laws(std::tuple<Laws...>*) {
  return {law_kernels<set, Laws>()...};
}
template <InstructionSet set>
std::vector<LawKernels> all_laws() {
  return all_laws<set>(static_cast<AllLaws*>(nullptr));
}

struct Level {
  std::string name;
  KernelTables (*tables)();
  std::vector<LawKernels> (*laws)();
};

std::vector<Level> available_levels() {
  std::vector<Level> levels;
#ifdef MATPOINT_HAS_X86_KERNELS
  if (__builtin_cpu_supports("x86-64-v4")) levels.push_back({"avx512", kernels_avx512, all_laws<InstructionSet::avx512>});
  if (__builtin_cpu_supports("x86-64-v3")) levels.push_back({"avx2", kernels_avx2, all_laws<InstructionSet::avx2>});
#endif
  levels.push_back({"base", kernels_base, all_laws<InstructionSet::base>});
  return levels;
}

struct Choice {
  std::string name;
  KernelTables tables;
  std::vector<LawKernels> laws;  // in the order of AllLaws
};

Choice choose() {
  const std::vector<Level> levels = available_levels();
  const char* asked = std::getenv("MATPOINT_SIMD");
  if (asked == nullptr || *asked == 0) return {levels.front().name, levels.front().tables(), levels.front().laws()};
  for (const Level& level : levels) {
    if (level.name == asked) return {level.name, level.tables(), level.laws()};
  }
  const std::vector<std::string> names = available_instruction_sets();
  throw InputError("MATPOINT_SIMD = \"{}\" is not available on this processor, allowed: {}{}", asked, list_names(names),
                   did_you_mean(asked, names));
}

const Choice& choice() {
  static const Choice chosen = choose();
  return chosen;
}

}  // namespace

std::vector<std::string> available_instruction_sets() {
  std::vector<std::string> names;
  for (const Level& level : available_levels()) names.push_back(level.name);
  return names;
}

const std::string& instruction_set() { return choice().name; }

template <>
const KernelTable<2, double>& kernel_table<2, double>() {
  return *choice().tables.double_2d;
}
template <>
const KernelTable<3, double>& kernel_table<3, double>() {
  return *choice().tables.double_3d;
}
template <>
const KernelTable<2, float>& kernel_table<2, float>() {
  return *choice().tables.float_2d;
}
template <>
const KernelTable<3, float>& kernel_table<3, float>() {
  return *choice().tables.float_3d;
}

template <int Dim, class R>
LawKernel<Dim, R> law_kernel(int law_index) {
  return choice().laws[static_cast<std::size_t>(law_index)].get<Dim, R>();
}
template LawKernel<2, double> law_kernel<2, double>(int);
template LawKernel<3, double> law_kernel<3, double>(int);
template LawKernel<2, float> law_kernel<2, float>(int);
template LawKernel<3, float> law_kernel<3, float>(int);

}  // namespace matpoint
