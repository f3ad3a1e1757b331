#include "core/math/rotations.h"

#include <catch2/catch.hpp>
#include <numbers>

namespace engram {
namespace {

TEST_CASE("The angle between orientations is that of the rotation from one to the other",
          "[math]") {
  const Eigen::Vector3d axis = Eigen::Vector3d(1, 2, -1).normalized();
  const Eigen::Quaterniond from = turn_about(Eigen::Vector3d::UnitX(), 0.4);
  for (const double angle : {0.0, 1e-9, 0.5, 2.0, std::numbers::pi}) {
    Eigen::Quaterniond to = from * turn_about(axis, angle);
    CHECK(angle_between(from, to) == Approx(angle).margin(1e-12));
    to.coeffs() *= -1;  // the same orientation
    CHECK(angle_between(from, to) == Approx(angle).margin(1e-12));
  }
}

TEST_CASE("A rotation about an axis leaves the axis where it is", "[math]") {
  const Eigen::Vector3d axis = Eigen::Vector3d(0.2, -1, 0.5).normalized();
  CHECK((turn_about(axis, 1.3) * axis - axis).norm() < 1e-15);
  CHECK((turn_about(Eigen::Vector3d::UnitZ(), std::numbers::pi / 2) * Eigen::Vector3d::UnitX() -
         Eigen::Vector3d::UnitY())
            .norm() < 1e-15);
}

}  // namespace
}  // namespace engram
