#include "protocol/eval/policies/guarded_process.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>
#include <fstream>
#include <thread>

#include "tests/protocol/eval/policies/watched_process.h"
#include "tests/temporary_folder.h"

namespace engram {
namespace {

using test::ends_soon, test::number_in, test::runs;

// A process that hides: in a session of its own, an orphan, deaf to signals that can be ignored.
std::string hidden_child(const std::string& file) {
  return "setsid sh -c 'trap \"\" TERM HUP INT; (sleep 1000 & echo $! >" + file + "; wait) & ' & ";
}

struct Nothing {
  int descriptor = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  ~Nothing() { ::close(descriptor); }
};

}  // namespace

TEST_CASE("A guarded command ends as it would without a guard", "[policy]") {
  const Nothing nothing;
  const auto ending = [&](const std::string& command) {
    const GuardedProcess process(command, nothing.descriptor, nothing.descriptor);
    process.wait(std::chrono::seconds(10));
    return process.ending().value();
  };
  CHECK((ending("exit 7").exited && ending("exit 7").status == 7));
  CHECK(ending("true").status == 0);
  const auto killed = ending("kill -9 $$");
  CHECK_FALSE(killed.exited);
  CHECK(killed.status == SIGKILL);
  CHECK(ending("kill -TERM 0").status == SIGTERM);
  CHECK(ending("/no/such/program").status == 127);
}

TEST_CASE("Nothing outlives a guarded command", "[policy]") {
  const Nothing nothing;
  const test::TemporaryFolder folder;
  const std::string file = (folder.path() / "child").string();
  std::string child;
  {
    const GuardedProcess process(hidden_child(file) + "sleep 1000", nothing.descriptor,
                                 nothing.descriptor);
    child = number_in(file);
    CHECK(runs(child));
    CHECK_FALSE(process.ending());
  }
  CHECK(ends_soon(child));
  std::filesystem::remove(file);
  const GuardedProcess process(
      hidden_child(file) + "while [ ! -s " + file + " ]; do sleep 0.01; done; exit 3",
      nothing.descriptor, nothing.descriptor);
  process.wait(std::chrono::seconds(10));
  CHECK(process.ending().value().status == 3);
  CHECK(ends_soon(number_in(file)));
}

TEST_CASE("Nothing outlives a process that was killed with its guarded commands", "[policy]") {
  const Nothing nothing;
  const test::TemporaryFolder folder;
  const std::string first = (folder.path() / "first").string();
  const std::string second = (folder.path() / "second").string();
  const pid_t parent = ::fork();
  if (parent == 0) {
    // Two of them: the second guard must not keep the first one's lifeline open.
    const GuardedProcess one(hidden_child(first) + "sleep 1000", nothing.descriptor,
                             nothing.descriptor);
    const GuardedProcess two(hidden_child(second) + "sleep 1000", nothing.descriptor,
                             nothing.descriptor);
    for (;;) ::pause();
  }
  const std::string child = number_in(first);
  const std::string other = number_in(second);
  CHECK((runs(child) && runs(other)));
  ::kill(parent, SIGKILL);
  ::waitpid(parent, nullptr, 0);
  CHECK(ends_soon(child));
  CHECK(ends_soon(other));
}

}  // namespace engram
