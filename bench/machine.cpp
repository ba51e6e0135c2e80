// Compiled for the building host, like the plain loop: standard headers and the C library only.
#include "machine.hpp"

#include <time.h>

#include <cstdlib>
#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace matpoint::bench {
namespace {

#if defined(__AVX512F__)
constexpr int k_pack_bytes = 64;
#elif defined(__AVX2__)
constexpr int k_pack_bytes = 32;
#else
constexpr int k_pack_bytes = 16;
#endif

double seconds() {
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Twelve chains hide the latency of a multiply-add on all processors of today.
template <class R>
double multiply_add_rate() {
  typedef R Pack __attribute__((vector_size(k_pack_bytes)));
  constexpr int k_chains = 12;
  constexpr int k_rounds = 4'000'000;
  double best = 0;
  for (int repetition = 0; repetition < 7; ++repetition) {
    Pack chain[k_chains] = {};
    Pack factor = Pack{} + static_cast<R>(0.999);
    Pack term = Pack{} + static_cast<R>(0.1);
    asm volatile("" : "+x"(factor), "+x"(term));  // not to be known in advance
    const double start = seconds();
    for (int round = 0; round < k_rounds; ++round) {
      for (Pack& x : chain) x = x * factor + term;
    }
    const double time = seconds() - start;
    Pack sum = {};
    for (const Pack& x : chain) sum += x;
    asm volatile("" : : "x"(sum));
    const double rate = 2.0 * k_rounds * k_chains * (k_pack_bytes / static_cast<double>(sizeof(R))) / time;
    best = rate > best ? rate : best;
  }
  return best;
}

double update_rate() {
  constexpr std::size_t k_bytes = std::size_t{256} << 20;
  constexpr std::size_t k_huge_page = std::size_t{2} << 20;
  auto* const values = static_cast<double*>(std::aligned_alloc(k_huge_page, k_bytes));
  if (values == nullptr) return 0;
#if defined(__linux__)
  ::madvise(values, k_bytes, MADV_HUGEPAGE);
#endif
  const std::size_t count = k_bytes / sizeof(double);
  for (std::size_t i = 0; i < count; ++i) values[i] = 1;
  double best = 0;
  for (int repetition = 0; repetition < 7; ++repetition) {
    const double start = seconds();
    for (std::size_t i = 0; i < count; ++i) values[i] *= 1.0001;
    asm volatile("" : : "r"(values) : "memory");
    const double rate = 2.0 * k_bytes / (seconds() - start);
    best = rate > best ? rate : best;
  }
  std::free(values);
  return best;
}

}  // namespace

Machine measure_machine() { return {update_rate(), multiply_add_rate<double>(), multiply_add_rate<float>()}; }

}  // namespace matpoint::bench
