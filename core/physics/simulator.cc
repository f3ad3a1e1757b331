#include "core/physics/simulator.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/physics/step.h"

namespace engram {

void apply_drive(const DriveLaw& law, const Drive& drive, mjData& data) {
  std::array<double, kRobotJoints> force;
  for (std::size_t joint = 0; joint < kRobotJoints; ++joint) {
    force[joint] = -law.damping * data.qvel[joint];
  }
  for (std::size_t joint = drive.velocity_mode ? kArmJoints : 0; joint < kRobotJoints; ++joint) {
    force[joint] += law.stiffness * (drive.target[joint] - data.qpos[joint]);
  }
  for (std::size_t joint = 0; joint < kArmJoints; ++joint) {
    force[joint] += law.damping * drive.velocity[joint];
  }
  for (std::size_t joint = 0; joint < kRobotJoints; ++joint) {
    data.ctrl[joint] = std::clamp(force[joint], -law.limit, law.limit);
  }
}

Physics::Physics(const PhysicsModel& model, const PhysicsOptions& options, int workers,
                 int num_envs)
    : model_(model), options_(options), clearances_(static_cast<std::size_t>(num_envs)) {
  const std::size_t props = model.props().size();
  workbenches_.resize(static_cast<std::size_t>(workers));
  for (Workbench& bench : workbenches_) {
    for (const SceneModel& scene : model.scenes()) {
      bench.scenes.push_back(make_data(*scene.model));
      bench.sieves.emplace_back(*scene.model);
    }
    bench.status.resize(props);
    bench.slot.resize(props);
    bench.awake_by_type.resize(static_cast<std::size_t>(model.num_types()));
    bench.motion.resize(props);
    bench.frames.resize(props);
    bench.frame_known.resize(props);
    bench.centers.resize(props);
    bench.obstacles.reserve(props);
    bench.beyond.resize(props);
    bench.gliding.reserve(props);
  }
}

bool Physics::step(const State& state, int env, int worker, const Drive& drive,
                   StepClock::Worker* clock) {
  if (options_.substeps == 0) return true;
  Workbench& bench = workbenches_[static_cast<std::size_t>(worker)];
  const MujocoScope scope;
  bool good = false;
  try {
    good = Step(*this, bench, state, env, drive, clock).run();
  } catch (const Error&) {
    // MuJoCo gave up in the middle of a step; nothing has been stored.
  }
  if (!good) {
    for (std::size_t i = 0; i < bench.scenes.size(); ++i) {
      mj_resetData(model_.scenes()[i].model.get(), bench.scenes[i].get());
    }
  }
  return good;
}

void Physics::update_tcp(const State& state, int env) const {
  const Pose pose = model_.arm().forward(state.qpos.row(env));
  Eigen::Map<Eigen::Vector3d>(state.tcp_pos.row(env)) = pose.pos;
  double* quat = state.tcp_quat.row(env);
  quat[0] = pose.quat.w();
  quat[1] = pose.quat.x();
  quat[2] = pose.quat.y();
  quat[3] = pose.quat.z();
}

}  // namespace engram
