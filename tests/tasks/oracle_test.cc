// What an oracle, a guess and no action at all achieve, and that sleep does not matter for it.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/batch/queries.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

using test::make_env, test::make_running, test::row;

constexpr std::uint64_t kCanonicalSeed = 4242424242;

std::vector<std::uint8_t> outcomes(const std::string& id, Policy policy, bool sleep = true,
                                   int episodes = 50, Rules rules = Rules::kReference) {
  const auto batch = make_running(id, {.num_envs = episodes,
                                       .seed = kCanonicalSeed,
                                       .threads = 2,
                                       .auto_reset = AutoReset::kOff,
                                       .sleep = sleep,
                                       .rules = rules});
  const State& state = batch->state();
  const std::uint8_t* succeeded = row<std::uint8_t>(batch->output("success_once"), 0);
  const auto all_over = [&] {
    for (int i = 0; i < episodes; ++i) {
      if (succeeded[i] == 0 && state.finished[i] == 0) return false;
    }
    return true;
  };
  while (!all_over()) test::step(*batch, policy);
  CHECK(Queries(*batch).unstable_count() == 0);
  std::vector<std::uint8_t> result;
  for (int i = 0; i < episodes; ++i) {
    result.push_back(*row<std::uint8_t>(batch->output("success_once"), i));
  }
  return result;
}

double rate(const std::vector<std::uint8_t>& successes) {
  return static_cast<double>(std::count(successes.begin(), successes.end(), 1)) /
         static_cast<double>(successes.size());
}

// Tasks with long episodes, whose tests run rarely.
bool is_lengthy(const RegistryEntry& entry) {
  return entry.id.find("Long") != std::string_view::npos || entry.horizon > 300;
}

std::vector<std::string> ids(bool lengthy) {
  std::vector<std::string> result;
  for (const std::string& id : test::implemented_ids()) {
    if (is_lengthy(require_entry(id)) == lengthy) result.push_back(id);
  }
  return result;
}

// Episodes for a test, fewer where they are very long.
int affordable(const std::string& id, int episodes) {
  constexpr int kSteps = 50'000;
  return std::clamp(kSteps / require_entry(id).horizon, 10, episodes);
}

void check_policies(const std::string& id) {
  INFO(id);
  CHECK(rate(outcomes(id, Policy::kOracle, true, affordable(id, 50))) >=
        require_entry(id).oracle_floor);
  const double chance = make_task(id)->info().chance();
  const double guessed = rate(outcomes(id, Policy::kBlind, true, affordable(id, 100)));
  CHECK(std::abs(guessed - chance) <= 0.15);
  // In 90 steps one untouched ball in ten drifts into the target.
  const double idle = id == "InterceptSlow-v0" ? 0.25 : 0;
  CHECK(rate(outcomes(id, Policy::kZero, true, affordable(id, 20))) <= idle);
}

TEST_CASE("Oracles solve the short tasks, guesses sometimes and idlers never", "[oracle]") {
  for (const std::string& id : ids(false)) check_policies(id);
}

TEST_CASE("Oracles solve the long tasks, guesses sometimes and idlers never", "[oracle][long]") {
  for (const std::string& id : ids(true)) check_policies(id);
}

// Where both rules are the same, there is nothing to see.
void check_original_rules(const std::string& id) {
  const std::unique_ptr<Task> task = make_task(id);
  const std::vector<TaskOptionSpec>& options = task->info().options;
  if (std::none_of(options.begin(), options.end(),
                   [](const TaskOptionSpec& option) { return option.original.has_value(); })) {
    return;
  }
  INFO(id);
  CHECK(rate(outcomes(id, Policy::kOracle, true, affordable(id, 50), Rules::kOriginal)) >=
        require_entry(id).oracle_floor);
}

TEST_CASE("Oracles solve the short tasks under the original's rules, too", "[oracle][rules]") {
  for (const std::string& id : ids(false)) check_original_rules(id);
}

TEST_CASE("Oracles solve the long tasks under the original's rules, too", "[oracle][rules][long]") {
  for (const std::string& id : ids(true)) check_original_rules(id);
}

