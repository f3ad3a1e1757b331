// What tests of variants share: batches with other constants, and what a task's description and
// document say of them.
#pragma once

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <string>
#include <string_view>

#include "tests/env_helpers.h"

namespace engram::test {

// At the beginning of an episode.
inline std::unique_ptr<Batch> make_reset(const char* id, const ConstantTable& constants,
                                         const BatchOptions& options = {}) {
  auto batch = std::make_unique<Batch>(make_task(id, constants), options);
  batch->reset();
  return batch;
}

// A class constant as messages show it, or "".
inline std::string constant_text(const TaskInfo& info, std::string_view name) {
  for (const auto& [given, value] : published_constants(info.constants)) {
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
