// Policies from outside: what they see, and that chunks are queues of their episode.
#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include <vector>

#include "protocol/eval/policies/policy_process.h"
#include "protocol/eval/run/evaluate.h"
#include "protocol/make/episodes.h"

namespace engram {
namespace {

constexpr const char* kId = "RememberColor3-VLA-v0";

// Answers with chunks of some length and keeps books.
class Recorder final : public ExternalPolicy {
 public:
  explicit Recorder(int chunk) : chunk_(chunk) {}

  void act(const PolicyRequest& request, PolicyReply& reply) override {
    for (int row = 0; row < request.count; ++row) {
      const auto i = static_cast<std::size_t>(row);
      asked.push_back(
          {request.episodes[i], request.steps[i], request.first[i] != 0, request.slots[i]});
      CHECK(!request.instructions[i].empty());
      std::vector<float> actions(static_cast<std::size_t>(chunk_) * 7);
      for (std::size_t k = 0; k < actions.size(); ++k) {
        actions[k] = static_cast<float>((k + i) % 5) / 10;
      }
      const std::int64_t shape[] = {1, chunk_, 7};
      reply.set(row, actions, shape);
    }
    proprio_size = request.proprio.size() / static_cast<std::size_t>(request.count);
    rgb_size = request.rgb.size() / static_cast<std::size_t>(request.count);
    state_size = request.state.size() / static_cast<std::size_t>(request.count);
    CHECK(request.env_id == kId);
    CHECK(request.max_slots == 2);
  }

  struct Question {
    int episode;
    int step;
    bool first;
    int env;
  };
  std::vector<Question> asked;
  std::size_t proprio_size = 0;
  std::size_t rgb_size = 0;
  std::size_t state_size = 0;

