#include "tasks/trace_shape/map.h"

#include <algorithm>
#include <string>

namespace engram::tasks {
namespace {

constexpr int kTrail = 64;           // points that are remembered
constexpr double kTrailStep = 0.01;  // m between two of them

constexpr OverlayPoint kCorner{10, 130};
constexpr double kSide = 160;     // pixels
constexpr double kReach = 0.22;   // m: shown to either side of a shape's centre, or more
constexpr double kMargin = 0.03;  // m around a shape
constexpr double kLineHeight = 24;

constexpr OverlayColor kContourColor{220, 220, 220};
constexpr OverlayColor kTrailColor{120, 200, 255};
constexpr OverlayColor kVisitedColor{60, 220, 60};
constexpr OverlayColor kUnvisitedColor{230, 120, 40};
constexpr OverlayColor kCubeColor{255, 255, 0};

const char* phase_name(TracePhase phase) {
  switch (phase) {
    case TracePhase::kPreDemo:
      return "PRE-DEMO";
    case TracePhase::kDemo:
      return "DEMO";
    case TracePhase::kAction:
      return "ACTION";
  }
  return "";
}

}  // namespace

TraceMap::TraceMap(double farthest_corner) : reach_(std::max(kReach, farthest_corner + kMargin)) {}

void TraceMap::bind(ColumnStore& memory) {
  trail_ = memory.add<float>("trail", 2 * kTrail, "m");
  length_ = memory.add<std::int32_t>("trail_length");
  memory.limit("trail_length", 0, 1'000'000'000);
}

void TraceMap::note(int env, const Vec2& green) const {
  float* trail = trail_.row(env);
  const int count = length_[env];
  if (count > 0) {
    const float* last = trail + 2 * ((count - 1) % kTrail);
    const Vec2 before(static_cast<double>(last[0]), static_cast<double>(last[1]));
    if ((green - before).norm() < kTrailStep) return;
  }
  float* next = trail + 2 * (count % kTrail);
  next[0] = static_cast<float>(green.x());
  next[1] = static_cast<float>(green.y());
  ++length_[env];
}

// View of a person behind the robot: x up, y to the left.
OverlayPoint TraceMap::on_map(const Vec2& point, const Vec2& center) const {
  const double scale = kSide / 2 / reach_;
  const Vec2 offset = (point - center).cwiseMax(-reach_).cwiseMin(reach_);
  return {kCorner.x + kSide / 2 - scale * offset.y(), kCorner.y + kSide / 2 - scale * offset.x()};
}

void TraceMap::draw(int env, const Contour& contour, int visited, const Vec2& green,
                    Overlay& out) const {
  const Vec2& center = contour.center();
  const ContourSet& set = contour.set();
  out.add(OverlayPanel{kCorner, kSide, kSide});
  OverlayLine outline{{}, 2, kContourColor};
  for (int i = 0; i <= set.waypoints(); ++i) {
    outline.points.push_back(on_map(contour.waypoint(i % set.waypoints()), center));
  }
  out.add(std::move(outline));

  OverlayLine trail{{}, 2, kTrailColor};
  const int count = length_[env];
  for (int i = std::max(0, count - kTrail); i < count; ++i) {
    const float* point = trail_.row(env) + 2 * (i % kTrail);
    trail.points.push_back(
        on_map({static_cast<double>(point[0]), static_cast<double>(point[1])}, center));
  }
  if (trail.points.size() > 1) out.add(std::move(trail));

  for (int i = 0; i < set.checkpoints(); ++i) {
    const bool seen = (visited >> i & 1) != 0;
    out.add(OverlayDisc{on_map(contour.checkpoint(i), center), 3,
                        seen ? kVisitedColor : kUnvisitedColor});
  }
  out.add(OverlayDisc{on_map(green, center), 4, kCubeColor});
}

OverlayPoint TraceMap::caption(const Contour& contour, int visited, TracePhase phase, bool closed,
                               Overlay& out) {
  OverlayPoint at{kCorner.x, kCorner.y + kSide};
  const auto write = [&](const std::string& text) {
    at.y += kLineHeight;
    out.add(OverlayText{at, text, kTextScale});
  };
  write(std::string(kContourNames[static_cast<std::size_t>(contour.shape())]) + " " +
        std::to_string(count_visits(visited)) + "/" + std::to_string(contour.set().checkpoints()));
  write(phase_name(phase));
  write(std::string("closed ") + (closed ? "YES" : "NO"));
  at.y += kLineHeight;
  return at;
}

}  // namespace engram::tasks
