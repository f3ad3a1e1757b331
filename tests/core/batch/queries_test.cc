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

std::vector<float> floats(const Batch& batch, int width) {
  return std::vector<float>(static_cast<std::size_t>(batch.num_envs() * width));
}

TEST_CASE("The robot's state is known in every observation mode", "[queries]") {
  BatchOptions options{.num_envs = 3};
  const auto observed = make("RememberColor3-VLA-v0", options);
  options.obs_mode = ObsMode::kNone;
  const auto batch = make("RememberColor3-VLA-v0", options);
  std::vector<float> qpos = floats(*batch, 9);
  std::vector<float> qvel = floats(*batch, 9);
  std::vector<float> tcp = floats(*batch, 7);
  CHECK_THROWS_WITH(Queries(*batch).robot_state(qpos, qvel, tcp),
                    Contains("before the first reset"));
  for (Batch* each : {observed.get(), batch.get()}) {
    each->reset();
    for (int i = 0; i < 12; ++i) test::step(*each, Policy::kRandom);
  }
  Queries(*batch).robot_state(qpos, qvel, tcp);
  for (int i = 0; i < 3; ++i) {
    // A row of the state begins with qpos, qvel and the TCP's pose.
    const float* row = observed->outputs().observation.data() + i * observed->state_dim();
    CHECK(std::equal(row, row + 9, qpos.data() + 9 * i));
    CHECK(std::equal(row + 9, row + 18, qvel.data() + 9 * i));
    CHECK(std::equal(row + 18, row + 25, tcp.data() + 7 * i));
  }
  Queries(*batch).robot_state({}, {}, {});
  qpos.pop_back();
  CHECK_THROWS_WITH(Queries(*batch).robot_state(qpos, {}, {}),
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

Camera camera_of(Batch& batch, int index, const std::string& name, int width, int height) {
  std::vector<float> extrinsic = floats(batch, 12);
  std::vector<float> pose = floats(batch, 16);
  std::vector<float> intrinsic = floats(batch, 9);
  Queries(batch).camera_params(name, width, height, {extrinsic, pose, intrinsic});
  Camera camera;
  camera.extrinsic = Eigen::Map<decltype(camera.extrinsic)>(extrinsic.data() + 12 * index);
  camera.pose = Eigen::Map<decltype(camera.pose)>(pose.data() + 16 * index);
  camera.intrinsic = Eigen::Map<decltype(camera.intrinsic)>(intrinsic.data() + 9 * index);
  return camera;
}

std::vector<std::uint8_t> image(Batch& batch, int index, const std::string& camera, int width,
                                int height) {
  std::vector<std::uint8_t> rgb(static_cast<std::size_t>(3 * width * height));
  SceneRenderer(batch).render(index, camera, width, height, rgb);
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
  const BatchOptions options{.num_envs = 2};
  const auto batch = make("InterceptSlow-VLA-v0", options);
  batch->reset();
  std::vector<float> actions = test::zeros(*batch);
  for (std::size_t i = 7; i < 14; ++i) actions[i] = 0.4F;  // the second arm moves and turns
  for (int i = 0; i < 5; ++i) batch->step(actions);
  for (const auto& [width, height] : {std::pair(200, 160), std::pair(128, 256)}) {
    for (const std::string name : {"base_camera", "hand_camera"}) {
      CAPTURE(name, width, height);
      const Camera camera = camera_of(*batch, 1, name, width, height);
      // Half a metre before the camera, off its axis.
      const Eigen::Vector4f before(0.06F, 0.09F, -0.35F, 1);
      const Eigen::Vector3d ball = (camera.pose * before).head<3>().cast<double>();
      const double still[4] = {1, 0, 0, 0};
      batch->state().place_prop(1, 0, ball.data(), still);
      const auto with = image(*batch, 1, name, width, height);
      batch->state().hide_prop(1, 0, ball.data());
      const auto without = image(*batch, 1, name, width, height);
      const Eigen::Vector2f seen = middle_of_change(with, without, width);
      const Eigen::Vector2f projected = camera.project(ball);
      CAPTURE(seen.x(), seen.y(), projected.x(), projected.y());
      CHECK((seen - projected).norm() < 1.0F);
      // Both conventions give one place.
      const Eigen::Vector3f cv = camera.extrinsic * ball.cast<float>().homogeneous();
      CHECK((cv - Eigen::Vector3f(before.x(), -before.y(), -before.z())).norm() < 1e-5F);
    }
  }
  // The first arm has stood still: its camera is elsewhere.
  const Camera first = camera_of(*batch, 0, "hand_camera", 128, 128);
  CHECK((first.pose - camera_of(*batch, 1, "hand_camera", 128, 128).pose).norm() > 0.05F);
  CHECK(first.intrinsic(0, 0) == Approx(64));
  CHECK(first.intrinsic(1, 2) == 64);
  CHECK_THROWS_WITH(Queries(*batch).camera_params("top", 128, 128, {}), Contains("hand_camera"));
  CHECK_THROWS_WITH(Queries(*batch).camera_params("hand_camera", 0, 128, {}),
                    Contains("1 to 4096"));
}

// The drawn values of an environment by name, the first of each.
std::map<std::string, double> drawn(const Batch& batch, int index) {
  std::vector<float> values = floats(batch, Queries(batch).sampled_dim());
  Queries(batch).sampled_values(values);
  std::map<std::string, double> named;
  std::size_t at = static_cast<std::size_t>(index * Queries(batch).sampled_dim());
  for (const Field& field : batch.info().sampled_values) {
    named[field.name] = static_cast<double>(values[at]);
    at += static_cast<std::size_t>(field.width);
  }
  return named;
}

std::map<std::string, double> drawn_with(const std::string& id, std::vector<Pin> pins) {
  const auto batch = test::make_running(id, {.num_envs = 2, .pins = std::move(pins)});
  test::step(*batch, Policy::kZero);
  return drawn(*batch, 1);
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
  const BatchOptions options{.pins = {{"shapes", {0, 0, 0, 0, 0}},
                                      {"radii", {0.08, 0.09, 0.1, 0.11, 0.12}},
                                      {"center_x", {-0.1}},
                                      {"center_y", {0.05}},
                                      {"rotations", {0, 1, 2, 3, 4}},
                                      {"sequence_length", {3}}}};
  const auto batch = test::make_running("TraceShapeSeqEasy-VLA-v0", options);
  const std::vector<Field>& fields = batch->info().sampled_values;
  REQUIRE(fields.back().name == "waypoints");
  REQUIRE(fields.back().width == 5 * 64 * 2);
  std::vector<float> values = floats(*batch, Queries(*batch).sampled_dim());
  Queries(*batch).sampled_values(values);
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
    const auto batch = test::make_env(id, {.num_envs = 3, .seed = 5});
    CHECK_THROWS_WITH(drawn(*batch, 0), Contains("before the first reset"));
    batch->reset();
    for (int i = 0; i < 3; ++i) {
      std::map<std::string, double> values = drawn(*batch, i);
      if (values.contains("cue_steps_per_env")) {
        CHECK(values["cue_steps_per_env"] == Queries(*batch).cue_end(i));
      }
      for (const Field& field : batch->info().sampled_values) {
        if (field.dtype == DType::kInt32)
          CHECK(std::trunc(values[field.name]) == values[field.name]);
      }
      if (!batch->info().frozen_cue) continue;
      const int frozen = *test::row<std::int32_t>(test::memory_of(*batch).find("freeze_steps"), i);
      CHECK(values["cue_steps_per_env"] + values["empty_steps_per_env"] == frozen);
    }
  }
}

}  // namespace
}  // namespace engram
