// Motion of free props and of the robot in contact against that of the original benchmark: every
// run begins at its recorded state and goes on by itself, with the recorded drive targets.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <numbers>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "core/contact/contact_step.h"
#include "core/scene/physics_model.h"
#include "core/sim/simulator.h"
#include "mjcf/ball.h"
#include "mjcf/peg.h"
#include "tasks/common/task_info.h"
#include "tests/build_paths.h"

namespace engram {
namespace {

// Rows of one run of a recording: substep, body (if there is one), numbers.
struct Row {
  int substep = 0;
  std::string body;
  std::vector<double> values;
};
using Runs = std::map<std::string, std::vector<Row>>;

Runs read_runs(const std::string& name, bool with_body) {
  std::ifstream file(std::string(test::kData) + "/contact_law/" + name);
  Runs runs;
  std::string line;
  std::getline(file, line);  // names
  while (std::getline(file, line)) {
    std::istringstream fields(line);
    std::string run;
    std::string field;
    Row row;
    std::getline(fields, run, ',');
    std::getline(fields, field, ',');
    row.substep = std::stoi(field);
    if (with_body) std::getline(fields, row.body, ',');
    while (std::getline(fields, field, ',')) row.values.push_back(std::stod(field));
    runs[run].push_back(row);
  }
  return runs;
}

const Runs& motions() {
  static const Runs runs = read_runs("motion.csv", true);
  return runs;
}
const Runs& robots() {
  static const Runs runs = read_runs("robot.csv", false);
  return runs;
}

// The bodies of a run by their names in the recording, in a scene of their own.
std::vector<mjcf::Prop> props_of(const std::string& run) {
  std::vector<mjcf::Prop> props;
  const auto found = motions().find(run);
  if (found == motions().end()) return props;
  for (const Row& row : found->second) {
    if (row.substep > 0) break;
    if (row.body == "ball") {
      props.push_back(mjcf::ball("ball", 0.02, {1, 1, 1, 1}));
    } else if (row.body == "peg") {
      props.push_back(mjcf::peg("peg", 0.12, 0.025, {1, 0, 0, 1}, {0, 0, 1, 1}));
    } else {
      props.push_back(mjcf::cube(row.body, 0.02, {1, 0, 0, 1}));
    }
  }
  return props;
}

// Largest errors against the recording.
struct Errors {
  double pos = 0;      // mm
  double turn = 0;     // degrees
  double joints = 0;   // mrad
  double fingers = 0;  // um
};

class World {
 public:
  explicit World(const std::string& run)
      : model_(tasks::scene_source({.props = props_of(run)})),
        state_(store_, static_cast<int>(model_.props().size()),
               max_contact_pairs(model_.collision())),
        simulator_(model_, SimulatorOptions{}, 1, 1) {
    const std::vector<double> up = {0, 0, 0, -1.9, 0, 2.6, 0.8, 0.04, 0.04};
    std::copy_n(up.begin(), kRobotJoints, state_.qpos.row(0));
    std::copy_n(up.begin(), kRobotJoints, drive_.qpos.begin());
    for (const Row& row : motions_of(run, 0)) place(row);
    if (const Row* const robot = robot_of(run, 0)) {
      std::copy_n(robot->values.begin(), kRobotJoints, state_.qpos.row(0));
      std::copy_n(robot->values.begin() + kRobotJoints, kRobotJoints, state_.qvel.row(0));
    }
  }

  // Errors over a run, from the world's present state on.
  Errors play(const std::string& run, bool poses_are_set) {
    Errors worst;
    for (int substep = 0; substep < 5 * 60; substep += 5) {
      if (const Row* const robot = robot_of(run, substep)) {
        std::copy_n(robot->values.begin() + 2 * kRobotJoints, kRobotJoints, drive_.qpos.begin());
      }
      const std::vector<Row> next = motions_of(run, substep + 5);
      const Row* const robot = robot_of(run, substep + 5);
      if (next.empty() && robot == nullptr) break;
      for (int prop = 0; prop < state_.num_props && poses_are_set; ++prop) {
        state_.forget_contacts(0, prop);
      }
      REQUIRE(simulator_.step(state_, 0, 0, drive_));
      for (const Row& row : next) compare(row, worst);
      if (robot != nullptr) compare_robot(*robot, worst);
    }
    return worst;
  }