 private:
  int chunk_;
};

TaskResult evaluate_with(ExternalPolicy& policy, ObsMode obs_mode, int num_envs,
                         const Protocol& further = {}) {
  class Reference final : public ExternalPolicy {
   public:
    explicit Reference(ExternalPolicy& to) : to_(to) {}
    void act(const PolicyRequest& request, PolicyReply& reply) override { to_.act(request, reply); }

   private:
    ExternalPolicy& to_;
  };
  Protocol protocol = further;
  protocol.external = [&policy](const WorkContext&) { return std::make_unique<Reference>(policy); };
  protocol.episodes = 3;
  protocol.num_envs = num_envs;
  protocol.threads = 1;
  protocol.environment.obs_mode = obs_mode;
  Ranks alone;
  std::vector<TaskResult> results;
  evaluate(alone, {&require_entry(kId)}, protocol,
           {.finished = [&results](TaskResult result) { results.push_back(std::move(result)); },
            .tick = {}});
  REQUIRE(results.size() == 1);
  return results[0];
}

}  // namespace

TEST_CASE("External policy: asked when the queue is empty, once per chunk", "[policy]") {
  Recorder policy(4);
  const TaskResult result = evaluate_with(policy, ObsMode::kRgb, 2);
  CHECK(result.chunk_size == 4);
  CHECK(result.lengths == std::vector<int>{25, 25, 25});
  // 25 steps in chunks of 4: seven requests for each of three episodes, the leftovers dropped.
  CHECK(policy.asked.size() == 21);
  std::vector<int> next_step(3, 0);
  for (const auto& question : policy.asked) {
    int& expected = next_step.at(static_cast<std::size_t>(question.episode));
    CHECK(question.step == expected);
    CHECK(question.first == (expected == 0));
    CHECK((question.env == 0 || question.env == 1));
    expected += 4;
  }
  CHECK(policy.proprio_size == 7);
  CHECK(policy.rgb_size == 128 * 128 * 6);
  CHECK(policy.state_size == 0);
}

TEST_CASE("External policy: the state only if requested", "[policy]") {
  Recorder policy(1);
  const TaskResult result = evaluate_with(policy, ObsMode::kState, 2);
  CHECK(result.chunk_size == 1);
  CHECK(policy.asked.size() == 75);
  CHECK(policy.rgb_size == 0);
  CHECK(policy.state_size > 25);
}

TEST_CASE("External policy: objects, as a batch of them observes", "[policy][objects]") {
  Recorder policy(1);
  evaluate_with(policy, ObsMode::kObjects, 2);
  CHECK(policy.asked.size() == 75);
  CHECK(policy.rgb_size == 0);
  BatchOptions options;
  options.obs_mode = ObsMode::kObjects;
  CHECK(policy.state_size == static_cast<std::size_t>(make(kId, options)->state_dim()));
}

TEST_CASE("External policy: shapes and values of an answer", "[policy]") {
  PolicyReply reply(2, 7);
  const std::vector<float> actions(21, 0.5F);
  const auto set = [&reply](std::vector<float> values, std::vector<std::int64_t> shape,
                            int row = 0) { reply.set(row, values, shape); };
  set({actions.begin(), actions.begin() + 7}, {7});
  CHECK(reply.chunk(0).size() == 7);
  set(actions, {3, 7});
  CHECK(reply.chunk(0).size() == 21);
  set(actions, {1, 3, 7});
  CHECK(reply.chunk(0).size() == 21);
  using Catch::Contains;
  CHECK_THROWS_WITH(set({}, {0, 7}), Contains("empty chunk"));
  CHECK_THROWS_WITH(set({}, {1, 0, 7}), Contains("empty chunk"));
  CHECK_THROWS_WITH(set({}, {0}), Contains("shape (0)"));
  CHECK_THROWS_WITH(set(actions, {21}), Contains("(21) given, (7), (K, 7) or (1, K, 7) allowed"));
  CHECK_THROWS_WITH(set(actions, {7, 3}), Contains("(7, 3)"));
  CHECK_THROWS_WITH(set(actions, {3, 1, 7}), Contains("(3, 1, 7)"));
  CHECK_THROWS_WITH(set(actions, {2, 7}), Contains("21 numbers"));
  CHECK_THROWS_WITH(set(actions, {3, 7}, 2), Contains("row 2"));
  std::vector<float> bad = actions;
  bad[9] = NAN;
  CHECK_THROWS_WITH(set(bad, {3, 7}), Contains("component 2 of action 1"));
  CHECK(reply.chunk(0).size() == 21);
  CHECK_THROWS_WITH(reply.chunk(1), Contains("no actions given for row 1"));
}

TEST_CASE("External policy: actions are those of the chunk, in order", "[policy]") {
  // Known actions, by hand, in a batch of one.
  class Known final : public ExternalPolicy {
   public:
    void act(const PolicyRequest& request, PolicyReply& reply) override {
      for (int row = 0; row < request.count; ++row) {
        std::vector<float> actions(5 * 7);
        for (int k = 0; k < 5; ++k) {
          actions[static_cast<std::size_t>(k) * 7] =
              0.01F * static_cast<float>(request.steps[static_cast<std::size_t>(row)] + k);
        }
        const std::int64_t shape[] = {5, 7};
        reply.set(row, actions, shape);
      }
    }
  };
  Known policy;
  const TaskResult result = evaluate_with(policy, ObsMode::kState, 2);
  BatchOptions options;
  options.auto_reset = AutoReset::kOff;
  const auto batch = make(kId, options);
  for (std::size_t episode = 0; episode < 3; ++episode) {
    const std::uint64_t seed = 4242424242 + episode;
    batch->reset({.mask = {}, .seeds = {&seed, 1}, .pins = nullptr});
    std::vector<float> action(7);
    for (int step = 0; step < 25; ++step) {
      action[0] = 0.01F * static_cast<float>(step);
      batch->step(action);
    }
    const double expected =
        *reinterpret_cast<const double*>(batch->output("episode_return").row(0));
    CHECK(result.returns[episode] == expected);
  }
}

namespace {

// Bytes of a process before it ends.
void hear(const std::vector<std::uint32_t>& words, const char* expected) {
  int ends[2];
  REQUIRE(::pipe2(ends, O_CLOEXEC) == 0);
  const auto size = static_cast<ssize_t>(words.size() * sizeof(std::uint32_t));
  REQUIRE(::write(ends[1], words.data(), static_cast<std::size_t>(size)) == size);
  ::close(ends[1]);
  const std::atomic<bool> stopped = false;
  std::atomic<std::uint64_t> steps = 0;
  const WorkContext context(0, stopped, steps);
  const int to = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  PolicyProcessOptions options;
  options.command = "x";
  CHECK_THROWS_WITH(PolicyProcess(to, ends[0], options, context), Catch::Contains(expected));
}

TEST_CASE("A policy that ends or breaks the protocol is reported", "[policy]") {
  hear({}, "closed its standard input or output");
  hear({1}, "closed its standard input or output");
  hear({1, 8, 0x4d474e45}, "closed its standard input or output");
  hear({1, 8, 0x4d474e45, 2}, "version 1");
  hear({7, 0}, "message type 7 of 0 bytes");
  hear({1, 1U << 28}, "closed its standard input or output");  // announces what does not come
  hear({1, (1U << 28) + 1}, "bytes, type 1 expected");
}

TEST_CASE("External policy: with latency, asked again when its answer has been used up",
          "[policy][latency]") {
  Recorder policy(4);
  Protocol protocol;
  protocol.latency = 3;
  const TaskResult result = evaluate_with(policy, ObsMode::kState, 2, protocol);
  // 25 steps in turns of three of waiting and four of acting.
  std::vector<int> next_step(3, 0);
  for (const auto& question : policy.asked) {
    int& expected = next_step.at(static_cast<std::size_t>(question.episode));
    CHECK(question.step == expected);
    expected += 7;
  }
  CHECK(policy.asked.size() == 12);
  Recorder prompt(4);
  CHECK(evaluate_with(prompt, ObsMode::kState, 2).returns != result.returns);
}

TEST_CASE("External policy: rounds have seeds of their own, digests do not depend on batches",
          "[policy][digests]") {
  class Seeded final : public ExternalPolicy {
   public:
    void act(const PolicyRequest& request, PolicyReply& reply) override {
      seeds.insert(request.policy_seed);
      for (int row = 0; row < request.count; ++row) {
        std::vector<float> action(7);
        action[0] = request.policy_seed == 5 ? 0.5F : -0.5F;
        const std::int64_t shape[] = {7};
        reply.set(row, action, shape);
      }
    }
    std::set<std::uint64_t> seeds;
  };
  Protocol protocol;
  protocol.repeat = 2;
  protocol.policy_seed = 5;
  const auto evaluate_in = [&](int num_envs) {
    Seeded policy;
    TaskResult result = evaluate_with(policy, ObsMode::kState, num_envs, protocol);
    CHECK(policy.seeds == std::set<std::uint64_t>{5, 6});
    return result;
  };
  const TaskResult result = evaluate_in(2);
  REQUIRE(result.digests.size() == 6);
  CHECK(result.seeds[3] == result.seeds[0]);
  // An equal episode, another answer.
  CHECK(result.digests[3].first_observation == result.digests[0].first_observation);
  CHECK(result.digests[3].first_answer != result.digests[0].first_answer);
  CHECK(result.digests[3].observations != result.digests[0].observations);
  CHECK(result.digests[1].first_observation != result.digests[0].first_observation);
  const TaskResult single = evaluate_in(1);
  for (std::size_t i = 0; i < 6; ++i) {
    CHECK(single.digests[i].observations == result.digests[i].observations);
    CHECK(single.digests[i].answers == result.digests[i].answers);
  }
  CHECK(single.returns == result.returns);
}

}  // namespace
}  // namespace engram
