#include "media/png.h"

#include <png.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <vector>

#include "core/base/error.h"

namespace engram::test {
namespace {

namespace fs = std::filesystem;

// A folder that goes away again.
struct Folder {
  fs::path path = fs::temp_directory_path() / ("engram_png_" + std::to_string(getpid()));
  Folder() { fs::create_directories(path); }
  ~Folder() { fs::remove_all(path); }
};

TEST_CASE("a PNG file holds the pixels that were written", "[render]") {
  const Folder folder;
  const std::string path = folder.path / "picture.png";
  std::vector<std::uint8_t> rgb(3 * 5 * 4);
  for (std::size_t i = 0; i < rgb.size(); ++i) rgb[i] = static_cast<std::uint8_t>(4 * i);
  write_png(path, 5, 4, rgb);
  write_png(path, 5, 4, rgb);  // over the old one

  png_image image = {};
  image.version = PNG_IMAGE_VERSION;
  REQUIRE(png_image_begin_read_from_file(&image, path.c_str()) != 0);
  CHECK(image.width == 5);
  CHECK(image.height == 4);
  image.format = PNG_FORMAT_RGB;
  std::vector<std::uint8_t> read(rgb.size());
  REQUIRE(png_image_finish_read(&image, nullptr, read.data(), 0, nullptr) != 0);
  CHECK(read == rgb);
  CHECK(std::distance(fs::directory_iterator(folder.path), fs::directory_iterator()) == 1);
}

TEST_CASE("a PNG file replaces a link, and what a killed process left goes", "[render]") {
  const Folder folder;
  const fs::path other = folder.path / "other";
  write_png(other, 2, 2, std::vector<std::uint8_t>(12));
  const auto size = fs::file_size(other);
  fs::create_symlink(other, folder.path / "a.png");
  write_png(folder.path / "a.png.0123456789abcdef.engram-tmp", 2, 2, std::vector<std::uint8_t>(12));
  write_png(folder.path / "a.png", 40, 40, std::vector<std::uint8_t>(4800, 7));
  CHECK_FALSE(fs::is_symlink(folder.path / "a.png"));
  CHECK(fs::file_size(other) == size);
  CHECK(std::distance(fs::directory_iterator(folder.path), fs::directory_iterator()) == 2);
}

TEST_CASE("a PNG file that cannot be written leaves nothing behind", "[render]") {
  const Folder folder;
  const std::vector<std::uint8_t> rgb(12);
  CHECK_THROWS_AS(write_png(folder.path / "missing" / "a.png", 2, 2, rgb), Error);
  fs::create_directory(folder.path / "taken.png");
  CHECK_THROWS_AS(write_png(folder.path / "taken.png", 2, 2, rgb), Error);
  CHECK_THROWS_AS(write_png(folder.path / "a.png", 2, 3, rgb), Error);
  CHECK_THROWS_AS(write_png(folder.path / "a.png", 0, 3, {}), Error);
  CHECK(std::distance(fs::directory_iterator(folder.path), fs::directory_iterator()) == 1);
}

}  // namespace
}  // namespace engram::test
