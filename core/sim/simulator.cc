#include "core/sim/simulator.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/base/index.h"
#include "core/contact/contact_kernel.h"
#include "core/robot/joint_solver.h"
#include "core/robot/lane_block.h"
#include "core/robot/lane_kernel.h"
#include "core/scene/speculative_margin.h"
#include "core/sim/env_step.h"
#include "core/sim/sleep_manager.h"
#include "core/sim/state_transfer.h"

namespace engram {
namespace {

const LaneKernel& choose_kernel(int lanes, int num_envs) {
  if (lanes == 0) return lane_kernel_for(num_envs);
  const LaneKernel* kernel = lane_kernel(lanes);
  if (kernel != nullptr) return *kernel;
  std::string allowed = "0";
  for (int width = 1; width <= kMaxLanes; width *= 2) {
    if (lane_kernel(width) != nullptr) allowed += ", " + std::to_string(width);
  }
  throw Error(Error::kInvalidArgument,
              "lanes: " + std::to_string(lanes) + " given; this processor allows: " + allowed);
}

void put_clearance(LaneBlock& block, int lane_index, const RobotBounds::Clearance& clearance) {
  const double distance = clearance.outside();
  block.put(LaneVectors::kClearanceQpos, lane_index, clearance.qpos.data(), kRobotJoints);
  block.put(LaneVectors::kSelfClearance, lane_index, clearance.self.data(), kRobotJoints);
  block.put(LaneVectors::kClearance, lane_index, &distance, 1);
}

// Stiffness times target and damping times target velocity: the part of a drive's force that does
// not depend on the joint's motion, N m, N.
double drive_bias(const RobotParams& params, const DriveTarget& target, int joint) {
  const auto i = at(joint);
  const double bias = drive_stiffness(params, target.velocity_mode, joint) * target.qpos[i];
  return joint < kArmJoints ? bias + params.drive.damping * target.qvel[i] : bias;
}

}  // namespace

struct Simulator::Lane {
  Lane(const PhysicsModel& model, const State& state, int env, RobotBounds::Clearance& clearance,
       StepWorkspace& step_workspace, SleepWorkspace& sleep_workspace, StepClock::Worker* clock)
      : step(model, state, env, step_workspace, clearance, clock),
        transfer(step),
        sleep_manager(step, sleep_workspace) {}

  // Begins a control step; decides whether anything may touch.
  void begin(bool sleep, int substeps) {
    transfer.begin(sleep);
    sleep_manager.begin(substeps);
    const bool was_clear = step.clearance.is_clear();
    step.clearance = RobotBounds::with_obstacles(step.clearance, sleep_manager.obstacles());
    // A robot that was near something probably still is.
    busy = !sleep || !step.awake().empty() || !was_clear;
  }

  void update_clearance(const RobotPose& pose) {
    clearance_updated = true;
    step.clearance = step.model.robot_bounds().clearance(pose, sleep_manager.obstacles());
  }

  // Whether a robot that moves at this speed may touch something in this substep.
  bool reaches(double speed) const {
    const double reach = kSpeculativeFactor * step.model.robot_params().timestep * speed;
    return !step.clearance.is_clear() || step.clearance.outside() <= reach - kClearanceAllowance;
  }

  // Wakes props, and puts all bodies into the broad phase and the block.
  void place_bodies(const RobotPose& pose, bool sleep, int lane_index, BroadPhase& broad_phase,
                    ContactBlock& block) {
    transfer.load_contacts();
    // The updated clearance serves the next step's begin(). This step keeps its geometry.
    if (!clearance_updated && step.awake().empty()) update_clearance(pose);
    transfer.pose_links(pose, broad_phase, lane_index);
    if (sleep) sleep_manager.wake_touching(pose);
    mark(step.clock, StepPart::kWake);
    put_bodies(lane_index, block);
    transfer.pose_props(broad_phase, lane_index);
  }

  void put_bodies(int lane_index, ContactBlock& block) {
    const RobotParams& params = step.model.robot_params();
    int body_index = 0;
    for (const int prop : step.awake()) {
      FreeBodyState& motion = step.workspace.motion[at(prop)];
      const FreeBody& body = step.prop_model(prop).body;
      body.accelerate(motion, step.model.gravity(), params.timestep);
      block.put_body(lane_index, body_index, body, motion);
      const int index = step.model.collision().body_of_prop(prop);
      if (index >= 0) step.workspace.bodies.body_indices[at(index)] = body_index;
      ++body_index;
    }
  }

