#include "core/physics/robot_step.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace engram {
namespace {

constexpr int kIterations = 15;
constexpr double kLinkDamping = 0.05;       // 1/s, of the arm's turning
constexpr double kCouplingStiffness = 1e5;  // N/m, between the fingers

// Free rotation is integrated explicitly, in reach of no drive: wrist joints that spin faster than
// this would gain speed from it. rad/s, m/s; PhysX's limit as well.
constexpr double kFastest = 100;

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

RobotStep::RobotStep(const Law& law, const Drive& drive)
    : law_(law), hh_(law.timestep / kIterations), most_(law.drive.limit * law.timestep) {
  stiffness_.fill(law.drive.stiffness);
  if (drive.velocity_mode) std::fill_n(stiffness_.begin(), kArmJoints, 0.0);
  for (std::size_t i = 0; i < kJoints; ++i) {
    aim_[i] = stiffness_[i] * drive.target[i];
    if (i < kArmJoints) aim_[i] += law.drive.damping * drive.velocity[i];
    resistance_[i] = law.drive.damping + hh_ * stiffness_[i];
  }
}

void RobotStep::prepare() {
  w_ = inverse(inertia);
  for (std::size_t i = 0; i < kJoints; ++i) {
    gain_[i] = hh_ / (1 + w_[i][i] * hh_ * resistance_[i]);
    brake_[i] = gain_[i] * resistance_[i];
    couple_[i] = w_[i][kLeft] - w_[i][kRight];
    begin_v_[i] = i < kArmJoints ? v[i] * (1 - kLinkDamping * law_.timestep) : v[i];
  }
  const double give = couple_[kLeft] - couple_[kRight];
  couple_gain_ = hh_ * kCouplingStiffness / (1 + give * hh_ * hh_ * kCouplingStiffness);
  for (std::size_t i = 0; i < kJoints; ++i) add_scaled(begin_v_, -law_.timestep * bias[i], w_[i]);
}

void RobotStep::run(const JointArray& force) {
  force_ = force;
  JointRow pushed{};
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (force[i] != 0) add_scaled(pushed, hh_ * force[i], w_[i]);
  }
  const bool is_pushed = pushed != JointRow{};
  JointRow speed = begin_v_;
  end_q_ = q;
  driven_ = spent_ = at_lower_ = at_upper_ = {};
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    if (is_pushed) add_scaled(speed, 1, pushed);
    couple_fingers(speed);
    for (std::size_t i = 0; i < kJoints; ++i) {
      pull_[i] = gain_[i] * (aim_[i] - stiffness_[i] * end_q_[i]);
    }
    [&]<std::size_t... kJoint>(std::index_sequence<kJoint...>) { (move_joint(kJoint, speed), ...); }
    (std::make_index_sequence<kJoints>());
    for (std::size_t i = 0; i < kJoints; ++i) end_q_[i] += hh_ * speed[i];
  }
  for (std::size_t i = 0; i < kJoints; ++i) {
    end_v_[i] = std::clamp(speed[i], -kFastest, kFastest);
  }
}

void RobotStep::move_evenly(const JointArray& velocity) {
  for (std::size_t i = 0; i < kJoints; ++i) {
    end_v_[i] = velocity[i];
    end_q_[i] = std::clamp(q[i] + law_.timestep * velocity[i], std::min(law_.lower[i], q[i]),
                           std::max(law_.upper[i], q[i]));
  }
}

// An undamped spring, taken implicitly.
inline void RobotStep::couple_fingers(JointRow& speed) const {
  const double apart = end_q_[kLeft] - end_q_[kRight] + hh_ * (speed[kLeft] - speed[kRight]);
  add_scaled(speed, -couple_gain_ * apart, couple_);
}

// The drive's impulse, and those of the limits: a joint goes no faster than to its limit.
inline void RobotStep::move_joint(std::size_t joint, JointRow& speed) {
  double impulse = pull_[joint] - brake_[joint] * speed[joint];
  const double sum = driven_[joint] + impulse;
  if (std::abs(sum) >= most_) [[unlikely]] {
    impulse = std::clamp(sum, -most_, most_) - driven_[joint];
    spent_[joint] += 1.0 / kIterations;
  }
  add_scaled(speed, impulse, w_[joint]);
  driven_[joint] += impulse;
  const double way = hh_ * speed[joint];
  const double to_lower = law_.lower[joint] - end_q_[joint];
  const double to_upper = law_.upper[joint] - end_q_[joint];
  if (way < to_lower || way > to_upper || at_lower_[joint] > 0 || at_upper_[joint] < 0)
      [[unlikely]] {
    stop_at_limits(joint, speed);
  }
}

// A limit pushes one way only.
void RobotStep::stop_at_limits(std::size_t joint, JointRow& speed) {
  const double excess_below = (law_.lower[joint] - end_q_[joint]) / hh_ - speed[joint];
  const double up = std::max(0.0, at_lower_[joint] + excess_below / w_[joint][joint]);
  add_scaled(speed, up - at_lower_[joint], w_[joint]);
  at_lower_[joint] = up;
  const double excess_above = (law_.upper[joint] - end_q_[joint]) / hh_ - speed[joint];
  const double down = std::min(0.0, at_upper_[joint] + excess_above / w_[joint][joint]);
  add_scaled(speed, down - at_upper_[joint], w_[joint]);
  at_upper_[joint] = down;
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
    resisting[i][i] += (1 - spent_[i]) * part * (law_.drive.damping + 0.5 * h * stiffness_[i]);
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
    const bool held = (at_lower_[i] > 0 && force_[i] < 0) || (at_upper_[i] < 0 && force_[i] > 0);
    if (held) mass[i][i] *= kHeldInertia;
  }
  return mass;
}

}  // namespace engram
