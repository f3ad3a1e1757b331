#include "protocol/parallel/shares.h"

#include <algorithm>
#include <charconv>
#include <numeric>
#include <optional>

#include "core/base/error.h"

namespace engram {
namespace {

std::optional<int> number_in(std::string_view digits) {
  int value = 0;
  const char* const end = digits.data() + digits.size();
  const auto [rest, error] = std::from_chars(digits.data(), end, value);
  if (digits.empty() || error != std::errc() || rest != end || value < 1) return std::nullopt;
  return value;
}

// Passes the sizes of all shards to each(task, sizes). Each shard has the same number of episodes
// of each task, give or take one: tasks differ in how early their episodes end. Those left over go
// to the shards with the least to do, the longest first. Episodes of a shard follow one another, so
// that they are played in one batch.
template <class F>
void cut_tasks(std::span<const TaskLoad> tasks, int count, F&& each) {
  const auto shards = static_cast<std::size_t>(count);
  std::vector<std::size_t> order(tasks.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(
      order, [&](std::size_t a, std::size_t b) { return tasks[a].horizon > tasks[b].horizon; });
  std::vector<std::int64_t> steps(shards, 0);  // of episodes left over, by shard
  std::vector<std::size_t> least(shards);
  std::iota(least.begin(), least.end(), std::size_t{0});
  for (const std::size_t task : order) {
    const auto left = static_cast<std::ptrdiff_t>(tasks[task].episodes % count);
    std::ranges::stable_sort(least, {}, [&](std::size_t i) { return std::pair(steps[i], i); });
    std::vector<int> sizes(shards, tasks[task].episodes / count);
    for (std::ptrdiff_t i = 0; i < left; ++i) {
      const std::size_t chosen = least[static_cast<std::size_t>(i)];
      ++sizes[chosen];
      steps[chosen] += tasks[task].horizon;
    }
    each(task, sizes);
  }
}

}  // namespace

Shard parse_shard(std::string_view option, const std::string& text) {
  const std::string_view whole(text);
  const std::size_t slash = std::min(whole.find('/'), whole.size());
  const std::optional<int> number = number_in(whole.substr(0, slash));
  const std::optional<int> count = number_in(whole.substr(std::min(slash + 1, whole.size())));
  if (!number || !count || *number > *count || *count > kMaxShards) {
    throw Error(Error::kInvalidArgument, std::string(option) + ": '" + text +
                                             "' given, I/N with I from 1 to N, such as 3/7, and "
                                             "N up to " +
                                             std::to_string(kMaxShards) + " allowed");
  }
  return {*number, *count};
}

std::string to_text(const Shard& shard) {
  return std::to_string(shard.number) + "/" + std::to_string(shard.count);
}

std::vector<EpisodeRange> share_of(std::span<const TaskLoad> tasks, const Shard& shard) {
  std::vector<EpisodeRange> share(tasks.size());
  const auto own = static_cast<std::ptrdiff_t>(shard.number) - 1;
  cut_tasks(tasks, shard.count, [&](std::size_t task, const std::vector<int>& sizes) {
    share[task].first = std::accumulate(sizes.begin(), sizes.begin() + own, 0);
    share[task].end = share[task].first + sizes[static_cast<std::size_t>(own)];
  });
  return share;
}

std::vector<std::vector<EpisodeRange>> all_shares(std::span<const TaskLoad> tasks, int count) {
  std::vector<std::vector<EpisodeRange>> shares(static_cast<std::size_t>(count),
                                                std::vector<EpisodeRange>(tasks.size()));
  cut_tasks(tasks, count, [&](std::size_t task, const std::vector<int>& sizes) {
    int first = 0;
    for (std::size_t i = 0; i < sizes.size(); ++i) {
      shares[i][task] = {first, first + sizes[i]};
      first += sizes[i];
    }
  });
  return shares;
}

}  // namespace engram
