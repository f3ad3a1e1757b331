#include "apps/options.h"

#include <catch2/catch.hpp>
#include <cmath>

namespace engram::apps {
namespace {

TEST_CASE("Whole numbers are parsed within their range", "[apps][options]") {
  CHECK(parse_int("--n", "12", 0, 20) == 12);
  CHECK(parse_int("--n", "+3", 0, 20) == 3);
  CHECK(parse_unsigned("--n", "18446744073709551615", 0, UINT64_MAX) == UINT64_MAX);
  for (const char* text : {"21", "-1", "1.5", "1e1", "", " 1", "+-1", "x"}) {
    INFO(text);
    CHECK_THROWS_WITH(parse_int("--n", text, 0, 20),
                      Catch::Contains("--n") && Catch::Contains("0 to 20"));
  }
}

TEST_CASE("Pins have one or more numbers", "[apps][options]") {
  const Pin pin = parse_pin("positions=0.1,-0.2");
  CHECK(pin.name == "positions");
  CHECK(pin.values == std::vector<double>{0.1, -0.2});
  for (const char* text : {"target", "=1", "target=", "target=a", "target=1,"}) {
    INFO(text);
    CHECK_THROWS_WITH(parse_pin(text), Catch::Contains("NAME=NUMBER"));
  }
}

TEST_CASE("Constants are numbers or lists", "[apps][options]") {
  const auto [name, value] = parse_constant("touch_radius=0.02");
  CHECK(name == "touch_radius");
  CHECK((value == Constant(0.02)));
  CHECK_THROWS_AS(parse_constant("touch_radius"), Error);
}

TEST_CASE("Options of tasks have one number", "[apps][options]") {
  const TaskOptionValue option = parse_option("strict=1");
  CHECK(option.name == "strict");
  CHECK(option.value == 1);
  CHECK_THROWS_WITH(parse_option("strict"), Catch::Contains("NAME=NUMBER"));
}

TEST_CASE("Filters select tasks in the registry's order", "[apps][options]") {
  TaskFilter filter;
  CHECK_FALSE(filter.any());
  CHECK(select(filter).size() == registry().size());
  filter.family = "RememberColor";
  CHECK(filter.any());
  const auto tasks = select(filter);
  REQUIRE(tasks.size() == 9);  // of 3, 5 and 9 colours: short, long and RL tasks
  CHECK(tasks[0]->index < tasks[1]->index);
  filter.family = "NoSuchFamily";
  CHECK_THROWS_AS(select(filter), Error);
}

TEST_CASE("A renderer is named only where something is rendered", "[apps][options]") {
  MakeOptions options = batch_options(2, 1);
  CHECK(options.num_envs == 2);
  CHECK(renderer_name(options) == "none");
  options.obs_mode = ObsMode::kRgb;
  CHECK(renderer_name(options) == options.image_options.renderer);
}

}  // namespace
}  // namespace engram::apps
