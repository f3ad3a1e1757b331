// How near bodies are to count as touching: contacts act before bodies touch, on the way of a
// substep.
#pragma once

namespace engram {

// Contacts act at gaps of up to so many times the displacement that the bodies' speeds at the
// substep's start make in it.
inline constexpr double kApproach = 1.5;
// What the margins of a clearance (RobotBounds) leave for that, m: faster robots need more.
inline constexpr double kClearanceAllowance = 0.016;

}  // namespace engram
