#include "io/reader_watch.hpp"

#include <poll.h>
#include <sys/inotify.h>
#include <unistd.h>

#include <cstring>

namespace matpoint {

ReaderWatch::ReaderWatch(const std::filesystem::path& folder) : descriptor_(::inotify_init1(IN_CLOEXEC | IN_NONBLOCK)) {
  // Without it, as where there are too many watches, files are replaced when they are ready.
  if (descriptor_ >= 0) ::inotify_add_watch(descriptor_, folder.c_str(), IN_OPEN | IN_CLOSE);
}

ReaderWatch::~ReaderWatch() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void ReaderWatch::take_events() {
  alignas(inotify_event) char buffer[16384];
  const Clock::time_point now = Clock::now();
  while (true) {
    const ssize_t size = ::read(descriptor_, buffer, sizeof buffer);
    if (size <= 0) return;
    for (ssize_t at = 0; at < size;) {
      inotify_event event;
      std::memcpy(&event, buffer + at, sizeof event);
      if (event.len > 0) {
        Looks& looks = seen_[buffer + at + sizeof event];
        looks.last = now;
        looks.open += (event.mask & IN_OPEN) != 0 ? 1 : -1;
      }
      at += static_cast<ssize_t>(sizeof event + event.len);
    }
  }
}

bool ReaderWatch::is_quiet(const std::string& name, std::chrono::milliseconds most) {
  // Between the times at which VTK opens a file for one look there is less than a millisecond.
  constexpr std::chrono::milliseconds k_quiet{10};
  if (descriptor_ < 0) return true;
  const Clock::time_point start = Clock::now();
  while (true) {
    take_events();
    const auto found = seen_.find(name);
    if (found == seen_.end() || (found->second.open <= 0 && Clock::now() - found->second.last >= k_quiet)) {
      seen_.erase(name);
      return true;
    }
    if (Clock::now() - start >= most) return false;
    pollfd wait{descriptor_, POLLIN, 0};
    ::poll(&wait, 1, static_cast<int>(k_quiet.count()));
  }
}

}  // namespace matpoint
