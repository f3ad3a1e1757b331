// The guard against objects that would appear inside one another.
//
// `clearance(first, second, offset)` is the smallest horizontal gap between two objects, m, given
// the vector from the first to the second; negative where they overlap.
#pragma once

#include <algorithm>

#include "tasks/common/layout.h"

namespace engram::tasks {

inline constexpr double kMinClearance = 0.001;     // m
inline constexpr double kExtraClearance = 0.0001;  // m, so that a separated pair stays separated
inline constexpr int kLayoutDraws = 50;
inline constexpr int kSeparationPasses = 200;

// Gap between two axis-aligned squares of the same half size.
inline double square_clearance(double half_size, const Vec2& offset) {
  const Vec2 gap = (offset.array().abs() - 2 * half_size).matrix();
  if (gap.x() < 0 && gap.y() < 0) return gap.maxCoeff();
  return gap.cwiseMax(0.0).norm();
}

template <class Clearance>
bool is_clear(const Layout& layout, const Clearance& clearance) {
  for (std::size_t i = 0; i < layout.size(); ++i) {
    for (std::size_t j = i + 1; j < layout.size(); ++j) {
      if (clearance(i, j, layout[j] - layout[i]) < kMinClearance) return false;
    }
  }
  return true;
}

// Moves pairs that are too close apart along the line between them, until none is.
template <class Clearance>
void separate(Layout& layout, const Clearance& clearance) {
  for (int pass = 0; pass < kSeparationPasses; ++pass) {
    bool moved = false;
    for (std::size_t i = 0; i < layout.size(); ++i) {
      for (std::size_t j = i + 1; j < layout.size(); ++j) {
        const Vec2 offset = layout[j] - layout[i];
        const double gap = clearance(i, j, offset);
        if (gap >= kMinClearance) continue;
        const Vec2 direction = offset.norm() > 1e-9 ? Vec2(offset.normalized()) : Vec2(1, 0);
        const Vec2 half = 0.5 * (kMinClearance - gap + kExtraClearance) * direction;
        layout[i] -= half;
        layout[j] += half;
        moved = true;
      }
    }
    if (!moved) return;
  }
}

// Draws layouts until one is clear, at most 50, and separates the last one if none was.
template <class DrawLayout, class Clearance>
Layout draw_clear_layout(const DrawLayout& draw, const Clearance& clearance) {
  Layout layout;
  for (int i = 0; i < kLayoutDraws; ++i) {
    layout = draw();
    if (is_clear(layout, clearance)) return layout;
  }
  separate(layout, clearance);
  return layout;
}

}  // namespace engram::tasks
