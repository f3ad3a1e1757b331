#include <catch2/catch.hpp>
#include <string>

#include "protocol/make/make.h"
#include "tests/apps/command.h"
#include "tests/sanitizers.h"

namespace engram::test {

TEST_CASE("doctor: versions, machine and memory", "[apps]") {
  const ParsedJson facts = engram_command("doctor --json").json();
  CHECK(facts["version"] == version());
  CHECK(facts["mujoco_runtime"] == facts["mujoco_compiled"]);
  CHECK(facts["threads"].get<int>() >= 1);
  CHECK(facts["bytes_per_env"].get<double>() > 0);
  // Sanitizers keep freed memory resident.
  if (!test::kSanitized) CHECK(facts["resident_bytes_per_env"].get<double>() > 0);
  CHECK(facts["egl"].get<std::string>().size() > 0);
  CHECK(facts["egl_available"].get<bool>() == (facts["egl_renderer"] != ""));
  CHECK(engram_command("doctor").code == 0);
}

}  // namespace engram::test
