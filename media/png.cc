#include "media/png.h"

#include <png.h>

#include <cstddef>

#include "core/base/error.h"
#include "core/base/temporary_file.h"

namespace engram {

namespace {

// The header for libpng. Throws Error if sizes do not fit.
png_image describe(int width, int height, std::span<const std::uint8_t> rgb) {
  constexpr int kLargestSide = 1 << 16;
  if (width < 1 || height < 1 || width > kLargestSide || height > kLargestSide ||
      rgb.size() !=
          std::size_t{3} * static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {
    throw Error(Error::kInvalidArgument, "write_png: " + std::to_string(width) + " x " +
                                             std::to_string(height) + " pixels do not fit " +
                                             std::to_string(rgb.size()) + " bytes of rgb");
  }
  png_image image = {};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(width);
  image.height = static_cast<png_uint_32>(height);
  image.format = PNG_FORMAT_RGB;
  return image;
}

}  // namespace

void write_png(const std::string& path, int width, int height, std::span<const std::uint8_t> rgb) {
  const std::vector<std::byte> bytes = png_bytes(width, height, rgb);
  remove_temporary_files_of(path);
  TemporaryFile file(path);
  file.write(bytes);
  file.keep();
}

std::vector<std::byte> png_bytes(int width, int height, std::span<const std::uint8_t> rgb) {
  png_image image = describe(width, height, rgb);
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::vector<std::byte> bytes(size);
  if (png_image_write_to_memory(&image, bytes.data(), &size, 0, rgb.data(), 0, nullptr) == 0) {
    throw Error(Error::kInternal, std::string("png_bytes: ") + image.message);
  }
  bytes.resize(size);
  return bytes;
}

}  // namespace engram
