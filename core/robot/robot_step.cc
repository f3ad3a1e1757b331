#include "core/robot/robot_step.h"

#include <algorithm>

#include "core/robot/lane_kernel.h"
#include "core/robot/robot_dynamics.h"

namespace engram {
namespace {

// Times its own: the inertia of a joint at its limit.
constexpr double kHeldInertia = 1000;

constexpr std::size_t kJoints = kRobotJoints;
constexpr std::size_t kLeft = kArmJoints;
constexpr std::size_t kRight = kArmJoints + 1;

// row += scale * other
void add_scaled(JointRow& row, double scale, const JointRow& other) {
  for (std::size_t i = 0; i < row.size(); ++i) row[i] += scale * other[i];
}

JointMatrix product(const JointMatrix& a, const JointMatrix& b) {
  JointMatrix result{};
  for (std::size_t i = 0; i < kJoints; ++i) {
    for (std::size_t k = 0; k < kJoints; ++k) add_scaled(result[i], a[i][k], b[k]);
  }
  return result;
}

}  // namespace

// Gauss and Jordan; such matrices need no pivoting.
JointMatrix inverse(JointMatrix m) {
  for (std::size_t k = 0; k < kJoints; ++k) {
    const double pivot = 1 / m[k][k];
    m[k][k] = 1;
    for (double& value : m[k]) value *= pivot;
    for (std::size_t i = 0; i < kJoints; ++i) {
      if (i == k) continue;
      const double factor = m[i][k];
      m[i][k] = 0;
      add_scaled(m[i], -factor, m[k]);
    }
  }
  return m;
}

double drive_stiffness(const RobotParams& law, const Drive& drive, int joint) {
  return drive.velocity_mode && joint < kArmJoints ? 0.0 : law.drive.stiffness;
}

double drive_aim(const RobotParams& law, const Drive& drive, int joint) {
  const auto i = static_cast<std::size_t>(joint);
  const double aim = drive_stiffness(law, drive, joint) * drive.target[i];
  return joint < kArmJoints ? aim + law.drive.damping * drive.velocity[i] : aim;
}

RobotStep::RobotStep(const RobotParams& law, const Drive& drive) : law_(law) {
  for (int i = 0; i < kRobotJoints; ++i) {
    joints_.stiffness[i] = drive_stiffness(law, drive, i);
    joints_.aim[i] = drive_aim(law, drive, i);
  }
}

void RobotStep::take(const double* rows, int lanes, int lane) {
  const auto copy = [=](int first, double* to, int count) {
    for (int i = 0; i < count; ++i) to[i] = rows[(first + i) * lanes + lane];
  };
  copy(LaneRows::kQ, q.data(), kRobotJoints);
  copy(LaneRows::kV, v.data(), kRobotJoints);
  copy(LaneRows::kBias, bias.data(), kRobotJoints);
  for (int i = 0; i < kRobotJoints; ++i) {
    copy(LaneRows::kInertia + i * kRobotJoints, inertia[static_cast<std::size_t>(i)].data(),
         kRobotJoints);
  }
  copy(LaneRows::kEndQ, end_q_.data(), kRobotJoints);
  copy(LaneRows::kEndV, end_v_.data(), kRobotJoints);
  prepared_ = false;
}

void RobotStep::begin(const RobotModel& chain, const double* qpos, const double* qvel) {
  std::copy_n(qpos, kRobotJoints, q.begin());
  std::copy_n(qvel, kRobotJoints, v.begin());
  LinkPose<double> links[kArmJoints];
  link_poses(chain, qpos, links);
  const RobotDynamics<double> dynamics(chain, qpos, links);
  JointMatrixOf<double> matrix;
  dynamics.inertia(matrix);
  for (std::size_t i = 0; i < kJoints; ++i) {
    std::copy_n(matrix[static_cast<int>(i)].at, kRobotJoints, inertia[i].begin());
  }
  dynamics.bias(qvel, bias.data());
  prepared_ = false;
}

void RobotStep::prepare() {
  prepared_ = true;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const int joint = static_cast<int>(i);
    for (std::size_t k = 0; k < kJoints; ++k) joints_.w[joint][static_cast<int>(k)] = inertia[i][k];
    joints_.w[joint][kRobotJoints] = 0;
    joints_.begin_v[joint] = v[i];
    joints_.bias[joint] = bias[i];
  }
  joints_.prepare(law_);
}

void RobotStep::run(const JointArray& force) {
  if (!prepared_) prepare();
  force_ = force;
  JointsOf<double> pushed;
  for (int i = 0; i < kRobotJoints; ++i) {
    const double value = force[static_cast<std::size_t>(i)];
    if (value != 0) add_scaled(pushed, joints_.hh * value, joints_.w[i]);
  }
  std::copy(q.begin(), q.end(), joints_.end_q.at);
  spent_ = {};
  joints_.run(law_, force == JointArray{} ? nullptr : &pushed, &spent_);
  std::copy_n(joints_.end_q.at, kJoints, end_q_.begin());
  std::copy_n(joints_.end_v.at, kJoints, end_v_.begin());
}

void RobotStep::move_evenly(const JointArray& velocity) {
  for (std::size_t i = 0; i < kJoints; ++i) {
    end_v_[i] = velocity[i];
    end_q_[i] = std::clamp(q[i] + law_.timestep * velocity[i], std::min(law_.lower[i], q[i]),
                           std::max(law_.upper[i], q[i]));
  }
}

// Response of velocities to forces over the substep, in four implicit steps instead of the
// iterations, whose own response is not symmetric. What is left between the two is below a quarter.
JointMatrix RobotStep::effective_inertia() const {
  constexpr int kDoublings = 2;
  const double h = law_.timestep;
  const double part = h / (1 << kDoublings);
  const double coupling = h * h * kCouplingStiffness;
  JointMatrix resisting = inertia;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double free = 1 - spent_[static_cast<int>(i)] / kSolverIterations;
    resisting[i][i] += free * part * (law_.drive.damping + 0.5 * h * joints_.stiffness[i]);
  }
  resisting[kLeft][kLeft] += coupling;
  resisting[kRight][kRight] += coupling;
  resisting[kLeft][kRight] -= coupling;
  resisting[kRight][kLeft] -= coupling;
  JointMatrix response = inverse(resisting);
  JointMatrix decay = product(response, inertia);  // of velocities, over the steps so far
  for (JointRow& row : response) {
    for (double& value : row) value *= part;
  }
  for (int i = 0; i < kDoublings; ++i) {
    if (i > 0) decay = product(decay, decay);
    const JointMatrix later = product(decay, response);
    for (std::size_t row = 0; row < kJoints; ++row) add_scaled(response[row], 1, later[row]);
  }
  JointMatrix mass = inverse(response);
  for (std::size_t i = 0; i < kJoints; ++i) {
    for (double& value : mass[i]) value *= h;
    // A limit holds what a contact pushes into it.
    const int joint = static_cast<int>(i);
    const bool held = (joints_.at_lower[joint] > 0 && force_[i] < 0) ||
                      (joints_.at_upper[joint] < 0 && force_[i] > 0);
    if (held) mass[i][i] *= kHeldInertia;
  }
  return mass;
}

}  // namespace engram
