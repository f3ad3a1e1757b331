// The broad phase in vectors of D: bounds of the distances of bodies, then of shapes.
#pragma once

#include "core/collision/broad_phase_lanes.h"
#include "core/robot/arm_kinematics.h"
#include "core/robot/lane_kernel.h"
#include "core/scene/speculative_margin.h"

namespace engram {
inline namespace ENGRAM_ISA {

// D: a double, or a vector of them, which is a part of the lanes.
template <class D, int kLanes>
class BroadPhaseKernel {
 public:
  // Frames of the robot's links, and centres and speeds of its bodies, from `vectors` after
  // LaneKernel::pose_links().
  static void pose_robot(const RobotModel& robot, const double* vectors,
                         const BroadPhaseLanes& lanes) {
    for (int part = 0; part < kLanes; part += simd::kLanesOf<D>) {
      pose_robot_part(robot, vectors + part, lanes, part);
    }
  }

  static void find_near(BroadPhaseLanes& lanes) {
    for (int i = 0; i < lanes.num_shapes; ++i) lanes.is_posed[i] = lanes.shape[i].frame < 0;
    for (int i = 0; i < lanes.num_bodies; ++i) pose_body(lanes, i);
    lanes.num_near = 0;
    for (int i = 0; i < lanes.num_body_pairs; ++i) {
      const BroadPhaseLanes::BodyPair& pair = lanes.body_pair[i];
      unsigned found = lanes.present[pair.a] & lanes.present[pair.b];
      if (found == 0) continue;
      found &= near_bodies(lanes, pair);
      if (found == 0) continue;
      for (int k = pair.first; k < pair.first + pair.count; ++k) {
        const unsigned near = found & near_shapes(lanes, pair, lanes.shape_pair[k]);
        if (near != 0) lanes.near[lanes.num_near++] = {k, near};
      }
    }
  }

 private:
  using Vec = Vec3Of<D>;
  using FrameOf = LinkPose<D>;

  ENGRAM_INLINE static D load(const double* rows, int row) {
    D value;
    __builtin_memcpy(&value, rows + row * kLanes, sizeof value);
    return value;
  }
  ENGRAM_INLINE static void store(double* rows, int row, D value) {
    __builtin_memcpy(rows + row * kLanes, &value, sizeof value);
  }
  ENGRAM_INLINE static Vec load_vec(const double* rows, int row) {
    return {load(rows, row), load(rows, row + 1), load(rows, row + 2)};
  }
  ENGRAM_INLINE static void store_vec(double* rows, int row, const Vec& value) {
    for (int k = 0; k < 3; ++k) store(rows, row + k, value[k]);
  }
  ENGRAM_INLINE static FrameOf load_frame(const double* rows, int row) {
    FrameOf frame;
    frame.pos = load_vec(rows, row);
    for (int k = 0; k < 9; ++k) frame.axes.at[k] = load(rows, row + 3 + k);
    return frame;
  }
  ENGRAM_INLINE static void store_frame(double* rows, int row, const FrameOf& frame) {
    store_vec(rows, row, frame.pos);
    for (int k = 0; k < 9; ++k) store(rows, row + 3 + k, frame.axes.at[k]);
  }
  // All parts of the lanes, as bits of one mask.
  template <class Test>
  ENGRAM_INLINE static unsigned for_parts(const Test& test) {
    unsigned mask = 0;
    for (int part = 0; part < kLanes; part += simd::kLanesOf<D>) {
      mask |= simd::bits(test(part)) << part;
    }
    return mask;
  }

  static void pose_robot_part(const RobotModel& robot, const double* vectors,
                              const BroadPhaseLanes& lanes, int part) {
    // Velocity of each hinge's link: of the point at the world's origin, and angular.
    Vec linear[kArmJoints];
    Vec angular[kArmJoints];
    D turn_speed[kArmJoints];
    FrameOf links[kRobotJoints];
    Vec v = {};
    Vec w = {};
    for (int i = 0; i < kArmJoints; ++i) {
      FrameOf& link = links[i];
      link = load_frame(vectors, LaneVectors::kLinkPoses + BroadPhaseLanes::kFrameRows * i);
      link.pos = link.pos + broadcast_vec3<D>(robot.base_position);
      const Vec turn = link.axes.column(2) * load(vectors, LaneVectors::kV + i);
      w = w + turn;
      v = v - cross(turn, link.pos);
      linear[i] = v;
      angular[i] = w;
      turn_speed[i] = simd::sqrt(dot(w, w));
    }
    const FrameOf& last = links[kArmJoints - 1];
    for (int k = 0; k < kFingers; ++k) {
      const D opening = load(vectors, LaneVectors::kQ + kArmJoints + k);
      const Vec offset = broadcast_vec3<D>(robot.fingers[k].offset) +
                         broadcast_vec3<D>(robot.finger_axis[k]) * opening;
      links[kArmJoints + k] = {last.pos + last.axes * offset,
                               last.axes.times(robot.fingers[k].rotation)};
    }
    for (int i = 0; i < kRobotJoints; ++i) {
      store_frame(lanes.frames + part, BroadPhaseLanes::kFrameRows * i, links[i]);
    }
    for (int i = 0; i < lanes.num_bodies; ++i) {
      const BroadPhaseLanes::Body& body = lanes.body[i];
      if (body.link < 0) continue;
      double* const rows = lanes.bodies + BroadPhaseLanes::kBodyRows * kLanes * i + part;
      const Vec center = links[body.frame].pos + links[body.frame].axes * body.center;
      store_vec(rows, BroadPhaseLanes::kCenter, center);
      const int hinge = hinges_of(body.link) - 1;
      const Vec moved = linear[hinge] + cross(angular[hinge], center);
      D speed = simd::sqrt(dot(moved, moved)) + turn_speed[hinge] * body.radius;
      const int finger = finger_of(body.link);
      if (finger >= 0) {
        speed += simd::abs(load(vectors, LaneVectors::kV + kArmJoints + finger));
      }
      store(rows, BroadPhaseLanes::kSpeed, speed);
    }
  }

  // Centre of a prop; travel.
  static void pose_body(const BroadPhaseLanes& lanes, int index) {
    const BroadPhaseLanes::Body& body = lanes.body[index];
    if (body.frame < 0 || lanes.present[index] == 0) return;
    for (int part = 0; part < kLanes; part += simd::kLanesOf<D>) {
      double* const rows = lanes.bodies + BroadPhaseLanes::kBodyRows * kLanes * index + part;
      const double* const frame =
          lanes.frames + BroadPhaseLanes::kFrameRows * kLanes * body.frame + part;
      if (body.link < 0) {
        const FrameOf carrier = load_frame(frame, 0);
        store_vec(rows, BroadPhaseLanes::kCenter, carrier.pos + carrier.axes * body.center);
      }
      store(rows, BroadPhaseLanes::kTravel,
            lanes.timestep *
                (kSpeculativeFactor * load(rows, BroadPhaseLanes::kSpeed) + body.speed_gain));
    }
  }

  static void pose_shape(const BroadPhaseLanes& lanes, int index) {
    if (lanes.is_posed[index]) return;
    lanes.is_posed[index] = true;
    const BroadPhaseLanes::Shape& shape = lanes.shape[index];
    for (int part = 0; part < kLanes; part += simd::kLanesOf<D>) {
      const FrameOf carrier =
          load_frame(lanes.frames + part, BroadPhaseLanes::kFrameRows * shape.frame);
      double* const rows = lanes.shapes + part;
      const int row = BroadPhaseLanes::kFrameRows * index;
      store_vec(rows, row, carrier.pos + carrier.axes * shape.pos);
      if (!shape.is_box) continue;
      const Mat3Of<D> axes = carrier.axes.times(shape.axes);
      for (int k = 0; k < 9; ++k) store(rows, row + 3 + k, axes.at[k]);
    }
  }

  ENGRAM_INLINE static D reach_of(const BroadPhaseLanes& lanes, const BroadPhaseLanes::BodyPair& p,
                                  double gap, int part) {
    const double* const rows = lanes.bodies + part + BroadPhaseLanes::kTravel * kLanes;
    return load(rows, BroadPhaseLanes::kBodyRows * p.a) +
           load(rows, BroadPhaseLanes::kBodyRows * p.b) + gap;
  }

  // Tests whether a point comes within `reach` of a shape, or may.
  ENGRAM_INLINE static auto is_near(const BroadPhaseLanes& lanes, int index, const Vec& point,
                                    D reach, int part) {
    const BroadPhaseLanes::Shape& shape = lanes.shape[index];
    const double* const rows = lanes.shapes + part;
    const int row = BroadPhaseLanes::kFrameRows * index;
    const Vec offset = point - load_vec(rows, row);
    if (!shape.is_box) {
      const D around = reach + shape.radius;
      return dot(offset, offset) <= around * around;
    }
    D squared = {};
    for (int k = 0; k < 3; ++k) {
      const D along = load(rows, row + 3 + k) * offset.x() + load(rows, row + 6 + k) * offset.y() +
                      load(rows, row + 9 + k) * offset.z();
      const D outside = simd::max(D{}, simd::abs(along) - shape.half[k]);
      squared += outside * outside;
    }
    return squared <= reach * reach;
  }

  ENGRAM_INLINE static Vec center_of(const BroadPhaseLanes& lanes, int body, int part) {
    return load_vec(lanes.bodies + part, BroadPhaseLanes::kBodyRows * body);
  }

  static unsigned near_bodies(const BroadPhaseLanes& lanes, const BroadPhaseLanes::BodyPair& pair) {
    const double radius = lanes.body[pair.a].radius;
    if (pair.box >= 0) {
      pose_shape(lanes, pair.box);
      return for_parts([&](int part) ENGRAM_INLINE_LAMBDA {
        return is_near(lanes, pair.box, center_of(lanes, pair.a, part),
                       reach_of(lanes, pair, pair.near_gap + radius, part), part);
      });
    }
    const double radii = radius + lanes.body[pair.b].radius;
    return for_parts([&](int part) ENGRAM_INLINE_LAMBDA {
      const Vec apart = center_of(lanes, pair.a, part) - center_of(lanes, pair.b, part);
      const D reach = reach_of(lanes, pair, pair.near_gap + radii, part);
      return dot(apart, apart) <= reach * reach;
    });
  }

  static unsigned near_shapes(const BroadPhaseLanes& lanes, const BroadPhaseLanes::BodyPair& bodies,
                              const BroadPhaseLanes::ShapePair& pair) {
    pose_shape(lanes, pair.a);
    pose_shape(lanes, pair.b);
    const auto reach = [&](int part) ENGRAM_INLINE_LAMBDA {
      return simd::min(reach_of(lanes, bodies, pair.near_gap, part),
                       simd::broadcast<D>(pair.max_reach));
    };
    const auto center_near = [&](int shape, int to) ENGRAM_INLINE_LAMBDA {
      return for_parts([&](int part) ENGRAM_INLINE_LAMBDA {
        const Vec center = load_vec(lanes.shapes + part, BroadPhaseLanes::kFrameRows * shape);
        return is_near(lanes, to, center, reach(part) + lanes.shape[shape].radius, part);
      });
    };
    unsigned near = center_near(pair.a, pair.b);
    if (near != 0) near &= center_near(pair.b, pair.a);
    if (near == 0 || !lanes.shape[pair.a].is_box || !lanes.shape[pair.b].is_box) return near;
    return near & for_parts([&](int part) ENGRAM_INLINE_LAMBDA {
             return are_boxes_near(lanes, pair, reach(part), part);
           });
  }

  // Tests the faces of two boxes as separating planes.
  ENGRAM_INLINE static auto are_boxes_near(const BroadPhaseLanes& lanes,
                                           const BroadPhaseLanes::ShapePair& pair, D reach,
                                           int part) {
    const FrameOf a = load_frame(lanes.shapes + part, BroadPhaseLanes::kFrameRows * pair.a);
    const FrameOf b = load_frame(lanes.shapes + part, BroadPhaseLanes::kFrameRows * pair.b);
    const double* const half_a = lanes.shape[pair.a].half;
    const double* const half_b = lanes.shape[pair.b].half;
    const Vec offset = b.pos - a.pos;
    D widest = simd::broadcast<D>(-1e9);
    Vec across_b = broadcast_vec3<D>(half_b);
    for (int i = 0; i < 3; ++i) {
      const Vec axis = a.axes.column(i);
      D across_a = simd::broadcast<D>(half_a[i]);
      for (int k = 0; k < 3; ++k) {
        const D spread = simd::abs(dot(axis, b.axes.column(k)));
        across_a += spread * half_b[k];
        across_b[k] += spread * half_a[i];
      }
      widest = simd::max(widest, simd::abs(dot(axis, offset)) - across_a);
    }
    for (int k = 0; k < 3; ++k) {
      widest = simd::max(widest, simd::abs(dot(b.axes.column(k), offset)) - across_b[k]);
    }
    return widest < reach;
  }
};

}  // namespace ENGRAM_ISA
}  // namespace engram
