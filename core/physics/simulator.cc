#include "core/physics/simulator.h"

#include "core/base/error.h"
#include "core/physics/loader.h"
#include "core/physics/stepper.h"
#include "core/physics/waker.h"

namespace engram {

struct Simulator::Workbench {
  explicit Workbench(const PhysicsModel& model) : loader(model), waker(model), stepper(model) {}

  Loader::Workbench loader;
  Waker::Workbench waker;
  Stepper::Workbench stepper;
};

Simulator::Simulator(const PhysicsModel& model, const SimulatorOptions& options, int workers,
                     int num_envs)
    : model_(model), options_(options), clearances_(at(num_envs)) {
  workbenches_.reserve(at(workers));
  for (int i = 0; i < workers; ++i) workbenches_.emplace_back(model);
}

Simulator::~Simulator() = default;

bool Simulator::step(const State& state, int env, int worker, const Drive& drive,
                     StepClock::Worker* clock) {
  if (options_.substeps == 0) return true;
  Workbench& workbench = workbenches_[at(worker)];
  const MujocoScope scope;
  bool good = false;
  try {
    good = advance(workbench, state, env, drive, clock);
  } catch (const Error&) {
    // MuJoCo gave up in the middle of a step; nothing has been stored.
  }
  if (!good) workbench.loader.reset_data();
  return good;
}

// The way of one control step. Returns false if physics diverged, before anything is stored.
bool Simulator::advance(Workbench& workbench, const State& state, int env, const Drive& drive,
                        StepClock::Worker* clock) {
  Loader loader(workbench.loader, state, env);
  Waker waker(workbench.waker, loader);
  Stepper stepper(workbench.stepper, loader, waker, clearances_[at(env)], drive, clock);

  if (!loader.state_is_plausible()) return false;
  loader.begin(options_.sleep);
  waker.begin();
  loader.enter(options_.sleep ? stepper.first_scene() : model_.full_scene());
  for (int i = 0; i < options_.substeps; ++i) {
    loader.glide(i, options_.substeps);
    mark(clock, StepPart::kGather);
    const bool good = options_.sleep ? stepper.composed_substep(i == 0) : stepper.plain_substep();
    if (!good) return false;
  }
  loader.glide(options_.substeps, options_.substeps);
  if (!loader.scene_is_plausible()) return false;
  loader.store();
  mark(clock, StepPart::kGather);
  if (options_.sleep) waker.put_to_sleep();
  mark(clock, StepPart::kWake);
  return true;
}

void Simulator::update_tcp(const State& state, int env) const {
  const Pose pose = model_.arm().forward(state.qpos.row(env));
  Eigen::Map<Eigen::Vector3d>(state.tcp_pos.row(env)) = pose.pos;
  double* quat = state.tcp_quat.row(env);
  quat[0] = pose.quat.w();
  quat[1] = pose.quat.x();
  quat[2] = pose.quat.y();
  quat[3] = pose.quat.z();
}

}  // namespace engram
