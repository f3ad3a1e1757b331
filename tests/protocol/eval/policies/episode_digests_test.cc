#include "protocol/eval/policies/episode_digests.h"

#include <array>
#include <catch2/catch.hpp>

#include "protocol/io/chained_hash.h"
#include "protocol/make/make.h"

namespace engram {
namespace {

constexpr std::array<float, 7> kProprio = {1, 2, 3, 4, 5, 6, 7};
constexpr std::array<float, 2> kState = {0.5F, -1};
constexpr std::array<float, 4> kActions = {1, 2, 3, 4};

PolicyView view(std::int32_t step, const std::string& instruction = "touch") {
  return {step, instruction, kProprio, {}, kState};
}

TEST_CASE("Digests chain what was seen and answered, as the docs say", "[evaluation][digests]") {
  EpisodeDigests digests;
  digests.add_question(view(3));
  std::uint64_t seen = 0;
  const std::int32_t step = 3;
  seen = chain_hash(seen, std::span(&step, 1));
  seen = chain_hash(seen, std::span<const char>("touch", 5));
  seen = chain_hash(seen, std::span<const float>(kProprio));
  seen = chain_hash(seen, std::span<const float>(kState));
  CHECK(digests.observations == seen);
  CHECK(digests.first_observation == seen);
  digests.add_answer(3, kActions, 2);
  const std::int32_t count = 2;
  std::uint64_t answered = chain_hash(0, std::span(&step, 1));
  answered = chain_hash(answered, std::span(&count, 1));
  answered = chain_hash(answered, std::span<const float>(kActions));
  CHECK(digests.answers == answered);
  CHECK(digests.first_answer == answered);
}

TEST_CASE("Digests tell every part of an episode", "[evaluation][digests]") {
  EpisodeDigests one;
  EpisodeDigests other;
  one.add_question(view(0));
  other.add_question(view(0));
  one.add_answer(0, kActions, 4);
  other.add_answer(0, kActions, 2);  // two actions instead of one
  CHECK(one.first_observation == other.first_observation);
  CHECK(one.first_answer != other.first_answer);
  one.add_question(view(4));
  other.add_question(view(4, "push"));
  CHECK(one.first_observation == other.first_observation);
  CHECK(one.observations != other.observations);
  CHECK(one.observations != one.first_observation);
}

TEST_CASE("A policy's view is the row of its environment", "[evaluation][digests]") {
  MakeOptions options;
  options.num_envs = 2;
  options.threads = 1;
  options.obs_mode = ObsMode::kState;
  const std::unique_ptr<Batch> batch = make("RememberColor3-VLA-v0", options);
  batch->reset();
  const PolicyView second = view_of(*batch, 1);
  CHECK(second.step == 0);
  CHECK_FALSE(second.instruction.empty());
  CHECK(second.proprio.data() == batch->outputs().proprio.data() + 7);
  CHECK(second.state.size() == static_cast<std::size_t>(batch->state_dim()));
  CHECK(second.rgb.empty());
}

}  // namespace
}  // namespace engram
