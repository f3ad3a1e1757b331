// Layouts of objects on the table: nominal slots and jitter. Episodes are drawn inside steps, so
// nothing here allocates.
#pragma once

#include <Eigen/Dense>
#include <array>
#include <cstddef>

#include "core/math/random.h"

namespace engram::tasks {

using Vec2 = Eigen::Vector2d;

// Points on the table, m, by slot or by key.
class Layout {
 public:
  static constexpr std::size_t kCapacity = 16;

  std::size_t size() const { return size_; }
  void push_back(const Vec2& point) { points_[size_++] = point; }
  Vec2& operator[](std::size_t i) { return points_[i]; }
  const Vec2& operator[](std::size_t i) const { return points_[i]; }
  Vec2* begin() { return points_.data(); }
  Vec2* end() { return points_.data() + size_; }
  const Vec2* begin() const { return points_.data(); }
  const Vec2* end() const { return points_.data() + size_; }

 private:
  std::array<Vec2, kCapacity> points_;
  std::size_t size_ = 0;
};

// Half a circle around the robot's side of the table, squeezed in y.
struct ArcParams {
  double radius = 0.3;         // m
  double compression = 0.025;  // m in y per slot from the middle
};

// Between the nearest two points, m.
double min_distance(const Layout& layout);

// Slots of three objects in a row, of more on an arc.
Layout nominal_slots(int count, const ArcParams& arc = {});

// `size`: half the side of a cube as large as the objects, m; jitter and distances grow with it.

// Moves every slot by N(0, (0.5 size)^2) in x and y, up to 50 times each until it keeps 3 sizes
// from the slots before it; the nominal slot stays if all fail.
Layout jitter_slots(const Layout& nominal, double size, RandomStream& random);

// Moves all slots by N(0, (0.5 size)^2) in x and y, up to 20 times until all pairs keep 3 sizes;
// the most spacious attempt stays if none does.
Layout jitter_layout(const Layout& nominal, double size, RandomStream& random);

// Gives key k the slot permutation[k], the permutation drawn uniformly.
Layout assign_slots(const Layout& slots, RandomStream& random);

// Parameters of spread_and_stretch, named as the class constants.
struct SpreadParams {
  double MANIP_MIN_DISTANCE = 0.09;  // m
  int MANIP_WIDTH_AXIS = 1;          // y
  double MANIP_WIDTH_SCALE = 2;
  double MANIP_WIDTH_CLAMP = 0.5;  // m
};

// Pushes keys apart at random until they keep the minimum distance, then widens the row about its
// mean (three objects only).
void spread_and_stretch(Layout& layout, const SpreadParams& params, double size,
                        RandomStream& random);

}  // namespace engram::tasks
