// Images of what never moves, shared by all workers.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "render/cpu/frame_builder.h"
#include "render/cpu/frame_data.h"
#include "render/cpu/prepared_scene.h"

namespace engram::cpu {

// One for each camera that never moves, of the first size that it is asked for. The worker that
// asks first draws it; until it is there, others draw without, which gives the same pixels.
class Backdrops {
 public:
  // `max_pixels`: of the largest image. `segments`: they have those for colours.
  Backdrops(const PreparedScene& prepared, std::int64_t max_pixels, bool segments = false);

  // Null if there is none (yet) of that size. `view` and `row` are working memory; does not
  // allocate.
  const Backdrop* find(const RenderInstances& instances, int camera, int width, int height,
                       const Kernel& kernel, FrameBuilder& builder, TileRow& row);

 private:
  enum class Status { kNone, kEmpty, kBeingDrawn, kReady };
  struct BackdropSlot {
    std::atomic<Status> state = Status::kNone;
    int width = 0;
    int height = 0;
    Backdrop backdrop = {};
    std::unique_ptr<float[]> w;
    std::unique_ptr<std::uint32_t[]> color;
  };

  std::int64_t capacity_;
  bool segments_;
  std::vector<BackdropSlot> slots_;  // one per camera
};

}  // namespace engram::cpu
