#include "tasks/common/constant_forms.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>
#include <string>

#include "core/base/index.h"
#include "tasks/common/colors.h"

namespace engram::tasks {
namespace {

using Kind = TaskConstant::Kind;

// The values of a table whose keys are 0, 1, ..., in the order of the keys; nothing for any other.
std::optional<ConstantList> in_key_order(const ConstantTable& table) {
  constexpr std::size_t kMax = 100;  // no constant has nearly as many
  if (table.size() > kMax) return std::nullopt;
  ConstantList values(table.size());
  std::vector<bool> seen(table.size());
  for (const auto& [key, value] : table) {
    std::size_t place = 0;
    while (place < table.size() && key != std::to_string(place)) ++place;
    if (place == table.size() || seen[place]) return std::nullopt;
    seen[place] = true;
    values[place] = value;
  }
  return values;
}

// The name behind a number; anything else as it is.
Constant name_of(const TaskConstant& about, const Constant& given) {
  const auto* number = std::get_if<std::int64_t>(&given.value);
  const auto count = static_cast<std::int64_t>(about.names.size());
  if (number == nullptr || *number < 0 || *number >= count) return given;
  return about.names[static_cast<std::size_t>(*number)];
}

std::string lower_case(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char letter) {
    return static_cast<char>(std::tolower(letter));
  });
  return text;
}

// Colours with a name: by that of the class constant, too.
std::optional<mjcf::Rgba> color_named(const std::string& name) {
  for (const NamedColor& color : COLOR_MAPPING) {
    if (lower_case(name) == color.plain_name || lower_case(name) == lower_case(color.name)) {
      return to_rgba(color.rgba);
    }
  }
  return std::nullopt;
}

// Opaque red, green, blue from 0 to 1, with or without alpha.
std::optional<mjcf::Rgba> color_of_numbers(const ConstantList& list) {
  if (list.size() != 3 && list.size() != 4) return std::nullopt;
  mjcf::Rgba color{0, 0, 0, 1};
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::optional<double> value = as_number(list[i]);
    if (!value || !(*value >= 0 && *value <= 1)) return std::nullopt;
    color[i] = *value;
  }
  if (color[3] != 1) return std::nullopt;
  return color;
}

}  // namespace

std::optional<mjcf::Rgba> as_color(const Constant& kept) {
  if (const auto* name = std::get_if<std::string>(&kept.value)) return color_named(*name);
  if (const auto* list = std::get_if<ConstantList>(&kept.value)) return color_of_numbers(*list);
  return std::nullopt;
}

Constant kept_color(const mjcf::Rgba& color) {
  const Constant numbers = ConstantList{color[0], color[1], color[2]};
  for (const NamedColor& named : COLOR_MAPPING) {
    const mjcf::Rgba its = to_rgba(named.rgba);
    if (is_same_value(numbers, ConstantList{its[0], its[1], its[2]})) return named.plain_name;
  }
  return numbers;
}

Constant kept_form(const TaskConstant& about, const Constant& given) {
  if (about.kind != Kind::kNames && about.kind != Kind::kColors) return given;
  ConstantList values;
  if (const auto* table = std::get_if<ConstantTable>(&given.value)) {
    const std::optional<ConstantList> ordered = in_key_order(*table);
    if (!ordered) return given;
    values = *ordered;
  } else if (const auto* list = std::get_if<ConstantList>(&given.value)) {
    values = *list;
  } else {
    values.push_back(given);
  }
  for (Constant& value : values) {
    if (about.kind == Kind::kNames) {
      value = name_of(about, value);
    } else if (const std::optional<mjcf::Rgba> color = as_color(value)) {
      value = kept_color(*color);
    }
  }
  return values;
}

bool is_same_value(const Constant& one, const Constant& other) {
  const std::optional<double> number = as_number(one);
  const std::optional<double> other_number = as_number(other);
  if (number && other_number) {
    return static_cast<float>(*number) == static_cast<float>(*other_number);
  }
  if (const auto* list = std::get_if<ConstantList>(&one.value)) {
    const auto* others = std::get_if<ConstantList>(&other.value);
    return others != nullptr && std::ranges::equal(*list, *others, is_same_value);
  }
  if (const auto* table = std::get_if<ConstantTable>(&one.value)) {
    const auto* others = std::get_if<ConstantTable>(&other.value);
    return others != nullptr &&
           std::ranges::is_permutation(*table, *others, [](const auto& entry, const auto& wanted) {
             return entry.first == wanted.first && is_same_value(entry.second, wanted.second);
           });
  }
  return one == other;
}

}  // namespace engram::tasks
