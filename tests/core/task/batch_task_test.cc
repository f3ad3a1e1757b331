// Batches whose task has rules that are called for many environments at once: the same bits as
// with ranges, whatever the batch is made of.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>

#include "core/base/error.h"
#include "core/batch/batch.h"
#include "core/batch/snapshot.h"
#include "protocol/make/make.h"
#include "render/make_renderer.h"
#include "tests/core/batch/listed_task.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

using Catch::Contains, test::ListedTask;

std::unique_ptr<Batch> listed(const std::string& id, const BatchOptions& options,
                              ListedTask** task = nullptr) {
  auto own = std::make_unique<ListedTask>(make_task(id));
  if (task != nullptr) *task = own.get();
  return std::make_unique<Batch>(std::move(own), options, make_renderer);
}

template <class T>
bool equal(std::span<const T> a, std::span<const T> b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

void check_same(const Batch& one, const Batch& other) {
  REQUIRE(test::batch_bytes(one) == test::batch_bytes(other));
  REQUIRE(equal(one.outputs().final_mask, other.outputs().final_mask));
  REQUIRE(equal(one.outputs().observation, other.outputs().observation));
  REQUIRE(equal(one.images().rgb, other.images().rgb));
  if (one.options().auto_reset != AutoReset::kSameStep) return;
  for (int env = 0; env < one.num_envs(); ++env) {
    if (one.outputs().final_mask[static_cast<std::size_t>(env)] == 0) continue;
    const ColumnView a = one.final_output("reward");
    const ColumnView b = other.final_output("reward");
    REQUIRE(*test::row<float>(a, env) == *test::row<float>(b, env));
  }
  REQUIRE(equal(test::final_images(one).rgb, test::final_images(other).rgb));
}

BatchOptions small_batch() {
  BatchOptions options{.num_envs = 6, .seed = 3};
  options.terminate_on_success = true;  // episodes end at different times
  return options;
}

TEST_CASE("Rules for lists of environments give the same bits as rules for ranges", "[rules]") {
  BatchOptions options = small_batch();
  options.threads = GENERATE(1, 3);
  options.auto_reset = GENERATE(AutoReset::kNextStep, AutoReset::kSameStep, AutoReset::kOff);
  options.obs_mode = GENERATE(ObsMode::kState, ObsMode::kObjects);
  const std::string id = GENERATE("RememberColor3-VLA-v0", "ShellGameTouch-VLA-v0",
                                  "InterceptMedium-VLA-v0", "TakeItBack-VLA-v0");
  CAPTURE(id, options.threads, name_of(options.auto_reset), name_of(options.obs_mode));
  const auto ranges = test::make_env(id, options);
  const auto lists = listed(id, options);
  ranges->reset();
  lists->reset();
  check_same(*ranges, *lists);
  for (int step = 0; step < 70; ++step) {
    const Policy policy = step % 10 == 9 ? Policy::kRandom : Policy::kOracle;
    const std::vector<float> actions = test::act(*ranges, policy);
    REQUIRE(test::act(*lists, policy) == actions);
    ranges->step(actions);
    lists->step(actions);
    check_same(*ranges, *lists);
  }
}

TEST_CASE("Rules for lists of environments draw the same images", "[rules][rgb]") {
  BatchOptions options = small_batch();
  options.threads = 2;
  options.obs_mode = ObsMode::kRgb;
  options.images.width = options.images.height = 32;
  options.auto_reset = GENERATE(AutoReset::kNextStep, AutoReset::kSameStep);
  const auto ranges = make("RememberColor3-VLA-v0", options);
  const auto lists = listed("RememberColor3-VLA-v0", options);
  ranges->reset();
  lists->reset();
  for (int step = 0; step < 40; ++step) {
    const std::vector<float> actions = test::act(*ranges, Policy::kOracle);
    ranges->step(actions);
    lists->step(actions);
    check_same(*ranges, *lists);
  }
}

TEST_CASE("Environments without a command and parts of a batch are treated alike", "[rules]") {
  BatchOptions options = small_batch();
  options.threads = 2;
  options.auto_reset = AutoReset::kOff;
  if (GENERATE(false, true)) {
    options.perturbations = {{PerturbationAxis::kActionDelay, 0.5},
                             {PerturbationAxis::kActionNoise, 0.5},
                             {PerturbationAxis::kStartPose, 1}};
  }
  const auto ranges = test::make_env("RememberColor3-VLA-v0", options);
  const auto lists = listed("RememberColor3-VLA-v0", options);
  ranges->reset();
  lists->reset();
  const std::vector<std::uint8_t> commanded = {1, 1, 0, 1, 0, 0};
  const std::vector<std::uint8_t> mask = {0, 1, 1, 0, 0, 1};
  const std::vector<Pin> pins = {{"target", {2}}};
  for (int step = 0; step < 40; ++step) {
    const std::vector<float> actions = test::act(*ranges, Policy::kOracle);
    REQUIRE(test::act(*lists, Policy::kOracle) == actions);
    for (Batch* batch : {ranges.get(), lists.get()}) {
      if (step % 3 == 0) {
        batch->step(actions, commanded);
      } else if (step % 3 == 1) {
        batch->step(actions);
      } else {
        batch->step_no_action();
      }
      if (step % 15 == 14) batch->reset({.mask = mask, .seeds = {}, .pins = &pins});
    }
    check_same(*ranges, *lists);
  }
}

TEST_CASE("Wrong first answers fail an episode with rules for lists, too", "[rules][strict]") {
  BatchOptions options = small_batch();
  options.task_options = {{"strict", 1}};
  const auto ranges = test::make_env("RememberColor3-VLA-v0", options);
  const auto lists = listed("RememberColor3-VLA-v0", options);
  ranges->reset();
  lists->reset();
  int failed = 0;
  for (int step = 0; step < 60; ++step) {
    const std::vector<float> actions = test::act(*ranges, Policy::kBlind);
    ranges->step(actions);
    lists->step(actions);
    check_same(*ranges, *lists);
    for (int env = 0; env < 6; ++env)
      failed += *test::row<std::uint8_t>(lists->output("failed"), env);
  }
  CHECK(failed > 0);
}

TEST_CASE("Snapshots pass between rules for lists and rules for ranges", "[rules][snapshot]") {
  const BatchOptions options = small_batch();
  const auto ranges = test::make_env("RememberColor3-VLA-v0", options);
  const auto lists = listed("RememberColor3-VLA-v0", options);
  ranges->reset();
  lists->reset();
  for (int step = 0; step < 9; ++step) test::step(*ranges, Policy::kOracle);
  Snapshotter(*lists).restore(Snapshotter(*ranges).save());
  for (int step = 0; step < 20; ++step) {
    const std::vector<float> actions = test::act(*ranges, Policy::kOracle);
    ranges->step(actions);
    lists->step(actions);
    REQUIRE(test::batch_bytes(*ranges) == test::batch_bytes(*lists));
  }
}

TEST_CASE("A group steps tasks of both kinds", "[rules][group]") {
  BatchOptions options = small_batch();
  options.threads = 2;
  const std::vector<std::string> ids = {"RememberColor3-VLA-v0", "TakeItBack-VLA-v0",
                                        "RememberColor5-VLA-v0"};
  std::vector<std::unique_ptr<Batch>> alone;
  std::vector<std::unique_ptr<Batch>> members;
  for (const std::string& id : ids) {
    alone.push_back(test::make_env(id, options));
    members.push_back(id == ids[1] ? listed(id, options) : test::make_env(id, options));
  }
  Batch group(std::move(members), 2);
  group.reset();
  for (const auto& batch : alone) batch->reset();
  std::vector<float> actions(static_cast<std::size_t>(group.num_envs() * group.action_dim()));
  for (int step = 0; step < 40; ++step) {
    ScriptedPolicy(group, Policy::kOracle).act(actions);
    group.step(actions);
    for (std::size_t i = 0; i < alone.size(); ++i) {
      test::step(*alone[i], Policy::kOracle);
      REQUIRE(test::batch_bytes(*alone[i]) == test::batch_bytes(group.part(static_cast<int>(i))));
    }
  }
}

TEST_CASE("After rules that fail, a batch has to be reset as a whole", "[rules][errors]") {
  using Failure = ListedTask::Failure;
  const Failure failure = GENERATE(Failure::kBeforePhysics, Failure::kAdvance, Failure::kEvaluate,
                                   Failure::kReward, Failure::kReset);
  ListedTask* task = nullptr;
  BatchOptions options = small_batch();
  options.threads = 2;
  options.auto_reset = AutoReset::kSameStep;
  const auto batch = listed("RememberColor3-VLA-v0", options, &task);
  batch->reset();
  for (int step = 0; step < 3; ++step) test::step(*batch, Policy::kOracle);
  const std::vector<float> actions = test::act(*batch, Policy::kOracle);
  task->fail_in(failure);
  if (failure == Failure::kReset) {
    CHECK_THROWS_WITH(batch->reset(), "rules that fail");
  } else {
    CHECK_THROWS_WITH(batch->step(actions), "rules that fail");
  }
  CHECK_THROWS_WITH(batch->step(actions), Contains("reset all environments first"));
  CHECK_THROWS_WITH(Snapshotter(*batch).save(0), Contains("reset all environments first"));
  const std::vector<std::uint8_t> some = {1, 0, 1, 1, 1, 1};
  CHECK_THROWS_WITH(batch->reset({.mask = some, .seeds = {}}), Contains("this one must reset all"));
  const std::vector<std::uint64_t> seeds = {7, 8, 9, 10, 11, 12};
  batch->reset({.mask = {}, .seeds = seeds});
  const auto fresh = listed("RememberColor3-VLA-v0", options);
  fresh->reset({.mask = {}, .seeds = seeds});
  for (int step = 0; step < 10; ++step) {
    test::step(*batch, Policy::kOracle);
    test::step(*fresh, Policy::kOracle);
  }
  CHECK(test::batch_bytes(*batch) == test::batch_bytes(*fresh));
}

}  // namespace
}  // namespace engram
