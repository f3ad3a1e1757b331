// Queries of a batch: robot, cameras, sampled values.
#include "core/batch/queries.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "core/batch/scene_renderer.h"
#include "protocol/make/make.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

using Catch::Matchers::Contains;

std::vector<float> floats(const Batch& env, int width) {
  return std::vector<float>(static_cast<std::size_t>(env.num_envs() * width));
}

TEST_CASE("The robot's state is known in every observation mode", "[queries]") {
  BatchOptions options;
  options.num_envs = 3;
  const auto observed = make("RememberColor3-VLA-v0", options);
  options.obs_mode = ObsMode::kNone;
  const auto env = make("RememberColor3-VLA-v0", options);
  std::vector<float> qpos = floats(*env, 9);
  std::vector<float> qvel = floats(*env, 9);
  std::vector<float> tcp = floats(*env, 7);
  CHECK_THROWS_WITH(Queries(*env).robot_state(qpos, qvel, tcp), Contains("before the first reset"));
  for (Batch* batch : {observed.get(), env.get()}) {
    batch->reset();
    for (int i = 0; i < 12; ++i) test::step(*batch, Policy::kRandom);
  }
  Queries(*env).robot_state(qpos, qvel, tcp);
  for (int i = 0; i < 3; ++i) {
    // A row of the state begins with qpos, qvel and the TCP's pose.
    const float* row = observed->observation().data() + i * observed->state_dim();
    CHECK(std::equal(row, row + 9, qpos.data() + 9 * i));
    CHECK(std::equal(row + 9, row + 18, qvel.data() + 9 * i));
    CHECK(std::equal(row + 18, row + 25, tcp.data() + 7 * i));
  }
  Queries(*env).robot_state({}, {}, {});
  qpos.pop_back();
  CHECK_THROWS_WITH(Queries(*env).robot_state(qpos, {}, {}),
                    Contains("26 values given, 27 needed"));
}

struct Camera {
  Eigen::Matrix<float, 3, 4, Eigen::RowMajor> extrinsic;
  Eigen::Matrix<float, 4, 4, Eigen::RowMajor> pose;
  Eigen::Matrix<float, 3, 3, Eigen::RowMajor> intrinsic;

  // In pixels from the upper left corner.
  Eigen::Vector2f project(const Eigen::Vector3d& point) const {
    const Eigen::Vector3f seen = intrinsic * (extrinsic * point.cast<float>().homogeneous());
    REQUIRE(seen.z() > 0);
    return seen.head<2>() / seen.z();
  }
};

Camera camera_of(Batch& env, int index, const std::string& name, int width, int height) {
  std::vector<float> extrinsic = floats(env, 12);
  std::vector<float> pose = floats(env, 16);
  std::vector<float> intrinsic = floats(env, 9);
  Queries(env).camera_params(name, width, height, {extrinsic, pose, intrinsic});
  Camera camera;
  camera.extrinsic = Eigen::Map<decltype(camera.extrinsic)>(extrinsic.data() + 12 * index);
  camera.pose = Eigen::Map<decltype(camera.pose)>(pose.data() + 16 * index);
  camera.intrinsic = Eigen::Map<decltype(camera.intrinsic)>(intrinsic.data() + 9 * index);
  return camera;
}

std::vector<std::uint8_t> picture(Batch& env, int index, const std::string& camera, int width,
                                  int height) {
  std::vector<std::uint8_t> rgb(static_cast<std::size_t>(3 * width * height));
  SceneRenderer(env).render(index, camera, width, height, rgb);
  return rgb;
}

