#include "render/cpu/wood.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <mutex>
#include <numbers>
#include <vector>

#include "core/threads/process_mutex.h"

namespace engram::cpu {
namespace {

// A number in 0..1 for each point of a lattice.
float lattice(std::uint32_t x, std::uint32_t y, std::uint32_t seed) {
  std::uint32_t h = x * 0x9e3779b1U ^ y * 0x85ebca77U ^ seed * 0xc2b2ae3dU;
  h = (h ^ (h >> 15)) * 0x2c1b3c6dU;
  h = (h ^ (h >> 12)) * 0x297a2d39U;
  return static_cast<float>((h ^ (h >> 15)) >> 8) * 0x1p-24F;
}

// Smooth noise in -1..1 that repeats after nx by ny cells. x runs from 0 to 1, y a little farther.
class Noise {
 public:
  Noise(std::uint32_t nx, std::uint32_t ny, std::uint32_t seed)
      : nx_(static_cast<float>(nx)), ny_(static_cast<float>(ny)), pitch_(nx + 1) {
    const std::uint32_t rows = ny + ny / 50 + 2;
    for (std::uint32_t y = 0; y < rows; ++y) {
      for (std::uint32_t x = 0; x <= nx; ++x) values_.push_back(lattice(x % nx, y % ny, seed));
    }
  }
  float operator()(float x, float y) const {
    const float fx = x * nx_;
    const float fy = y * ny_;
    const auto ix = static_cast<int>(fx);
    const auto iy = static_cast<int>(fy);
    const float tx = fx - static_cast<float>(ix);
    const float ty = fy - static_cast<float>(iy);
    const float sx = tx * tx * (3 - 2 * tx);
    const float sy = ty * ty * (3 - 2 * ty);
    const float* at =
        &values_[static_cast<std::size_t>(iy) * pitch_ + static_cast<std::size_t>(ix)];
    const float low = at[0] + sx * (at[1] - at[0]);
    const float high = at[pitch_] + sx * (at[pitch_ + 1] - at[pitch_]);
    return 2 * (low + sy * (high - low)) - 1;
  }

 private:
  float nx_, ny_;
  std::size_t pitch_;
  std::vector<float> values_;
};

// Streaks along the board, some 0.3 m long and 5 mm thick, that bend a little, and specks of 5 mm.
struct Grain {
  Noise bend{4, 6, 5};
  Noise streaks[3] = {{7, 400, 1}, {24, 400, 2}, {96, 400, 3}};
  Noise specks{400, 400, 4};

