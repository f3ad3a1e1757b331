#include "tasks/common/grasp_servo.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/math/real_functions.h"
#include "core/math/rotations.h"
#include "tasks/common/poses.h"

namespace engram::tasks {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kFirmForce = 5.0;  // N on each finger
constexpr double kFingerRest =
    0.1;  // m/s: fingers this slow have closed; held ones report some speed
constexpr double kFingerTarget = 0.015;  // m per finger at command 0
constexpr double kFingerScale = 0.025;   // m per unit of command
constexpr double kOpenEnough = 0.004;    // m: what a finger may lack of its opening
constexpr double kEmpty = 0.002;         // m: fingers this close have nothing in between

// Coming down: the tool keeps above a cone around the goal.
constexpr double kConeRadius = 0.002;  // m: of its tip
constexpr double kConeSlope = 4.0;
constexpr double kTooLow = 0.015;  // m below the waypoint: rise before going sideways
constexpr double kHover = 0.05;    // m above the goal: wait there until fingers and turn are ready

// Distances at which the fingers begin to close, and go on.
constexpr double kInPlace = 0.006;      // m
constexpr double kStillInPlace = 0.02;  // m
constexpr double kTurned = 0.08;        // rad

// Distances from the base's axis between which the arm moves at full speed, and how fast it slows
// down beyond them.
constexpr double kFolded = 0.40;     // m
constexpr double kStretched = 0.74;  // m
constexpr double kSlowing = 7.0;     // of full speed per m
constexpr double kSlowest = 0.3;     // of full speed
constexpr double kDescending = 0.5;  // of full speed: a faster descent leads sideways

constexpr double kReleaseRadius = 0.06;  // m: a tool further off sideways has nothing to release
constexpr double kStep = 0.05;           // m ahead of the tool while it rises

Quaterniond quaternion(const double* quat) { return {quat[0], quat[1], quat[2], quat[3]}; }

double narrower_finger(const State& state, int env) {
  const double* qpos = state.qpos.row(env);
  return std::min(qpos[kArmJoints], qpos[kArmJoints + 1]);
}

bool is_open(const State& state, int env, double opening) {
  return narrower_finger(state, env) > kFingerTarget + kFingerScale * opening - kOpenEnough;
}

}  // namespace

Quaterniond cube_grasp_orientation(const State& state, int env, int prop) {
  const Quaterniond turn = quaternion(state.prop_quat_of(env, prop));
  Vector3d edge = turn * Vector3d::UnitX();
  if (std::abs(edge.z()) > 0.7) edge = turn * Vector3d::UnitY();
  constexpr double kQuarter = std::numbers::pi / 2;
  const double now = tcp_yaw(state, env);
  const double away = real::atan2(edge.y(), edge.x()) - now;
  return tool_down(now + away - kQuarter * std::round(away / kQuarter));
}

bool is_held(const State& state, int env, int prop) {
  const double* qvel = state.qvel.row(env) + kArmJoints;
  const bool resting = std::max(std::abs(qvel[0]), std::abs(qvel[1])) < kFingerRest;
  return resting && is_grasping(state, env, prop, kFirmForce);
}

Vector3d transfer_waypoint(const State& state, int env, const Vector3d& goal,
                           double travel_height) {
  const Vector3d tcp = tcp_pos(state, env);
  const double distance = (goal - tcp).head<2>().norm();
  const double most = std::max(0.0, travel_height - goal.z());
  const double height = goal.z() + std::clamp(kConeSlope * (distance - kConeRadius), 0.0, most);
  if (tcp.z() < height - kTooLow) return {tcp.x(), tcp.y(), height};
  return {goal.x(), goal.y(), height};
}

void servo_tcp_limited(const State& state, int env, const Vector3d& goal,
                       const Quaterniond& orientation, double gripper, float* action) {
  servo_tcp(state, env, goal, orientation, gripper, action);
  const Vector3d tcp = tcp_pos(state, env);
  const double reach = real::hypot(tcp.x() - kRobotBaseX, tcp.y());
  const double beyond = std::max({0.0, kFolded - reach, reach - kStretched});
  const double fastest_here = action[2] < 0 ? kDescending : 1.0;
  const auto most = static_cast<float>(std::clamp(1 - kSlowing * beyond, kSlowest, fastest_here));
  const float fastest = std::max({std::abs(action[0]), std::abs(action[1]), std::abs(action[2])});
  if (fastest <= most) return;
  for (int i = 0; i < 3; ++i) action[i] *= most / fastest;
}

bool grasp(const State& state, int env, const Grip& grip, float* action) {
  if (is_held(state, env, grip.prop)) return true;
  const Vector3d goal = prop_pos(state, env, grip.prop) + Vector3d(0, 0, grip.height);
  const Vector3d tcp = tcp_pos(state, env);
  const bool turned = angle_between(grip.tool, quaternion(state.tcp_quat.row(env))) < kTurned;
  const bool open = is_open(state, env, grip.opening);
  const bool low = std::abs(tcp.z() - goal.z()) < kInPlace;
  const double distance = (goal - tcp).head<2>().norm();
  const bool begin = open && turned && distance < kInPlace;
  const bool go_on = !open && narrower_finger(state, env) > kEmpty && distance < kStillInPlace;
  if (low && (begin || go_on)) {
    servo_tcp_limited(state, env, {tcp.x(), tcp.y(), goal.z()}, grip.tool, kGripperSqueezing,
                      action);
    return false;
  }
  Vector3d next = transfer_waypoint(state, env, goal, grip.travel_height);
  if (!open || !turned) {
    next.z() = std::max(next.z(), std::min(grip.travel_height, goal.z() + kHover));
  }
  servo_tcp_limited(state, env, next, grip.tool, grip.opening, action);
  return false;
}

void carry(const State& state, int env, const Grip& grip, const Vector3d& place, float* action) {
  const Vector3d goal = place + tcp_pos(state, env) - prop_pos(state, env, grip.prop);
  servo_tcp_limited(state, env, transfer_waypoint(state, env, goal, grip.travel_height), grip.tool,
                    kGripperSqueezing, action);
}

bool release(const State& state, int env, const Grip& grip, double clearance, float* action) {
  const Vector3d prop = prop_pos(state, env, grip.prop);
  const Vector3d tcp = tcp_pos(state, env);
  if ((tcp - prop).head<2>().norm() > kReleaseRadius || tcp.z() > prop.z() + clearance) return true;
  const double rise = is_open(state, env, grip.opening) ? kStep : 0.0;
  servo_tcp_limited(state, env, tcp + Vector3d(0, 0, rise), grip.tool, grip.opening, action);
  return false;
}

bool is_at(const State& state, int env, int prop, const Vector3d& place,
           const Tolerance& tolerance) {
  const Vector3d offset = prop_pos(state, env, prop) - place;
  return offset.head<2>().norm() < tolerance.sideways && std::abs(offset.z()) < tolerance.height;
}

bool pick_and_place(const State& state, int env, const Grip& grip, const Vector3d& place,
                    float* action, const Tolerance& tolerance) {
  constexpr double kClearance = 0.06;  // m: the fingers' ends above a cube
  if (is_at(state, env, grip.prop, place, tolerance)) {
    return release(state, env, grip, kClearance, action);
  }
  if (grasp(state, env, grip, action)) carry(state, env, grip, place, action);
  return false;
}

}  // namespace engram::tasks
