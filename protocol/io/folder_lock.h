// A folder that one process at a time writes to.
#pragma once

#include <filesystem>

#include "protocol/io/files.h"

namespace engram {

// Keeps other processes, and other locks of this one, from a folder while it lives. Two runs that
// write the same files would remove or overwrite each other's.
class FolderLock {
 public:
  // Removes what a run that was killed has left half-written, and writes a note of the owner.
  // Throws Error (kIo), which names the owner, if the folder is locked.
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

  // The locked folder, even if a link or another folder has taken its name.
  const OpenFolder& folder() const { return folder_; }

 private:
  OpenFolder folder_;
};

}  // namespace engram
