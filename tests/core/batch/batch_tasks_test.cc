#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "core/batch/batch.h"
#include "core/batch/queries.h"
#include "core/batch/scripted_policy.h"
#include "core/batch/snapshot.h"
#include "tasks/family_samples.h"
#include "tests/allocation_counter.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

using Catch::Contains, test::Bytes;

std::vector<std::unique_ptr<Batch>> make_batches(const std::vector<std::string>& ids,
                                                 const BatchOptions& options) {
  std::vector<std::unique_ptr<Batch>> batches;
  for (const std::string& id : ids) batches.push_back(test::make_env(id, options));
  return batches;
}

Batch make_group(const std::vector<std::string>& ids, const BatchOptions& options) {
  return Batch(make_batches(ids, options), options.threads);
}

void act(Batch& group, Policy policy, std::vector<float>& actions) {
  ScriptedPolicy(group, policy).act(actions);
}

std::vector<float> zeros(const Batch& group) {
  return std::vector<float>(static_cast<std::size_t>(group.num_envs()) *
                            static_cast<std::size_t>(group.action_dim()));
}

// Values of one environment in a group's output.
template <class T>
std::span<const T> row(const Batch& group, const char* name, int env) {
  const OutputArray* const array = find_array(group.output_arrays().now(), name);
  REQUIRE(array != nullptr);
  const auto width = static_cast<std::size_t>(array->field.width);
  return {reinterpret_cast<const T*>(array->data) + static_cast<std::size_t>(env) * width, width};
}

// Steps a group and the same batches alone, and compares all that every environment remembers.
void check_equal_to_batches(const std::vector<std::string>& ids, BatchOptions options, int steps) {
  const std::vector<std::unique_ptr<Batch>> alone = make_batches(ids, options);
  options.threads = 3;
  Batch group = make_group(ids, options);
  group.reset();
  for (const auto& batch : alone) batch->reset();
  std::vector<float> actions = zeros(group);
  for (int step = 0; step < steps; ++step) {
    const Policy policy = step % 2 == 0 ? Policy::kOracle : Policy::kRandom;
    act(group, policy, actions);
    group.step(actions);
    for (const auto& batch : alone) test::step(*batch, policy);
  }
  for (int i = 0; i < group.num_parts(); ++i) {
    INFO(group.part(i).info().id);
    CHECK((test::batch_bytes(group.part(i)) ==
           test::batch_bytes(*alone[static_cast<std::size_t>(i)])));
  }
}

TEST_CASE("Environments of a group are what they are alone", "[determinism]") {
  BatchOptions options;
  options.num_envs = 5;
  options.threads = 1;
  options.seed = 7;
  options.auto_reset = GENERATE(AutoReset::kNextStep, AutoReset::kSameStep);
  check_equal_to_batches(one_of_each_family(), options, 40);
}

TEST_CASE("Environments of a group of all tasks are what they are alone", "[determinism][long]") {
  const BatchOptions options{.num_envs = 4, .threads = 1};
  // The halves have control modes of their own.
  std::map<ControlMode, std::vector<std::string>> ids;
  for (const RegistryEntry& entry : registry()) ids[entry.control_mode].emplace_back(entry.id);
  CHECK(ids.size() == 2);
  for (const auto& [mode, alike] : ids) check_equal_to_batches(alike, options, 120);
}

const std::vector<std::string> kThree = {"RememberColor3-VLA-v0", "RotateLenientPos-VLA-v0",
                                         "ShellGameTouch-VLA-v0"};

