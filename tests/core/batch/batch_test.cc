#include "core/batch/batch.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/batch/queries.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

using test::batch_bytes, test::env_bytes, test::make_env, test::make_running, test::row, test::step,
    test::zeros;

constexpr const char* kId = "RememberColor3-VLA-v0";
constexpr double kPi = std::numbers::pi;

ResetRequest with_seeds(std::span<const std::uint64_t> seeds) {
  ResetRequest request;
  request.seeds = seeds;
  return request;
}

TEST_CASE("Proprio is the TCP pose and the gripper opening", "[batch]") {
  const auto batch = make_running(kId, {.robot_init_qpos_noise = 0});
  const auto proprio = batch->outputs().proprio;
  REQUIRE(proprio.size() == 7);
  CHECK(proprio[0] == Approx(-0.070696).margin(1e-6));
  CHECK(proprio[1] == Approx(0).margin(1e-6));
  CHECK(proprio[2] == Approx(0.318047).margin(1e-6));
  CHECK(std::abs(proprio[3]) == Approx(kPi));
  CHECK(proprio[4] == Approx(0).margin(1e-6));
  CHECK(proprio[5] == Approx(0).margin(1e-6));
  CHECK(proprio[6] == Approx(0.08));
}

TEST_CASE("joint_proprio shows the arm's angles and the gripper's opening", "[batch]") {
  const auto batch = make_running("RememberColor3-VLA-v0", {.joint_proprio = true});
  CHECK(batch->outputs().proprio.size() == 8);
  for (int step = 0; step < 3; ++step) {
    const auto proprio = batch->outputs().proprio;
    REQUIRE(proprio.size() == 8);
    const double* qpos = batch->state().qpos.row(0);
    for (std::size_t i = 0; i < 7; ++i) CHECK(proprio[i] == static_cast<float>(qpos[i]));
    CHECK(proprio[7] == static_cast<float>(qpos[7] + qpos[8]));
    batch->step(std::vector<float>{0.5F, 0.5F, -0.5F, 0, 0, 0, -1});
  }
}

TEST_CASE("A yaw action turns the hand the way of its rotation sign", "[batch]") {
  for (const int sign : {-1, 1}) {
    const auto batch =
        make_running(kId, {.rotation_sign = sign, .freeze_cue = false, .robot_init_qpos_noise = 0});
    batch->step(std::vector<float>{0, 0, 0, 0, 0, 1, 0});
    CHECK(sign * static_cast<double>(batch->outputs().proprio[5]) == Approx(0.04).margin(0.006));
  }
}

TEST_CASE("State fields name the parts of the state observation", "[batch]") {
  const auto batch = make_running(kId);
  int offset = 0;
  std::vector<std::string> names;
  for (const Field& field : Queries(*batch).state_fields()) {
    if (field.name == "tcp_pose") CHECK(offset == 18);
    if (field.name == "oracle_info") CHECK(offset == 25);
    if (field.name == "goal_0_pose") CHECK(offset == 26);
    names.push_back(field.name);
    offset += field.width;
  }
  CHECK(names == std::vector<std::string>{"qpos", "qvel", "tcp_pose", "oracle_info", "goal_0_pose",
                                          "goal_1_pose", "goal_2_pose"});
  CHECK(offset == batch->state_dim());
  CHECK(batch->outputs().observation.size() == static_cast<std::size_t>(offset));
  for (int i = 0; i < 9; ++i) {
    CHECK(batch->outputs().observation[static_cast<std::size_t>(i)] ==
          static_cast<float>(batch->state().qpos.row(0)[i]));
  }
  CHECK(batch->outputs().observation[18] == static_cast<float>(batch->state().tcp_pos.row(0)[0]));
  CHECK(batch->outputs().observation[21] == static_cast<float>(batch->state().tcp_quat.row(0)[0]));
}

TEST_CASE("Target modes add the controller state after qvel", "[batch]") {
  BatchOptions options{.control_mode = ControlMode::kPdJointTargetDeltaPos};
  const auto batch = make_running(kId, options);
  CHECK(batch->state_dim() == 35 + 7);
  CHECK(Queries(*batch).state_fields()[2].name == "target_qpos");
  CHECK(batch->outputs().observation[18] == batch->outputs().observation[0]);
  options.control_mode = ControlMode::kPdEeTargetDeltaPose;
  const auto pose = make_running(kId, options);
  CHECK(Queries(*pose).state_fields()[2].name == "target_pose");
  // In the root frame; tcp_pose follows, in the world's.
  CHECK(pose->outputs().observation[18] == Approx(pose->outputs().observation[25] + 0.615F));
  CHECK(pose->outputs().observation[19] == Approx(pose->outputs().observation[26]).margin(1e-6));
}

