// Intercept and InterceptGrab as RL tasks.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "core/batch/queries.h"
#include "tasks/intercept/deflect.h"
#include "tasks/intercept/grab.h"
#include "tests/tasks/rl_episodes.h"

namespace engram {
namespace {

using test::make_env, test::make_running, test::rl_ids, test::row;
using Vector = Eigen::Vector3d;

const std::map<std::string, std::pair<double, double>> kSpeeds = {
    {"InterceptSlow-v0", {0.25, 0.5}},       {"InterceptMedium-v0", {0.5, 0.75}},
    {"InterceptFast-v0", {0.75, 1.0}},       {"InterceptGrabSlow-v0", {0.25, 0.5}},
    {"InterceptGrabMedium-v0", {0.5, 0.75}}, {"InterceptGrabFast-v0", {0.75, 1.0}}};

bool is_grab(const std::string& id) { return id.find("Grab") != std::string::npos; }

TEST_CASE("The RL tasks of Intercept are those of the published list", "[intercept][rl]") {
  CHECK(rl_ids("Intercept") ==
        std::vector<std::string>{"InterceptSlow-v0", "InterceptMedium-v0", "InterceptFast-v0"});
  CHECK(rl_ids("InterceptGrab") == std::vector<std::string>{"InterceptGrabSlow-v0",
                                                            "InterceptGrabMedium-v0",
                                                            "InterceptGrabFast-v0"});
  for (const auto& [id, speed] : kSpeeds) test::check_rl_facts(id, 90, "Spatial");
}

TEST_CASE("RL tasks of Intercept draw and show what the VLA tasks do", "[intercept][rl]") {
  for (const auto& [id, speed] : kSpeeds) {
    INFO(id);
    const BatchOptions options{.num_envs = 500};
    const auto batch = make_env(id, options);
    const auto twin = make_env(id.substr(0, id.size() - 2) + "VLA-v0", options);
    batch->reset();
    twin->reset();
    double slowest = 9;
    double fastest = 0;
    for (int i = 0; i < options.num_envs; ++i) {
      const double* pos = batch->state().prop_pos_of(i, 0);
      CHECK(pos[2] == (is_grab(id) ? 0.02 : 0.04));
      CHECK((pos[0] >= -0.35 && pos[0] < -0.05 && pos[1] >= -0.9 && pos[1] < -0.65));
      const double* velocity = batch->state().prop_qvel_of(i, 0);
      CHECK((velocity[0] >= 0 && velocity[0] < 0.05 && velocity[2] == 0));
      slowest = std::min(slowest, velocity[1]);
      fastest = std::max(fastest, velocity[1]);
      CHECK(row<float>(batch->output("oracle_info"), i)[1] == static_cast<float>(velocity[1]));
    }
    CHECK((slowest >= speed.first && slowest < speed.first + 0.01));
    CHECK((fastest <= speed.second && fastest > speed.second - 0.01));
    CHECK(batch->state_dim() == (is_grab(id) ? 49 : 50));
    CHECK(test::names_of(Queries(*batch).state_fields()) ==
          test::names_of(Queries(*twin).state_fields()));
    CHECK(test::names_of(batch->info().reward_terms) == test::names_of(twin->info().reward_terms));
    CHECK(batch->info().success_reward == (is_grab(id) ? 300 : 30));
    for (const TaskConstant& constant : batch->info().constants) {
      CHECK(constant.name.find("_COEF") == std::string::npos);
    }
  }
}

TEST_CASE("A ball in the target ends an RL episode, unless the user wants it to go on",
          "[intercept][rl]") {
  for (const bool ends : {true, false}) {
    BatchOptions options{
        .reward_mode = RewardMode::kDense, .auto_reset = AutoReset::kOff, .substeps = 0};
    if (!ends) options.terminate_on_success = false;
    options.pins = {{"ball_x", {-0.2}}, {"goal_y", {0.0}}};
    const auto batch = make_running("InterceptFast-v0", options);
    double* pos = batch->state().prop_pos_of(0, 0);
    pos[0] = 0;
    pos[1] = -0.1001;
    test::step(*batch, Policy::kZero);
    CHECK(batch->outputs().success[0] == 0);
    CHECK(batch->outputs().terminated[0] == 0);
    pos[1] = -0.0999;
    test::step(*batch, Policy::kZero);
    CHECK(batch->outputs().success[0] == 1);
    CHECK(batch->outputs().reward[0] == 30);
    CHECK(batch->outputs().terminated[0] == (ends ? 1 : 0));
    CHECK(batch->outputs().truncated[0] == 0);
  }
}

TEST_CASE("The reward of InterceptGrab as an RL task equals its published values",
          "[intercept][rl]") {
  tasks::GrabReward in{.ball = {-0.2, -0.1, 0.02},
                       .tcp = {-0.2, -0.09, 0.03},
                       .gripper_width = 0.08,
                       .bonuses = {.attempt = 45, .grasp = 100}};
  CHECK(in.compute() == Approx(123.940290).margin(1e-5));
  in.tcp = in.ball;
  in.gripper_width = 0.05;
  CHECK(in.compute() == Approx(185));
  in.grasped = true;
  in.gripper_width = 0.0401;
  CHECK(in.compute() == Approx(285));
  in.gripper_width = 0.0399;
  CHECK(in.compute() == Approx(140));
}

TEST_CASE("In an RL episode one slow ball in ten drifts into the target by itself",
          "[intercept][rl]") {
  constexpr int kEpisodes = 1600;
  const auto share = [](const char* id) {
    const ControlMode mode = ControlMode::kPdJointDeltaPos;
    return test::solved_by(Policy::kZero, id, mode, kEpisodes) / double{kEpisodes};
  };
  CHECK(share("InterceptSlow-v0") == Approx(0.095).margin(0.02));
  CHECK(share("InterceptMedium-v0") < 0.001);
}

// --- the published formulas, from the state alone ---

Vector ball_of(const Batch& batch, int i) {
  return Eigen::Map<const Vector>(batch.state().prop_pos_of(i, 0));
}
Vector tcp_of(const Batch& batch, int i) {
  return Eigen::Map<const Vector>(batch.state().tcp_pos.row(i));
}

// The point behind the ball, as seen from the target.
Vector hit_point(const Batch& batch, int i) {
  const Vector ball = ball_of(batch, i);
  const Vector from_goal = ball - Eigen::Map<const Vector>(batch.state().prop_pos_of(i, 1));
  return ball + 0.07 * from_goal / from_goal.norm();
}

// reached: the latch of the environment's episode.
double published_deflect(const Batch& batch, int i, bool& reached) {
  const Vector ball = ball_of(batch, i);
  const Vector goal = Eigen::Map<const Vector>(batch.state().prop_pos_of(i, 1));
  const double distance = std::hypot(ball.x() - goal.x(), ball.y() - goal.y());
  const double r = (hit_point(batch, i) - tcp_of(batch, i)).norm();
  reached = reached || r < 0.04;
  if (distance < 0.1) return 30;
  return reached ? 5 * (1 - std::tanh(distance)) : 2 * (1 - std::tanh(2 * r));
}

double published_grab(const Batch& batch, int i) {
  const State& state = batch.state();
  const Vector offset = (ball_of(batch, i) - tcp_of(batch, i)).cwiseAbs();
  const double distance = offset.norm();
  const double* joints = state.qpos.row(i);
  const double width = joints[7] + joints[8];
  double fastest = 0;
  for (int k = 0; k < 7; ++k) fastest = std::max(fastest, std::abs(state.qvel.row(i)[k]));
  const bool grasped = is_grasping(state, i, 0);
  if (grasped && fastest <= 0.2) return 300;
  const bool inside = offset.x() <= 0.04 && offset.y() <= 0.04 && offset.z() <= 0.03 &&
                      distance <= 0.04 && width >= 0.04;
  double reward = 10 * (1 - std::tanh(3 * distance));
  if (inside) reward += 10 + 90 * std::exp(-5 * std::max(std::abs(width - 0.04) - 0.02, 0.0));
  if (distance <= 0.025) reward += 30 * (1 - distance / 0.06);
  if (inside && width <= 0.06) reward += 45;
  if (grasped) reward += 100;
  return reward;
}

TEST_CASE("Rewards of Intercept as an RL task are those of the published formula over 5,000 steps",
          "[intercept][rl]") {
  for (const std::string& id : rl_ids("Intercept")) {
    INFO(id);
    std::map<int, bool> reached;
    const auto [steps, successes] = test::play_rl(id, [&](const Batch& batch, int i) {
      if (batch.state().elapsed[i] == 1) reached[i] = false;
      const double expected = published_deflect(batch, i, reached[i]);
      CHECK(static_cast<double>(batch.outputs().reward[static_cast<std::size_t>(i)]) ==
            Approx(expected).margin(1e-5));
    });
    CHECK(steps >= 5000);
    CHECK(successes > 100);
  }
}

TEST_CASE("A hand that was once behind the ball earns by the ball's distance alone",
          "[intercept][rl]") {
  const BatchOptions options{.num_envs = 8,
                             .reward_mode = RewardMode::kDense,
                             .control_mode = ControlMode::kPdEeDeltaPose,
                             .terminate_on_success = false};
  const auto batch = make_running("InterceptSlow-v0", options);
  std::map<int, bool> reached;
  int latched = 0;
  for (int t = 1; t < 90; ++t) {
    batch->step(test::move_to(*batch, [&](int i) {
      const Vector hit = hit_point(*batch, i);
      const bool in_reach = std::hypot(hit.x() + 0.615, hit.y()) < 0.75;
      return in_reach ? hit : tcp_of(*batch, i);
    }));
    for (int i = 0; i < options.num_envs; ++i) {
      const double expected = published_deflect(*batch, i, reached[i]);
      CHECK(static_cast<double>(batch->outputs().reward[static_cast<std::size_t>(i)]) ==
            Approx(expected).margin(1e-5));
      latched += reached[i] && expected < 30 ? 1 : 0;
    }
  }
  CHECK(latched > 50);
}

TEST_CASE(
    "Rewards of InterceptGrab as an RL task are those of the published formula over 5,000 steps",
    "[intercept][rl]") {
  for (const std::string& id : rl_ids("InterceptGrab")) {
    INFO(id);
    int moving_grasps = 0;
    const auto [steps, successes] = test::play_rl(id, [&](const Batch& batch, int i) {
      const double reward =
          static_cast<double>(batch.outputs().reward[static_cast<std::size_t>(i)]);
      CHECK(reward == Approx(published_grab(batch, i)).margin(5e-5));
      moving_grasps += reward > 130 && reward < 300 ? 1 : 0;
    });
    CHECK(steps >= 5000);
    CHECK(successes > 100);
    CHECK(moving_grasps > 10);
  }
}

TEST_CASE("The oracle solves the RL tasks of Intercept in both of their usual modes",
          "[intercept][rl][oracle]") {
  for (const char* family : {"Intercept", "InterceptGrab"}) {
    for (const std::string& id : rl_ids(family)) test::check_rl_oracle(id);
  }
}

}  // namespace
}  // namespace engram
