// Images as PNG files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace engram {

// Writes width x height pixels of three bytes, row after row from the top. The file appears whole
// or not at all. Throws Error.
void write_png(const std::string& path, int width, int height, std::span<const std::uint8_t> rgb);

// The bytes of such a file.
std::vector<std::byte> png_bytes(int width, int height, std::span<const std::uint8_t> rgb);

}  // namespace engram
