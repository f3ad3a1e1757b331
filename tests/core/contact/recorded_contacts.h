// Recordings of the original benchmark in contact, of tests/data/contact_law: states of props and
// of the robot, drive targets, contact points and impulses.
#pragma once

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "core/math/eigen_types.h"
#include "core/robot/robot_model.h"
#include "mjcf/ball.h"
#include "mjcf/battery.h"
#include "mjcf/peg.h"
#include "tests/build_paths.h"

namespace engram::test {

struct RecordedBody {
  std::string name;
  Vec3 pos, linear, angular;  // world; of the centre of mass
  Quat quat;
};
struct RecordedRobot {
  JointArray qpos, qvel, target;
};
struct RecordedPoint {
  std::string a, shape, b;  // bodies; shape: number of the box of A, if it is a finger
  Vec3 pos, normal;
  double gap = 0;
  double impulse = 0;
};
struct RecordedSubstep {
  std::vector<RecordedBody> bodies;
  std::vector<RecordedRobot> robot;  // one or none
  std::vector<RecordedPoint> points;
};
// By number of the substep.
using RecordedRun = std::map<int, RecordedSubstep>;

class Recordings {
 public:
  static const std::map<std::string, RecordedRun>& runs() {
    static const Recordings all;
    return all.runs_;
  }

 private:
  Recordings() {
    read("motion.csv", [](const std::vector<std::string>& row, RecordedSubstep& at) {
      RecordedBody body;
      body.name = row[2];
      body.pos = vec3(row, 3);
      body.quat = Quat(number(row, 6), number(row, 7), number(row, 8), number(row, 9)).normalized();
      body.linear = vec3(row, 10);
      body.angular = vec3(row, 13);
      at.bodies.push_back(body);
    });
    read("robot.csv", [](const std::vector<std::string>& row, RecordedSubstep& at) {
      RecordedRobot robot;
      for (std::size_t i = 0; i < kRobotJoints; ++i) {
        robot.qpos[i] = number(row, 2 + i);
        robot.qvel[i] = number(row, 2 + kRobotJoints + i);
        robot.target[i] = number(row, 2 + 2 * kRobotJoints + i);
      }
      at.robot.push_back(robot);
    });
    read("contacts.csv", [](const std::vector<std::string>& row, RecordedSubstep& at) {
      at.points.push_back(
          {row[2], row[3], row[4], vec3(row, 6), vec3(row, 9), number(row, 12), number(row, 13)});
    });
  }

  template <class Add>
  void read(const std::string& name, const Add& add) {
    std::ifstream file(std::string(kData) + "/contact_law/" + name);
    std::string line;
    std::getline(file, line);  // names
    while (std::getline(file, line)) {
      std::istringstream fields(line);
      std::vector<std::string> row;
      for (std::string field; std::getline(fields, field, ',');) row.push_back(field);
      add(row, runs_[row[0]][std::stoi(row[1])]);
    }
    REQUIRE_FALSE(runs_.empty());
  }
  static double number(const std::vector<std::string>& row, std::size_t i) {
    return std::stod(row[i]);
  }
  static Vec3 vec3(const std::vector<std::string>& row, std::size_t i) {
    return {number(row, i), number(row, i + 1), number(row, i + 2)};
  }

  std::map<std::string, RecordedRun> runs_;
};

// The props of a run, by their names in the recording.
inline std::vector<mjcf::Prop> recorded_props(const RecordedRun& run) {
  std::vector<mjcf::Prop> props;
  for (const RecordedBody& body : run.begin()->second.bodies) {
    if (body.name == "ball") {
      props.push_back(mjcf::ball(body.name, 0.02, {1, 1, 1, 1}));
    } else if (body.name == "peg") {
      props.push_back(mjcf::peg(body.name, 0.12, 0.025, {1, 0, 0, 1}, {0, 0, 1, 1}));
    } else {
      props.push_back(mjcf::cube(body.name, 0.02, {1, 0, 0, 1}));
    }
  }
  return props;
}

// Runs whose cubes' poses the task sets in every control step: the original forgets all anchors.
inline bool sets_poses(const std::string& run) {
  return run.starts_with("stack") || run.starts_with("cube_hits");
}

}  // namespace engram::test
