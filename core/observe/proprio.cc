#include "core/observe/proprio.h"

namespace engram {

std::vector<Field> proprio_fields(bool joint_proprio) {
  const Field opening = {"gripper_opening", 1, DType::kFloat32, "m",
                         "sum of both fingers, 0 to 0.08"};
  if (joint_proprio) {
    return {{"joint_angles", 7, DType::kFloat32, "rad", "of the arm, from the base on"}, opening};
  }
  return {{"tcp_position", 3, DType::kFloat32, "m", "world frame"},
          {"roll", 1, DType::kFloat32, "rad", "about the fixed x axis, first"},
          {"pitch", 1, DType::kFloat32, "rad", "about the fixed y axis, second"},
          {"yaw", 1, DType::kFloat32, "rad", "about the fixed z axis, third"},
          opening};
}

}  // namespace engram
