// The mug of the shell games: hollow in renderings, solid in collisions. See
// docs/tasks/shell_game.md.
#pragma once

#include <numbers>
#include <string>

#include "mjcf/prop.h"

namespace engram::mjcf {

// Scale of the benchmark's mug, relative to the scan. Lengths here and in mug.cc are of a mug of
// that scale.
inline constexpr double kMugScale = 1.3;

// Height of the origin of a mug that stands on its rim or on its foot.
inline constexpr double kMugRestingHeight = 0.0529462;  // m

// Direction of the handle, about +z from +x, in the frame of the scanned mug.
inline constexpr double kMugHandleYaw = -34.1 * std::numbers::pi / 180;  // rad

// Radius of the largest ball about the origin that the wall hides, seen from above.
inline constexpr double kMugHides = 0.0433;  // m

// +z goes from foot to rim; the origin is the middle of the scan's bounding box. `handle_yaw` turns
// the whole mug about +z so that its handle points that way. Its density is the same at any scale.
Prop mug(const std::string& name, double handle_yaw = kMugHandleYaw, double scale = kMugScale);

}  // namespace engram::mjcf
