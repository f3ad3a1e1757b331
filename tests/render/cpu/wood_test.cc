#include "render/cpu/wood.h"

#include <catch2/catch.hpp>
#include <cmath>

namespace engram::cpu {
namespace {

double mean_of(const WoodTexture& wood, int level) {
  const int count = (WoodTexture::kAlong >> level) * (WoodTexture::kAcross >> level);
  const std::uint8_t* texels = wood.texels + wood.offset[level];
  double sum = 0;
  for (int i = 0; i < count; ++i) sum += texels[i];
  return sum / count;
}

TEST_CASE("All levels of the wood have the same mean, which leaves colours as they are",
          "[render]") {
  const WoodTexture wood = wood_texture();
  for (int level = 0; level < WoodTexture::kLevels; ++level) {
    CHECK(std::abs(mean_of(wood, level) - WoodTexture::kMean) < 1);
  }
}

double deviation_of(const WoodTexture& wood, int level) {
  const int count = (WoodTexture::kAlong >> level) * (WoodTexture::kAcross >> level);
  const std::uint8_t* texels = wood.texels + wood.offset[level];
  double sum = 0;
  for (int i = 0; i < count; ++i) sum += std::pow(texels[i] - WoodTexture::kMean, 2);
  return std::sqrt(sum / count);
}

TEST_CASE("All levels of the wood have the same contrast, nearly the original's", "[render]") {
  // 300 levels are the brightness of the board. The grain's deviation is 0.094 of it, that of the
  // figure 0.07.
  const WoodTexture wood = wood_texture();
  for (int level = 0; level < WoodTexture::kLevels; ++level) {
    CHECK(deviation_of(wood, level) > 0.11 * 300);
    CHECK(deviation_of(wood, level) < 0.12 * 300);
  }
}

TEST_CASE("Wood has grain: it changes more across the board than along it", "[render]") {
  const WoodTexture wood = wood_texture();
  double along = 0;
  double across = 0;
  for (int row = 0; row + 1 < WoodTexture::kAcross; ++row) {
    const std::uint8_t* texel = wood.texels + row * WoodTexture::kAlong;
    for (int i = 0; i + 1 < WoodTexture::kAlong; ++i) {
      along += std::abs(texel[i + 1] - texel[i]);
      across += std::abs(texel[i + WoodTexture::kAlong] - texel[i]);
    }
  }
  CHECK(across > along);
}

TEST_CASE("The wood is painted once", "[render]") {
  CHECK(wood_texture().texels == wood_texture().texels);
}

}  // namespace
}  // namespace engram::cpu