  // Reads the substep's result.
  void read_back(int lane_index, const ContactBlock& block) {
    step.workspace.contacts.finish(step.workspace.memory, lane_index, block);
    int body_index = 0;
    for (const int prop : step.awake()) {
      FreeBodyState& motion = step.workspace.motion[at(prop)];
      block.get_body(lane_index, body_index++, motion);
      limit_spin(motion);
    }
  }

  // Work of its contacts.
  int cost() const {
    return busy ? step.workspace.contacts.work() + static_cast<int>(step.awake().size()) : 0;
  }

  EnvStep step;
  StateTransfer transfer;
  SleepManager sleep_manager;
  bool busy = false;               // something beside the robot's free motion is simulated
  bool clearance_updated = false;  // in this step
  bool ok = true;
};

struct Simulator::WorkerWorkspace {
  WorkerWorkspace(const PhysicsModel& model, const LaneKernel& kernel)
      : block(kernel),
        broad_phase(model.collision(), model.robot_params().timestep, kernel.lanes),
        contact_block(kernel.lanes, num_free(model), model.collision().num_free_shapes(),
                      base_of(model)),
        narrow_phase(model.full(), model.collision()) {
    for (int i = 0; i < kernel.lanes; ++i) {
      step_workspaces.emplace_back(model);
      sleep_workspaces.emplace_back(model);
    }
  }

  static int num_free(const PhysicsModel& model) {
    return static_cast<int>(std::count_if(model.props().begin(), model.props().end(),
                                          [](const PropModel& prop) { return prop.free; }));
  }
  static Vec3 base_of(const PhysicsModel& model) {
    return Eigen::Map<const Vec3>(model.robot_model().base_position);
  }