TEST_CASE("A group's outputs stand in common arrays") {
  const BatchOptions options{.num_envs = 3, .obs_mode = ObsMode::kObjects};
  Batch group = make_group(kThree, options);
  REQUIRE(group.num_envs() == 9);
  group.reset();
  std::vector<float> actions = zeros(group);
  for (int step = 0; step < 10; ++step) {
    act(group, Policy::kRandom, actions);
    group.step(actions);
  }
  const auto& fields = group.output_arrays().row_fields();
  for (int env = 0; env < group.num_envs(); ++env) {
    const auto [part, own] = group.locate(env);
    const Batch& batch = group.part(part);
    CHECK(row<std::int32_t>(group, "task_index", env)[0] == part);
    CHECK(row<float>(group, "reward", env)[0] ==
          batch.outputs().reward[static_cast<std::size_t>(own)]);
    CHECK(row<std::int32_t>(group, "elapsed_steps", env)[0] == 10);
    const auto proprio = row<float>(group, "proprio", env);
    CHECK(std::memcmp(proprio.data(), test::row<float>(batch.output("proprio"), own),
                      proprio.size_bytes()) == 0);

    // Every field of the task's row is in its place; all others are zero.
    std::vector<float> expected(static_cast<std::size_t>(group.state_dim()));
    const float* from = test::row<float>(batch.output("observation"), own);
    for (const Field& field : Queries(batch).state_fields()) {
      std::copy_n(from, field.width, expected.begin() + offset_of(field.name, fields));
      from += field.width;
    }
    CHECK(std::ranges::equal(row<float>(group, "observation", env), expected));

    const auto mask = row<std::uint8_t>(group, "object_mask", env);
    const auto objects =
        std::ranges::count_if(Queries(batch).state_fields(),
                              [](const Field& field) { return field.name.ends_with("_seen"); });
    CHECK(std::ranges::count(mask, 1) == objects);
    CHECK(std::ranges::is_sorted(mask, std::greater<>()));
  }
  // Tokens stand together, behind everything else.
  CHECK(count_tokens(fields) ==
        static_cast<int>(row<std::uint8_t>(group, "object_mask", 0).size()));
  const auto first = std::ranges::find_if(
      fields, [](const RangedField& field) { return field.field.name.starts_with("object_"); });
  CHECK(std::all_of(first, fields.end(), [](const RangedField& field) {
    return field.field.name.starts_with("object_");
  }));
}

// A task whose info "task_cue" is no part of observations.
std::string lamp() {
  for (const std::string& id : test::implemented_ids()) {
    const auto batch = test::make_env(id);
    const ColumnView cue = test::columns_of(*batch).find("task_cue");
    if (cue.field != nullptr && batch->info().task_cue_dim == 0) return id;
  }
  return {};
}

TEST_CASE("A group's outputs are as wide as the widest task's, and of one type") {
  const BatchOptions options{.num_envs = 2};
  // oracle_info: one int, and three floats; task_cue: of Rotate to be seen, of others an info.
  Batch group = make_group(
      {"RememberColor3-VLA-v0", "InterceptSlow-VLA-v0", "RotateLenientPos-VLA-v0", lamp()},
      options);
  group.reset();
  const OutputArray& oracle = *find_array(group.output_arrays().now(), "oracle_info");
  CHECK(oracle.field.dtype == DType::kFloat32);
  const int colour = *test::row<std::int32_t>(group.part(0).output("oracle_info"), 1);
  const auto values = row<float>(group, "oracle_info", 1);
  CHECK(values[0] == static_cast<float>(colour));
  CHECK(std::ranges::all_of(values.subspan(1), [](float value) { return value == 0; }));
  CHECK(group.output_arrays().has(2, "task_cue"));
  CHECK_FALSE(group.output_arrays().has(3, "task_cue"));
  CHECK_FALSE(group.output_arrays().has(0, "task_cue"));
  CHECK(row<float>(group, "task_cue", 4)[0] ==
        *test::row<float>(group.part(2).output("task_cue"), 0));
  CHECK(row<float>(group, "task_cue", 6)[0] == 0);
  CHECK(make_group({lamp()}, options).output_arrays().has(0, "task_cue"));
}

