#include "core/image/image_changes.h"

#include "core/math/real_functions.h"

namespace engram {
namespace {

Mat3 rotation_about(int axis, double angle) {
  const double c = real::cos(angle);
  const double s = real::sin(angle);
  const int i = (axis + 1) % 3;
  const int j = (axis + 2) % 3;
  Mat3 matrix = Mat3::Identity();
  matrix(i, i) = c;
  matrix(j, j) = c;
  matrix(i, j) = -s;
  matrix(j, i) = s;
  return matrix;
}

}  // namespace

Frame moved(const Frame& camera, const CameraChange& change) {
  const auto& [right, up, backward] = change.rotation;
  const Mat3 turn = rotation_about(2, backward) * rotation_about(1, up) * rotation_about(0, right);
  return {camera.pos + camera.axes * Vec3(change.offset[0], change.offset[1], change.offset[2]),
          camera.axes * turn};
}

}  // namespace engram
