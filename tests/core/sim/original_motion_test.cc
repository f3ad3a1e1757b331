// The arm's motion against that of the original benchmark, which was recorded step by step.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "core/scene/physics_model.h"
#include "core/sim/controller.h"
#include "tasks/common/task_info.h"
#include "tests/build_paths.h"
#include "tests/core/sim/physics_engines.h"

namespace engram {
namespace {

using Row = std::vector<double>;

// Rows of a recording, grouped by the text in their first columns. An empty field is zero.
std::map<std::string, std::vector<Row>> read_groups(const std::string& name, int key_columns) {
  std::ifstream file(std::string(test::kData) + "/" + name);
  std::map<std::string, std::vector<Row>> groups;
  std::string line;
  std::getline(file, line);  // names
  while (std::getline(file, line)) {
    std::istringstream fields(line);
    std::string field;
    std::string key;
    Row row;
    for (int column = 0; std::getline(fields, field, ','); ++column) {
      if (column < key_columns) {
        key += (column > 0 ? " " : "") + field;
      } else {
        row.push_back(field.empty() ? 0 : std::stod(field));
      }
    }
    groups[key].push_back(row);
  }
  return groups;
}

// Largest errors of a step against the recording.
struct Errors {
  double joints = 0;   // mrad
  double fingers = 0;  // mm
};

class Replay {
 public:
  explicit Replay(const double* qpos, ControlMode mode = ControlMode::kPdEeDeltaPose,
                  Physics physics = Physics::kEngram)
      : controller_(mode, robot().arm(), robot().joint_ranges(), -1),
        engine_(test::make_engine(physics, scene(), robot(), store_)) {
    std::copy_n(qpos, kRobotJoints, state_.qpos.row(0));
    controller_.reset(state_, 0);
    std::copy_n(qpos, kRobotJoints, targets.qpos.begin());
  }
  void act(const Row& action) {
    const std::vector<float> values(action.begin(), action.end());
    move(controller_.drive(state_, 0, values.data()));
  }
  void move(const DriveTarget& drive) {
    bool ok = false;
    engine_->step(state_, 0, 0, {&drive, 1}, &ok, nullptr);
    REQUIRE(ok);
  }
  Errors errors(const double* qpos) const {
    Errors errors;
    for (int i = 0; i < kRobotJoints; ++i) {
      double& worst = i < kArmJoints ? errors.joints : errors.fingers;
      worst = std::max(worst, 1e3 * std::abs(state_.qpos.row(0)[i] - qpos[i]));
    }
    return errors;
  }

  DriveTarget targets;  // of the start pose

 private:
  static const SceneSpec& scene() {
    static const SceneSpec spec = tasks::scene_source({});
    return spec;
  }
  static const PhysicsModel& robot() {
    static const PhysicsModel model(scene());
    return model;
  }

