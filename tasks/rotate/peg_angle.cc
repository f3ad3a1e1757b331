#include "tasks/rotate/peg_angle.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "core/math/real_functions.h"

namespace engram::tasks {
namespace {}  // namespace

double round_to_half(double value) {
  return static_cast<double>(static_cast<float>(Eigen::half(static_cast<float>(value))));
}

double largest_angle(RotateMode mode) {
  return mode == RotateMode::kPosNegAngle ? kPi / 4 : kPi / 2;
}

double target_angle(RotateMode mode, double least, double u) {
  const bool both = mode == RotateMode::kPosNegAngle;
  const double magnitude = least + u * (largest_angle(mode) - least);
  return round_to_half(both && u <= 0.5 ? -magnitude : magnitude);
}

// Targets of one sign lie in an interval, and those of different signs are too far apart.
double guess_rate(RotateMode mode, double least) {
  const int signs = mode == RotateMode::kPosNegAngle ? 2 : 1;
  const double share = std::min(1.0, signs * least / (largest_angle(mode) - least));
  return share * (2 - share) / signs;
}

double wrap_angle(double angle) {
  const double turned = angle + kPi;
  const double wrapped = turned - 2 * kPi * std::floor(turned / (2 * kPi)) - kPi;
  return wrapped < kPi ? wrapped : -kPi;
}

double peg_angle(const double* quat) {
  const double w = quat[0];
  const double x = quat[1];
  const double y = quat[2];
  const double z = quat[3];
  const double scale = 2 / (w * w + x * x + y * y + z * z);
  const double r00 = 1 - scale * (y * y + z * z);
  const double r01 = scale * (x * y - w * z);
  return real::atan2(-r01, r00);
}

PegTurn peg_turn(double angle, double initial_angle, double target) {
  const double relative = wrap_angle(angle - initial_angle);
  return {relative, wrap_angle(target - relative)};
}

std::string rotate_instruction(const std::string& text, double target) {
  const std::string place = "{angle_deg}";
  const auto degrees =
      static_cast<double>(static_cast<float>(target) * 180.0F / static_cast<float>(kPi));
  std::string result = text;
  return result.replace(result.find(place), place.size(),
                        std::to_string(std::lrint(degrees)));  // halves to even
}

}  // namespace engram::tasks
