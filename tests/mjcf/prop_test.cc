// Props in motion: cubes that rest, and cubes that are held.
#include "mjcf/prop.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "tests/mjcf/model.h"

namespace engram::mjcf::test {
namespace {

TEST_CASE("A cube weighs what its density says", "[mjcf][prop]") {
  const Prop prop = cube("cube", 0.02, {1, 0, 0, 1});
  CHECK(prop.mass == Approx(0.064));
  for (size_t i = 0; i < 3; ++i) CHECK(prop.inertia[i] == Approx(0.064 * 0.04 * 0.04 / 6));
  for (size_t i = 3; i < 6; ++i) CHECK(prop.inertia[i] == 0);

  const Model model = compile({{prop}}, Detail::kPhysics);
  const int body = id(model, mjOBJ_BODY, "cube");
  CHECK(model->body_mass[body] == Approx(0.064));
  CHECK(model->body_inertia[3 * body] == Approx(0.064 * 0.04 * 0.04 / 6));
}

TEST_CASE("A dropped cube comes to rest on the table", "[mjcf][prop]") {
  Prop prop = cube("cube", 0.02, {1, 0, 0, 1});
  prop.pos = {0, 0.1, 0.03};
  const Model model = compile_driven({{prop}}, Detail::kPhysics);
  const Data data = make_data(model, kMikasa);
  for (int i = 0; i < 200; ++i) step(model, data);
  CHECK(data->qpos[11] == Approx(0.02).margin(1e-3));
  CHECK(mju_norm(data->qvel + 9, 6) < 1e-3);
}

// Holds a cube at the TCP of the rest pose. The fingers start almost closed on it.
struct Grasp {
  Grasp() {
    Prop prop = cube("cube", 0.02, {1, 0, 0, 1});
    prop.pos = {0.00001, 0, 0.16978};
    model = compile_driven({{prop}}, Detail::kPhysics);
    Arm pose = kRest;
    pose[7] = pose[8] = 0.0205;
    data = make_data(model, pose);
    data->ctrl[7] = data->ctrl[8] = -0.01;
  }

  void run(double seconds) {
    const long steps = std::lround(seconds * 100);
    for (long i = 0; i < steps; ++i) step(model, data);
  }

  // Position of the cube in the hand.
  std::array<double, 3> cube_in_hand() const {
    mj_kinematics(model.get(), data.get());
    const int tcp = id(model, mjOBJ_SITE, "tcp");
    mjtNum difference[3];
    std::array<double, 3> local{};
    mju_sub3(difference, data->qpos + 9, data->site_xpos + 3 * tcp);
    mju_mulMatTVec(local.data(), data->site_xmat + 9 * tcp, difference, 3, 3);
    return local;
  }

  Model model;
  Data data{nullptr, mj_deleteData};
};

double distance(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  return mju_dist3(a.data(), b.data());
}

TEST_CASE("A grasped cube does not slip", "[mjcf][prop]") {
  Grasp grasp;
  grasp.run(0.3);
  const auto start = grasp.cube_in_hand();
  grasp.run(2);
  CHECK(distance(start, grasp.cube_in_hand()) < 1e-3);
  // Each finger presses with 1000 (half width + 0.01) N.
  CHECK(grasp.data->qpos[7] == Approx(0.02).margin(3e-4));
  CHECK(grasp.data->qpos[8] == Approx(0.02).margin(3e-4));
  CHECK(mju_norm(grasp.data->qvel, 15) < 1e-3);
}

TEST_CASE("A grasped cube follows the hand", "[mjcf][prop]") {
  Grasp grasp;
  grasp.run(0.3);
  const auto start = grasp.cube_in_hand();
  // Swings at up to 0.4 m/s. A free body moves along the tangent in a step, the hand along the
  // arc: held by friction alone, the cube drifts outwards.
  for (int i = 0; i < 40; ++i) {
    grasp.data->ctrl[0] = 0.25 * std::sin(0.15 * i);
    grasp.data->ctrl[3] = kRest[3] + 0.1 * std::sin(0.3 * i);
    grasp.run(0.05);
  }
  CHECK(distance(start, grasp.cube_in_hand()) < 3e-3);
}

// Servoes the TCP towards a point through the drives' targets, 0.1 m per control step at most.
class Servo {
 public:
  Servo(const Model& model, const Data& data)
      : model_(model), data_(data), tcp_(id(model, mjOBJ_SITE, "tcp")) {}

  void run(const std::array<double, 3>& goal, double fingers, int controls) {
    for (int i = 0; i < controls; ++i) {
      aim(goal);
      data_->ctrl[7] = data_->ctrl[8] = fingers;
      for (int k = 0; k < 5; ++k) step(model_, data_);
    }
  }

  const double* tcp() {
    mj_kinematics(model_.get(), data_.get());
    return data_->site_xpos + 3 * tcp_;
  }

 private:
  // Position only: dq = J' (J J')^-1 error.
  void aim(const std::array<double, 3>& goal) {
    const auto nv = static_cast<size_t>(model_->nv);
    std::vector<mjtNum> jacobian(3 * nv);
    mj_jacSite(model_.get(), data_.get(), jacobian.data(), nullptr, tcp_);
    mjtNum product[9], error[3], weights[3];
    mju_mulMatMatT(product, jacobian.data(), jacobian.data(), 3, static_cast<int>(nv), 3);
    mju_cholFactor(product, 3, 1e-9);
    mju_sub3(error, goal.data(), data_->site_xpos + 3 * tcp_);
    if (mju_norm3(error) > 0.1) mju_scl3(error, error, 0.1 / mju_norm3(error));
    mju_cholSolve(weights, product, error, 3);
    for (size_t k = 0; k < 7; ++k) {
      data_->ctrl[k] = data_->qpos[k];
      for (size_t row = 0; row < 3; ++row) {
        data_->ctrl[k] += jacobian[row * nv + k] * weights[row];
      }
    }
  }

  const Model& model_;
  const Data& data_;
  int tcp_;
};

TEST_CASE("A cube on the table is grasped, lifted and carried", "[mjcf][prop]") {
  const Prop prop = cube("cube", 0.02, {1, 0, 0, 1});
  const Model model = compile_driven({{prop}}, Detail::kPhysics);
  const Data data = make_data(model, kRest);
  Servo servo(model, data);

  servo.run({0, 0, 0.02}, 0.04, 60);
  servo.run({0, 0, 0.02}, -0.01, 20);
  const double* cube_position = data->qpos + 9;
  const std::array<double, 3> goals[] = {{0, 0, 0.2}, {0, 0.2, 0.2}, {-0.1, 0, 0.1}};
  for (const auto& goal : goals) {
    servo.run(goal, -0.01, 60);
    CHECK(mju_dist3(servo.tcp(), goal.data()) < 2e-3);
    CHECK(mju_dist3(servo.tcp(), cube_position) < 5e-3);
  }
  servo.run(goals[2], 0.04, 60);
  CHECK(cube_position[2] == Approx(0.02).margin(1e-3));
}

}  // namespace
}  // namespace engram::mjcf::test
