#include "io/output_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "core/error.hpp"

namespace matpoint {
namespace {

int open_to_write(const std::filesystem::path& path, int flags) {
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CLOEXEC | flags, 0666);
  if (descriptor < 0) fail_write(path, std::strerror(errno));
  return descriptor;
}

/// 0, or the error number.
int write_all(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(descriptor, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  return 0;
}

}  // namespace

void fail_write(const std::filesystem::path& path, const std::string& reason) {
  throw SolverError("cannot write \"{}\": {}", path.string(), reason);
}

namespace {

void sync_to_disk(int descriptor, const std::filesystem::path& path) {
  // Pipes and the like have nothing to sync.
  if (::fsync(descriptor) != 0 && errno != EINVAL && errno != EROFS) fail_write(path, std::strerror(errno));
}

}  // namespace

GrowingFile::GrowingFile(std::filesystem::path path, std::string_view first)
    : GrowingFile((write_file(path, first), std::move(path)), static_cast<Index>(first.size())) {}

GrowingFile::GrowingFile(std::filesystem::path path, Index size)
    : path_(std::move(path)), descriptor_(open_to_write(path_, 0)), size_(size) {
  struct stat status {};
  const int error = ::fstat(descriptor_, &status) != 0 || (status.st_size >= size && ::ftruncate(descriptor_, size) != 0) ||
                            ::lseek(descriptor_, size, SEEK_SET) < 0
                        ? errno
                        : 0;
  if (error == 0 && status.st_size >= size) return;
  ::close(descriptor_);
  if (error != 0) fail_write(path_, std::strerror(error));
  throw InputError("\"{}\" has {} bytes, and had {} when the state was saved: it has been changed since", path_.string(), status.st_size,
                   size);
}

GrowingFile::~GrowingFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void GrowingFile::sync() { sync_to_disk(descriptor_, path_); }

void GrowingFile::close() {
  // Some file systems (NFS) report a full disk only here.
  if (descriptor_ >= 0 && ::close(std::exchange(descriptor_, -1)) != 0) fail_write(path_, std::strerror(errno));
}

void GrowingFile::append(std::string_view text) {
  if (const int error = write_all(descriptor_, text)) {
    // A row that is there in part would spoil the file for every reader. Devices cannot be cut, and need not be.
    if (::ftruncate(descriptor_, size_) == 0) ::lseek(descriptor_, size_, SEEK_SET);
    fail_write(path_, std::strerror(error));
  }
  size_ += static_cast<Index>(text.size());
}

void GrowingFile::cut(Index size) {
  if (size == size_) return;
  if (::ftruncate(descriptor_, size) != 0 || ::lseek(descriptor_, size, SEEK_SET) < 0) fail_write(path_, std::strerror(errno));
  size_ = size;
}

void write_file(const std::filesystem::path& path, std::string_view text, OnDisk what) {
  std::filesystem::path temporary = path;
  temporary += ".tmp";
  const int descriptor = open_to_write(temporary, O_CREAT | O_TRUNC);
  int error = write_all(descriptor, text);
  // On the disk before it has its name, and its name on the disk before anything else says that it is there: whatever happens to the
  // machine, a name is never that of half a file.
  if (error == 0 && ::fsync(descriptor) != 0 && errno != EINVAL) error = errno;
  // Some file systems (NFS) report a full disk only here.
  if (::close(descriptor) != 0 && error == 0) error = errno;
  if (error == 0 && ::rename(temporary.c_str(), path.c_str()) != 0) error = errno;
  if (error != 0) {
    ::unlink(temporary.c_str());
    fail_write(path, std::strerror(error));
  }
  if (what == OnDisk::content) return;
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  const int folder_descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder_descriptor < 0) fail_write(path, std::strerror(errno));
  error = ::fsync(folder_descriptor) != 0 && errno != EINVAL ? errno : 0;
  ::close(folder_descriptor);
  if (error != 0) fail_write(path, std::strerror(error));
}

}  // namespace matpoint
