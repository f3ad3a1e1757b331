#include "core/batch/scripted_policy.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "core/base/error.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

using test::act, test::make_env, test::make_running, test::zeros;

constexpr const char* kId = "RememberColor5-VLA-v0";

TEST_CASE("Scripts need a mode that they have actions for", "[scripted_policy]") {
  const auto batch = make_running(kId, {.control_mode = ControlMode::kPdEePose});
  std::vector<float> actions = zeros(*batch);
  CHECK_THROWS_WITH(ScriptedPolicy(*batch, Policy::kOracle).act(actions),
                    Catch::Contains("oracle with control mode pd_ee_pose, pd_ee_delta_pose, "
                                    "pd_joint_pos or pd_joint_delta_pos needed"));
  CHECK_THROWS_AS(ScriptedPolicy(*batch, Policy::kBlind).act(actions), Error);
  CHECK_THROWS_AS(ScriptedPolicy(*batch, Policy::kSweep).act(actions), Error);
  CHECK_NOTHROW(ScriptedPolicy(*batch, Policy::kRandom).act(actions));
}

TEST_CASE("Actions of the wrong number are refused, and those before the first reset",
          "[scripted_policy]") {
  const auto batch = make_env(kId);
  std::vector<float> actions = zeros(*batch);
  CHECK_THROWS_WITH(ScriptedPolicy(*batch, Policy::kZero).act(actions),
                    Catch::Contains("act before the first reset"));
  batch->reset();
  actions.push_back(0);
  CHECK_THROWS_WITH(ScriptedPolicy(*batch, Policy::kZero).act(actions),
                    Catch::Contains("8 values given, 7 needed"));
}

TEST_CASE("Random actions fill the action space and follow from seed and step",
          "[scripted_policy]") {
  BatchOptions options{.num_envs = 200, .seed = 5};
  const auto batch = make_running(kId, options);
  const std::vector<float> first = act(*batch, Policy::kRandom);
  CHECK(act(*batch, Policy::kRandom) == first);
  CHECK(*std::ranges::max_element(first) > 0.9F);
  CHECK(*std::ranges::min_element(first) < -0.9F);
  for (const float value : first) REQUIRE(std::abs(value) <= 1);
  batch->step(first);
  CHECK(act(*batch, Policy::kRandom) != first);
  // An equal environment in another batch, at another place.
  options.num_envs = 2;
  options.seed = 7;
  const auto other = make_running(kId, options);
  const std::vector<float> again = act(*other, Policy::kRandom);
  CHECK(std::equal(again.begin(), again.end(), first.begin() + 2 * 7));
}

TEST_CASE("Scripts rest where the episode has ended and nothing resets it", "[scripted_policy]") {
  const auto batch = make_running(kId, {.num_envs = 3, .auto_reset = AutoReset::kOff});
  batch->state().finished[1] = 1;
  const std::vector<float> actions = act(*batch, Policy::kOracle);
  const auto is_zero = [&](int index) {
    const auto row = actions.begin() + 7 * index;
    return std::all_of(row, row + 7, [](float value) { return value == 0; });
  };
  CHECK_FALSE(is_zero(0));
  CHECK(is_zero(1));
  CHECK_FALSE(is_zero(2));
}

TEST_CASE("Scripts turn rotations round for rotation sign 1", "[scripted_policy]") {
  const auto actions_with = [](int sign) {
    const auto batch = make_running("RotateLenientPos-VLA-v0", {.rotation_sign = sign});
    return act(*batch, Policy::kOracle);
  };
  const std::vector<float> canonical = actions_with(-1);
  const std::vector<float> turned = actions_with(1);
  for (std::size_t i = 0; i < 7; ++i) {
    const bool rotation = i >= 3 && i < 6;
    CHECK(turned[i] == (rotation ? -canonical[i] : canonical[i]));
  }
}

// Ten episodes of the oracle.
struct Course {
  int successes = 0;
  std::vector<float> proprio;
};

Course course_of(std::string_view id, ControlMode mode, int steps) {
  const auto batch =
      make_running(id, {.num_envs = 10, .control_mode = mode, .auto_reset = AutoReset::kOff});
  Course course;
  for (int k = 0; k < steps; ++k) {
    batch->step(act(*batch, Policy::kOracle));
    const auto now = batch->outputs().proprio;
    course.proprio.insert(course.proprio.end(), now.begin(), now.end());
  }
  for (int i = 0; i < batch->num_envs(); ++i) {
    course.successes += *test::row<std::uint8_t>(batch->output("success_once"), i);
  }
  return course;
}

TEST_CASE("In pd_joint_pos the scripts move as in pd_ee_delta_pose", "[scripted_policy]") {
  for (const char* id : {"RememberColor5-VLA-v0", "TakeItBack-VLA-v0", "InterceptMedium-VLA-v0"}) {
    INFO(id);
    const Course usual = course_of(id, ControlMode::kPdEeDeltaPose, 25);
    const Course joints = course_of(id, ControlMode::kPdJointPos, 25);
    CHECK(joints.successes == usual.successes);
    REQUIRE(joints.proprio.size() == usual.proprio.size());
    double farthest = 0;
    for (std::size_t i = 0; i < usual.proprio.size(); i += 7) {
      for (std::size_t k = 0; k < 3; ++k) {
        farthest = std::max(farthest, std::abs(static_cast<double>(usual.proprio[i + k]) -
                                               static_cast<double>(joints.proprio[i + k])));
      }
    }
    CHECK(farthest < 1e-3);  // m: the servos' thresholds enlarge the rounding of targets
  }
}

TEST_CASE("In pd_joint_delta_pos the oracle succeeds where its joints are fast enough",
          "[scripted_policy]") {
  for (const char* id : {"ShellGameTouch-VLA-v0", "TakeItBack-VLA-v0", "RotateLenientPos-VLA-v0"}) {
    INFO(id);
    CHECK(course_of(id, ControlMode::kPdJointDeltaPos, 120).successes >= 9);
  }
}

TEST_CASE("A policy seed changes random actions and guesses, and nothing of the episode",
          "[scripted_policy]") {
  const auto actions_of = [](std::uint64_t policy_seed, Policy policy, int steps) {
    const auto batch = make_running(kId, {.num_envs = 20, .policy_seed = policy_seed});
    for (int k = 0; k < steps; ++k) batch->step_no_action();
    return std::pair(act(*batch, policy), test::batch_bytes(*batch));
  };
  const auto [usual, episodes] = actions_of(0, Policy::kRandom, 0);
  CHECK(usual == act(
                     *[] {
                       auto batch = make_running(kId, {.num_envs = 20});
                       return batch;
                     }(),
                     Policy::kRandom));
  const auto [other, same_episodes] = actions_of(1, Policy::kRandom, 0);
  CHECK(other != usual);
  CHECK(same_episodes == episodes);
  CHECK(actions_of(1, Policy::kRandom, 0).first == other);
  CHECK(actions_of(2, Policy::kRandom, 0).first != other);
  // After the cue, when the choice is made.
  CHECK(actions_of(1, Policy::kBlind, 20).first != actions_of(0, Policy::kBlind, 20).first);
  CHECK(actions_of(1, Policy::kOracle, 20).first == actions_of(0, Policy::kOracle, 20).first);
}

}  // namespace
}  // namespace engram
