// Latch of the objects that the robot has touched: a touch is a TCP that stands still near the
// point above an object, and it counts for the rest of the episode.
#pragma once

#include "core/task/task.h"

namespace engram::tasks {

struct TouchLatchParams {
  int objects = 0;        // props 0, ..., objects - 1 of the scene
  double height = 0.025;  // m: the touch point is that far above an object's origin
  int order_length = 0;   // how many first touches are remembered in order; 0: none
  bool repeats = false;   // whether a second touch of an object is noted
};

// The object whose touch point is nearest to the TCP, if that is within `radius`; otherwise -1. So
// a TCP between two objects touches only one. points: (objects, 3).
int touched_object(const double* points, int objects, const double* tcp, double radius);

// Notes a first touch in the order of touches, -1 being a free entry: in the first free one, and in
// the first of all once none is left, as upstream does.
void append_touch(std::int32_t* order, int length, int object);

class TouchLatch {
 public:
  static constexpr int kMaxObjects = 16;

  explicit TouchLatch(const TouchLatchParams& params) : params_(params) {}

  // radius: m around a touch point.
  void bind(const Bindings& bindings, double radius);
  void reset(int env) const;
  // One evaluation; latches nothing unless `acting`.
  void evaluate(int env, bool acting) const;

  double radius() const { return radius_; }  // m
  const std::uint8_t* touched(int env) const { return touched_.row(env); }
  // (order_length) objects in the order of their first touches, then -1.
  const std::int32_t* order(int env) const { return order_.row(env); }
  // Whether an object was touched again after the tool had been away from it, or at another one.
  bool repeated(int env) const { return params_.repeats && repeated_[env] != 0; }
  Eigen::Vector3d touch_point(int env, int object) const;

 private:
  // Ends the touch that lasts once the tool has left it.
  void end_touch(int env) const;
  // Whether the tool touches this object again.
  void note_repeat(int env, int object) const;

  TouchLatchParams params_;
  double radius_ = 0;
  Bindings engine_;
  Column<std::uint8_t> touched_;  // (objects)
  Column<std::int32_t> order_;    // (order_length)
  Column<std::int32_t> lasting_;  // the object whose touch has not ended, -1: none
  Column<std::uint8_t> repeated_;
};

}  // namespace engram::tasks
