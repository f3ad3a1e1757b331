#include "protocol/eval/policies/scripted_actor.h"

#include <catch2/catch.hpp>

#include "protocol/make/make.h"

namespace engram {
namespace {

std::unique_ptr<Batch> started_batch(int num_envs) {
  MakeOptions options;
  options.num_envs = num_envs;
  options.threads = 1;
  options.auto_reset = AutoReset::kOff;
  std::unique_ptr<Batch> batch = make("RememberColor3-VLA-v0", options);
  batch->reset();
  return batch;
}

TEST_CASE("A scripted actor without latency acts as the policy does", "[evaluation][latency]") {
  const auto batch = started_batch(2);
  ScriptedActor actor(*batch, Policy::kRandom, 0);
  actor.start(0, {});
  actor.start(1, {});
  const std::size_t size = 2 * static_cast<std::size_t>(batch->action_dim());
  std::vector<float> actions(size);
  std::vector<float> expected(size);
  std::vector<std::uint8_t> commanded(2);
  for (int step = 0; step < 3; ++step) {
    ScriptedPolicy(*batch, Policy::kRandom).act(expected);
    actor.act(actions, commanded);
    CHECK(actions == expected);
    CHECK(commanded == std::vector<std::uint8_t>{1, 1});
    batch->step(actions, commanded);
  }
  CHECK(actor.digests(0).observations != actor.digests(1).observations);
}

TEST_CASE("A scripted actor's answers come late", "[evaluation][latency]") {
  const auto batch = started_batch(1);
  ScriptedActor actor(*batch, Policy::kRandom, 2);
  actor.start(0, {});
  const auto dim = static_cast<std::size_t>(batch->action_dim());
  std::vector<float> actions(dim);
  std::vector<float> asked(dim);
  std::vector<float> late(dim);
  std::vector<std::uint8_t> commanded(1);
  for (int step = 0; step < 9; ++step) {
    ScriptedPolicy(*batch, Policy::kRandom).act(asked);
    actor.act(actions, commanded);
    if (step % 3 == 2) {
      CHECK(actions == late);
    } else if (step % 3 == 0) {
      late = asked;
    }
    CHECK(commanded[0] == (step < 2 ? 0 : 1));
    batch->step(actions, commanded);
  }
}

}  // namespace
}  // namespace engram
