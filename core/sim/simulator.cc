#include "core/sim/simulator.h"

#include <algorithm>
#include <optional>
#include <string>

#include "core/base/error.h"
#include "core/robot/lane_block.h"
#include "core/robot/robot_step.h"
#include "core/sim/env_step.h"
#include "core/sim/scene_binding.h"
#include "core/sim/sleep_manager.h"

namespace engram {
namespace {

// Limit of free rotation, which is integrated explicitly: a slender prop that tumbles by a radian
// per substep would gain energy from its own gyroscopic torque, without end. rad/s; PhysX's limit.
constexpr double kFastestSpin = 100;

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

void put_clearance(LaneBlock& block, int lane, const RobotBounds::Clearance& clearance) {
  const double distance = clearance.clearance();
  block.put(LaneRows::kClearanceQpos, lane, clearance.qpos.data(), kRobotJoints);
  block.put(LaneRows::kClearance, lane, &distance, 1);
}

// Applies the weights of awake props at their centres of mass. The robot is weightless.
void apply_weights(const EnvStep& step) {
  if (!step.scene_has_props()) return;
  mjData& data = step.data();
  for (int prop = 0; prop < step.num_props(); ++prop) {
    if (!step.is_awake(prop)) continue;
    const PropModel& prop_model = step.prop_model(prop);
    const PropSlot& slot = step.slot_of(prop);
    const mjtNum* quat = data.qpos + slot.qpos + 3;
    const Eigen::Vector3d weight(0, 0, -prop_model.mass * step.model.gravity());
    const Eigen::Vector3d in_body =
        Eigen::Quaterniond(quat[0], quat[1], quat[2], quat[3]).conjugate() * weight;
    Eigen::Map<Eigen::Vector3d>(data.qfrc_applied + slot.dof) = weight;
    Eigen::Map<Eigen::Vector3d>(data.qfrc_applied + slot.dof + 3) =
        prop_model.center_of_mass.cross(in_body);
  }
}

void limit_spins(const EnvStep& step) {
  if (!step.scene_has_props()) return;
  for (int prop = 0; prop < step.num_props(); ++prop) {
    if (!step.is_awake(prop)) continue;
    Eigen::Map<Eigen::Vector3d> spin(step.data().qvel + step.slot_of(prop).dof + 3);
    const double speed = spin.norm();
    if (speed > kFastestSpin) spin *= kFastestSpin / speed;
  }
}

bool has_warnings(const mjData& data) {
  return std::any_of(std::begin(data.warning), std::end(data.warning),
                     [](const mjWarningStat& warning) { return warning.number != 0; });
}

}  // namespace

struct Simulator::Lane {
  Lane(const PhysicsModel& model, const State& state, int env, const DriveTarget& drive,
       RobotBounds::Clearance& clearance, StepWorkspace& step_workspace,
       SleepWorkspace& sleep_workspace, SceneWorkspace& scenes, StepClock::Worker* clock)
      : step(model, state, env, step_workspace, clearance, clock),
        binding(step, scenes),
        sleep_manager(step, sleep_workspace),
        robot(model.robot_params(), drive) {}

  // Tests for anything to simulate beside the robot's free motion.
  bool is_busy() const { return step.scene_index != PhysicsModel::kDynamicsScene; }

  // Scene to begin a step in.
  int first_scene() {
    const bool was_clear = step.clearance.is_clear();
    step.clearance = RobotBounds::with_obstacles(step.clearance, sleep_manager.obstacles());
    if (step.num_awake > 0) return step.smallest_scene(true);
    // A robot that was near something probably still is.
    return was_clear ? PhysicsModel::kDynamicsScene : PhysicsModel::kRobotScene;
  }

  // Tests again whether the robot, at a new pose, is clear of everything. If not, the lane is busy
  // from now on.
  void update_clearance(const RobotPose& pose) {
    clearance_updated = true;
    step.clearance = step.model.robot_bounds().clearance(pose, sleep_manager.obstacles());
    if (!is_busy() && !step.clearance.is_clear()) binding.select_scene(PhysicsModel::kRobotScene);
  }

