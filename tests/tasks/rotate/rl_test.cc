// RotateLenient and RotateStrict as RL tasks.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "tasks/rotate/peg_angle.h"
#include "tasks/rotate/task.h"
#include "tests/tasks/rl_episodes.h"

namespace engram {
namespace {

using test::make_env, test::make_running, test::rl_ids, test::row;

constexpr double kPi = std::numbers::pi;

bool is_strict(const std::string& id) { return id.find("Strict") != std::string::npos; }

std::vector<std::string> all_ids() {
  std::vector<std::string> ids = rl_ids("RotateLenient");
  for (const std::string& id : rl_ids("RotateStrict")) ids.push_back(id);
  return ids;
}

TEST_CASE("The RL tasks of Rotate are those of the published list", "[rotate][rl]") {
  CHECK(all_ids() == std::vector<std::string>{"RotateLenientPos-v0", "RotateLenientPosNeg-v0",
                                              "RotateStrictPos-v0", "RotateStrictPosNeg-v0"});
  for (const std::string& id : all_ids()) {
    test::check_rl_facts(id, 90, is_strict(id) ? "Object" : "Spatial");
    const auto batch = make_env(id);
    CHECK(batch->info().success_reward == (is_strict(id) ? 100 : 25));
    CHECK(batch->state_dim() == 33);
  }
}

TEST_CASE("Targets of Rotate's RL tasks are those of the VLA tasks, in half precision",
          "[rotate][rl]") {
  for (const std::string& id : all_ids()) {
    INFO(id);
    const BatchOptions options{.num_envs = 400};
    const auto batch = make_running(id, options);
    const bool both = id.find("PosNeg") != std::string::npos;
    for (int i = 0; i < options.num_envs; ++i) {
      const float cue = *row<float>(batch->output("task_cue"), i);
      CHECK(static_cast<double>(cue) == tasks::round_to_half(static_cast<double>(cue)));
      CHECK((both ? std::abs(cue) > 0.0999F && cue < 0.7855F : cue > 0.0999F && cue < 1.571F));
      if (both && cue < 0) CHECK(cue > -0.443F);
      if (both && cue > 0) CHECK(cue > 0.442F);
      CHECK(*row<float>(batch->output("oracle_info"), i) == Approx(cue).margin(1e-6));
    }
  }
}

TEST_CASE("Info and reward terms of Rotate's RL tasks have the published names", "[rotate][rl]") {
  using Names = std::vector<std::string>;
  for (const std::string& id : all_ids()) {
    INFO(id);
    const auto batch = make_env(id);
    Names info;
    for (std::size_t i = 0; i < test::columns_of(*batch).size(); ++i) {
      const std::string& name = test::columns_of(*batch)[i].field->name;
      if (name == "relative_angle" || name.ends_with("_error")) info.push_back(name);
    }
    CHECK(info == (is_strict(id)
                       ? Names{"relative_angle", "x_pos_error", "y_angle_error", "y_pos_error"}
                       : Names{"relative_angle", "y_angle_error"}));
    CHECK(test::names_of(batch->info().reward_terms) ==
          (is_strict(id)
               ? Names{"to_grip_dist", "reaching_reward", "reached_status", "y_angle_reward",
                       "correct_angle", "y_angle_diff", "agent_is_static", "success", "x_pos_error",
                       "y_pos_error", "x_pos_reward", "y_pos_reward", "position_ok"}
               : Names{"to_grip_dist", "reaching_reward", "reached_status", "y_angle_reward",
                       "self.correct_angle", "self.angle_diff", "agent_is_static", "success"}));
  }
}

TEST_CASE("The reward of RotateLenient as an RL task equals its published values", "[rotate][rl]") {
  tasks::RotateReward in{.distance = 0.05, .error = 0.05, .success_reward = 25};
  CHECK(in.compute() == Approx(19.694953).margin(1e-6));
  in.distance = 0.30;
  in.robot_static = true;  // too early for success
  CHECK(in.compute() == Approx(7.223130).margin(1e-6));
  in.success = true;
  CHECK(in.compute() == 25);
}

// Turns the peg to an angle and lets a step pass.
void turn_to(Batch& batch, double angle) {
  double* quat = batch.state().prop_quat_of(0, 0);
  quat[0] = std::cos(angle / 2);
  quat[3] = std::sin(angle / 2);
  test::step(batch, Policy::kZero);
}

TEST_CASE("In the first five steps nothing is a success, whatever rewards are asked for",
          "[rotate][rl]") {
  for (const std::string& id : all_ids()) {
    for (const RewardMode mode : {RewardMode::kSparse, RewardMode::kDense, RewardMode::kNone}) {
      for (const bool ends : {true, false}) {
        BatchOptions options{.reward_mode = mode, .auto_reset = AutoReset::kOff, .substeps = 0};
        if (!ends) options.terminate_on_success = false;
        options.pins = {{"target_angle", {0.5}}, {"initial_yaw", {0.0}}};
        const auto batch = make_running(id, options);
        INFO(id);
        for (int t = 1; t <= 5; ++t) {
          turn_to(*batch, 0.5);
          CHECK(batch->outputs().success[0] == 0);
          CHECK(batch->outputs().terminated[0] == 0);
        }
        turn_to(*batch, 0.5);
        CHECK(batch->outputs().success[0] == 1);
        CHECK(batch->outputs().terminated[0] == (ends ? 1 : 0));
        const bool strict = is_strict(id);
        CHECK(batch->outputs().reward[0] == (mode == RewardMode::kSparse ? 1.0F
                                             : mode == RewardMode::kDense
                                                 ? (strict ? 100.0F : 25.0F)
                                                 : 0.0F));
      }
    }
  }
}

// The published formula, from the state and what the episode began with.
class Published {
 public:
  // Notes how the peg lies, before the first step.
  void begin(const Batch& batch, int i) {
    pos_ = Eigen::Map<const Eigen::Vector3d>(batch.state().prop_pos_of(i, 0));
    yaw_ = yaw(batch, i);
  }

