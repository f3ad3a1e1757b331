// Files that are written completely or not at all.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/temporary_file.h"

namespace engram {

// Writes a file that is never seen half-written, not even after a power cut (TemporaryFile). An
// existing link or device of that name is replaced, not followed. Throws Error (kIo) if that fails;
// an older file is then unchanged.
void write_file(const std::filesystem::path& path, std::span<const std::byte> bytes);
void write_file(const std::filesystem::path& path, std::string_view text);
// Writes to a path given by the user, which may be a device or a pipe.
void write_output(const std::filesystem::path& path, std::string_view text);

// The content of a file; nothing if there is none. Throws Error (kIo) if it cannot be read, is
// larger than anything of engram's, or is a pipe or a device, which might never end.
std::optional<std::string> read_file(const std::filesystem::path& path);
// Reads a path given by the user, which may be a pipe or a device, up to 64 MiB.
std::optional<std::string> read_input(const std::filesystem::path& path);

// A folder by its descriptor: the same one until the end, whatever takes its name meanwhile.
class OpenFolder {
 public:
  // The folder itself may be reached by a link. Throws Error (kIo) if it cannot be opened.
  explicit OpenFolder(const std::filesystem::path& folder);
  ~OpenFolder();
  OpenFolder(OpenFolder&& other) noexcept;
  OpenFolder& operator=(OpenFolder&&) = delete;
  OpenFolder(const OpenFolder&) = delete;
  OpenFolder& operator=(const OpenFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  int descriptor() const { return descriptor_; }

  // A folder in it, made if need be. Throws Error (kIo) if it is a link or no folder.
  OpenFolder subfolder(const std::string& name) const;
  // Write and read a file in it, as the functions above.
  void write_file(const std::string& name, std::span<const std::byte> bytes) const;
  void write_file(const std::string& name, std::string_view text) const;
  std::optional<std::string> read_file(const std::string& name) const;
  // The names of everything in it, in no order. Throws Error (kIo) if it cannot be read.
  std::vector<std::string> names() const;

 private:
  OpenFolder(std::filesystem::path path, int descriptor)
      : path_(std::move(path)), descriptor_(descriptor) {}

  std::filesystem::path path_;  // when it was opened, for messages
  int descriptor_;
};

// Makes the folder, if need be. Throws Error (kIo) if no file can be made in it.
void require_writable_folder(const std::filesystem::path& folder);

}  // namespace engram
