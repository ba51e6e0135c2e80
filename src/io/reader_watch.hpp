// Who looks at the files of a folder while they are replaced.
//
// A reader that opens a file once sees the old or the new one. VTK's opens it several times for one look, takes the number of times from
// the first and their values from the second, and crashes where the second has more. So a file of times is replaced when nobody has just
// opened it; on file systems of other machines that cannot be known.
#pragma once

#include <chrono>
#include <filesystem>
#include <map>
#include <string>

namespace matpoint {

class ReaderWatch {
 public:
  explicit ReaderWatch(const std::filesystem::path& folder);
  ~ReaderWatch();
  ReaderWatch(const ReaderWatch&) = delete;
  ReaderWatch& operator=(const ReaderWatch&) = delete;

  /// Waits until nobody has opened or closed the file of that name for a moment, at most so long; false if that did not happen.
  bool is_quiet(const std::string& name, std::chrono::milliseconds most);

 private:
  using Clock = std::chrono::steady_clock;
  void take_events();

  struct Looks {
    Clock::time_point last;  ///< When the file was opened or closed.
    int open = 0;            ///< By so many it is now.
  };
  int descriptor_ = -1;
  std::map<std::string, Looks> seen_;  ///< By the file's name, since it was replaced.
};

}  // namespace matpoint
