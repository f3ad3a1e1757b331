// A convex polygon of possible contact points: x and y in the plane of a reference face, z along
// its outward normal.
#pragma once

#include <array>

#include "core/base/index.h"
#include "core/math/eigen_types.h"

namespace engram {

class ContactPolygon {
 public:
  static constexpr int kCapacity = 32;

  void push(const Vec3& point) {
    if (size_ < kCapacity) points_[at(size_++)] = point;
  }
  int size() const { return size_; }
  const Vec3& operator[](int i) const { return points_[at(i)]; }

  // Keeps the part with x cos + y sin <= limit.
  void clip(double cosine, double sine, double limit);
  // Keeps the deepest point, the farthest from it, and the extremes on both sides of the line
  // between.
  void reduce_to_four();

 private:
  std::array<Vec3, kCapacity> points_;
  int size_ = 0;
};

}  // namespace engram
