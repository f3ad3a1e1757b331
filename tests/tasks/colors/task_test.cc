// BunchOfColors, SeqOfColors and ChainOfColors in their environments.
#include "tasks/colors/task.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "core/batch/queries.h"
#include "tests/env_helpers.h"
#include "tests/tasks/pose_tool.h"

namespace engram {
namespace {

using test::flag, test::make_env, test::make_running, test::row, test::step_at;

const Eigen::Vector3d kFarAway(-0.1, 0, 0.4);

Eigen::Vector3d cube(const Batch& batch, int color, int index = 0) {
  return Eigen::Map<Eigen::Vector3d>(batch.state().prop_pos_of(index, color));
}

Eigen::Vector2d slot(const Batch& batch, int color, int index = 0) {
  return Eigen::Map<const Eigen::Vector2d>(
      row<double>(test::memory_of(batch).find("positions"), index) + 2 * color);
}

int target(const Batch& batch, int item, int index = 0) {
  return row<std::int32_t>(test::memory_of(batch).find("sequence"), index)[item];
}

template <class T>
T value(const Batch& batch, const char* name) {
  return *row<T>(batch.output(name), 0);
}

bool touched(const Batch& batch, int color) {
  return row<std::uint8_t>(test::memory_of(batch).find("touched"), 0)[color] != 0;
}

Eigen::Vector2d button(const Batch& batch) {
  return Eigen::Map<const Eigen::Vector2d>(
      row<double>(test::memory_of(batch).find("center_button_xy"), 0));
}

// An environment without physics in the first step of its action phase.
std::unique_ptr<Batch> acting(const std::string& id, std::vector<double> sequence = {4, 1, 7},
                              BatchOptions options = {}) {
  options.substeps = 0;
  options.reward_mode = RewardMode::kDense;
  const char* cue = id.find("Bunch") == 0 ? "cue_steps" : "cue_step_duration";
  options.pins = {{"sequence", std::move(sequence)}, {cue, {1}}, {"empty_steps", {1}}};
  auto batch = make_running(id, options);
  const int start = Queries(*batch).cue_end(0) + 1;
  for (int t = 0; t < start; ++t) step_at(*batch, kFarAway);
  CHECK(batch->state().elapsed[0] == start);
  return batch;
}

void touch(Batch& batch, int color) {
  step_at(batch, cube(batch, color) + Eigen::Vector3d(0, 0, 0.035));
  step_at(batch, kFarAway);
}

// Positions over the button at some height.
void step_over_button(Batch& batch, double height) {
  step_at(batch, {button(batch).x(), button(batch).y(), height});
}

void press_button(Batch& batch) {
  for (const double height : {0.1, 0.08, 0.09, 0.17}) step_over_button(batch, height);
}

TEST_CASE("The cue is shown as the worked examples say", "[color_recall]") {
  const BatchOptions options{
      .substeps = 0,
      .pins = {{"cue_step_duration", {2}}, {"empty_steps", {2}}, {"sequence", {4, 1, 7}}}};
  for (const char* id : {"SeqOfColors3-VLA-v0", "ChainOfColors3-VLA-v0"}) {
    const auto batch = make_running(id, options);
    CHECK(Queries(*batch).cue_end(0) == 6);
    for (int t = 0; t <= 20; ++t) {
      INFO(id << ", elapsed " << t);
      const int item = t / 2;
      for (int color = 0; color < 9; ++color) {
        const bool shown = t < 6 && color == target(*batch, item);
        const bool free = t >= 8;
        CHECK((batch->state().status_of(0, color) != PropStatus::kHidden) == (shown || free));
        const int* cue = row<std::int32_t>(test::memory_of(*batch).find("sequence"), 0);
        const bool past = std::find(cue, cue + std::min(item, 3), color) != cue + std::min(item, 3);
        Eigen::Vector3d expected(slot(*batch, color).x(), slot(*batch, color).y(),
                                 free ? 0.02 : 1000);
        if (!free && (shown || past)) expected.head<2>().setZero();
        if (shown) expected.z() = 0.02;
        CHECK(cube(*batch, color) == expected);
      }
      step_at(*batch, kFarAway);
    }
  }
}

TEST_CASE("Bunch shows all colours at once, each in its place", "[color_recall]") {
  const auto batch = make_running(
      "BunchOfColors3-VLA-v0",
      {.substeps = 0, .pins = {{"cue_steps", {1}}, {"empty_steps", {1}}, {"sequence", {8, 0, 3}}}});
  const std::map<int, Eigen::Vector3d> places = {{0, {0.038203, -0.156658, 0.02}},
                                                 {3, {0.206732, -0.060244, 0.02}},
                                                 {8, {0.038203, 0.156658, 0.02}}};
  for (int color = 0; color < 9; ++color) {
    const auto place = places.find(color);
    const Eigen::Vector3d expected =
        place != places.end() ? place->second : Eigen::Vector3d(0, 0, 1000);
    CHECK((cube(*batch, color) - expected).norm() < 1e-6);
    CHECK((batch->state().status_of(0, color) != PropStatus::kHidden) == (place != places.end()));
  }
  CHECK(value<float>(*batch, "max_cube_displacement_xy") > 0.05F);
  step_at(*batch, kFarAway);
  for (int color = 0; color < 9; ++color) {
    CHECK(batch->state().status_of(0, color) == PropStatus::kHidden);
    CHECK(cube(*batch, color) == Eigen::Vector3d(0, 0, 1000));
  }
  step_at(*batch, kFarAway);
  CHECK(value<float>(*batch, "max_cube_displacement_xy") == 0);
  for (int color = 0; color < 9; ++color) CHECK(cube(*batch, color).z() == 0.02);
}

TEST_CASE("Cubes are put back in the first five steps of the action phase", "[color_recall]") {
  const auto batch = acting("SeqOfColors3-VLA-v0");
  const int start = batch->state().elapsed[0];
  for (int t = start; t < start + 8; ++t) {
    batch->state().prop_pos_of(0, 2)[0] += 0.03;
    batch->state().prop_qvel_of(0, 2)[0] = 0.1;
    step_at(*batch, kFarAway);
    const bool put_back = batch->state().elapsed[0] <= start + 4;
    INFO("elapsed " << batch->state().elapsed[0]);
    CHECK((cube(*batch, 2).head<2>() == slot(*batch, 2)) == put_back);
    CHECK((batch->state().prop_qvel_of(0, 2)[0] == 0) == put_back);
  }
}

TEST_CASE("Layouts are the jittered arc, shuffled, with the button in its middle",
          "[color_recall]") {
  const BatchOptions options{.num_envs = 4000};
  const auto batch = make_running("ChainOfColors7-VLA-v0", options);
  std::array<std::array<int, 9>, 9> counts{};
  std::array<int, 9> first{};
  Eigen::Vector2d deviation = Eigen::Vector2d::Zero();
  for (int i = 0; i < options.num_envs; ++i) {
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    std::set<int> taken;
    for (int color = 0; color < 9; ++color) {
      const Eigen::Vector2d at = slot(*batch, color, i);
      mean += at / 9;
      // The nominal slot that is nearest.
      int nearest = 0;
      double least = 1;
      Eigen::Vector2d offset = Eigen::Vector2d::Zero();
      for (int k = 0; k < 9; ++k) {
        const double angle = 1.15 * std::numbers::pi * (k - 4) / 9;
        const Eigen::Vector2d nominal(0.3 * std::cos(angle) - 0.25,
                                      0.3 * std::sin(angle) + 0.018 * (k - 4));
        if ((at - nominal).norm() >= least) continue;
        least = (at - nominal).norm();
        nearest = k;
        offset = at - nominal;
      }
      taken.insert(nearest);
      ++counts[static_cast<std::size_t>(color)][static_cast<std::size_t>(nearest)];
      deviation += offset.cwiseProduct(offset);
    }
    CHECK(taken.size() == 9);
    const double* xy = row<double>(test::memory_of(*batch).find("center_button_xy"), i);
    CHECK(xy[0] == Approx(mean.x() - 0.04));
    CHECK(xy[1] == Approx(mean.y()).margin(1e-12));
    std::set<int> colors;
    for (int item = 0; item < 7; ++item) colors.insert(target(*batch, item, i));
    CHECK(colors.size() == 7);
    ++first[static_cast<std::size_t>(target(*batch, 0, i))];
  }
  const double expected = options.num_envs / 9.0;
  const double tolerance = 5 * std::sqrt(expected);
  for (std::size_t a = 0; a < 9; ++a) {
    CHECK(std::abs(first[a] - expected) < tolerance);
    for (std::size_t b = 0; b < 9; ++b) CHECK(std::abs(counts[a][b] - expected) < tolerance);
  }
  for (int axis = 0; axis < 2; ++axis) {
    CHECK(std::sqrt(deviation[axis] / (9 * options.num_envs)) == Approx(0.01).epsilon(0.03));
  }
}

TEST_CASE("A touch asks for the phase, stillness and the radius", "[color_recall]") {
  const auto batch = acting("BunchOfColors3-VLA-v0");
  const Eigen::Vector3d over = cube(*batch, 4);
  step_at(*batch, over + Eigen::Vector3d(0, 0, 0.080));  // 0.055 from the touch point
  CHECK_FALSE(touched(*batch, 4));
  test::pose_tool(*batch, over + Eigen::Vector3d(0, 0, 0.07));
  batch->state().qvel.row(0)[2] = 0.25;
  test::step(*batch, Policy::kZero);
  CHECK_FALSE(touched(*batch, 4));
  step_at(*batch, over + Eigen::Vector3d(0, 0, 0.07));
  CHECK(touched(*batch, 4));
  step_at(*batch, kFarAway);
  CHECK(touched(*batch, 4));

  // With upstream's radius a touch is nearer.
  const BatchOptions narrow{.task_options = {{"touch_radius", 0.02}}};
  const auto strict = acting("BunchOfColors3-VLA-v0", {4, 1, 7}, narrow);
  step_at(*strict, cube(*strict, 4) + Eigen::Vector3d(0, 0, 0.07));
  CHECK_FALSE(touched(*strict, 4));
  step_at(*strict, cube(*strict, 4) + Eigen::Vector3d(0, 0, 0.035));
  CHECK(touched(*strict, 4));
  CHECK_THROWS_WITH(make_env("BunchOfColors3-VLA-v0", {.task_options = {{"touch_radius", 0}}}),
                    Catch::Contains("0.001 to 0.2"));

  // Not during the cue.
  const auto early = make_running(
      "ChainOfColors3-VLA-v0",
      {.substeps = 0,
       .pins = {{"cue_step_duration", {2}}, {"empty_steps", {2}}, {"sequence", {4, 1, 7}}}});
  for (int t = 1; t < 8; ++t) {
    step_at(*early, {0, 0, 0.055});
    for (int color = 0; color < 9; ++color) CHECK_FALSE(touched(*early, color));
  }
}

TEST_CASE("The button opens when the colours are touched, and success needs all of it",
          "[color_recall]") {
  for (const char* id : {"BunchOfColors3-VLA-v0", "SeqOfColors3-VLA-v0", "ChainOfColors3-VLA-v0"}) {
    INFO(id);
    const bool chain = id[0] == 'C';
    // In the cue's order, and in another.
    for (const std::vector<int>& order : {std::vector<int>{4, 1, 7}, std::vector<int>{7, 4, 1}}) {
      const bool right = !chain || order[0] == 4;
      const auto batch = acting(id);
      press_button(*batch);  // too early: it stays shut
      CHECK_FALSE(flag(*batch, "button_pressed"));
      for (int i = 0; i < 3; ++i) {
        CHECK_FALSE(flag(*batch, "button_pressable"));
        touch(*batch, order[static_cast<std::size_t>(i)]);
      }
      CHECK(flag(*batch, "button_pressable") == right);
      CHECK_FALSE(batch->outputs().success[0]);
      press_button(*batch);
      CHECK(flag(*batch, "button_pressed") == right);
      CHECK(batch->outputs().success[0] == (right ? 1 : 0));
      CHECK(batch->outputs().terminated[0] == 0);
      if (!right) continue;
      CHECK(batch->outputs().reward[0] == 400);
      // Stillness and displacement are asked for in every step, and a wrong touch spoils it.
      test::pose_tool(*batch, kFarAway);
      batch->state().qvel.row(0)[0] = 0.3;
      test::step(*batch, Policy::kZero);
      CHECK(batch->outputs().success[0] == 0);
      step_at(*batch, kFarAway);
      CHECK(batch->outputs().success[0] == 1);
      batch->state().prop_pos_of(0, 8)[1] += 0.0601;
      step_at(*batch, kFarAway);
      CHECK(batch->outputs().success[0] == 0);
      CHECK(flag(*batch, "strong_cube_displacement"));
      batch->state().prop_pos_of(0, 8)[1] -= 0.0602 - 0.06;
      step_at(*batch, kFarAway);
      CHECK(batch->outputs().success[0] == 1);
      touch(*batch, 5);
      CHECK(batch->outputs().success[0] == 0);
      CHECK(flag(*batch, "button_pressed"));
    }
  }
}

TEST_CASE("With strict order Seq demands the cue's order", "[color_recall]") {
  const BatchOptions strict{.task_options = {{"strict_order", 1}}};
  for (const bool right : {true, false}) {
    const auto batch = acting("SeqOfColors3-VLA-v0", {4, 1, 7}, strict);
    for (const int color : right ? std::vector<int>{4, 1, 7} : std::vector<int>{4, 7, 1}) {
      touch(*batch, color);
    }
    CHECK(flag(*batch, "button_pressable") == right);
  }
  CHECK_THROWS_WITH(acting("ChainOfColors3-VLA-v0", {4, 1, 7}, strict),
                    Catch::Contains("no option named 'strict_order'"));
}

TEST_CASE("Chain refuses a cube that is touched again, unless the original's rules hold",
          "[color_recall]") {
  for (const std::vector<int>& order :
       {std::vector<int>{4, 1, 7}, {4, 1, 7, 4}, {4, 1, 7, 1}, {4, 4, 1, 7}}) {
    INFO(order.size() << ", second " << order[1]);
    const bool again = order.size() > 3;
    for (const BatchOptions& options :
         {BatchOptions{}, BatchOptions{.task_options = {{"repeated_touches", 1}}},
          BatchOptions{.rules = Rules::kOriginal}}) {
      const bool refused =
          again && options.task_options.empty() && options.rules == Rules::kReference;
      const auto batch = acting("ChainOfColors3-VLA-v0", {4, 1, 7}, options);
      for (const int color : order) touch(*batch, color);
      press_button(*batch);
      CHECK(batch->outputs().success[0] == (refused ? 0 : 1));
      CHECK(flag(*batch, "button_pressable") == !refused);
    }
  }
  // The order does not count in the two other families.
  for (const char* id : {"BunchOfColors3-VLA-v0", "SeqOfColors3-VLA-v0"}) {
    const auto batch = acting(id);
    for (const int color : {4, 4, 1, 7}) touch(*batch, color);
    press_button(*batch);
    CHECK(batch->outputs().success[0] == 1);
  }
}

TEST_CASE("A tool that stays at a cube touches it once", "[color_recall]") {
  const auto batch = acting("ChainOfColors3-VLA-v0");
  const Eigen::Vector3d point = cube(*batch, 4) + Eigen::Vector3d(0, 0, 0.025);
  const double radius = 0.05;
  // In and out at the edge of where it touches, then away.
  for (const double height : {0.3 * radius, 0.99 * radius, 1.01 * radius, 0.98 * radius}) {
    step_at(*batch, point + Eigen::Vector3d(0, 0, height));
  }
  step_at(*batch, kFarAway);
  for (const int color : {1, 7}) touch(*batch, color);
  CHECK(flag(*batch, "button_pressable"));
}

TEST_CASE("A press waits while the button is shut", "[color_recall]") {
  const auto batch = acting("SeqOfColors3-VLA-v0");
  for (int t = 0; t < 6; ++t) step_at(*batch, kFarAway);
  for (const int color : {4, 1, 7}) touch(*batch, color);
  step_over_button(*batch, 0.08);
  batch->state().prop_pos_of(0, 0)[0] += 0.1;  // something was pushed meanwhile
  step_over_button(*batch, 0.17);
  CHECK_FALSE(flag(*batch, "button_pressed"));
  batch->state().prop_pos_of(0, 0)[0] -= 0.1;
  step_over_button(*batch, 0.17);
  CHECK(flag(*batch, "button_pressed"));
}

TEST_CASE("The goal vector leads from colour to colour and to the button", "[color_recall]") {
  for (const char* id : {"BunchOfColors3-VLA-v0", "SeqOfColors3-VLA-v0", "ChainOfColors3-VLA-v0"}) {
    INFO(id);
    const auto batch = acting(id);
    const std::vector<int> order =
        id[0] == 'B' ? std::vector<int>{1, 4, 7} : std::vector<int>{4, 1, 7};
    const auto check = [&batch](const Eigen::Vector3d& goal) {
      const float* shown = row<float>(batch->output("obj_to_goal_pos"), 0);
      for (int i = 0; i < 3; ++i) {
        CHECK(shown[i] == Approx(goal[i] - kFarAway[i]).margin(1e-6));
      }
    };
    step_at(*batch, kFarAway);
    for (const int color : order) {
      check(cube(*batch, color) + Eigen::Vector3d(0, 0, 0.025));
      for (int i = 0; i < 9; ++i) {
        CHECK(batch->outputs().observation[static_cast<std::size_t>(18 + 7 + 9 + 6 * i + 5)] ==
              (i == color ? 1 : 0));
      }
      touch(*batch, color);
    }
    check({button(*batch).x(), button(*batch).y(), 0.063});
    press_button(*batch);
    step_at(*batch, kFarAway);
    check(kFarAway);  // no goal is left
  }
}

TEST_CASE("The cap sinks in the action phase only", "[color_recall]") {
  const auto batch = make_running(
      "BunchOfColors5-VLA-v0", {.substeps = 0, .pins = {{"cue_steps", {2}}, {"empty_steps", {2}}}});
  const auto& props = batch->physics_model().props();
  const auto index = [&props](const char* name) {
    return static_cast<int>(
        std::find_if(props.begin(), props.end(),
                     [name](const PropModel& prop) { return prop.name == name; }) -
        props.begin());
  };
  const int cap = index("center_button_cap");
  const int base = index("center_button_base");
  REQUIRE(cap < batch->state().num_props);
  for (int t = 1; t <= 6; ++t) {
    step_over_button(*batch, 0.08);
    const double* pos = batch->state().prop_pos_of(0, cap);
    CHECK(pos[2] == Approx(t < 4 ? 0.044 : 0.036));
    CHECK(pos[0] == button(*batch).x());
    CHECK(batch->state().prop_quat_of(0, cap)[2] == Approx(0.70711).margin(1e-5));
    CHECK(batch->state().prop_pos_of(0, base)[2] == 0.015);
    CHECK(value<float>(*batch, "button_press_depth") == Approx(t < 4 ? 0 : 0.008).margin(1e-6));
  }
}

TEST_CASE("Colour tasks have the published sizes", "[color_recall]") {
  for (const auto& [length, dim] : std::map<int, int>{{3, 88}, {5, 90}, {7, 92}}) {
    for (const char* family : {"BunchOfColors", "SeqOfColors", "ChainOfColors"}) {
      const std::string id = family + std::to_string(length) + "-VLA-v0";
      const auto batch = make_env(id);
      CHECK(batch->state_dim() == dim);
      CHECK(batch->info().oracle_dim == length);
    }
  }
  const std::map<std::string, int> answers = {
      {"BunchOfColors3-VLA-v0", 84},    {"BunchOfColors5-VLA-v0", 126},
      {"SeqOfColors7-VLA-v0", 36},      {"ChainOfColors3-VLA-v0", 504},
      {"ChainOfColors5-VLA-v0", 15120}, {"ChainOfColors7-VLA-v0", 181440}};
  for (const auto& [id, count] : answers) CHECK(make_task(id)->info().candidates == count);
}

TEST_CASE("Colours that are pinned twice are refused", "[color_recall]") {
  CHECK_THROWS_WITH(make_env("ChainOfColors3-VLA-v0", {.pins = {{"sequence", {4, 1, 4}}}}),
                    Catch::Contains("4 given twice"));
}

TEST_CASE("The answer is the first wrong touch, or the last that is needed",
          "[color_recall][answer]") {
  struct Row {
    std::vector<int> touches;
    bool in_sets, in_order;  // what is right in Bunch and Seq, and in Chain
    int set_answer, order_answer;
    std::size_t set_touches, order_touches;  // with which the answer is given
  };
  const Row rows[] = {
      {{4, 1, 7}, true, true, 528, 528, 3, 3},    {{4, 7, 1}, true, false, 582, 58, 3, 2},
      {{4, 0, 7}, false, false, 51, 51, 2, 2},    {{8, 4, 1}, false, false, 9, 9, 1, 1},
      {{4, 1, 7, 3}, true, true, 528, 528, 3, 3},  // what follows does not count
  };
  for (const char* id : {"BunchOfColors3-VLA-v0", "SeqOfColors3-VLA-v0", "ChainOfColors3-VLA-v0"}) {
    const bool ordered = id[0] == 'C';
    for (const Row& line : rows) {
      INFO(id << ", row " << &line - rows);
      const auto batch = acting(id);
      press_button(*batch);  // no answer
      CHECK_FALSE(flag(*batch, "answered"));
      const std::size_t last = ordered ? line.order_touches : line.set_touches;
      for (std::size_t i = 0; i < line.touches.size(); ++i) {
        touch(*batch, line.touches[i]);
        CHECK(flag(*batch, "answered") == (i + 1 >= last));
      }
      CHECK(value<std::int32_t>(*batch, "first_answer") ==
            (ordered ? line.order_answer : line.set_answer));
      CHECK(flag(*batch, "first_answer_correct") == (ordered ? line.in_order : line.in_sets));
    }
  }
}

TEST_CASE("A wrong touch fails a strict episode", "[color_recall][answer]") {
  for (const bool strict : {false, true}) {
    const BatchOptions options{.task_options = {{kStrictOption, strict ? 1.0 : 0.0}}};
    const auto batch = acting("BunchOfColors3-VLA-v0", {4, 1, 7}, options);
    touch(*batch, 1);
    CHECK_FALSE(flag(*batch, "failed"));
    touch(*batch, 0);
    CHECK(flag(*batch, "failed") == strict);
  }
}

}  // namespace
}  // namespace engram