  // Loads the scene in use and poses its bodies.
  void load(const RobotPose& pose) {
    binding.load(pose.qpos, robot.v);
    step.scene->kinematics.pose(pose, step.data());
  }

  // Selects and loads the smallest scene for the substep; returns the model with the contact pairs
  // that may touch.
  const mjModel* load_near_pairs(const RobotPose& pose) {
    // The updated clearance serves the next step's first_scene(). This step keeps its geometry.
    if (step.scene_index == PhysicsModel::kRobotScene && !clearance_updated) update_clearance(pose);
    while (const std::optional<int> scene = sleep_manager.wake_touching(pose.qpos)) {
      binding.select_scene(*scene);
      load(pose);
    }
    mark(step.clock, StepPart::kWake);
    return step.instance->broad_phase.near_pairs(step.data());
  }

  // Simulates everything beside the robot's free motion, which the block's lane holds, with
  // details; sets the lane's end to the robot's motion with contacts. Without `sleep` it stays in
  // the scene in use and tests every contact pair. Returns false if MuJoCo warns.
  bool substep(const RobotPose& pose, bool sleep, LaneBlock& block, int lane,
               ContactWorkspace& contacts) {
    robot.load(block.rows(), block.lanes(), lane);
    load(pose);
    mark(step.clock, StepPart::kDynamics);
    const mjModel* colliding = sleep ? load_near_pairs(pose) : &step.scene_model();
    apply_weights(step);
    mark(step.clock, StepPart::kController);
    contact_step({step.scene, colliding}, &step.data(), robot, step.contact_force, contacts,
                 binding.kinematic_bodies());
    block.put(LaneRows::kEndQ, lane, robot.end_q().data(), kRobotJoints);
    block.put(LaneRows::kEndV, lane, robot.end_v().data(), kRobotJoints);
    limit_spins(step);
    binding.read_back();
    mark(step.clock, StepPart::kDynamics);
    return !has_warnings(step.data());
  }

  EnvStep step;
  SceneBinding binding;
  SleepManager sleep_manager;
  RobotStep robot;
  bool clearance_updated = false;  // in this step
  bool good = true;
};

struct Simulator::WorkerWorkspace {
  WorkerWorkspace(const PhysicsModel& model, const LaneKernel& kernel)
      : scenes(model), block(kernel) {
    for (int i = 0; i < kernel.lanes; ++i) {
      step_workspaces.emplace_back(model);
      sleep_workspaces.emplace_back(model);
    }
  }

  SceneWorkspace scenes;
  LaneBlock block;
  // For each lane.
  std::vector<StepWorkspace> step_workspaces;
  std::vector<SleepWorkspace> sleep_workspaces;
  std::array<std::optional<Lane>, kMostLanes> lanes;
};

Simulator::Simulator(const PhysicsModel& model, const SimulatorOptions& options, int workers,
                     int num_envs)
    : model_(model),
      options_(options),
      kernel_(choose_kernel(options.lanes)),
      clearances_(at(num_envs)) {
  workspaces_.reserve(at(workers));
  for (int i = 0; i < workers; ++i) workspaces_.emplace_back(model, kernel_);
}

Simulator::~Simulator() = default;

LaneBlock& Simulator::block(int worker) { return workspaces_[at(worker)].block; }

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
  WorkerWorkspace& workspace = workspaces_[at(worker)];
  const MujocoScope scope;
  for (int lane = 0; lane < count; ++lane) {
    const int env = first + lane;
    const DriveTarget& drive = drives[at(lane)];
    workspace.lanes[at(lane)].emplace(
        model_, state, env, drive, clearances_[at(env)], workspace.step_workspaces[at(lane)],
        workspace.sleep_workspaces[at(lane)], workspace.scenes, clock);
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
      workspace.lanes[at(lane)]->binding.move_kinematic_props(i, options_.substeps);
    }
    substep(workspace, count, i + 1 == options_.substeps, drives.front().velocity_mode, clock);
  }
  for (int lane = 0; lane < count; ++lane) {
    good[lane] = workspace.lanes[at(lane)]->good;
    workspace.lanes[at(lane)].reset();
  }
}

