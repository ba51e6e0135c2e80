// Memory for many equal pieces that live as long as their owner: handed out in order, from large aligned runs that the system may back
// with huge pages (a sweep over 10^6 particles otherwise spends a good part of its time in the page tables).
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <new>
#include <vector>

#if defined(__linux__)
#include <sys/mman.h>
#endif

#include "core/types.hpp"

namespace matpoint {

class Arena {
 public:
  Arena() = default;
  ~Arena() {
    for (void* run : runs_) std::free(run);
  }
  Arena(const Arena&) = delete;
  Arena& operator=(const Arena&) = delete;

  /// `bytes` of zeroed memory, a multiple of 64, at a multiple of 64. May be called from several threads.
  void* take(std::size_t bytes) {
    const std::lock_guard lock(mutex_);
    if (bytes > left_) grow(bytes);
    void* const taken = next_;
    next_ += bytes;
    left_ -= bytes;
    return taken;
  }
  Index memory() const { return static_cast<Index>(total_); }

 private:
  static constexpr std::size_t k_huge_page = std::size_t{2} << 20;

  /// A new run, a part of what there is: the slack stays small beside what is used, and a sweep never waits long for new memory.
  void grow(std::size_t bytes) {
    std::size_t size = std::max(total_ / 32, bytes);
    if (size < std::size_t{16} << 10) size = std::size_t{16} << 10;
    const std::size_t alignment = size >= k_huge_page ? k_huge_page : 64;
    size = (size + alignment - 1) / alignment * alignment;
    void* const run = std::aligned_alloc(alignment, size);
    if (run == nullptr) throw std::bad_alloc();
#if defined(__linux__)
    if (alignment == k_huge_page) ::madvise(run, size, MADV_HUGEPAGE);
#endif
    std::memset(run, 0, size);
    runs_.push_back(run);
    next_ = static_cast<char*>(run);
    left_ = size;
    total_ += size;
  }

  std::mutex mutex_;
  std::vector<void*> runs_;
  char* next_ = nullptr;
  std::size_t left_ = 0;
  std::size_t total_ = 0;
};

}  // namespace matpoint
