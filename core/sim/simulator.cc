#include "core/sim/simulator.h"

#include <algorithm>
#include <optional>
#include <string>

#include "core/base/error.h"
#include "core/robot/lane_block.h"
#include "core/sim/scene_binding.h"
#include "core/sim/sleep_manager.h"
#include "core/sim/stepper.h"

namespace engram {
namespace {

const LaneKernel& choose_kernel(int lanes) {
  if (lanes == 0) return widest_lane_kernel();
  const LaneKernel* kernel = lane_kernel(lanes);
  if (kernel != nullptr) return *kernel;
  std::string allowed = "0";
  for (int width = 1; width <= kMostLanes; width *= 2) {
    if (lane_kernel(width) != nullptr) allowed += ", " + std::to_string(width);
  }
  throw Error(Error::kInvalidArgument,
              "lanes: " + std::to_string(lanes) + " given; this processor allows: " + allowed);
}

void set_room(LaneBlock& block, int lane, const RobotBounds::Clearance& clearance) {
  const double room = clearance.room();
  block.put(LaneRows::kClearanceQpos, lane, clearance.qpos.data(), kRobotJoints);
  block.put(LaneRows::kClearance, lane, &room, 1);
}

}  // namespace

struct Simulator::Lane {
  Lane(SceneBinding::Workspace& loader_bench, SleepManager::Workspace& waker_bench,
       SceneWorkspace& scenes, const State& state, int env, RobotBounds::Clearance& clearance,
       const DriveTarget& drive, StepClock::Worker* clock)
      : loader(loader_bench, scenes, state, env),
        waker(waker_bench, loader),
        stepper(loader, waker, clearance, drive, clock) {}

  SceneBinding loader;
  SleepManager waker;
  Stepper stepper;
  bool good = true;
};

struct Simulator::Workspace {
  Workspace(const PhysicsModel& model, const LaneKernel& kernel) : scenes(model), block(kernel) {
    for (int i = 0; i < kernel.lanes; ++i) {
      loaders.emplace_back(model);
      wakers.emplace_back(model);
    }
  }

