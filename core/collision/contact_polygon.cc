#include "core/collision/contact_polygon.h"

#include <algorithm>

namespace engram {

void ContactPolygon::clip(double cosine, double sine, double limit) {
  std::array<double, kCapacity> beyond;
  bool inside = true;
  for (int i = 0; i < size_; ++i) {
    beyond[at(i)] = (*this)[i].x() * cosine + (*this)[i].y() * sine - limit;
    inside = inside && beyond[at(i)] <= 0;
  }
  if (inside) return;
  const int count = size_;
  std::array<Vec3, kCapacity> before;
  std::copy_n(points_.begin(), count, before.begin());
  size_ = 0;
  for (int i = 0; i < count; ++i) {
    const int next = i + 1 < count ? i + 1 : 0;
    const Vec3& from = before[at(i)];
    const Vec3& to = before[at(next)];
    const double out_from = beyond[at(i)];
    const double out_to = beyond[at(next)];
    if (out_from <= 0) push(from);
    if ((out_from < 0 && out_to > 0) || (out_from > 0 && out_to < 0)) {
      push(from + (to - from) * (out_from / (out_from - out_to)));
    }
  }
}

void ContactPolygon::reduce_to_four() {
  if (size_ <= 4) return;
  const auto gap = [&](int i) { return points_[at(i)].z(); };
  int deepest = 0;
  for (int i = 1; i < size_; ++i) deepest = gap(i) < gap(deepest) ? i : deepest;
  const auto squared = [&](int i) {
    return (points_[at(i)] - points_[at(deepest)]).head<2>().squaredNorm();
  };
  int farthest = 0;
  for (int i = 1; i < size_; ++i) farthest = squared(i) > squared(farthest) ? i : farthest;
  const Vec3 edge = points_[at(farthest)] - points_[at(deepest)];
  const auto across = [&](int i) {
    const Vec3 offset = points_[at(i)] - points_[at(deepest)];
    return edge.x() * offset.y() - edge.y() * offset.x();
  };
  int left = 0;
  int right = 0;
  for (int i = 1; i < size_; ++i) {
    left = across(i) > across(left) ? i : left;
    right = across(i) < across(right) ? i : right;
  }
  std::array<int, 4> chosen = {deepest, farthest, -1, -1};
  int count = 2;
  for (const int i : {left, right}) {
    if (std::find(chosen.begin(), chosen.begin() + count, i) == chosen.begin() + count) {
      chosen[at(count++)] = i;
    }
  }
  std::array<Vec3, 4> kept;
  for (int i = 0; i < count; ++i) kept[at(i)] = points_[at(chosen[at(i)])];
  std::copy_n(kept.begin(), count, points_.begin());
  size_ = count;
}

}  // namespace engram
