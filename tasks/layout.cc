#include "tasks/layout.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

namespace engram::tasks {
namespace {

constexpr double kJitter = 0.01;        // m: 0.5 x 0.02
constexpr double kSlotDistance = 0.06;  // m: 3 x 0.02
constexpr int kJitterAttempts = 50;
constexpr double kSpreadJitter = 0.012;  // m: 0.6 x 0.02
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

Layout nominal_slots(int count) {
  Layout slots;
  const int middle = count / 2;
  for (int key = 0; key < count; ++key) {
    if (count == 3) {
      slots.push_back({0.0, -(key - 1) * 0.1});
      continue;
    }
    const double angle = std::numbers::pi * (key - middle) / count;
    slots.push_back({0.3 * std::cos(angle) - 0.25, 0.3 * std::sin(angle) - (key - middle) * 0.025});
  }
  return slots;
}

Layout jitter_slots(const Layout& nominal, RandomStream& random) {
  Layout slots = nominal;
  for (std::size_t i = 0; i < slots.size(); ++i) {
    for (int attempt = 0; attempt < kJitterAttempts; ++attempt) {
      const Vec2 candidate = nominal[i] + normal_pair(kJitter, random);
      if (!keeps_distance(candidate, slots, i, kSlotDistance)) continue;
      slots[i] = candidate;
      break;
    }
  }
  return slots;
}

Layout assign_slots(const Layout& slots, RandomStream& random) {
  std::array<int, Layout::kCapacity> storage{};
  const std::span permutation(storage.data(), slots.size());
  random.permutation(permutation);
  Layout layout;
  for (const int slot : permutation) layout.push_back(slots[static_cast<std::size_t>(slot)]);
  return layout;
}

void spread_and_stretch(Layout& layout, const SpreadParams& params, RandomStream& random) {
  for (std::size_t key = 0; key < layout.size(); ++key) {
    for (int attempt = 0; attempt < kSpreadAttempts; ++attempt) {
      if (keeps_distance(layout[key], layout, key, params.MANIP_MIN_DISTANCE)) break;
      layout[key] += normal_pair(kSpreadJitter, random);
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
