// Several tasks in one batch, and outputs in the caller's arrays, through the plain C API.
#include <nlohmann/json.hpp>

#include "tests/api/c_api_fixture.h"

namespace engram {
namespace {

using Catch::Contains, test::actions_of, test::BatchHandle, test::default_options, test::output;

constexpr const char* kOther = "ShellGameTouch-VLA-v0";

BatchHandle make_two(const engram_options& options) {
  const engram_task_share tasks[] = {{test::kId, 2, nullptr, nullptr, 0, nullptr, 0},
                                     {kOther, 3, nullptr, nullptr, 0, nullptr, 0}};
  engram_env* env = nullptr;
  REQUIRE(engram_make_group(tasks, 2, &options, &env) == ENGRAM_OK);
  return BatchHandle(env);
}

TEST_CASE("A group of tasks through the C API equals its batches", "[c_api]") {
  engram_options options = default_options();
  options.obs_mode = ENGRAM_OBS_RGB;
  const BatchHandle group = make_two(options);
  REQUIRE(engram_num_envs(group.get()) == 5);
  REQUIRE(engram_reset(group.get(), nullptr) == ENGRAM_OK);
  options.num_envs = 3;
  const BatchHandle alone = test::make_batch(options, kOther);
  REQUIRE(engram_reset(alone.get(), nullptr) == ENGRAM_OK);
  for (int i = 0; i < 6; ++i) {
    const std::vector<float> all = actions_of(group, ENGRAM_POLICY_ORACLE);
    const std::vector<float> own = actions_of(alone, ENGRAM_POLICY_ORACLE);
    CHECK(std::equal(own.begin(), own.end(), all.begin() + 2 * 7));
    REQUIRE(engram_step(group.get(), all.data(), all.size()) == ENGRAM_OK);
    REQUIRE(engram_step(alone.get(), own.data(), own.size()) == ENGRAM_OK);
    for (const char* name : {"rgb", "proprio", "reward"}) {
      const engram_array here = output(group, name);
      const engram_array there = output(alone, name);
      const std::size_t row = test::size_of(there) / 3;
      CHECK(std::memcmp(static_cast<const std::byte*>(here.data) + 2 * row, there.data, 3 * row) ==
            0);
    }
  }
  const auto description = nlohmann::json::parse(engram_describe_json(group.get()));
  REQUIRE(description["tasks"].size() == 2);
  CHECK(description["tasks"][1]["id"] == kOther);
  CHECK(description["tasks"][1]["first_env"] == 2);
  CHECK(description["tasks"][1]["num_envs"] == 3);
  CHECK(engram_horizon(group.get()) == description["horizon"]);
  CHECK(engram_drawn_dim(group.get()) == 0);
  char text[200];
  REQUIRE(engram_instruction(group.get(), 4, text, sizeof text, nullptr) == ENGRAM_OK);
  CHECK(std::string(text) == description["tasks"][1]["instruction"]);
}

std::string words_of(const BatchHandle& batch, std::int32_t env) {
  std::size_t length = 0;
  REQUIRE(engram_words(batch.get(), env, nullptr, 0, &length) == ENGRAM_OK);
  std::string text(length, ' ');
  REQUIRE(engram_words(batch.get(), env, text.data(), length + 1, nullptr) == ENGRAM_OK);
  return text;
}

TEST_CASE("Words of a group are those of each environment's task", "[c_api][labels]") {
  engram_options options = default_options();
  const BatchHandle group = make_two(options);
  options.num_envs = 2;
  const BatchHandle first = test::make_running(options);
  options.num_envs = 3;
  const BatchHandle other = test::make_batch(options, kOther);
  REQUIRE(engram_reset(other.get(), nullptr) == ENGRAM_OK);
  REQUIRE(engram_reset(group.get(), nullptr) == ENGRAM_OK);
  for (int step = 0; step < 4; ++step) {
    for (std::int32_t env = 0; env < 2; ++env) CHECK(words_of(group, env) == words_of(first, env));
    for (std::int32_t env = 0; env < 3; ++env) {
      CHECK(words_of(group, 2 + env) == words_of(other, env));
    }
    CHECK_THAT(words_of(group, 1), Contains("the cue was a"));
    CHECK_THAT(words_of(group, 4), !Contains("the cue was a"));
    test::step_by(group, ENGRAM_POLICY_ZERO);
    test::step_by(first, ENGRAM_POLICY_ZERO);
    test::step_by(other, ENGRAM_POLICY_ZERO);
  }
}

TEST_CASE("Tasks of a group have constants and pins of their own", "[c_api]") {
  const double red = 1;
  const engram_pin pin = {"target", &red, 1};
  const engram_task_share tasks[] = {
      {"RememberColor9-VLA-v0", 1, R"({"COLORS": 7})", nullptr, 0, nullptr, 0},
      {test::kId, 1, nullptr, &pin, 1, nullptr, 0}};
  const engram_options options = default_options();
  engram_env* env = nullptr;
  REQUIRE(engram_make_group(tasks, 2, &options, &env) == ENGRAM_OK);
  const BatchHandle group(env);
  REQUIRE(engram_reset(env, nullptr) == ENGRAM_OK);
  const auto description = nlohmann::json::parse(engram_describe_json(env));
  CHECK(description["tasks"][0]["changed"]["COLORS"] == 7);
  CHECK(description["tasks"][1]["changed"].empty());
  CHECK(test::values<std::int32_t>(output(group, "oracle_info"))[1] == 1);
}

TEST_CASE("The C API refuses bad groups", "[c_api]") {
  const engram_options options = default_options();
  engram_env* env = nullptr;
  const auto refused = [&](engram_task_share task, engram_status status) {
    CHECK(engram_make_group(&task, 1, &options, &env) == status);
    CHECK(env == nullptr);
    return std::string(engram_last_error());
  };
  CHECK_THAT(
      refused({"RememberColour3-VLA-v0", 1, nullptr, nullptr, 0, nullptr, 0}, ENGRAM_UNKNOWN_ID),
      Contains("RememberColor3-VLA-v0"));
  CHECK_THAT(refused({test::kId, 0, nullptr, nullptr, 0, nullptr, 0}, ENGRAM_INVALID_ARGUMENT),
             Contains("number of environments of RememberColor3-VLA-v0: 0 given"));
  CHECK_THAT(refused({nullptr, 1, nullptr, nullptr, 0, nullptr, 0}, ENGRAM_INVALID_ARGUMENT),
             Contains("id of a task"));
  CHECK(engram_make_group(nullptr, 1, &options, &env) == ENGRAM_INVALID_ARGUMENT);
  const engram_task_share none{};
  CHECK(engram_make_group(&none, 0, &options, &env) == ENGRAM_INVALID_ARGUMENT);
}

TEST_CASE("Images are drawn into the caller's arrays, in turns", "[c_api]") {
  engram_options options = default_options(2);
  options.obs_mode = ENGRAM_OBS_RGB;
  options.image_width = options.image_height = 16;
  options.auto_reset = ENGRAM_AUTO_RESET_OFF;
  const BatchHandle batch = test::make_batch(options);
  const BatchHandle plain = test::make_batch(options);
  const std::size_t size = test::size_of(output(batch, "rgb"));
  const std::size_t turns = GENERATE(2, 5);
  std::vector<std::vector<std::uint8_t>> images(turns, std::vector<std::uint8_t>(size));
  std::vector<engram_output_target> targets;
  for (std::vector<std::uint8_t>& one : images) targets.push_back({"rgb", one.data(), size});
  REQUIRE(engram_write_outputs(batch.get(), targets.data(), turns, 1) == ENGRAM_OK);
  REQUIRE(engram_reset(batch.get(), nullptr) == ENGRAM_OK);
  REQUIRE(engram_reset(plain.get(), nullptr) == ENGRAM_OK);
  // Beyond the end of the episodes, where environments wait with their last image.
  for (int i = 0; i < 140; ++i) {
    const std::vector<float> actions = actions_of(plain, ENGRAM_POLICY_ORACLE);
    REQUIRE(engram_step_async(batch.get(), actions.data(), actions.size()) == ENGRAM_OK);
    REQUIRE(engram_step(plain.get(), actions.data(), actions.size()) == ENGRAM_OK);
    REQUIRE(engram_step_wait(batch.get()) == ENGRAM_OK);
    const int turn = engram_output_buffer(batch.get());
    REQUIRE(turn == (i + 1) % static_cast<int>(turns));
    const std::vector<std::uint8_t>& now = images[static_cast<std::size_t>(turn)];
    REQUIRE(output(batch, "rgb").data == now.data());
    REQUIRE(std::memcmp(now.data(), output(plain, "rgb").data, size) == 0);
  }
  CHECK(engram_write_outputs(batch.get(), targets.data(), 1, 1) == ENGRAM_BAD_STATE);
}

}  // namespace
}  // namespace engram
