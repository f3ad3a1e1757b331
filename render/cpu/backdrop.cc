#include "render/cpu/backdrop.h"

#include <algorithm>
#include <limits>

namespace engram::cpu {
namespace {

// Larger images have no backdrop.
constexpr std::int64_t kMaxPixels = 1 << 20;

void draw(const FrameData& frame, const Kernel& kernel, TileRow& row, int stride, float* w,
          std::uint32_t* color) {
  row.keeps_depth = true;
  for (row.y = 0; row.y < frame.height; row.y += kBlock) {
    row.rows = std::min(kBlock, frame.height - row.y);
    for (row.x = 0; row.x < stride; row.x += kPanelTiles * kBlock) {
      row.tiles = std::min(kPanelTiles, (stride - row.x) / kBlock);
      kernel.draw_tiles(frame, nullptr, row);
      for (int y = 0; y < row.rows; ++y) {
        const std::ptrdiff_t to = static_cast<std::ptrdiff_t>(row.y + y) * stride + row.x;
        const int from = y * row.pitch;
        std::copy_n(row.w + from, row.tiles * kBlock, w + to);
        std::copy_n(row.code + from, row.tiles * kBlock, color + to);
      }
    }
  }
  row.keeps_depth = false;
}

}  // namespace

Backdrops::Backdrops(const PreparedScene& prepared, std::int64_t max_pixels, bool segments)
    : capacity_(std::min(max_pixels, kMaxPixels)),
      segments_(segments),
      slots_(prepared.scene.cameras.size()) {
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    if (!prepared.scene.cameras[i].still || capacity_ == 0) continue;
    // Pages that no image needs are never touched.
    slots_[i].w = std::make_unique_for_overwrite<float[]>(static_cast<std::size_t>(capacity_));
    slots_[i].color =
        std::make_unique_for_overwrite<std::uint32_t[]>(static_cast<std::size_t>(capacity_));
    slots_[i].state = Status::kEmpty;
  }
}

const Backdrop* Backdrops::find(const RenderInstances& instances, int camera, int width, int height,
                                const Kernel& kernel, FrameBuilder& builder, TileRow& row) {
  BackdropSlot& slot = slots_[static_cast<std::size_t>(camera)];
  Status state = slot.state.load(std::memory_order_acquire);
  if (state == Status::kEmpty && static_cast<std::int64_t>(padded(width)) * height <= capacity_ &&
      slot.state.compare_exchange_strong(state, Status::kBeingDrawn)) {
    slot.width = width;
    slot.height = height;
    constexpr float kNone = -std::numeric_limits<float>::infinity();
    slot.backdrop = {slot.w.get(), slot.color.get(), padded(width), {kNone, 0, 0}};
    const FrameData& frame = builder.build(instances, camera, width, height, Shown::kStill);
    draw(segments_ ? builder.segmented() : frame, kernel, row, slot.backdrop.stride, slot.w.get(),
         slot.color.get());
    if (!builder.ranks().empty()) slot.backdrop.last = builder.ranks().back();
    slot.state.store(Status::kReady, std::memory_order_release);
    state = Status::kReady;
  }
  if (state != Status::kReady || slot.width != width || slot.height != height) return nullptr;
  return &slot.backdrop;
}

}  // namespace engram::cpu
