#include "apps/interruption.h"

#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <csignal>
#include <string>

#include "core/base/error.h"

namespace engram::apps {
namespace {

TEST_CASE("Without a signal nothing is interrupted", "[apps]") {
  const Interruption interruption(0);
  CHECK_FALSE(interruption.requested());
  CHECK_FALSE(interruption.flag().load());
  interruption.check("unused");
}

TEST_CASE("The first signal is noted", "[apps]") {
  const int signal = GENERATE(SIGINT, SIGTERM, SIGHUP, SIGUSR1);
  const pid_t child = ::fork();
  REQUIRE(child >= 0);
  if (child == 0) {  // exit code 3: noted, and reported with the state
    const Interruption interruption(0);
    std::raise(signal);
    try {
      interruption.check("nothing was written");
    } catch (const Error& error) {
      const std::string text = error.what();
      ::_exit(interruption.requested() && text == "interrupted; nothing was written" ? 3 : 4);
    }
    ::_exit(5);
  }
  int status = 0;
  REQUIRE(::waitpid(child, &status, 0) == child);
  CHECK(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 3);
}

TEST_CASE("The end of a time limit is noted as a signal is", "[apps]") {
  const pid_t child = ::fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    const Interruption interruption(0, 1);
    for (int i = 0; i < 300 && !interruption.requested(); ++i) ::usleep(10'000);
    try {
      interruption.check("saved");
    } catch (const Error& error) {
      ::_exit(error.what() == std::string("interrupted by --time-limit; saved") ? 3 : 4);
    }
    ::_exit(5);
  }
  int status = 0;
  REQUIRE(::waitpid(child, &status, 0) == child);
  CHECK(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 3);
}

TEST_CASE("A hangup that the caller ignores stays ignored", "[apps]") {
  std::signal(SIGHUP, SIG_IGN);
  {
    const Interruption interruption(0);
    std::raise(SIGHUP);
    CHECK_FALSE(interruption.requested());
  }
  CHECK(std::signal(SIGHUP, SIG_DFL) == SIG_IGN);
}

}  // namespace
}  // namespace engram::apps
