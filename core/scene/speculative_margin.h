// Margins of speculative contacts, which act before bodies touch, on the way of a
// substep.
#pragma once

namespace engram {

// Contacts act at gaps of up to this multiple of the displacement that the bodies' speeds at the
// substep's start make in it.
inline constexpr double kSpeculativeFactor = 1.5;
// Distances below these count as touching in a clearance (RobotBounds), m: of the robot to anything
// else, and between its own bodies.
inline constexpr double kContactMargin = 0.02;
inline constexpr double kSelfMargin = 0.01;
// What these margins leave for the way of a substep, m: faster robots need more.
inline constexpr double kClearanceAllowance = 0.016;

}  // namespace engram
