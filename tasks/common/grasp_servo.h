// Top-down grasping, carrying and releasing, for experts. Nothing is remembered between steps: the
// next action follows from where TCP, fingers and props are, so that a prop that slipped away is
// simply grasped again.
#pragma once

#include <Eigen/Dense>

#include "core/sim/state.h"
#include "tasks/common/tcp_servo.h"

namespace engram::tasks {

// Grasp of a prop.
struct Grip {
  int prop = 0;
  Eigen::Quaterniond tool = kToolDown;  // its orientation
  double height = 0.003;                // m, of the TCP above the prop's origin
  double opening = kGripperOpen;        // gripper command while the tool approaches and retracts
  double travel_height = 0.2;           // m, of the TCP between two places
};

// Orientation in which the fingers close on two faces of a cube: of the four possible ones that
// nearest to the present one.
Eigen::Quaterniond cube_grasp_orientation(const State& state, int env, int prop);

// True while both fingers press on the prop and have come to rest.
bool is_held(const State& state, int env, int prop);

// Next waypoint of a transfer: the TCP rises where it is, travels at `travel_height` and comes down
// over the goal.
Eigen::Vector3d transfer_waypoint(const State& state, int env, const Eigen::Vector3d& goal,
                                  double travel_height);

// Servo like servo_tcp, but slower where the arm is folded or stretched so far that it would
// overshoot.
void servo_tcp_limited(const State& state, int env, const Eigen::Vector3d& goal,
                       const Eigen::Quaterniond& orientation, double gripper, float* action);

// Writes the next action of grasping the prop. True, and nothing is written, once it is held.
bool grasp(const State& state, int env, const Grip& grip, float* action);

// Writes the next action of bringing the origin of the prop that is held to a place.
void carry(const State& state, int env, const Grip& grip, const Eigen::Vector3d& place,
           float* action);

// Writes the next action of opening the fingers and retracting upwards. True, and nothing is
// written, once the TCP is `clearance` above the prop's origin, or was never near it.
bool release(const State& state, int env, const Grip& grip, double clearance, float* action);

// Distance from its place within which a prop counts as placed.
struct Tolerance {
  double sideways = 0.006;  // m
  double height = 0.003;    // m
};
bool is_at(const State& state, int env, int prop, const Eigen::Vector3d& place,
           const Tolerance& tolerance = {});

// All of it: writes the next action of bringing the prop's origin to a place and releasing it.
// True, and nothing is written, once it is there and the tool is clear.
bool pick_and_place(const State& state, int env, const Grip& grip, const Eigen::Vector3d& place,
                    float* action, const Tolerance& tolerance = {});

}  // namespace engram::tasks
