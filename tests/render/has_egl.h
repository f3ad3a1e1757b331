// For tests that need OpenGL.
#pragma once

#include <catch2/catch.hpp>

#include "render/egl/context.h"

namespace engram {

// Says so and returns false where images cannot be drawn.
inline bool has_egl() {
  static const EglInfo info = query_egl();
  if (!info.available) WARN("skipped: " << info.problem);
  return info.available;
}

}  // namespace engram
