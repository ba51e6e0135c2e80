#include "io/output_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

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

GrowingFile::GrowingFile(std::filesystem::path path) : path_(std::move(path)), descriptor_(open_to_write(path_, O_CREAT | O_TRUNC)) {}

GrowingFile::~GrowingFile() { ::close(descriptor_); }

void GrowingFile::append(std::string_view text) {
  if (const int error = write_all(descriptor_, text)) {
    // A row that is there in part would spoil the file for every reader. Devices cannot be cut, and need not be.
    if (::ftruncate(descriptor_, size_) == 0) ::lseek(descriptor_, size_, SEEK_SET);
    fail_write(path_, std::strerror(error));
  }
  size_ += static_cast<Index>(text.size());
}

void write_file(const std::filesystem::path& path, std::string_view text) {
  std::filesystem::path temporary = path;
  temporary += ".tmp";
  const int descriptor = open_to_write(temporary, O_CREAT | O_TRUNC);
  int error = write_all(descriptor, text);
  // Some file systems (NFS) report a full disk only here.
  if (::close(descriptor) != 0 && error == 0) error = errno;
  if (error == 0 && ::rename(temporary.c_str(), path.c_str()) != 0) error = errno;
  if (error != 0) {
    ::unlink(temporary.c_str());
    fail_write(path, std::strerror(error));
  }
}

void reserve_space(const std::filesystem::path& path, Index bytes) {
  const int descriptor = open_to_write(path, 0);
  struct stat status {};
  int error = ::fstat(descriptor, &status) == 0 ? 0 : errno;
  if (error == 0) {
    do {
      error = ::posix_fallocate(descriptor, status.st_size, bytes);
    } while (error == EINTR);
    // Not every file system can reserve: then the write itself must find out.
    if (error == EINVAL || error == EOPNOTSUPP || error == ENODEV)
      error = 0;
    else if (error != 0 && ::ftruncate(descriptor, status.st_size) != 0)
      error = errno;
  }
  ::close(descriptor);
  if (error != 0) fail_write(path, std::strerror(error));
}

}  // namespace matpoint
