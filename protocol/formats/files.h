// Files that are written completely or not at all.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace engram {

// Writes all bytes to an open descriptor. Returns 0, or the system's error number.
int write_all(int descriptor, std::span<const std::byte> bytes);

// Writes a file that is never seen half-written, not even after a power cut: under a temporary name
// first, then renamed. Devices and pipes are written to directly. Throws Error (kIo) if that
// fails; an older file is then unchanged.
void write_file(const std::filesystem::path& path, std::span<const std::byte> bytes);
void write_file(const std::filesystem::path& path, std::string_view text);

// The content of a file; nothing if there is none. Throws Error (kIo) if it cannot be read.
std::optional<std::string> read_file(const std::filesystem::path& path);

// The names of everything in a folder, in no order. Throws Error (kIo) if it cannot be read.
std::vector<std::string> names_in(const std::filesystem::path& folder);

// Makes the folder, if need be. Throws Error (kIo) if no file can be made in it.
void require_writable_folder(const std::filesystem::path& folder);

// Removes what write_file left in a folder when its process was killed.
void remove_temporary_files(const std::filesystem::path& folder);

}  // namespace engram