TEST_CASE("Final outputs of a group are those of its batches") {
  const BatchOptions options{.num_envs = 3, .auto_reset = AutoReset::kSameStep};
  Batch group = make_group({"InterceptSlow-VLA-v0", "RememberColor3-VLA-v0"}, options);
  group.reset();
  std::vector<float> actions = zeros(group);
  bool ended = false;
  for (int step = 0; step < 100; ++step) {
    act(group, Policy::kOracle, actions);
    group.step(actions);
    const auto* const finals = reinterpret_cast<const std::uint8_t*>(
        find_array(group.output_arrays().finals(), "success_once")->data);
    for (int env = 0; env < group.num_envs(); ++env) {
      const auto [part, own] = group.locate(env);
      if (group.part(part).outputs().final_mask[static_cast<std::size_t>(own)] == 0) continue;
      ended = true;
      CHECK(row<std::uint8_t>(group, "final_mask", env)[0] == 1);
      CHECK(finals[env] ==
            *test::row<std::uint8_t>(group.part(part).final_output("success_once"), own));
      CHECK(row<std::int32_t>(group, "elapsed_steps", env)[0] == 0);
    }
  }
  CHECK(ended);
}

TEST_CASE("Resets of a group concern the environments that are asked for") {
  const BatchOptions options{.num_envs = 2};
  Batch group = make_group({"RememberColor3-VLA-v0", "ShellGameTouch-VLA-v0"}, options);
  std::vector<float> actions = zeros(group);
  CHECK_THROWS_WITH(group.step(actions), Contains("reset first"));
  const std::vector<std::uint64_t> seeds = {1, 2, 3, 4};
  ResetRequest seeded;
  seeded.seeds = seeds;
  group.reset(seeded);
  group.step(actions);
  const Bytes first = test::batch_bytes(group.part(0));

  // Pins of the second task do not trouble the first.
  const std::vector<std::uint8_t> second = {0, 0, 1, 1};
  const std::vector<Pin> pins = {{group.part(1).info().hidden_variable, {2}}};
  ResetRequest pinned;
  pinned.mask = second;
  pinned.pins = &pins;
  group.reset(pinned);
  CHECK((test::batch_bytes(group.part(0)) == first));
  CHECK(group.part(1).state().elapsed[0] == 0);
  CHECK(group.part(1).state().episode[1] == 1);

  // A refused reset changes nothing.
  const Bytes before = test::batch_bytes(group.part(1));
  const std::vector<Pin> unknown = {{"no_such_draw", {2}}};
  ResetRequest bad;
  bad.pins = &unknown;
  CHECK_THROWS_AS(group.reset(bad), Error);
  ResetRequest shorter;
  shorter.mask = std::span(second).first(3);
  CHECK_THROWS_AS(group.reset(shorter), Error);
  CHECK((test::batch_bytes(group.part(0)) == first));
  CHECK((test::batch_bytes(group.part(1)) == before));
}

TEST_CASE("A group refuses bad actions by the environment's number") {
  const BatchOptions options{
      .num_envs = 2, .auto_reset = AutoReset::kOff, .after_end = AfterEnd::kRefuse};
  Batch group = make_group({"RememberColor3-VLA-v0", "ShellGameTouch-VLA-v0"}, options);
  group.reset();
  std::vector<float> actions = zeros(group);
  actions[3 * 7 + 2] = NAN;
  CHECK_THROWS_WITH(group.step(actions), Contains("environment 3, component 2"));
  CHECK_THROWS_AS(group.step(std::span(actions).first(7)), Error);
  CHECK(group.part(0).state().elapsed[0] == 0);
}

