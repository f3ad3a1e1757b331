#include "tasks/remember/find_same.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "core/collision/contact_pair.h"
#include "tests/tasks/remember/recall_env.h"

namespace engram {
namespace {

using test::count_of, test::make_env, test::make_running, test::memory_int, test::object_pos,
    test::Part, test::row, test::stored_pos;

bool settles(const Batch& batch) { return batch.info().family != "RememberColor"; }

// Checks who is where in the phase of the present step; nobody has touched anything.
void check_phase(const Batch& batch) {
  const tasks::ObjectSet objects = test::objects_of(batch);
  const int t = batch.state().elapsed[0];
  const int cue = memory_int(batch, "cue_steps");
  const int target = memory_int(batch, "target");
  const bool manipulation = t >= test::appearance_of(batch);
  INFO(batch.info().id << ", t " << t << ", cue " << cue);
  for (int key = 0; key < count_of(batch); ++key) {
    const bool visible = manipulation || (t < cue && key == target);
    CHECK(test::is_visible(batch, key) == visible);
    Eigen::Vector3d expected = stored_pos(batch, key);
    CHECK(expected.z() == objects.resting_height(key));
    if (!manipulation) expected.z() = 1000;
    if (!manipulation && key == target) {
      expected = {0, 0, t < cue ? objects.resting_height(key) : 1000};
    }
    CHECK(object_pos(batch, key) == expected);
    CHECK(batch.state().prop_quat_of(0, key)[0] == 1);
    CHECK(prop_is_static(batch.state(), 0, key, 0, 0));
  }
  test::check_outputs(batch, objects);
}

TEST_CASE("Remember runs through the phases of the worked example", "[remember]") {
  const BatchOptions options{.pins = {{"cue_steps", {2}}, {"empty_steps", {3}}}};
  for (const std::string& id : test::ids_of("Remember", Part::kShort)) {
    const auto batch = make_running(id, options);
    check_phase(*batch);
    double opening = static_cast<double>(batch->outputs().proprio[6]);
    for (int t = 1; t <= 8; ++t) {
      batch->step(std::vector<float>{0, 0, 0.2F, 0, 0, 0, 1});
      check_phase(*batch);
      // Actions of the first five steps are zeroed: the gripper closes half. The sixth is live.
      const double now = static_cast<double>(batch->outputs().proprio[6]);
      CHECK((now < opening) == (t <= 5));
      opening = now;
    }
    for (int t = 9; t <= 25; ++t) {
      batch->step(test::zeros(*batch));
      CHECK(batch->outputs().truncated[0] == (t == 25 ? 1 : 0));
      CHECK(batch->outputs().terminated[0] == 0);
    }
  }
}

TEST_CASE("Remember changes phases at the drawn steps in every variant", "[remember]") {
  for (const std::string& id : test::ids_of("Remember")) {
    for (std::uint64_t seed = 0; seed < 2; ++seed) {
      const auto batch = make_running(id, {.seed = seed});
      const int cue = memory_int(*batch, "cue_steps");
      const int appearance = test::appearance_of(*batch);
      check_phase(*batch);
      for (int t = 1; t <= appearance + 4; ++t) {
        test::step(*batch, Policy::kZero);
        if (t <= 3 || std::abs(t - cue) <= 1 || t >= appearance - 1) check_phase(*batch);
      }
    }
  }
}

TEST_CASE("Objects stay where they appear for the steps in which they settle", "[remember]") {
  for (const char* id :
       {"RememberColor5-VLA-v0", "RememberShape9-VLA-v0", "RememberShapeAndColor3x3-VLA-v0"}) {
    const auto batch = make_running(id, {.pins = {{"cue_steps", {1}}, {"empty_steps", {1}}}});
    const State& state = batch->state();
    test::step(*batch, Policy::kZero);
    for (int t = 2; t <= 6; ++t) {
      const bool pinned = t < 2 + (settles(*batch) ? 3 : 1);
      // The caller has displaced and turned an object during the step.
      const double away[3] = {0.3, 0.3, 0.02};
      const double turned[4] = {0, 0, 0, 1};
      state.place_prop(0, 1, away, turned);
      test::step(*batch, Policy::kZero);
      INFO(id << ", t " << t);
      CHECK((object_pos(*batch, 1) == stored_pos(*batch, 1)) == pinned);
      CHECK((state.prop_quat_of(0, 1)[0] == 1) == pinned);
    }
  }
}

TEST_CASE("Only the short Remember variants freeze the cue", "[remember]") {
  for (const std::string& id : test::ids_of("Remember", Part::kVla)) {
    const bool lengthy = id.find("Long") != std::string::npos;
    const auto batch = make_env(id);
    CHECK(batch->info().frozen_cue == !lengthy);
    batch->reset();
    CHECK(memory_int(*batch, "freeze_steps") == (lengthy ? 0 : test::appearance_of(*batch)));
  }
}

TEST_CASE("Remember draws targets and phase lengths uniformly over their ranges", "[remember]") {
  for (const std::string& id : test::ids_of("Remember", Part::kVla)) {
    const bool lengthy = id.find("Long") != std::string::npos;
    const bool fixed = id == "RememberColor5-Long-VLA-v0" || id == "RememberColor9-Long-VLA-v0";
    BatchOptions options;
    options.num_envs = lengthy ? 5000 : 1500;  // all of 401 lengths are to occur
    options.threads = 2;
    const auto batch = make_running(id, options);
    std::map<int, int> targets;
    std::map<int, int> cues;
    std::map<int, int> empties;
    for (int i = 0; i < options.num_envs; ++i) {
      ++targets[memory_int(*batch, "target", i)];
      ++cues[memory_int(*batch, "cue_steps", i)];
      ++empties[memory_int(*batch, "empty_steps", i)];
    }
    INFO(id);
    test::check_uniform(targets, 0, count_of(*batch) - 1);
    test::check_uniform(cues, fixed ? 100 : lengthy ? 10 : 1, lengthy ? 100 : 5);
    test::check_uniform(empties, lengthy ? 50 : 1, lengthy ? 450 : 5);
  }
}

TEST_CASE("Rows of three are stretched in RememberColor and RememberShape alone", "[remember]") {
  const std::map<std::string, double> spans = {{"RememberColor3-VLA-v0", 0.4},
                                               {"RememberShape3-VLA-v0", 0.4},
                                               {"FindImposterColor3-VLA-v0", 0.2},
                                               {"FindImposterShape3-VLA-v0", 0.2}};
  for (const auto& [id, span] : spans) {
    const BatchOptions options{.num_envs = 200};
    const auto batch = make_running(id, options);
    double sum = 0;
    for (int i = 0; i < options.num_envs; ++i) {
      const auto y = [&](int key) { return stored_pos(*batch, key, i).y(); };
      sum += std::max({y(0), y(1), y(2)}) - std::min({y(0), y(1), y(2)});
    }
    INFO(id);
    CHECK(sum / options.num_envs == Approx(span).margin(0.03));
  }
}

TEST_CASE("Success asks for phase, distance and stillness", "[remember]") {
  BatchOptions options;
  options.substeps = 0;  // the robot stays where the test puts it
  options.robot_init_qpos_noise = 0;
  options.pins = {{"cue_steps", {2}}, {"empty_steps", {2}}, {"target", {1}}};
  const auto batch = make_running("RememberColor3-VLA-v0", options);
  const State& state = batch->state();
  const Eigen::Vector3d tcp = Eigen::Map<Eigen::Vector3d>(state.tcp_pos.row(0));
  const auto result = [&](double distance, double speed) {
    const Eigen::Vector3d pos = tcp + Eigen::Vector3d(0, 0, distance);
    std::copy_n(pos.data(), 3, state.prop_pos_of(0, 1));
    state.qvel.row(0)[3] = speed;
    test::step(*batch, Policy::kZero);
    state.qvel.row(0)[3] = 0;
    return batch->outputs().success[0] != 0;
  };
  for (int t = 1; t < 4; ++t) {
    test::step(*batch, Policy::kZero);
    CHECK(batch->outputs().success[0] == 0);
  }
  test::step(*batch, Policy::kZero);  // t = 4: all cubes appear
  CHECK(batch->outputs().success[0] == 0);
  CHECK(result(0.03, 0));
  CHECK(result(0.05 - 1e-12, 0));
  CHECK_FALSE(result(0.05 + 1e-9, 0));
  CHECK(*row<std::uint8_t>(batch->output("is_robot_static"), 0) == 1);
  CHECK(*row<std::uint8_t>(batch->output("is_obj_placed"), 0) == 0);
  CHECK(result(0.03, 0.2));
  CHECK_FALSE(result(0.03, 0.2001));
  CHECK(*row<std::uint8_t>(batch->output("is_obj_placed"), 0) == 1);
  CHECK(*row<std::uint8_t>(batch->output("is_robot_static"), 0) == 0);
  CHECK(result(0.0, 0));  // on again: it is not latched
  CHECK(*row<std::uint8_t>(batch->output("success_once"), 0) == 1);
  CHECK(batch->outputs().terminated[0] == 0);
}

// A hand that comes to rest at the object of the cue. Returns in how many of 60 steps it rested
// there.
int rest_at_cue(Batch& batch, bool counts) {
  batch.reset();
  const State& state = batch.state();
  const double above = object_pos(batch, memory_int(batch, "target")).z() + 0.035;
  int rested = 0;
  for (int i = 0; i < 60; ++i) {
    const Eigen::Vector3d goal(0, 0, above);
    const Eigen::Vector3d way = (goal - Eigen::Map<Eigen::Vector3d>(state.tcp_pos.row(0))) * 10;
    std::vector<float> action(7);
    for (std::size_t k = 0; k < 3; ++k) {
      action[k] = static_cast<float>(std::clamp(way[static_cast<Eigen::Index>(k)], -1.0, 1.0));
    }
    batch.step(action);
    const bool rests = *row<std::uint8_t>(batch.output("is_obj_placed"), 0) != 0 &&
                       *row<std::uint8_t>(batch.output("is_robot_static"), 0) != 0;
    rested += rests ? 1 : 0;
    CHECK((batch.outputs().success[0] != 0) == (counts && rests));
    if (i > 55) CHECK(batch.outputs().reward[0] > 0.5F);  // the bonus is not gated
  }
  return rested;
}

TEST_CASE("Touching the cue before the objects appear is a success with success_in_cue alone",
          "[remember]") {
  BatchOptions options{.pins = {{"cue_steps", {100}},
                                {"empty_steps", {50}},
                                {"robot_noise", {0, 0, 0, 0, 0, 0, 0}}}};
  for (const char* id : {"RememberColor3-Long-VLA-v0", "RememberShapeAndColor5x3-Long-VLA-v0"}) {
    for (const bool counts : {false, true}) {
      INFO(id << ", option " << counts);
      options.task_options.clear();
      if (counts) options.task_options = {{"success_in_cue", 1}};
      CHECK(rest_at_cue(*make_env(id, options), counts) > 20);
    }
  }
}

TEST_CASE("Cubes forget in every step what they stick to, shapes do not", "[remember]") {
  for (const bool cubes : {true, false}) {
    const auto batch =
        make_running(cubes ? "RememberColor3-VLA-v0" : "RememberShape3-VLA-v0", {.substeps = 0});
    for (int i = 0; i < 22; ++i) test::step(*batch, Policy::kZero);
    std::int32_t* const ids = batch->state().contact_ids.row(0);
    std::fill_n(ids, StoredPair::kInts, 0);
    ids[StoredPair::kShapePair] = 1;
    ids[StoredPair::kPropA] = 2;
    ids[StoredPair::kPoints] = ids[StoredPair::kPatches] = 1;
    test::step(*batch, Policy::kZero);
    CHECK(ids[StoredPair::kShapePair] == 1);
    CHECK(ids[StoredPair::kPatches] == (cubes ? 0 : 1));
    CHECK(ids[StoredPair::kPoints] == (cubes ? 0 : 1));
  }
}

TEST_CASE("A cube that was pushed is where it was pushed to", "[remember]") {
  const auto batch =
      make_running("RememberColor5-VLA-v0", {.pins = {{"cue_steps", {1}}, {"empty_steps", {1}}}});
  for (int i = 0; i < 15; ++i) test::step(*batch, Policy::kOracle);
  for (int i = 0; i < 9; ++i) batch->step(std::vector<float>{0.5F, 0, -0.5F, 0, 0, 0, -0.6F});
  const int target = memory_int(*batch, "target");
  CHECK((object_pos(*batch, target) - stored_pos(*batch, target)).norm() > 0.003);
  CHECK(batch->outputs().observation[static_cast<std::size_t>(26 + 3 * target)] ==
        static_cast<float>(object_pos(*batch, target).x()));
  // An episode later everything stands upright again.
  test::step(*batch, Policy::kZero);
  test::step(*batch, Policy::kZero);
  for (int i = 0; i < 6; ++i) test::step(*batch, Policy::kZero);
  for (int key = 0; key < 5; ++key) CHECK(object_pos(*batch, key) == stored_pos(*batch, key));
}

}  // namespace
}  // namespace engram
