#include "mjcf/drawn_props.h"

#include <algorithm>

namespace engram::mjcf {
namespace {

// Parking lot of hidden props, m: two metres under the ground, out of every camera's sight.
constexpr double kParkingHeight = -3;
constexpr double kParkingPitch = 0.5;

void park(Prop& prop, std::size_t index) {
  prop.pos = {0, kParkingPitch * static_cast<double>(index), kParkingHeight};
  prop.quat = {1, 0, 0, 0};
  for (Geom& geom : prop.geoms) geom.collides = false;
}

}  // namespace

std::vector<Prop> drawn_props(const std::vector<Prop>& props, const DrawnScene& drawn) {
  std::vector<Prop> result = props;
  for (std::size_t i = 0; i < result.size(); ++i) {
    const DrawnProp& now = drawn.props[i];
    if (now.rgba[3] > 0) {
      for (Geom& geom : result[i].geoms) geom.rgba = now.rgba;
    }
    result[i].pos = now.pos;
    result[i].quat = now.quat;
    if (now.hidden) park(result[i], i);
  }
  return result;
}

}  // namespace engram::mjcf
