// The shell games as tasks: phases, who is where, success, observation, and mugs that stay put.
#include "tasks/shell_game/game.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "mjcf/mug.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

using Eigen::Vector3d, test::make_env, test::make_running, test::row;

constexpr double kRest = mjcf::kMugRestingHeight;
constexpr const char* kLongs[] = {"ShellGameShuffleTouch-Long-VLA-v0",
                                  "ShellGameShuffleColorLampTouch-Long-VLA-v0"};
constexpr const char* kShorts[] = {
    "ShellGameTouch-VLA-v0",        "ShellGamePush-VLA-v0",
    "ShellGamePick-VLA-v0",         "ShellGameColorLampTouch-VLA-v0",
    "ShellGameShuffleTouch-VLA-v0", "ShellGameShuffleColorLampTouch-VLA-v0"};

bool has(const std::string& id, const char* part) { return id.find(part) != std::string::npos; }

int memory_int(const Batch& batch, const char* name, int index = 0) {
  return *row<std::int32_t>(test::memory_of(batch).find(name), index);
}
int oracle(const Batch& batch, int index = 0) {
  return *row<std::int32_t>(batch.output("oracle_info"), index);
}
Vector3d pos(const Batch& batch, int prop, int index = 0) {
  return Eigen::Map<Vector3d>(batch.state().prop_pos_of(index, prop));
}
bool visible(const Batch& batch, int prop, int index = 0) {
  return batch.state().status_of(index, prop) != PropStatus::kHidden;
}
void check_near(const Vector3d& given, const Vector3d& expected, double margin = 1e-12) {
  INFO(given.transpose() << " instead of " << expected.transpose());
  CHECK((given - expected).norm() <= margin);
}

BatchOptions pinned(std::vector<Pin> pins) {
  BatchOptions options{.pins = std::move(pins)};
  return options;
}

TEST_CASE("Mugs appear over the ball when the cue is over", "[shell]") {
  for (const char* id : {"ShellGameTouch-VLA-v0", "ShellGamePush-VLA-v0", "ShellGamePick-VLA-v0"}) {
    const auto batch = make_running(
        id, pinned({{"cue_steps", {3}}, {"base", {0.05, -0.03}}, {"cup_with_ball_number", {2}}}));
    for (int t = 0; t <= 6; ++t) {
      INFO(id << ", t " << t);
      for (int mug = 0; mug < 3; ++mug) {
        const Vector3d slot(0.05, -0.03 + (mug - 1) * 0.2, kRest);
        check_near(pos(*batch, mug), slot + Vector3d(0, 0, t < 3 ? 1000 : 0));
        CHECK(visible(*batch, mug) == (t >= 3));
        const Eigen::Map<const Eigen::Vector4d> quat(batch->state().prop_quat_of(0, mug));
        CHECK(quat.norm() == Approx(1).margin(1e-12));
        CHECK(quat[2] / quat[1] == Approx(has(id, "Pick") ? 2.5 : 0.5));
      }
      check_near(pos(*batch, 3), {0.05, 0.17, 0.02});
      CHECK(visible(*batch, 3));
      CHECK(oracle(*batch) == 2);
      test::step(*batch, Policy::kZero);
    }
  }
}

TEST_CASE("State observations have the published lengths and places", "[shell]") {
  const std::map<std::string, int> lengths = {
      {"ShellGameTouch-VLA-v0", 40},        {"ShellGamePush-VLA-v0", 43},
      {"ShellGamePick-VLA-v0", 47},         {"ShellGameColorLampTouch-VLA-v0", 30},
      {"ShellGameShuffleTouch-VLA-v0", 40}, {"ShellGameShuffleColorLampTouch-VLA-v0", 30}};
  for (const auto& [id, length] : lengths) {
    INFO(id);
    const auto batch = make_running(id, pinned({{"base", {0.02, 0.01}}}));
    REQUIRE(batch->state_dim() == length);
    const auto at = [&](int i) {
      return static_cast<double>(batch->outputs().observation[static_cast<std::size_t>(i)]);
    };
    const auto check = [&](int first, const Vector3d& point) {
      for (int i = 0; i < 3; ++i) CHECK(at(first + i) == Approx(point[i]).margin(1e-6));
    };
    const float* offset = row<float>(batch->output("obj_to_goal_pos"), 0);
    if (has(id, "Lamp")) {
      for (int i = 0; i < 3; ++i) CHECK(at(25 + i) == static_cast<double>(offset[i]));
      CHECK(at(28) == memory_int(*batch, "target_color"));
      CHECK(at(29) == oracle(*batch));
      continue;
    }
    const int cup = memory_int(*batch, "cup_with_ball_number");
    const double y = 0.01 + (cup - 1) * 0.2;
    int next = 25;
    if (has(id, "Push")) check(next, {0.12, y, 0.05});
    if (has(id, "Pick")) check(next, {0.02, y, 0.145});
    if (length > 40) next += 3;
    CHECK(at(next) == Approx(0.02).margin(1e-6));
    CHECK(at(next + 2) == Approx(1000.0529).margin(1e-3));
    next += 7;
    if (has(id, "Pick")) {
      CHECK(at(next) == Approx(0.02 - 0.045).margin(1e-6));
      CHECK(at(next + 1) == Approx(y + 0.043).margin(1e-6));
      next += 3;
    }
    check(next, {0.02, y, 0.02});
    next += 7;
    CHECK(at(next) == oracle(*batch));
    CHECK(next + (has(id, "Pick") ? 2 : 1) == length);
  }
}

