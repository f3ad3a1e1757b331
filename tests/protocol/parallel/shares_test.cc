#include "protocol/parallel/shares.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

#include "core/base/error.h"

namespace engram {
namespace {

const std::vector<TaskLoad> kTasks = {{50, 100}, {50, 2160}, {7, 600}, {1, 90}, {13, 90}};

TEST_CASE("Shares: every episode is in one shard", "[shares]") {
  for (const int count : {1, 2, 3, 7, 50, 200}) {
    std::vector<int> next(kTasks.size(), 0);
    for (int number = 1; number <= count; ++number) {
      const auto share = share_of(kTasks, {number, count});
      REQUIRE(share.size() == kTasks.size());
      for (std::size_t i = 0; i < share.size(); ++i) {
        CHECK(share[i].first == next[i]);
        CHECK(share[i].size() >= 0);
        next[i] = share[i].end;
      }
    }
    for (std::size_t i = 0; i < kTasks.size(); ++i) CHECK(next[i] == kTasks[i].episodes);
  }
}

TEST_CASE("Shares: those of all shards are those of each", "[shares]") {
  for (const int count : {1, 3, 50, 200}) {
    const auto all = all_shares(kTasks, count);
    REQUIRE(static_cast<int>(all.size()) == count);
    for (int number = 1; number <= count; ++number) {
      const auto share = share_of(kTasks, {number, count});
      const auto& same = all[static_cast<std::size_t>(number) - 1];
      for (std::size_t i = 0; i < share.size(); ++i) {
        CHECK(same[i].first == share[i].first);
        CHECK(same[i].end == share[i].end);
      }
    }
  }
}

TEST_CASE("Shares: shards take equal time, up to the longest episode", "[shares]") {
  for (const int count : {2, 3, 7, 11, 30}) {
    std::vector<int> steps;
    for (int number = 1; number <= count; ++number) {
      const auto share = share_of(kTasks, {number, count});
      int sum = 0;
      for (std::size_t i = 0; i < share.size(); ++i) sum += share[i].size() * kTasks[i].horizon;
      steps.push_back(sum);
    }
    CHECK(std::ranges::max(steps) - std::ranges::min(steps) <= 2160);
  }
}

TEST_CASE("Shares: the words of a shard", "[shares]") {
  CHECK(parse_shard("--shard", "3/7") == Shard{3, 7});
  CHECK(to_text(Shard{3, 7}) == "3/7");
  for (const char* wrong :
       {"", "3", "0/7", "8/7", "3/", "/7", "3/0", "-1/7", "3/7/9", "3 /7", "1/1000001", "a/b"}) {
    INFO(wrong);
    CHECK_THROWS_WITH(parse_shard("--shard", wrong), Catch::Contains("I/N with I from 1 to N"));
  }
}

}  // namespace
}  // namespace engram
