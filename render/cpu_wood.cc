// The wood of the tables: growth rings cut lengthwise, painted once.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "render/cpu_scene.h"

namespace engram::cpu {
namespace {

// A number in 0..1 for each point of a lattice.
float lattice(std::uint32_t x, std::uint32_t y, std::uint32_t seed) {
  std::uint32_t h = x * 0x9e3779b1U ^ y * 0x85ebca77U ^ seed * 0xc2b2ae3dU;
  h = (h ^ (h >> 15)) * 0x2c1b3c6dU;
  h = (h ^ (h >> 12)) * 0x297a2d39U;
  return static_cast<float>((h ^ (h >> 15)) >> 8) * 0x1p-24F;
}

// Smooth noise in -1..1 that repeats after nx by ny cells; x and y run from 0 to 1.
float noise(float x, float y, std::uint32_t nx, std::uint32_t ny, std::uint32_t seed) {
  const float fx = x * static_cast<float>(nx);
  const float fy = y * static_cast<float>(ny);
  const auto ix = static_cast<std::uint32_t>(fx);
  const auto iy = static_cast<std::uint32_t>(fy);
  const float tx = fx - static_cast<float>(ix);
  const float ty = fy - static_cast<float>(iy);
  const float sx = tx * tx * (3 - 2 * tx);
  const float sy = ty * ty * (3 - 2 * ty);
  const auto at = [&](std::uint32_t dx, std::uint32_t dy) {
    return lattice((ix + dx) % nx, (iy + dy) % ny, seed);
  };
  const float low = at(0, 0) + sx * (at(1, 0) - at(0, 0));
  const float high = at(0, 1) + sx * (at(1, 1) - at(0, 1));
  return 2 * (low + sy * (high - low)) - 1;
}

// Brightness, 0..1, of one point; x along and y across the grain.
float brightness(float x, float y) {
  // Rings bend slowly along the board: nested arches here, straight lines there.
  constexpr float kRings = 88;
  const float bend =
      6.5F * noise(x, y, 2, 4, 1) + 2.0F * noise(x, y, 4, 10, 2) + 0.30F * noise(x, y, 12, 80, 3);
  const float ring = y * kRings + bend;
  const float phase = ring - std::floor(ring);
  // Each ring darkens slowly and ends sharply.
  const float dark = phase < 0.75F ? phase / 0.75F : (1 - phase) / 0.25F;
  const float strength = 0.6F + 0.4F * noise(x, y, 3, 14, 4);
  const float streaks = 0.5F * noise(x, y, 10, 150, 9) + 0.5F * noise(x, y, 32, 360, 5);
  const float pores = noise(x, y, 96, 512, 6);
  const float shade = 0.4F * noise(x, y, 2, 5, 7) + 0.6F * noise(x, y, 4, 26, 8);
  const float value = 0.74F - 0.5F * strength * (dark * dark - 0.33F) + 0.26F * streaks +
                      0.10F * pores + 0.22F * shade - 0.15F;
  return value < 0 ? 0.0F : (value > 1 ? 1.0F : value);
}

std::vector<std::uint8_t> paint(const WoodTexture& texture, std::size_t size) {
  std::vector<std::uint8_t> texels(size);
  constexpr int kAlong = WoodTexture::kAlong;
  constexpr int kAcross = WoodTexture::kAcross;
  for (int y = 0; y < kAcross; ++y) {
    for (int x = 0; x < kAlong; ++x) {
      const float value = brightness((static_cast<float>(x) + 0.5F) / kAlong,
                                     (static_cast<float>(y) + 0.5F) / kAcross);
      texels[static_cast<std::size_t>(y * kAlong + x)] =
          static_cast<std::uint8_t>(std::lround(255 * value));
    }
  }
  // Each coarser level is the mean of four texels, with more contrast: photographed boards keep
  // streaks where the mean would be smooth.
  constexpr int kMean = 158;
  for (int level = 1; level < WoodTexture::kLevels; ++level) {
    const int along = kAlong >> level;
    const int across = kAcross >> level;
    const std::uint8_t* finer = &texels[static_cast<std::size_t>(texture.offset[level - 1])];
    std::uint8_t* out = &texels[static_cast<std::size_t>(texture.offset[level])];
    for (int y = 0; y < across; ++y) {
      for (int x = 0; x < along; ++x) {
        const std::uint8_t* from = finer + 4 * y * along + 2 * x;
        const int sum = from[0] + from[1] + from[2 * along] + from[2 * along + 1];
        const int contrasted = kMean + (sum + 2 - 4 * kMean) * 9 / 32;
        out[y * along + x] = static_cast<std::uint8_t>(std::clamp(contrasted, 0, 255));
      }
    }
  }
  return texels;
}

}  // namespace

WoodTexture wood_texture() {
  WoodTexture texture = {};
  int size = 0;
  for (int level = 0; level < WoodTexture::kLevels; ++level) {
    texture.offset[level] = size;
    size += (WoodTexture::kAlong >> level) * (WoodTexture::kAcross >> level);
  }
  constexpr int kSlack = 16;  // kernels read whole words
  static const std::vector<std::uint8_t> texels =
      paint(texture, static_cast<std::size_t>(size + kSlack));
  texture.texels = texels.data();
  return texture;
}

}  // namespace engram::cpu
