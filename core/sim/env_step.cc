#include "core/sim/env_step.h"

namespace engram {

StepWorkspace::StepWorkspace(const PhysicsModel& model)
    : bodies(model.collision()), contacts(model.collision()) {
  for (const CollisionBody& body : model.collision().bodies()) {
    const Attachment& attachment = body.attachment;
    const bool same = attachment.frame.pos.isZero(0) && attachment.frame.axes.isIdentity(0);
    is_link.push_back(attachment.link >= 0 && same ? 1 : 0);
  }
  const std::size_t props = model.props().size();
  status.resize(props);
  motion.resize(props);
  begin.resize(props);
  moving_pos.resize(props);
  awake.reserve(props);
  moving.reserve(props);
  reach_frames.resize(model.reach_shapes().size());
  reach_gaps.resize(model.reach_shapes().size());
  memory.pairs.reserve(at(max_near_pairs(model.collision())));
}

void EnvStep::wake(int prop) {
  workspace.status[at(prop)] = PropStatus::kAwake;
  workspace.awake.insert(std::lower_bound(awake().begin(), awake().end(), prop), prop);
  workspace.motion[at(prop)] = prop_model(prop).body.load(
      state.prop_pos_of(env, prop), state.prop_quat_of(env, prop), state.prop_qvel_of(env, prop));
  workspace.begin[at(prop)] = workspace.motion[at(prop)];
}

double EnvStep::prop_speed(int prop) const {
  const FreeBodyState& motion = workspace.motion[at(prop)];
  return motion.linear.norm() + motion.angular.norm() * prop_model(prop).bounding_radius;
}

}  // namespace engram