TEST_CASE("Observation modes choose what is written", "[batch]") {
  BatchOptions options;
  const auto state = make_env(kId, options);
  options.obs_mode = ObsMode::kStateDict;
  const auto dict = make_env(kId, options);
  options.obs_mode = ObsMode::kNone;
  const auto none = make_env(kId, options);
  for (Batch* batch : {state.get(), dict.get(), none.get()}) {
    batch->reset();
    step(*batch, Policy::kRandom);
  }
  CHECK(none->outputs().observation.empty());
  CHECK(state->outputs().observation.size() == 35);
  CHECK(std::equal(state->outputs().observation.begin(), state->outputs().observation.end(),
                   dict->outputs().observation.begin()));
  CHECK(std::equal(state->outputs().proprio.begin(), state->outputs().proprio.end(),
                   none->outputs().proprio.begin()));
}

TEST_CASE("Reset noise has the given spread and leaves the fingers alone", "[batch]") {
  const BatchOptions options{.num_envs = 2000};
  const auto batch = make_running(kId, options);
  const double start[] = {0, 0, 0, -2 * kPi / 3, 0, 2 * kPi / 3, kPi / 4};
  for (int joint = 0; joint < kArmJoints; ++joint) {
    double sum = 0;
    double squares = 0;
    for (int i = 0; i < options.num_envs; ++i) {
      const double noise = batch->state().qpos.row(i)[joint] - start[joint];
      sum += noise;
      squares += noise * noise;
    }
    CHECK(std::abs(sum / options.num_envs) < 0.002);
    CHECK(std::sqrt(squares / options.num_envs) == Approx(0.02).epsilon(0.1));
  }
  for (int i = 0; i < options.num_envs; ++i) {
    REQUIRE(batch->state().qpos.row(i)[7] == 0.04);
    REQUIRE(batch->state().qpos.row(i)[8] == 0.04);
  }
}

TEST_CASE("Environment i has the seed of the batch plus i", "[batch]") {
  const auto batch = make_running(kId, {.num_envs = 3, .seed = 4242424242});
  for (int i = 0; i < 3; ++i) {
    CHECK(batch->state().seed[i] == 4242424242u + static_cast<unsigned>(i));
  }
}

TEST_CASE("A reset without seeds goes on to the next episode of each seed", "[batch]") {
  const auto batch = make_running(kId, {.num_envs = 2});
  const auto first = batch_bytes(*batch);
  batch->reset();
  const auto second = batch_bytes(*batch);
  CHECK(first != second);
  CHECK(batch->state().episode[1] == 1);
  const std::uint64_t seeds[] = {0, 1};
  batch->reset(with_seeds(seeds));
  CHECK(batch_bytes(*batch) == first);
  batch->reset();
  CHECK(batch_bytes(*batch) == second);
}

TEST_CASE("Every environment can be given a seed of its own", "[batch]") {
  BatchOptions options{.num_envs = 3};
  const auto batch = make_env(kId, options);
  const std::uint64_t seeds[] = {77, 5, 77};
  batch->reset(with_seeds(seeds));
  options.num_envs = 1;
  options.seed = 77;
  const auto single = make_running(kId, options);
  CHECK(env_bytes(*batch, 0) == env_bytes(*single, 0));
  CHECK(env_bytes(*batch, 2) == env_bytes(*single, 0));
  CHECK(env_bytes(*batch, 1) != env_bytes(*single, 0));
}

TEST_CASE("A reset by mask leaves all other environments byte for byte", "[batch]") {
  const auto batch = make_running(kId, {.num_envs = 6});
  for (int i = 0; i < 12; ++i) step(*batch, Policy::kOracle);
  std::vector<test::Bytes> before;
  before.reserve(6);
  for (int i = 0; i < 6; ++i) before.push_back(env_bytes(*batch, i));
  const std::uint8_t mask[] = {0, 1, 0, 0, 1, 0};
  const std::uint64_t seeds[] = {9, 9, 9, 9, 4, 9};
  batch->reset({.mask = mask, .seeds = seeds, .pins = nullptr});
  for (int i = 0; i < 6; ++i) {
    INFO("environment " << i);
    CHECK((env_bytes(*batch, i) == before[static_cast<std::size_t>(i)]) ==
          (mask[static_cast<std::size_t>(i)] == 0));
  }
  CHECK(batch->state().seed[1] == 9);
  CHECK(batch->state().seed[4] == 4);
  CHECK(batch->state().elapsed[1] == 0);
  CHECK(batch->state().elapsed[0] == 12);
}

