// Contact points of a pair of shapes A and B.
#pragma once

#include <array>
#include <cstddef>

#include "core/base/index.h"
#include "core/math/eigen_types.h"

namespace engram {

struct ContactPoint {
  Vec3 pos;     // on the surface of B, m, world
  Vec3 normal;  // from B to A
  double gap;   // distance along the normal; below zero: overlap, m
};

// Points of one pair; those beyond the capacity are left out.
class ContactPoints {
 public:
  static constexpr int kCapacity = 8;

  ContactPoints() = default;
  ContactPoints(const ContactPoints& other) { *this = other; }
  // Copies no more points than there are.
  ContactPoints& operator=(const ContactPoints& other) {
    size_ = other.size_;
    for (int i = 0; i < size_; ++i) (*this)[i] = other[i];
    return *this;
  }

  void push(const ContactPoint& point) {
    if (size_ < kCapacity) points_[at(size_++)] = point;
  }
  void clear() { size_ = 0; }
  // Drops points with this gap or more.
  void keep_below(double gap) {
    int kept = 0;
    for (int i = 0; i < size_; ++i) {
      if ((*this)[i].gap < gap) (*this)[kept++] = (*this)[i];
    }
    size_ = kept;
  }
  int size() const { return size_; }
  bool empty() const { return size_ == 0; }
  ContactPoint& operator[](int i) { return points_[at(i)]; }
  const ContactPoint& operator[](int i) const { return points_[at(i)]; }
  const ContactPoint* begin() const { return points_.data(); }
  const ContactPoint* end() const { return points_.data() + size_; }

 private:
  std::array<ContactPoint, kCapacity> points_;
  int size_ = 0;
};

}  // namespace engram
