// The nine colours that families share, and choices of colours.
#pragma once

#include <array>

#include "core/base/constant.h"
#include "core/base/index.h"
#include "mjcf/prop.h"

namespace engram::tasks {

struct NamedColor {
  const char* name;         // the class constant's
  std::array<int, 4> rgba;  // 0..255
  const char* plain_name;   // what users write
};

inline constexpr std::array<NamedColor, 9> COLOR_MAPPING = {{
    {"Red", {255, 0, 0, 255}, "red"},
    {"Lime", {0, 255, 0, 255}, "green"},
    {"Blue", {0, 0, 255, 255}, "blue"},
    {"Yellow", {255, 255, 0, 255}, "yellow"},
    {"Magenta", {255, 0, 255, 255}, "magenta"},
    {"Cyan", {0, 255, 255, 255}, "cyan"},
    {"Maroon", {128, 0, 0, 255}, "maroon"},
    {"Olive", {255, 128, 0, 255}, "olive"},  // really orange; the name is upstream's
    {"Teal", {0, 128, 128, 255}, "teal"},
}};

// 0..1 per channel.
constexpr mjcf::Rgba to_rgba(const std::array<int, 4>& bytes) {
  return {bytes[0] / 255.0, bytes[1] / 255.0, bytes[2] / 255.0, bytes[3] / 255.0};
}

// Opaque colours in an order.
class ColorList {
 public:
  static constexpr int kCapacity = 16;

  constexpr ColorList() = default;
  // The first `count` of COLOR_MAPPING.
  constexpr explicit ColorList(int count) : size_(count) {
    for (int i = 0; i < count; ++i) colors_[at(i)] = to_rgba(COLOR_MAPPING[at(i)].rgba);
  }

  constexpr int size() const { return size_; }
  constexpr const mjcf::Rgba& operator[](int i) const { return colors_[at(i)]; }
  constexpr void clear() { size_ = 0; }
  constexpr void push_back(const mjcf::Rgba& color) { colors_[at(size_++)] = color; }

 private:
  std::array<mjcf::Rgba, kCapacity> colors_{};
  int size_ = 0;
};

// A colour as a class constant; they are published in single precision.
Constant published_color(const mjcf::Rgba& rgba);

// COLOR_MAPPING as a class constant.
Constant color_mapping_constant();

}  // namespace engram::tasks