TEST_CASE("The shuffle's test vector holds for both shuffle families", "[shell]") {
  const std::map<int, std::vector<double>> table = {
      {3, {0.05, -0.23, 1000.05295, 0.05, -0.03, 1000.05295, 0.05, 0.17, 1000.05295}},
      {4, {0.05, -0.23, 0.05295, 0.05, -0.03, 0.05295, 0.05, 0.17, 0.05295}},
      {7, {0.14446, -0.16281, 0.10962, -0.04446, -0.09719, 0.10962, 0.05, 0.17, 0.10962}},
      {21, {-0.13893, 0.03562, 0.10962, 0.23893, -0.09562, 0.10962, 0.05, -0.03, 0.10962}},
      {26, {0.05, -0.23, 0.05295, 0.05, 0.17, 0.05295, 0.05, -0.03, 0.05295}},
      {27, {0.05, -0.23, 0.05295, 0.05, 0.17, 0.05295, 0.05, -0.03, 0.05295}},
      {40, {0.05, -0.23, 0.05295, 0.05, 0.17, 0.05295, 0.05, -0.03, 0.05295}},
  };
  std::vector<Pin> pins = {{"base", {0.05, -0.03}},
                           {"cue_steps", {4}},
                           {"shuffle_steps", {23}},
                           {"num_swaps", {3}},
                           {"swap_pairs", {0, 2, 1, 0}}};
  for (const int cup : {0, 1, 2}) {
    for (const bool lamp : {false, true}) {
      std::vector<Pin> all = pins;
      all.push_back({lamp ? "target_color" : "cup_with_ball_number", {static_cast<double>(cup)}});
      if (lamp) all.push_back({"mapping", {0}});
      const auto batch = make_running(
          lamp ? "ShellGameShuffleColorLampTouch-VLA-v0" : "ShellGameShuffleTouch-VLA-v0",
          pinned(all));
      CHECK(oracle(*batch) == std::vector<int>{0, 2, 1}[static_cast<std::size_t>(cup)]);
      CHECK(memory_int(*batch, "freeze_steps") == 27);
      for (int t = 0; t <= 40; ++t) {
        INFO("lamp " << lamp << ", cup " << cup << ", t " << t);
        const auto expected = table.find(t);
        for (int mug = 0; mug < 3; ++mug) {
          CHECK(visible(*batch, mug) == (t >= 4));
          if (expected == table.end()) continue;
          check_near(pos(*batch, mug), Vector3d(expected->second.data() + 3 * mug), 1e-5);
        }
        if (lamp) {
          for (int ball = 3; ball < 6; ++ball) {
            CHECK(visible(*batch, ball) == (t < 4));
            check_near(pos(*batch, ball), t < 4 ? Vector3d(0.05, -0.03 + (ball - 4) * 0.2, 0.02)
                                                : Vector3d(0.05, -0.23, 1000.02));
          }
          const float* bulb = batch->state().prop_rgba.row(0) + 4 * 7;
          for (int k = 0; k < 3; ++k) CHECK(bulb[k] == (t < 27 || k == cup ? 1.0F : 0.0F));
          CHECK(batch->state().prop_emission.row(0)[7] == (t < 27 ? 0.0F : 2.0F));
          CHECK(*row<float>(batch->output("task_cue"), 0) == static_cast<float>(cup));
        } else {
          const double start = -0.03 + (cup - 1) * 0.2;
          const double end = -0.03 + (oracle(*batch) - 1) * 0.2;
          CHECK(visible(*batch, 3) == (t < 4 || t >= 27));
          const Vector3d ball = t < 4    ? Vector3d(0.05, start, 0.02)
                                : t < 27 ? Vector3d(0.05, start, 1000.02)
                                         : Vector3d(0.05, end, 0.02);
          check_near(pos(*batch, 3), ball);
          CHECK(*row<float>(batch->output("mug_max_displacement"), 0) == 0);
        }
        test::step(*batch, Policy::kZero);
      }
    }
  }
}

