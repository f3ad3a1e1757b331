// A few images of an episode whose length is not known in advance: the stride doubles as it grows.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/batch/scene_renderer.h"
#include "protocol/io/bytes.h"
#include "protocol/make/make.h"

namespace engram {

class SampleImages {
 public:
  static constexpr int kSide = 128;  // pixels
  static constexpr int kImages = 5;  // in the strip

  // After the reset and after every step.
  void sample(const Batch& batch, int index);
  // The strip: base camera from the first to the last sample.
  Bytes png() const;

 private:
  struct Image {
    int step;
    std::vector<std::uint8_t> rgb;
  };

  void capture(const Batch& batch, int index);

  std::optional<SceneRenderer> renderer_;  // from the first image that needs it on
  std::vector<Image> images_;
  int stride_ = 1;  // steps between two of them
};

}  // namespace engram