// The middle of the pixels that differ.
Eigen::Vector2f middle_of_change(const std::vector<std::uint8_t>& first,
                                 const std::vector<std::uint8_t>& second, int width) {
  Eigen::Vector2f sum(0, 0);
  int count = 0;
  for (std::size_t i = 0; i < first.size(); i += 3) {
    if (std::equal(first.begin() + static_cast<std::ptrdiff_t>(i),
                   first.begin() + static_cast<std::ptrdiff_t>(i) + 3,
                   second.begin() + static_cast<std::ptrdiff_t>(i))) {
      continue;
    }
    const int pixel = static_cast<int>(i / 3);
    sum += Eigen::Vector2f(static_cast<float>(pixel % width) + 0.5F,
                           static_cast<float>(pixel / width) + 0.5F);
    ++count;
  }
  REQUIRE(count > 20);
  return sum / static_cast<float>(count);
}

TEST_CASE("A ball is seen where the cameras' matrices say", "[queries]") {
  BatchOptions options;
  options.num_envs = 2;
  const auto env = make("InterceptSlow-VLA-v0", options);
  env->reset();
  std::vector<float> actions = test::zeros(*env);
  for (std::size_t i = 7; i < 14; ++i) actions[i] = 0.4F;  // the second arm moves and turns
  for (int i = 0; i < 5; ++i) env->step(actions);
  for (const auto& [width, height] : {std::pair(200, 160), std::pair(128, 256)}) {
    for (const std::string name : {"base_camera", "hand_camera"}) {
      CAPTURE(name, width, height);
      const Camera camera = camera_of(*env, 1, name, width, height);
      // Half a metre before the camera, off its axis.
      const Eigen::Vector4f before(0.06F, 0.09F, -0.35F, 1);
      const Eigen::Vector3d ball = (camera.pose * before).head<3>().cast<double>();
      const double still[4] = {1, 0, 0, 0};
      env->state().place_prop(1, 0, ball.data(), still);
      const auto with = picture(*env, 1, name, width, height);
      env->state().hide_prop(1, 0, ball.data());
      const auto without = picture(*env, 1, name, width, height);
      const Eigen::Vector2f seen = middle_of_change(with, without, width);
      const Eigen::Vector2f projected = camera.project(ball);
      CAPTURE(seen.x(), seen.y(), projected.x(), projected.y());
      CHECK((seen - projected).norm() < 1.0F);
      // The same place in both conventions.
      const Eigen::Vector3f cv = camera.extrinsic * ball.cast<float>().homogeneous();
      CHECK((cv - Eigen::Vector3f(before.x(), -before.y(), -before.z())).norm() < 1e-5F);
    }
  }
  // The first arm has stood still: its camera is elsewhere.
  const Camera first = camera_of(*env, 0, "hand_camera", 128, 128);
  CHECK((first.pose - camera_of(*env, 1, "hand_camera", 128, 128).pose).norm() > 0.05F);
  CHECK(first.intrinsic(0, 0) == Approx(64));
  CHECK(first.intrinsic(1, 2) == 64);
  CHECK_THROWS_WITH(Queries(*env).camera_params("top", 128, 128, {}), Contains("hand_camera"));
  CHECK_THROWS_WITH(Queries(*env).camera_params("hand_camera", 0, 128, {}), Contains("1 to 4096"));
}

// The drawn values of an environment by name, the first of each.
std::map<std::string, double> drawn(const Batch& env, int index) {
  std::vector<float> values = floats(env, Queries(env).sampled_dim());
  Queries(env).sampled_values(values);
  std::map<std::string, double> named;
  std::size_t at = static_cast<std::size_t>(index * Queries(env).sampled_dim());
  for (const Field& field : env.info().sampled_values) {
    named[field.name] = static_cast<double>(values[at]);
    at += static_cast<std::size_t>(field.width);
  }
  return named;
}

std::map<std::string, double> drawn_with(const std::string& id, std::vector<Pin> pins) {
  BatchOptions options;
  options.num_envs = 2;
  options.pins = std::move(pins);
  const auto env = test::make_env(id, options);
  env->reset();
  test::step(*env, Policy::kZero);
  return drawn(*env, 1);
}