  float operator()(float x, float y) const {
    const float bent = y + 0.003F * (1 + bend(x, y));
    return 1.20F * streaks[0](x, bent) + 0.85F * streaks[1](x, bent) + 0.45F * streaks[2](x, bent) +
           0.50F * specks(x, bent);
  }
};

// sin(x) for |x| <= pi / 2, the same on every machine.
float sine(float x) {
  const float s = x * x;
  return x * (1 - s / 6 * (1 - s / 20 * (1 - s / 42 * (1 - s / 72))));
}

// cos(i angle) for i = 0, 1, ...; the angle goes from 0 to pi as `place` goes from 0 to 1.
constexpr int kWaves = 7;
using Waves = std::array<float, kWaves>;
Waves waves(float place) {
  const float cosine = sine(std::numbers::pi_v<float> * (0.5F - place));
  Waves wave = {1, cosine};
  for (std::size_t i = 2; i < kWaves; ++i) wave[i] = 2 * cosine * wave[i - 1] - wave[i - 2];
  return wave;
}

// Brightness of the board at large, in waves across (rows) and along: the original's table,
// smoothed over some 0.2 m.
constexpr std::array<Waves, kWaves> kFigure = {{
    {1.001F, 0.067F, 0.018F, 0.002F, -0.005F, -0.017F, -0.020F},
    {0.028F, 0.048F, 0.000F, 0.000F, -0.013F, -0.004F, 0.015F},
    {0.009F, 0.001F, -0.021F, 0.017F, 0.007F, 0.017F, 0.002F},
    {0.005F, -0.007F, -0.009F, 0.017F, -0.001F, 0.004F, -0.009F},
    {0.007F, 0.010F, -0.019F, 0.002F, 0.013F, -0.016F, -0.001F},
    {0.007F, 0.008F, -0.015F, 0.000F, 0.012F, -0.013F, 0.010F},
    {0.001F, -0.010F, -0.009F, -0.001F, 0.018F, -0.005F, 0.007F},
}};

// The texture's origin is the table's middle; its second half is what comes before the first.
float place_of(int texel, int count) {
  const float part = (static_cast<float>(texel) + 0.5F) / static_cast<float>(count);
  return part < 0.5F ? part + 0.5F : part - 0.5F;
}

// A level of the texture while it is painted: its grain alone.
struct Board {
  int along, across;
  std::vector<float> grain;
};

Board finest() {
  const Grain grain;
  Board board = {WoodTexture::kAlong, WoodTexture::kAcross, {}};
  for (int y = 0; y < board.across; ++y) {
    for (int x = 0; x < board.along; ++x) {
      board.grain.push_back(grain((static_cast<float>(x) + 0.5F) / WoodTexture::kAlong,
                                  (static_cast<float>(y) + 0.5F) / WoodTexture::kAcross));
    }
  }
  return board;
}

// Takes the mean over 40 mm across off each texel: dark lines get bright ones beside them, and
// brightness at large is the figure's.
void level_out(Board& board) {
  constexpr int kHalf = 8;
  const auto along = static_cast<std::size_t>(board.along);
  const std::vector<float> before = board.grain;
  const auto row = [&](int y) {
    return &before[static_cast<std::size_t>((y + board.across) % board.across) * along];
  };
  std::vector<double> sums(along);
  const auto add = [&](const float* values) {
    for (std::size_t x = 0; x < along; ++x) sums[x] += values[x];
  };
  for (int y = -kHalf; y < kHalf; ++y) add(row(y));
  for (int y = 0; y < board.across; ++y) {
    add(row(y + kHalf));
    float* out = &board.grain[static_cast<std::size_t>(y) * along];
    const float* gone = row(y - kHalf);
    for (std::size_t x = 0; x < along; ++x) {
      out[x] -= static_cast<float>(sums[x] / (2 * kHalf + 1));
      sums[x] -= gone[x];
    }
  }
}

// Every second texel of every second row: the original reads its photograph unfiltered, so that the
// grain stays crisp far away.
Board coarser(const Board& finer) {
  Board board = {finer.along / 2, finer.across / 2, {}};
  for (int y = 0; y < board.across; ++y) {
    const float* row = &finer.grain[static_cast<std::size_t>(2 * y * finer.along)];
    for (int x = 0; x < board.along; ++x) board.grain.push_back(row[2 * x]);
  }
  return board;
}

// Paints every level with one contrast. A difference of 1 is a brightness of kScale.
void paint(const Board& board, std::uint8_t* out) {
  constexpr float kContrast = 0.094F;  // standard deviation
  constexpr float kScale = 300;
  double sum = 0;
  double squares = 0;
  for (const float value : board.grain) {
    sum += value;
    squares += value * value;
  }
  const auto count = static_cast<double>(board.grain.size());
  const auto mean = static_cast<float>(sum / count);
  const auto spread = static_cast<float>(std::sqrt(squares / count - sum / count * sum / count));
  std::vector<Waves> along;
  along.reserve(static_cast<std::size_t>(board.along));
  for (int x = 0; x < board.along; ++x) along.push_back(waves(place_of(x, board.along)));
  for (int y = 0; y < board.across; ++y) {
    const Waves across = waves(place_of(y, board.across));
    Waves row = {};
    for (std::size_t i = 0; i < kWaves; ++i) {
      for (std::size_t k = 0; k < kWaves; ++k) row[k] += across[i] * kFigure[i][k];
    }
    for (int x = 0; x < board.along; ++x) {
      const auto at = static_cast<std::size_t>(y * board.along + x);
      const Waves& column = along[static_cast<std::size_t>(x)];
      float figure = 0;
      for (std::size_t k = 0; k < kWaves; ++k) figure += row[k] * column[k];
      const float value = figure * (1 + kContrast * (board.grain[at] - mean) / spread) - 1;
      const float level = WoodTexture::kMean + kScale * value;
      out[at] = static_cast<std::uint8_t>(std::lround(std::clamp(level, 0.0F, 255.0F)));
    }
  }
}

std::vector<std::uint8_t> paint_all(const WoodTexture& texture, std::size_t size) {
  std::vector<std::uint8_t> texels(size);
  Board board = finest();
  level_out(board);
  for (int level = 0; level < WoodTexture::kLevels; ++level) {
    if (level > 0) board = coarser(board);
    paint(board, &texels[static_cast<std::size_t>(texture.offset[level])]);
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
  static std::vector<std::uint8_t> texels;
  const std::lock_guard lock(process_mutex(ProcessLock::kTextures));
  if (texels.empty()) texels = paint_all(texture, static_cast<std::size_t>(size + kSlack));
  texture.texels = texels.data();
  return texture;
}

}  // namespace engram::cpu
