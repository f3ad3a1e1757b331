#include "apps/run_control.h"

#include <catch2/catch.hpp>

#include "core/base/error.h"

namespace engram::apps {
namespace {

TEST_CASE("A time limit has seconds, minutes or hours", "[apps]") {
  CHECK(parse_time_limit("90") == 90);
  CHECK(parse_time_limit("90s") == 90);
  CHECK(parse_time_limit("55m") == 55 * 60);
  CHECK(parse_time_limit("2h") == 2 * 3600);
  for (const char* wrong : {"", "m", "0", "0m", "-5m", "1.5h", "5 m", "5d", "99999999h"}) {
    INFO(wrong);
    CHECK_THROWS_WITH(parse_time_limit(wrong),
                      Catch::Contains("seconds (90, 90s), minutes (55m) or hours (2h)"));
  }
}

TEST_CASE("The words of this program begin with its name", "[apps]") {
  const std::vector<std::string> words = words_of_command();
  REQUIRE_FALSE(words.empty());
  CHECK(words.front() == "engram");
}

TEST_CASE("A shard needs a folder", "[apps]") {
  RunControl control;
  CHECK_NOTHROW(require_folder(control, ""));
  control.shard = Shard{1, 2};
  CHECK_NOTHROW(require_folder(control, "out"));
  CHECK_THROWS_WITH(require_folder(control, ""), Catch::Contains("--out DIR needed"));
}

}  // namespace
}  // namespace engram::apps
