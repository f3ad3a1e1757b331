#include "protocol/datasets/npz.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "tests/temporary_folder.h"

namespace engram::test {
namespace {

const std::vector<std::uint8_t> kPixels = [] {
  std::vector<std::uint8_t> pixels(5 * 4 * 6);
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<std::uint8_t>(i * 7);
  return pixels;
}();
constexpr std::int64_t kSeed = 4'242'424'242;

std::vector<std::byte> sample() {
  const std::vector<float> rewards = {0.25F, -1.5F};
  const std::u32string text = code_points("Tür \xf0\x9f\x9a\xaa");
  const bool yes = true;
  const NpyArray arrays[] = {
      {"rgb", NpyType::kUint8, {5, 4, 6}, bytes_of(kPixels)},
      {"reward", NpyType::kFloat32, {2}, bytes_of(rewards)},
      {"text",
       NpyType::kText,
       {},
       std::as_bytes(std::span<const char32_t>(text)),
       static_cast<int>(text.size())},
      {"yes", NpyType::kBool, {}, bytes_of(yes)},
      {"seed", NpyType::kInt64, {}, bytes_of(kSeed)},
  };
  return npz_bytes(arrays);
}

void write(const std::filesystem::path& path, const std::vector<std::byte>& bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  REQUIRE(file.flush().good());
}

}  // namespace

TEST_CASE("NPZ: arrays come back", "[npz]") {
  const TemporaryFolder folder;
  const auto path = folder.path() / "a.npz";
  write(path, sample());
  const NpzFile file(path);
  const std::int64_t shape[] = {5, 4, 6};
  const std::vector<std::byte> pixels = file.read("rgb", NpyType::kUint8, shape);
  REQUIRE(pixels.size() == kPixels.size());
  CHECK(std::memcmp(pixels.data(), kPixels.data(), pixels.size()) == 0);
  CHECK(file.shape("reward", NpyType::kFloat32) == std::vector<std::int64_t>{2});
  CHECK(file.scalar<std::int64_t>("seed", NpyType::kInt64) == kSeed);
  CHECK(file.scalar<bool>("yes", NpyType::kBool));
  CHECK_THROWS_AS(file.shape("reward", NpyType::kInt32), Error);
  CHECK_THROWS_AS(file.shape("other", NpyType::kInt32), Error);
}

TEST_CASE("NPZ: the same arrays make the same bytes at any time", "[npz]") {
  const std::vector<std::byte> bytes = sample();
  CHECK(bytes == sample());
  const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  CHECK(text.starts_with("PK\x03\x04"));
  for (const char* name : {"rgb.npy", "reward.npy", "text.npy", "yes.npy", "seed.npy"}) {
    CHECK(text.find(name) != std::string::npos);
  }
  // 1 January 1980, midnight, in the first local header: version, flags, method, time, date.
  CHECK(text.substr(10, 4) == std::string("\x00\x00\x21\x00", 4));
}

TEST_CASE("NPZ: text becomes code points", "[npz]") {
  CHECK(code_points("abc") == U"abc");
  CHECK(code_points("Tür \xf0\x9f\x9a\xaa") == U"Tür \U0001F6AA");
  CHECK(code_points("a\xffz") == U"a\uFFFDz");
  CHECK(code_points("\xe2\x82") == U"\uFFFD\uFFFD");
}

TEST_CASE("NPZ: damaged files are refused", "[npz]") {
  const TemporaryFolder folder;
  const auto path = folder.path() / "a.npz";
  const std::vector<std::byte> whole = sample();
  CHECK_THROWS_AS(NpzFile(path), Error);  // not there
  for (const std::size_t length :
       {std::size_t{0}, std::size_t{10}, whole.size() / 2, whole.size() - 1}) {
    write(path, {whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length)});
    CHECK_THROWS_WITH(NpzFile(path), Catch::Contains(path.string()) && Catch::Contains("damaged"));
  }
  // Any flipped byte of the pixels' member is noticed when they are read.
  const std::int64_t shape[] = {5, 4, 6};
  int noticed = 0;
  for (std::size_t at = 60; at < 100; ++at) {
    std::vector<std::byte> damaged = whole;
    damaged[at] ^= std::byte{0x10};
    write(path, damaged);
    try {
      NpzFile(path).read("rgb", NpyType::kUint8, shape);
    } catch (const Error& error) {
      CHECK(error.kind() == Error::kIo);
      ++noticed;
    }
  }
  CHECK(noticed == 40);
}

TEST_CASE("NPZ: an announced size allocates no memory", "[npz]") {
  const TemporaryFolder folder;
  const auto path = folder.path() / "a.npz";
  const std::byte few[] = {std::byte{1}, std::byte{2}};
  for (const std::int64_t size : {std::int64_t{1} << 34, std::int64_t{1} << 62}) {
    const std::vector<std::int64_t> shape = {size, 4, 4};
    const NpyArray array{"x", NpyType::kFloat32, shape, few};
    write(path, npz_bytes({&array, 1}));
    const NpzFile file(path);
    CHECK_THROWS_WITH(file.read("x", NpyType::kFloat32, shape), Catch::Contains("array 'x'"));
  }
}

}  // namespace engram::test
