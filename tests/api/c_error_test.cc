// How exceptions become statuses and messages.
#include "api/c_error.h"

#include <catch2/catch.hpp>
#include <new>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "core/base/error.h"

namespace engram {
namespace {

template <class E>
engram_status status_of(const E& error) {
  return c::guarded([&error] { throw error; });
}

TEST_CASE("Each kind of error has a status", "[c_api]") {
  const std::vector<std::pair<Error::Kind, engram_status>> kinds = {
      {Error::kInvalidArgument, ENGRAM_INVALID_ARGUMENT},
      {Error::kUnknownId, ENGRAM_UNKNOWN_ID},
      {Error::kUnavailable, ENGRAM_UNAVAILABLE},
      {Error::kBadState, ENGRAM_BAD_STATE},
      {Error::kIo, ENGRAM_IO},
      {Error::kInternal, ENGRAM_INTERNAL},
      {Error::kTaskFailed, ENGRAM_TASK_FAILED}};
  for (const auto& [kind, status] : kinds) {
    CHECK(status_of(Error(kind, "what was wrong")) == status);
    CHECK(engram_last_error() == std::string("what was wrong"));
  }
}

TEST_CASE("Exceptions of the standard library do not cross either", "[c_api]") {
  CHECK(status_of(std::bad_alloc()) == ENGRAM_UNAVAILABLE);
  CHECK(engram_last_error() == std::string("out of memory"));
  CHECK(status_of(std::system_error(std::make_error_code(
            std::errc::resource_unavailable_try_again))) == ENGRAM_UNAVAILABLE);
  CHECK(status_of(std::logic_error("oops")) == ENGRAM_INTERNAL);
  CHECK(engram_last_error() == std::string("oops"));
  CHECK(status_of(42) == ENGRAM_INTERNAL);
}

TEST_CASE("Messages belong to their thread and stay until its next failure", "[c_api]") {
  c::fail(ENGRAM_IO, "of this thread");
  std::string elsewhere = "not asked yet";
  std::thread([&elsewhere] {
    elsewhere = engram_last_error();
    c::fail(ENGRAM_IO, "of another thread");
  }).join();
  CHECK(elsewhere.empty());
  CHECK(c::guarded([] {}) == ENGRAM_OK);
  CHECK(engram_last_error() == std::string("of this thread"));
}

TEST_CASE("Messages move no cursor and reverse no letters", "[c_api]") {
  c::fail(ENGRAM_IO, "a\x9b[2J \u202eb \u00fc \xe2\x82");
  CHECK(engram_last_error() == std::string("a?[2J ???b \u00fc ??"));
}

TEST_CASE("Messages are one line of bounded length", "[c_api]") {
  c::fail(ENGRAM_IO, "two\nlines");
  CHECK(engram_last_error() == std::string("two?lines"));
  c::fail(ENGRAM_IO, std::string(100'000, 'x'));
  CHECK(std::string(engram_last_error()).size() == 4095);
}

}  // namespace
}  // namespace engram
