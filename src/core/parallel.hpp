// The only file that knows OpenMP. Work is cut into pieces by the problem (bands of the grid, chunks of particles), never by the number
// of threads, and partial sums are added in the order of the pieces: results are the same bits for any number of threads.
#pragma once

#include <atomic>
#include <exception>

#include "core/types.hpp"

namespace matpoint {

/// Threads for all loops from now on; 0 takes all processors that this process may use.
void set_thread_count(int count);
int thread_count();

/// Below this many points or nodes a parallel region costs more than it saves (measured: about 2 microseconds against 20 ns a point).
constexpr Index k_parallel_threshold = 2000;

/// Calls f(i) for i in [0, count), in any order and on any thread; `work` is the number of points or nodes behind all pieces. What an f
/// throws is thrown on when all threads are done: one of those, if there are several.
template <class F>
void parallel_for(Index count, Index work, F&& f) {
  // An exception must not leave a thread of OpenMP: the program would end there, for example for want of memory.
  std::exception_ptr error;
  std::atomic<bool> has_failed{false};
#ifdef _OPENMP
  const int threads = thread_count();
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads) if (threads > 1 && count > 1 && work >= k_parallel_threshold)
#endif
  for (Index i = 0; i < count; ++i) {
    if (has_failed.load(std::memory_order_relaxed)) continue;
    try {
      f(i);
    } catch (...) {
      if (!has_failed.exchange(true)) error = std::current_exception();
    }
  }
  (void)work;
  if (error) std::rethrow_exception(error);
}

}  // namespace matpoint
