// The map that people see over images of TraceShape and TraceShapeSeq: the contour, its
// checkpoints, the green cube and its trail.
#pragma once

#include "core/base/column.h"
#include "core/image/overlay.h"
#include "tasks/trace_shape/contour.h"
#include "tasks/trace_shape/demo.h"

namespace engram::tasks {

class TraceMap {
 public:
  static constexpr double kTextScale = 0.6;

  // farthest_corner: of a shape, m from its centre.
  explicit TraceMap(double farthest_corner);

  void bind(ColumnStore& memory);
  // Adds the green cube's position to its trail where that grows noticeably.
  void note(int env, const Vec2& green) const;
  void draw(int env, const Contour& contour, int visited, const Vec2& green, Overlay& out) const;
  // Lines of text below the map; returns the baseline for the next one.
  static OverlayPoint caption(const Contour& contour, int visited, TracePhase phase, bool closed,
                              Overlay& out);

 private:
  OverlayPoint on_map(const Vec2& point, const Vec2& center) const;

  double reach_;                 // m: what is shown to either side of the shape's centre
  Column<float> trail_;          // (kTrail * 2) m, a ring of points
  Column<std::int32_t> length_;  // points since the episode began
};

}  // namespace engram::tasks