  double reward(const Batch& batch, int i, bool strict) const {
    const State& state = batch.state();
    const Eigen::Vector3d pos = Eigen::Map<const Eigen::Vector3d>(state.prop_pos_of(i, 0));
    const Eigen::Vector3d tcp = Eigen::Map<const Eigen::Vector3d>(state.tcp_pos.row(i));
    const auto target = static_cast<double>(*row<float>(batch.output("task_cue"), i));
    const double e = std::abs(std::remainder(target - (yaw(batch, i) - yaw_), 2 * kPi));
    const double distance = (pos - tcp).norm();
    const Eigen::Vector3d shift = (pos - pos_).cwiseAbs();
    const bool placed = shift.x() < 0.05 && shift.y() < 0.05;
    double fastest = 0;
    for (int k = 0; k < 7; ++k) fastest = std::max(fastest, std::abs(state.qvel.row(i)[k]));
    const bool still = fastest <= 0.2;
    const bool late = state.elapsed[i] > 5;
    if (strict) {
      if (e < 0.1 && still && placed && late) return 100;
      double reward = 0.5 * std::exp(-3 * distance);
      if (distance >= 0.04) return reward;
      reward += 5 * std::exp(-5 * shift.x()) + 5 * std::exp(-5 * shift.y());
      if (placed) reward += 35 * std::exp(-e) + (e < 0.1 ? 10 + (still ? 5 : 0) : 0);
      return reward;
    }
    if (e < 0.1 && still && late) return 25;
    return std::exp(-5 * distance) + (distance < 0.1 ? 15 * std::exp(-1.5 * e) : 0) +
           (e < 0.1 ? 5 + (still ? 2 : 0) : 0);
  }

 private:
  static double yaw(const Batch& batch, int i) {
    return tasks::peg_angle(batch.state().prop_quat_of(i, 0));
  }

  Eigen::Vector3d pos_ = Eigen::Vector3d::Zero();
  double yaw_ = 0;
};

TEST_CASE("Rewards of Rotate's RL tasks are those of the published formula over 5,000 steps",
          "[rotate][rl]") {
  for (const std::string& id : all_ids()) {
    INFO(id);
    std::vector<Published> published(20);
    const auto [steps, successes] = test::play_rl(
        id,
        [&](const Batch& batch, int i) {
          const double expected =
              published[static_cast<std::size_t>(i)].reward(batch, i, is_strict(id));
          CHECK(static_cast<double>(batch.outputs().reward[static_cast<std::size_t>(i)]) ==
                Approx(expected).margin(2e-5));
        },
        [&](const Batch& batch, int i) { published[static_cast<std::size_t>(i)].begin(batch, i); });
    CHECK(steps >= 5000);
    CHECK(successes > 100);
  }
}

TEST_CASE("The oracle solves the RL tasks of Rotate in both of their usual modes",
          "[rotate][rl][oracle]") {
  for (const std::string& id : all_ids()) test::check_rl_oracle(id);
}

}  // namespace
}  // namespace engram
