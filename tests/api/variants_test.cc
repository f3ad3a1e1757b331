// Constants and ids of users' own through the public headers.
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "engram/engram.h"
#include "tests/api/c_api_fixture.h"

namespace {

using Catch::Matchers::Contains, engram::Error;

constexpr const char* kBase = "RememberColor9-VLA-v0";

TEST_CASE("Constants through the C++ header", "[cpp_api][variants]") {
  engram::VectorEnv env = engram::make(
      kBase, {.num_envs = 4, .constants = R"({"COLORS": 2, "max_episode_steps": 30})"});
  CHECK(env.horizon() == 30);
  CHECK_THAT(std::string(env.describe()), Contains("\"candidates\": 2"));
  const auto refused = [](const char* constants) {
    return [constants] { engram::make(kBase, {.constants = constants}); };
  };
  CHECK_THROWS_WITH(refused("{\"COLORS\": 12}")(), Contains("2 to 9 allowed"));
  CHECK_THROWS_WITH(refused("[1]")(), Contains("a JSON object"));
  CHECK_THROWS_WITH(refused("{\"COLORS\"")(), Contains("a JSON object"));
}

TEST_CASE("A horizon of the user's, through the C++ header", "[cpp_api][variants]") {
  // Even if it is too short to succeed, and whatever the constants say.
  for (const int steps : {1, 7, 25, 60}) {
    engram::VectorEnv env = engram::make(kBase, {.num_envs = 2,
                                                 .auto_reset = engram::AutoReset::kOff,
                                                 .constants = R"({"max_episode_steps": 40})",
                                                 .after_end = engram::AfterEnd::kContinue,
                                                 .max_episode_steps = steps});
    CHECK(env.horizon() == steps);
    const std::vector<float> zeros = env.make_actions();
    env.reset();
    for (int i = 1; i <= steps + 3; ++i) {
      env.step(zeros);
      CHECK(env.truncated()[1] == (i >= steps ? 1 : 0));
      CHECK(env.elapsed_steps()[1] == i);
    }
  }
  CHECK(engram::make(kBase).horizon() == 25);
}

TEST_CASE("Ids through the C++ header", "[cpp_api][variants]") {
  const std::size_t before = engram::task_ids().size();
  engram::register_variant(
      {.id = "Api-Color2-v0", .base = kBase, .constants = "{\"COLORS\": 2}", .instruction = "Go."});
  CHECK(engram::task_ids().size() == before + 1);
  CHECK(engram::task_ids().back() == "Api-Color2-v0");
  CHECK_THAT(std::string(engram::list()), Contains("Api-Color2-v0"));
  engram::VectorEnv env = engram::make("Api-Color2-v0");
  env.reset();
  CHECK(env.instruction(0) == "Go.");
  CHECK_THROWS_AS(engram::register_variant({.id = "Api", .base = kBase, .constants = {}}), Error);

  std::string folder = std::filesystem::temp_directory_path() / "engram-XXXXXX";
  REQUIRE(::mkdtemp(folder.data()) != nullptr);
  const std::string file = folder + "/variants.json";
  std::ofstream(file) << R"({"variants": [{"id": "Api-File-v0", "base": "Api-Color2-v0"}]})";
  engram::load_variants(file);
  CHECK(engram::make("Api-File-v0").horizon() == 25);
  CHECK_THROWS_WITH(engram::load_variants(file + "x"), Contains("cannot be read"));
  std::filesystem::remove_all(folder);
}

TEST_CASE("Ranges are narrowed through the C++ header", "[cpp_api][variants]") {
  engram::VectorEnv env = engram::make(
      kBase,
      {.num_envs = 4, .constants = R"({"EMPTY_PHASE_STEPS": [1, 60], "max_episode_steps": 100})"});
  env.reset({.constants = R"({"EMPTY_PHASE_STEPS": 3})"});
  CHECK_THROWS_WITH(env.reset({.constants = R"({"EMPTY_PHASE_STEPS": 61})"}),
                    Contains("from 1 to 60"));
  CHECK_THROWS_WITH(env.reset({.constants = "x"}), Contains("a JSON object"));
  env.reset({.constants = "{}"});
}

TEST_CASE("The plain C API refuses what it cannot take", "[c_api][variants]") {
  CHECK(engram_register_variant(nullptr, kBase, nullptr, nullptr) == ENGRAM_INVALID_ARGUMENT);
  CHECK(engram_register_variant("C-Api-v0", nullptr, nullptr, nullptr) == ENGRAM_INVALID_ARGUMENT);
  CHECK(engram_load_variants(nullptr) == ENGRAM_INVALID_ARGUMENT);
  CHECK(engram_register_variant("C-Api-v0", "Nothing-v0", nullptr, nullptr) == ENGRAM_UNKNOWN_ID);
  CHECK(engram_register_variant("C-Api-v0", kBase, "{\"COLOR\": 3}", nullptr) == ENGRAM_UNKNOWN_ID);
  CHECK(engram_register_variant("C-Api-v0", kBase, "{", nullptr) == ENGRAM_INVALID_ARGUMENT);
  CHECK(engram_register_variant("C-Api-v0", kBase, nullptr, nullptr) == ENGRAM_OK);
  CHECK(engram_register_variant("C-Api-v0", kBase, nullptr, nullptr) == ENGRAM_OK);
}

}  // namespace
