#include "core/robot/arm.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "core/base/error.h"
#include "core/math/random.h"
#include "core/scene/mujoco_handle.h"
#include "tasks/common/task_info.h"

namespace engram {
namespace {

constexpr double kPi = std::numbers::pi;
using JointJacobian = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>;

struct Robot {
  ModelPtr model = compile_model(tasks::scene_source({}).compose({}, RobotDetail::kCollision));
  DataPtr data = make_data(*model);
  Arm arm{*model};
};

// Joint angles within the limits, or beyond them as a simulation may get.
ArmVector random_joints(const mjModel& model, RandomStream& random, double beyond = 0.1) {
  ArmVector q;
  for (int i = 0; i < kArmJoints; ++i) {
    q[i] = random.uniform(model.jnt_range[2 * i] - beyond, model.jnt_range[2 * i + 1] + beyond);
  }
  return q;
}

const ArmVector kStart{{0, 0, 0, -2 * kPi / 3, 0, 2 * kPi / 3, kPi / 4}};

// Smallest joint step that gives a displacement, by its definition.
template <class Jacobian, class Displacement>
ArmVector pseudo_inverse(const Jacobian& jacobian, const Displacement& displacement) {
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(jacobian, Eigen::ComputeThinU | Eigen::ComputeThinV);
  ArmVector step = ArmVector::Zero();
  for (Eigen::Index i = 0; i < jacobian.rows(); ++i) {
    const double sigma = svd.singularValues()[i];
    if (sigma <= 7 * 1.2e-7 * svd.singularValues()[0]) continue;
    step += svd.matrixV().col(i) * svd.matrixU().col(i).dot(displacement) / sigma;
  }
  return step;
}

TEST_CASE("The arm reaches the TCP poses of the key poses", "[arm]") {
  const Robot robot;
  const double half = std::sqrt(0.5);
  struct KeyPose {
    ArmVector q;
    Eigen::Vector3d pos;
    Eigen::Quaterniond quat;
  };
  const ArmVector rest{{0, kPi / 8, 0, -5 * kPi / 8, 0, 3 * kPi / 4, kPi / 4}};
  ArmVector wrist_camera = rest;
  wrist_camera[6] = -kPi / 4;
  const KeyPose poses[] = {
      {rest, {0.00001, 0, 0.16978}, {0, 1, 0, 0}},
      {wrist_camera, {0.00001, 0, 0.16978}, {0, half, half, 0}},
      {kStart, {-0.070696, 0, 0.318047}, {0, 1, 0, 0}},
  };
  for (const KeyPose& key : poses) {
    const Pose pose = robot.arm.forward(key.q.data());
    CHECK((pose.pos - key.pos).norm() < 1e-5);
    CHECK(pose.quat.angularDistance(key.quat) < 1e-5);
    CHECK(pose.quat.norm() == Approx(1).margin(1e-14));
  }
}

TEST_CASE("Forward kinematics and Jacobian equal MuJoCo's at random poses", "[arm]") {
  const Robot robot;
  const int site = mj_name2id(robot.model.get(), mjOBJ_SITE, "tcp");
  RandomStream random(1, 0, 0);
  for (int round = 0; round < 300; ++round) {
    const ArmVector q = random_joints(*robot.model, random);
    mj_resetData(robot.model.get(), robot.data.get());
    Eigen::Map<ArmVector>(robot.data->qpos) = q;
    mj_kinematics(robot.model.get(), robot.data.get());
    mj_comPos(robot.model.get(), robot.data.get());
    JointJacobian linear(3, robot.model->nv);
    JointJacobian angular(3, robot.model->nv);
    mj_jacSite(robot.model.get(), robot.data.get(), linear.data(), angular.data(), site);

    ArmJacobian jacobian;
    const Pose pose = robot.arm.forward(q.data(), jacobian);
    const Pose same = robot.arm.forward(q.data());
    REQUIRE(same.pos == pose.pos);
    REQUIRE(same.quat.coeffs() == pose.quat.coeffs());
    REQUIRE((pose.pos - Eigen::Map<Eigen::Vector3d>(robot.data->site_xpos + 3 * site)).norm() <
            1e-12);
    REQUIRE(
        (pose.quat.toRotationMatrix() -
         Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(robot.data->site_xmat + 9 * site))
            .norm() < 1e-12);
    REQUIRE((jacobian.topRows<3>() - linear.leftCols<kArmJoints>()).norm() < 1e-12);
    REQUIRE((jacobian.bottomRows<3>() - angular.leftCols<kArmJoints>()).norm() < 1e-12);
  }
}

TEST_CASE("The Jacobian of the start pose is the published one", "[arm]") {
  const Robot robot;
  ArmJacobian expected;
  expected << 0, -0.014953, 0, 0.330953, 0, 0.210400, 0,  //
      0.544304, 0, 0.544304, 0, 0.138212, 0, 0,           //
      0, -0.544304, 0, 0.461804, 0, 0.088000, 0,          //
      0, 0, 0, 0, 0.866025, 0, 0,                         //
      0, 1, 0, -1, 0, -1, 0,                              //
      1, 0, 1, 0, -0.5, 0, -1;
  ArmJacobian jacobian;
  robot.arm.forward(kStart.data(), jacobian);
  CHECK((jacobian - expected).cwiseAbs().maxCoeff() < 1e-6);
}

TEST_CASE("A pseudo-inverse step equals that of the full SVD", "[arm]") {
  const Robot robot;
  RandomStream random(2, 0, 0);
  const auto check = [&](const ArmVector& q, double tolerance) {
    ArmJacobian jacobian;
    robot.arm.forward(q.data(), jacobian);
    Vector6 displacement;
    for (double& value : displacement) value = random.uniform(-0.1, 0.1);
    const ArmVector expected = pseudo_inverse(jacobian, displacement);
    const ArmVector step = Arm::pseudo_inverse_step(jacobian, displacement);
    REQUIRE((step - expected).norm() <= tolerance * (1 + expected.norm()));
    const Eigen::Vector3d linear = displacement.head<3>();
    const ArmVector expected3 = pseudo_inverse(jacobian.topRows<3>().eval(), linear);
    const ArmVector step3 = Arm::pseudo_inverse_step(jacobian, linear);
    REQUIRE((step3 - expected3).norm() <= tolerance * (1 + expected3.norm()));
  };

  for (int round = 0; round < 500; ++round) check(random_joints(*robot.model, random), 1e-6);

  // All axes in one plane, and the elbow straight: rank is lost.
  check(ArmVector::Zero(), 1e-9);
  const ArmVector upright{{0.3, 0, -0.2, 0, 0, kPi, 0.5}};
  check(upright, 1e-9);

  // From a common pose into the stretched elbow, where one singular value passes through zero.
  ArmVector q{{0.1, 0.9, 0, -0.467, 0, 1.4, 0.7}};
  double smallest = 1;
  for (int i = 0; i <= 400; ++i) {
    q[3] = -0.467 + 0.0005 * (i - 200);
    ArmJacobian jacobian;
    robot.arm.forward(q.data(), jacobian);
    smallest = std::min(smallest, jacobian.jacobiSvd().singularValues()[5]);
    check(q, 1e-6);
  }
  CHECK(smallest < 1e-3);
}

TEST_CASE("Where a direction is lost the pseudo-inverse leaves it out", "[arm]") {
  const Robot robot;
  ArmJacobian jacobian;
  robot.arm.forward(ArmVector::Zero().eval().data(), jacobian);
  REQUIRE(jacobian.jacobiSvd().singularValues()[5] < 1e-9);
  for (int axis = 0; axis < 6; ++axis) {
    const ArmVector step = Arm::pseudo_inverse_step(jacobian, (0.1 * Vector6::Unit(axis)).eval());
    CHECK(step.allFinite());
    CHECK(step.norm() < 10);
  }
}

TEST_CASE("Inverse kinematics finds joints for a pose nearby", "[arm]") {
  const Robot robot;
  RandomStream random(3, 0, 0);
  for (int round = 0; round < 100; ++round) {
    ArmVector q = kStart;
    for (double& value : q) value += random.uniform(-0.3, 0.3);
    ArmVector other = q;
    for (double& value : other) value += random.uniform(-0.05, 0.05);
    const Pose target = robot.arm.forward(other.data());
    ArmVector found;
    REQUIRE(robot.arm.inverse(target, q.data(), found));
    const Pose reached = robot.arm.forward(found.data());
    CHECK((reached.pos - target.pos).norm() < 1e-3);
    CHECK(reached.quat.angularDistance(target.quat) < 1e-2);
  }
}

// The original stops within its tolerances of 1 mm and 10 mrad, but makes a step there, too.
TEST_CASE("A step of inverse kinematics removes a fifth of the error", "[arm]") {
  const Robot robot;
  const Pose start = robot.arm.forward(kStart.data());
  Pose target = start;
  target.pos += Vec3(4e-4, -3e-4, 5e-4);
  target.quat = Quat(Eigen::AngleAxisd(5e-3, Vec3(1, 2, -2) / 3)) * start.quat;
  ArmVector found;
  REQUIRE(robot.arm.inverse(target, kStart.data(), found));
  const Pose reached = robot.arm.forward(found.data());
  CHECK((target.pos - reached.pos - 0.8 * (target.pos - start.pos)).norm() < 1e-6);
  CHECK(reached.quat.angularDistance(target.quat) == Approx(0.8 * 5e-3).margin(1e-5));
  // The smallest such step.
  ArmJacobian jacobian;
  robot.arm.forward(kStart.data(), jacobian);
  Vector6 error;
  error << target.pos - start.pos, rotation_vector(target.quat * start.quat.conjugate());
  CHECK((found - kStart - 0.2 * pseudo_inverse(jacobian, error)).norm() < 1e-8);
}

TEST_CASE("Inverse kinematics ends where the error no longer falls", "[arm]") {
  const Robot robot;
  for (const double away : {0.6, 3.0, 100.0}) {
    Pose target = robot.arm.forward(kStart.data());
    target.pos.x() += away;
    ArmVector found = ArmVector::Zero();
    CHECK_FALSE(robot.arm.inverse(target, kStart.data(), found));
    CHECK(found.allFinite());
    CHECK(found != kStart);
  }
}

TEST_CASE("Inverse kinematics takes no step to joints that are no angles", "[arm]") {
  const Robot robot;
  for (const double away : {1e30, 1e300}) {
    Pose target = robot.arm.forward(kStart.data());
    target.pos.x() += away;
    ArmVector found = ArmVector::Zero();
    CHECK_FALSE(robot.arm.inverse(target, kStart.data(), found));
    CHECK(found == kStart);
  }
}

TEST_CASE("A rotation vector is the shorter of both", "[arm]") {
  using Eigen::AngleAxisd;
  const Eigen::Vector3d axis = Eigen::Vector3d(1, -2, 0.5).normalized();
  for (const double angle : {0.0, 1e-14, 1e-7, 0.3, 3.0}) {
    Eigen::Quaterniond quat(AngleAxisd(angle, axis));
    CHECK((rotation_vector(quat) - angle * axis).norm() < 1e-12);
    quat.coeffs() *= -1;  // the same rotation
    CHECK((rotation_vector(quat) - angle * axis).norm() < 1e-12);
  }
  CHECK((rotation_vector(Eigen::Quaterniond(AngleAxisd(4.0, axis))) - (4 - 2 * kPi) * axis).norm() <
        1e-12);
}

TEST_CASE("Roll, pitch and yaw compose about fixed axes", "[arm]") {
  using Eigen::AngleAxisd, Eigen::Vector3d;
  RandomStream random(4, 0, 0);
  for (int round = 0; round < 100; ++round) {
    const Vector3d angles(random.uniform(-3, 3), random.uniform(-1.5, 1.5), random.uniform(-3, 3));
    const Eigen::Quaterniond quat = AngleAxisd(angles.z(), Vector3d::UnitZ()) *
                                    AngleAxisd(angles.y(), Vector3d::UnitY()) *
                                    AngleAxisd(angles.x(), Vector3d::UnitX());
    CHECK((roll_pitch_yaw(quat) - angles).norm() < 1e-9);
  }
  const double half = std::sqrt(0.5);
  CHECK(roll_pitch_yaw({half, 0, half, 0}).y() == Approx(kPi / 2));  // clipped, never NaN
  CHECK(std::abs(roll_pitch_yaw({0, 1, 0, 0}).x()) == Approx(kPi));
}

TEST_CASE("An arm needs a model with a TCP below seven hinges", "[arm]") {
  const ModelPtr empty = compile_model("<mujoco><worldbody><body/></worldbody></mujoco>");
  CHECK_THROWS_AS(Arm(*empty), Error);
  const ModelPtr finger = compile_model(
      "<mujoco><worldbody><body><joint type='hinge'/><geom size='1' mass='1'/>"
      "<site name='tcp'/></body></worldbody></mujoco>");
  CHECK_THROWS_WITH(Arm(*finger), Catch::Contains("seven hinges"));
}

}  // namespace
}  // namespace engram
