// What the cue has shown must not be told by any later observation of the objects modes, nor by
// what else a policy is given.
#include <algorithm>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "tests/tasks/leak_check.h"

namespace engram {
namespace {

constexpr int kEpisodes = 4;

// What is given to policies beside their observation, in every step.
constexpr const char* kOpenOutputs[] = {"observation",   "proprio", "reward", "terminated",
                                        "truncated",     "success", "failed", "unstable",
                                        "elapsed_steps", "answered"};

std::unique_ptr<VectorEnv> make_seeing(const std::string& id, std::uint64_t seed,
                                       const std::vector<Pin>& pins) {
  EnvOptions options;
  options.seed = seed;
  options.threads = 1;
  options.auto_reset = AutoReset::kOff;
  options.obs_mode = ObsMode::kObjects;
  options.reward_mode = RewardMode::kSparse;  // dense ones measure the way to the hidden goal
  options.pins = pins;
  auto env = test::make_env(id, options);
  env->reset();
  return env;
}

std::size_t bytes_of(const Field& field) {
  return static_cast<std::size_t>(field.width) * size_of(field.dtype);
}

bool is_alike(const VectorEnv& one, const VectorEnv& other) {
  return std::ranges::all_of(kOpenOutputs, [&](const char* name) {
    if (one.outputs().find(name).field == nullptr) return true;
    const ColumnView a = one.output(name);
    const std::byte* b = other.output(name).row(0);
    return std::equal(a.row(0), a.row(0) + bytes_of(*a.field), b);
  });
}

struct Count {
  int tasks = 0;
  int steps = 0;  // that were compared
  int shown = 0;  // steps in which the cue could be seen in the observation
};

// Until the robot has answered, observations differ in the moments that show the cue alone.
void compare(VectorEnv& one, VectorEnv& other, Policy policy, Count& count) {
  const std::vector<float> rest = test::zeros(one);
  bool cue_over = false;
  while (one.state().finished[0] == 0 && other.state().finished[0] == 0) {
    if (test::has_answered(one) || test::has_answered(other)) return;
    const bool shown = test::shows(one) || test::shows(other);
    cue_over |= !shown;
    if (shown) {
      count.shown += is_alike(one, other) ? 0 : 1;
    } else {
      INFO("step " << one.state().elapsed[0]);
      REQUIRE(is_alike(one, other));
      ++count.steps;
    }
    const bool rests = policy == Policy::kZero || !cue_over;
    const std::vector<float> actions = rests ? rest : test::act(one, policy);
    one.step(actions);
    other.step(actions);
  }
}

void check_all(Policy policy) {
  Count count;
  for (const std::string& id : test::implemented_ids()) {
    const TaskInfo info = make_task(id)->info();
    const std::optional<Draw> draw = test::draw_named(info, info.hidden_draw);
    if (!draw) continue;
    ++count.tasks;
    const int before = count.shown;
    for (std::uint64_t seed = 0; seed < (info.horizon > 300 ? 1 : kEpisodes); ++seed) {
      INFO(id << ", seed " << seed << ", " << name_of(policy));
      const auto one = make_seeing(id, seed, {{draw->name, test::hidden_values(*draw, false)}});
      const auto other = make_seeing(id, seed, {{draw->name, test::hidden_values(*draw, true)}});
      compare(*one, *other, policy, count);
    }
    INFO(id);
    const bool at_a_set_time = make_seeing(id, 0, {})->cue_end(0) < info.horizon;
    if (at_a_set_time) CHECK(count.shown > before);
  }
  CHECK(count.tasks == 97 - 6 - 4 - 1);  // Intercept, Rotate, TakeItBack: below, and leak_test.cc
  CHECK(count.steps > 3000);
}

TEST_CASE("Objects tell nothing after the cue to a robot that rests", "[objects][leak][long]") {
  check_all(Policy::kZero);
}

TEST_CASE("Objects tell nothing after the cue to a robot that moves about",
          "[objects][leak][long]") {
  check_all(Policy::kRandom);
}

TEST_CASE("Objects tell nothing after the cue to a robot that does the task",
          "[objects][leak][long]") {
  check_all(Policy::kSweep);
}

TEST_CASE("A token that told the hidden quantity would be noticed", "[objects][leak]") {
  const auto one = make_seeing("RememberColor3-VLA-v0", 0, {{"target", {0}}});
  const auto other = make_seeing("RememberColor3-VLA-v0", 0, {{"target", {2}}});
  while (test::shows(*one)) {
    test::step(*one, Policy::kZero);
    test::step(*other, Policy::kZero);
  }
  CHECK(is_alike(*one, *other));
  auto* rows = reinterpret_cast<float*>(one->output("observation").row(0));
  rows[one->state_dim() - 1] =
      static_cast<float>(*test::row<std::int32_t>(one->output("oracle_info"), 0) + 0.25);
  CHECK_FALSE(is_alike(*one, *other));
}

// The angle is a cue that policies may see; everything else is the same.
TEST_CASE("Objects of Rotate tell the angle in task_cue alone", "[objects][leak]") {
  for (const std::string& id : test::implemented_ids()) {
    if (id.find("Rotate") != 0) continue;
    const Draw draw = *test::draw_named(make_task(id)->info(), "target_angle");
    const auto one = make_seeing(id, 3, {{draw.name, {draw.low}}});
    const auto other = make_seeing(id, 3, {{draw.name, {draw.high}}});
    for (int t = 0; t < 40; ++t) {
      int differ = 0;
      int offset = 0;
      for (const Field& field : one->state_fields()) {
        for (int i = 0; i < field.width; ++i, ++offset) {
          const auto at = static_cast<std::size_t>(offset);
          if (one->observation()[at] == other->observation()[at]) continue;
          CHECK(field.name == "task_cue");
          ++differ;
        }
      }
      CHECK(differ == 1);
      const std::vector<float> actions = test::act(*one, Policy::kRandom);
      one->step(actions);
      other->step(actions);
    }
  }
}

TEST_CASE("Objects of TakeItBack do not tell the start once the cube is on its target",
          "[objects][leak]") {
  const auto one = make_seeing("TakeItBack-VLA-v0", 0, {});
  const auto other = make_seeing("TakeItBack-VLA-v0", 0, {});
  while (*test::row<std::uint8_t>(one->output("goal_reached_status"), 0) == 0) {
    test::step(*one, Policy::kOracle);
  }
  other->restore(one->save());
  auto* start = reinterpret_cast<double*>(other->memory().find("initial").row(0));
  start[0] = -start[0];
  start[1] = -start[1] - 0.05;
  for (int t = 0; t < 15; ++t) {
    CHECK(std::ranges::equal(one->observation(), other->observation()));
    const std::vector<float> actions = test::act(*one, Policy::kRandom);
    one->step(actions);
    other->step(actions);
  }
}

// The sensors' pictures of a scene with and without a prop differ only where its token is filled.
TEST_CASE("What has no token is in no picture", "[objects][render][long]") {
  for (const std::string& id : test::implemented_ids()) {
    EnvOptions options;
    options.obs_mode = ObsMode::kObjects;
    options.threads = 1;
    const auto env = make(id, options);
    env->reset();
    const std::unique_ptr<Task> task = make_task(id);
    const std::vector<ObjectLook> looks = task->looks();
    const std::uint64_t all = (std::uint64_t{1} << looks.size()) - 1;
    for (int t = 0; t < 30; ++t) {
      const std::uint64_t seen = *test::row<std::uint64_t>(env->memory().find("tokens_seen"), 0);
      const auto bare = make(id, options);
      bare->restore(env->save());
      for (std::size_t prop = 0; prop < looks.size(); ++prop) {
        const bool part = looks[prop].kind == ObjectKind::kPart;
        if ((seen >> prop & 1) != 0 ||
            (part && env->state().status_of(0, static_cast<int>(prop)) != PropStatus::kHidden)) {
          continue;
        }
        bare->state().prop_status.row(0)[prop] = static_cast<std::uint8_t>(PropStatus::kHidden);
      }
      INFO(id << ", step " << t << ", seen " << (seen & all));
      for (const char* sensor : {"base_camera", "hand_camera"}) {
        REQUIRE(test::differing_pixels(*env, *bare, sensor) == 0);
      }
      for (int i = 0; i < 3 && t < 29; ++i) test::step(*env, Policy::kOracle);
    }
  }
}

}  // namespace
}  // namespace engram
