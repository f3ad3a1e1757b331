#include "tasks/common/colors.h"

#include <charconv>
#include <string>

namespace engram::tasks {

Constant published_color(const mjcf::Rgba& rgba) {
  ConstantList list;
  for (const double value : rgba) {
    // The decimal number that single precision prints.
    std::array<char, 32> text{};
    const auto written =
        std::to_chars(text.data(), text.data() + text.size(), static_cast<float>(value));
    double shown = 0;
    std::from_chars(text.data(), written.ptr, shown);
    list.emplace_back(shown);
  }
  return list;
}

Constant color_mapping_constant() {
  ConstantTable table;
  for (std::size_t key = 0; key < COLOR_MAPPING.size(); ++key) {
    const NamedColor& color = COLOR_MAPPING[key];
    const ConstantList rgba(color.rgba.begin(), color.rgba.end());
    table.emplace_back(std::to_string(key), ConstantList{color.name, rgba});
  }
  return table;
}

}  // namespace engram::tasks