// Steps 25 and 26 are left over: seven steps a swap, 23 in all.
TEST_CASE("With snap_back, left-over steps show the mugs as before the last swap", "[shell]") {
  for (const char* id : {"ShellGameShuffleTouch-VLA-v0", "ShellGameShuffleColorLampTouch-VLA-v0"}) {
    BatchOptions options = pinned({{"base", {0.05, -0.03}},
                                   {"cue_steps", {4}},
                                   {"shuffle_steps", {23}},
                                   {"num_swaps", {3}},
                                   {"swap_pairs", {0, 2, 1, 0}}});
    const auto plain = make_env(id, options);
    options.task_options = {{"snap_back", 1}};
    const auto snapping = make_env(id, options);
    plain->reset();
    snapping->reset();
    const std::vector<Vector3d> before = {
        {0.05, 0.17, 0.05295}, {0.05, -0.23, 0.05295}, {0.05, -0.03, 0.05295}};
    for (int t = 0; t <= 30; ++t) {
      INFO(id << ", t " << t);
      for (int mug = 0; mug < 3; ++mug) {
        const bool left_over = t == 25 || t == 26;
        check_near(pos(*snapping, mug),
                   left_over ? before[static_cast<std::size_t>(mug)] : pos(*plain, mug), 1e-5);
      }
      CHECK(oracle(*snapping) == oracle(*plain));
      test::step(*plain, Policy::kZero);
      test::step(*snapping, Policy::kZero);
    }
  }
}

TEST_CASE("The lamp games draw which colour goes with which mug", "[shell]") {
  // slot_of_color = (2, 0, 1) and green.
  const auto batch = make_running(
      "ShellGameColorLampTouch-VLA-v0",
      pinned({{"mapping", {4}}, {"target_color", {1}}, {"base", {0, 0}}, {"cue_steps", {2}}}));
  check_near(pos(*batch, 3), {0, 0.2, 0.02});
  check_near(pos(*batch, 4), {0, -0.2, 0.02});
  check_near(pos(*batch, 5), {0, 0, 0.02});
  check_near(pos(*batch, 6), {0.25, 0, 0.06});
  CHECK(oracle(*batch) == 0);
  CHECK(*row<float>(batch->output("task_cue"), 0) == 1);
  test::step(*batch, Policy::kZero);
  CHECK(visible(*batch, 3));
  test::step(*batch, Policy::kZero);
  for (int ball = 3; ball < 6; ++ball) {
    CHECK_FALSE(visible(*batch, ball));
    check_near(pos(*batch, ball), {0, 0.2, 1000.02});
  }
  CHECK(batch->state().prop_emission.row(0)[7] == 2.0F);

  for (const char* id :
       {"ShellGameColorLampTouch-VLA-v0", "ShellGameShuffleColorLampTouch-VLA-v0"}) {
    BatchOptions options{.num_envs = 1200};
    for (const bool fixed : {false, true}) {
      if (fixed) options.task_options = {{"fixed_mapping", 1}};
      const auto large = make_running(id, options);
      std::map<std::vector<int>, int> counts;
      for (int i = 0; i < options.num_envs; ++i) {
        const std::uint8_t* slots =
            row<std::uint8_t>(test::memory_of(*large).find("slot_of_color"), i);
        ++counts[{slots[0], slots[1], slots[2]}];
      }
      INFO(id);
      CHECK(counts.size() == (fixed ? 1U : 6U));
      for (const auto& [mapping, count] : counts) {
        if (fixed) CHECK(mapping == std::vector<int>{0, 1, 2});
        if (!fixed) CHECK(std::abs(count - 200) < 65);  // five standard deviations
      }
    }
  }
}

