// Shares of a run: which episodes each of several machines plays.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace engram {

// Shard `number` of `count`, from 1 on.
struct Shard {
  int number = 1;
  int count = 1;

  friend bool operator==(const Shard&, const Shard&) = default;
};

inline constexpr int kMaxShards = 1'000'000;

// "3/7". Throws Error (kInvalidArgument) for anything else. option: for the message.
Shard parse_shard(std::string_view option, const std::string& text);
std::string to_text(const Shard& shard);

// A task of a run: its episodes, all rounds together, and the time that one of them may take.
struct TaskLoad {
  int episodes = 0;
  int horizon = 1;
};

// Episodes first to end - 1 of a task.
struct EpisodeRange {
  int first = 0;
  int end = 0;

  int size() const { return end - first; }
};

// The shard's episodes of each task. All shards together have every episode once, and their
// horizons add up to nearly the same. A function of the loads and of the shard alone.
std::vector<EpisodeRange> share_of(std::span<const TaskLoad> tasks, const Shard& shard);
// The shares of shards 1 to count, in the time of one.
std::vector<std::vector<EpisodeRange>> all_shares(std::span<const TaskLoad> tasks, int count);

}  // namespace engram
