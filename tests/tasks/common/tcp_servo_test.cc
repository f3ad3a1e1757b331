#include "tasks/common/tcp_servo.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/tasks/pose_tool.h"

namespace engram {
namespace {

using namespace tasks;

// A robot that stands where it is put.
std::unique_ptr<Batch> make_still_env() {
  BatchOptions options;
  options.substeps = 0;
  auto env = test::make_env("RememberColor3-VLA-v0", options);
  env->reset();
  return env;
}

TEST_CASE("The tool tilts outwards where it must and not before", "[servo]") {
  const auto tilt_of = [](double reach, const Tilt& tilt = {}) {
    const Eigen::Vector3d point(kRobotBaseX + reach, 0, 0);
    const Eigen::Vector3d approach =
        tilt_outwards(kToolDown, point, tilt) * Eigen::Vector3d::UnitZ();
    return std::atan2(approach.x(), -approach.z());  // positive: the tips point outwards
  };
  CHECK(tilt_of(0.6) == 0);
  CHECK(tilt_of(0.78) == Approx(0.16));
  CHECK(tilt_of(1.0) == Approx(0.4));
  CHECK(tilt_of(0.28) == 0);
  CHECK(tilt_of(0.28, {.fold = 0.33}) == Approx(-0.2));
}

TEST_CASE("The servo moves towards its goal, at full scale at most", "[servo]") {
  const auto env = make_still_env();
  test::step_at(*env, {0.0, 0.0, 0.2});
  std::array<float, 7> action{};
  servo_tcp(env->state(), 0, {0.01, -1.0, 0.2}, kToolDown, kGripperOpen, action.data());
  CHECK(action[0] == Approx(0.16).margin(1e-4));  // 1.6 times the distance, of 0.1 m
  CHECK(action[1] == -1);
  CHECK(action[2] == Approx(0).margin(1e-4));
  CHECK(action[6] == 1);
  hold_tcp(kGripperClosed, action.data());
  for (int i = 0; i < 6; ++i) CHECK(action[static_cast<std::size_t>(i)] == 0);
}

TEST_CASE("An approach comes down where the tool is overhead", "[servo]") {
  const auto env = make_still_env();
  const Eigen::Vector3d goal(0.0, 0.0, 0.05);
  const auto heights = [&](const Eigen::Vector3d& tcp) {
    test::step_at(*env, tcp);
    return std::array{approach_from_above(env->state(), 0, goal, 0.06).z(),
                      descend(env->state(), 0, goal, 0.115).z()};
  };
  CHECK(heights({0.1, 0.0, 0.15})[0] == Approx(0.11));
  CHECK(heights({0.1, 0.0, 0.15})[1] == Approx(0.115));  // no higher than it travels
  CHECK(heights({0.03 - 1e-6, 0.0, 0.15})[0] == Approx(0.05));
  CHECK(heights({0.03, 0.0, 0.15})[1] == Approx(0.07).margin(1e-5));
  CHECK(heights({0.005, 0.0, 0.15})[1] == Approx(0.05));
}

TEST_CASE("Low down, translations are slower", "[servo]") {
  const auto env = make_still_env();
  const auto speed_at = [&](double height) {
    test::step_at(*env, {0.0, 0.0, height});
    std::array<float, 7> action{0, 1, 0, 0, 0, 0, 0};
    limit_speed_near(env->state(), 0, 0.05, action.data());
    return static_cast<double>(action[1]);
  };
  CHECK(speed_at(0.05) == Approx(0.25).margin(1e-4));
  CHECK(speed_at(0.10) == Approx(0.65).margin(1e-4));
  CHECK(speed_at(0.20) == 1);
}

}  // namespace
}  // namespace engram
