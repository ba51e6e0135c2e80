#include "core/parallel.hpp"

#include <atomic>

#ifdef _OPENMP
#include <omp.h>
#endif

namespace matpoint {
namespace {
std::atomic<int> g_thread_count{0};
}

void set_thread_count(int count) { g_thread_count = count; }

int thread_count() {
  const int count = g_thread_count;
#ifdef _OPENMP
  return count > 0 ? count : omp_get_num_procs();
#else
  (void)count;
  return 1;
#endif
}

}  // namespace matpoint
