#include "core/robot/robot_step.h"

#include <algorithm>

#include "core/robot/lane_kernel.h"
#include "core/robot/robot_dynamics.h"

namespace engram {
namespace {

// Factor on the diagonal of the mass matrix for a joint at its limit.
constexpr double kHeldMass = 1000;

JointMatrix product(const JointMatrix& a, const JointMatrix& b) {
  JointMatrix result;
  for (int i = 0; i < kRobotJoints; ++i) {
    for (int k = 0; k < kRobotJoints; ++k) add_scaled(result[i], a[i][k], b[k]);
  }
  return result;
}

}  // namespace

double drive_bias(const RobotParams& params, const DriveTarget& target, int joint) {
  const auto i = static_cast<std::size_t>(joint);
  const double bias = drive_stiffness(params, target.velocity_mode, joint) * target.qpos[i];
  return joint < kArmJoints ? bias + params.drive.damping * target.qvel[i] : bias;
}

RobotStep::RobotStep(const RobotParams& params, const DriveTarget& target) : params_(params) {
  for (int i = 0; i < kRobotJoints; ++i) {
    joints_.stiffness[i] = drive_stiffness(params, target.velocity_mode, i);
    joints_.drive_bias[i] = drive_bias(params, target, i);
  }
}

void RobotStep::load(const double* rows, int lanes, int lane) {
  const auto copy = [=](int first, double* to) {
    for (int i = 0; i < kRobotJoints; ++i) to[i] = rows[(first + i) * lanes + lane];
  };
  copy(LaneRows::kQ, q.data());
  copy(LaneRows::kV, v.data());
  copy(LaneRows::kBiasForce, bias_force.data());
  for (int i = 0; i < kRobotJoints; ++i) {
    copy(LaneRows::kMassMatrix + i * kRobotJoints, mass_matrix[i].at);
  }
  copy(LaneRows::kEndQ, end_q_.data());
  copy(LaneRows::kEndV, end_v_.data());
  prepared_ = false;
}

void RobotStep::begin(const RobotModel& robot, const double* qpos, const double* qvel) {
  std::copy_n(qpos, kRobotJoints, q.begin());
  std::copy_n(qvel, kRobotJoints, v.begin());
  LinkPose<double> links[kArmJoints];
  link_poses(robot, qpos, links);
  const RobotDynamics<double> dynamics(robot, qpos, links);
  dynamics.mass_matrix(mass_matrix);
  dynamics.bias_force(qvel, bias_force.data());
  prepared_ = false;
}

void RobotStep::prepare() {
  prepared_ = true;
  joints_.inv_mass = mass_matrix;
  std::copy(v.begin(), v.end(), joints_.begin_v.at);
  std::copy(bias_force.begin(), bias_force.end(), joints_.bias_force.at);
  joints_.prepare(params_);
}

void RobotStep::run(const JointArray& force) {
  if (!prepared_) prepare();
  force_ = force;
  JointsOf<double> contact_dv;
  for (int i = 0; i < kRobotJoints; ++i) {
    const double value = force[static_cast<std::size_t>(i)];
    if (value != 0) add_scaled(contact_dv, joints_.dt * value, joints_.inv_mass[i]);
  }
  std::copy(q.begin(), q.end(), joints_.end_q.at);
  saturated_ = {};
  joints_.run(params_, force == JointArray{} ? nullptr : &contact_dv, &saturated_);
  std::copy_n(joints_.end_q.at, kRobotJoints, end_q_.begin());
  std::copy_n(joints_.end_v.at, kRobotJoints, end_v_.begin());
}

void RobotStep::integrate_constant_velocity(const JointArray& velocity) {
  for (std::size_t i = 0; i < kRobotJoints; ++i) {
    end_v_[i] = velocity[i];
    end_q_[i] = std::clamp(q[i] + params_.timestep * velocity[i], std::min(params_.lower[i], q[i]),
                           std::max(params_.upper[i], q[i]));
  }
}

// Response of velocities to forces over the substep, in four implicit steps instead of the
// iterations, whose own response is not symmetric. The difference between the two is below a
// quarter.
JointMatrix RobotStep::effective_mass_matrix() const {
  constexpr int kDoublings = 2;
  const double h = params_.timestep;
  const double part = h / (1 << kDoublings);
  const double coupling = h * h * kCouplingStiffness;
  JointMatrix response = mass_matrix;
  for (int i = 0; i < kRobotJoints; ++i) {
    const double unsaturated = 1 - saturated_[i] / kSolverIterations;
    response[i][i] += unsaturated * part * (params_.drive.damping + 0.5 * h * joints_.stiffness[i]);
  }
  response[kLeftFinger][kLeftFinger] += coupling;
  response[kRightFinger][kRightFinger] += coupling;
  response[kLeftFinger][kRightFinger] -= coupling;
  response[kRightFinger][kLeftFinger] -= coupling;
  invert(response);
  JointMatrix decay = product(response, mass_matrix);  // of velocities, over the steps so far
  for (JointRow& row : response.row) {
    for (double& value : row.at) value *= part;
  }
  for (int i = 0; i < kDoublings; ++i) {
    if (i > 0) decay = product(decay, decay);
    const JointMatrix later = product(decay, response);
    for (int row = 0; row < kRobotJoints; ++row) add_scaled(response[row], 1.0, later[row]);
  }
  invert(response);
  for (int i = 0; i < kRobotJoints; ++i) {
    for (double& value : response[i].at) value *= h;
    // A limit holds a contact that pushes into it.
    const double force = force_[static_cast<std::size_t>(i)];
    const bool held =
        (joints_.lower_impulse[i] > 0 && force < 0) || (joints_.upper_impulse[i] < 0 && force > 0);
    if (held) response[i][i] *= kHeldMass;
  }
  return response;
}

}  // namespace engram
