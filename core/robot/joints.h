// How many joints the robot has.
#pragma once

namespace engram {

inline constexpr int kArmJoints = 7;
inline constexpr int kFingers = 2;
inline constexpr int kRobotJoints = kArmJoints + kFingers;  // qpos order: arm, left, right finger

}  // namespace engram
