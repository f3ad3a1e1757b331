#include "media/overlay.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string_view>

namespace engram {
namespace {

constexpr double kSide = 512;  // pixels of the side for which overlay units are defined

Color to_color(const OverlayColor& color) {
  return {color.red, color.green, color.blue, color.opacity};
}

class Painter {
 public:
  Painter(Point corner, double unit, Canvas& canvas)
      : corner_(corner), unit_(unit), canvas_(&canvas) {}

  void operator()(const OverlayText& item) const {
    canvas_->text(place(item.baseline), item.text, unit_ * item.scale, to_color(item.color));
  }
  void operator()(const OverlaySwatch& item) const {
    canvas_->swatch(place(item.corner), unit_ * item.size, to_color(item.color),
                    to_color(item.border), unit_);
  }
  void operator()(const OverlayPanel& item) const {
    const Point at = place(item.corner);
    canvas_->fill({at.x, at.y, unit_ * item.width, unit_ * item.height}, to_color(item.color));
  }
  void operator()(const OverlayLine& item) const {
    std::vector<Point> points;
    for (const OverlayPoint& point : item.points) points.push_back(place(point));
    canvas_->line(points, unit_ * item.width, to_color(item.color));
  }
  void operator()(const OverlayDisc& item) const {
    canvas_->disc(place(item.center), unit_ * item.radius, to_color(item.color));
  }

 private:
  Point place(const OverlayPoint& point) const {
    return {corner_.x + unit_ * point.x, corner_.y + unit_ * point.y};
  }

  Point corner_;
  double unit_;
  Canvas* canvas_;
};

bool reward_is_disabled() {
  const char* value = std::getenv("MIKASA_DISABLE_REWARD_OVERLAY");
  return value != nullptr && *value != '\0' && std::string_view(value) != "0";
}

}  // namespace

Overlay make_overlay(int width, int height) {
  const double side = std::min(width, height);
  return {kSide * width / side, kSide * height / side, {}};
}

void add_step(Overlay& overlay, int step) {
  overlay.add(OverlayText{{10, 30}, "Step: " + std::to_string(step)});
}

void add_reward(Overlay& overlay, double reward) {
  if (reward_is_disabled()) return;
  char text[64];
  std::snprintf(text, sizeof(text), "Reward: %.3f", reward);
  overlay.add(OverlayText{{10, 90}, text});
}

void draw_overlay(const Overlay& overlay, Point corner, int side, Canvas& canvas) {
  const Painter painter(corner, side / kSide, canvas);
  for (const OverlayItem& item : overlay.items) std::visit(painter, item);
}

}  // namespace engram
