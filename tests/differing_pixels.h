// Comparison of two environments by their images.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/batch/batch.h"
#include "core/batch/scene_renderer.h"

namespace engram::test {

// Images of two batches' first environments.
class ImagePair {
 public:
  ImagePair(const Batch& a, const Batch& b) : a_(a), b_(b) {}

  // Pixels in which a camera's images differ.
  int differing_pixels(const char* camera) {
    constexpr int kSide = 128;
    std::vector<std::uint8_t> first(kSide * kSide * 3);
    std::vector<std::uint8_t> second(first.size());
    a_.render(0, camera, kSide, kSide, first);
    b_.render(0, camera, kSide, kSide, second);
    int count = 0;
    for (std::size_t i = 0; i < first.size(); i += 3) {
      count += std::equal(&first[i], &first[i] + 3, &second[i]) ? 0 : 1;
    }
    return count;
  }

 private:
  SceneRenderer a_;
  SceneRenderer b_;
};

}  // namespace engram::test
