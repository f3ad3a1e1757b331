// Files that appear complete or not at all (atomic replacement).
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace engram {

// Writes all bytes to an open descriptor. Returns 0, or the system's error number.
int write_all(int descriptor, std::span<const std::byte> bytes);

// A file that is written under a temporary name and then renamed to its own. The temporary name
// cannot be guessed; nothing that is there is written into, and no link is followed.
class TemporaryFile {
 public:
  // Creates the temporary file beside `path`. Throws Error (kIo), as all functions of this class,
  // with messages that name the path.
  explicit TemporaryFile(std::string path);
  // Writes the file of that name in an open folder. shown: its path in messages.
  TemporaryFile(int folder, std::string name, std::string shown);
  // Removes the file unless it was kept.
  ~TemporaryFile();
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  void write(std::span<const std::byte> bytes);
  // Second name of the open file, for libraries that open files themselves. If there is /proc, it
  // leads to this very file even if the temporary name has been replaced.
  std::string open_name() const;
  // Renames the file to its own name, in place of an older one, once its bytes are on the disk.
  void keep();

 private:
  [[noreturn]] void fail(int error) const;

  int folder_;
  std::string name_;       // in that folder
  std::string temporary_;  // likewise
  std::string shown_;
  int descriptor_ = -1;
  bool kept_ = false;
};

// Removes temporary files that killed processes have left in a folder: all of them, or those of the
// file of that name. Files that a living process writes stay.
void remove_temporary_files(const std::string& folder, std::string_view name = {});
// Removes those of one file.
void remove_temporary_files_of(const std::string& path);

}  // namespace engram