TEST_CASE("Oracles succeed in the same episodes with and without sleep", "[oracle][sleep]") {
  for (const std::string& id : ids(false)) {
    INFO(id);
    // Episodes without sleep take their time.
    constexpr int kEpisodes = 10;
    CHECK(outcomes(id, Policy::kOracle, true, kEpisodes) ==
          outcomes(id, Policy::kOracle, false, kEpisodes));
  }
}

// Random motion that keeps the hand above the props. `closing`: the fingers meet their limit now
// and then.
std::vector<float> raised(Batch& batch, bool closing) {
  std::vector<float> actions = test::act(batch, Policy::kRandom);
  for (int i = 0; i < batch.num_envs(); ++i) {
    const double height = batch.state().tcp_pos.row(i)[2];
    float* action = actions.data() + 7 * i;
    action[2] = static_cast<float>(std::clamp(5 * (0.35 - height), -1.0, 1.0)) + 0.2F * action[2];
    for (int k = 3; k < 6; ++k) action[k] *= 0.3F;
    if (!closing) action[6] = std::abs(action[6]);
  }
  return actions;
}

struct Differences {
  double robot = 0;      // largest difference of a joint position or velocity
  int robot_bits = 0;    // environments and steps in which a bit differed
  double props = 0;      // m
  bool touched = false;  // a prop woke
};

Differences compare_sleep(const std::string& id, bool closing) {
  MakeOptions options;
  // A cue of one cube after the other is cut short, so that all of them appear in time.
  const bool rl = require_entry(id).split == Split::kRl;
  if (rl && (id.starts_with("Seq") || id.starts_with("Chain"))) {
    options.constants = {{"CUE_STEP_DURATION", 1}};
  }
  options.num_envs = 16;
  options.control_mode = ControlMode::kPdEeDeltaPose;  // that of these actions
  options.auto_reset = AutoReset::kOff;
  const auto asleep = make_env(id, options);
  options.sleep = false;
  const auto awake = make_env(id, options);
  asleep->reset();
  awake->reset();
  Differences found;
  const State& a = asleep->state();
  const State& b = awake->state();
  // Props of RL tasks appear in the 40th step at the latest; until then the robot rests.
  const int waits = require_entry(id).split == Split::kRl ? 40 : 0;
  for (int step = 0; step < waits + 25; ++step) {
    const std::vector<float> actions =
        step < waits ? test::zeros(*asleep) : raised(*asleep, closing);
    asleep->step(actions);
    awake->step(actions);
    for (int i = 0; i < options.num_envs; ++i) {
      bool same = true;
      for (int joint = 0; joint < kRobotJoints; ++joint) {
        const double position = std::abs(a.qpos.row(i)[joint] - b.qpos.row(i)[joint]);
        const double velocity = std::abs(a.qvel.row(i)[joint] - b.qvel.row(i)[joint]);
        found.robot = std::max({found.robot, position, velocity});
        same = same && position == 0 && velocity == 0;
      }
      found.robot_bits += same ? 0 : 1;
      for (int prop = 0; prop < a.num_props; ++prop) {
        found.touched |= a.status_of(i, prop) == PropStatus::kAwake;
        const Eigen::Map<const Eigen::Vector3d> left(a.prop_pos_of(i, prop));
        const Eigen::Map<const Eigen::Vector3d> right(b.prop_pos_of(i, prop));
        found.props = std::max(found.props, (left - right).norm());
      }
    }
  }
  return found;
}

TEST_CASE("Untouched props leave the robot's bits alone with and without sleep", "[sleep]") {
  for (const std::string& id : ids(false)) {
    const Differences found = compare_sleep(id, false);
    INFO(id);
    CHECK(found.robot_bits == 0);
    CHECK(found.props < 5e-4);
    CHECK((found.props > 0) == require_entry(id).definition->expectations.settles);
    CHECK(found.touched == require_entry(id).definition->expectations.moves_untouched);
  }
}

// At a joint limit the solver iterates on robot and awake cubes together and stops when both are
// good enough: the last bits may differ then.
TEST_CASE("At a joint limit sleep makes a difference in the last bits only", "[sleep]") {
  for (const std::string& id : ids(false)) {
    const Differences found = compare_sleep(id, true);
    INFO(id << ": bits differ in " << found.robot_bits << " steps, by " << found.robot);
    CHECK(found.robot < 1e-9);
    CHECK(found.touched == require_entry(id).definition->expectations.moves_untouched);
  }
}

}  // namespace
}  // namespace engram
