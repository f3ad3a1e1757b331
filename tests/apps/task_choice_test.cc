#include "apps/task_choice.h"

#include <catch2/catch.hpp>

namespace engram::apps {
namespace {

TEST_CASE("Tasks are chosen by id, once each", "[apps]") {
  const auto tasks =
      chosen_tasks({"TakeItBack-VLA-v0", "RememberColor3-VLA-v0", "TakeItBack-VLA-v0"}, {}, false);
  REQUIRE(tasks.size() == 2);
  CHECK(tasks[0]->id == "TakeItBack-VLA-v0");
  CHECK(tasks[1]->id == "RememberColor3-VLA-v0");
}

TEST_CASE("Tasks are chosen by filters or all of them", "[apps]") {
  TaskFilter filter;
  CHECK(chosen_tasks({}, filter, true).size() == 97);
  filter.family = "RememberColor";
  CHECK(chosen_tasks({}, filter, false).size() == 6);
  filter.split = Split::kRl;
  CHECK(chosen_tasks({}, filter, false).size() == 3);
  filter.split = Split::kExtended;
  CHECK_THROWS_WITH(chosen_tasks({}, filter, false), Catch::Contains("no task"));
}

TEST_CASE("Tasks have to be chosen in one of the two ways", "[apps]") {
  CHECK_THROWS_WITH(chosen_tasks({}, {}, false), Catch::Contains("no task given"));
  CHECK_THROWS_WITH(chosen_tasks({"RememberColor3-VLA-v0"}, {}, true),
                    Catch::Contains("one or the other"));
  CHECK_THROWS_AS(chosen_tasks({"Nothing-VLA-v0"}, {}, false), Error);
}

}  // namespace
}  // namespace engram::apps
