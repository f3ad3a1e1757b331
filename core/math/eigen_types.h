// Short names of Eigen's types.
#pragma once

#include <Eigen/Dense>

namespace engram {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using RowMat3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using Quat = Eigen::Quaterniond;

}  // namespace engram
