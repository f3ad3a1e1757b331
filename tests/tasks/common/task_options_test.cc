#include "tasks/common/task_options.h"

#include <array>
#include <catch2/catch.hpp>

#include "core/batch/options.h"

namespace engram {
namespace {

TEST_CASE("Options are described in the order of their declaration", "[parts][options]") {
  std::vector<TaskOptionSpec> specs;
  tasks::TaskOptions list(specs);
  const tasks::TaskOption radius =
      list.add({"touch_radius", 0.05, false, 0.001, 0.2, "m", "how near"});
  const tasks::TaskOption strict = list.on_off("strict_order", "1: the order counts", true);
  REQUIRE(specs.size() == 2);
  CHECK(specs[1].name == "strict_order");
  CHECK(specs[1].integer);
  CHECK(specs[1].value_under(Rules::kReference) == 0);
  CHECK(specs[1].value_under(Rules::kOriginal) == 1);

  const std::array<double, 2> values = {0.07, 1};
  Bindings bindings;
  bindings.options = values;
  CHECK(radius.value(bindings) == 0.07);
  CHECK(strict.is_on(bindings));
}

}  // namespace
}  // namespace engram
