// What tests of variants read in a task's description and document.
#pragma once

#include <algorithm>
#include <cstdlib>
#include <string>
#include <string_view>

#include "core/task.h"
#include "core/task_constant.h"

namespace engram::test {

// A class constant as messages show it, or "".
inline std::string constant_text(const TaskInfo& info, std::string_view name) {
  for (const auto& [given, value] : info.constants) {
    if (given == name) return in_words(value);
  }
  return "";
}

// The first size of the first geom after that name in a scene's document.
inline double size_in(const std::string& document, const std::string& name) {
  const std::size_t body = document.find("\"" + name + "\"");
  const std::size_t size = document.find("size=\"", body);
  return size == std::string::npos ? -1 : std::atof(document.c_str() + size + 6);
}

}  // namespace engram::test
