// How far two environments look alike.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/env/batch.h"

namespace engram::test {

// Pixels in which a camera's pictures of two batches' first environments differ.
inline int differing_pixels(Batch& a, Batch& b, const char* camera) {
  std::vector<std::uint8_t> first(128 * 128 * 3);
  std::vector<std::uint8_t> second(first.size());
  a.render(0, camera, 128, 128, first);
  b.render(0, camera, 128, 128, second);
  int count = 0;
  for (std::size_t i = 0; i < first.size(); i += 3) {
    count += std::equal(&first[i], &first[i] + 3, &second[i]) ? 0 : 1;
  }
  return count;
}

}  // namespace engram::test
