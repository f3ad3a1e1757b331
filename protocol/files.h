// Files that are either whole or not there.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>

namespace engram {

// Writes a file that is never seen half-written, not even after a power cut: under a temporary name
// first, then renamed. A device or pipe is written to as it is. Throws Error (kIo) if that fails;
// what was there before stays.
void write_file(const std::filesystem::path& path, std::span<const std::byte> bytes);
void write_file(const std::filesystem::path& path, std::string_view text);

// Makes the folder, if need be. Throws Error (kIo) if no file can be made in it.
void require_writable_folder(const std::filesystem::path& folder);

// Removes what write_file left in a folder when its process was killed.
void remove_temporary_files(const std::filesystem::path& folder);

}  // namespace engram
