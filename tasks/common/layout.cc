#include "tasks/common/layout.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include "core/base/index.h"
#include "core/math/real_functions.h"

namespace engram::tasks {
namespace {

// In sizes of the objects.
constexpr double kJitter = 0.5;
constexpr double kSlotDistance = 3;
constexpr double kSpreadJitter = 0.6;
constexpr int kJitterAttempts = 50;
constexpr int kLayoutAttempts = 20;
constexpr int kSpreadAttempts = 80;

Vec2 normal_pair(double deviation, RandomStream& random) {
  const double x = random.normal();
  return deviation * Vec2(x, random.normal());
}

// True if the point keeps `distance` from the first `count` points.
bool keeps_distance(const Vec2& point, const Layout& others, std::size_t count, double distance) {
  return std::all_of(others.begin(), others.begin() + count,
                     [&](const Vec2& other) { return (point - other).norm() >= distance; });
}

}  // namespace

double min_distance(const Layout& layout) {
  double least = std::numeric_limits<double>::max();
  for (std::size_t i = 0; i < layout.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      least = std::min(least, (layout[i] - layout[j]).squaredNorm());
    }
  }
  return std::sqrt(least);
}

Layout nominal_slots(int count, const ArcParams& arc) {
  Layout slots;
  for (int key = 0; key < count; ++key) {
    const double step = key - 0.5 * (count - 1);  // from the middle
    if (count == 3) {
      slots.push_back({0.0, -step * 0.1});
      continue;
    }
    const double angle = std::numbers::pi * step / count;
    slots.push_back({arc.radius * real::cos(angle) - 0.25,
                     arc.radius * real::sin(angle) - step * arc.compression});
  }
  return slots;
}

Layout jitter_slots(const Layout& nominal, double size, RandomStream& random) {
  Layout slots = nominal;
  for (std::size_t i = 0; i < slots.size(); ++i) {
    for (int attempt = 0; attempt < kJitterAttempts; ++attempt) {
      const Vec2 candidate = nominal[i] + normal_pair(kJitter * size, random);
      if (!keeps_distance(candidate, slots, i, kSlotDistance * size)) continue;
      slots[i] = candidate;
      break;
    }
  }
  return slots;
}

Layout jitter_layout(const Layout& nominal, double size, RandomStream& random) {
  Layout best;
  double best_distance = -1;
  for (int attempt = 0; attempt < kLayoutAttempts && best_distance < kSlotDistance * size;
       ++attempt) {
    Layout candidate;
    for (const Vec2& slot : nominal)
      candidate.push_back(slot + normal_pair(kJitter * size, random));
    const double distance = min_distance(candidate);
    if (distance <= best_distance) continue;
    best = candidate;
    best_distance = distance;
  }
  return best;
}

Layout assign_slots(const Layout& slots, RandomStream& random) {
  std::array<int, Layout::kCapacity> storage{};
  const std::span permutation(storage.data(), slots.size());
  random.permutation(permutation);
  Layout layout;
  for (const int slot : permutation) layout.push_back(slots[at(slot)]);
  return layout;
}

void spread_and_stretch(Layout& layout, const SpreadParams& params, double size,
                        RandomStream& random) {
  for (std::size_t key = 0; key < layout.size(); ++key) {
    for (int attempt = 0; attempt < kSpreadAttempts; ++attempt) {
      if (keeps_distance(layout[key], layout, key, params.MANIP_MIN_DISTANCE)) break;
      layout[key] += normal_pair(kSpreadJitter * size, random);
    }
  }
  const Eigen::Index axis = params.MANIP_WIDTH_AXIS;
  const auto clamped = [&params](double y) {
    return std::clamp(y, -params.MANIP_WIDTH_CLAMP, params.MANIP_WIDTH_CLAMP);
  };
  double mean = 0;
  for (Vec2& point : layout) {
    point[axis] = clamped(point[axis]);
    mean += point[axis] / static_cast<double>(layout.size());
  }
  for (Vec2& point : layout) {
    point[axis] = clamped(mean + params.MANIP_WIDTH_SCALE * (point[axis] - mean));
  }
}

}  // namespace engram::tasks