TEST_CASE("What an episode samples covers its ranges", "[shell]") {
  struct Ranges {
    int cue_low, cue_high, shuffle_low, shuffle_high, swaps_low, swaps_high;
  };
  const std::map<std::string, Ranges> table = {
      {"ShellGameTouch-VLA-v0", {1, 5, 0, 0, 0, 0}},
      {"ShellGameShuffleTouch-VLA-v0", {1, 5, 20, 35, 2, 4}},
      {"ShellGameShuffleTouch-Long-VLA-v0", {10, 100, 100, 400, 5, 15}},
      {"ShellGameShuffleColorLampTouch-Long-VLA-v0", {10, 100, 100, 400, 5, 15}}};
  for (const auto& [id, ranges] : table) {
    const BatchOptions options{.num_envs = 3000};
    const auto batch = make_running(id, options);
    INFO(id);
    const auto check = [&](const char* name, int low, int high) {
      std::map<int, int> counts;
      for (int i = 0; i < options.num_envs; ++i) ++counts[memory_int(*batch, name, i)];
      CHECK(counts.begin()->first == low);
      CHECK(counts.rbegin()->first == high);
      CHECK(static_cast<int>(counts.size()) == high - low + 1);
    };
    check("cue_steps", ranges.cue_low, ranges.cue_high);
    if (ranges.shuffle_high == 0) continue;
    check("shuffle_steps", ranges.shuffle_low, ranges.shuffle_high);
    check("num_swaps", ranges.swaps_low, ranges.swaps_high);
    // After the shuffle the answer is uniform.
    std::map<int, int> answers;
    for (int i = 0; i < options.num_envs; ++i) ++answers[oracle(*batch, i)];
    for (const auto& [slot, count] : answers) CHECK(std::abs(count - 1000) < 130);
  }
}

TEST_CASE("Only the short games but Pick freeze the cue, and three end at success", "[shell]") {
  for (const char* id : kShorts) {
    const auto batch = make_env(id);
    INFO(id);
    CHECK(batch->info().frozen_cue == !has(id, "Pick"));
    const bool ends = has(id, "GameTouch") || has(id, "Push") || has(id, "Pick");
    CHECK((batch->info().termination == Termination::kSuccess) == ends);
    CHECK((batch->info().termination == Termination::kNever) == !ends);
  }
  for (const char* id : kLongs) CHECK_FALSE(make_env(id)->info().frozen_cue);
}

// The farthest that a mug strays from all slots once the robot may act. Nothing may succeed.
double farthest_stray(const char* id, bool sleep) {
  const BatchOptions options{.num_envs = 6, .auto_reset = AutoReset::kOff, .sleep = sleep};
  const auto batch = make_running(id, options);
  double farthest = 0;
  for (int t = 1; t <= batch->info().horizon; ++t) {
    test::step(*batch, Policy::kZero);
    for (int i = 0; i < options.num_envs; ++i) {
      CHECK(batch->outputs().success[static_cast<std::size_t>(i)] == 0);
      if (t < memory_int(*batch, "manipulation_start", i)) continue;
      const double* base = row<double>(test::memory_of(*batch).find("base"), i);
      for (int mug = 0; mug < 3; ++mug) {
        double nearest = 1;
        for (int slot = 0; slot < 3; ++slot) {
          const Vector3d stand(base[0], base[1] + (slot - 1) * 0.2, kRest);
          nearest = std::min(nearest, (pos(*batch, mug, i) - stand).norm());
        }
        farthest = std::max(farthest, nearest);
      }
    }
  }
  return farthest;
}

TEST_CASE("Left alone, no mug moves and nothing succeeds", "[shell]") {
  for (const char* id : kShorts) {
    INFO(id);
    CHECK(farthest_stray(id, true) < 1e-12);
    CHECK(farthest_stray(id, false) < 2e-4);  // mugs that are simulated all the time
  }
}

