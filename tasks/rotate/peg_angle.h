// Angles of the Rotate families: targets, the turn of a peg so far, and the rest.
#pragma once

#include <numbers>
#include <string>

namespace engram::tasks {

inline constexpr double kPi = std::numbers::pi;
inline constexpr int kPeg = 0;  // index among the props

enum class RotateMode { kPosAngle, kPosNegAngle };

// The nearest half-precision number; ties go to the even one.
double round_to_half(double value);

// The largest target, rad.
double largest_angle(RotateMode mode);

// The target for a uniform number of [0, 1): rad, in half precision; `least` is the smallest. In
// pos_neg_angle sign and magnitude come from the same number: positive targets are large, negative
// ones small.
double target_angle(RotateMode mode, double least, double u);

// Probability that two targets are less than the smallest one apart: the share of guesses that are
// right.
double guess_rate(RotateMode mode, double least);

// An angle in [-pi, pi).
double wrap_angle(double angle);

// The third angle of the intrinsic X-Y-Z decomposition of a quaternion (w, x, y, z) of any length:
// the yaw, for a peg that lies flat.
double peg_angle(const double* quat);

struct PegTurn {
  double relative = 0;  // turned since the episode began, rad
  double error = 0;     // still to be turned, rad
};
PegTurn peg_turn(double angle, double initial_angle, double target);

// The family's instruction with the target in whole degrees.
std::string rotate_instruction(const std::string& text, double target);

}  // namespace engram::tasks
