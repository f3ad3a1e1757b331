#include "protocol/parallel/episode_queue.h"

#include <catch2/catch.hpp>
#include <string>

namespace engram {
namespace {

// "task:first+count ..."
std::string rest_of(EpisodeQueue& queue) {
  std::string text;
  while (const auto block = queue.next()) {
    text += std::to_string(block->task) + ":" + std::to_string(block->first) + "+" +
            std::to_string(block->count) + " ";
  }
  return text;
}

TEST_CASE("Episode queue: blocks of consecutive episodes, task by task", "[work]") {
  EpisodeQueue queue(4, 100);
  queue.add(9, {0, 6});
  queue.add(2, {10, 13});
  queue.add(5, {3, 3});
  CHECK(queue.size() == 9);
  CHECK(rest_of(queue) == "9:0+4 9:4+2 2:10+3 ");
  CHECK(queue.size() == 0);
}

TEST_CASE("Episode queue: a block stays within a round", "[work]") {
  EpisodeQueue queue(8, 5);
  queue.add(0, {3, 12});
  CHECK(rest_of(queue) == "0:3+2 0:5+5 0:10+2 ");
}

TEST_CASE("Episode queue: episodes that are there are left out", "[work]") {
  EpisodeQueue queue(8, 100);
  queue.add(0, {0, 8});
  queue.add(1, {4, 6});
  for (const int episode : {0, 3, 7, 9, -1}) queue.remove(0, episode);
  for (const int episode : {3, 4, 5}) queue.remove(1, episode);
  queue.remove(8, 0);
  CHECK(queue.size() == 5);
  CHECK(rest_of(queue) == "0:1+2 0:4+3 ");
}

}  // namespace
}  // namespace engram
