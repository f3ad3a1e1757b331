// The cameras. See docs/robot.md.
#pragma once

#include "mjcf/render_view.h"
#include "mjcf/xml.h"

namespace engram::mjcf {

// base_camera and render_camera, fixed in the world.
void add_world_cameras(Element& worldbody, RenderView render_view);

// hand_camera, fixed in the hand.
void add_hand_camera(Element& hand);

}  // namespace engram::mjcf
