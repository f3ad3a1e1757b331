// A task's scene as one MJCF text: robot, table, ground, lights, cameras and the task's props.
#pragma once

#include <string>
#include <vector>

#include "core/task/drawn_scene.h"
#include "mjcf/prop.h"
#include "mjcf/render_view.h"

namespace engram::mjcf {

struct Scene {
  std::vector<Prop> props;  // in the order in which tasks index them
  RenderView render_view = RenderView::kRobotAndTable;
  bool table_ends = false;  // props can fall off the table; otherwise its top has no end
  // False: the plain Panda. The hand carries no camera: camera_link has neither mass nor geoms.
  bool wrist_camera = true;
};

// Contents of a document. The robot's bodies, joints and actuators come first and are the same
// in all of them, so that robot indices agree between the compiled models.
enum class Detail {
  kFull,       // everything, visual geometry, lights and cameras included: for tools and renderers
  kPhysics,    // moving and colliding bodies: robot, table, props
  kRobotOnly,  // the same without props
  kRobotDynamics,  // the robot's bodies, joints and drives; no collision geoms
};

// Returns the MJCF text. Bodies are link0..link7, hand, camera_link, leftfinger, rightfinger and
// the props by name; the TCP is the site "tcp".
std::string compose(const Scene& scene, Detail detail);

// Returns the text of everything in one drawn episode, for MuJoCo's own step: poses and colours are
// drawn, hidden props are parked without contact, the keyframe is that moment at rest, and
// actuators carry what has no weight in engram, the robot's links and hidden props.
std::string compose_drawn(const Scene& scene, const DrawnScene& drawn);

}  // namespace engram::mjcf
