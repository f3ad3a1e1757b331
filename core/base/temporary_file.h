// Files that appear whole or not at all.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace engram {

// Writes all bytes to an open descriptor. Returns 0, or the system's error number.
int write_all(int descriptor, std::span<const std::byte> bytes);

// A file that is written under a temporary name and then renamed to its own. The temporary name
// cannot be foreseen; nothing that is there is written into, and no link is followed.
class TemporaryFile {
 public:
  // For the file of that path, beside it. Throws Error (kIo), as all of this class, with messages
  // that name the path.
  explicit TemporaryFile(std::string path);
  // Removes the file unless it was kept.
  ~TemporaryFile();
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  void write(std::span<const std::byte> bytes);
  // Another name of the open file, for libraries that open files themselves. Where there is /proc,
  // it leads to this very file even if somebody has replaced the temporary name.
  std::string open_name() const;
  // The file gets its own name, in place of an older one, once its bytes are on the disk.
  void keep();

 private:
  [[noreturn]] void fail(int error) const;

  std::string path_;
  std::string temporary_;
  int descriptor_ = -1;
  bool kept_ = false;
};

// Removes what processes that were killed have left of such files in a folder: of all of them, or
// of the file of that name. Those that a living process writes stay.
void remove_temporary_files(const std::string& folder, std::string_view name = {});
// The same for what is left of one file.
void remove_temporary_files_of(const std::string& path);

}  // namespace engram
