#include "io/folder_lock.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <utility>

#include "core/error.hpp"

namespace matpoint {
namespace {

std::string host_name() {
  char name[256] = {};
  return ::gethostname(name, sizeof name - 1) == 0 ? name : "";
}

}  // namespace

bool FolderUse::is_here() const { return host == host_name(); }

FolderLock::~FolderLock() { release(); }

void FolderLock::release() {
  // The file stays: whoever unlinks it may unlink the one that another process has just locked.
  if (descriptor_ >= 0) ::close(std::exchange(descriptor_, -1));
}

void FolderLock::take(const std::filesystem::path& folder, const std::string& started) {
  if (descriptor_ >= 0) return;
  const std::filesystem::path path = folder / k_lock_name;
  descriptor_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (descriptor_ < 0) throw InputError("results folder \"{}\" cannot be locked: {}", folder.string(), std::strerror(errno));
  if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    release();
    const FolderUse use = folder_use(folder);
    throw InputError(
        "results folder \"{}\" is in use: process {} on {} writes into it since {}; wait for it, or give another folder with --out",
        folder.string(), use.process, use.host, use.started);
  }
  const std::string text = fmt::format("{} {} {}\n", ::getpid(), host_name(), started);
  if (::ftruncate(descriptor_, 0) != 0 || ::pwrite(descriptor_, text.data(), text.size(), 0) != static_cast<ssize_t>(text.size()))
    throw InputError("results folder \"{}\" cannot be locked: {}", folder.string(), std::strerror(errno));
}

FolderUse folder_use(const std::filesystem::path& folder) {
  FolderUse use;
  const std::filesystem::path path = folder / k_lock_name;
  std::ifstream file(path);
  if (!file) return use;
  file >> use.process >> use.host >> use.started;
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return use;
  use.is_locked = ::flock(descriptor, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  ::close(descriptor);
  return use;
}

}  // namespace matpoint
