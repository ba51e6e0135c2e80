// Files that stay readable when the disk fills up: text grows by whole rows, and other files appear complete or not at all.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "core/types.hpp"

namespace matpoint {

/// A text file that grows. Each append is on its way to the disk when it returns; nothing waits in a buffer of ours.
class GrowingFile {
 public:
  /// Creates the file, or replaces it, with its first text, which is on the disk then. Throws SolverError.
  GrowingFile(std::filesystem::path path, std::string_view first);
  /// Goes on after its first `size` bytes; what is behind them is cut off. Throws SolverError, and InputError for a file that is shorter.
  GrowingFile(std::filesystem::path path, Index size);
  ~GrowingFile();
  GrowingFile(const GrowingFile&) = delete;
  GrowingFile& operator=(const GrowingFile&) = delete;

  /// Appends the text, or throws SolverError and leaves the file as it was.
  void append(std::string_view text);
  Index size() const { return size_; }
  /// Takes back what is behind the first `size` bytes. Throws SolverError.
  void cut(Index size);
  /// Comes back when all of it is on the disk. Throws SolverError.
  void sync();
  /// Nothing can be appended any more. Throws SolverError.
  void close();

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
  Index size_ = 0;
};

/// Writes or replaces a file by way of `<path>.tmp`: a reader sees the old or the new file, never a part, also after a power loss. On the
/// disk when it returns; its name may follow later, so that a power loss leaves the old file, where `OnDisk::content` does. Throws
/// SolverError.
enum class OnDisk { content, name };
void write_file(const std::filesystem::path& path, std::string_view text, OnDisk what = OnDisk::name);

/// SolverError `cannot write "<path>": <reason>`.
[[noreturn]] void fail_write(const std::filesystem::path& path, const std::string& reason);

}  // namespace matpoint
