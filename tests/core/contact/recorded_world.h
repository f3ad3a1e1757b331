// A scene of the recordings in contact, which goes on by itself from the recorded state, with the
// recorded drive targets, under either physics.
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>

#include "core/contact/contact_step.h"
#include "tasks/common/task_info.h"
#include "tests/core/contact/recorded_contacts.h"
#include "tests/core/sim/physics_engines.h"

namespace engram::test {

class RecordedWorld {
 public:
  // Largest errors against the recording.
  struct Errors {
    double pos = 0;      // mm
    double turn = 0;     // degrees
    double joints = 0;   // mrad
    double fingers = 0;  // um
  };

  explicit RecordedWorld(const RecordedRun& run, Physics physics = Physics::kEngram)
      : scene_(tasks::scene_source({.props = recorded_props(run)})),
        model_(scene_),
        state_(store_, static_cast<int>(model_.props().size()),
               max_stored_pairs(model_.collision())),
        engine_(make_engine(physics, scene_, model_, store_)) {
    const JointArray up = {0, 0, 0, -1.9, 0, 2.6, 0.8, 0.04, 0.04};
    std::copy(up.begin(), up.end(), state_.qpos.row(0));
    drive_.qpos = up;
    for (const RecordedBody& body : run.at(0).bodies) place(body);
    for (const RecordedRobot& robot : run.at(0).robot) {
      std::copy(robot.qpos.begin(), robot.qpos.end(), state_.qpos.row(0));
      std::copy(robot.qvel.begin(), robot.qvel.end(), state_.qvel.row(0));
    }
  }

  // Errors over a run, from the world's present state on.
  Errors play(const RecordedRun& run, bool sets_poses) {
    Errors worst;
    for (int substep = 0; run.contains(substep + kSubsteps); substep += kSubsteps) {
      for (const RecordedRobot& robot : run.at(substep).robot) drive_.qpos = robot.target;
      for (int prop = 0; prop < state_.num_props && sets_poses; ++prop) {
        state_.forget_contacts(0, prop);
      }
      step();
      for (const RecordedBody& body : run.at(substep + kSubsteps).bodies) compare(body, worst);
      for (const RecordedRobot& robot : run.at(substep + kSubsteps).robot) compare(robot, worst);
    }
    return worst;
  }

 private:
  static constexpr int kSubsteps = 5;

  void step() {
    bool ok = false;
    engine_->step(state_, 0, 0, {&drive_, 1}, &ok, nullptr);
    REQUIRE(ok);
  }

  int prop_named(const std::string& name) const {
    const auto& props = model_.props();
    const auto found = std::find_if(props.begin(), props.end(),
                                    [&](const PropModel& prop) { return prop.name == name; });
    REQUIRE(found != props.end());
    return static_cast<int>(found - props.begin());
  }

  void place(const RecordedBody& body) {
    const int prop = prop_named(body.name);
    const double quat[4] = {body.quat.w(), body.quat.x(), body.quat.y(), body.quat.z()};
    state_.place_prop(0, prop, body.pos.data(), quat, PropStatus::kAwake);
    Eigen::Map<Vec3>{state_.prop_qvel_of(0, prop)} = body.linear;
    Eigen::Map<Vec3>{state_.prop_qvel_of(0, prop) + 3} = body.quat.conjugate() * body.angular;
  }

  void compare(const RecordedBody& body, Errors& worst) const {
    const int prop = prop_named(body.name);
    const Eigen::Map<const Vec3> pos(state_.prop_pos_of(0, prop));
    const double* const q = state_.prop_quat_of(0, prop);
    const double turn = Quat(q[0], q[1], q[2], q[3]).angularDistance(body.quat);
    worst.pos = std::max(worst.pos, 1e3 * (pos - body.pos).norm());
    worst.turn = std::max(worst.turn, turn * 180 / std::numbers::pi);
  }

  void compare(const RecordedRobot& robot, Errors& worst) const {
    for (std::size_t i = 0; i < kRobotJoints; ++i) {
      const double apart = std::abs(state_.qpos.row(0)[i] - robot.qpos[i]);
      double& error = i < kArmJoints ? worst.joints : worst.fingers;
      error = std::max(error, (i < kArmJoints ? 1e3 : 1e6) * apart);
    }
  }

  SceneSpec scene_;
  PhysicsModel model_;
  ColumnStore store_{1};
  State state_;
  std::unique_ptr<PhysicsEngine> engine_;
  DriveTarget drive_;
};

}  // namespace engram::test
