#include "apps/task_files.h"

#include <catch2/catch.hpp>

#include "apps/message_socket.h"

namespace engram::apps {
namespace {

using Words = std::vector<std::string>;

TEST_CASE("An id behind a Python file loads the file", "[apps][own_tasks]") {
  CHECK(with_task_files({"eval", "my/tasks.py:LampOrder-v0", "--json"}) ==
        Words{"--tasks=my/tasks.py", "eval", "LampOrder-v0", "--json"});
  CHECK(with_task_files({"eval", "a.py:A-v0", "a.py:B-v0", "b.py:C-v1"}) ==
        Words{"--tasks=a.py", "--tasks=b.py", "eval", "A-v0", "B-v0", "C-v1"});
}

TEST_CASE("Other words of a command line stay", "[apps][own_tasks]") {
  for (const Words& words :
       {Words{"eval", "LampOrder-v0"}, Words{"--policy-command", "a b.py"}, Words{"tasks.py:"},
        Words{"--loader", "mine.py:Mine.load"}, Words{"no.py:f-v"}, Words{"tasks.txt:LampOrder-v0"},
        Words{"--out=tasks.py:LampOrder-v0"}, Words{"x.py:two words"},
        Words{"check", "tasks.py:LampOrder-v0"},
        Words{"--tasks", "a.so", "check", "tasks.py:LampOrder-v0"}}) {
    CHECK(with_task_files(words) == words);
  }
}

TEST_CASE("Messages pass a socket whole, until the other end is gone", "[apps][own_tasks]") {
  auto [one, end] = MessageSocket::pair();
  MessageSocket other(std::move(end));
  const std::string long_message(100'000, 'x');
  REQUIRE(one.send(""));
  REQUIRE(one.send(long_message));
  CHECK(other.receive() == std::optional<std::string>(""));
  CHECK(other.receive() == std::optional<std::string>(long_message));
  one = MessageSocket();
  CHECK_FALSE(other.receive().has_value());
  CHECK_FALSE(other.send("more"));
}

}  // namespace
}  // namespace engram::apps
