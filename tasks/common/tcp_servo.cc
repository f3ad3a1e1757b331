#include "tasks/common/tcp_servo.h"

#include <algorithm>

#include "core/math/float_sums.h"
#include "core/math/real_functions.h"
#include "core/math/rotations.h"
#include "core/robot/arm.h"
#include "core/sim/action_scale.h"
#include "tasks/common/poses.h"

namespace engram::tasks {
namespace {

// Gain above 1, since one step covers only part of a command. Below
// 1 / kStepResponse, so that the tool does not overshoot.
constexpr double kGain = 1.6;
// Horizontal distance at which the tool may come down.
constexpr double kOverhead = 0.03;  // m

// Horizontal distance within which a descending tool is at its lowest.
constexpr double kDescentRadius = 0.01;  // m

using Eigen::Vector3d;

// command: displacement, m.
void write_translation(const Vector3d& command, float* action) {
  for (int i = 0; i < 3; ++i) {
    action[i] = static_cast<float>(std::clamp(command[i] / kTranslationScale, -1.0, 1.0));
  }
}

// rotation: rotation vector, 1 being full scale, with the original benchmark's sign.
void write_rotation(const Vector3d& rotation, float* action) {
  for (int i = 0; i < 3; ++i) {
    action[3 + i] = static_cast<float>(rotation[i] / std::max(1.0, rotation.norm()));
  }
}

// Turns the tool towards an orientation; leaves the translation alone.
void turn_tool(const State& state, int env, const Eigen::Quaterniond& orientation, double gripper,
               float* action) {
  const double* quat = state.tcp_quat.row(env);
  const Eigen::Quaterniond measured(quat[0], quat[1], quat[2], quat[3]);
  // The original benchmark negates rotation actions.
  write_rotation(-kGain / kRotationScale * rotation_vector(orientation * measured.conjugate()),
                 action);
  action[6] = static_cast<float>(gripper);
}

}  // namespace

void servo_tcp(const State& state, int env, const Eigen::Vector3d& goal,
               const Eigen::Quaterniond& orientation, double gripper, float* action) {
  const Eigen::Vector3d translation = kGain / kTranslationScale * (goal - tcp_pos(state, env));
  for (int i = 0; i < 3; ++i) action[i] = static_cast<float>(std::clamp(translation[i], -1.0, 1.0));
  turn_tool(state, env, orientation, gripper, action);
}

void displace_tcp(const State& state, int env, const Eigen::Vector3d& command,
                  const Eigen::Quaterniond& orientation, double gripper, float* action) {
  write_translation(command, action);
  turn_tool(state, env, orientation, gripper, action);
}

void reach_point(const State& state, const Arm& arm, int env, const Eigen::Vector3d& goal,
                 double gripper, float* action) {
  constexpr double kReachGain = 2.2;     // little overshoot does no harm to a touch
  constexpr double kUpright = 0.2;       // of the tilt is taken back in one action
  constexpr double kMaxUpright = 0.005;  // rad: slow enough to count as rest
  ArmJacobian jacobian;
  const auto pose = arm.forward(state.qpos.row(env), jacobian);
  const Vector3d way = kReachGain * (goal - tcp_pos(state, env));
  ArmVector step = Arm::pseudo_inverse_step(jacobian, way);
  step /= std::max(1.0, step.cwiseAbs().maxCoeff() / kJointScale);
  Vector3d upright = kUpright * rotation_vector(kToolDown * pose.quat.conjugate());
  upright /= std::max(1.0, upright.norm() / kMaxUpright);
  write_translation(jacobian.topRows<3>() * step, action);
  write_rotation(-(jacobian.bottomRows<3>() * step + upright) / kRotationScale, action);
  action[6] = static_cast<float>(gripper);
}

void swing_tcp(const State& state, const Arm& arm, int env, const Eigen::Vector3d& goal,
               const Eigen::Quaterniond& orientation, double gripper, float* action) {
  const double* qpos = state.qpos.row(env);
  ArmVector joints;
  arm.inverse({goal, orientation}, qpos, joints);  // as far as it came, on failure
  ArmVector step = kGain * (joints - Eigen::Map<const ArmVector>(qpos));
  step /= std::max(1.0, step.cwiseAbs().maxCoeff() / kJointScale);
  ArmJacobian jacobian;
  arm.forward(qpos, jacobian);
  write_translation(jacobian.topRows<3>() * step, action);
  write_rotation(-jacobian.bottomRows<3>() * step / kRotationScale, action);
  action[6] = static_cast<float>(gripper);
}

void limit_speed_near(const State& state, int env, double height, float* action) {
  constexpr double kMin = 0.25;  // of full speed
  constexpr double kPerMetre = 8;
  const double above = state.tcp_pos.row(env)[2] - height;
  const double most = std::clamp(kMin + kPerMetre * above, kMin, 1.0);
  const auto length = static_cast<double>(length_of_three(action));
  if (length > most) {
    const auto slower = static_cast<float>(most / length);
    for (int i = 0; i < 3; ++i) action[i] *= slower;
  }
}

Eigen::Vector3d tcp_velocity(const State& state, const Arm& arm, int env) {
  ArmJacobian jacobian;
  arm.forward(state.qpos.row(env), jacobian);
  return jacobian.topRows<3>() * Eigen::Map<const ArmVector>(state.qvel.row(env));
}

Eigen::Quaterniond tool_down(double yaw) { return turn_about(Vector3d::UnitZ(), yaw) * kToolDown; }

double tcp_yaw(const State& state, int env) {
  const double* quat = state.tcp_quat.row(env);
  const Vector3d forward =
      Eigen::Quaterniond(quat[0], quat[1], quat[2], quat[3]) * Vector3d::UnitX();
  return real::atan2(forward.y(), forward.x());
}

Eigen::Quaterniond tilt_outwards(const Eigen::Quaterniond& orientation,
                                 const Eigen::Vector3d& point, const Tilt& tilt) {
  const Eigen::Vector3d outward(point.x() - kRobotBaseX, point.y(), 0);
  const double reach = outward.norm();
  const double angle = std::clamp(tilt.per_metre * (reach - tilt.reach), 0.0, tilt.most) -
                       std::clamp(tilt.per_metre * (tilt.fold - reach), 0.0, tilt.most);
  const Eigen::Vector3d axis = -Eigen::Vector3d::UnitZ().cross(outward / reach);
  return turn_about(axis, angle) * orientation;
}

void hold_tcp(double gripper, float* action) {
  std::fill_n(action, 6, 0.0F);
  action[6] = static_cast<float>(gripper);
}

Eigen::Vector3d approach_from_above(const State& state, int env, const Eigen::Vector3d& goal,
                                    double clearance) {
  const Eigen::Vector3d tcp = tcp_pos(state, env);
  const bool overhead = (goal - tcp).head<2>().norm() <= kOverhead;
  return goal + Eigen::Vector3d(0, 0, overhead ? 0.0 : clearance);
}

Eigen::Vector3d approach_by_funnel(const State& state, int env, const Eigen::Vector3d& goal,
                                   double radius, double slope) {
  const Eigen::Vector3d tcp = tcp_pos(state, env);
  const double away = (goal - tcp).head<2>().norm();
  return goal + Eigen::Vector3d(0, 0, slope * std::max(0.0, away - radius));
}

Eigen::Vector3d descend(const State& state, int env, const Eigen::Vector3d& goal,
                        double travel_height) {
  Eigen::Vector3d waypoint = approach_by_funnel(state, env, goal, kDescentRadius, 1);
  waypoint.z() = std::min(waypoint.z(), std::max(travel_height, goal.z()));
  return waypoint;
}

}  // namespace engram::tasks
