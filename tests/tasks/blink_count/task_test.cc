// BlinkCountButtonPress: schedules, outcomes, reward.
#include "tasks/blink_count/task.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/batch/queries.h"
#include "tasks/blink_count/reward.h"
#include "tasks/common/reward_dict.h"
#include "tests/env_helpers.h"
#include "tests/tasks/pose_tool.h"

namespace engram {
namespace {

using test::flag, test::make_running, test::row, test::step_at;

constexpr const char* kEasy = "BlinkCountButtonPressEasy-VLA-v0";
const Eigen::Vector3d kFarAway(-0.1, 0, 0.4);
const Eigen::Vector3d kRed(-0.1, 0, 0);
const Eigen::Vector3d kBlack(-0.1, 0.16, 0);

Eigen::Vector3d over(const Eigen::Vector3d& button, double height) {
  return {button.x(), button.y(), height};
}

template <class T>
T value(const Batch& batch, const char* name, int index = 0) {
  return *row<T>(batch.output(name), index);
}
int count(const Batch& batch, const char* name) { return value<std::int32_t>(batch, name); }

BatchOptions placed(double blinks) {
  BatchOptions options{
      .reward_mode = RewardMode::kDense,
      .auto_reset = AutoReset::kOff,
      .substeps = 0,
      .pins = {{"button_x", {-0.1}}, {"button_y", {0}}, {"target_blinks", {blinks}}}};
  return options;
}

// An environment without physics after the last evaluation of the cue.
std::unique_ptr<Batch> after_cue(double blinks) {
  auto batch = make_running(kEasy, placed(blinks));
  while (batch->state().elapsed[0] < Queries(*batch).cue_end(0) - 1) step_at(*batch, kFarAway);
  return batch;
}

TEST_CASE("The lamp blinks as the worked example says", "[blink_count]") {
  BatchOptions options = placed(2);
  options.pins.push_back({"pre_blink_off_steps", {5}});
  options.pins.push_back({"blink_on_steps", {3, 3, 3}});
  options.pins.push_back({"blink_off_steps", {4, 3, 5}});
  const auto batch = make_running(kEasy, options);
  CHECK(Queries(*batch).cue_end(0) == 18);
  const auto& props = batch->physics_model().props();
  const auto index = [&props](const std::string& name) {
    return static_cast<int>(
        std::find_if(props.begin(), props.end(),
                     [&name](const PropModel& prop) { return prop.name == name; }) -
        props.begin());
  };
  const int blink = index("blink_lamp_bulb");
  const int phase = index("phase_lamp_bulb");
  REQUIRE(std::max(blink, phase) < batch->state().num_props);
  CHECK(batch->state().prop_pos_of(0, blink)[0] == Approx(0.12));
  CHECK(batch->state().prop_pos_of(0, blink)[1] == Approx(0).margin(1e-12));
  CHECK(batch->state().prop_pos_of(0, phase)[0] == Approx(0.12));
  CHECK(batch->state().prop_pos_of(0, phase)[1] == Approx(-0.2));
  for (int t = 0; t <= 22; ++t) {
    INFO("elapsed " << t);
    const bool lit = (t >= 5 && t <= 7) || (t >= 12 && t <= 14);
    CHECK(flag(*batch, "light_on") == lit);
    CHECK(flag(*batch, "phase_ready") == (t >= 18));
    CHECK(flag(*batch, "action_mask") == (t >= 18));
    const float* bulb = batch->state().prop_rgba.row(0) + 4 * blink;
    const float* signal = batch->state().prop_rgba.row(0) + 4 * phase;
    CHECK(bulb[0] == Approx(lit ? 0 : 245.0 / 255));
    CHECK(bulb[2] == Approx(lit ? 1 : 245.0 / 255));
    CHECK(batch->state().prop_emission.row(0)[blink] == (lit ? 20 : 0));
    CHECK(signal[0] == (t >= 18 ? 0 : 1));
    CHECK(signal[1] == (t >= 18 ? 1 : 0));
    CHECK(batch->state().prop_emission.row(0)[phase] == 3);
    step_at(*batch, kFarAway);
  }
}

TEST_CASE("The lamp's colour is an option", "[blink_count]") {
  BatchOptions options = placed(1);
  options.task_options = {{"blink_red", 51}, {"blink_green", 255}, {"blink_blue", 0}};
  options.pins.push_back({"pre_blink_off_steps", {5}});
  const auto batch = make_running(kEasy, options);
  for (int t = 0; t < 5; ++t) step_at(*batch, kFarAway);
  REQUIRE(flag(*batch, "light_on"));
  const float* rgba = batch->state().prop_rgba.row(0);
  bool found = false;
  for (int prop = 0; prop < batch->state().num_props; ++prop) {
    const float* own = rgba + 4 * prop;
    found |= own[0] == 0.2F && own[1] == 1 && own[2] == 0 && own[3] == 1;
  }
  CHECK(found);
}

TEST_CASE("Episodes draw what the ranges allow", "[blink_count]") {
  struct Ranges {
    int low, high, cue_low, cue_high;
  };
  const std::map<std::string, Ranges> table = {
      {"BlinkCountButtonPressEasy-VLA-v0", {1, 3, 11, 34}},
      {"BlinkCountButtonPressMedium-VLA-v0", {1, 5, 11, 50}},
      {"BlinkCountButtonPressHard-VLA-v0", {1, 7, 11, 66}},
      {"BlinkCountButtonPressEasy-Long-VLA-v0", {1, 10, 11, 130}},
      {"BlinkCountButtonPressMedium-Long-VLA-v0", {10, 20, 65, 210}},
      {"BlinkCountButtonPressHard-Long-VLA-v0", {20, 30, 125, 290}},
  };
  for (const auto& [id, ranges] : table) {
    INFO(id);
    const BatchOptions options{.num_envs = 3000};
    const auto batch = make_running(id, options);
    CHECK(batch->state_dim() == 77);
    CHECK(batch->info().candidates == ranges.high - ranges.low + 1);
    std::map<int, int> blinks;
    int shortest = 1000;
    int longest = 0;
    for (int i = 0; i < options.num_envs; ++i) {
      ++blinks[value<std::int32_t>(*batch, "target_blinks", i)];
      shortest = std::min(shortest, Queries(*batch).cue_end(i));
      longest = std::max(longest, Queries(*batch).cue_end(i));
      const double* red = row<double>(test::memory_of(*batch).find("button_xy"), i);
      const double* black = row<double>(test::memory_of(*batch).find("confirm_button_xy"), i);
      CHECK((red[0] >= -0.15 && red[0] < -0.05 && red[1] >= -0.12 && red[1] < 0.12));
      CHECK(black[0] == red[0]);
      CHECK(black[1] == Approx(red[1] + 0.16));
    }
    CHECK(blinks.begin()->first == ranges.low);
    CHECK(blinks.rbegin()->first == ranges.high);
    const double expected = 3000.0 / (ranges.high - ranges.low + 1);
    for (const auto& [number, times] : blinks) {
      CHECK(std::abs(times - expected) < 5 * std::sqrt(expected));
    }
    CHECK(shortest >= ranges.cue_low);
    CHECK(longest <= ranges.cue_high);
  }
}

TEST_CASE("Presses lead to the worked outcomes", "[blink_count]") {
  struct Press {
    Eigen::Vector3d button;
    double height;
  };
  struct Row {
    std::vector<Press> presses;
    int raw, confirmed;
    bool success;
  };
  const Row rows[] = {
      {{{kRed, 0.080}, {kRed, 0.090}, {kRed, 0.166}, {kBlack, 0.080}}, 1, 1, true},
      {{{kRed, 0.080}, {kRed, 0.090}, {kBlack, 0.080}}, 1, 0, false},
      {{{kRed, 0.080}, {kRed, 0.090}, {kRed, 0.166}, {kRed, 0.080}}, 2, 1, false},
      {{{kBlack, 0.080}}, 0, 0, false},
      {{{kRed, 0.080}, {kRed, 0.084}, {kRed, 0.080}, {kRed, 0.090}, {kRed, 0.166}, {kBlack, 0.080}},
       1,
       1,
       true},
  };
  for (const Row& line : rows) {
    const auto batch = after_cue(1);
    step_at(*batch, kFarAway);  // the first evaluation of the action phase
    for (std::size_t i = 0; i < line.presses.size(); ++i) {
      INFO("row " << &line - rows << ", press " << i);
      CHECK(batch->outputs().terminated[0] == 0);
      step_at(*batch, over(line.presses[i].button, line.presses[i].height));
    }
    CHECK(count(*batch, "raw_press_count") == line.raw);
    CHECK(count(*batch, "press_count") == line.confirmed);
    CHECK(batch->outputs().terminated[0] == 1);
    CHECK(batch->outputs().success[0] == (line.success ? 1 : 0));
    CHECK(flag(*batch, "failed") != line.success);
    CHECK(flag(*batch, "submit_success") == line.success);
    if (line.success) CHECK(batch->outputs().reward[0] == 30);
  }
}

TEST_CASE("A press of the cue counts in the first step of the action phase", "[blink_count]") {
  const auto batch = after_cue(1);
  const int last = batch->state().elapsed[0];
  CHECK(last == Queries(*batch).cue_end(0) - 1);
  test::pose_tool(*batch, over(kRed, 0.08));
  // Again the last evaluation of the cue, now with the tool on the button.
  batch->state().elapsed[0] = last - 1;
  test::step(*batch, Policy::kZero);
  CHECK(count(*batch, "raw_press_count") == 0);
  CHECK(value<float>(*batch, "press_depth") == Approx(0.008).margin(1e-6));  // though the cap sinks
  step_at(*batch, over(kRed, 0.08));
  CHECK(batch->state().elapsed[0] == Queries(*batch).cue_end(0));
  CHECK(count(*batch, "raw_press_count") == 1);
  CHECK(flag(*batch, "new_raw_press_event"));
}

TEST_CASE("The cap sinks ahead of the finger, and stops a hard press", "[blink_count]") {
  const auto batch = make_running(
      kEasy, {.pins = {{"target_blinks", {1}}, {"robot_noise", {0, 0, 0, 0, 0, 0, 0}}}});
  while (batch->state().elapsed[0] < Queries(*batch).cue_end(0)) test::step(*batch, Policy::kZero);
  for (int i = 0; i < 60 && count(*batch, "raw_press_count") == 0; ++i) {
    test::step(*batch, Policy::kOracle);
  }
  REQUIRE(count(*batch, "raw_press_count") == 1);
  double lowest = 1;
  int pressed = 0;
  for (int i = 0; i < 30; ++i) {
    // Down with full strength, but not aside; the tips slide off in the end.
    const double* tcp = batch->state().tcp_pos.row(0);
    const double* button = row<double>(test::memory_of(*batch).find("button_xy"), 0);
    if (std::hypot(tcp[0] - button[0], tcp[1] - button[1]) > 0.0165) break;
    ++pressed;
    std::vector<float> action(7);
    tasks::servo_tcp(batch->state(), 0, {button[0], button[1], tcp[2] - 0.1}, tasks::kToolDown,
                     tasks::kGripperClosed, action.data());
    batch->step(action);
    lowest = std::min(lowest, tcp[2]);
    CHECK(value<float>(*batch, "press_depth") >= 0.0049F);
  }
  CHECK(pressed >= 3);
  // The tips end 9.5 mm below the TCP, the sunken cap at 0.044.
  CHECK(lowest > 0.044 + 0.0095 - 0.004);
  CHECK(lowest < 0.044 + 0.0095 + 0.002);
  CHECK(Queries(*batch).unstable_count() == 0);
}

TEST_CASE("Without termination at success a later press too many fails", "[blink_count]") {
  BatchOptions options = placed(1);
  options.terminate_on_success = false;
  const auto batch = make_running(kEasy, options);
  while (batch->state().elapsed[0] < Queries(*batch).cue_end(0)) step_at(*batch, kFarAway);
  for (const double height : {0.08, 0.09, 0.17}) step_at(*batch, over(kRed, height));
  step_at(*batch, over(kBlack, 0.08));
  CHECK(batch->outputs().success[0] == 1);
  CHECK(batch->outputs().terminated[0] == 0);
  step_at(*batch, over(kBlack, 0.2));
  CHECK(batch->outputs().success[0] == 1);  // latched
  CHECK(batch->outputs().reward[0] == 30);
  step_at(*batch, over(kBlack, 0.08));
  CHECK_FALSE(flag(*batch, "new_confirm_press_event"));  // one submission per episode
  step_at(*batch, over(kRed, 0.08));
  CHECK(flag(*batch, "failed"));
  CHECK(batch->outputs().terminated[0] == 1);
  CHECK(batch->outputs().reward[0] == 30);
}

// Brings the button into the state that a row of the reward table assumes, then makes its step.
TEST_CASE("Environments pay the worked rewards", "[reward][blink_count]") {
  // Rows that a course of presses of an environment leads to; N = 2.
  const auto batch = after_cue(2);
  step_at(*batch, over(kRed, 0.10));
  const auto expect_smooth_off = [&batch](double reward) {
    // The zero action and a robot at rest: no action cost. Up to 35 are paid per metre of the TCP's
    // height, which is a float.
    CHECK(static_cast<double>(batch->outputs().reward[0]) == Approx(reward).margin(2e-5));
  };
  expect_smooth_off(1.0145562);
  step_at(*batch, over(kRed, 0.08));
  expect_smooth_off(4.1228610);
  CHECK(value<float>(*batch, "lift_target_z") == Approx(0.18));
  step_at(*batch, over(kRed, 0.09));
  step_at(*batch, over(kRed, 0.17));
  expect_smooth_off(-0.6486337);
  CHECK(flag(*batch, "new_press_event"));
  step_at(*batch, over(kRed, 0.18));
  expect_smooth_off(-1.0032573);
  step_at(*batch, over(kBlack, 0.08));
  expect_smooth_off(-14.2633660);
  CHECK(flag(*batch, "failed"));

  const auto other = after_cue(2);
  CHECK(other->outputs().reward[0] == 0);
  step_at(*other, kFarAway);
  for (int i = 0; i < 2; ++i) {
    for (const double height : {0.08, 0.09, 0.17}) step_at(*other, over(kRed, height));
  }
  step_at(*other, over(kBlack, 0.10));
  CHECK(static_cast<double>(other->outputs().reward[0]) == Approx(2.0875055).margin(2e-6));
  step_at(*other, over(kBlack, 0.08));
  CHECK(other->outputs().reward[0] == 30);
}

TEST_CASE("The blink reward has the worked value of a step with an abrupt action",
          "[reward][blink_count]") {
  const tasks::BlinkCountParams params;
  tasks::BlinkReward in{params};
  in.height = 0.12;
  in.xy_distance = 0.01;
  in.cap_distance = std::hypot(0.01, 0.12 - 0.044);
  in.black_cap_distance = std::hypot(0.15, 0.12 - 0.044);
  in.target = 2;
  in.pending = true;
  in.start_height = 0.08;
  in.red.released = true;
  in.acting = true;
  in.action_cost = {1, 0.2, 0.5};
  CHECK(in.compute() == Approx(7.7361566).margin(6e-7));
  CHECK(in.smooth.penalty == Approx(0.0401040).margin(6e-7));
  std::vector<std::string> names;
  for (const Field& term : tasks::reward_terms_of(in)) names.push_back(term.name);
  REQUIRE(names.size() == 37);
  CHECK(names[36] == "smooth_penalty");
  std::vector<float> values(names.size());
  tasks::TermWriter writer(values.data());
  in.list_terms(writer);
  CHECK(static_cast<double>(values[36]) == Approx(0.0401040).margin(6e-7));
  in.acting = false;
  CHECK(in.compute() == 0);
}

TEST_CASE("The first action is compared with zero", "[reward][blink_count]") {
  BatchOptions options = placed(1);
  const auto batch = make_running(kEasy, options);
  batch->step(std::vector<float>{0.3F, 0, 0, 0, 0, 0, 0.4F});
  step_at(*batch, kFarAway);
  const float* terms = row<float>(batch->output("reward_dict"), 0);
  CHECK(static_cast<double>(terms[33]) == Approx(std::tanh(2 * 0.5)));
  CHECK(static_cast<double>(terms[34]) == Approx(std::tanh(5 * 0.5)));
}

// Presses red, and submits if `submit`.
void answer(Batch& batch, int presses, bool submit) {
  for (int i = 0; i < presses; ++i) {
    for (const double height : {0.08, 0.09, 0.17}) step_at(batch, over(kRed, height));
  }
  if (submit) step_at(batch, over(kBlack, 0.08));
}

TEST_CASE("The answer is the count that is submitted, or one too many", "[blink_count][answer]") {
  for (const int presses : {0, 1, 2, 3}) {
    INFO(presses);
    const auto batch = after_cue(2);
    step_at(*batch, kFarAway);
    answer(*batch, std::min(presses, 2), false);
    CHECK_FALSE(flag(*batch, "answered"));
    answer(*batch, presses - std::min(presses, 2), presses < 3);
    CHECK(flag(*batch, "answered"));
    CHECK(count(*batch, "first_answer") == presses);
    CHECK(flag(*batch, "first_answer_correct") == (presses == 2));
    CHECK(flag(*batch, "failed") == (presses != 2));
  }
}

TEST_CASE("Only the first count is the answer, and none before the action phase",
          "[blink_count][answer]") {
  BatchOptions options = placed(1);
  options.terminate_on_success = false;
  const auto batch = make_running(kEasy, options);
  while (batch->state().elapsed[0] < Queries(*batch).cue_end(0) - 2) {
    step_at(*batch, over(kBlack, batch->state().elapsed[0] % 2 == 0 ? 0.08 : 0.2));
    CHECK_FALSE(flag(*batch, "answered"));
  }
  while (batch->state().elapsed[0] < Queries(*batch).cue_end(0)) step_at(*batch, kFarAway);
  answer(*batch, 1, true);
  CHECK(flag(*batch, "first_answer_correct"));
  step_at(*batch, kFarAway);
  answer(*batch, 1, false);
  CHECK(flag(*batch, "failed"));
  CHECK(count(*batch, "first_answer") == 1);
  CHECK(flag(*batch, "first_answer_correct"));
}

}  // namespace
}  // namespace engram
