#include "core/task/object_descriptor.h"

#include <algorithm>

namespace engram {
namespace {

constexpr double kBlack = 0.12;      // the strongest component of what is black
constexpr double kPale = 0.35;       // saturation of what has no hue
constexpr double kLightGrey = 0.75;  // from there on it is white
constexpr double kDarkGrey = 0.25;   // below it is black
constexpr double kDepthWeight = 0.7;

enum Color : int { kRed, kWhite = 9, kGreyColor = 10, kBlackColor = 11 };

// Hue, as a colour whose least component is 0 and greatest 1, and depth: the greatest component.
struct Hue {
  std::array<double, 3> rgb;
  double depth;
};
constexpr std::array<Hue, 9> kHues = {{{{1, 0, 0}, 1},
                                       {{0, 1, 0}, 1},
                                       {{0, 0, 1}, 1},
                                       {{1, 1, 0}, 1},
                                       {{1, 0, 1}, 1},
                                       {{0, 1, 1}, 1},
                                       {{1, 0, 0}, 0.5},
                                       {{1, 0.5, 0}, 1},
                                       {{0, 1, 1}, 0.5}}};

}  // namespace

int nearest_object_color(double red, double green, double blue) {
  const double least = std::min({red, green, blue});
  const double most = std::max({red, green, blue});
  if (most < kBlack) return kBlackColor;
  if (most - least < kPale * most) {
    return most >= kLightGrey ? kWhite : most >= kDarkGrey ? kGreyColor : kBlackColor;
  }
  const std::array<double, 3> rgb = {(red - least) / (most - least),
                                     (green - least) / (most - least),
                                     (blue - least) / (most - least)};
  const auto distance = [&](const Hue& hue) {
    const double depth = kDepthWeight * (hue.depth - most);
    double sum = depth * depth;
    for (std::size_t i = 0; i < 3; ++i) sum += (rgb[i] - hue.rgb[i]) * (rgb[i] - hue.rgb[i]);
    return sum;
  };
  const auto* const nearest = std::ranges::min_element(kHues, {}, distance);
  return kRed + static_cast<int>(nearest - kHues.begin());
}

}  // namespace engram
