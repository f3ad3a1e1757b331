// Episodes that are still to be played, task by task.
#pragma once

#include <optional>
#include <vector>

#include "protocol/parallel/shares.h"

namespace engram {

class EpisodeQueue {
 public:
  // Consecutive episodes of a task.
  struct Block {
    int task = 0;
    int first = 0;
    int count = 0;
  };

  // size: of a block, at most; round: blocks do not go beyond its multiples.
  EpisodeQueue(int size, int round) : size_(size), round_(round) {}

  // Behind the others. task: a number of its own.
  void add(int task, const EpisodeRange& episodes);
  // An episode that is there already.
  void remove(int task, int episode);

  // The next block, which is then no longer in the queue.
  std::optional<Block> next();
  // Episodes that have not been taken.
  int size() const;

 private:
  struct Open {
    int task = 0;
    int first = 0;  // episode of open[0]
    std::vector<bool> open;
    std::size_t next = 0;  // the first that may be open
  };

  int size_;
  int round_;
  std::vector<Open> tasks_;
  std::size_t current_ = 0;  // among tasks_
};

}  // namespace engram
