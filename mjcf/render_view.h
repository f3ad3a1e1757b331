// Views of render_camera, the camera for people.
#pragma once

namespace engram::mjcf {

// Named by what is seen. See docs/robot.md.
enum class RenderView {
  kRobotAndTable,  // from (0.5, 1, 1) at (-0.3, 0, 0)
  kTable,          // from (0.6, 0.7, 0.6) at (0, 0, 0.15)
  kAboveTable,     // from there at (0, 0, 0.35), for what is lifted
};

}  // namespace engram::mjcf
