// A task's scene as one MJCF text: robot, table, ground, lights, cameras and the task's props.
#pragma once

#include <string>
#include <vector>

#include "mjcf/prop.h"

namespace engram::mjcf {

// The three cameras that people and sensors look through. See docs/cameras.md.
enum class RenderCamera { kA, kB, kC };

struct Scene {
  std::vector<Prop> props;  // in the order in which tasks index them
  RenderCamera render_camera = RenderCamera::kA;
  bool table_ends = false;  // props can fall off the table; otherwise its top has no end
};

// What a document contains. The robot's bodies, joints and actuators come first and are the same
// in all of them, so that robot indices agree between the compiled models.
enum class Detail {
  kFull,       // everything, visual geometry, lights and cameras included: for tools and renderers
  kPhysics,    // what moves or collides: robot, table, props
  kRobotOnly,  // the same without props
  kRobotDynamics,  // the robot's bodies, joints and drives; nothing that can be touched
};

// Returns the MJCF text. Bodies are link0..link7, hand, camera_link, leftfinger, rightfinger and
// the props by name; the TCP is the site "tcp".
std::string compose(const Scene& scene, Detail detail);

}  // namespace engram::mjcf
