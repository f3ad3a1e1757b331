// Sheets of `engram record`: images of several steps side by side, each under its step.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "api/media.h"
#include "core/batch/batch.h"

namespace engram::apps {

// Steps at which phases of drawn lengths end in the batch's first environment.
std::vector<int> phase_changes(const Batch& batch);

// `count` steps of an episode, or all that it has if these are fewer: the last one, the first one,
// those of changes in order, and some between them, in ascending order.
std::vector<int> sheet_steps(int count, int last, std::span<const int> changes);

class RecordSheet {
 public:
  // width, height: of an image.
  RecordSheet(int images, int width, int height);

  int width() const { return canvas_.width(); }
  int height() const { return canvas_.height(); }
  void add(int step, std::span<const std::uint8_t> rgb);
  std::vector<std::uint8_t> rgb() const { return canvas_.rgb(); }

 private:
  int columns_;
  int image_width_;
  int image_height_;
  int gutter_;
  int label_;  // height of a label, above its image
  int added_ = 0;
  Canvas canvas_;
};

}  // namespace engram::apps
