// Pictures of what never moves, shared by all workers.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "render/cpu_frame.h"
#include "render/cpu_scene.h"
#include "render/cpu_view.h"

namespace engram::cpu {

// One for each camera that never moves, of the first size that it is asked for. The worker that
// asks first draws it; until it is there, others draw without, which gives the same pixels.
class Backdrops {
 public:
  // `most_pixels`: of the largest picture. `segments`: they have those for colours.
  Backdrops(const PreparedScene& prepared, std::int64_t most_pixels, bool segments = false);

  // Null if there is none (yet) of that size. `view` and `row` are working memory; does not
  // allocate.
  const Backdrop* find(const RenderInstances& instances, int camera, int width, int height,
                       const Kernel& kernel, View& view, TileRow& row);

 private:
  enum class State { kNone, kEmpty, kBeingDrawn, kReady };
  struct Slot {
    std::atomic<State> state = State::kNone;
    int width = 0;
    int height = 0;
    Backdrop backdrop = {};
    std::unique_ptr<float[]> w;
    std::unique_ptr<std::uint32_t[]> color;
  };

  std::int64_t capacity_;
  bool segments_;
  std::vector<Slot> slots_;  // one per camera
};

}  // namespace engram::cpu
