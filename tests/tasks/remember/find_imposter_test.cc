#include "tasks/remember/find_imposter.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "tests/tasks/first_answer.h"
#include "tests/tasks/pose_tool.h"
#include "tests/tasks/remember/recall_env.h"

namespace engram {
namespace {

using test::count_of, test::make_env, test::make_running, test::memory_int, test::object_pos,
    test::row, test::stored_pos;

Eigen::Vector3d cue_pos(const Batch& batch, int key, double z, int index = 0) {
  const double* pos = row<double>(test::memory_of(batch).find("cue_positions"), index) + 2 * key;
  return {pos[0], pos[1], z};
}

// Checks who is where in the phase of the present step; nobody has touched anything.
void check_phase(const Batch& batch) {
  const tasks::ObjectSet objects = test::objects_of(batch);
  const int t = batch.state().elapsed[0];
  const int since_appearance = t - test::appearance_of(batch);
  const int imposter = memory_int(batch, "target");
  const bool cue = t < memory_int(batch, "cue_steps");
  INFO(batch.info().id << ", t " << t << ", " << since_appearance << " since the appearance");
  for (int key = 0; key < count_of(batch); ++key) {
    const bool visible = since_appearance >= 0 || (cue && key != imposter);
    CHECK(test::is_visible(batch, key) == visible);
    if (since_appearance < 0) {
      CHECK(object_pos(batch, key) == cue_pos(batch, key, visible ? 0.02 : 1000));
      CHECK(prop_is_static(batch.state(), 0, key, 0, 0));
    } else {
      // They drop where they appear, sink in a little as they land, and lie still soon after.
      const Eigen::Vector3d moved = object_pos(batch, key) - stored_pos(batch, key);
      const double unrest = since_appearance == 0 ? 0.003 : since_appearance == 1 ? 0.002 : 0.001;
      CHECK(moved.head<2>().norm() < 5e-4);
      CHECK(std::abs(moved.z()) < unrest);
    }
    CHECK(batch.state().prop_quat_of(0, key)[0] == Approx(1).margin(1e-3));
  }
  test::check_outputs(batch, objects);
}

TEST_CASE("FindImposter runs through the phases of the worked example", "[find_imposter]") {
  const BatchOptions options{.pins = {{"cue_steps", {2}}, {"empty_steps", {3}}}};
  for (const std::string& id : test::ids_of("FindImposter")) {
    const auto batch = make_env(id, options);
    CHECK(batch->info().frozen_cue);
    batch->reset();
    CHECK(memory_int(*batch, "freeze_steps") == 5);
    check_phase(*batch);
    double opening = static_cast<double>(batch->outputs().proprio[6]);
    for (int t = 1; t <= 8; ++t) {
      batch->step(std::vector<float>{0, 0, 0.2F, 0, 0, 0, 1});
      check_phase(*batch);
      const double now = static_cast<double>(batch->outputs().proprio[6]);
      CHECK((now < opening) == (t <= 5));
      opening = now;
    }
    const int horizon = id == "FindImposterShapeAndColor5x3-VLA-v0" ? 40 : 25;
    for (int t = 9; t <= horizon; ++t) {
      batch->step(test::zeros(*batch));
      CHECK(batch->outputs().truncated[0] == (t == horizon ? 1 : 0));
      CHECK(batch->outputs().terminated[0] == 0);
    }
  }
}

TEST_CASE("Objects that are shown hang in the air, awake or not", "[find_imposter]") {
  for (const bool sleep : {true, false}) {
    const auto batch =
        make_running("FindImposterShape9-VLA-v0",
                     {.sleep = sleep, .pins = {{"cue_steps", {5}}, {"empty_steps", {2}}}});
    for (int t = 1; t < 5; ++t) {
      // The caller has displaced and turned an object during the step.
      const int key = memory_int(*batch, "target") == 3 ? 4 : 3;
      const double away[3] = {0.3, 0.3, 0.02};
      const double turned[4] = {0, 0, 0, 1};
      batch->state().place_prop(0, key, away, turned);
      test::step(*batch, Policy::kZero);
      check_phase(*batch);
    }
  }
}

TEST_CASE("Low shapes drop from the step of their appearance on", "[find_imposter]") {
  const auto batch = make_running("FindImposterShape9-VLA-v0",
                                  {.pins = {{"cue_steps", {1}}, {"empty_steps", {1}}}});
  test::step(*batch, Policy::kZero);
  test::step(*batch, Policy::kZero);
  const tasks::ObjectSet objects = test::objects_of(*batch);
  const auto height = [&](int key) {
    return object_pos(*batch, key).z() - objects.resting_height(key);
  };
  // Cross, torus, star and t_shape have landed; pyramide and crescent have fallen for five
  // substeps.
  constexpr double kFall = 15 * 9.81 * 1e-4;
  for (const int key : {3, 4, 5, 7}) CHECK(std::abs(height(key)) < 3e-3);
  for (const int key : {6, 8})
    CHECK(object_pos(*batch, key).z() == Approx(0.02 - kFall).margin(1e-4));
  test::step(*batch, Policy::kZero);
  for (int key = 0; key < 9; ++key) CHECK(std::abs(height(key)) < 2e-3);
  for (int t = 4; t <= 8; ++t) test::step(*batch, Policy::kZero);
  for (int key = 0; key < 9; ++key) CHECK(std::abs(height(key)) < 2e-4);
}

TEST_CASE("A pinned permutation deals the places as in the example", "[find_imposter]") {
  BatchOptions options{.pins = {{"permutation", {1, 2, 0}}}};
  const auto batch = make_running("FindImposterShape3-VLA-v0", options);
  for (const auto& [key, place] : {std::pair{0, 1}, {1, 2}, {2, 0}}) {
    CHECK(stored_pos(*batch, key).head<2>() == cue_pos(*batch, place, 0).head<2>());
  }
  options.pins = {{"permutation", {1, 1, 0}}};
  CHECK_THROWS_WITH(make_env("FindImposterShape3-VLA-v0", options),
                    "pin 'permutation': value 1 given twice, different values allowed");
  options.pins = {{"imposter", {3}}};
  CHECK_THROWS_WITH(make_env("FindImposterShape3-VLA-v0", options), Catch::Contains("0 to 2"));
}

// "Success: TCP within GOAL_THRESH of the imposter in the manipulation phase."
TEST_CASE(
    "Success is a tool within GOAL_THRESH of the imposter, at rest under the original's rules",
    "[find_imposter][rules]") {
  for (const Rules rules : {Rules::kReference, Rules::kOriginal}) {
    for (const char* id : {"FindImposterColor5-VLA-v0", "FindImposterShape5-VLA-v0",
                           "FindImposterShapeAndColor3x3-VLA-v0"}) {
      INFO(id << ", rules " << static_cast<int>(rules));
      const bool static_needed = rules == Rules::kOriginal;
      const auto batch =
          make_running(id, {.substeps = 0,
                            .pins = {{"imposter", {4}}, {"cue_steps", {1}}, {"empty_steps", {2}}},
                            .rules = rules});
      // After a step with the tool so far above an object, and a joint at that speed.
      const auto succeeds = [&](int key, double height, double speed) {
        test::pose_tool(*batch, object_pos(*batch, key) + Eigen::Vector3d(0, 0, height));
        batch->state().qvel.row(0)[0] = speed;
        test::step(*batch, Policy::kZero);
        return batch->outputs().success[0] != 0;
      };
      const double above = 0.05 - 1e-4;
      test::step_at(*batch, stored_pos(*batch, 4));  // the table is empty
      CHECK(batch->outputs().success[0] == 0);
      test::pose_tool(*batch, {0.1, 0, 0.3});
      test::step(*batch, Policy::kZero);  // objects appear
      test::step(*batch, Policy::kZero);
      CHECK_FALSE(test::first_answer(*batch).given);
      CHECK_FALSE(succeeds(4, 0.0502, 0.3));
      CHECK_FALSE(test::first_answer(*batch).given);
      CHECK(succeeds(4, above, 0.3) == !static_needed);
      CHECK(test::first_answer(*batch) ==
            (static_needed ? test::FirstAnswer{} : test::FirstAnswer{true, 4, true}));
      CHECK(*row<std::uint8_t>(batch->output("is_robot_static"), 0) == 0);
      CHECK(succeeds(4, above, 0.2));
      CHECK(batch->outputs().reward[0] == 1);
      CHECK_FALSE(succeeds(4, 0.0502, 0));
      CHECK_FALSE(succeeds(3, above, 0));
      CHECK(batch->outputs().terminated[0] == 0);
    }
  }
}

TEST_CASE("To pass by an object is an answer where the arm need not stand still",
          "[find_imposter][answer]") {
  for (const double needed : {0.0, 1.0}) {
    const BatchOptions options{
        .substeps = 0,
        .pins = {{"imposter", {4}}, {"cue_steps", {1}}, {"empty_steps", {1}}},
        .task_options = {{"static_needed", needed}, {kStrictOption, 1}}};
    const auto batch = make_running("FindImposterColor9-VLA-v0", options);
    test::step(*batch, Policy::kZero);
    test::step(*batch, Policy::kZero);
    for (const int key : {2, 4}) {
      test::pose_tool(*batch, object_pos(*batch, key) + Eigen::Vector3d(0, 0, 0.03));
      batch->state().qvel.row(0)[0] = key == 2 ? 0.5 : 0;
      test::step(*batch, Policy::kZero);
    }
    CHECK(test::first_answer(*batch) ==
          (needed == 0 ? test::FirstAnswer{true, 2, false} : test::FirstAnswer{true, 4, true}));
    CHECK((batch->outputs().success[0] != 0) == (needed != 0));
  }
}

// The place of the cue phase in which a key appears.
int dealt(const Batch& batch, int key, int index) {
  int place = 0;
  while (cue_pos(batch, place, 0, index).head<2>() != stored_pos(batch, key, index).head<2>())
    ++place;
  return place;
}

TEST_CASE("Places are dealt anew, each way as likely, but never as before", "[find_imposter]") {
  const BatchOptions options{.num_envs = 3000};
  const auto batch = make_running("FindImposterColor3-VLA-v0", options);
  std::map<std::array<int, 3>, int> seen;
  for (int i = 0; i < options.num_envs; ++i) {
    ++seen[{dealt(*batch, 0, i), dealt(*batch, 1, i), dealt(*batch, 2, i)}];
  }
  CHECK(seen.size() == 5);
  CHECK(seen.count({0, 1, 2}) == 0);
  for (const auto& [permutation, count] : seen) CHECK(std::abs(count - 600) < 110);
}

TEST_CASE("FindImposter draws imposters and phase lengths uniformly", "[find_imposter]") {
  for (const std::string& id : test::ids_of("FindImposter")) {
    const BatchOptions options{.num_envs = 3000, .threads = 2};
    const auto batch = make_running(id, options);
    std::map<int, int> imposters;
    std::map<int, int> cues;
    std::map<int, int> empties;
    for (int i = 0; i < options.num_envs; ++i) {
      ++imposters[memory_int(*batch, "target", i)];
      ++cues[memory_int(*batch, "cue_steps", i)];
      ++empties[memory_int(*batch, "empty_steps", i)];
    }
    INFO(id);
    test::check_uniform(imposters, 0, count_of(*batch) - 1);
    test::check_uniform(cues, 1, 5);
    test::check_uniform(empties, 1, 5);
  }
}

}  // namespace
}  // namespace engram
