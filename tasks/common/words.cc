#include "tasks/common/words.h"

#include <cmath>
#include <numbers>

#include "core/base/index.h"
#include "core/observe/object_words.h"
#include "mjcf/object_descriptor.h"
#include "tasks/common/poses.h"

namespace engram::tasks {

std::string enumerate(std::span<const std::string> items) {
  std::string text;
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (i > 0) text += i + 1 == items.size() ? " and " : ", ";
    text += items[i];
  }
  return text;
}

std::string name_object(const mjcf::Prop& prop, NamedBy by) {
  const ObjectDescriptor look = mjcf::describe_object(prop);
  const std::string noun = by.shape ? shape_word(look.shape) : "cube";
  return by.color ? std::string(kObjectColorNames[at(look.color)]) + " " + noun : noun;
}

std::string name_color(const mjcf::Rgba& rgba) {
  return std::string(kObjectColorNames[at(nearest_object_color(rgba[0], rgba[1], rgba[2]))]);
}

std::string in_centimetres(double metres) {
  return std::to_string(std::lround(100 * metres)) + " cm";
}

std::string in_degrees(double radians) {
  return std::to_string(std::lround(radians * 180 / std::numbers::pi)) + " degrees";
}

bool tool_is_at(const State& state, int env, const Eigen::Vector3d& point, double radius) {
  return (tcp_pos(state, env) - point).norm() < radius;
}

}  // namespace engram::tasks