TEST_CASE("The first reset must reset all environments", "[batch]") {
  const auto batch = make_env(kId, {.num_envs = 2});
  const std::uint8_t mask[] = {1, 0};
  CHECK_THROWS_WITH(batch->reset({.mask = mask, .seeds = {}, .pins = nullptr}),
                    Catch::Contains("environment 1 masked out"));
  CHECK_THROWS_AS(batch->step(zeros(*batch)), Error);
}

TEST_CASE("The zero policy writes zeros and the random one stays within bounds", "[batch]") {
  for (int mode = 0; mode < kControlModes; ++mode) {
    const auto batch =
        make_running(kId, {.num_envs = 4, .control_mode = static_cast<ControlMode>(mode)});
    CHECK(test::act(*batch, Policy::kZero) == zeros(*batch));
    std::set<float> distinct;
    for (int i = 0; i < 10; ++i) {
      const std::vector<float> actions = test::act(*batch, Policy::kRandom);
      for (std::size_t k = 0; k < actions.size(); ++k) {
        const std::size_t c = k % static_cast<std::size_t>(batch->action_dim());
        REQUIRE(actions[k] >= batch->action_space().low[c]);
        REQUIRE(actions[k] <= batch->action_space().high[c]);
        distinct.insert(actions[k]);
      }
      batch->step(actions);
    }
    CHECK(distinct.size() > 100);
    CHECK(Queries(*batch).unstable_count() == 0);
  }
}

TEST_CASE("Random actions depend on neither threads nor batch size", "[batch]") {
  BatchOptions options{.num_envs = 5, .threads = 1};
  const auto one = make_env(kId, options);
  options.threads = 3;
  const auto three = make_env(kId, options);
  one->reset();
  three->reset();
  const std::vector<float> actions = test::act(*one, Policy::kRandom);
  CHECK(actions == test::act(*three, Policy::kRandom));
  CHECK(actions == test::act(*one, Policy::kRandom));  // asked twice, the same actions
  options.num_envs = 1;
  options.seed = 3;
  const auto single = make_running(kId, options);
  const std::vector<float> alone = test::act(*single, Policy::kRandom);
  CHECK(std::equal(alone.begin(), alone.end(), actions.begin() + 3 * 7));
}

TEST_CASE("Oracles speak the rotation sign of the environment", "[batch]") {
  BatchOptions options{.seed = 3};
  const auto upstream = make_env(kId, options);
  options.rotation_sign = 1;
  const auto positive = make_env(kId, options);
  double turned = 0;
  for (Batch* batch : {upstream.get(), positive.get()}) batch->reset();
  for (int i = 0; i < 20; ++i) {
    const std::vector<float> a = test::act(*upstream, Policy::kOracle);
    const std::vector<float> b = test::act(*positive, Policy::kOracle);
    for (std::size_t k = 0; k < 7; ++k) {
      REQUIRE(a[k] == (k >= 3 && k < 6 ? -b[k] : b[k]));
      if (k >= 3 && k < 6) turned += static_cast<double>(std::abs(a[k]));
    }
    upstream->step(a);
    positive->step(b);
    REQUIRE(std::equal(upstream->outputs().proprio.begin(), upstream->outputs().proprio.end(),
                       positive->outputs().proprio.begin()));
  }
  CHECK(turned > 0);
}

TEST_CASE("Outputs are found by name", "[batch]") {
  const auto batch = make_running(kId);
  for (const char* name :
       {"observation", "proprio", "reward", "terminated", "truncated", "unstable", "elapsed_steps",
        "success", "success_once", "episode_return", "oracle_info", "obj_to_goal_pos",
        "is_obj_placed", "is_robot_static", "reward_dict"}) {
    CHECK(batch->output(name).field->name == name);
    CHECK(batch->final_output(name).field->name == name);
  }
  CHECK_THROWS_WITH(batch->output("rewards"),
                    Catch::Contains("no output named 'rewards'") && Catch::Contains("proprio"));
  CHECK(Queries(*batch).instruction(0) == batch->info().instruction);
  CHECK_THROWS_AS(Queries(*batch).instruction(1), Error);
  CHECK_THROWS_AS(Queries(*batch).instruction(-1), Error);
}

