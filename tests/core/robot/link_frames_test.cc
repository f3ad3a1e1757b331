// Geometry and Jacobians of links against MuJoCo and against finite differences.
#include "core/robot/link_frames.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "core/robot/robot_dynamics.h"
#include "core/scene/mujoco_handle.h"
#include "tests/core/robot/robot_fixture.h"

namespace engram::test {
namespace {

// One robot's links at some joint positions.
class Links {
 public:
  explicit Links(const JointArray& q) : q_(row_of(q)), frames_(model(), q_, pose()) {}
  Links(const Links&) = delete;
  Links& operator=(const Links&) = delete;

  static const RobotModel& model() { return physics().robot_model(); }
  const LinkFrames<double>& frames() const { return frames_; }
  Vec3 center(int link) const {
    const Vec3Of<double> center = frames_.center(link);
    return {center.x(), center.y(), center.z()};
  }
  JointMatrixOf<double> inverse_mass_matrix() const {
    JointMatrixOf<double> mass;
    RobotDynamics<double>(model(), q_, links_).mass_matrix(mass);
    invert(mass);
    return mass;
  }

 private:
  const LinkPoses<double>& pose() {
    link_poses(model(), q_, links_);
    return links_;
  }

  JointsOf<double> q_;
  LinkPoses<double> links_;
  LinkFrames<double> frames_;
};

std::string body_name(int link) {
  if (link == kLeftFingerLink) return "leftfinger";
  if (link == kRightFingerLink) return "rightfinger";
  if (link == kHandLink) return "hand";
  if (link == kCameraLink) return "camera_link";
  return "link" + std::to_string(link + 1);
}

TEST_CASE("Centres of mass of links are MuJoCo's", "[robot]") {
  const mjModel& model = physics().robot();
  const DataPtr data = make_data(model);
  const Eigen::Map<const Vec3> base(physics().robot_model().base_position);
  for (const Robot& robot : random_robots(64)) {
    std::copy(robot.q.begin(), robot.q.end(), data->qpos);
    mj_kinematics(&model, data.get());
    mj_comPos(&model, data.get());
    const Links links(robot.q);
    for (int link = 0; link < kNumLinks; ++link) {
      const int body = mj_name2id(&model, mjOBJ_BODY, body_name(link).c_str());
      REQUIRE(body >= 0);
      const Vec3 theirs = Eigen::Map<const Vec3>(data->xipos + 3 * body) - base;
      REQUIRE((links.center(link) - theirs).norm() < 1e-12);
    }
  }
}

TEST_CASE("A link's Jacobian is the derivative of its centre of mass", "[robot]") {
  constexpr double kStep = 1e-6;
  for (const Robot& robot : random_robots(16)) {
    const Links links(robot.q);
    for (int link = 0; link < kNumLinks; ++link) {
      JointsOf<double> rows[3];
      links.frames().center_jacobian(link, rows);
      for (std::size_t joint = 0; joint < kRobotJoints; ++joint) {
        JointArray before = robot.q;
        JointArray after = robot.q;
        before[joint] -= kStep;
        after[joint] += kStep;
        const Vec3 slope = (Links(after).center(link) - Links(before).center(link)) / (2 * kStep);
        const auto i = static_cast<int>(joint);
        REQUIRE((Vec3(rows[0][i], rows[1][i], rows[2][i]) - slope).norm() < 1e-8);
      }
    }
  }
}

// A robot's links a moment later, at the same joint velocities.
Links moved(const Robot& robot, double time) {
  JointArray q = robot.q;
  for (std::size_t i = 0; i < kRobotJoints; ++i) q[i] += time * robot.v[i];
  return Links(q);
}
Vec3 vec3(const Vec3Of<double>& v) { return {v.x(), v.y(), v.z()}; }

Vec3 center_velocity(const Links& links, int link, const JointsOf<double>& v) {
  JointsOf<double> rows[3];
  links.frames().center_jacobian(link, rows);
  Vec3 velocity = Vec3::Zero();
  for (int i = 0; i < kRobotJoints; ++i)
    velocity += Vec3(rows[0][i], rows[1][i], rows[2][i]) * v[i];
  return velocity;
}
Vec3 angular_velocity(const Links& links, int link, const JointsOf<double>& v) {
  Vec3 velocity = Vec3::Zero();
  for (int i = 0; i < hinges_of(link); ++i) velocity += vec3(links.frames().axis(i)) * v[i];
  return velocity;
}

TEST_CASE("A link's bias acceleration is that at constant joint velocities", "[robot]") {
  constexpr double kStep = 1e-6;
  for (const Robot& robot : random_robots(16)) {
    const JointsOf<double> v = row_of(robot.v);
    const Links before = moved(robot, -kStep);
    const Links after = moved(robot, kStep);
    const Links links(robot.q);
    for (int link = 0; link < kNumLinks; ++link) {
      const auto slope = [&](const auto& velocity) -> Vec3 {
        return (velocity(after, link, v) - velocity(before, link, v)) / (2 * kStep);
      };
      Vec3Of<double> linear;
      Vec3Of<double> angular;
      links.frames().bias_acceleration(link, v, linear, angular);
      REQUIRE((vec3(linear) - slope(center_velocity)).norm() < 1e-7);
      REQUIRE((vec3(angular) - slope(angular_velocity)).norm() < 1e-7);
    }
  }
}

TEST_CASE("A link's compliance is a quarter of its largest response along an axis", "[robot]") {
  for (const Robot& robot : random_robots(16)) {
    const Links links(robot.q);
    const JointMatrixOf<double> inverse = links.inverse_mass_matrix();
    for (int link = 0; link < kNumLinks; ++link) {
      JointsOf<double> rows[3];
      links.frames().center_jacobian(link, rows);
      double largest = 0;
      for (const JointsOf<double>& row : rows) {
        double response = 0;
        for (int i = 0; i < kRobotJoints; ++i) {
          for (int k = 0; k < kRobotJoints; ++k) response += row[i] * inverse[i][k] * row[k];
        }
        largest = std::max(largest, response);
      }
      REQUIRE(links.frames().compliance(link, inverse) == Approx(0.25 * largest));
    }
  }
}

TEST_CASE("A joint is as compliant as the softer of its two links", "[robot]") {
  const Links links(random_robots(1).front().q);
  const JointMatrixOf<double> inverse = links.inverse_mass_matrix();
  const auto of_link = [&](int link) { return links.frames().compliance(link, inverse); };
  const auto of_joint = [&](int joint) { return links.frames().joint_compliance(joint, inverse); };
  CHECK(of_joint(0) == of_link(0));
  for (int joint = 1; joint < kArmJoints; ++joint) {
    CHECK(of_joint(joint) == std::max(of_link(joint), of_link(joint - 1)));
  }
  CHECK(of_joint(kArmJoints) == std::max(of_link(kLeftFingerLink), of_link(kHandLink)));
}

}  // namespace
}  // namespace engram::test