// Reads an environment from its columns.
void Simulator::begin_lane(WorkerWorkspace& workspace, int lane) {
  Lane& here = *workspace.lanes[at(lane)];
  const State& state = here.step.state;
  const int env = here.step.env;
  workspace.block.put(LaneRows::kQ, lane, state.qpos.row(env), kRobotJoints);
  workspace.block.put(LaneRows::kV, lane, state.qvel.row(env), kRobotJoints);
  here.good = here.binding.state_is_plausible();
  if (!here.good) return;
  here.binding.begin(options_.sleep);
  here.sleep_manager.begin();
  here.binding.select_scene(options_.sleep ? here.first_scene() : model_.full_scene());
  put_clearance(workspace.block, lane, here.step.clearance);
}

// Moves all robots as if nothing touched them; then, one by one, the environments in which
// something may.
void Simulator::substep(WorkerWorkspace& workspace, int count, bool last, bool velocity_mode,
                        StepClock::Worker* clock) {
  LaneBlock& block = workspace.block;
  const RobotModel& chain = model_.robot_model();
  const unsigned exceeded = kernel_.clearance_exceeded(chain, block.rows());
  unsigned busy = 0;
  unsigned unclear = 0;  // lanes whose clearance has to be updated
  for (int lane = 0; lane < count; ++lane) {
    const Lane& here = *workspace.lanes[at(lane)];
    if (!here.good) continue;
    if (here.is_busy()) {
      busy |= 1U << lane;
    } else {
      unclear |= exceeded & (1U << lane);
    }
  }
  kernel_.substep(chain, model_.robot_params(), velocity_mode, block.rows(), (busy | unclear) != 0);
  mark(clock, StepPart::kDynamics);
  for (int lane = 0; lane < count; ++lane) {
    Lane& here = *workspace.lanes[at(lane)];
    if (!here.good) continue;
    if (((busy | unclear) >> lane & 1) != 0) {
      substep_lane(workspace, lane, (unclear >> lane & 1) != 0);
    }
    if (!here.is_busy()) here.step.contact_force = {};
    if (last && here.good) finish_lane(workspace, lane);
  }
  block.advance();
}

void Simulator::substep_lane(WorkerWorkspace& workspace, int lane, bool check_clearance) {
  Lane& here = *workspace.lanes[at(lane)];
  LaneBlock& block = workspace.block;
  const RobotPose pose = pose_in_lane(model_.robot_model(), block.rows(), block.lanes(), lane);
  try {
    if (check_clearance) {
      here.update_clearance(pose);
      put_clearance(block, lane, here.step.clearance);
      mark(here.step.clock, StepPart::kWake);
    }
    if (here.is_busy()) {
      here.good =
          here.substep(pose, options_.sleep, block, lane, workspace.scenes.contact_workspace());
    }
  } catch (const Error&) {
    here.good = false;  // MuJoCo failed in the middle of a step; nothing has been stored
  }
  if (!here.good) workspace.scenes.reset_data();
}

// Stores an environment in its columns, if its state is plausible.
void Simulator::finish_lane(WorkerWorkspace& workspace, int lane) {
  Lane& here = *workspace.lanes[at(lane)];
  JointArray qpos;
  JointArray qvel;
  workspace.block.get(LaneRows::kEndQ, lane, qpos.data(), kRobotJoints);
  workspace.block.get(LaneRows::kEndV, lane, qvel.data(), kRobotJoints);
  here.binding.move_kinematic_props(options_.substeps, options_.substeps);
  here.good = here.binding.is_plausible(qpos, qvel);
  if (!here.good) return;
  here.binding.store(qpos, qvel);
  mark(here.step.clock, StepPart::kGather);
  if (options_.sleep) here.sleep_manager.sleep_resting();
  mark(here.step.clock, StepPart::kWake);
}

void Simulator::update_tcp(const State& state, int first, int count, int worker) {
  LaneBlock& block = workspaces_[at(worker)].block;
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