TEST_CASE("Sampled values are those of the episode", "[queries]") {
  using Values = std::map<std::string, double>;
  CHECK(drawn_with("RememberShape9-Long-VLA-v0", {{"cue_steps", {60}}, {"empty_steps", {300}}}) ==
        Values{{"cue_steps_per_env", 60}, {"empty_steps_per_env", 300}});
  CHECK(drawn_with("ShellGamePush-VLA-v0", {}).contains("cue_steps_per_env"));
  CHECK_FALSE(drawn_with("ShellGamePush-VLA-v0", {}).contains("empty_steps_per_env"));
  const Values shuffle = drawn_with("ShellGameShuffleTouch-VLA-v0", {});
  CHECK(shuffle.at("empty_steps_per_env") > 0);
  CHECK(drawn_with("BlinkCountButtonPressEasy-VLA-v0", {{"target_blinks", {2}}})
            .at("target_blinks") == 2);
  const Values timed = drawn_with("TimedTransferEasy-VLA-v0", {{"signal_step", {3}}});
  CHECK(timed.at("signal_step") == 3);
  CHECK(timed.at("window_start") > 3);
  CHECK(timed.at("window_end") >= timed.at("window_start"));
  CHECK(drawn_with("TakeItBack-VLA-v0", {}).empty());
  CHECK(drawn_with("BatteriesCheckerEasy-3-VLA-v0", {}).empty());
}

TEST_CASE("Waypoints lie on the shapes that are shown, and are 0 after the last", "[queries]") {
  BatchOptions options;
  options.pins = {{"shapes", {0, 0, 0, 0, 0}},    {"radii", {0.08, 0.09, 0.1, 0.11, 0.12}},
                  {"center_x", {-0.1}},           {"center_y", {0.05}},
                  {"rotations", {0, 1, 2, 3, 4}}, {"sequence_length", {3}}};
  const auto env = test::make_env("TraceShapeSeqEasy-VLA-v0", options);
  env->reset();
  const std::vector<Field>& fields = env->info().sampled_values;
  REQUIRE(fields.back().name == "waypoints");
  REQUIRE(fields.back().width == 5 * 64 * 2);
  std::vector<float> values = floats(*env, Queries(*env).sampled_dim());
  Queries(*env).sampled_values(values);
  const float* next = values.data() + values.size() - 5 * 64 * 2;
  for (int shape = 0; shape < 5; ++shape) {
    for (int i = 0; i < 64; ++i, next += 2) {
      CAPTURE(shape, i);
      if (shape < 3) {
        CHECK(std::hypot(next[0] + 0.1F, next[1] - 0.05F) == Approx(0.08 + 0.01 * shape));
      } else {
        CHECK(next[0] == 0);
        CHECK(next[1] == 0);
      }
    }
  }
}

// Whether actions are frozen ends where these say, in the tasks that freeze them.
TEST_CASE("Every task reports the lengths of its phases", "[queries]") {
  for (const std::string& id : test::implemented_ids()) {
    CAPTURE(id);
    BatchOptions options;
    options.num_envs = 3;
    options.seed = 5;
    const auto env = test::make_env(id, options);
    CHECK_THROWS_WITH(drawn(*env, 0), Contains("before the first reset"));
    env->reset();
    for (int i = 0; i < 3; ++i) {
      std::map<std::string, double> values = drawn(*env, i);
      if (values.contains("cue_steps_per_env")) {
        CHECK(values["cue_steps_per_env"] == Queries(*env).cue_end(i));
      }
      for (const Field& field : env->info().sampled_values) {
        if (field.dtype == DType::kInt32)
          CHECK(std::trunc(values[field.name]) == values[field.name]);
      }
      if (!env->info().frozen_cue) continue;
      const int frozen = *test::row<std::int32_t>(env->memory().find("freeze_steps"), i);
      CHECK(values["cue_steps_per_env"] + values["empty_steps_per_env"] == frozen);
    }
  }
}

}  // namespace
}  // namespace engram
