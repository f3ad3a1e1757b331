// Tasks out of a library, through the public headers.
#include <catch2/catch.hpp>
#include <string>

#include "engram/engram.h"
#include "tests/api/c_api_fixture.h"
#include "tests/build_paths.h"

namespace {

using Catch::Matchers::Contains;

const std::string kLibrary = std::string(engram::test::kTaskLibraries) + "/libtouch_spot.so";

TEST_CASE("A library's tasks through the C++ header", "[cpp_api][task_library]") {
  engram::load_tasks(kLibrary);
  CHECK_THAT(std::string(engram::list()), Contains("TouchSpot-VLA-v0"));
  engram::VectorEnv env = engram::make("TouchSpot-VLA-v0", {.num_envs = 8});
  std::vector<float> actions = env.make_actions();
  env.reset();
  for (int i = 0; i < env.horizon() - 1; ++i) {
    env.act(engram::Policy::kOracle, actions);
    env.step(actions);
  }
  for (const std::uint8_t success : env.success_once()) CHECK(success == 1);
  CHECK_THROWS_WITH(engram::load_tasks(kLibrary + "x"), Contains("cannot be read"));
}

TEST_CASE("The plain C API refuses what is no library of tasks", "[c_api][task_library]") {
  CHECK(engram_load_tasks(nullptr) == ENGRAM_INVALID_ARGUMENT);
  CHECK(engram_load_tasks("/nowhere/libtasks.so") == ENGRAM_IO);
  const std::string other = std::string(engram::test::kTaskLibraries) + "/libother_abi.so";
  CHECK(engram_load_tasks(other.c_str()) == ENGRAM_INVALID_ARGUMENT);
  CHECK_THAT(std::string(engram_last_error()), Contains("another ABI"));
  CHECK(engram_load_tasks(kLibrary.c_str()) == ENGRAM_OK);
}

}  // namespace
