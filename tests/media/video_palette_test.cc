#include "media/video_palette.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <set>
#include <vector>

namespace engram {
namespace {

using Pixels = std::vector<std::uint8_t>;

int distance(const PaletteColor& a, const PaletteColor& b) {
  int most = 0;
  for (std::size_t i = 0; i < 3; ++i) most = std::max(most, std::abs(a[i] - b[i]));
  return most;
}

TEST_CASE("palette: few colours are kept as they are", "[media]") {
  ColorHistogram histogram;
  histogram.add(Pixels{150, 100, 60, 20, 60, 220, 150, 100, 60});
  const auto palette = choose_palette(histogram, 255);
  CHECK(std::set(palette.begin(), palette.end()) ==
        std::set<PaletteColor>{{150, 100, 60}, {20, 60, 220}});
  CHECK(choose_palette(ColorHistogram(), 255).empty());
}

TEST_CASE("palette: rare colours among many are kept", "[media]") {
  ColorHistogram histogram;
  Pixels browns;
  for (int i = 0; i < 100'000; ++i) {
    for (const int value : {100 + i % 97, 50 + i % 61, 20 + i % 31}) {
      browns.push_back(static_cast<std::uint8_t>(value));
    }
  }
  histogram.add(browns);
  Pixels rare;  // of a cube that is far away
  for (int i = 0; i < 40; ++i) rare.insert(rare.end(), {0, 255, 0, 255, 0, 255});
  histogram.add(rare);
  PaletteMap map(choose_palette(histogram, 64));
  CHECK(map.palette().size() == 64);
  for (const PaletteColor& color : {PaletteColor{0, 255, 0}, {255, 0, 255}, {148, 80, 35}}) {
    CHECK(distance(map.palette()[map.index_at(0, 0, color.data())], color) <= 16);
  }
}

TEST_CASE("palette: colours between two entries are dithered", "[media]") {
  PaletteMap map({{0, 0, 0}, {8, 8, 8}});
  const Pixels middle = {4, 4, 4};
  std::array<int, 2> count{};
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 8; ++x) ++count[map.index_at(x, y, middle.data())];
  }
  CHECK(count[0] > 8);
  CHECK(count[1] > 8);
}

}  // namespace
}  // namespace engram
