// Taking, carrying and leaving things with the gripper from above, for oracles. Nothing is
// remembered between steps: what comes next follows from where tool, fingers and things are, so
// that what slipped away is simply taken again.
#pragma once

#include <Eigen/Dense>

#include "core/sim/state.h"
#include "tasks/common/tool_servo.h"

namespace engram::tasks {

// How a prop is taken.
struct Grip {
  int prop = 0;
  Eigen::Quaterniond tool = kToolDown;  // orientation of the tool
  double height = 0.003;                // m, of the TCP above the prop's origin
  double opening = kGripperOpen;        // gripper command while the tool comes and goes
  double travel_height = 0.2;           // m, of the TCP between two places
};

// The tool turned so that the fingers close on two faces of a cube; of the four ways the one that
// is nearest to where the tool is turned now.
Eigen::Quaterniond tool_for_cube(const State& state, int env, int prop);

// Whether both fingers press on the prop and have come to rest.
bool is_held(const State& state, int env, int prop);

// The point to steer for on the way to a goal: the tool rises where it is, travels at
// `travel_height` and comes down over the goal.
Eigen::Vector3d over_the_top(const State& state, int env, const Eigen::Vector3d& goal,
                             double travel_height);

// As servo_tool, but slower where the arm is folded or stretched so far that it would overshoot.
void steer_tool(const State& state, int env, const Eigen::Vector3d& goal,
                const Eigen::Quaterniond& orientation, double gripper, float* action);

// Writes the next action of taking the prop. True, and nothing is written, once it is held.
bool take(const State& state, int env, const Grip& grip, float* action);

// Writes the next action of bringing the origin of the prop that is held to a place.
void carry(const State& state, int env, const Grip& grip, const Eigen::Vector3d& place,
           float* action);

// Writes the next action of opening the fingers and leaving upwards. True, and nothing is written,
// once the TCP is `clearance` above the prop's origin, or was never near it.
bool leave(const State& state, int env, const Grip& grip, double clearance, float* action);

// How near to its place a prop counts as brought.
struct Tolerance {
  double sideways = 0.006;  // m
  double height = 0.003;    // m
};
bool is_at(const State& state, int env, int prop, const Eigen::Vector3d& place,
           const Tolerance& tolerance = {});

// All of it: writes the next action of bringing the prop's origin to a place and leaving it there.
// True, and nothing is written, once it is there and the tool is clear.
bool bring(const State& state, int env, const Grip& grip, const Eigen::Vector3d& place,
           float* action, const Tolerance& tolerance = {});

}  // namespace engram::tasks
