#include "media/video_palette.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace engram {
namespace {

using Vec = std::array<double, 3>;

struct WeightedColor {
  Vec rgb;
  double weight;  // for splitting
  double count;   // for the mean
};

// Colours that one palette entry stands for.
struct ColorBox {
  std::size_t begin = 0;
  std::size_t end = 0;
  int axis = 0;      // of the largest spread
  double mean = 0;   // on it
  double error = 0;  // squared, on it
};

ColorBox make_box(const std::vector<WeightedColor>& colors, std::size_t begin, std::size_t end) {
  double weight = 0;
  Vec sum = {};
  Vec squares = {};
  for (std::size_t i = begin; i < end; ++i) {
    weight += colors[i].weight;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double value = colors[i].rgb[axis];
      sum[axis] += colors[i].weight * value;
      squares[axis] += colors[i].weight * value * value;
    }
  }
  ColorBox box{begin, end};
  for (int axis = 0; axis < 3; ++axis) {
    const auto at = static_cast<std::size_t>(axis);
    const double error = squares[at] - sum[at] * sum[at] / weight;
    if (error > box.error) box = {begin, end, axis, sum[at] / weight, error};
  }
  return box;
}

std::vector<WeightedColor> weighted_colors(const ColorHistogram& histogram) {
  std::vector<WeightedColor> colors;
  for (const ColorHistogram::Bin& bin : histogram.bins()) {
    if (bin.count == 0) continue;
    const auto count = static_cast<double>(bin.count);
    WeightedColor color{{}, std::sqrt(count), count};
    for (std::size_t i = 0; i < 3; ++i) color.rgb[i] = static_cast<double>(bin.sum[i]) / count;
    colors.push_back(color);
  }
  return colors;
}

PaletteColor mean_color(const std::vector<WeightedColor>& colors, const ColorBox& box) {
  Vec sum = {};
  double count = 0;
  for (std::size_t i = box.begin; i < box.end; ++i) {
    count += colors[i].count;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      sum[axis] += colors[i].count * colors[i].rgb[axis];
    }
  }
  PaletteColor color = {};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    color[axis] = static_cast<std::uint8_t>(std::lround(sum[axis] / count));
  }
  return color;
}

// Thresholds of 0 to 63, every one once (Bayer's matrix).
int threshold(int x, int y) {
  int value = 0;
  for (int bit = 0; bit < 3; ++bit) {
    const int across = (x >> bit) & 1;
    const int down = (y >> bit) & 1;
    value |= ((across ^ down) << 1 | down) << (2 * (2 - bit));
  }
  return value;
}

constexpr int kDither = 8;  // levels between the lowest and the highest threshold

}  // namespace

void ColorHistogram::add(std::span<const std::uint8_t> rgb) {
  for (std::size_t i = 0; i + 2 < rgb.size(); i += 3) {
    Bin& bin = bins_[bin_of(rgb[i], rgb[i + 1], rgb[i + 2])];
    ++bin.count;
    for (std::size_t channel = 0; channel < 3; ++channel) bin.sum[channel] += rgb[i + channel];
  }
}

std::vector<PaletteColor> choose_palette(const ColorHistogram& histogram, int size) {
  std::vector<WeightedColor> colors = weighted_colors(histogram);
  std::vector<ColorBox> boxes;
  if (!colors.empty()) boxes.push_back(make_box(colors, 0, colors.size()));
  while (!boxes.empty() && boxes.size() < static_cast<std::size_t>(size)) {
    const auto worst =
        std::max_element(boxes.begin(), boxes.end(),
                         [](const ColorBox& a, const ColorBox& b) { return a.error < b.error; });
    const ColorBox box = *worst;
    const auto axis = static_cast<std::size_t>(box.axis);
    const auto begin = colors.begin();
    const auto middle = std::stable_partition(
        begin + static_cast<std::ptrdiff_t>(box.begin),
        begin + static_cast<std::ptrdiff_t>(box.end),
        [&](const WeightedColor& color) { return color.rgb[axis] < box.mean; });
    const auto split = static_cast<std::size_t>(middle - begin);
    if (box.error <= 0 || split == box.begin || split == box.end) break;
    *worst = make_box(colors, box.begin, split);
    boxes.push_back(make_box(colors, split, box.end));
  }
  std::vector<PaletteColor> palette;
  palette.reserve(boxes.size());
  for (const ColorBox& box : boxes) palette.push_back(mean_color(colors, box));
  return palette;
}

PaletteMap::PaletteMap(std::vector<PaletteColor> palette)
    : palette_(std::move(palette)), known_(std::size_t{1} << (3 * ColorHistogram::kBits), -1) {}

std::uint8_t PaletteMap::index_at(int x, int y, const std::uint8_t* rgb) {
  const int shift = kDither * (2 * threshold(x, y) - 63) / 128;
  const auto shifted = [shift](std::uint8_t value) { return std::clamp(value + shift, 0, 255); };
  const int red = shifted(rgb[0]);
  const int green = shifted(rgb[1]);
  const int blue = shifted(rgb[2]);
  std::int16_t& index = known_[ColorHistogram::bin_of(red, green, blue)];
  const auto middle = [](int value) { return (value & ~3) + 2; };  // of the bin
  if (index < 0) index = nearest(middle(red), middle(green), middle(blue));
  return static_cast<std::uint8_t>(index);
}

std::uint8_t PaletteMap::nearest(int red, int green, int blue) const {
  int best = std::numeric_limits<int>::max();
  std::size_t found = 0;
  for (std::size_t i = 0; i < palette_.size(); ++i) {
    const int r = palette_[i][0] - red;
    const int g = palette_[i][1] - green;
    const int b = palette_[i][2] - blue;
    const int distance = 3 * r * r + 4 * g * g + 2 * b * b;  // the eye sees green best
    if (distance < best) {
      best = distance;
      found = i;
    }
  }
  return static_cast<std::uint8_t>(found);
}

}  // namespace engram