  LaneBlock block;
  BroadPhase broad_phase;
  ContactBlock contact_block;
  NarrowPhase narrow_phase;
  // For each lane.
  std::vector<StepWorkspace> step_workspaces;
  std::vector<SleepWorkspace> sleep_workspaces;
  std::array<std::optional<Lane>, kMaxLanes> lanes;
};

Simulator::Simulator(const PhysicsModel& model, const SimulatorOptions& options, int workers,
                     int num_envs)
    : model_(model),
      options_(options),
      kernel_(choose_kernel(options.lanes, num_envs)),
      contact_kernel_(contact_kernel(kernel_.lanes)),
      clearances_(at(num_envs)),
      costs_(at(num_envs)) {
  workspaces_.reserve(at(workers));
  for (int i = 0; i < workers; ++i) workspaces_.emplace_back(model, kernel_);
}

Simulator::~Simulator() = default;

LaneBlock& Simulator::block(int worker) { return workspaces_[at(worker)].block; }

bool Simulator::step(const State& state, int env, int worker, const DriveTarget& drive,
                     StepClock::Worker* clock) {
  bool ok = true;
  step(state, env, worker, {&drive, 1}, &ok, clock);
  return ok;
}

void Simulator::step(const State& state, int first, int worker, std::span<const DriveTarget> drives,
                     bool* ok, StepClock::Worker* clock) {
  std::fill_n(ok, drives.size(), true);
  if (options_.substeps == 0) return;
  const MujocoScope scope;
  std::array<int, at(kMaxTogether)> storage;
  const std::span<int> places(storage.data(), drives.size());
  std::iota(places.begin(), places.end(), 0);
  if (places.size() > at(lanes())) sort_by_cost(first, places);
  for (std::size_t begin = 0; begin < places.size(); begin += at(lanes())) {
    const std::size_t count = std::min(at(lanes()), places.size() - begin);
    step_block(state, first, places.subspan(begin, count), worker, drives, ok, clock);
  }
}

// The most contacts first. A block takes the time of the most contacts that any of its lanes has.
void Simulator::sort_by_cost(int first, std::span<int> places) const {
  std::sort(places.begin(), places.end(), [&](int a, int b) {
    return std::pair(-costs_[at(first + a)], a) < std::pair(-costs_[at(first + b)], b);
  });
}

// One control step of a block of lanes: the environments at these places, from `first` on.
void Simulator::step_block(const State& state, int first, std::span<const int> places, int worker,
                           std::span<const DriveTarget> drives, bool* ok,
                           StepClock::Worker* clock) {
  const int count = static_cast<int>(places.size());
  WorkerWorkspace& workspace = workspaces_[at(worker)];
  for (int lane_index = 0; lane_index < count; ++lane_index) {
    const int place = places[at(lane_index)];
    const int env = first + place;
    const DriveTarget& drive = drives[at(place)];
    workspace.lanes[at(lane_index)].emplace(model_, state, env, clearances_[at(env)],
                                            workspace.step_workspaces[at(lane_index)],
                                            workspace.sleep_workspaces[at(lane_index)], clock);
    for (int joint = 0; joint < kRobotJoints; ++joint) {
      const double bias = drive_bias(model_.robot_params(), drive, joint);
      workspace.block.put(LaneVectors::kDriveBias + joint, lane_index, &bias, 1);
    }
    begin_lane(workspace, lane_index);
  }
  workspace.block.pad(LaneVectors::kQ, LaneVectors::kEndQ, count);
  workspace.block.pad(LaneVectors::kClearanceQpos, 2 * kRobotJoints + 1, count);
  mark(clock, StepPart::kGather);
  for (int i = 0; i < options_.substeps; ++i) {
    for (int lane_index = 0; lane_index < count; ++lane_index) {
      workspace.lanes[at(lane_index)]->transfer.move_kinematic_props(i, options_.substeps);
    }
    substep(workspace, count, i + 1 == options_.substeps, drives.front().velocity_mode, clock);
  }
  for (int lane_index = 0; lane_index < count; ++lane_index) {
    Lane& lane = *workspace.lanes[at(lane_index)];
    ok[places[at(lane_index)]] = lane.ok;
    costs_[at(lane.step.env)] = lane.cost();
    workspace.lanes[at(lane_index)].reset();
  }
}

// Reads an environment from its columns.
void Simulator::begin_lane(WorkerWorkspace& workspace, int lane_index) {
  Lane& lane = *workspace.lanes[at(lane_index)];
  const State& state = lane.step.state;
  const int env = lane.step.env;
  workspace.block.put(LaneVectors::kQ, lane_index, state.qpos.row(env), kRobotJoints);
  workspace.block.put(LaneVectors::kV, lane_index, state.qvel.row(env), kRobotJoints);
  lane.ok = lane.transfer.state_is_plausible();
  if (!lane.ok) return;
  lane.begin(options_.sleep, options_.substeps);
  put_clearance(workspace.block, lane_index, lane.step.clearance);
}

// Finds contacts in the environments in which something may touch; then moves all environments
// together.
void Simulator::substep(WorkerWorkspace& workspace, int count, bool last, bool velocity_mode,
                        StepClock::Worker* clock) {
  LaneBlock& block = workspace.block;
  const RobotModel& robot = model_.robot_model();
  const ContactLanes* contacts = nullptr;
  if (pose_busy(workspace, count)) {
    mark(clock, StepPart::kDynamics);
    contacts = &find_contacts(workspace, count);
  }
  // A robot that is near something mostly touches nothing; the kernel without contacts is faster.
  if (contacts == nullptr || contacts->empty()) {
    kernel_.substep(robot, model_.robot_params(), velocity_mode, block.vectors());
  } else {
    contact_kernel_.substep(robot, model_.robot_params(), velocity_mode, block.vectors(),
                            *contacts);
  }
  mark(clock, StepPart::kDynamics);
  for (int lane_index = 0; lane_index < count; ++lane_index) {
    Lane& lane = *workspace.lanes[at(lane_index)];
    if (!lane.ok) continue;
    if (lane.busy) lane.read_back(lane_index, workspace.contact_block);
    if (last) finish_lane(workspace, lane_index);
  }
  block.advance();
}

// Measures clearances again that no longer hold: lanes whose robots are not clear of everything in
// this substep are busy from now on. Returns whether any is; if so, the robots are posed.
bool Simulator::pose_busy(WorkerWorkspace& workspace, int count) {
  LaneBlock& block = workspace.block;
  const RobotModel& robot = model_.robot_model();
  const unsigned exceeded =
      kernel_.clearance_exceeded(robot, kSpeculativeFactor * model_.robot_params().timestep,
                                 kClearanceAllowance, block.vectors());
  bool busy = false;
  unsigned stale = 0;  // lanes
  for (int lane_index = 0; lane_index < count; ++lane_index) {
    const Lane& lane = *workspace.lanes[at(lane_index)];
    busy = busy || (lane.ok && lane.busy);
    if (lane.ok && !lane.busy) stale |= exceeded & (1U << lane_index);
  }
  if (!busy && stale == 0) return false;
  kernel_.pose_links(robot, block.vectors());
  for (int lane_index = 0; lane_index < count; ++lane_index) {
    if ((stale >> lane_index & 1U) == 0) continue;
    Lane& lane = *workspace.lanes[at(lane_index)];
    lane.update_clearance(pose_in_lane(robot, block.vectors(), block.lanes(), lane_index));
    put_clearance(block, lane_index, lane.step.clearance);
    JointArray qvel;
    block.get(LaneVectors::kV, lane_index, qvel.data(), kRobotJoints);
    // The speeds of all joints together are a rough bound.
    if (!lane.reaches(model_.robot_bounds().max_displacement(JointArray{}, qvel))) {
      stale &= ~(1U << lane_index);
    }
    mark(lane.step.clock, StepPart::kWake);
  }
  if (!busy && stale == 0) return false;
  contact_kernel_.pose_robot(robot, block.vectors(), workspace.broad_phase.view());
  for (int lane_index = 0; lane_index < count; ++lane_index) {
    if ((stale >> lane_index & 1U) == 0) continue;
    Lane& lane = *workspace.lanes[at(lane_index)];
    lane.busy = lane.reaches(workspace.broad_phase.fastest_link(lane_index));
    busy = busy || lane.busy;
  }
  return busy;
}

// Contacts of all lanes that are busy.
const ContactLanes& Simulator::find_contacts(WorkerWorkspace& workspace, int count) {
  BroadPhase& broad_phase = workspace.broad_phase;
  const LaneBlock& block = workspace.block;
  workspace.contact_block.clear();
  broad_phase.clear();
  for (int lane_index = 0; lane_index < count; ++lane_index) {
    Lane& lane = *workspace.lanes[at(lane_index)];
    if (!lane.ok || !lane.busy) continue;
    const RobotPose pose =
        pose_in_lane(model_.robot_model(), block.vectors(), block.lanes(), lane_index);
    lane.place_bodies(pose, options_.sleep, lane_index, broad_phase, workspace.contact_block);
    mark(lane.step.clock, StepPart::kDynamics);
  }
  contact_kernel_.find_near(broad_phase.view());
  for (int lane_index = 0; lane_index < count; ++lane_index) {
    Lane& lane = *workspace.lanes[at(lane_index)];
    if (!lane.ok || !lane.busy) continue;
    StepWorkspace& memory = lane.step.workspace;
    try {
      memory.contacts.find(memory.bodies, broad_phase, memory.memory, workspace.narrow_phase,
                           lane_index, workspace.contact_block);
    } catch (const Error&) {
      lane.ok = false;  // MuJoCo failed in the middle of a step; nothing has been stored
    }
    mark(lane.step.clock, StepPart::kDynamics);
  }
  return workspace.contact_block.view();
}

// Stores an environment in its columns, if its state is plausible.
void Simulator::finish_lane(WorkerWorkspace& workspace, int lane_index) {
  Lane& lane = *workspace.lanes[at(lane_index)];
  JointArray qpos;
  JointArray qvel;
  workspace.block.get(LaneVectors::kEndQ, lane_index, qpos.data(), kRobotJoints);
  workspace.block.get(LaneVectors::kEndV, lane_index, qvel.data(), kRobotJoints);
  lane.transfer.move_kinematic_props(options_.substeps, options_.substeps);
  lane.ok = lane.transfer.is_plausible(qpos, qvel);
  if (!lane.ok) return;
  if (options_.sleep) lane.sleep_manager.count_slow_steps();
  lane.transfer.store(qpos, qvel);
  if (lane.busy) lane.transfer.store_finger_forces(lane_index, workspace.contact_block);
  mark(lane.step.clock, StepPart::kGather);
  if (options_.sleep) lane.sleep_manager.sleep_resting();
  mark(lane.step.clock, StepPart::kWake);
}

void Simulator::update_tcp(const State& state, int first, int count, int worker) {
  LaneBlock& block = workspaces_[at(worker)].block;
  const int end = first + count;
  for (; first < end; first += lanes()) {
    const int used = std::min(lanes(), end - first);
    for (int lane_index = 0; lane_index < used; ++lane_index) {
      block.put(LaneVectors::kQ, lane_index, state.qpos.row(first + lane_index), kArmJoints);
    }
    block.pad(LaneVectors::kQ, kArmJoints, used);
    kernel_.forward_kinematics(model_.robot_model(), block.vectors());
    for (int lane_index = 0; lane_index < used; ++lane_index) {
      block.get(LaneVectors::kTcp, lane_index, state.tcp_pos.row(first + lane_index), 3);
      block.get(LaneVectors::kTcp + 3, lane_index, state.tcp_quat.row(first + lane_index), 4);
    }
  }
}

}  // namespace engram
