#include "core/sim/env_step.h"

namespace engram {

StepWorkspace::StepWorkspace(const PhysicsModel& model) {
  const std::size_t props = model.props().size();
  status.resize(props);
  awake_by_type.resize(at(model.num_types()));
  slot.resize(props);
  prop.reserve(props);
  motion.resize(props);
  moving.reserve(props);
  kinematic_bodies.reserve(props);
}

void EnvStep::wake(int prop) {
  ++num_awake;
  ++workspace.awake_by_type[at(prop_model(prop).type)];
  workspace.status[at(prop)] = PropStatus::kAwake;
  workspace.slot[at(prop)] = kNoSlot;
  PropMotion& motion = workspace.motion[at(prop)];
  std::copy_n(state.prop_pos_of(env, prop), 3, motion.qpos.begin());
  std::copy_n(state.prop_quat_of(env, prop), 4, motion.qpos.begin() + 3);
  std::copy_n(state.prop_qvel_of(env, prop), 6, motion.qvel.begin());
  std::copy_n(state.prop_qacc_warmstart.row(env) + 6 * prop, 6, motion.qacc_warmstart.begin());
}

}  // namespace engram
