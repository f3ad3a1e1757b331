#include "core/physics/drive.h"

#include <algorithm>

namespace engram {

void apply_drive(const DriveLaw& law, const Drive& drive, mjData& data) {
  std::array<double, kRobotJoints> force;
  for (std::size_t joint = 0; joint < kRobotJoints; ++joint) {
    force[joint] = -law.damping * data.qvel[joint];
  }
  for (std::size_t joint = drive.velocity_mode ? kArmJoints : 0; joint < kRobotJoints; ++joint) {
    force[joint] += law.stiffness * (drive.target[joint] - data.qpos[joint]);
  }
  for (std::size_t joint = 0; joint < kArmJoints; ++joint) {
    force[joint] += law.damping * drive.velocity[joint];
  }
  for (std::size_t joint = 0; joint < kRobotJoints; ++joint) {
    data.ctrl[joint] = std::clamp(force[joint], -law.limit, law.limit);
  }
}

}  // namespace engram
