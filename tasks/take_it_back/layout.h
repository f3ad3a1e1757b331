// Layout of TakeItBack: its props, and the slots of the cube.
#pragma once

#include <Eigen/Core>

namespace engram::tasks {

// Props of the scene, each at its index.
enum TakeItBackProp { kCube, kInitialRegion, kGoalRegion, kChangedGoalRegion, kProps };

// Slots of the cube lie side by side; the agent has to remember which one it was.
inline constexpr int kSlots = 3;
inline constexpr double kSlotPitch = 0.1;  // m
inline constexpr double kSlotWidth = 0.05;

// slot: -1, 0 or 1.
inline Eigen::Vector2d middle_of_slot(int slot) { return {0, kSlotPitch * slot + kSlotWidth / 2}; }

}  // namespace engram::tasks
