// Who writes into a results folder: a lock that the system takes away from a process that ends, however it ends.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/types.hpp"

namespace matpoint {

constexpr const char* k_lock_name = ".lock";

/// What the lock of a folder says.
struct FolderUse {
  bool is_locked = false;  ///< A process of this machine holds it.
  std::string host;        ///< Of the last process that wrote; empty if none did.
  Index process = 0;
  std::string started;
  bool is_here() const;  ///< Whether that was this machine.
};

class FolderLock {
 public:
  FolderLock() = default;
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

  /// Takes the lock of a folder that exists, until the object or the process ends. Throws InputError if another one has it. On file systems
  /// that know no locks it is taken for free.
  void take(const std::filesystem::path& folder, const std::string& started);
  void release();

 private:
  int descriptor_ = -1;
};

FolderUse folder_use(const std::filesystem::path& folder);

}  // namespace matpoint
