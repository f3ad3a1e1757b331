// The nine colours that families share.
#pragma once

#include <array>

#include "core/base/constant.h"
#include "mjcf/prop.h"

namespace engram::tasks {

struct NamedColor {
  const char* name;
  std::array<int, 4> rgba;  // 0..255
};

inline constexpr std::array<NamedColor, 9> COLOR_MAPPING = {{
    {"Red", {255, 0, 0, 255}},
    {"Lime", {0, 255, 0, 255}},
    {"Blue", {0, 0, 255, 255}},
    {"Yellow", {255, 255, 0, 255}},
    {"Magenta", {255, 0, 255, 255}},
    {"Cyan", {0, 255, 255, 255}},
    {"Maroon", {128, 0, 0, 255}},
    {"Olive", {255, 128, 0, 255}},  // really orange; the name is upstream's
    {"Teal", {0, 128, 128, 255}},
}};

// 0..1 per channel.
mjcf::Rgba to_rgba(const std::array<int, 4>& bytes);

// A colour as a class constant; they are published in single precision.
Constant published_color(const mjcf::Rgba& rgba);

// COLOR_MAPPING as a class constant.
Constant color_mapping_constant();

}  // namespace engram::tasks
