// Scene of one environment at one moment: what its episode has drawn.
#pragma once

#include <array>
#include <vector>

namespace engram {

struct DrawnProp {
  std::array<double, 3> pos{};
  std::array<double, 4> quat{1, 0, 0, 0};  // (w, x, y, z)
  bool hidden = false;                     // not in the scene
  std::array<double, 4> rgba{};            // linear; instead of its own colour if alpha is positive
};

struct DrawnScene {
  std::array<double, 9> qpos{};  // seven arm joints, left finger, right finger
  std::vector<DrawnProp> props;  // in the task's order
};

}  // namespace engram
