#include "protocol/parallel/episode_queue.h"

#include <algorithm>

namespace engram {

void EpisodeQueue::add(int task, const EpisodeRange& episodes) {
  tasks_.push_back(
      {task, episodes.first, std::vector<bool>(static_cast<std::size_t>(episodes.size()), true)});
}

void EpisodeQueue::remove(int task, int episode) {
  const auto found = std::ranges::find(tasks_, task, &Open::task);
  if (found == tasks_.end() || episode < found->first) return;
  const auto place = static_cast<std::size_t>(episode - found->first);
  if (place < found->open.size()) found->open[place] = false;
}

std::optional<EpisodeQueue::Block> EpisodeQueue::next() {
  for (; current_ < tasks_.size(); ++current_) {
    Open& task = tasks_[current_];
    while (task.next < task.open.size() && !task.open[task.next]) ++task.next;
    if (task.next == task.open.size()) continue;
    Block block{task.task, task.first + static_cast<int>(task.next), 0};
    const int in_round = block.first % round_;
    while (task.next < task.open.size() && task.open[task.next] && block.count < size_ &&
           in_round + block.count < round_) {
      task.open[task.next++] = false;
      ++block.count;
    }
    return block;
  }
  return std::nullopt;
}

int EpisodeQueue::size() const {
  int count = 0;
  for (const Open& task : tasks_) {
    count += static_cast<int>(std::ranges::count(task.open, true));
  }
  return count;
}

}  // namespace engram
