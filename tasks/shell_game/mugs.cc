#include "tasks/shell_game/mugs.h"

#include <algorithm>

#include "mjcf/mug.h"

namespace engram::tasks {
namespace {

constexpr std::array<const char*, kCups> kNames = {"mug_left", "mug_center", "mug_right"};
constexpr double kBaseRange = 0.1;  // m

}  // namespace

// Half turns about horizontal axes at 26.57 and 68.20 degrees.
const MugStance kUpsideDown{mjcf::kMugHandleYaw, {0, 0.894427190999916, 0.447213595499958, 0}};
const MugStance kHandleTowardsRobot{0, {0, 0.371390676354104, 0.928476690885259, 0}};

Draw Mugs::base_draw() {
  return {"base", 2, false, -kBaseRange, kBaseRange, "m", "x, y of the center slot"};
}

Mugs::Mugs(mjcf::Scene& scene, const MugStance& stance) : stance_(stance) {
  for (int slot = 0; slot < kCups; ++slot) {
    mjcf::Prop mug = mjcf::mug(kNames[static_cast<std::size_t>(slot)], stance.handle_yaw);
    mug.pos = {0, (slot - 1) * MIN_DIST, mjcf::kMugRestingHeight};
    mug.quat = stance.quat;
    scene.props.push_back(std::move(mug));
  }
}

void Mugs::bind(const Bindings& bindings) {
  engine_ = bindings;
  base_ = bindings.memory->add<double>("base", 2, "m");
}

void Mugs::reset(const Episode& episode, int draw) const {
  const int env = episode.env();
  if (const double* pinned = episode.pinned(draw)) {
    std::copy_n(pinned, 2, base_.row(env));
  } else {
    RandomStream random = episode.stream(draw);
    for (int i = 0; i < 2; ++i) base_.row(env)[i] = random.uniform(-kBaseRange, kBaseRange);
  }
  for (int mug = 0; mug < kCups; ++mug) {
    const Eigen::Vector3d pos = slot_pos(env, mug, mjcf::kMugRestingHeight + HEIGHT_OFFSET);
    engine_.state->place_prop(env, mug, pos.data(), stance_.quat.data(), PropStatus::kHidden);
  }
}

Eigen::Vector3d Mugs::standing_pos(int env, int slot) const {
  return slot_pos(env, slot, mjcf::kMugRestingHeight);
}

void Mugs::stand(int env, int mug, const Eigen::Vector3d& pos) const {
  engine_.state->place_prop(env, mug, pos.data(), stance_.quat.data());
}

void Mugs::stand_all(int env) const {
  for (int mug = 0; mug < kCups; ++mug) stand(env, mug, mug);
}

}  // namespace engram::tasks
