#include "apps/record_view.h"

#include "api/media.h"

namespace engram::apps {
namespace {

std::string camera_name(const std::string& camera) { return camera + "_camera"; }

}  // namespace

RecordView::RecordView(const Batch& batch, const ViewOptions& options)
    : batch_(batch), renderer_(batch), options_(options) {}

std::vector<std::uint8_t> RecordView::draw() {
  const bool all = options_.camera == "all";
  const int side = options_.height;
  Canvas canvas(options_.width, options_.height);
  const int width = all ? side : options_.width;
  draw_camera(all ? "render" : options_.camera, width, side);
  canvas.blit(0, 0, width, side, rgb_);
  if (options_.overlays) draw_overlays(width, side, canvas);
  if (all) {
    const int half = side / 2;
    draw_panel("base", "top", {side, 0, half}, canvas);
    draw_panel("hand", "wrist", {side, half, half}, canvas);
  }
  return canvas.rgb();
}

void RecordView::draw_camera(const std::string& name, int width, int height) {
  rgb_.resize(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  renderer_.render(0, camera_name(name), width, height, rgb_);
}

void RecordView::draw_overlays(int width, int height, Canvas& canvas) const {
  Overlay overlay = make_overlay(width, height);
  renderer_.overlay(0, overlay);
  add_step(overlay, batch_.state().elapsed[0]);
  add_reward(overlay, batch_.outputs().reward[0]);
  draw_overlay(overlay, {0, 0}, std::min(width, height), canvas);
}

void RecordView::draw_panel(const std::string& camera, const std::string& label, const Panel& panel,
                            Canvas& canvas) {
  const double side = panel.side;
  const Point corner{static_cast<double>(panel.x), static_cast<double>(panel.y)};
  const int size = options_.sensor_size > 0 ? options_.sensor_size : panel.side;
  draw_camera(camera, size, size);
  canvas.blit_scaled({corner.x, corner.y, side, side}, size, size, rgb_);
  Overlay overlay = make_overlay(panel.side, panel.side);
  overlay.add(OverlayText{{16, 40}, label});
  draw_overlay(overlay, corner, panel.side, canvas);
}

}  // namespace engram::apps
