#include "tasks/rotate/peg_angle.h"

#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <string>

namespace engram {
namespace {

using tasks::RotateMode;

constexpr double kPi = std::numbers::pi;

TEST_CASE("Targets are half-precision numbers", "[rotate]") {
  CHECK(tasks::round_to_half(0.1) == Approx(0.0999756).margin(1e-7));
  CHECK(tasks::round_to_half(0.467699) == Approx(0.4677734).margin(1e-7));
  CHECK(tasks::round_to_half(0.835398) == Approx(0.8354492).margin(1e-7));
  CHECK(tasks::round_to_half(1.203097) == 1.203125);
  CHECK(tasks::round_to_half(1.570795) == 1.5703125);
  CHECK(tasks::round_to_half(-0.442699) == Approx(-0.4426270).margin(1e-7));
}

TEST_CASE("Targets and their degrees follow from the draw", "[rotate]") {
  struct Row {
    double u, pos;
    const char* pos_degrees;
    double pos_neg;
    const char* pos_neg_degrees;
  };
  const Row table[] = {{0, 0.0999756, "6", -0.0999756, "-6"},
                       {0.25, 0.4677734, "27", -0.2712402, "-16"},
                       {0.5, 0.8354492, "48", -0.4426270, "-25"},
                       {0.75, 1.203125, "69", 0.6142578, "35"},
                       {0.999999, 1.5703125, "90", 0.78515625, "45"}};
  const std::string text = "Rotate the peg by {angle_deg} degrees to match the target angle.";
  for (const Row& row : table) {
    const double pos = tasks::target_angle(RotateMode::kPosAngle, 0.1, row.u);
    const double both = tasks::target_angle(RotateMode::kPosNegAngle, 0.1, row.u);
    CHECK(pos == Approx(row.pos).margin(1e-7));
    CHECK(both == Approx(row.pos_neg).margin(1e-7));
    CHECK(tasks::rotate_instruction(text, pos) == "Rotate the peg by " +
                                                      std::string(row.pos_degrees) +
                                                      " degrees to match the target angle.");
    CHECK(tasks::rotate_instruction(text, both) == "Rotate the peg by " +
                                                       std::string(row.pos_neg_degrees) +
                                                       " degrees to match the target angle.");
  }
}

TEST_CASE("Angles wrap to half-open turns", "[rotate]") {
  CHECK(tasks::wrap_angle(kPi) == -kPi);
  CHECK(tasks::wrap_angle(-kPi) == -kPi);
  CHECK(tasks::wrap_angle(0.3) == Approx(0.3));
  CHECK(tasks::wrap_angle(7) == Approx(7 - 2 * kPi));
  CHECK(tasks::wrap_angle(-7) == Approx(2 * kPi - 7));

  struct Row {
    double initial, angle, target, relative, error;
  };
  const Row table[] = {{6.0, 0.2, 0.8, 0.483185, 0.316619}, {1.0, 0.5, 0.3, -0.5, 0.800049},
                       {3.0, 3.3, -0.4, 0.3, -0.699902},    {0.1, 6.2, -0.3, -0.183185, -0.116864},
                       {0, -2.5, 1.5, -2.5, -2.283185},     {0, 3.0, -0.4, 3.0, 2.883283}};
  for (const Row& row : table) {
    const tasks::PegTurn turn =
        tasks::peg_turn(row.angle, row.initial, tasks::round_to_half(row.target));
    INFO(row.initial << " " << row.angle);
    CHECK(turn.relative == Approx(row.relative).margin(2e-6));
    CHECK(turn.error == Approx(row.error).margin(2e-6));
  }
}

TEST_CASE("The angle is that of the X-Y-Z decomposition", "[rotate]") {
  using Eigen::AngleAxisd, Eigen::Quaterniond, Eigen::Vector3d;
  const auto angle = [](const Quaterniond& q, double length = 1) {
    const double quat[4] = {length * q.w(), length * q.x(), length * q.y(), length * q.z()};
    return tasks::peg_angle(quat);
  };
  const Quaterniond yaw(AngleAxisd(0.7, Vector3d::UnitZ()));
  CHECK(angle(yaw) == Approx(0.7));
  CHECK(angle(yaw, 3) == Approx(0.7));  // of any length
  CHECK(angle(AngleAxisd(0.3, Vector3d::UnitX()) * AngleAxisd(-0.2, Vector3d::UnitY()) * yaw) ==
        Approx(0.7));
  const auto rolled = [&](double degrees) {
    return angle(yaw * AngleAxisd(degrees * kPi / 180, Vector3d::UnitX()));
  };
  CHECK(rolled(20) == Approx(0.6695).margin(5e-5));
  CHECK(rolled(90) == Approx(0).margin(1e-9));
  CHECK(rolled(180) == Approx(-0.7));
}

}  // namespace
}  // namespace engram