  ColumnStore store_{1};
  State state_{store_, 0};
  Controller controller_;
  std::unique_ptr<PhysicsEngine> engine_;
};

// A row of arm_actions.csv: step, 7 actions, 7 joint targets, the fingers' target, 9 positions.
constexpr std::size_t kAction = 1;
constexpr std::size_t kTarget = 8;
constexpr std::size_t kQpos = 16;

DriveTarget recorded_drive(const Row& row) {
  DriveTarget drive;
  std::copy_n(row.begin() + kTarget, kRobotJoints, drive.qpos.begin());
  drive.qpos[kArmJoints + 1] = drive.qpos[kArmJoints];
  return drive;
}

// Worst errors of the first `steps` steps; from the recorded actions, or the recorded targets.
Errors replay(const std::vector<Row>& rows, int steps, bool from_actions,
              Physics physics = Physics::kEngram) {
  Replay robot(rows[0].data() + kQpos, ControlMode::kPdEeDeltaPose, physics);
  Errors worst;
  for (std::size_t i = 1; i <= static_cast<std::size_t>(steps); ++i) {
    if (from_actions) {
      robot.act(Row(rows[i].begin() + kAction, rows[i].begin() + kTarget));
    } else {
      robot.move(recorded_drive(rows[i]));
    }
    const Errors errors = robot.errors(rows[i].data() + kQpos);
    worst.joints = std::max(worst.joints, errors.joints);
    worst.fingers = std::max(worst.fingers, errors.fingers);
  }
  return worst;
}

struct Bound {
  int steps;
  double joints;  // mrad
};

TEST_CASE("Sixty recorded actions lead where they led in the original", "[physics][original]") {
  // Shorter ones: after that several joints are at their limits in a singular pose, or (ry) the
  // hand is on the table.
  const std::map<std::string, Bound> bounds = {
      {"rand", {60, 0.1}},      {"rand2", {60, 0.1}},   {"rand_small", {60, 0.1}},
      {"px5hold", {60, 0.1}},   {"pulse_y", {60, 0.1}}, {"rx", {60, 0.1}},
      {"rz", {60, 0.1}},        {"close", {60, 0.1}},   {"zero", {60, 0.1}},
      {"closeopen", {60, 0.1}}, {"x03", {24, 0.1}},     {"ry", {49, 0.1}},
      {"px", {8, 0.5}},         {"mx", {12, 0.5}},      {"py", {18, 0.5}},
      {"pz", {23, 0.5}},        {"diag", {39, 0.5}}};
  const auto recorded = read_groups("arm_actions.csv", 1);
  REQUIRE(recorded.size() == bounds.size());
  for (const auto& [name, rows] : recorded) {
    REQUIRE(rows.size() == 61);
    const Bound& bound = bounds.at(name);
    const Errors worst = replay(rows, bound.steps, true);
    INFO(name << ": " << worst.joints << " mrad, " << worst.fingers << " mm");
    CHECK(worst.joints <= bound.joints);
    CHECK(worst.fingers <= (bound.joints > 0.1 ? 0.1 : 0.05));
  }
}

// x03 goes through nearly singular poses (smallest singular value 0.011), where a target changes by
// millirads for a microrad of the arm's own. From the recorded targets it stays true.
TEST_CASE("Recorded targets lead where they led in the original", "[physics][original]") {
  const auto recorded = read_groups("arm_actions.csv", 1);
  for (const char* name : {"rand", "rand2", "rand_small", "x03", "px5hold", "pulse_y", "rx", "rz",
                           "close", "zero", "closeopen"}) {
    const Errors worst = replay(recorded.at(name), 60, false);
    INFO(name << ": " << worst.joints << " mrad, " << worst.fingers << " mm");
    CHECK(worst.joints <= 0.05);
    CHECK(worst.fingers <= 0.05);
  }
  CHECK(replay(recorded.at("diag"), 45, false).joints <= 0.5);
  const Errors whole = replay(recorded.at("x03"), 60, true);
  CHECK(whole.joints <= 2.5);
}

// Its drives are taken together, the original's one after another, and so joints that share a turn
// share it in another way: of 27 mrad in the first step of pulse_y, none of which is left after it.
TEST_CASE("Recorded targets lead MuJoCo's arm near to where they led in the original",
          "[mujoco_physics][original]") {
  const std::map<std::string, Bound> bounds = {
      {"rx", {60, 3}},    {"rz", {40, 0.5}},       {"close", {60, 0.1}},  {"zero", {60, 0.1}},
      {"x03", {20, 1}},   {"px5hold", {60, 15}},   {"pulse_y", {60, 18}}, {"rand_small", {60, 9}},
      {"rand", {60, 45}}, {"closeopen", {60, 0.1}}};
  const auto recorded = read_groups("arm_actions.csv", 1);
  for (const auto& [name, bound] : bounds) {
    const Errors worst = replay(recorded.at(name), bound.steps, false, Physics::kMujoco);
    INFO(name << ": " << worst.joints << " mrad, " << worst.fingers << " mm");
    CHECK(worst.joints <= bound.joints);
    CHECK(worst.fingers <= 1);
  }
}

TEST_CASE("A hand that is turned into the table rests there as in the original",
          "[physics][original]") {
  const auto recorded = read_groups("arm_actions.csv", 1);
  const Errors worst = replay(recorded.at("ry"), 60, true);
  CHECK(worst.joints <= 10);
}

// A row of pose_actions.csv: step, up to 7 actions, 9 positions.
constexpr std::size_t kPoseQpos = 8;

// Steps of a sequence before its goal is out of reach.
std::size_t reachable_steps(const std::string& sequence) {
  return sequence == "pd_ee_target_delta_pos" ? 63 : 100;
}

// A goal pose leaves one of the seven joints free: the TCP agrees where the joints do not.
TEST_CASE("Goal poses lead to the joints of the original", "[physics][original]") {
  const std::map<std::string, ControlMode> modes = {
      {"pd_ee_pose", ControlMode::kPdEePose},
      {"pd_ee_target_delta_pos", ControlMode::kPdEeTargetDeltaPos},
      {"pd_ee_target_delta_pose", ControlMode::kPdEeTargetDeltaPose},
      {"pd_ee_target_delta_pose hold", ControlMode::kPdEeTargetDeltaPose}};
  const auto recorded = read_groups("pose_actions.csv", 1);
  REQUIRE(recorded.size() == modes.size());
  for (const auto& [name, rows] : recorded) {
    Replay replay(rows[0].data() + kPoseQpos, modes.at(name));
    for (std::size_t i = 1; i < rows.size(); ++i) {
      replay.act(Row(rows[i].begin() + kAction, rows[i].begin() + kPoseQpos));
      const Errors errors = replay.errors(rows[i].data() + kPoseQpos);
      INFO(name << ", step " << i);
      // Towards a goal out of reach the original moves as well, by 0.3 rad in the one step
      // recorded: inverse kinematics ends in a singular pose, which amplifies the errors of its
      // start.
      CHECK(errors.joints <= (i <= reachable_steps(name) ? 0.1 : 5.0));
      CHECK(errors.fingers <= 0.05);
    }
  }
}

TEST_CASE("A joint's step is the original's", "[physics][original]") {
  const auto recorded = read_groups("joint_steps.csv", 2);
  CHECK(recorded.size() == 22);
  for (const auto& [name, rows] : recorded) {
    Replay replay(rows[0].data() + 1);
    DriveTarget drive = replay.targets;
    if (name.substr(0, 3) == "all") {
      for (std::size_t i = 0; i < kArmJoints; ++i) drive.qpos[i] += i % 2 == 0 ? 0.05 : -0.05;
    } else {
      const std::size_t joint = static_cast<std::size_t>(std::stoi(name)) - 1;
      drive.qpos[joint] += std::stod(name.substr(name.find(' ')));
    }
    for (std::size_t i = 1; i < rows.size(); ++i) {
      replay.move(drive);
      const Errors errors = replay.errors(rows[i].data() + 1);
      INFO(name << ", step " << i);
      CHECK(errors.joints <= 0.1);
      CHECK(errors.fingers <= 0.05);
    }
  }
}

}  // namespace
}  // namespace engram