TEST_CASE("An additional environment costs a few kilobytes", "[batch]") {
  CHECK(Queries(*make_env("RememberColor9-VLA-v0")).bytes_per_env() < 12'000);
}

TEST_CASE("A step without a new command keeps the drives' targets", "[batch]") {
  for (int i = 0; i < kControlModes; ++i) {
    const BatchOptions options{.num_envs = 3,
                               .threads = 1,
                               .control_mode = static_cast<ControlMode>(i),
                               .auto_reset = AutoReset::kOff,
                               .freeze_cue = false};
    const auto batch = make_env(kId, options);
    CHECK_THROWS_WITH(batch->step_no_action(), Catch::Contains("reset first"));
    batch->reset();
    INFO(name_of(*options.control_mode));
    // Before the first command, the robot stays in its start pose.
    const std::vector<double> start(batch->state().qpos.row(1), batch->state().qpos.row(1) + 9);
    for (int k = 0; k < 3; ++k) batch->step_no_action();
    for (std::size_t k = 0; k < start.size(); ++k) {
      CHECK(batch->state().qpos.row(1)[k] == Approx(start[k]).margin(1e-4));
    }
    CHECK(batch->state().elapsed[1] == 3);

    std::vector<float> actions;
    test::act(*batch, Policy::kRandom).swap(actions);
    batch->step(actions);
    const std::vector<double> target(batch->state().target_qpos.row(1),
                                     batch->state().target_qpos.row(1) + 9);
    std::vector<double> far(9);
    for (std::size_t k = 0; k < far.size(); ++k) {
      far[k] = std::abs(batch->state().qpos.row(1)[k] - target[k]);
    }
    for (int k = 0; k < 8; ++k) batch->step_no_action();
    for (std::size_t k = 0; k < target.size(); ++k) {
      CHECK(batch->state().target_qpos.row(1)[k] == target[k]);
      const bool moves_on = options.control_mode == ControlMode::kPdJointVel && k < 7;
      const bool pushed = options.control_mode == ControlMode::kPdJointPosVel ||
                          options.control_mode == ControlMode::kPdJointDeltaPosVel;
      if (moves_on || pushed) continue;
      // Farther on the way: a tenth of the way is left, or the joint was there already.
      CHECK(std::abs(batch->state().qpos.row(1)[k] - target[k]) <= 0.5 * far[k] + 2e-3);
    }
    CHECK(batch->state().elapsed[1] == 12);
  }
}

TEST_CASE("A step without a command is that of the same absolute targets", "[batch]") {
  const BatchOptions options{
      .num_envs = 2, .control_mode = ControlMode::kPdJointPos, .freeze_cue = false};
  const auto one = make_env(kId, options);
  const auto other = make_env(kId, options);
  one->reset();
  other->reset();
  const std::vector<float> actions = test::act(*one, Policy::kRandom);
  one->step(actions);
  other->step(actions);
  for (int k = 0; k < 5; ++k) {
    one->step(actions);
    other->step_no_action();
    CHECK(batch_bytes(*one) == batch_bytes(*other));
  }
  CHECK(one->state().elapsed[0] == 6);
}

TEST_CASE("Environments without a new command step beside others", "[batch]") {
  const BatchOptions options{.num_envs = 6, .freeze_cue = false};
  const auto moved = make_env(kId, options);
  const auto left = make_env(kId, options);
  const auto mixed = make_env(kId, options);
  const std::vector<std::uint8_t> commanded = {1, 0, 0, 1, 1, 0};
  for (const auto* batch : {&moved, &left, &mixed}) (*batch)->reset();
  for (int k = 0; k < 4; ++k) {
    const std::vector<float> actions = test::act(*mixed, Policy::kRandom);
    moved->step(actions);
    left->step_no_action();
    mixed->step(actions, commanded);
  }
  for (int i = 0; i < 6; ++i) {
    INFO(i);
    const auto& same = commanded[static_cast<std::size_t>(i)] != 0 ? moved : left;
    CHECK(env_bytes(*mixed, i) == env_bytes(*same, i));
  }
  CHECK(env_bytes(*moved, 1) != env_bytes(*left, 1));
  CHECK_THROWS_WITH(mixed->step(zeros(*mixed), std::vector<std::uint8_t>(5)),
                    Catch::Contains("commanded: 5 values given, 6 needed"));
  CHECK(mixed->state().elapsed[0] == 4);
}

}  // namespace
}  // namespace engram
