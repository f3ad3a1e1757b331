#include "core/physics/robot_step.h"

#include <algorithm>
#include <cmath>

namespace engram {
namespace {

constexpr int kIterations = 15;
constexpr double kLinkDamping = 0.05;       // 1/s, of the arm's turning
constexpr double kCouplingStiffness = 1e5;  // N/m, between the fingers

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
    : law_(law), hh_(law.timestep / kIterations) {
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
    couple_[i] = w_[i][kLeft] - w_[i][kRight];
    begin_v_[i] = i < kArmJoints ? v[i] * (1 - kLinkDamping * law_.timestep) : v[i];
  }
  const double give = couple_[kLeft] - couple_[kRight];
  couple_gain_ = hh_ * kCouplingStiffness / (1 + give * hh_ * hh_ * kCouplingStiffness);
  for (std::size_t i = 0; i < kJoints; ++i) add_scaled(begin_v_, -law_.timestep * bias[i], w_[i]);
}

void RobotStep::run(const JointArray& force) {
  JointRow pushed{};
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (force[i] != 0) add_scaled(pushed, hh_ * force[i], w_[i]);
  }
  const bool is_pushed = pushed != JointRow{};
  speed_ = begin_v_;
  end_q_ = q;
  driven_ = spent_ = at_lower_ = at_upper_ = {};
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    if (is_pushed) add_scaled(speed_, 1, pushed);
    couple_fingers();
    for (std::size_t i = 0; i < kJoints; ++i) {
      drive_joint(i);
      stop_at_limits(i);
    }
    for (std::size_t i = 0; i < kJoints; ++i) end_q_[i] += hh_ * speed_[i];
  }
  std::copy_n(speed_.begin(), kJoints, end_v_.begin());
}

// An undamped spring, taken implicitly.
void RobotStep::couple_fingers() {
  const double apart = end_q_[kLeft] - end_q_[kRight] + hh_ * (speed_[kLeft] - speed_[kRight]);
  add_scaled(speed_, -couple_gain_ * apart, couple_);
}

// The limit is on the sum of this substep's impulses.
void RobotStep::drive_joint(std::size_t joint) {
  const double impulse = gain_[joint] * (aim_[joint] - stiffness_[joint] * end_q_[joint] -
                                         resistance_[joint] * speed_[joint]);
  const double most = law_.drive.limit * law_.timestep;
  const double sum = std::clamp(driven_[joint] + impulse, -most, most);
  push(joint, sum - driven_[joint]);
  driven_[joint] = sum;
  if (std::abs(sum) >= most) spent_[joint] += 1.0 / kIterations;
}

// A joint goes no faster than to its limit; a limit pushes one way only.
void RobotStep::stop_at_limits(std::size_t joint) {
  const double to_lower = (law_.lower[joint] - end_q_[joint]) / hh_ - speed_[joint];
  if (to_lower > 0 || at_lower_[joint] > 0) {
    const double sum = std::max(0.0, at_lower_[joint] + to_lower / w_[joint][joint]);
    push(joint, sum - at_lower_[joint]);
    at_lower_[joint] = sum;
  }
  const double to_upper = (law_.upper[joint] - end_q_[joint]) / hh_ - speed_[joint];
  if (to_upper < 0 || at_upper_[joint] < 0) {
    const double sum = std::min(0.0, at_upper_[joint] + to_upper / w_[joint][joint]);
    push(joint, sum - at_upper_[joint]);
    at_upper_[joint] = sum;
  }
}

void RobotStep::push(std::size_t joint, double impulse) { add_scaled(speed_, impulse, w_[joint]); }

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
    if (at_lower_[i] > 0 || at_upper_[i] < 0) mass[i][i] *= kHeldInertia;
  }
  return mass;
}

}  // namespace engram
