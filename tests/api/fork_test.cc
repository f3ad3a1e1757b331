// A process that was forked has a batch's memory, but none of its threads.
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <functional>

#include "tests/api/c_api_fixture.h"

namespace engram {
namespace {

using test::BatchHandle, test::make_running;

// Whether f holds in a forked process.
bool in_child(const std::function<bool()>& f) {
  const pid_t child = ::fork();
  if (child == 0) {
    ::alarm(60);  // ends a process that hangs
    ::_exit(f() ? 0 : 1);
  }
  int status = 0;
  REQUIRE(::waitpid(child, &status, 0) == child);
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

bool is_told(engram_status status) {
  const std::string message = engram_last_error();
  return status == ENGRAM_BAD_STATE && message.find("do not survive a fork") != std::string::npos &&
         message.find("process " + std::to_string(::getppid())) != std::string::npos;
}

TEST_CASE("A forked process learns that the batch is not its own", "[c_api]") {
  const BatchHandle batch = make_running();
  engram_env* env = batch.get();
  std::vector<float> actions(test::action_count(batch));
  std::array<std::uint8_t, 12> bytes{};
  std::size_t size = 0;
  const std::function<engram_status()> calls[] = {
      [&] { return engram_step(env, actions.data(), actions.size()); },
      [&] { return engram_step_no_action(env); },
      [&] { return engram_step_async(env, actions.data(), actions.size()); },
      [&] { return engram_step_wait(env); },
      [&] { return engram_reset(env, nullptr); },
      [&] { return engram_act(env, ENGRAM_POLICY_ZERO, actions.data(), actions.size()); },
      [&] { return engram_save(env, 0, nullptr, 0, &size); },
      [&] { return engram_render(env, 0, "base_camera", 2, 2, bytes.data(), bytes.size()); },
  };
  for (const auto& call : calls) CHECK(in_child([&call] { return is_told(call()); }));
  CHECK(in_child([env] { return engram_describe_json(env) == nullptr; }));
  // Facts can be read, the handle let go, and a batch of its own made.
  CHECK(in_child([env] {
    const bool known = engram_num_envs(env) == 4;
    engram_close(env);
    return known;
  }));
  // The parent's batch is as it was.
  CHECK(engram_step(env, actions.data(), actions.size()) == ENGRAM_OK);
}

TEST_CASE("A forked process learns it while a step is under way in the parent", "[c_api]") {
  const BatchHandle batch = make_running();
  const std::vector<float> actions(test::action_count(batch));
  REQUIRE(engram_step_async(batch.get(), actions.data(), actions.size()) == ENGRAM_OK);
  CHECK(in_child([&] { return is_told(engram_step_wait(batch.get())); }));
  CHECK(engram_step_wait(batch.get()) == ENGRAM_OK);
}

}  // namespace
}  // namespace engram
