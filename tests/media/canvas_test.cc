#include "media/canvas.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

#include "core/base/error.h"

namespace engram {
namespace {

using Bytes = std::vector<std::uint8_t>;

Color pixel(const Canvas& canvas, int x, int y) {
  const Bytes rgb = canvas.rgb();
  const auto at = 3 * static_cast<std::size_t>(y * canvas.width() + x);
  return {rgb[at], rgb[at + 1], rgb[at + 2]};
}

int count(const Canvas& canvas, Color color) {
  int found = 0;
  const Bytes rgb = canvas.rgb();
  for (std::size_t i = 0; i < rgb.size(); i += 3) {
    if (Color{rgb[i], rgb[i + 1], rgb[i + 2]} == color) ++found;
  }
  return found;
}

Bytes gradient(int width, int height) {
  Bytes rgb;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (const int value : {x, y, x + y}) rgb.push_back(static_cast<std::uint8_t>(value));
    }
  }
  return rgb;
}

constexpr Color kGrey = {90, 100, 110};

// The smallest box around all pixels of a colour: left, top, right, bottom.
std::array<int, 4> bounds(const Canvas& canvas, Color color) {
  std::array<int, 4> box = {canvas.width(), canvas.height(), -1, -1};
  const Bytes rgb = canvas.rgb();
  for (int y = 0; y < canvas.height(); ++y) {
    for (int x = 0; x < canvas.width(); ++x) {
      const auto at = 3 * static_cast<std::size_t>(y * canvas.width() + x);
      if (Color{rgb[at], rgb[at + 1], rgb[at + 2]} != color) continue;
      box = {std::min(box[0], x), std::min(box[1], y), std::max(box[2], x), std::max(box[3], y)};
    }
  }
  return box;
}

}  // namespace

TEST_CASE("canvas: images come out as they went in, cut off at the edges", "[render]") {
  const Bytes image = gradient(40, 30);
  Canvas same(40, 30);
  same.blit(0, 0, 40, 30, image);
  CHECK(same.rgb() == image);

  Canvas canvas(20, 20, kGrey);
  canvas.blit(-10, 15, 40, 30, image);
  CHECK(pixel(canvas, 0, 14) == kGrey);
  CHECK(pixel(canvas, 0, 15) == Color{10, 0, 10});
  CHECK(pixel(canvas, 19, 19) == Color{29, 4, 33});
  canvas.blit(50, 50, 40, 30, image);
  canvas.blit(-50, -50, 40, 30, image);
  CHECK(pixel(canvas, 0, 14) == kGrey);

  Bytes copy(3 * 40 * 30);
  same.copy_to(copy);
  CHECK(copy == image);
}

TEST_CASE("canvas: wrong lengths and sizes are refused", "[render]") {
  Canvas canvas(8, 8);
  Bytes bytes(3 * 8 * 8 - 1);
  CHECK_THROWS_AS(canvas.blit(0, 0, 8, 8, bytes), Error);
  CHECK_THROWS_AS(canvas.copy_to(bytes), Error);
  CHECK_THROWS_WITH(Canvas(0, 8), Catch::Contains("0 x 8"));
  CHECK_THROWS_WITH(Canvas(8, 40000), Catch::Contains("32767"));
}

TEST_CASE("canvas: scaling fills the target and nothing else", "[render]") {
  const Bytes flat(3 * 16 * 16, 200);
  Canvas canvas(64, 64, kGrey);
  canvas.blit_scaled({16, 16, 32, 32}, 16, 16, flat);
  CHECK(count(canvas, {200, 200, 200}) == 32 * 32);
  CHECK(count(canvas, kGrey) == 64 * 64 - 32 * 32);

  // Smaller: means of what falls together, such as every second row of black and white.
  Bytes stripes(3 * 64 * 64, 0);
  for (std::size_t y = 0; y < 64; y += 2) std::fill_n(stripes.begin() + 192 * y, 192, 255);
  Canvas small(16, 16);
  small.blit_scaled({0, 0, 16, 16}, 64, 64, stripes);
  CHECK(std::abs(pixel(small, 8, 8).red - 128) < 12);
}

TEST_CASE("canvas: text is white with a dark outline, as tall as it should be", "[render]") {
  Canvas canvas(200, 80, kGrey);
  canvas.text({10, 50}, "HEI");
  const auto [left, top, right, bottom] = bounds(canvas, kWhite);
  CHECK(bottom == 49);  // the baseline is the edge below
  CHECK(std::abs(top - (50 - 21)) <= 1);
  CHECK(std::abs(left - 13) <= 2);
  CHECK(right < 80);
  CHECK(count(canvas, kOutline) > 50);
  CHECK(count(canvas, kWhite) > 50);

  Canvas large(400, 160, kGrey);
  large.text({20, 100}, "HEI", 2);
  CHECK(std::abs(bounds(large, kWhite)[1] - 58) <= 1);

  Canvas again(200, 80, kGrey);
  again.text({10, 50}, "HEI");
  CHECK(again.rgb() == canvas.rgb());
}

TEST_CASE("canvas: shapes", "[render]") {
  Canvas canvas(64, 64, kGrey);
  canvas.swatch({10, 20}, 22, {255, 0, 0}, kWhite);
  CHECK(bounds(canvas, kWhite) == std::array<int, 4>{10, 20, 31, 41});
  CHECK(bounds(canvas, {255, 0, 0}) == std::array<int, 4>{12, 22, 29, 39});
  CHECK(count(canvas, {255, 0, 0}) == 18 * 18);

  canvas.fill({0, 0, 64, 64}, {0, 0, 0, 0.5});
  CHECK(std::abs(pixel(canvas, 60, 60).red - 45) <= 1);
  canvas.fill({0, 0, 64, 64}, kBlack);
  canvas.disc({32, 32}, 10, {0, 255, 0});
  CHECK(std::abs(count(canvas, {0, 255, 0}) - 285) < 40);  // whole pixels of 314
  const Point corner[] = {{4, 4}, {4, 60}, {60, 60}};
  canvas.line(corner, 4, {0, 0, 255});
  CHECK(pixel(canvas, 4, 30) == Color{0, 0, 255});
  CHECK(pixel(canvas, 30, 60) == Color{0, 0, 255});
  CHECK(pixel(canvas, 30, 10) == kBlack);
}

}  // namespace engram
