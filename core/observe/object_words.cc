#include "core/observe/object_words.h"

#include <cmath>
#include <cstdlib>
#include <string_view>

#include "core/base/index.h"
#include "core/task/object_descriptor.h"

namespace engram {

std::string shape_word(int shape) {
  if (shape < 0) return "object";
  const std::string_view name = kObjectShapeNames[at(shape)];
  if (name == "pyramide") return "pyramid";
  if (name == "t_shape") return "T shape";
  return std::string(name);
}

std::string in_metres(double metres) {
  const long whole = std::lround(100 * metres);
  const std::string digits = std::to_string(100 + std::labs(whole) % 100).substr(1);
  return (whole < 0 ? "-" : "") + std::to_string(std::labs(whole) / 100) + "." + digits + " m";
}

}  // namespace engram
