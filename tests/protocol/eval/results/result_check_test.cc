#include "protocol/eval/results/result_check.h"

#include <catch2/catch.hpp>

namespace engram {
namespace {

constexpr const char* kId = "RememberColor3-VLA-v0";

TaskResult result_of(std::uint64_t start_seed, int length) {
  TaskResult result;
  result.entry = &require_entry(kId);
  result.successes = {true, false};
  result.returns = {1, 0};
  result.lengths = {length, length};
  result.seeds = {start_seed, start_seed + 1};
  return result;
}

EvaluationSettings two_episodes() {
  EvaluationSettings settings;
  settings.tasks = {kId};
  settings.episodes = 2;
  return settings;
}

TEST_CASE("A result follows the protocol with its seeds and lengths", "[evaluation][results]") {
  const EvaluationSettings settings = two_episodes();
  const int horizon = require_entry(kId).horizon;
  CHECK(follows_protocol(result_of(settings.start_seed, horizon), settings));
  CHECK_FALSE(follows_protocol(result_of(settings.start_seed + 1, horizon), settings));
  CHECK_FALSE(follows_protocol(result_of(settings.start_seed, horizon + 1), settings));
  CHECK_FALSE(follows_protocol(result_of(settings.start_seed, 0), settings));
  EvaluationSettings longer = settings;
  longer.episodes = 3;
  CHECK_FALSE(follows_protocol(result_of(settings.start_seed, horizon), longer));
}

TEST_CASE("Documents that are no results are refused", "[evaluation][results]") {
  const RegistryEntry& entry = require_entry(kId);
  CHECK_FALSE(parse_result(Json(), entry));
  CHECK_FALSE(parse_result(JsonList{1, 2}, entry));
  CHECK_FALSE(parse_result(JsonTable{{"env_id", kId}}, entry));
}

}  // namespace
}  // namespace engram