TEST_CASE("Touch asks for phase, distance, stillness and mugs in their places", "[shell]") {
  BatchOptions options = pinned({{"cue_steps", {2}}, {"cup_with_ball_number", {1}}});
  options.substeps = 0;  // everything stays where the test puts it
  options.terminate_on_success = false;
  const auto batch = make_running("ShellGameTouch-VLA-v0", options);
  const State& state = batch->state();
  const Vector3d tcp = Eigen::Map<Vector3d>(state.tcp_pos.row(0));
  const auto result = [&](double distance, double speed, double shove = 0) {
    const Vector3d home = pos(*batch, 2);
    const Vector3d goal = tcp + Vector3d(0, 0, distance);
    std::copy_n(goal.data(), 3, state.prop_pos_of(0, 1));
    state.prop_pos_of(0, 2)[0] += shove;
    state.qvel.row(0)[3] = speed;
    test::step(*batch, Policy::kZero);
    std::copy_n(home.data(), 3, state.prop_pos_of(0, 2));
    return batch->outputs().success[0] != 0;
  };
  const auto remember_here = [&] {  // the displacement of the target does not matter here
    double* reference =
        const_cast<double*>(row<double>(test::memory_of(*batch).find("mug_reference"), 0));
    std::copy_n(tcp.data(), 2, reference + 2);
  };
  CHECK_FALSE(result(0.05, 0));  // still the cue
  CHECK(*row<std::uint8_t>(batch->output("is_obj_placed"), 0) == 1);
  test::step(*batch, Policy::kZero);
  remember_here();
  CHECK(result(0.05, 0));
  CHECK(batch->outputs().reward[0] == 1);
  CHECK(result(0.08 - 1e-12, 0.2));
  CHECK_FALSE(result(0.08 + 1e-9, 0));
  CHECK_FALSE(result(0.05, 0.2001));
  CHECK(result(0.05, 0, 0.05 - 1e-12));
  CHECK_FALSE(result(0.05, 0, 0.05 + 1e-9));
  CHECK(*row<float>(batch->output("mug_max_displacement"), 0) == Approx(0.05));
  CHECK(*row<std::uint8_t>(batch->output("is_mug_displacement_ok"), 0) == 0);
  CHECK(result(0.05, 0));  // back in its place
  CHECK(batch->outputs().terminated[0] == 0);
}

TEST_CASE("The mug has to reach the goal of Push and Pick under the original's rules",
          "[shell][rules]") {
  for (const bool push : {true, false}) {
    BatchOptions options = pinned({{"cue_steps", {1}}, {"cup_with_ball_number", {0}}});
    options.substeps = 0;
    options.rules = Rules::kOriginal;
    const auto batch =
        make_running(push ? "ShellGamePush-VLA-v0" : "ShellGamePick-VLA-v0", options);
    test::step(*batch, Policy::kZero);
    const Vector3d home = pos(*batch, 0);
    const auto result = [&](const Vector3d& moved, double speed = 0) {
      const Vector3d there = home + moved;
      std::copy_n(there.data(), 3, batch->state().prop_pos_of(0, 0));
      batch->state().qvel.row(0)[0] = speed;
      test::step(*batch, Policy::kZero);
      return batch->outputs().success[0] != 0;
    };
    CHECK_FALSE(result({0, 0, 0}));
    if (push) {
      CHECK_FALSE(result({0.0040, 0, 0}));
      CHECK_FALSE(result({0.1960, 0, 0}));
      CHECK_FALSE(result({0.05, 0, 0}, 0.3001));
      CHECK(result({0.0042, 0, 0}, 0.3));
    } else {
      CHECK_FALSE(result({0, 0, 0.0120}));
      CHECK_FALSE(result({0, 0, 0.05}, 0.2001));
      CHECK(result({0, 0, 0.0122}, 0.2));
    }
    CHECK(batch->outputs().terminated[0] == 1);
    // The ball goes with its mug as long as that is low.
    check_near(pos(*batch, 3), {pos(*batch, 0).x(), pos(*batch, 0).y(), 0.02});
  }
}

TEST_CASE("A mug that is lifted leaves its ball behind under the original's rules",
          "[shell][rules]") {
  BatchOptions options = pinned({{"cue_steps", {1}}, {"cup_with_ball_number", {1}}});
  options.substeps = 0;
  options.terminate_on_success = false;
  options.rules = Rules::kOriginal;
  const auto batch = make_running("ShellGamePick-VLA-v0", options);
  test::step(*batch, Policy::kZero);
  const Vector3d home = pos(*batch, 1);
  const auto move = [&](const Vector3d& moved) {
    const Vector3d there = home + moved;
    std::copy_n(there.data(), 3, batch->state().prop_pos_of(0, 1));
    test::step(*batch, Policy::kZero);
    return pos(*batch, 3);
  };
  check_near(move({0.03, 0.01, 0.0499}), home + Vector3d(0.03, 0.01, 0.02 - kRest));
  check_near(move({0.06, 0.02, 0.0501}), home + Vector3d(0.03, 0.01, 0.02 - kRest));
  check_near(move({0.06, 0.02, 0.01}), home + Vector3d(0.06, 0.02, 0.02 - kRest));
}

}  // namespace
}  // namespace engram
