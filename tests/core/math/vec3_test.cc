// Vectors, matrices and quaternions against Eigen's.
#include "core/math/vec3.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/math/eigen_types.h"

namespace engram {
namespace {

const double kVector[3] = {0.3, -1.2, 2.5};

Vec3 to_eigen(const Vec3Of<double>& v) { return {v.x(), v.y(), v.z()}; }

TEST_CASE("Products of vectors are Eigen's", "[math]") {
  const Vec3Of<double> a = {1, -2, 0.5};
  const Vec3Of<double> b = {0.25, 3, -1};
  CHECK(dot(a, b) == to_eigen(a).dot(to_eigen(b)));
  CHECK((to_eigen(cross(a, b)) - to_eigen(a).cross(to_eigen(b))).norm() < 1e-15);
  CHECK(to_eigen(a + b * 2.0 - a) == to_eigen(b) * 2);
}

TEST_CASE("A quaternion rotates as its matrix does", "[math]") {
  const Quat quat = Quat(0.9, 0.1, -0.3, 0.2).normalized();
  const Mat3 matrix = quat.toRotationMatrix();
  const QuatOf<double> ours = {quat.w(), quat.x(), quat.y(), quat.z()};
  const Vec3 rotated = matrix * Eigen::Map<const Vec3>(kVector);
  CHECK((to_eigen(ours * kVector) - rotated).norm() < 1e-14);
  CHECK((to_eigen(ours.z_axis()) - matrix.col(2)).norm() < 1e-14);

  Mat3Of<double> rows;
  Eigen::Map<RowMat3>(rows.at) = matrix;
  CHECK((to_eigen(rows * kVector) - rotated).norm() < 1e-14);
  CHECK(to_eigen(rows.column(1)) == matrix.col(1));
  CHECK(to_eigen(rows.row(1)) == matrix.row(1).transpose());
}

TEST_CASE("Rotations about the own z axis agree", "[math]") {
  constexpr double kAngle = 0.7;
  const Quat quat = Quat(0.9, 0.1, -0.3, 0.2).normalized();
  Mat3Of<double> rows;
  Eigen::Map<RowMat3>(rows.at) = quat.toRotationMatrix();
  const QuatOf<double> ours = {quat.w(), quat.x(), quat.y(), quat.z()};
  const Mat3Of<double> matrix = rows.rotated_z(std::sin(kAngle), std::cos(kAngle));
  const QuatOf<double> half = ours.rotated_z(std::sin(kAngle / 2), std::cos(kAngle / 2));
  CHECK((to_eigen(matrix * kVector) - to_eigen(half * kVector)).norm() < 1e-14);
}

TEST_CASE("Lanes of vectors have the numbers of single ones", "[math]") {
  const auto lanes = broadcast_vec3<simd::Double>(kVector);
  const Vec3Of<double> single = {kVector[0], kVector[1], kVector[2]};
  for (int i = 0; i < simd::kDoubles; ++i) {
    CHECK(dot(lanes, lanes)[i] == dot(single, single));
    CHECK(cross(lanes, lanes)[2][i] == 0);
  }
}

}  // namespace
}  // namespace engram
