// The palette of a GIF, chosen for all of its frames (median cut by variance, Bayer dither).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace engram {

// Counts colours. Those whose channels agree in their six upper bits are counted together.
class ColorHistogram {
 public:
  static constexpr int kBits = 6;

  struct Bin {
    std::uint64_t count = 0;
    std::array<std::uint64_t, 3> sum = {};  // of the channels
  };

  ColorHistogram() : bins_(std::size_t{1} << (3 * kBits)) {}

  static std::size_t bin_of(int red, int green, int blue) {
    constexpr int kDropped = 8 - kBits;
    const int index =
        (red >> kDropped << 2 * kBits) | (green >> kDropped << kBits) | blue >> kDropped;
    return static_cast<std::size_t>(index);
  }

  void add(std::span<const std::uint8_t> rgb);
  const std::vector<Bin>& bins() const { return bins_; }

 private:
  std::vector<Bin> bins_;
};

using PaletteColor = std::array<std::uint8_t, 3>;

// At most `size` colours that are close to those of the histogram. Rare colours count for more than
// their share of pixels.
std::vector<PaletteColor> choose_palette(const ColorHistogram& histogram, int size);

// Finds palette indices, with an ordered dither, so that still parts of a video do not flicker.
class PaletteMap {
 public:
  explicit PaletteMap(std::vector<PaletteColor> palette);

  const std::vector<PaletteColor>& palette() const { return palette_; }
  std::uint8_t index_at(int x, int y, const std::uint8_t* rgb);

 private:
  std::uint8_t nearest(int red, int green, int blue) const;

  std::vector<PaletteColor> palette_;
  std::vector<std::int16_t> known_;  // by bin; negative: not looked up yet
};

}  // namespace engram
