// Memory of the contact solver for environments side by side: free bodies, and patches of contacts
// in the order in which they are solved. The structures below have one float for each lane in place
// of every number.
//
//              ^ normal, from B to A
//     +--------|--------+
//     |   A    |        |
//     +--o-----x-----o--+--> tangent
//   =======================   B
//      point anchor point
//
//   patch    points of one pair with one normal
//   point    has a gap along the normal: one constraint
//   anchor   a place of A and one of B that stick to each other: two constraints, along the
//   tangents.
//            A finger's only anchor has a third one, about the normal (torsion)
//
//              lane 0    lane 1    lane 2    lane 3
//   patch 0   [ A-B   ] [ A-B   ] [       ] [ A-B   ]   A lane is one environment. All lanes are
//   patch 1   [ A-C   ] [       ] [       ] [ B-C   ]   solved at once; an empty one has mass 0.
//
// A constraint is a unit impulse on A, and its opposite on B, along an axis or about it.
#pragma once

#include <algorithm>

#include "core/math/vec3.h"
#include "core/robot/robot_model.h"

namespace engram {
inline namespace ENGRAM_ISA {

inline constexpr int kPatchPoints = 4;
inline constexpr int kPatchAnchors = 2;

// A free prop, about its centre of mass, world axes.
template <class V>
struct FreeBodyLanes {
  V inv_mass;              // 1/kg; 0: none in this lane
  V inv_inertia[6];        // xx, yy, zz, xy, xz, yz; 1/(kg m^2)
  Vec3Of<V> center;        // m, at the substep's start, from the robot's base
  Vec3Of<V> linear;        // velocity, m/s
  Vec3Of<V> angular;       // rad/s
  Vec3Of<V> begin_linear;  // velocity before contacts
  // In this substep so far: sums of velocity times time, m, rad.
  Vec3Of<V> delta_position, delta_rotation;
  QuatOf<V> rotation;  // the same turn, as a quaternion
};

// One constraint: J of both bodies times the effective mass, so that a speed becomes an impulse,
// and the response of their velocities to a unit of impulse. The mass is 0 where a lane has none.
template <class V>
struct ConstraintLanes {
  V joint[kRobotJoints];
  V joint_response[kRobotJoints];
  Vec3Of<V> axis;  // along which free bodies are pushed; 0 for a torque
  Vec3Of<V> turn_a, turn_response_a;
  Vec3Of<V> turn_b, turn_response_b;
  V separation;  // gap, or distance of anchors, at the substep's start, times mass, kg m
  V bias_rate;   // share of the separation that is taken out, 1/s
  // Along the axis, times mass, N s: what velocities of B, if it is kinematic, and bias
  // accelerations of links add to J v, and to the rate of the separation.
  V added_speed, added_rate;
  V impulse;  // sum in this substep, N s
};

// Contacts of one pair with one normal.
template <class V>
struct PatchLanes {
  // --- set for each lane ---
  V link_a, link_b;            // of the robot, or -1
  V prop_a, prop_b;            // index of a free body, or -1
  V joint_sign[kRobotJoints];  // 1: the joint moves A, -1: it moves B
  V num_points;                // 0: none in this lane
  V num_anchors;
  V friction;
  V torsion_radius;                   // m
  Vec3Of<V> normal;                   // from B to A
  Vec3Of<V> kinematic_velocity;       // of B, m/s
  Vec3Of<V> point[kPatchPoints];      // m, from the robot's base
  V gap[kPatchPoints];                // m
  Vec3Of<V> anchor_a[kPatchAnchors];  // m, from the robot's base
  Vec3Of<V> apart[kPatchAnchors];     // m, from B's anchor to A's: a small difference
  // --- set by the solver ---
  V slipping;  // 1: friction slipped in the velocity iteration
  Vec3Of<V> tangent[2];
  // Change of a free body's velocity by a unit of impulse along the normal and the tangents, 1/kg.
  Vec3Of<V> normal_response_a, normal_response_b;
  Vec3Of<V> tangent_response_a[2], tangent_response_b[2];
  V min_normal_impulse;  // least sum of normal impulses for friction, N s
  V torsion_reach;       // m; 0: no torsional friction
  ConstraintLanes<V> normal_constraint[kPatchPoints];
  ConstraintLanes<V> friction_constraint[kPatchAnchors][2];
  ConstraintLanes<V> torsion_constraint;
};

}  // namespace ENGRAM_ISA

// Members of one patch over all lanes, so that nothing is done for what no lane has.
struct PatchMembers {
  unsigned links = 0;  // bits
  unsigned long long props_a = 0;
  unsigned long long props_b = 0;
  int num_points = 0;  // most of any lane
  int num_anchors = 0;
  bool torsion = false;
  // Some lanes that have this patch have a link as A, others have none.
  bool mixed_links = false;
  // Lanes that have this patch have different bodies, or some have none.
  bool mixed_a = false;
  bool mixed_b = false;
};

// Order of solving: pairs of moving bodies; pairs of a free body and a fixed one; then, after each
// joint, pairs of its links and fixed bodies.
struct PatchLists {
  static constexpr int kMoving = 0;
  static constexpr int kFixed = 1;
  static constexpr int kLinks = 2;  // + joint
  static constexpr int kCount = kLinks + kRobotJoints;

  int begin[kCount] = {};  // first patch
  int size[kCount] = {};   // most of any lane
};

struct ContactLanes {
  float* bodies = nullptr;
  int num_bodies = 0;  // most of any lane
  float* patches = nullptr;
  PatchMembers* members = nullptr;
  PatchLists lists;

  // Nothing beside the robot's free motion in any lane.
  bool empty() const {
    return num_bodies == 0 && std::ranges::all_of(lists.size, [](int size) { return size == 0; });
  }
};

}  // namespace engram