  SceneWorkspace scenes;
  LaneBlock block;
  // For each lane.
  std::vector<SceneBinding::Workspace> loaders;
  std::vector<SleepManager::Workspace> wakers;
  std::array<std::optional<Lane>, kMostLanes> lanes;
};

Simulator::Simulator(const PhysicsModel& model, const SimulatorOptions& options, int workers,
                     int num_envs)
    : model_(model),
      options_(options),
      kernel_(choose_kernel(options.lanes)),
      clearances_(at(num_envs)) {
  workbenches_.reserve(at(workers));
  for (int i = 0; i < workers; ++i) workbenches_.emplace_back(model, kernel_);
}

Simulator::~Simulator() = default;

LaneBlock& Simulator::block(int worker) { return workbenches_[at(worker)].block; }

bool Simulator::step(const State& state, int env, int worker, const DriveTarget& drive,
                     StepClock::Worker* clock) {
  bool good = true;
  step(state, env, worker, {&drive, 1}, &good, clock);
  return good;
}

void Simulator::step(const State& state, int first, int worker, std::span<const DriveTarget> drives,
                     bool* good, StepClock::Worker* clock) {
  const int count = static_cast<int>(drives.size());
  std::fill_n(good, count, true);
  if (options_.substeps == 0) return;
  Workspace& workspace = workbenches_[at(worker)];
  const MujocoScope scope;
  for (int lane = 0; lane < count; ++lane) {
    const int env = first + lane;
    const DriveTarget& drive = drives[at(lane)];
    workspace.lanes[at(lane)].emplace(workspace.loaders[at(lane)], workspace.wakers[at(lane)],
                                      workspace.scenes, state, env, clearances_[at(env)], drive,
                                      clock);
    for (int joint = 0; joint < kRobotJoints; ++joint) {
      const double aim = drive_bias(model_.robot_params(), drive, joint);
      workspace.block.put(LaneRows::kDriveBias + joint, lane, &aim, 1);
    }
    begin_lane(workspace, lane);
  }
  workspace.block.pad(LaneRows::kQ, LaneRows::kEndQ, count);
  workspace.block.pad(LaneRows::kClearanceQpos, kRobotJoints + 1, count);
  mark(clock, StepPart::kGather);
  for (int i = 0; i < options_.substeps; ++i) {
    for (int lane = 0; lane < count; ++lane) {
      workspace.lanes[at(lane)]->loader.glide(i, options_.substeps);
    }
    substep(workspace, count, i + 1 == options_.substeps, drives.front().velocity_mode, clock);
  }
  for (int lane = 0; lane < count; ++lane) {
    good[lane] = workspace.lanes[at(lane)]->good;
    workspace.lanes[at(lane)].reset();
  }
}

// Takes an environment out of its columns.
void Simulator::begin_lane(Workspace& workspace, int lane) {
  Lane& here = *workspace.lanes[at(lane)];
  const State& state = here.loader.state();
  const int env = here.loader.env();
  workspace.block.put(LaneRows::kQ, lane, state.qpos.row(env), kRobotJoints);
  workspace.block.put(LaneRows::kV, lane, state.qvel.row(env), kRobotJoints);
  here.good = here.loader.state_is_plausible();
  if (!here.good) return;
  here.loader.begin(options_.sleep);
  here.waker.begin();
  here.loader.enter(options_.sleep ? here.stepper.first_scene() : model_.full_scene());
  set_room(workspace.block, lane, here.stepper.clearance());
}

// All robots as if nothing touched them; then, one by one, the environments in which something may.
void Simulator::substep(Workspace& workspace, int count, bool last, bool velocity_mode,
                        StepClock::Worker* clock) {
  LaneBlock& block = workspace.block;
  const RobotModel& chain = model_.robot_model();
  const unsigned moved_far = kernel_.clearance_exceeded(chain, block.rows());
  unsigned busy = 0;
  unsigned looking = 0;
  for (int lane = 0; lane < count; ++lane) {
    const Lane& here = *workspace.lanes[at(lane)];
    if (!here.good) continue;
    if (here.stepper.is_busy()) {
      busy |= 1U << lane;
    } else {
      looking |= moved_far & (1U << lane);
    }
  }
  kernel_.substep(chain, model_.robot_params(), velocity_mode, block.rows(), (busy | looking) != 0);
  mark(clock, StepPart::kDynamics);
  for (int lane = 0; lane < count; ++lane) {
    Lane& here = *workspace.lanes[at(lane)];
    if (!here.good) continue;
    if (((busy | looking) >> lane & 1) != 0) {
      const RobotPose pose = pose_in_lane(chain, block.rows(), block.lanes(), lane);
      try {
        if ((looking >> lane & 1) != 0) {
          here.stepper.look_around(pose);
          set_room(block, lane, here.stepper.clearance());
          mark(clock, StepPart::kWake);
        }
        if (here.stepper.is_busy())
          here.good = here.stepper.substep(pose, options_.sleep, block, lane);
      } catch (const Error&) {
        here.good = false;  // MuJoCo gave up in the middle of a step; nothing has been stored
      }
      if (!here.good) workspace.scenes.reset_data();
    }
    if (!here.stepper.is_busy()) here.loader.forget_contacts();
    if (last && here.good) finish_lane(workspace, lane, clock);
  }
  block.advance();
}

// Puts an environment back into its columns, if all is well.
void Simulator::finish_lane(Workspace& workspace, int lane, StepClock::Worker* clock) {
  Lane& here = *workspace.lanes[at(lane)];
  JointArray qpos;
  JointArray qvel;
  workspace.block.get(LaneRows::kEndQ, lane, qpos.data(), kRobotJoints);
  workspace.block.get(LaneRows::kEndV, lane, qvel.data(), kRobotJoints);
  here.loader.glide(options_.substeps, options_.substeps);
  here.good = here.loader.is_plausible(qpos, qvel);
  if (!here.good) return;
  here.loader.store(qpos, qvel);
  mark(clock, StepPart::kGather);
  if (options_.sleep) here.waker.sleep_resting();
  mark(clock, StepPart::kWake);
}

void Simulator::update_tcp(const State& state, int first, int count, int worker) {
  LaneBlock& block = workbenches_[at(worker)].block;
  for (int lane = 0; lane < count; ++lane) {
    block.put(LaneRows::kQ, lane, state.qpos.row(first + lane), kArmJoints);
  }
  block.pad(LaneRows::kQ, kArmJoints, count);
  kernel_.forward_kinematics(model_.robot_model(), block.rows());
  for (int lane = 0; lane < count; ++lane) {
    block.get(LaneRows::kTcp, lane, state.tcp_pos.row(first + lane), 3);
    block.get(LaneRows::kTcp + 3, lane, state.tcp_quat.row(first + lane), 4);
  }
}

}  // namespace engram
