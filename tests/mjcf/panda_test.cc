// The compiled robot against published numbers. See docs/robot.md.
#include "mjcf/panda.h"

#include <catch2/catch.hpp>
#include <vector>

#include "tests/mjcf/model.h"

namespace engram::mjcf::test {
namespace {

// |a . b| of two quaternions is 1 if they are the same rotation.
double similarity(const double* a, const std::array<double, 4>& b) {
  return std::abs(a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]);
}

struct KeyPose {
  Arm joints;
  std::array<double, 3> position;
  std::array<double, 4> orientation;
};

TEST_CASE("The TCP is where it should be at every key pose", "[mjcf][panda]") {
  const double half = std::sqrt(0.5);
  const KeyPose pose =
      GENERATE_COPY(KeyPose{kRest, {0.00001, 0, 0.16978}, {0, 1, 0, 0}},
                    KeyPose{kBuilder, {0.00001, 0, 0.16978}, {0, half, half, 0}},
                    KeyPose{kMikasa, {-0.070696, 0, 0.318047}, {0, 1, 0, 0}},
                    // The start pose after a delta pose action.
                    KeyPose{{-0.013974, 0.240072, -0.013974, -2 * kPi / 3 + 0.025537, -0.034641,
                             2 * kPi / 3 + 0.214535, kPi / 4 + 0.039373, 0.04, 0.04},
                            {-0.032443, -0.019793, 0.212619},
                            {0.0143, 0.9997, -0.0217, 0.0}});
  const Model model = compile({}, Detail::kRobotOnly);
  const Data data = make_data(model, pose.joints);

  const int tcp = id(model, mjOBJ_SITE, "tcp");
  for (int i = 0; i < 3; ++i) {
    CHECK(data->site_xpos[3 * tcp + i] ==
          Approx(pose.position[static_cast<size_t>(i)]).margin(1e-4));
  }
  std::array<double, 4> orientation;
  mju_mat2Quat(orientation.data(), data->site_xmat + 9 * tcp);
  CHECK(similarity(orientation.data(), pose.orientation) == Approx(1).margin(1e-4));
}

TEST_CASE("Bodies, joints and drives come in the specified order", "[mjcf][panda]") {
  const Model model = compile(cubes(2), Detail::kPhysics);
  const std::vector<std::string> bodies = {
      "world", "link0", "link1",       "link2",      "link3",       "link4", "link5", "link6",
      "link7", "hand",  "camera_link", "leftfinger", "rightfinger", "cube0", "cube1"};
  REQUIRE(model->nbody == static_cast<int>(bodies.size()));
  for (int i = 0; i < model->nbody; ++i) {
    CHECK(mj_id2name(model.get(), mjOBJ_BODY, i) == bodies[static_cast<size_t>(i)]);
  }
  const std::vector<std::string> joints = {"joint1", "joint2",        "joint3",
                                           "joint4", "joint5",        "joint6",
                                           "joint7", "finger_joint1", "finger_joint2"};
  REQUIRE(model->nu == 9);
  for (int i = 0; i < 9; ++i) {
    CHECK(mj_id2name(model.get(), mjOBJ_JOINT, i) == joints[static_cast<size_t>(i)]);
    CHECK(mj_id2name(model.get(), mjOBJ_ACTUATOR, i) == joints[static_cast<size_t>(i)]);
    CHECK(model->actuator_trnid[2 * i] == i);
    CHECK(model->jnt_qposadr[i] == i);
  }
}

TEST_CASE("Joints have their limits", "[mjcf][panda]") {
  constexpr std::array<std::array<double, 2>, 9> kLimits = {{{-2.8973, 2.8973},
                                                             {-1.7628, 1.7628},
                                                             {-2.8973, 2.8973},
                                                             {-3.0718, -0.0698},
                                                             {-2.8973, 2.8973},
                                                             {-0.0175, 3.7525},
                                                             {-2.8973, 2.8973},
                                                             {0, 0.04},
                                                             {0, 0.04}}};
  const Model model = compile({}, Detail::kRobotOnly);
  for (int i = 0; i < 9; ++i) {
    CHECK(model->jnt_limited[i]);
    CHECK(model->jnt_range[2 * i] == kLimits[static_cast<size_t>(i)][0]);
    CHECK(model->jnt_range[2 * i + 1] == kLimits[static_cast<size_t>(i)][1]);
  }
}

struct Inertial {
  const char* body;
  double mass;
  std::array<double, 3> com;
  std::array<double, 6> inertia;  // xx yy zz xy xz yz
};

constexpr Inertial kInertials[] = {
    {"link0",
     0.629769,
     {-0.041018, -0.00014, 0.049974},
     {0.00315, 0.00388, 0.004285, 8.2904e-07, 0.00015, 8.2299e-06}},
    {"link1",
     4.970684,
     {0.003875, 0.002081, -0.04762},
     {0.70337, 0.70661, 0.009117, -0.000139, 0.006772, 0.019169}},
    {"link2",
     0.646926,
     {-0.003141, -0.02872, 0.003495},
     {0.007962, 0.02811, 0.025995, -0.003925, 0.010254, 0.000704}},
    {"link3",
     3.228604,
     {0.027518, 0.039252, -0.066502},
     {0.037242, 0.036155, 0.01083, -0.004761, -0.011396, -0.012805}},
    {"link4",
     3.587895,
     {-0.05317, 0.104419, 0.027454},
     {0.025853, 0.019552, 0.028323, 0.007796, -0.001332, 0.008641}},
    {"link5",
     1.225946,
     {-0.011953, 0.041065, -0.038437},
     {0.035549, 0.029474, 0.008627, -0.002117, -0.004037, 0.000229}},
    {"link6",
     1.666555,
     {0.060149, -0.014117, -0.010517},
     {0.001964, 0.004354, 0.005433, 0.000109, -0.001158, 0.000341}},
    {"link7",
     0.735522,
     {0.010517, -0.004252, 0.061597},
     {0.012516, 0.010027, 0.004815, -0.000428, -0.001196, -0.000741}},
    {"hand", 0.73, {-0.01, 0, 0.03}, {0.001, 0.0025, 0.0017, 0, 0, 0}},
    {"camera_link", 0.564, {0, 0, 0}, {0.003881243, 0.00049894, 0.003879257, 0, 0, 0}},
    {"leftfinger", 0.015, {0, 0, 0}, {2.375e-06, 2.375e-06, 7.5e-07, 0, 0, 0}},
    {"rightfinger", 0.015, {0, 0, 0}, {2.375e-06, 2.375e-06, 7.5e-07, 0, 0, 0}},
};

TEST_CASE("Inertial properties are those of the table in every document", "[mjcf][panda]") {
  const Detail detail = GENERATE(Detail::kFull, Detail::kPhysics, Detail::kRobotOnly);
  const Model model = compile(cubes(1), detail);
  for (const Inertial& expected : kInertials) {
    INFO(expected.body);
    const int body = id(model, mjOBJ_BODY, expected.body);
    CHECK(model->body_mass[body] == expected.mass);
    for (int i = 0; i < 3; ++i) {
      CHECK(model->body_ipos[3 * body + i] == expected.com[static_cast<size_t>(i)]);
    }
    // R diag(I) R' gives the tensor back.
    mjtNum rotation[9];
    mju_quat2Mat(rotation, model->body_iquat + 4 * body);
    const mjtNum* principal = model->body_inertia + 3 * body;
    const auto element = [&](int row, int column) {
      double sum = 0;
      for (int k = 0; k < 3; ++k) {
        sum += rotation[3 * row + k] * principal[k] * rotation[3 * column + k];
      }
      return sum;
    };
    const double tensor[] = {element(0, 0), element(1, 1), element(2, 2),
                             element(0, 1), element(0, 2), element(1, 2)};
    // MuJoCo's eigenvectors are good to about a millionth.
    const double margin = 1e-6 * (tensor[0] + tensor[1] + tensor[2]);
    for (size_t i = 0; i < 6; ++i) CHECK(tensor[i] == Approx(expected.inertia[i]).margin(margin));
  }
}

TEST_CASE("A drive pulls with 1000 N/m, damped by 100, taken implicitly", "[mjcf][panda]") {
  const Model model = compile({}, Detail::kRobotOnly);
  const Data data = make_data(model, kMikasa);
  for (int i = 0; i < 9; ++i) {
    INFO("joint " << i);
    const double implicit = i < 7 ? 5 : 10;  // half and all of 0.01 s times the stiffness
    CHECK(model->dof_armature[i] == Approx(0.01 * (100 + implicit)));
    CHECK(model->dof_damping[i] == 0);
    const double error = GENERATE(0.02, -0.05, 0.3, -0.3);
    data->ctrl[i] = data->qpos[i] + error;
    data->qvel[i] = 0.1;
    mj_forward(model.get(), data.get());
    const double force = 1000 * error - 0.1 * (100 + implicit);
    CHECK(data->qfrc_actuator[i] == Approx(std::clamp(force, -200.0, 200.0)));
    REQUIRE(model->nuser_actuator == 3);
    const std::vector<double> user(model->actuator_user + 3 * i, model->actuator_user + 3 * i + 3);
    CHECK(user == std::vector<double>{1000, 100, 100});
  }
}

TEST_CASE("Fingers are coupled by a spring on their difference", "[mjcf][panda]") {
  const Model model = compile({}, Detail::kRobotOnly);
  Arm pose = kMikasa;
  pose[7] = 0.03;
  pose[8] = 0.02;
  const Data data = make_data(model, pose);
  CHECK(data->qfrc_passive[7] == Approx(-20));
  CHECK(data->qfrc_passive[8] == Approx(20));
}

}  // namespace
}  // namespace engram::mjcf::test