TEST_CASE("A batch of several tasks steps with commands for some environments") {
  BatchOptions options;
  options.num_envs = 2;
  const std::vector<std::string> ids = {"RememberColor3-VLA-v0", "ShellGameTouch-VLA-v0"};
  Batch group = make_group(ids, options);
  const std::vector<std::unique_ptr<Batch>> alone = make_batches(ids, options);
  group.reset();
  std::vector<float> actions = zeros(group);
  const std::vector<std::uint8_t> commanded = {1, 0, 0, 1};
  const std::size_t half = actions.size() / 2;
  for (int step = 0; step < 3; ++step) {
    act(group, Policy::kRandom, actions);
    group.step(actions, commanded);
    for (int i = 0; i < 2; ++i) {
      Batch& single = *alone[static_cast<std::size_t>(i)];
      if (step == 0) single.reset();
      single.step(std::span(actions).subspan(static_cast<std::size_t>(i) * half, half),
                  std::span(commanded).subspan(static_cast<std::size_t>(2 * i), 2));
      CHECK((test::batch_bytes(group.part(i)) == test::batch_bytes(single)));
    }
  }
  CHECK_THROWS_WITH(group.step(actions, std::span(commanded).first(3)),
                    Contains("commanded: 3 values given, 4 needed"));
}

TEST_CASE("Facts and columns of one task are not those of several") {
  BatchOptions options;
  options.num_envs = 2;
  Batch group = make_group({"RememberColor3-VLA-v0", "ShellGameTouch-VLA-v0"}, options);
  CHECK_THROWS_WITH(group.info(), Contains("several tasks, one needed; ask its parts"));
  CHECK_THROWS_AS(group.state(), Error);
  CHECK(group.outputs().reward.size() == 4);
  CHECK_THROWS_WITH(group.locate(4), Contains("environment 4 given, 0 to 3 allowed"));
}

TEST_CASE("A group of no task, or of different modes, is refused") {
  CHECK_THROWS_AS(Batch(std::vector<std::unique_ptr<Batch>>(), 1), Error);
  std::vector<std::unique_ptr<Batch>> batches;
  batches.push_back(test::make_env("RememberColor3-VLA-v0"));
  batches.push_back(
      test::make_env("RememberColor5-VLA-v0", {.control_mode = ControlMode::kPdJointPos}));
  CHECK_THROWS_WITH(Batch(std::move(batches), 1),
                    Contains("pd_joint_pos of RememberColor5-VLA-v0"));
}

TEST_CASE("Steps of a group do not allocate", "[allocation]") {
  BatchOptions options;
  options.num_envs = 8;
  options.threads = 2;
  options.auto_reset = GENERATE(AutoReset::kNextStep, AutoReset::kSameStep);
  Batch group = make_group({"RememberColor3-VLA-v0", "ShellGameTouch-VLA-v0"}, options);
  std::vector<float> own(static_cast<std::size_t>(group.num_envs()));
  std::vector<float> other(own.size());
  group.write_to(std::vector<std::vector<OutputTarget>>{
      {{"reward", own.data(), own.size() * sizeof(float)}},
      {{"reward", other.data(), own.size() * sizeof(float)}}});
  group.reset();
  std::vector<float> actions = zeros(group);
  act(group, Policy::kRandom, actions);
  group.step(actions);
  const std::int64_t before = test::allocation_count();
  for (int step = 0; step < 60; ++step) group.step(actions);
  CHECK(test::allocation_count() == before);
}

TEST_CASE("Outputs are written to arrays of the user's, in turns") {
  const BatchOptions options{.num_envs = 3};
  const bool several = GENERATE(false, true);
  auto group = several ? std::make_unique<Batch>(make_batches(kThree, options), 1)
                       : test::make_env(kThree[0], options);
  const auto count = static_cast<std::size_t>(group->num_envs());
  const auto width = static_cast<std::size_t>(group->state_dim());
  const std::size_t turns = GENERATE(1, 2, 4);
  std::vector<std::vector<float>> rows(turns, std::vector<float>(count * width));
  std::vector<std::vector<float>> rewards(turns, std::vector<float>(count));
  std::vector<std::vector<OutputTarget>> targets;
  for (std::size_t i = 0; i < turns; ++i) {
    targets.push_back({{"observation", rows[i].data(), rows[i].size() * sizeof(float)},
                       {"reward", rewards[i].data(), count * sizeof(float)}});
  }
  group->write_to(targets);
  group->reset();
  CHECK(group->output_arrays().buffer() == 0);
  std::vector<float> actions = zeros(*group);
  for (std::size_t step = 0; step < 10; ++step) {
    act(*group, Policy::kRandom, actions);
    const std::vector<std::vector<float>> before = rows;
    group->step(actions);
    const auto now = static_cast<std::size_t>(group->output_arrays().buffer());
    CHECK(now == (step + 1) % turns);
    for (std::size_t turn = 0; turn < turns; ++turn) {
      if (turn != now) CHECK(rows[turn] == before[turn]);  // still readable
    }
    const OutputArray& own = *find_array(group->output_arrays().now(), "observation");
    CHECK(std::memcmp(rows[now].data(), own.data, count * own.row_bytes()) == 0);
    CHECK(std::memcmp(rewards[now].data(), find_array(group->output_arrays().now(), "reward")->data,
                      count * sizeof(float)) == 0);
  }
}

