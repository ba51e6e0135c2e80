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
  /// Creates the file, or empties it. Throws SolverError.
  explicit GrowingFile(std::filesystem::path path);
  ~GrowingFile();
  GrowingFile(const GrowingFile&) = delete;
  GrowingFile& operator=(const GrowingFile&) = delete;

  /// Appends the text, or throws SolverError and leaves the file as it was.
  void append(std::string_view text);

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
  Index size_ = 0;
};

/// Writes or replaces a file by way of `<path>.tmp`: a reader sees the old or the new file, never a part. Throws SolverError.
void write_file(const std::filesystem::path& path, std::string_view text);

/// Takes room for `bytes` more at the end of a file, so that a later write cannot run out of disk halfway. The caller's write, or
/// truncation, gives back what is not used. Throws SolverError, with the file as it was, when the room is not there.
void reserve_space(const std::filesystem::path& path, Index bytes);

/// SolverError `cannot write "<path>": <reason>`.
[[noreturn]] void fail_write(const std::filesystem::path& path, const std::string& reason);

}  // namespace matpoint
