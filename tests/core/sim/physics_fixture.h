// A robot above a few props, for tests of physics: nothing happens that the test does not ask for.
#pragma once

#include <Eigen/Dense>
#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tests/core/batch/scene_task.h"

namespace engram::test {

struct Placement {
  Eigen::Vector3d pos;
  PropStatus status = PropStatus::kAsleep;
  Eigen::Quaterniond quat = Eigen::Quaterniond::Identity();
};

class Rig {
 public:
  Rig(std::vector<mjcf::Prop> props, std::vector<Placement> placements, BatchOptions options = {})
      : placements_(std::move(placements)) {
    auto task = std::make_unique<SceneTask>(std::move(props));
    task_ = task.get();
    task_->on_reset = [this](int index) {
      for (std::size_t i = 0; i < placements_.size(); ++i) place(index, static_cast<int>(i));
    };
    options.robot_init_qpos_noise = 0;
    options.threads = 1;
    batch_ = std::make_unique<Batch>(std::move(task), options);
    batch_->reset();
  }

  // Cubes of half size 0.02 m, one for each placement.
  static Rig cubes(std::vector<Placement> placements, const BatchOptions& options = {}) {
    std::vector<mjcf::Prop> props;
    for (std::size_t i = 0; i < placements.size(); ++i) {
      props.push_back(mjcf::cube("cube_" + std::to_string(i), 0.02, {1, 0, 0, 1}));
    }
    return {std::move(props), std::move(placements), options};
  }
  Rig(const Rig&) = delete;
  Rig& operator=(const Rig&) = delete;

  Batch& batch() { return *batch_; }
  SceneTask& task() { return *task_; }
  const State& state() const { return batch_->state(); }
  Eigen::Vector3d tcp() const { return Eigen::Map<Eigen::Vector3d>(state().tcp_pos.row(0)); }
  Eigen::Vector3d pos(int prop) const {
    return Eigen::Map<Eigen::Vector3d>(state().prop_pos_of(0, prop));
  }
  PropStatus status(int prop) const { return state().status_of(0, prop); }

  void rest(int steps, double gripper = tasks::kGripperOpen) {
    std::array<float, 7> action{};
    tasks::hold_tcp(gripper, action.data());
    for (int i = 0; i < steps; ++i) batch_->step(action);
  }
  // Moves the tool towards a point, pointing down, at most `speed` of full scale.
  void move(const Eigen::Vector3d& goal, int steps, double gripper = tasks::kGripperOpen,
            float speed = 1) {
    std::array<float, 7> action{};
    for (int i = 0; i < steps; ++i) {
      tasks::servo_tcp(state(), 0, goal, tasks::kToolDown, gripper, action.data());
      for (int k = 0; k < 3; ++k) action[k] = std::clamp(action[k], -speed, speed);
      batch_->step(action);
    }
  }

 private:
  void place(int index, int prop) const {
    const Placement& where = placements_[static_cast<std::size_t>(prop)];
    const Eigen::Quaterniond& q = where.quat;
    const double quat[4] = {q.w(), q.x(), q.y(), q.z()};
    task_->engine.state->place_prop(index, prop, where.pos.data(), quat, where.status);
  }

  std::vector<Placement> placements_;
  SceneTask* task_ = nullptr;
  std::unique_ptr<Batch> batch_;
};

}  // namespace engram::test