 private:
  static std::vector<Row> motions_of(const std::string& run, int substep) {
    std::vector<Row> rows;
    const auto found = motions().find(run);
    if (found == motions().end()) return rows;
    std::copy_if(found->second.begin(), found->second.end(), std::back_inserter(rows),
                 [substep](const Row& row) { return row.substep == substep; });
    return rows;
  }
  static const Row* robot_of(const std::string& run, int substep) {
    const auto found = robots().find(run);
    if (found == robots().end()) return nullptr;
    const auto row = std::find_if(found->second.begin(), found->second.end(),
                                  [substep](const Row& r) { return r.substep == substep; });
    return row == found->second.end() ? nullptr : &*row;
  }

  int prop_named(const std::string& name) const {
    const auto& props = model_.props();
    const auto found = std::find_if(props.begin(), props.end(),
                                    [&](const PropModel& prop) { return prop.name == name; });
    REQUIRE(found != props.end());
    return static_cast<int>(found - props.begin());
  }

  void place(const Row& row) {
    const int prop = prop_named(row.body);
    state_.place_prop(0, prop, row.values.data(), row.values.data() + 3, PropStatus::kAwake);
    const Eigen::Quaterniond quat(row.values[3], row.values[4], row.values[5], row.values[6]);
    const Eigen::Vector3d spin =
        quat.conjugate() * Eigen::Vector3d(row.values[10], row.values[11], row.values[12]);
    std::copy_n(row.values.begin() + 7, 3, state_.prop_qvel_of(0, prop));
    std::copy_n(spin.data(), 3, state_.prop_qvel_of(0, prop) + 3);
  }

  void compare(const Row& row, Errors& worst) const {
    const int prop = prop_named(row.body);
    double squared = 0;
    for (int i = 0; i < 3; ++i) {
      const double apart = state_.prop_pos_of(0, prop)[i] - row.values[static_cast<std::size_t>(i)];
      squared += apart * apart;
    }
    const double* const q = state_.prop_quat_of(0, prop);
    const Eigen::Quaterniond mine(q[0], q[1], q[2], q[3]);
    const Eigen::Quaterniond theirs(row.values[3], row.values[4], row.values[5], row.values[6]);
    const double turn = mine.angularDistance(theirs.normalized()) * 180 / std::numbers::pi;
    worst.pos = std::max(worst.pos, 1e3 * std::sqrt(squared));
    worst.turn = std::max(worst.turn, turn);
  }

  void compare_robot(const Row& row, Errors& worst) const {
    for (int i = 0; i < kRobotJoints; ++i) {
      const double apart =
          std::abs(state_.qpos.row(0)[i] - row.values[static_cast<std::size_t>(i)]);
      double& error = i < kArmJoints ? worst.joints : worst.fingers;
      error = std::max(error, (i < kArmJoints ? 1e3 : 1e6) * apart);
    }
  }

  PhysicsModel model_;
  ColumnStore store_{1};
  State state_;
  Simulator simulator_;
  DriveTarget drive_;
};

// Runs that set their cubes' poses in every control step.
bool sets_poses(const std::string& run) {
  return run.starts_with("stack") || run.starts_with("cube_hits");
}

TEST_CASE("Bodies in contact move as in the original", "[physics][original]") {
  std::map<std::string, Errors> errors;
  for (const auto& [run, rows] : motions()) {
    if (run.starts_with("battery") || run.starts_with("grasp")) continue;
    errors[run] = World(run).play(run, sets_poses(run));
  }
  for (const std::string variant : {"0.0", "0.5", "1.0"}) {
    World world("grasp_close_" + variant);
    for (const char* part : {"grasp_close_", "grasp_lift_", "grasp_shake_"}) {
      const std::string run = part + variant;
      if (robots().contains(run)) errors[run] = world.play(run, false);
    }
  }
  for (const auto& [run, worst] : errors) {
    std::printf("%-28s %8.3f mm %8.3f deg %8.3f mrad %8.2f um\n", run.c_str(), worst.pos, worst.turn,
                worst.joints, worst.fingers);
  }
}

}  // namespace
}  // namespace engram