TEST_CASE("Arrays for outputs are refused where they do not fit") {
  const auto group = test::make_env(kThree[0], {.num_envs = 2});
  std::vector<float> values(2);
  const auto write = [&](const OutputTarget& target) {
    group->write_to(std::vector<std::vector<OutputTarget>>{{target}});
  };
  CHECK_THROWS_WITH(write({"rewards", values.data(), 8}), Contains("no output named 'rewards'"));
  CHECK_THROWS_WITH(write({"reward", values.data(), 4}), Contains("4 bytes given, 8 bytes needed"));
  CHECK_THROWS_WITH(write({"reward", nullptr, 8}), Contains("no address"));
  const std::vector<std::vector<OutputTarget>> different = {{{"reward", values.data(), 8}},
                                                            {{"success", values.data(), 2}}};
  CHECK_THROWS_WITH(group->write_to(different), Contains("the same outputs"));
  CHECK_THROWS_WITH(group->write_to({}), Contains("0 turns"));
  group->reset();
  CHECK_THROWS_WITH(write({"reward", values.data(), 8}), Contains("after the first reset"));
}

TEST_CASE("Groups are saved and restored, whole and one by one") {
  const BatchOptions options{.num_envs = 2};
  Batch group = make_group({"RememberColor3-VLA-v0", "ShellGameTouch-VLA-v0"}, options);
  const Snapshotter snapshots(group);
  group.reset();
  std::vector<float> actions = zeros(group);
  for (int step = 0; step < 5; ++step) group.step(actions);
  const std::vector<std::byte> whole = snapshots.save();
  const std::vector<std::byte> one = snapshots.save(3);
  CHECK(whole.size() == snapshots.save_size());
  CHECK(one.size() == snapshots.save_size(3));
  const Bytes then = test::batch_bytes(group.part(1));

  // One environment goes back to a batch of its own task.
  const auto alone = test::make_running("ShellGameTouch-VLA-v0");
  Snapshotter(*alone).restore(0, one);
  CHECK((test::env_bytes(*alone, 0) == test::env_bytes(group.part(1), 1)));

  Batch other = make_group({"RememberColor3-VLA-v0", "ShellGameTouch-VLA-v0"}, options);
  Snapshotter(other).restore(whole);
  CHECK((test::batch_bytes(other.part(1)) == then));
  CHECK(row<std::int32_t>(other, "elapsed_steps", 3)[0] == 5);

  // Refused without changes.
  group.step(actions);
  const Bytes now = test::batch_bytes(group.part(0));
  std::vector<std::byte> damaged = whole;
  damaged.back() ^= std::byte{1};
  CHECK_THROWS_AS(snapshots.restore(damaged), Error);
  CHECK_THROWS_AS(snapshots.restore(std::span(whole).first(whole.size() - 9)), Error);
  CHECK_THROWS_AS(snapshots.restore(one), Error);
  CHECK_THROWS_AS(snapshots.restore(0, one), Error);  // of another task
  CHECK((test::batch_bytes(group.part(0)) == now));
}

}  // namespace
}  // namespace engram
