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
// The same for paths given by users: devices and pipes are written to.
void write_output(const std::filesystem::path& path, std::string_view text);

// The content of a file; nothing if there is none. Throws Error (kIo) if it cannot be read, is
// larger than anything of engram's, or is a pipe or a device, which might never end.
std::optional<std::string> read_file(const std::filesystem::path& path);
// The same for paths given by users, pipes and devices included, up to 64 MiB.
std::optional<std::string> read_input(const std::filesystem::path& path);

// The names of everything in a folder, in no order. Throws Error (kIo) if it cannot be read.
std::vector<std::string> names_in(const std::filesystem::path& folder);

// Makes the folder, if need be. Throws Error (kIo) if no file can be made in it.
void require_writable_folder(const std::filesystem::path& folder);

}  // namespace engram
