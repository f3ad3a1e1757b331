// Tasks with the plain Panda, which carries no camera on its hand.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "core/batch/queries.h"
#include "core/batch/snapshot.h"
#include "protocol/make/make.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

const ConstantTable kPlain = {{"robot_uids", "panda"}};
constexpr const char* kId = "RememberColor3-VLA-v0";

std::unique_ptr<Batch> make_reset(const ConstantTable& constants, int num_envs = 1) {
  return test::make_running(kId, MakeOptions{{.num_envs = num_envs}, constants});
}

TEST_CASE("The plain Panda's hand is lighter by the camera", "[variants][robot]") {
  const auto with = make_reset({});
  const auto without = make_reset(kPlain);
  const auto& heavy = with->physics_model().robot_model().links;
  const auto& light = without->physics_model().robot_model().links;
  constexpr int kLast = kArmJoints - 1;
  for (int i = 0; i < kLast; ++i) CHECK(heavy[i].mass == light[i].mass);
  CHECK(heavy[kLast].mass - light[kLast].mass == Approx(0.564));
  const auto shapes = [](const Batch& batch) {
    return batch.physics_model().reach_shapes().size();
  };
  CHECK(shapes(*without) + 1 == shapes(*with));
}

TEST_CASE("The plain Panda moves a little differently", "[variants][robot]") {
  const auto with = make_reset({});
  const auto without = make_reset(kPlain);
  CHECK(test::batch_bytes(*make_reset({{"robot_uids", "panda_wristcam"}})) ==
        test::batch_bytes(*with));
  std::vector<float> action = test::zeros(*with);
  action[3] = 1;
  for (int i = 0; i < 10; ++i) {
    with->step(action);
    without->step(action);
  }
  double most = 0;
  for (int i = 0; i < kArmJoints; ++i) {
    most = std::max(most, std::abs(with->state().qpos.row(0)[i] - without->state().qpos.row(0)[i]));
  }
  CHECK(most > 1e-5);
  CHECK(most < 0.05);
}

TEST_CASE("The oracle solves tasks with the plain Panda", "[variants][robot]") {
  const auto batch = make_reset(kPlain, 16);
  for (int i = 0; i < batch->info().horizon; ++i) test::step(*batch, Policy::kOracle);
  int solved = 0;
  for (int i = 0; i < 16; ++i) solved += *test::row<std::uint8_t>(batch->output("success_once"), i);
  CHECK(solved >= 15);
}

TEST_CASE("Other robots are refused, and snapshots belong to theirs", "[variants][robot]") {
  CHECK_THROWS_WITH(make_task(kId, {{"robot_uids", "fetch"}}),
                    "constant 'robot_uids': 'fetch' given, one of panda_wristcam, panda allowed");
  const auto with = make_reset({});
  const auto without = make_reset(kPlain);
  CHECK_THROWS_WITH(Snapshotter(*with).restore(Snapshotter(*without).save()),
                    Catch::Contains("robot_uids"));
}

TEST_CASE("hand_camera is a point of view without a body", "[variants][robot]") {
  const MakeOptions options{{.obs_mode = ObsMode::kRgb}, kPlain};
  const auto batch = make(kId, options);
  batch->reset();
  CHECK(batch->images().rgb.size() == std::size_t{128} * 128 * 6);
}

}  // namespace
}  // namespace engram
